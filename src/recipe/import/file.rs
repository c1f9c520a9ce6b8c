//! Import of one edited file: its layers are identified, located, and compared with what was exported.

use std::path::Path;

use rayon::prelude::*;

use super::compare::Profiles;
use super::gather::gathered;
use super::identify::{SortedLayers, foreign, record_of, refuse_foreign, sorted};
use super::layer::{DocumentContext, LayerPaint};
use super::mask::{FileMask, mask_of};
use super::merged::AbsentLayer;
use super::originals::ExportedPixels;
use super::place::{CanvasPlacement, place};
use super::report::{FileReport, LayerReport, LayerState};
use super::settle::SurfacePaint;
use super::share::by_surface;
use super::{ImportOptions, LayerCache};
use crate::document::Element;
use crate::document::export_record::{ExportFormat, ExportRecord, ExportedLayer, RecordedIndex};
use crate::document::paint::{PaintPatch, PaintedDocument, PaintedLayer};
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::baselines::Baselines;
use crate::io::colour::Conversion;
use crate::io::hash::hash_bytes;
use crate::io::layered::read_layered;
use crate::io::layered::{Depth, EditedDocument, EditedLayer};
use crate::recipe::paint::parts::{LayerParts, PartSource};
use crate::task::Task;

/// The contents of an edited file to be imported.
pub struct FilePaint<'a> {
    /// The export from which the file comes.
    pub record: &'a ExportRecord,
    /// The report for the user.
    pub report: FileReport,
    /// The image layers in the file.
    pub layers: Vec<ImportedLayerPaint>,
    /// The pixels that its layers called `mask` cover.
    pub mask: Option<FileMask>,
}

/// The paint of one image layer, by surface.
pub struct ImportedLayerPaint {
    /// The token of the image layer.
    pub token: String,
    /// The index among the report's layers, if it is reported there.
    pub report: Option<usize>,
    /// All paint of the layer; `None` where the project's paint stays as it is.
    pub surfaces: Option<Vec<SurfacePaint>>,
    /// The layer's present state; `None` where that is unknown.
    pub seen: Option<PaintedLayer>,
}

/// The inputs for reading any file of an import.
#[derive(Clone, Copy)]
pub struct ReadContext<'a> {
    /// The records of exports.
    pub records: &'a [ExportRecord],
    /// The exported pixels.
    pub originals: ExportedPixels<'a>,
    /// The import options.
    pub options: ImportOptions,
    /// The layers as seen at earlier imports.
    pub recall: &'a LayerCache,
}

/// The number of layers, the largest ones, by which the canvas is located.
const VOTERS: usize = 8;

/// An edited document beside its export.
pub struct ComparedDocument<'a> {
    /// What all its layers share.
    pub context: DocumentContext<'a>,
    /// Its layers by kind.
    pub sorted: SortedLayers<'a>,
    /// The paint of the image layers that it has.
    pub found: Vec<(RecordedIndex, LayerPaint)>,
}

/// Reads an edited file without its pixels, and finds the export that it comes from.
///
/// # Errors
/// Returns [`Error::Input`] for a file that cannot be read or is not one of these exports, or [`Error::Io`].
pub fn identified<'a>(
    file: &Path,
    records: &'a [ExportRecord],
    task: &Task,
) -> Result<(EditedDocument, &'a ExportRecord)> {
    let document = task.timed("read file", || read_layered(file))?;
    refuse_foreign(file, &document, records)?;
    let record = record_of(&document, records).ok_or_else(|| foreign(file))?;
    Ok((document, record))
}

/// Compares a document with its export. `before` is what the export's layers showed when this file was last imported.
///
/// # Errors
/// Returns [`Error::Input`] when the image was scaled and that is not permitted, and the errors of reading pixels.
pub fn compared<'a>(
    (file, document): (&Path, &'a EditedDocument),
    record: &'a ExportRecord,
    reading: ReadContext<'a>,
    before: &PaintedDocument,
    task: &Task,
) -> Result<ComparedDocument<'a>> {
    let sorted = sorted(document, record);
    let context = document_context(file, document, record, &sorted, reading)?;
    let found: Vec<(RecordedIndex, LayerPaint)> = task.timed("compare layers", || {
        let all: Vec<_> = sorted.image_layers.iter().collect();
        let compared = all.par_iter().map(|(index, layers)| {
            task.go_on()?;
            let exported = &record.layers[index.0];
            Ok((**index, context.layer(exported, layers, before.layers.get(&exported.id))?))
        });
        compared.collect::<Result<_>>()
    })?;
    Ok(ComparedDocument { context, sorted, found })
}

/// Begins the report of a file: without layers.
pub fn begun_report(file: &Path, document: &EditedDocument, context: &DocumentContext) -> FileReport {
    let record = context.record;
    let mut report = FileReport {
        file: file.to_owned(),
        photo: record.photo.name.clone(),
        key: record.key.clone(),
        offset: context.offset,
        scale: context.scale,
        layers: Vec::new(),
        notes: document.notes.clone(),
    };
    report.notes.extend(notes(context));
    report
}

/// Reads an edited file. `before` returns what an export's layers showed when this file was last imported.
///
/// # Errors
/// Returns [`Error::Input`] for a file that cannot be read or is not an export of this project, or when the image
/// was scaled and that is not permitted; or [`Error::Io`].
pub fn read<'a>(
    file: &Path,
    reading: ReadContext<'a>,
    before: &dyn Fn(&ExportRecord) -> PaintedDocument,
    task: &Task,
) -> Result<FilePaint<'a>> {
    let (document, record) = identified(file, reading.records, task)?;
    refuse_evened(file, record)?;
    let compared = compared((file, &document), record, reading, &before(record), task)?;
    let ComparedDocument { context, sorted, found } = compared;
    let mut report = begun_report(file, &document, &context);
    let mut layers = Vec::new();
    let mut of_absent: Vec<(RecordedIndex, PaintPatch)> = Vec::new();
    for (index, mut paint) in found {
        let exported = &record.layers[index.0];
        let left_out = paint.report.state == LayerState::LeftOut;
        let painted = paint.patch.as_ref().map_or(0, PaintPatch::count);
        let surfaces = paint.patch.map(|patch| by_surface(&patch, &parts(record, exported)));
        paint.report.notes.extend(surfaces.as_deref().and_then(|surfaces| past_outlines(surfaces, painted)));
        layers.push(ImportedLayerPaint {
            token: exported.id.clone(),
            report: Some(report.layers.len()),
            surfaces,
            seen: (!left_out).then_some(paint.seen),
        });
        report.layers.push(paint.report);
        of_absent.extend(paint.of_absent);
    }
    for (index, exported) in missing(record, &sorted) {
        let mut layer_report = LayerReport::new(&exported.name, Some(&exported.id), LayerState::Missing);
        let paint = of_absent.iter().filter(|(p, _)| *p == index).map(|(_, patch)| patch.clone());
        if let Some(patch) = paint.reduce(|a, b| a.under(&b)) {
            (layer_report.painted, layer_report.erased) = (patch.count(), patch.erased());
            layer_report
                .notes
                .push("it was merged into another layer; its paint is imported from there".into());
            let surfaces = by_surface(&patch, &parts(record, exported));
            layer_report.notes.extend(past_outlines(&surfaces, patch.count()));
            let surfaces = Some(surfaces);
            let token = exported.id.clone();
            let index = Some(report.layers.len());
            layers.push(ImportedLayerPaint { token, report: index, surfaces, seen: None });
        }
        report.layers.push(layer_report);
    }
    let mask = mask_of(&context, &sorted.masks, record, &mut report)?;
    report.layers.extend(task.timed("compare helpers", || others(&context, &sorted))?);
    Ok(FilePaint { record, report, layers, mask })
}

/// The share of a layer's paint that may be past all outlines without a note: strokes along an edge go past it as a matter of course.
const MOSTLY_PAST: f64 = 0.9;

/// Returns a note about `painted` pixels of a layer that are past the outlines of its surfaces, for the most part.
fn past_outlines(surfaces: &[SurfacePaint], painted: u64) -> Option<String> {
    let past: u64 = surfaces.iter().filter(|of| of.beyond).map(|of| of.patch.count()).sum();
    (past as f64 > MOSTLY_PAST * painted as f64).then(|| {
        format!(
            "{past} of its {painted} painted pixels are past the outlines of its surfaces, so views do not show them; they are kept"
        )
    })
}

/// Rejects exports with matched exposure: paint on them would have another exposure than the photo.
fn refuse_evened(file: &Path, record: &ExportRecord) -> Result<()> {
    if record.evened.is_none() {
        return Ok(());
    }
    let found = "it was exported with --even-colour for viewing only, and cannot be imported";
    Err(Error::input(file, "", found, "export without --even-colour, and paint on that file"))
}

/// Returns the record's layers that are not in the document, with their indices.
pub fn missing<'a>(
    record: &'a ExportRecord,
    sorted: &SortedLayers,
) -> Vec<(RecordedIndex, &'a ExportedLayer)> {
    let all = (0..).map(RecordedIndex).zip(&record.layers);
    all.filter(|(index, _)| !sorted.image_layers.contains_key(index)).collect()
}

/// Collects what all layers of a document share; locates the canvas and compares the profiles.
fn document_context<'a>(
    file: &Path,
    document: &EditedDocument,
    record: &'a ExportRecord,
    sorted: &SortedLayers,
    reading: ReadContext<'a>,
) -> Result<DocumentContext<'a>> {
    let ReadContext { originals, options, recall, .. } = reading;
    let size = (record.photo.width, record.photo.height);
    let (offset, scale) = match where_is(document, record, sorted, originals)? {
        CanvasPlacement::At(offset) => (offset, 1.0),
        CanvasPlacement::Scaled(scale) if options.scaled => ([0, 0], scale),
        CanvasPlacement::Scaled(scale) => {
            let found = format!("the image was scaled to {:.4} of its size", scale);
            let remedy = "import with --scaled (faint paint is lost then), or scale it back in the editor";
            return Err(Error::input(file, "", found, remedy));
        }
        CanvasPlacement::Unclear => {
            let (w, h) = size;
            let found = format!(
                "the canvas has {} x {} pixels but the photo {w} x {h}, and no layer shows the position",
                document.width, document.height
            );
            return Err(Error::input(file, "", found, "restore the image's canvas in the editor"));
        }
    };
    let canvas = match scale == 1.0 {
        true => PixelRect { x: -offset[0], y: -offset[1], w: document.width, h: document.height },
        false => PixelRect::of_size(size.0, size.1),
    };
    let depth = Depth::try_from(record.depth).map_err(Error::Request)?;
    let profiles = profiles(file, document, record, originals.kept)?;
    let absent =
        missing(record, sorted).into_iter().map(|(index, layer)| AbsentLayer { index, layer }).collect();
    // An equivalent profile may be written anew with every save, with the date in it, so only profiles that differ
    // count.
    let other_profile = profiles.is_some().then(|| document.icc.as_deref().map(hash_bytes));
    let conditions = format!("{offset:?} {scale} {depth:?} {:?} {other_profile:?}", document.depth);
    let named = document.format != ExportFormat::Folder;
    let only_whole = options.only_whole;
    Ok(DocumentContext {
        originals,
        record,
        depth,
        offset,
        scale,
        canvas,
        profiles,
        absent,
        named,
        only_whole,
        recall,
        conditions,
    })
}

/// Locates the canvas by the size of the document or by the largest image layers.
fn where_is(
    document: &EditedDocument,
    record: &ExportRecord,
    sorted: &SortedLayers,
    originals: ExportedPixels,
) -> Result<CanvasPlacement> {
    let size = (record.photo.width, record.photo.height);
    let mut voters = Vec::new();
    if (document.width, document.height) != size {
        let mut largest: Vec<_> = sorted.image_layers.iter().collect();
        largest.sort_by_key(|(index, layers)| (std::cmp::Reverse(layers[0].rect.area()), **index));
        for (index, layers) in largest.into_iter().take(VOTERS) {
            let exported = &record.layers[index.0];
            if let Some(base) = originals.pixels(record, exported)? {
                let depth = base.depth();
                // A layer that cannot be read is left out later, with the reason.
                let Ok(found) = gathered(layers) else { continue };
                voters.push((base, exported.baseline.rect, found.pixels.in_depth(depth), found.rect));
            }
        }
    }
    let voters = voters.iter().map(|(base, at, found, found_at)| (base, *at, found, *found_at));
    Ok(place(document, size, voters))
}

/// Compares the profiles; `None` where they agree. A document without a profile is assumed to have the photo's,
/// because some editors drop it.
fn profiles(
    file: &Path,
    document: &EditedDocument,
    record: &ExportRecord,
    kept: &Baselines,
) -> Result<Option<Profiles>> {
    let Some(found) = &document.icc else { return Ok(None) };
    let own = record.profile.as_ref().map(|name| kept.bytes(name)).transpose()?.flatten();
    let wrong = |said: String| Error::input(file, "colour profile", said, "save it with the photo's profile");
    let there = Conversion::between(own.as_deref(), Some(found)).map_err(wrong)?;
    let back = Conversion::between(Some(found), own.as_deref()).map_err(wrong)?;
    Ok(there.zip(back).map(|(there, back)| Profiles { there, back }))
}

/// Returns notes about the document as a whole.
fn notes(context: &DocumentContext) -> Vec<String> {
    let mut notes = Vec::new();
    if context.offset != [0, 0] {
        let [x, y] = context.offset;
        notes.push(format!("the canvas was cropped or enlarged: the photo is at {x}, {y}"));
    }
    if context.scale != 1.0 {
        notes.push(format!("the image was scaled to {:.4} of its size; faint paint is lost", context.scale));
    }
    if context.profiles.is_some() {
        notes.push(
            "its colours are in another profile; changes of less than 3 of 255 count as rounding".into(),
        );
    }
    notes
}

/// Reports helpers that were painted on, and layers that belong to no export.
///
/// # Errors
/// Returns the errors of reading their pixels.
pub fn others(context: &DocumentContext, sorted: &SortedLayers) -> Result<Vec<LayerReport>> {
    let comparable = context.scale == 1.0 && context.profiles.is_none() && context.offset == [0, 0];
    let helpers = if comparable { &sorted.helpers[..] } else { &[] };
    let looked_at = helpers.par_iter().map(|(layer, helper)| context.helper(layer, helper));
    let reports = looked_at.collect::<Result<Vec<_>>>()?;
    let unknown_layer = |layer: &&EditedLayer| {
        let mut report = LayerReport::new(&layer.name, None, LayerState::Unknown);
        report.notes.push("it has no [token]; merge it into the layer that it belongs to".into());
        report
    };
    Ok(reports.into_iter().flatten().chain(sorted.unknown.iter().map(unknown_layer)).collect())
}

/// Returns the outlines of an exported layer's surfaces.
fn parts<'a>(record: &'a ExportRecord, exported: &'a ExportedLayer) -> LayerParts<'a> {
    let shared =
        |element: &Element| record.layers.iter().filter(|l| l.elements.contains(element)).count() > 1;
    let with_tile = |element: &'a Element| (element, shared(element).then_some(exported.needed_rect));
    let elements: Vec<_> = exported.elements.iter().map(with_tile).collect();
    let scenery = PartSource {
        photo: &record.photo,
        camera: &record.camera,
        surfaces: &record.surfaces,
        pieces: &record.pieces,
    };
    scenery.parts(&elements, exported.rect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_is_noted_that_is_past_all_outlines_but_for_a_tenth() {
        let of = |beyond: bool, count: i32| SurfacePaint {
            object: "wall".into(),
            face: None,
            triangle: None,
            beyond,
            outline: Vec::new(),
            patch: PaintPatch::of_pixels(
                &(0..count).map(|x| (x, 0, [0, 0, 0, u16::MAX])).collect::<Vec<_>>(),
            ),
        };
        assert_eq!(past_outlines(&[of(true, 90), of(false, 10)], 100), None);
        // Surfaces in one plane share pixels, which count once.
        let note = past_outlines(&[of(true, 91), of(false, 9), of(false, 9)], 100);
        assert!(note.is_some_and(|note| note.contains("91 of its 100 painted pixels")));
        assert_eq!(past_outlines(&[], 0), None, "without paint there is nothing to say");
    }
}
