//! Detection of a mirrored or turned image, from its layers as they were exported.

use std::collections::BTreeMap;

use super::identify::SortedLayers;
use super::layer::LayerPaint;
use super::place::{PlacedLayer, placed_layers, scale_of};
use super::shift::shift;
use crate::import::originals::ExportedPixels;
use quadratura_base::error::Result;
use quadratura_document::export_record::ExportRecord;
use quadratura_layered_files::image_turn::TURNS;
use quadratura_layered_files::{EditedDocument, ImageTurn};

/// The number of layers that have to agree before the others are left alone.
const ENOUGH: usize = 3;
/// The number of pixels of a layer that are compared where colours have changed, too.
const COMPARED: u64 = 4096;
/// The share of the next best difference below which a turn is recognised by the likeness of its pixels.
const CLEARLY: f64 = 0.6;

/// Returns the turn of the whole image that the turned layers tell: most layers, and the same turn. One turned layer
/// among others was turned by itself.
pub fn turn_of_layers<'a>(layers: impl Iterator<Item = &'a LayerPaint>) -> Option<ImageTurn> {
    let mut votes: BTreeMap<Option<ImageTurn>, usize> = BTreeMap::new();
    for layer in layers.filter(|layer| layer.turned.is_some() || layer.change.is_in_place()) {
        *votes.entry(layer.turned).or_default() += 1;
    }
    let (turn, count) = votes.into_iter().max_by_key(|(_, count)| *count)?;
    turn.filter(|_| count > 1)
}

/// Returns how the whole image was turned: first by pixels that are as they were exported, then, where all have
/// changed because the image was scaled or recoloured, by the likeness of the pixels.
///
/// # Errors
/// Returns the errors of reading the exported pixels.
pub fn turn_of(
    document: &EditedDocument,
    record: &ExportRecord,
    sorted: &SortedLayers,
    originals: ExportedPixels,
) -> Result<Option<ImageTurn>> {
    let canvas = (document.width, document.height);
    let layers = placed_layers(record, sorted, originals)?;
    let mut votes = [0; TURNS.len()];
    for layer in &layers {
        if shift(&layer.base, layer.at, &layer.found, layer.found_at).is_some() {
            return Ok(None);
        }
        let is_turn = |turn: &ImageTurn| {
            shift(&layer.base, layer.at, &turn.raster(&layer.found), turn.rect(layer.found_at, canvas))
                .is_some()
        };
        if let Some(index) = TURNS.iter().position(is_turn) {
            votes[index] += 1;
        }
        if votes.iter().any(|count| *count >= ENOUGH) {
            break;
        }
    }
    let (best, count) = votes.iter().enumerate().max_by_key(|(_, count)| **count).expect("there are turns");
    if *count > 0 {
        return Ok(Some(TURNS[best]));
    }
    Ok(by_similarity(&layers, canvas, (record.photo.width, record.photo.height)))
}

/// Returns the turn with which the layers are clearly more alike than with any other, and than without one.
fn by_similarity(layers: &[PlacedLayer], canvas: (u32, u32), photo: (u32, u32)) -> Option<ImageTurn> {
    let difference = |turn: Option<ImageTurn>| {
        let scale = scale_of(turn.map_or(canvas, |turn| turn.size(canvas)), photo)?;
        let all: Vec<f64> = layers.iter().filter_map(|layer| layer.difference(turn, canvas, scale)).collect();
        (!all.is_empty()).then(|| (all.iter().sum::<f64>() / all.len() as f64, turn))
    };
    let mut all: Vec<_> =
        [None].into_iter().chain(TURNS.into_iter().map(Some)).filter_map(difference).collect();
    all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let [(best, turn), (next, _), ..] = all[..] else { return None };
    turn.filter(|_| best < CLEARLY * next)
}

impl PlacedLayer {
    /// Returns the mean difference, 0 to 1, between the layer as it was exported and as it is in the document, turned
    /// back; `None` where it has no pixels.
    fn difference(&self, turn: Option<ImageTurn>, canvas: (u32, u32), scale: f64) -> Option<f64> {
        let found = turn.map(|turn| turn.raster(&self.found));
        let found = found.as_ref().unwrap_or(&self.found);
        let at = turn.map_or(self.found_at, |turn| turn.rect(self.found_at, canvas));
        let step = (self.at.area() / COMPARED).max(1) as usize;
        let (mut sum, mut count) = (0.0, 0);
        for (x, y) in self.at.pixels().step_by(step) {
            let old = self.base.rgba16((x - self.at.x) as u32, (y - self.at.y) as u32);
            if old[3] == 0 {
                continue;
            }
            let on_canvas = |place: i32| ((f64::from(place) + 0.5) * scale).floor() as i32;
            let (u, v) = (on_canvas(x), on_canvas(y));
            let new = match at.contains(u, v) {
                true => found.rgba16((u - at.x) as u32, (v - at.y) as u32),
                false => [0; 4],
            };
            let apart: u32 = (0..3).map(|i| u32::from(old[i].abs_diff(new[i]))).sum();
            sum += if new[3] == 0 { 1.0 } else { f64::from(apart) / (3.0 * 65535.0) };
            count += 1;
        }
        (count > 0).then(|| sum / f64::from(count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_layered_files::{Depth, Raster};

    const PHOTO: (u32, u32) = (60, 40);

    /// A layer of soft waves at (10, 5), and what an editor made of it on its canvas.
    fn waves(edited: impl Fn(u32, u32) -> [u16; 4], size: (u32, u32), found_at: PixelRect) -> PlacedLayer {
        let mut base = Raster::blank(30, 20, Depth::Eight);
        PixelRect::of_size(30, 20)
            .pixels()
            .for_each(|(x, y)| base.set_rgba16(x as u32, y as u32, wave(x, y)));
        let mut found = Raster::blank(size.0, size.1, Depth::Eight);
        for (x, y) in PixelRect::of_size(size.0, size.1).pixels() {
            found.set_rgba16(x as u32, y as u32, edited(x as u32, y as u32));
        }
        PlacedLayer { base, at: PixelRect { x: 10, y: 5, w: 30, h: 20 }, found, found_at }
    }

    fn wave(x: i32, y: i32) -> [u16; 4] {
        [(x * 1900) as u16, (y * 2900) as u16, 20_000, 65535]
    }

    #[test]
    fn a_recoloured_image_that_was_mirrored_too_is_recognised_by_its_likeness() {
        let darker = |x: u32, y: u32| wave(29 - x as i32, y as i32).map(|value| value - value / 8);
        let mirrored = waves(darker, (30, 20), PixelRect { x: 60 - 40, y: 5, w: 30, h: 20 });
        assert_eq!(by_similarity(&[mirrored], PHOTO, PHOTO), Some(TURNS[0]));
        let only_darker = |x: u32, y: u32| wave(x as i32, y as i32).map(|value| value - value / 8);
        let straight = waves(only_darker, (30, 20), PixelRect { x: 10, y: 5, w: 30, h: 20 });
        assert_eq!(by_similarity(&[straight], PHOTO, PHOTO), None);
    }

    #[test]
    fn an_image_turned_and_scaled_to_half_is_recognised() {
        // Turned clockwise: 40 x 60, then 20 x 30.
        let half = |x: u32, y: u32| wave(2 * y as i32, 19 - 2 * x as i32);
        let at = PixelRect { x: (40 - 25) / 2, y: 5, w: 10, h: 15 };
        assert_eq!(by_similarity(&[waves(half, (10, 15), at)], (20, 30), PHOTO), Some(TURNS[3]));
    }
}
