//! The composition of a filling in shares.

use serde::Serialize;

use crate::document::Stack;

/// The shares of a stack's texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FillShares {
    /// The hidden share of the texels that elements cover, 0..=1.
    pub hidden: f64,
    /// The share of hidden texels filled from other photos, 0..=1.
    pub from_photos: f64,
    /// The share of hidden texels filled from paint of other photos, 0..=1.
    pub from_paint: f64,
    /// The share of hidden texels inpainted by patches (by example), 0..=1.
    pub by_example: f64,
    /// The share of hidden texels inpainted by diffusion, 0..=1.
    pub diffused: f64,
    /// The share of hidden texels that are not filled, 0..=1.
    pub empty: f64,
}

impl FillShares {
    /// Computes the shares of a stack, filled or not.
    pub fn from_stack(stack: &Stack) -> Self {
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
