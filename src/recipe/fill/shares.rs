//! What fills each image layer of a stack, read from its files.

use std::path::Path;

use super::super::paint::PhotoPaint;
use crate::document::Stack;
use crate::document::stack::{ImageLayer, LayerFill, StackFill, origins};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_grey, read_layer, read_mask};
use crate::io::stack_store::StackStore;
use crate::task::Task;

/// Hidden texels of one image layer, by what shows there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayerShares {
    /// Covered texels that the photo does not show.
    pub hidden: u64,
    /// Of these, painted by hand.
    pub painted: u64,
    /// Filled from other photos, painted over or not.
    pub from_photos: u64,
    /// Filled by example, painted over or not.
    pub by_example: u64,
    /// Filled by diffusion, painted over or not.
    pub diffused: u64,
    /// How far what was filled is trusted on average, 0 to 1; 0 where nothing was.
    pub confidence: f64,
}

/// For each image layer of the current stack of a photo in the project what shows at its hidden texels; empty without
/// a stack.
///
/// # Errors
/// When files of layers, filling or paint cannot be read; [`crate::Error::Cancelled`].
pub fn layer_shares(project: &Path, photo: &str, task: &Task) -> Result<Vec<LayerShares>> {
    let store = StackStore::new(project);
    let Some(stack) = store.current(photo)? else { return Ok(Vec::new()) };
    let folder = store.folder(photo);
    let paint = PhotoPaint::open(project, &stack)?;
    let count = stack.image_layers.len() as u64;
    let mut all = Vec::with_capacity(stack.image_layers.len());
    for (place, layer) in stack.image_layers.iter().enumerate() {
        task.step("look at fillings", place as u64, count)?;
        let mut shares =
            LayerShares { hidden: layer.texels_used - layer.texels_visible, ..LayerShares::default() };
        if let (Some(fill), Some(of_stack)) = (&layer.fill, &stack.fill) {
            count_origins(&mut shares, layer, fill, of_stack, &folder)?;
        }
        if paint.is_on(place) && shares.hidden > 0 {
            shares.painted = painted(&stack, &folder, &paint, place)?;
        }
        all.push(shares);
    }
    Ok(all)
}

fn count_origins(
    shares: &mut LayerShares,
    layer: &ImageLayer,
    fill: &LayerFill,
    of_stack: &StackFill,
    folder: &Path,
) -> Result<()> {
    let part = layer.needed_rect.intersection(&layer.rect);
    if fill.texels_filled == 0 || part.is_empty() {
        return Ok(());
    }
    let origin = read_grey(&folder.join(&fill.provenance_file), layer.rect, part)?;
    let confidence = read_grey(&folder.join(&fill.confidence_file), layer.rect, part)?;
    let mut trust = 0;
    for (origin, confidence) in origin.into_iter().zip(confidence) {
        match of_stack.origins.get(usize::from(origin)).map(String::as_str) {
            None | Some(origins::NONE) => continue,
            Some(origins::EXEMPLAR) => shares.by_example += 1,
            Some(origins::DIFFUSED) => shares.diffused += 1,
            Some(_) => shares.from_photos += 1,
        }
        trust += u64::from(confidence);
    }
    let filled = shares.by_example + shares.diffused + shares.from_photos;
    shares.confidence = trust as f64 / 255.0 / filled.max(1) as f64;
    Ok(())
}

/// Hidden texels of a layer with paint on them.
fn painted(stack: &Stack, folder: &Path, paint: &PhotoPaint, place: usize) -> Result<u64> {
    let layer = &stack.image_layers[place];
    let part = layer.needed_rect.intersection(&layer.rect);
    let texels = read_layer(&folder.join(&layer.file), layer.rect, part)?;
    let needed = read_mask(&folder.join(&layer.needed_file), layer.rect, part)?;
    let is_hidden = |x: i32, y: i32| {
        let texel = place_in(part, x, y)?;
        Some(needed[texel] != 0 && texels[4 * texel + 3] == 0)
    };
    let patch = paint.on(stack, place)?;
    Ok(patch.iter().filter(|(x, y, _)| is_hidden(*x, *y) == Some(true)).count() as u64)
}

fn place_in(rect: PixelRect, x: i32, y: i32) -> Option<usize> {
    let inside = x >= rect.x && y >= rect.y && x < rect.right() && y < rect.bottom();
    inside.then(|| (y - rect.y) as usize * rect.w as usize + (x - rect.x) as usize)
}
