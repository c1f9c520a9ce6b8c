//! Import of one edited file: its layers are identified, located, and compared with what was exported.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use super::colours::refuse_lost_colours;
use super::context::{EditedFile, ReadContext, document_context, missing, notes};
use super::identify::{SortedLayers, foreign, record_of, refuse_foreign, sorted};
use super::layer::{DocumentContext, LayerPaint};
use super::mask::{FileMask, mask_of};
use super::question::{LayerChange, WeighedLayer};
use super::real::real_paint;
use super::report::{FileReport, LayerImportReport, LayerState};
use super::settle::SurfacePaint;
use super::share::by_surface;
use super::turned::{turn_of, turn_of_layers};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::Element;
use quadratura_document::export_record::{ExportFormat, ExportRecord, ExportedLayer, RecordedIndex};
use quadratura_document::paint::{PaintPatch, PaintedDocument, PaintedLayer};
use quadratura_layered_files::read_layered;
use quadratura_layered_files::{EditedDocument, EditedLayer, ImageTurn};
use quadratura_stacks::paint::parts::{LayerParts, PartSource};

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
    /// How it differs from the export; `None` where it is not in the file, or left out.
    pub change: Option<LayerChange>,
    /// The area of its rectangle in the export.
    pub area: u64,
    /// Whether it is as at the last import, so that the project's paint stays as it is.
    pub is_as_before: bool,
}

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

/// Compares a document with its export; `turn` is how it was turned back before that. `before` is what the export's layers showed when this file was last imported.
///
/// # Errors
/// Returns [`Error::Input`] when the image was scaled and that is not permitted, or has lost its colours, and the errors of
/// reading pixels.
pub fn compared<'a>(
    edited: EditedFile<'a>,
    record: &'a ExportRecord,
    reading: ReadContext<'a>,
    before: &PaintedDocument,
    task: &Task,
) -> Result<ComparedDocument<'a>> {
    let sorted = sorted(edited.document, record);
    let context = document_context(edited, record, &sorted, reading)?;
    let found: Vec<(RecordedIndex, LayerPaint)> = task.timed("compare layers", || {
        let all: Vec<_> = sorted.image_layers.iter().collect();
        let compared = all.par_iter().map(|(index, layers)| {
            task.check_cancelled()?;
            let exported = &record.layers[index.0];
            Ok((**index, context.layer(exported, layers, before.layers.get(&exported.id))?))
        });
        compared.collect::<Result<_>>()
    })?;
    refuse_lost_colours(edited.file, edited.document, &sorted, &found)?;
    Ok(ComparedDocument { context, sorted, found })
}

/// Begins the report of a file: without layers.
pub fn begun_report(file: &Path, document: &EditedDocument, context: &DocumentContext) -> FileReport {
    let record = context.record;
    let mut report = FileReport {
        file: file.to_owned(),
        photo: record.photo.name.clone(),
        key: record.key.clone(),
        turned: context.turn.map(|turn| turn.done),
        offset: context.offset,
        scale: context.scale,
        layers: Vec::new(),
        question: None,
        notes: document.notes.clone(),
    };
    report.notes.extend(notes(context));
    report
}

/// Reads an edited file. `before` returns what an export's layers showed when this file was last imported. An image that
/// was mirrored or turned is turned back.
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
    let before = before(record);
    let edited = EditedFile { file, document: &document, turn: None };
    let as_saved = paint_of(edited, record, reading, &before, task);
    let turn = match &as_saved {
        // The files of a folder are turned one by one, each at its place.
        _ if document.format == ExportFormat::Folder => None,
        Ok((paint, turn)) if turn.is_some() || !paint.may_be_turned() => *turn,
        Err(Error::Cancelled) => None,
        _ => task.timed("look for a turned image", || {
            turn_of(&document, record, &sorted(&document, record), reading.originals)
        })?,
    };
    match turn {
        Some(turn) => {
            let document = turn.document(document);
            let edited = EditedFile { file, document: &document, turn: Some(turn) };
            Ok(paint_of(edited, record, reading, &before, task)?.0)
        }
        None => Ok(as_saved?.0),
    }
}

impl FilePaint<'_> {
    /// Returns true where a turn of the whole image would explain what was found: hardly a pixel is where it was, or the
    /// image was scaled, so that none is.
    fn may_be_turned(&self) -> bool {
        let changes = self.layers.iter().filter_map(|layer| layer.change.as_ref());
        let compared: Vec<_> = changes.filter(|change| change.shown > 0).collect();
        let moved = compared.iter().filter(|change| !change.is_in_place()).count();
        self.report.scale != 1.0 || 2 * moved > compared.len()
    }
}

impl ImportedLayerPaint {
    /// Returns the layer for the question about its file; `changed` is the number of pixels whose paint is new.
    pub fn weighed(&self, changed: u64) -> Option<WeighedLayer> {
        self.change.clone().map(|change| WeighedLayer { change, area: self.area, changed })
    }
}

/// Reads the paint of a document, and finds whether its layers say that the image was turned.
fn paint_of<'a>(
    edited: EditedFile,
    record: &'a ExportRecord,
    reading: ReadContext<'a>,
    before: &PaintedDocument,
    task: &Task,
) -> Result<(FilePaint<'a>, Option<ImageTurn>)> {
    let EditedFile { file, document, turn } = edited;
    let compared = compared(edited, record, reading, before, task)?;
    let ComparedDocument { context, sorted, found } = compared;
    let turned = turn_of_layers(found.iter().map(|(_, paint)| paint)).filter(|_| turn.is_none());
    let mut report = begun_report(file, document, &context);
    let mut layers = Vec::new();
    let mut of_absent: Vec<(RecordedIndex, PaintPatch)> = Vec::new();
    for (index, mut paint) in found {
        let exported = &record.layers[index.0];
        let left_out = paint.report.state == LayerState::LeftOut;
        if let Some(patch) = paint.patch.take_if(|patch| !patch.is_empty()) {
            paint.patch = Some(real_paint(file, record, exported, patch, reading, &mut paint.report)?);
        }
        let painted = paint.patch.as_ref().map_or(0, PaintPatch::count);
        let surfaces = paint.patch.map(|patch| by_surface(&patch, &parts(record, exported)));
        paint.report.notes.extend(surfaces.as_deref().and_then(|surfaces| past_outlines(surfaces, painted)));
        layers.push(ImportedLayerPaint {
            token: exported.id.clone(),
            report: Some(report.layers.len()),
            is_as_before: surfaces.is_none(),
            surfaces,
            seen: (!left_out).then_some(paint.seen),
            change: (!left_out).then_some(paint.change),
            area: exported.exported_rect.area(),
        });
        report.layers.push(paint.report);
        of_absent.extend(paint.of_absent);
    }
    for (index, exported) in missing(record, &sorted) {
        let mut layer_report =
            LayerImportReport::new(&exported.name, Some(&exported.id), LayerState::Missing);
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
            layers.push(ImportedLayerPaint {
                token,
                report: index,
                surfaces,
                seen: None,
                change: None,
                area: 0,
                is_as_before: false,
            });
        }
        report.layers.push(layer_report);
    }
    report.notes.extend(turned_alone(&report.layers));
    let mask = mask_of(&context, &sorted.masks, record, &mut report)?;
    report.layers.extend(task.timed("compare helpers", || others(&context, &sorted))?);
    Ok((FilePaint { record, report, layers, mask }, turned))
}

/// Returns a note for each way in which layers were mirrored or turned by themselves.
fn turned_alone(layers: &[LayerImportReport]) -> Vec<String> {
    let mut ways: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for layer in layers {
        if let Some(turned) = layer.turned {
            ways.entry(turned).or_default().push(&layer.name);
        }
    }
    let back = "is imported as if it had been turned back";
    let note = |(turned, names): (&str, Vec<&str>)| match names[..] {
        [name] => format!("{name} was {turned} by itself; its paint {back}"),
        _ => format!("{} layers were {turned}, each at its place; their paint {back}", names.len()),
    };
    ways.into_iter().map(note).collect()
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

/// Reports helpers that were painted on, and layers that belong to no export.
///
/// # Errors
/// Returns the errors of reading their pixels.
pub fn others(context: &DocumentContext, sorted: &SortedLayers) -> Result<Vec<LayerImportReport>> {
    let is_exact = context.profiles.is_none() && context.rounding.is_none();
    let comparable = context.scale == 1.0 && is_exact && context.offset == [0, 0];
    let helpers = if comparable { &sorted.helpers[..] } else { &[] };
    let looked_at = helpers.par_iter().map(|(layer, helper)| context.helper(layer, helper));
    let reports = looked_at.collect::<Result<Vec<_>>>()?;
    let unknown_layer = |layer: &&EditedLayer| {
        let mut report = LayerImportReport::new(&layer.name, None, LayerState::Unknown);
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
