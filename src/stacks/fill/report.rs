//! The composition of a filling in shares.

use serde::Serialize;

use crate::layer_table::LayerFigures;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_document::{ImageLayer, Stack};

/// The shares of a stack's texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FillShares {
    /// The hidden share of the texels that faces cover, 0..=1, without that of backdrops.
    pub hidden: f64,
    /// The share of the texels that faces cover which is hidden and belongs to image layers of backdrops alone,
    /// 0..=1. Little of it is ever seen.
    pub hidden_of_backdrops: f64,
    /// The share of all hidden texels, with those of backdrops, filled from other photos, 0..=1.
    pub from_photos: f64,
    /// The share of hidden texels filled from paint of other photos, 0..=1.
    pub from_paint: f64,
    /// The share of hidden texels inpainted by patches (by example), 0..=1.
    pub by_example: f64,
    /// The share of hidden texels inpainted by diffusion, 0..=1.
    pub diffused: f64,
    /// The share of hidden texels that are not filled, 0..=1.
    pub empty: f64,
    /// The share of the needed texels of the surroundings which is hidden, 0..=1. All other shares leave the
    /// surroundings out. `None` where the photo has no layer of them.
    pub hidden_of_surroundings: Option<f64>,
    /// The share of the hidden texels of the surroundings which is filled, 0..=1; `None` as above.
    pub filled_of_surroundings: Option<f64>,
}

impl FillShares {
    /// Computes the shares of a stack, filled or not.
    pub fn from_stack(stack: &Stack) -> Self {
        let LayerFigures { used, hidden, .. } = figures(stack.layers_of_faces());
        let of_backdrops = hidden_of_backdrops(stack).min(hidden);
        let share = |texels: u64, of: u64| if of == 0 { 0.0 } else { texels as f64 / of as f64 };
        let fill = stack.fill.as_ref();
        let of_hidden = |texels: u64| share(texels, hidden);
        let [from_photos, from_paint, by_example, diffused] = fill.map_or([0; 4], |fill| {
            [fill.texels_from_photos, fill.texels_from_paint, fill.texels_by_example, fill.texels_diffused]
        });
        let filled = from_photos + from_paint + by_example + diffused;
        let layers = stack.image_layers.iter().filter(|layer| stack.is_of_surroundings(layer));
        let surroundings = stack.surroundings().map(|_| figures(layers));
        Self {
            hidden: share(hidden - of_backdrops, used),
            hidden_of_backdrops: share(of_backdrops, used),
            from_photos: of_hidden(from_photos),
            from_paint: of_hidden(from_paint),
            by_example: of_hidden(by_example),
            diffused: of_hidden(diffused),
            empty: of_hidden(hidden.saturating_sub(filled)),
            hidden_of_surroundings: surroundings.map(|all| share(all.hidden, all.used)),
            filled_of_surroundings: surroundings.map(|all| share(all.filled, all.hidden)),
        }
    }
}

/// Returns the sums over some image layers.
fn figures<'a>(layers: impl Iterator<Item = &'a ImageLayer>) -> LayerFigures {
    LayerFigures::sum(layers.map(LayerFigures::from_layer))
}

/// Returns the number of hidden texels in image layers that contain nothing but backdrops.
fn hidden_of_backdrops(stack: &Stack) -> u64 {
    let is_backdrop = |layer: &&ImageLayer| stack.shows_only(layer, says_backdrop);
    let layers = stack.image_layers.iter().filter(is_backdrop);
    layers.map(|layer| layer.texels_used - layer.texels_visible).sum()
}
