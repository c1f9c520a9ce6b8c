//! Comparison of one image layer with its export.

use super::colours::lost_colours;
use super::compare::{Comparison, PlacedRaster, Profiles};
use super::gather::{Gathered, gathered};
use super::merged::{AbsentLayer, take_out};
use super::originals::ExportedPixels;
use super::question::LayerChange;
use super::recall::{CachedLayer, LayerCache, key_of_layers};
use super::report::{LayerImportReport, LayerState};
use super::scaled::{repainted, unscaled};
use super::shift::shift;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::{ExportRecord, ExportedLayer, HelperLayer, RecordedIndex};
use quadratura_document::paint::{PaintPatch, PaintedLayer};
use quadratura_files::hash::hash_bytes;
use quadratura_layered_files::image_turn::TURNS;
use quadratura_layered_files::{Depth, EditedLayer, ImageTurn, Raster, Rounding};

/// The data that all layers of a document share.
pub struct DocumentContext<'a> {
    /// The exported pixels.
    pub originals: ExportedPixels<'a>,
    /// The export.
    pub record: &'a ExportRecord,
    /// The bits per sample of the export.
    pub depth: Depth,
    /// How the image was mirrored or turned; the document is turned back.
    pub turn: Option<ImageTurn>,
    /// The position of the photo's top-left pixel on the canvas.
    pub offset: [i32; 2],
    /// The number of canvas pixels per photo pixel.
    pub scale: f64,
    /// The canvas, in photo pixels.
    pub canvas: PixelRect,
    /// The profiles; `None` where the document has the photo's profile.
    pub profiles: Option<Profiles>,
    /// Whether another profile was assigned to the document, whose colours are as they were.
    pub assigned: bool,
    /// How coarsely the document stores colours.
    pub rounding: Option<Rounding>,
    /// The image layers that are not in the document; they may have been merged into others.
    pub absent: Vec<AbsentLayer<'a>>,
    /// Whether layers have their names from the export, rather than file names.
    pub named: bool,
    /// Whether an unreadable layer is an error; otherwise it is left out.
    pub only_whole: bool,
    /// Whether paint is imported only where no photo shows the surface.
    pub only_unseen: bool,
    /// The layers as seen at earlier imports.
    pub recall: &'a LayerCache,
    /// The remaining properties of the document that influence what a layer shows, as a key for [`LayerCache`].
    pub conditions: String,
}

/// The paint of one image layer.
pub struct LayerPaint {
    /// The report for the user.
    pub report: LayerImportReport,
    /// All paint of the layer; `None` where it is the same as at the last import, or could not be determined.
    pub patch: Option<PaintPatch>,
    /// The layer's present state.
    pub seen: PaintedLayer,
    /// Paint on image layers that were merged into this one, by their indices in the record.
    pub of_absent: Vec<(RecordedIndex, PaintPatch)>,
    /// How it differs from the export.
    pub change: LayerChange,
    /// How the layer was mirrored or turned by itself.
    pub turned: Option<ImageTurn>,
    /// How it is stored, where that cannot have the exported colours.
    pub lost_colours: Option<&'static str>,
}

impl LayerPaint {
    fn new(report: LayerImportReport, patch: Option<PaintPatch>, seen: PaintedLayer) -> Self {
        let change = LayerChange::default();
        Self { report, patch, seen, of_absent: Vec::new(), change, turned: None, lost_colours: None }
    }
}

/// Makes the result for a layer that is left out; its paint in the project stays.
fn left_out(mut report: LayerImportReport, why: String) -> LayerPaint {
    report.state = LayerState::LeftOut;
    report.notes.push(why);
    LayerPaint::new(report, None, PaintedLayer::default())
}

/// The end of the hash of a layer of which only the paint is imported where no photo shows the surface.
const UNSEEN: &str = " unseen";

/// What to do about colours that were lost.
pub const TO_RGB: &str = "convert the image to RGB first: undo the conversion in the editor, because colours that are \
                          lost do not return with it, and save again";

/// The combined layers of one token.
struct CombinedLayers {
    sight: CachedLayer,
    /// The pixels with their rectangle in the photo; `None` where the hash was enough.
    pixels: Option<(Raster, PixelRect)>,
}

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
        let mut report = LayerImportReport::new(&layers[0].name, Some(&exported.id), LayerState::Unchanged);
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
        let mut shown = seen.sight.shown;
        if shown == exported.pixels {
            return Ok(LayerPaint::new(report, Some(PaintPatch::of_pixels(&[])), PaintedLayer::default()));
        }
        if self.only_unseen {
            // A part of the paint is another state of the layer than all of it.
            shown.push_str(UNSEEN);
        }
        if let Some(before) = before.filter(|before| before.shown == shown) {
            (report.painted, report.erased) = (before.painted, before.erased);
            report.state = if before.painted > 0 { LayerState::Painted } else { LayerState::Unchanged };
            return Ok(LayerPaint::new(report, None, before.clone()));
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
        if let Some(stored) = lost_colours(layers[0].colours, &base) {
            let lost = left_out(report, format!("its pixels are stored in {stored}; {TO_RGB}"));
            return Ok(LayerPaint { lost_colours: Some(stored), ..lost });
        }
        let base = PlacedRaster { rect: exported.baseline.rect, pixels: &base };
        let found = PlacedRaster { rect, pixels: &pixels };
        let mut patch = self.painted(base, found);
        let mut change = LayerChange::new(base, &patch);
        let mut turned = None;
        // Moved by a pixel, most of a plain surface is as it was.
        let place = exported.exported_rect;
        let is_elsewhere = (rect.w, rect.h) == (place.w, place.h) && rect != place;
        // The files of a folder are turned one by one; mirrored, most of a plain surface is as it was, too.
        let in_place = (!self.named && change.replaced > 0)
            .then(|| self.turned_in_place(base, place, found, &change))
            .flatten();
        if let Some((turn, turned_back)) = in_place {
            (turned, patch) = (Some(turn), turned_back);
            change = LayerChange::new(base, &patch);
        } else if (!change.is_in_place() || is_elsewhere) && self.scale == 1.0 {
            let by = |moved: [i32; 2], rect: PixelRect| PixelRect {
                x: rect.x - moved[0],
                y: rect.y - moved[1],
                ..rect
            };
            if let Some(moved) = shift(base.pixels, base.rect, &pixels, rect) {
                report.moved = Some(moved).filter(|moved| *moved != [0, 0]);
                patch = self.painted(base, PlacedRaster { rect: by(moved, rect), pixels: &pixels });
            } else if let Some((turn, pixels, moved)) = turned_layer(base, found) {
                turned = Some(turn);
                let rect = PixelRect { w: pixels.width(), h: pixels.height(), ..rect };
                patch = self.painted(base, PlacedRaster { rect: by(moved, rect), pixels: &pixels });
            } else if let Some((turn, turned_back)) = self.turned_in_place(base, place, found, &change) {
                (turned, patch) = (Some(turn), turned_back);
            }
            change = LayerChange::new(base, &patch);
        }
        if let Some(turn) = turned {
            (report.turned, report.resized) = (Some(turn.done), false);
        } else if !self.named && (rect.w, rect.h) != (place.w, place.h) {
            return Ok(left_out(report, not_turned(rect, place)));
        }
        let (patch, of_absent) =
            take_out(&self.absent, exported, base, patch, self.originals.kept, &mut report)?;
        (report.painted, report.erased) = (patch.count(), patch.erased());
        if report.painted > 0 {
            report.state = LayerState::Painted;
        }
        let seen = PaintedLayer { shown, painted: report.painted, erased: report.erased };
        let paint = LayerPaint::new(report, Some(patch), seen);
        Ok(LayerPaint { of_absent, change, turned, ..paint })
    }

    /// Returns true when the hash is that of the export or of the last import.
    fn is_known(&self, shown: &str, exported: &ExportedLayer, before: Option<&PaintedLayer>) -> bool {
        let unseen = if self.only_unseen { UNSEEN } else { "" };
        let is_before = |before: &PaintedLayer| before.shown.strip_suffix(unseen) == Some(shown);
        shown == exported.pixels || before.is_some_and(is_before)
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
    pub fn helper(&self, layer: &EditedLayer, helper: &HelperLayer) -> Result<Option<LayerImportReport>> {
        let shown = match self.hash_of_helper(layer, helper) {
            Err(problem @ (Error::Input { .. } | Error::Io { .. })) if !self.only_whole => {
                let report = LayerImportReport::new(&layer.name, None, LayerState::LeftOut);
                return Ok(Some(left_out(report, problem.to_string()).report));
            }
            shown => shown?,
        };
        Ok(shown.filter(|shown| *shown != helper.pixels).map(|_| {
            let mut report = LayerImportReport::new(&layer.name, None, LayerState::PaintedHelper);
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
            Comparison { base, found, canvas: self.canvas, profiles, rounding: self.rounding }.painted()
        } else {
            repainted(base, found, self.scale)
        }
    }

    /// Returns how a layer was mirrored or turned at its place, of which there are too few patterns to find it by them, and
    /// its paint once it is turned back: the turn with which most pixels are as they were, and clearly more than without.
    fn turned_in_place(
        &self,
        base: PlacedRaster,
        place: PixelRect,
        found: PlacedRaster,
        change: &LayerChange,
    ) -> Option<(ImageTurn, PaintPatch)> {
        let size = |rect: PixelRect| (rect.w, rect.h);
        let is_there = (found.rect.x, found.rect.y) == (place.x, place.y);
        let turns = TURNS.into_iter().filter(|turn| is_there && turn.size(size(found.rect)) == size(place));
        let turned = turns.map(|turn| {
            let patch = self.painted(base, PlacedRaster { rect: place, pixels: &turn.raster(found.pixels) });
            (LayerChange::new(base, &patch), turn, patch)
        });
        let (best, turn, patch) = turned.min_by_key(|(turned, ..)| turned.replaced)?;
        (best.is_in_place() && 2 * best.replaced < change.replaced).then_some((turn, patch))
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
}

/// Says why a file of a folder, which has a position only where its size is right, is left out.
fn not_turned(rect: PixelRect, place: PixelRect) -> String {
    format!(
        "it has {} x {} pixels, but its layer has {} x {}, and it is not that layer turned, so its position is unknown; \
         give it its size again, or use an older copy",
        rect.w, rect.h, place.w, place.h
    )
}

/// Returns how a layer was mirrored or turned, the layer turned back at the same corner, and by how much it is then moved.
fn turned_layer(base: PlacedRaster, found: PlacedRaster) -> Option<(ImageTurn, Raster, [i32; 2])> {
    TURNS.into_iter().find_map(|turn| {
        let pixels = turn.raster(found.pixels);
        let rect = PixelRect { w: pixels.width(), h: pixels.height(), ..found.rect };
        let moved = shift(base.pixels, base.rect, &pixels, rect)?;
        Some((turn, pixels, moved))
    })
}
