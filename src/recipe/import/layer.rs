//! Comparison of one image layer with its export.

use super::compare::{Comparison, PlacedRaster, Profiles};
use super::gather::{Gathered, gathered};
use super::merged::{AbsentLayer, take_out};
use super::originals::ExportedPixels;
use super::recall::{CachedLayer, LayerCache, key_of_layers};
use super::report::{LayerReport, LayerState};
use super::scaled::{repainted, unscaled};
use super::shift::shift;
use crate::document::export_record::{ExportRecord, ExportedLayer, HelperLayer, RecordedIndex};
use crate::document::paint::{PaintPatch, PaintedLayer};
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::hash::hash_bytes;
use crate::io::layered::{Depth, EditedLayer, Raster};

/// The data that all layers of a document share.
pub struct DocumentContext<'a> {
    /// The exported pixels.
    pub originals: ExportedPixels<'a>,
    /// The export.
    pub record: &'a ExportRecord,
    /// The bits per sample of the export.
    pub depth: Depth,
    /// The position of the photo's top-left pixel on the canvas.
    pub offset: [i32; 2],
    /// The number of canvas pixels per photo pixel.
    pub scale: f64,
    /// The canvas, in photo pixels.
    pub canvas: PixelRect,
    /// The profiles; `None` where the document has the photo's profile.
    pub profiles: Option<Profiles>,
    /// The image layers that are not in the document; they may have been merged into others.
    pub absent: Vec<AbsentLayer<'a>>,
    /// Whether layers have their names from the export, rather than file names.
    pub named: bool,
    /// Whether an unreadable layer is an error; otherwise it is left out.
    pub only_whole: bool,
    /// The layers as seen at earlier imports.
    pub recall: &'a LayerCache,
    /// The remaining properties of the document that influence what a layer shows, as a key for [`LayerCache`].
    pub conditions: String,
}

/// The paint of one image layer.
pub struct LayerPaint {
    /// The report for the user.
    pub report: LayerReport,
    /// All paint of the layer; `None` where it is the same as at the last import, or could not be determined.
    pub patch: Option<PaintPatch>,
    /// The layer's present state.
    pub seen: PaintedLayer,
    /// Paint on image layers that were merged into this one, by their indices in the record.
    pub of_absent: Vec<(RecordedIndex, PaintPatch)>,
}

/// Makes the result for a layer that is left out; its paint in the project stays.
fn left_out(mut report: LayerReport, why: String) -> LayerPaint {
    report.state = LayerState::LeftOut;
    report.notes.push(why);
    LayerPaint { report, patch: None, seen: PaintedLayer::default(), of_absent: Vec::new() }
}

/// The combined layers of one token.
struct CombinedLayers {
    sight: CachedLayer,
    /// The pixels with their rectangle in the photo; `None` where the hash was enough.
    pixels: Option<(Raster, PixelRect)>,
}

/// The share of a layer's pixels beyond which differences are no paint: the layer was probably moved.
const MOST_PAINTED: f64 = 0.6;

impl DocumentContext<'_> {
    /// Compares the layers with the token of `exported`; `before` is what they showed at the last import.
    ///
    /// # Errors
    /// Returns the errors of reading their pixels.
    pub fn layer(
        &self,
        exported: &ExportedLayer,
        layers: &[&EditedLayer],
        before: Option<&PaintedLayer>,
    ) -> Result<LayerPaint> {
        let mut report = LayerReport::new(&layers[0].name, Some(&exported.id), LayerState::Unchanged);
        report.renamed = self.named && layers.iter().all(|layer| layer.name != exported.name);
        let seen = match self.look(layers, |shown| self.is_known(shown, exported, before)) {
            Err(problem @ (Error::Input { .. } | Error::Io { .. })) if !self.only_whole => {
                return Ok(left_out(report, problem.to_string()));
            }
            seen => seen?,
        };
        report.notes = seen.sight.notes;
        let rect = seen.sight.rect;
        report.resized =
            self.scale == 1.0 && (rect.w, rect.h) != (exported.exported_rect.w, exported.exported_rect.h);
        let shown = seen.sight.shown;
        let done = |report, patch, seen| Ok(LayerPaint { report, patch, seen, of_absent: Vec::new() });
        if shown == exported.pixels {
            return done(report, Some(PaintPatch::of_pixels(&[])), PaintedLayer::default());
        }
        if let Some(before) = before.filter(|before| before.shown == shown) {
            (report.painted, report.erased) = (before.painted, before.erased);
            report.state = if before.painted > 0 { LayerState::Painted } else { LayerState::Unchanged };
            return done(report, None, before.clone());
        }
        let (pixels, rect) = seen.pixels.expect("what is not known was decoded");
        let Some(base) = self.originals.pixels(self.record, exported)? else {
            return Ok(left_out(
                report,
                "its pixels as exported are no longer kept (exports/pixels holds those of the last eight exports of each \
                 photo), and the stack has changed, so its paint cannot be identified; export again, and copy the layer over in the image editor"
                    .into(),
            ));
        };
        let base = PlacedRaster { rect: exported.baseline.rect, pixels: &base };
        let found = PlacedRaster { rect, pixels: &pixels };
        let mut patch = self.painted(base, found);
        if let Some(moved) = self.moved(base, found, &patch) {
            report.moved = Some(moved);
            let rect = PixelRect { x: rect.x - moved[0], y: rect.y - moved[1], ..rect };
            patch = self.painted(base, PlacedRaster { rect, pixels: &pixels });
        }
        let (patch, of_absent) =
            take_out(&self.absent, exported, base, patch, self.originals.kept, &mut report)?;
        (report.painted, report.erased) = (patch.count(), patch.erased());
        if report.painted > 0 {
            report.state = LayerState::Painted;
        }
        let seen = PaintedLayer { shown, painted: report.painted, erased: report.erased };
        Ok(LayerPaint { report, patch: Some(patch), seen, of_absent })
    }

    /// Returns true when the hash is that of the export or of the last import.
    fn is_known(&self, shown: &str, exported: &ExportedLayer, before: Option<&PaintedLayer>) -> bool {
        shown == exported.pixels || before.is_some_and(|before| before.shown == shown)
    }

    /// Combines the layers of one token. Layers that were seen at an earlier import are not decoded again when
    /// `enough` accepts the hash of what they show.
    fn look(&self, layers: &[&EditedLayer], enough: impl Fn(&str) -> bool) -> Result<CombinedLayers> {
        let code = key_of_layers(&self.conditions, layers)?;
        let before = code.as_deref().and_then(|code| self.recall.sight(code));
        if let Some(sight) = before.filter(|sight| enough(&sight.shown)) {
            return Ok(CombinedLayers { sight, pixels: None });
        }
        let Gathered { rect: found, pixels, notes } = gathered(layers)?;
        let (pixels, rect) = match self.scale == 1.0 {
            true => (pixels, self.in_photo(found)),
            false => unscaled(&pixels, found, self.scale),
        };
        let sight = CachedLayer { shown: self.hash(&pixels, rect), rect: found, notes };
        if let Some(code) = code {
            self.recall.keep(code, sight.clone());
        }
        Ok(CombinedLayers { sight, pixels: Some((pixels, rect)) })
    }

    /// Reports a helper layer, the photo or a guide, if it was painted on.
    ///
    /// # Errors
    /// Returns the errors of reading its pixels.
    pub fn helper(&self, layer: &EditedLayer, helper: &HelperLayer) -> Result<Option<LayerReport>> {
        let shown = match self.hash_of_helper(layer, helper) {
            Err(problem @ (Error::Input { .. } | Error::Io { .. })) if !self.only_whole => {
                let report = LayerReport::new(&layer.name, None, LayerState::LeftOut);
                return Ok(Some(left_out(report, problem.to_string()).report));
            }
            shown => shown?,
        };
        Ok(shown.filter(|shown| *shown != helper.pixels).map(|_| {
            let mut report = LayerReport::new(&layer.name, None, LayerState::PaintedHelper);
            report.notes.push(
                "it was painted on, but this paint is not imported; paint on a layer with a [token]".into(),
            );
            report
        }))
    }

    /// Returns the hash of a helper's stored pixels, without its opacity, at the place where it was exported: a helper
    /// that was only moved is not painted on. `None` where an editor with fewer bits has rounded them.
    fn hash_of_helper(&self, layer: &EditedLayer, helper: &HelperLayer) -> Result<Option<String>> {
        let code = layer.pixels.code()?;
        let code = code
            .map(|code| hash_bytes(format!("helper {} {:?} {code}", self.conditions, layer.rect).as_bytes()));
        if let Some(sight) = code.as_deref().and_then(|code| self.recall.sight(code)) {
            return Ok(Some(sight.shown));
        }
        let pixels = layer.pixels.read()?;
        let same_depth = pixels.depth() == self.depth;
        if !same_depth && self.depth != Depth::Eight {
            return Ok(None);
        }
        let pixels = if same_depth { pixels } else { pixels.in_depth(self.depth) };
        let same_size = (layer.rect.w, layer.rect.h) == (helper.rect.w, helper.rect.h);
        let place = if same_size { helper.rect } else { layer.rect };
        let shown = pixels.hash_at(place.x, place.y);
        if let Some(code) = code {
            self.recall.keep(code, CachedLayer { shown: shown.clone(), rect: layer.rect, notes: Vec::new() });
        }
        Ok(Some(shown))
    }

    /// Converts a rectangle of the canvas to photo pixels.
    pub fn in_photo(&self, rect: PixelRect) -> PixelRect {
        PixelRect { x: rect.x - self.offset[0], y: rect.y - self.offset[1], ..rect }
    }

    /// Returns the pixels that differ from the export.
    fn painted(&self, base: PlacedRaster, found: PlacedRaster) -> PaintPatch {
        if self.scale == 1.0 {
            let profiles = self.profiles.as_ref();
            Comparison { base, found, canvas: self.canvas, profiles }.painted()
        } else {
            repainted(base, found, self.scale)
        }
    }

    /// Returns the hash of pixels in the bit depth of the export, so that a file that was only converted counts as
    /// unchanged.
    fn hash(&self, pixels: &Raster, rect: PixelRect) -> String {
        let hash = match pixels.depth() == self.depth {
            true => pixels.hash_at(rect.x, rect.y),
            false => pixels.clone().in_depth(self.depth).hash_at(rect.x, rect.y),
        };
        // The same values in another profile, or at another scale, are other colours.
        let plain = self.profiles.is_none() && self.scale == 1.0;
        if plain { hash } else { hash_bytes(format!("{hash} converted {}", self.scale).as_bytes()) }
    }

    /// Returns by how much the layer was moved, if its pixels differ so much that this is likely.
    fn moved(&self, base: PlacedRaster, found: PlacedRaster, patch: &PaintPatch) -> Option<[i32; 2]> {
        let places = PixelRect::of_size(base.pixels.width(), base.pixels.height()).pixels();
        let opaque = places.filter(|&(x, y)| base.pixels.has_colour(x as u32, y as u32)).count();
        if opaque == 0 || (patch.count() as f64) < MOST_PAINTED * opaque as f64 || self.scale != 1.0 {
            return None;
        }
        shift(base.pixels, base.rect, found.pixels, found.rect).filter(|by| *by != [0, 0])
    }
}
