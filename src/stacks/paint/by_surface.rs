//! The paint of a photo by surface, whatever image layers the surfaces are in.

use std::collections::{BTreeMap, BTreeSet};

use super::home::PaintMapping;
use super::parts::{LayerParts, camera_of};
use super::{PaintExtent, PhotoPaint, PlacedPaint, parts_of_layer};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_document::Stack;
use quadratura_document::paint::PaintPatch;
use quadratura_document::stack::{FilledPaint, SurfaceName};
use quadratura_files::hash::hash_bytes;

impl PhotoPaint {
    /// Returns the surfaces of the stack that have paint, sorted, without paint outside of all outlines.
    pub fn surfaces(&self, stack: &Stack) -> Vec<SurfaceName> {
        let mut names = Vec::new();
        self.each(stack, |parts, placed| {
            names.extend(name_of(parts, placed));
            Ok(())
        })
        .expect("nothing is read here");
        names.sort();
        names.dedup();
        names
    }

    /// Returns the paint on each surface, in photo pixels, later imports on top.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn by_surface(&self, stack: &Stack) -> Result<BTreeMap<SurfaceName, PaintPatch>> {
        let mut pieces: Vec<(SurfaceName, usize, PaintPatch)> = Vec::new();
        self.each(stack, |parts, placed| {
            let Some(name) = name_of(parts, placed) else { return Ok(()) };
            let mut patch = self.patch(placed.entry, stack)?;
            if placed.extent == PaintExtent::Covered {
                let covered = parts.covered(&parts.list[placed.part]);
                patch = patch.picked(|x, y, _| covered.holds(x, y));
            }
            pieces.push((name, placed.entry, patch));
            Ok(())
        })?;
        // Entries are numbered from the earliest import.
        pieces.sort_by(|a, b| (&a.0, a.1).cmp(&(&b.0, b.1)));
        let mut by_surface: BTreeMap<SurfaceName, PaintPatch> = BTreeMap::new();
        for (name, _, patch) in pieces {
            let below = by_surface.entry(name).or_insert_with(|| PaintPatch::of_pixels(&[]));
            *below = below.under(&patch);
        }
        by_surface.retain(|_, patch| !patch.is_empty());
        Ok(by_surface)
    }

    /// Returns the entries that lie on surfaces of the stack, with these surfaces, without paint outside of all
    /// outlines and on the surroundings.
    pub fn placed(&self, stack: &Stack) -> Vec<FilledPaint> {
        let mut surfaces: BTreeMap<usize, BTreeSet<SurfaceName>> = BTreeMap::new();
        self.each(stack, |parts, placed| {
            if let Some(name) = name_of(parts, placed) {
                surfaces.entry(placed.entry).or_default().insert(name);
            }
            Ok(())
        })
        .expect("nothing is read here");
        let placed = |(index, surfaces): (usize, BTreeSet<SurfaceName>)| {
            let entry = &self.entries[index];
            let text = serde_json::to_string(entry).expect("plain data is JSON");
            FilledPaint {
                photo: entry.photo.clone(),
                surfaces: surfaces.into_iter().collect(),
                rect: self.present_rect(index, stack),
                entry: hash_bytes(text.as_bytes()),
                only_here: false,
            }
        };
        surfaces.into_iter().map(placed).collect()
    }

    /// Returns the rectangle of an entry in pixels of the present photo: all of it where the camera has changed.
    fn present_rect(&self, index: usize, stack: &Stack) -> PixelRect {
        let (camera, pose) = camera_of(&stack.photo, &stack.camera);
        match PaintMapping::between(&self.entries[index], &self.views[index], camera, pose) {
            Some(_) => camera.rect(),
            None => self.entries[index].rect,
        }
    }

    /// Calls `see` for every entry on a part of a surface, image layer by image layer.
    fn each(
        &self,
        stack: &Stack,
        mut see: impl FnMut(&LayerParts<'_>, &PlacedPaint) -> Result<()>,
    ) -> Result<()> {
        let layers = stack.layer_indices().zip(&self.layers);
        for (layer, placed) in layers.filter(|(_, placed)| !placed.is_empty()) {
            let parts = parts_of_layer(stack, layer);
            for placed in placed.iter().filter(|placed| placed.extent != PaintExtent::Beyond) {
                see(&parts, placed)?;
            }
        }
        Ok(())
    }
}

/// Returns the name of the surface of an entry; `None` for the surroundings.
fn name_of(parts: &LayerParts, placed: &PlacedPaint) -> Option<SurfaceName> {
    let part = &parts.list[placed.part];
    Some(SurfaceName { object: part.object.to_owned(), face: part.face?, triangle: part.triangle })
}
