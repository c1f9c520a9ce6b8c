//! Layers that were merged into others in the editor: their pixels are not paint on the remaining layer.

use super::compare::PlacedRaster;
use super::report::LayerImportReport;
use quadratura_base::error::Result;
use quadratura_document::export_record::{ExportedLayer, RecordedIndex};
use quadratura_document::paint::PaintPatch;
use quadratura_io::baselines::Baselines;

/// An image layer that is not in the document.
#[derive(Debug, Clone, Copy)]
pub struct AbsentLayer<'a> {
    /// The index among the record's layers, which are nearest first.
    pub index: RecordedIndex,
    /// The layer as it was exported.
    pub layer: &'a ExportedLayer,
}

/// The share of a layer's pixels that has to be in the other layer, pixel by pixel, for the two to count as merged.
/// An artist who deletes a column and paints the wall behind it paints other pixels.
const MERGED_SHARE: f64 = 0.5;

/// Removes from `patch` the pixels of absent layers that were merged into `survivor`. Paint on such pixels of a
/// layer that was in front is that layer's paint, and is returned with the layer's index.
///
/// # Errors
/// Returns the errors of reading the exported pixels.
pub fn take_out(
    absent: &[AbsentLayer],
    survivor: &ExportedLayer,
    base: PlacedRaster,
    mut patch: PaintPatch,
    kept: &Baselines,
    report: &mut LayerImportReport,
) -> Result<(PaintPatch, Vec<(RecordedIndex, PaintPatch)>)> {
    let mut of_absent = Vec::new();
    for lost in absent {
        let rect = lost.layer.baseline.rect.intersection(&patch.rect());
        if rect.is_empty() {
            continue;
        }
        let Some(theirs) = kept.pixels(&lost.layer.baseline)? else { continue };
        let theirs = PlacedRaster { rect: lost.layer.baseline.rect, pixels: &theirs };
        // Where the remaining layer covered the absent one, it still does.
        let in_front = lost.layer.order < survivor.order;
        let showed = |x: i32, y: i32| theirs.at(x, y)[3] != 0 && (in_front || base.at(x, y)[3] == 0);
        let all = count(theirs, showed);
        let same = patch.iter().filter(|&(x, y, colour)| showed(x, y) && theirs.at(x, y) == colour).count();
        if all == 0 || (same as f64) < MERGED_SHARE * all as f64 {
            continue;
        }
        let name = &lost.layer.name;
        report.notes.push(format!(
            "\"{name}\" was merged into it; the content of that layer stays where it \
            was"
        ));
        let painted = patch.picked(|x, y, colour| in_front && showed(x, y) && theirs.at(x, y) != colour);
        patch = patch.picked(|x, y, colour| {
            let is_theirs = showed(x, y) && (in_front || theirs.at(x, y) == colour);
            !is_theirs
        });
        of_absent.push((lost.index, painted));
    }
    Ok((patch, of_absent))
}

/// Counts the pixels of a placed raster for which `wanted` is true.
fn count(placed: PlacedRaster, wanted: impl Fn(i32, i32) -> bool) -> usize {
    placed.rect.pixels().filter(|&(x, y)| wanted(x, y)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::report::LayerState;
    use quadratura_base::geometry::PixelRect;
    use quadratura_document::export_record::Baseline;
    use quadratura_document::paint::PaintColour;
    use quadratura_layered_files::{Depth, Raster};

    const RECT: PixelRect = PixelRect::of_size(10, 1);

    fn exported(id: &str, order: u32, file: String) -> ExportedLayer {
        ExportedLayer {
            id: id.into(),
            name: format!("{id} [{id}]"),
            order,
            rect: RECT,
            exported_rect: RECT,
            needed_rect: RECT,
            pixels: String::new(),
            baseline: Baseline { file, rect: RECT },
            elements: vec![],
        }
    }

    fn shade(value: u16) -> PaintColour {
        [257 * value, 257 * value, 257 * value, 65535]
    }

    /// The wall shows columns 6 to 9, the column before it 0 to 5; this is the wall in the edited file.
    fn taken(found: impl Fn(i32) -> Option<PaintColour>) -> (Vec<i32>, Vec<(usize, u64)>, LayerImportReport) {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let mut column = Raster::blank(10, 1, Depth::Eight);
        (0..6).for_each(|x| column.set_rgba16(x, 0, shade(10 + x as u16)));
        let mut wall = Raster::blank(10, 1, Depth::Eight);
        (6..10).for_each(|x| wall.set_rgba16(x, 0, shade(200)));
        let column = exported("column", 0, kept.store_pixels(&column).unwrap());
        let absent = [AbsentLayer { index: RecordedIndex(4), layer: &column }];
        let pixels: Vec<_> = (0..10).filter_map(|x| Some((x, 0, found(x)?))).collect();
        let mut report = LayerImportReport::new("wall", None, LayerState::Painted);
        let base = PlacedRaster { rect: RECT, pixels: &wall };
        let survivor = exported("wall", 1, String::new());
        let (patch, rest) =
            take_out(&absent, &survivor, base, PaintPatch::of_pixels(&pixels), &kept, &mut report).unwrap();
        let columns = patch.iter().map(|(x, ..)| x).collect();
        (columns, rest.iter().map(|(index, patch)| (index.0, patch.count())).collect(), report)
    }

    #[test]
    fn a_layer_merged_down_is_no_paint_and_what_was_painted_on_it_is_its_own() {
        let merged = |x: i32| match x {
            2 => Some(shade(99)),
            7 => Some(shade(77)),
            0..=5 => Some(shade(10 + x as u16)),
            _ => None,
        };
        let (patch, rest, report) = taken(merged);
        assert_eq!((patch, rest), (vec![7], vec![(4, 1)]));
        assert!(report.notes[0].contains("merged"), "{:?}", report.notes);
    }

    #[test]
    fn paint_where_a_deleted_layer_was_is_paint() {
        let (patch, rest, report) = taken(|x| (x < 6).then(|| shade(if x == 3 { 13 } else { 120 })));
        assert_eq!((patch, rest), ((0..6).collect(), vec![]));
        assert!(report.notes.is_empty());
    }
}
