//! The composition of each image layer's filling, read from its files.

use std::path::Path;

use crate::paint::PhotoPaint;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::stack::{ImageLayer, LayerFill, StackFill, origins};
use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
use quadratura_io::stack_store::StackStore;
use quadratura_layers::LayerIndex;

/// The numbers of hidden texels of an image layer by source.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayerShares {
    /// The number of covered texels that the photo does not show.
    pub hidden: u64,
    /// The number of hidden texels with the photo's own paint.
    pub painted: u64,
    /// The number of hidden texels filled from other photos, painted over or not.
    pub from_photos: u64,
    /// The number of hidden texels filled from paint of other photos, painted over or not.
    pub from_paint: u64,
    /// The number of hidden texels inpainted by patches (by example), painted over or not.
    pub by_example: u64,
    /// The number of hidden texels inpainted by diffusion, painted over or not.
    pub diffused: u64,
    /// The mean confidence of the filling, 0..=1; 0 where there is none.
    pub confidence: f64,
    /// The number of visible texels to which paint of another photo was propagated.
    pub propagated: u64,
}

impl LayerShares {
    /// Returns the number of hidden texels that are filled.
    pub fn filled(&self) -> u64 {
        self.from_photos + self.from_paint + self.by_example + self.diffused
    }
}

/// Counts the hidden texels of each image layer in the current stack of a photo; empty without a stack.
///
/// # Errors
/// Returns an error when files of layers, filling or paint cannot be read, or [`quadratura_base::Error::Cancelled`].
pub fn layer_shares(project: &Path, photo: &str, task: &Task) -> Result<Vec<LayerShares>> {
    let store = StackStore::new(project);
    let Some(stack) = store.current(photo)? else { return Ok(Vec::new()) };
    let folder = store.folder(photo);
    let paint = PhotoPaint::open(project, &stack)?;
    let count = stack.image_layers.len() as u64;
    let mut all = Vec::with_capacity(stack.image_layers.len());
    for (index, layer) in stack.numbered_layers() {
        task.step("check fillings", index.0.into(), count)?;
        let mut shares =
            LayerShares { hidden: layer.texels_used - layer.texels_visible, ..LayerShares::default() };
        if let (Some(fill), Some(of_stack)) = (&layer.fill, &stack.fill) {
            count_origins(&mut shares, layer, fill, of_stack, photo, &folder)?;
        }
        if paint.is_on(index) && shares.hidden > 0 {
            shares.painted = painted(&stack, &folder, &paint, index)?;
        }
        all.push(shares);
    }
    Ok(all)
}

/// Counts the sources of a layer's texels.
fn count_origins(
    shares: &mut LayerShares,
    layer: &ImageLayer,
    fill: &LayerFill,
    of_stack: &StackFill,
    photo: &str,
    folder: &Path,
) -> Result<()> {
    let part = layer.needed_rect.intersection(&layer.rect);
    if part.is_empty() || (fill.texels_filled == 0 && fill.propagation_file.is_none()) {
        return Ok(());
    }
    let origin = read_grey(&folder.join(&fill.provenance_file), layer.rect, part)?;
    let confidence = read_grey(&folder.join(&fill.confidence_file), layer.rect, part)?;
    let propagated = fill.propagation_file.as_ref();
    let propagated = propagated.map(|file| read_layer(&folder.join(file), layer.rect, part)).transpose()?;
    let is_propagated = |at: usize| propagated.as_ref().is_some_and(|texels| texels[4 * at + 3] > 0);
    let mut trust = 0;
    for (at, (origin, confidence)) in origin.into_iter().zip(confidence).enumerate() {
        // Visible texels are not hidden, whatever was propagated to them.
        if is_propagated(at) {
            shares.propagated += 1;
            continue;
        }
        match of_stack.origins.get(usize::from(origin)).map(String::as_str) {
            None | Some(origins::NONE) => continue,
            Some(origins::EXEMPLAR) => shares.by_example += 1,
            Some(origins::DIFFUSED) => shares.diffused += 1,
            Some(name) if origins::painter(name).is_some() => shares.from_paint += 1,
            // The photo shows them through see-through surfaces.
            Some(name) if name == photo => {
                shares.hidden -= 1;
                continue;
            }
            Some(_) => shares.from_photos += 1,
        }
        trust += u64::from(confidence);
    }
    shares.confidence = trust as f64 / 255.0 / shares.filled().max(1) as f64;
    Ok(())
}

/// Returns the number of hidden texels of a layer that have paint.
fn painted(stack: &Stack, folder: &Path, paint: &PhotoPaint, index: LayerIndex) -> Result<u64> {
    let layer = stack.layer(index);
    let part = layer.needed_rect.intersection(&layer.rect);
    let texels = read_layer(&folder.join(&layer.file), layer.rect, part)?;
    let needed = read_mask(&folder.join(&layer.needed_file), layer.rect, part)?;
    let is_hidden = |x: i32, y: i32| {
        let texel = part.index(x, y)?;
        Some(needed[texel] != 0 && texels[4 * texel + 3] == 0)
    };
    let patch = paint.on(stack, index)?;
    Ok(patch.iter().filter(|(x, y, _)| is_hidden(*x, *y) == Some(true)).count() as u64)
}
