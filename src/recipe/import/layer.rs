//! One image layer that came back: what was painted on it.

use super::compare::{Comparison, Placed, Profiles};
use super::gather::{Gathered, gathered};
use super::merged::{Absent, take_out};
use super::report::{LayerReport, LayerState};
use super::scaled::{repainted, unscaled};
use super::shift::shift;
use crate::document::export_record::ExportedLayer;
use crate::document::paint::{PaintedLayer, Patch};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::baselines::Baselines;
use crate::io::hash::hash_bytes;
use crate::io::layered::{Depth, EditedLayer};

/// What all layers of a document share.
pub struct Desk<'a> {
    /// Pixels as they were exported.
    pub kept: &'a Baselines,
    /// Bits of a sample as exported.
    pub depth: Depth,
    /// Where the photo's top left pixel lies on the canvas.
    pub offset: [i32; 2],
    /// Pixels of the canvas per pixel of the photo.
    pub scale: f64,
    /// What the canvas shows, in photo pixels.
    pub canvas: PixelRect,
    /// None where the document has the photo's profile.
    pub profiles: Option<Profiles>,
    /// Image layers that are not in the document; they may have been merged into others.
    pub absent: Vec<Absent<'a>>,
}

/// The paint of one image layer.
pub struct LayerPaint {
    /// What the user is told.
    pub report: LayerReport,
    /// All of it; none where it is the same as at the last import, or could not be told.
    pub patch: Option<Patch>,
    /// What the layer shows now.
    pub seen: PaintedLayer,
    /// Paint on image layers that were merged into this one, by their places in the record.
    pub of_absent: Vec<(usize, Patch)>,
}

/// More of a layer than this cannot be other than it was, unless it lies somewhere else.
const MOST_PAINTED: f64 = 0.6;

impl Desk<'_> {
    /// What became of the layers with the token of `exported`; `before` is what they showed at the last import.
    ///
    /// # Errors
    /// What reading their pixels says.
    pub fn layer(
        &self,
        exported: &ExportedLayer,
        layers: &[&EditedLayer],
        before: Option<&PaintedLayer>,
    ) -> Result<LayerPaint> {
        let Gathered { rect, pixels, notes } = gathered(layers)?;
        let mut report = LayerReport::new(&layers[0].name, Some(&exported.id), LayerState::Unchanged);
        report.notes = notes;
        report.renamed = layers.iter().all(|layer| layer.name != exported.name);
        report.resized =
            self.scale == 1.0 && (rect.w, rect.h) != (exported.exported_rect.w, exported.exported_rect.h);
        let shown = if self.scale == 1.0 {
            (pixels, self.in_photo(rect))
        } else {
            unscaled(&pixels, rect, self.scale)
        };
        let (pixels, rect) = shown;
        let shown = self.hash(&pixels, rect);
        let done = |report, patch, seen| Ok(LayerPaint { report, patch, seen, of_absent: Vec::new() });
        if shown == exported.pixels {
            return done(report, Some(Patch::of_pixels(&[])), PaintedLayer::default());
        }
        if let Some(before) = before.filter(|before| before.shown == shown) {
            (report.painted, report.erased) = (before.painted, before.erased);
            report.state = if before.painted > 0 { LayerState::Painted } else { LayerState::Unchanged };
            return done(report, None, before.clone());
        }
        let Some(base) = self.kept.pixels(&exported.baseline)? else {
            report.state = LayerState::LeftOut;
            report
                .notes
                .push("its pixels as exported are no longer kept; export again and paint there".into());
            return done(report, None, PaintedLayer::default());
        };
        let base = Placed { rect: exported.baseline.rect, pixels: &base };
        let found = Placed { rect, pixels: &pixels };
        let mut patch = self.painted(base, found);
        if let Some(moved) = self.moved(base, found, &patch) {
            report.moved = Some(moved);
            let rect = PixelRect { x: rect.x - moved[0], y: rect.y - moved[1], ..rect };
            patch = self.painted(base, Placed { rect, pixels: &pixels });
        }
        let (patch, of_absent) = take_out(&self.absent, exported, base, patch, self.kept, &mut report)?;
        (report.painted, report.erased) = (patch.count(), patch.erased());
        if report.painted > 0 {
            report.state = LayerState::Painted;
        }
        let seen = PaintedLayer { shown, painted: report.painted, erased: report.erased };
        Ok(LayerPaint { report, patch: Some(patch), seen, of_absent })
    }

    /// A rectangle of the canvas in photo pixels.
    pub fn in_photo(&self, rect: PixelRect) -> PixelRect {
        PixelRect { x: rect.x - self.offset[0], y: rect.y - self.offset[1], ..rect }
    }

    fn painted(&self, base: Placed, found: Placed) -> Patch {
        if self.scale == 1.0 {
            let profiles = self.profiles.as_ref();
            Comparison { base, found, canvas: self.canvas, profiles }.painted()
        } else {
            repainted(base, found, self.scale)
        }
    }

    /// In the depth of the export, so that a file that was only converted is still the same.
    fn hash(&self, pixels: &crate::io::layered::Raster, rect: PixelRect) -> String {
        let hash = match pixels.depth() == self.depth {
            true => pixels.hash_at(rect.x, rect.y),
            false => pixels.clone().in_depth(self.depth).hash_at(rect.x, rect.y),
        };
        // The same numbers in another profile, or at another scale, are other colours.
        let plain = self.profiles.is_none() && self.scale == 1.0;
        if plain { hash } else { hash_bytes(format!("{hash} converted {}", self.scale).as_bytes()) }
    }

    fn moved(&self, base: Placed, found: Placed, patch: &Patch) -> Option<[i32; 2]> {
        let pixels = || (0..base.pixels.height()).flat_map(|y| (0..base.pixels.width()).map(move |x| (x, y)));
        let shown = pixels().filter(|&(x, y)| base.pixels.has_colour(x, y)).count();
        if shown == 0 || (patch.count() as f64) < MOST_PAINTED * shown as f64 || self.scale != 1.0 {
            return None;
        }
        shift(base.pixels, base.rect, found.pixels, found.rect).filter(|by| *by != [0, 0])
    }
}
