//! The exported pixels of image layers: stored ones, or recomputed from the stack if it is still the same.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::{ExportRecord, ExportedLayer};
use quadratura_document::paint::PaintBook;
use quadratura_io::baselines::Baselines;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_stacks::layer_pixels::{layer_pixels, unfilled_pixels};
use quadratura_stacks::paint::PhotoPaint;

/// The sources of a project's exported pixels.
#[derive(Debug, Clone, Copy)]
pub struct ExportedPixels<'a> {
    /// The stored pixels.
    pub kept: &'a Baselines,
    /// The project's folder.
    pub project: &'a Path,
    /// The project's paint.
    pub book: &'a PaintBook,
}

impl ExportedPixels<'_> {
    /// Returns the pixels of a layer of `record`, as large as its baseline; `None` when they are no longer stored,
    /// and the present stack with the paint of that time gives other pixels.
    ///
    /// # Errors
    /// Returns the errors of reading stored pixels.
    pub fn pixels(&self, record: &ExportRecord, layer: &ExportedLayer) -> Result<Option<Raster>> {
        let kept = self.kept.pixels(&layer.baseline)?;
        Ok(kept.or_else(|| self.made_again(record, layer)))
    }

    /// Recomputes the pixels. Only a result with the hash of the export is used, so errors are simply ignored.
    fn made_again(&self, record: &ExportRecord, exported: &ExportedLayer) -> Option<Raster> {
        let store = StackStore::new(self.project);
        let stack = store.current(&record.photo.name).ok()??;
        let index = stack.layer_with_token(&exported.id)?;
        let rect = stack.layer(index).rect;
        let paint = PhotoPaint::new(&self.book_of(record), PaintStore::new(self.project), &stack);
        let folder = store.folder(&record.photo.name);
        [layer_pixels, unfilled_pixels].into_iter().find_map(|pixels| {
            let raster = pixels(&stack, &folder, &paint, index).ok()?;
            let at = exported.exported_rect;
            let exported_part = raster.clone().cropped(within(rect, at)?);
            let is_same = exported_part.hash_at(at.x, at.y) == exported.pixels;
            is_same.then(|| Some(raster.cropped(within(rect, exported.baseline.rect)?))).flatten()
        })
    }

    /// Returns the paint that the export showed, as far as it is still known.
    fn book_of(&self, record: &ExportRecord) -> PaintBook {
        let replaced = self.book.imports.iter().flat_map(|import| &import.replaced);
        let mut entries: Vec<_> = self.book.entries.iter().chain(replaced).cloned().collect();
        entries.retain(|entry| record.paint.contains(&entry.file));
        let mut book = PaintBook { entries, views: self.book.views.clone(), ..PaintBook::default() };
        book.tidy();
        book
    }
}

/// Returns `part` relative to the corner of `whole`; `None` where it extends beyond.
fn within(whole: PixelRect, part: PixelRect) -> Option<PixelRect> {
    let inside = whole.intersection(&part) == part;
    inside.then(|| PixelRect { x: part.x - whole.x, y: part.y - whole.y, ..part })
}
