//! Paint over real pixels: at places of a surface that this photo does not show, and other photos do.

use std::path::Path;

use super::context::ReadContext;
use super::report::LayerImportReport;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::{ExportRecord, ExportedLayer};
use quadratura_document::paint::PaintPatch;
use quadratura_document::stack::origins;
use quadratura_io::layer_reader::{read_grey, read_layer};
use quadratura_io::stack_store::StackStore;

/// Who shows the surface at a pixel of an image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownBy {
    /// This photo.
    Here,
    /// Other photos, and not this one.
    Elsewhere,
    /// No photo, as far as is known.
    Nowhere,
}

/// Who shows an image layer's surfaces, in a rectangle of the photo.
#[derive(Debug)]
pub struct RealPixels {
    rect: PixelRect,
    shown_by: Vec<ShownBy>,
}

impl RealPixels {
    /// Reads who shows the surfaces of an exported layer within `rect`, from the filling of the photo's present stack;
    /// `None` where there is none, or the layer is not in it.
    ///
    /// # Errors
    /// Returns the errors of reading the stack's files.
    pub fn read(
        project: &Path,
        record: &ExportRecord,
        exported: &ExportedLayer,
        rect: PixelRect,
    ) -> Result<Option<Self>> {
        let (store, photo) = (StackStore::new(project), &record.photo.name);
        let Some(stack) = store.current(photo)? else { return Ok(None) };
        let Some(layer) = stack.layer_with_token(&exported.id).map(|index| stack.layer(index)) else {
            return Ok(None);
        };
        let Some((fill, of_layer)) = stack.fill.as_ref().zip(layer.fill.as_ref()) else { return Ok(None) };
        let rect = layer.rect.intersection(&rect);
        if rect.is_empty() {
            return Ok(Some(Self { rect, shown_by: Vec::new() }));
        }
        let folder = store.folder(photo);
        let texels = read_layer(&folder.join(&layer.file), layer.rect, rect)?;
        let sources = read_grey(&folder.join(&of_layer.provenance_file), layer.rect, rect)?;
        let origin =
            |source: u16| fill.origins.get(usize::from(source)).map_or(origins::NONE, String::as_str);
        let shown = texels.as_chunks::<4>().0.iter().zip(sources).map(|(texel, source)| {
            // A photo may be the source of its own texels, which it shows through see-through surfaces.
            let origin = origin(source);
            match texel[3] > 0 || origin == photo {
                true => ShownBy::Here,
                false if !origin.starts_with('[') => ShownBy::Elsewhere,
                false => ShownBy::Nowhere,
            }
        });
        Ok(Some(Self { rect, shown_by: shown.collect() }))
    }

    /// Returns who shows a pixel.
    pub fn at(&self, x: i32, y: i32) -> ShownBy {
        self.rect.index(x, y).map_or(ShownBy::Nowhere, |index| self.shown_by[index])
    }

    /// Returns the number of painted pixels that other photos show and this one does not.
    pub fn replaced(&self, paint: &PaintPatch) -> u64 {
        paint.iter().filter(|(x, y, _)| self.at(*x, *y) == ShownBy::Elsewhere).count() as u64
    }

    /// Returns the paint where no photo shows the surface.
    pub fn unseen(&self, paint: &PaintPatch) -> PaintPatch {
        paint.picked(|x, y, _| self.at(x, y) == ShownBy::Nowhere)
    }
}

/// Counts the pixels of a layer's paint that replace what other photos show, and returns the paint: without those, and
/// those that this photo shows, where the options say so.
pub fn real_paint(
    file: &Path,
    record: &ExportRecord,
    exported: &ExportedLayer,
    patch: PaintPatch,
    reading: ReadContext,
    report: &mut LayerImportReport,
) -> Result<PaintPatch> {
    let real = RealPixels::read(reading.originals.project, record, exported, patch.rect())?;
    report.over_photos = real.as_ref().map(|real| real.replaced(&patch));
    if !reading.options.only_unseen {
        return Ok(patch);
    }
    let Some(real) = real else {
        let found =
            format!("\"{}\" has no filling, which would say where other photos show it", exported.name);
        return Err(Error::input(
            file,
            "",
            found,
            ("run ", Remedy::Fill, " first, or import without --only-unseen"),
        ));
    };
    let unseen = real.unseen(&patch);
    if unseen != patch {
        let left_out = patch.count() - unseen.count();
        report
            .notes
            .push(format!("{left_out} painted pixels are left out, because photos show the surface there"));
    }
    (report.painted, report.erased) = (unseen.count(), unseen.erased());
    Ok(unseen)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_is_kept_where_no_photo_shows_the_surface() {
        let rect = PixelRect { x: 5, y: 0, w: 3, h: 1 };
        let real = RealPixels { rect, shown_by: vec![ShownBy::Here, ShownBy::Elsewhere, ShownBy::Nowhere] };
        let paint = PaintPatch::of_pixels(&[4, 5, 6, 7].map(|x| (x, 0, [9, 9, 9, 65535])));
        assert_eq!(real.replaced(&paint), 1);
        let columns: Vec<i32> = real.unseen(&paint).iter().map(|(x, ..)| x).collect();
        assert_eq!(columns, [4, 7], "past the layer is nothing that a photo shows");
    }
}
