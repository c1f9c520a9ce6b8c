//! The image layers of a stack that can be merged with each other.

use rayon::prelude::*;
use serde::Serialize;

use super::checks::MergeJudge;
use super::cost::MergeCost;
use quadratura_base::scene::Model;
use quadratura_document::{PhotoDecisions, Stack};
use quadratura_layers::{LayerIndex, Options};

/// An image layer and those with which it can share one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MergeableLayer {
    /// The layer's token.
    pub token: String,
    /// The layer's name.
    pub name: String,
    /// The layer's depth, 1 nearest.
    pub depth: u32,
    /// The layers that can be merged with it, those first that cost the fewest texels.
    pub with: Vec<MergePartner>,
}

/// An image layer with which another can be merged, and what that costs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MergePartner {
    /// The layer's token.
    pub token: String,
    /// The layer's name.
    pub name: String,
    /// The number of texels of the rectangle around both.
    pub texels: u64,
    /// The number of texels of their separate rectangles.
    pub before: u64,
    /// Whether the rectangle around both would be mostly empty.
    pub mostly_empty: bool,
}

/// Returns the image layers of a stack in its order, without the surroundings, each with those that it can be merged
/// with, beside the decided merges and splits. `options` are the photo's.
pub fn mergeable(
    decided: &PhotoDecisions,
    stack: &Stack,
    model: &Model,
    options: &Options,
) -> Vec<MergeableLayer> {
    let judge = MergeJudge::new(decided, stack, model);
    let of_faces = stack.numbered_layers().filter(|(_, layer)| !stack.is_of_surroundings(layer));
    let layers: Vec<LayerIndex> = of_faces.map(|(index, _)| index).collect();
    let partner = |a: LayerIndex, b: LayerIndex| {
        let cost = MergeCost::new(stack, &[a, b], options).filter(|cost| !cost.is_too_large())?;
        let elements = [a, b].into_iter().flat_map(|layer| &stack.layer(layer).elements);
        let elements: Vec<u32> = elements.map(|element| element.0).collect();
        judge.allows(&elements).then(|| MergePartner {
            token: stack.layer(b).id.clone(),
            name: stack.layer(b).name.clone(),
            texels: cost.texels,
            before: cost.before,
            mostly_empty: cost.is_high(),
        })
    };
    let of_layer = |a: &LayerIndex| {
        let others = layers.iter().filter(|b| *b != a);
        let mut with: Vec<MergePartner> = others.filter_map(|b| partner(*a, *b)).collect();
        with.sort_by_key(|partner| partner.texels as i64 - partner.before as i64);
        let layer = stack.layer(*a);
        MergeableLayer { token: layer.id.clone(), name: layer.name.clone(), depth: layer.order + 1, with }
    };
    layers.par_iter().map(of_layer).collect()
}
