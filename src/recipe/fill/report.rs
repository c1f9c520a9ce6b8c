//! What filling did, in shares.

use serde::Serialize;

use crate::document::Stack;

/// Shares of a stack's texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FillShares {
    /// Hidden, of the texels that some element covers.
    pub hidden: f64,
    /// Of the hidden ones: given by other photos.
    pub from_photos: f64,
    /// Given by paint of other photos.
    pub from_paint: f64,
    /// Made by example.
    pub by_example: f64,
    /// Made by diffusion.
    pub diffused: f64,
    /// Not filled.
    pub empty: f64,
}

impl FillShares {
    /// Of a stack, filled or not.
    pub fn of(stack: &Stack) -> Self {
        let visible: u64 = stack.image_layers.iter().map(|layer| layer.texels_visible).sum();
        let hidden = stack.texels_used.saturating_sub(visible);
        let share = |texels: u64, of: u64| if of == 0 { 0.0 } else { texels as f64 / of as f64 };
        let fill = stack.fill.as_ref();
        let of_hidden = |texels: u64| share(texels, hidden);
        let [from_photos, from_paint, by_example, diffused] = fill.map_or([0; 4], |fill| {
            [fill.texels_from_photos, fill.texels_from_paint, fill.texels_by_example, fill.texels_diffused]
        });
        let filled = from_photos + from_paint + by_example + diffused;
        Self {
            hidden: share(hidden, stack.texels_used),
            from_photos: of_hidden(from_photos),
            from_paint: of_hidden(from_paint),
            by_example: of_hidden(by_example),
            diffused: of_hidden(diffused),
            empty: of_hidden(hidden.saturating_sub(filled)),
        }
    }
}
