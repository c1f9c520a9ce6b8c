//! One edited file: its layers told apart, placed, and compared with what was exported.

use std::path::Path;

use rayon::prelude::*;

use super::compare::Profiles;
use super::gather::gathered;
use super::identify::{Sorted, record_of, refuse_foreign, sorted, stranger};
use super::layer::{Desk, LayerPaint};
use super::mask::{MaskShare, mask_of};
use super::merged::Absent;
use super::originals::Originals;
use super::place::{Place, place};
use super::report::{FileReport, LayerReport, LayerState};
use super::settle::OnSurface;
use super::share::shared;
use super::{ImportOptions, Recall};
use crate::document::Element;
use crate::document::export_record::{ExportFormat, ExportRecord, ExportedLayer};
use crate::document::paint::{PaintedDocument, PaintedLayer, Patch};
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::baselines::Baselines;
use crate::io::colour::Conversion;
use crate::io::hash::hash_bytes;
use crate::io::layered::read_layered;
use crate::io::layered::{Depth, EditedDocument, EditedLayer};
use crate::recipe::paint::parts::{Parts, Scenery};
use crate::task::Task;

/// What an edited file brings home.
pub struct FilePaint<'a> {
    /// The export that it came from.
    pub record: &'a ExportRecord,
    /// What the user is told.
    pub report: FileReport,
    /// The image layers that are in the file.
    pub layers: Vec<LayerShare>,
    /// What its layers called `mask` mask.
    pub mask: Option<MaskShare>,
}

/// The paint of one image layer, by surface.
pub struct LayerShare {
    /// Of the image layer.
    pub token: String,
    /// Its place among the report's layers, if it is told there.
    pub report: Option<usize>,
    /// All of its paint; none where it stays as it is in the project.
    pub surfaces: Option<Vec<OnSurface>>,
    /// What it shows now; none where nobody knows.
    pub seen: Option<PaintedLayer>,
}

/// What every file of an import is read with.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// What was exported.
    pub records: &'a [ExportRecord],
    /// Its pixels.
    pub originals: Originals<'a>,
    /// How to import.
    pub options: ImportOptions,
    /// What was seen at earlier imports.
    pub recall: &'a Recall,
}

/// So many layers say where the canvas lies, the largest ones.
const VOTERS: usize = 8;

/// Reads an edited file. `before` gives what an export's layers showed when this file was last imported.
///
/// # Errors
/// [`Error::Input`] for a file that cannot be read or is no export of this project; [`Error::Io`];
/// [`Error::Request`] when the image was scaled and that was not allowed.
pub fn read<'a>(
    file: &Path,
    reading: Reading<'a>,
    before: &dyn Fn(&ExportRecord) -> PaintedDocument,
    task: &Task,
) -> Result<FilePaint<'a>> {
    let document = task.timed("read file", || read_layered(file))?;
    refuse_foreign(file, &document, reading.records)?;
    let record = record_of(&document, reading.records).ok_or_else(|| stranger(file))?;
    refuse_evened(file, record)?;
    let sorted = sorted(&document, record);
    let desk = desk(file, &document, record, &sorted, reading)?;
    let before = before(record);
    let found: Vec<(usize, LayerPaint)> = task.timed("compare layers", || {
        let all: Vec<_> = sorted.image_layers.iter().collect();
        let compared = all.par_iter().map(|(place, layers)| {
            task.go_on()?;
            let exported = &record.layers[**place];
            Ok((**place, desk.layer(exported, layers, before.layers.get(&exported.id))?))
        });
        compared.collect::<Result<_>>()
    })?;
    let mut report = FileReport {
        file: file.to_owned(),
        photo: record.photo.name.clone(),
        key: record.key.clone(),
        offset: desk.offset,
        scale: desk.scale,
        layers: Vec::new(),
        notes: document.notes.clone(),
    };
    report.notes.extend(notes(&desk));
    let mut layers = Vec::new();
    let mut of_absent: Vec<(usize, Patch)> = Vec::new();
    for (place, paint) in found {
        let exported = &record.layers[place];
        let left_out = paint.report.state == LayerState::LeftOut;
        layers.push(LayerShare {
            token: exported.id.clone(),
            report: Some(report.layers.len()),
            surfaces: paint.patch.map(|patch| by_surface(record, exported, &patch)),
            seen: (!left_out).then_some(paint.seen),
        });
        report.layers.push(paint.report);
        of_absent.extend(paint.of_absent);
    }
    for (place, exported) in missing(record, &sorted) {
        let mut told = LayerReport::new(&exported.name, Some(&exported.id), LayerState::Missing);
        let paint = of_absent.iter().filter(|(p, _)| *p == place).map(|(_, patch)| patch.clone());
        if let Some(patch) = paint.reduce(|a, b| a.under(&b)) {
            (told.painted, told.erased) = (patch.count(), patch.erased());
            told.notes.push("it was merged into another layer; what was painted there is taken home".into());
            let surfaces = Some(by_surface(record, exported, &patch));
            let (token, index) = (exported.id.clone(), Some(report.layers.len()));
            layers.push(LayerShare { token, report: index, surfaces, seen: None });
        }
        report.layers.push(told);
    }
    let mask = mask_of(&desk, &sorted.masks, record, &mut report)?;
    report.layers.extend(task.timed("compare helpers", || others(&desk, &sorted))?);
    Ok(FilePaint { record, report, layers, mask })
}

/// What was painted on evened colours would be of another exposure than the photo that it belongs to.
fn refuse_evened(file: &Path, record: &ExportRecord) -> Result<()> {
    if record.evened.is_none() {
        return Ok(());
    }
    let found = "it was exported with --even-colour, for looking at; it has no way back";
    Err(Error::input(file, "", found, "export without --even-colour, and paint on that"))
}

fn missing<'a>(record: &'a ExportRecord, sorted: &Sorted) -> Vec<(usize, &'a ExportedLayer)> {
    let all = record.layers.iter().enumerate();
    all.filter(|(place, _)| !sorted.image_layers.contains_key(place)).collect()
}

fn desk<'a>(
    file: &Path,
    document: &EditedDocument,
    record: &'a ExportRecord,
    sorted: &Sorted,
    reading: Reading<'a>,
) -> Result<Desk<'a>> {
    let Reading { originals, options, recall, .. } = reading;
    let size = (record.photo.width, record.photo.height);
    let (offset, scale) = match where_is(document, record, sorted, originals)? {
        Place::At(offset) => (offset, 1.0),
        Place::Scaled(scale) if options.scaled => ([0, 0], scale),
        Place::Scaled(scale) => {
            let found = format!("the image was scaled to {:.4} of its size", scale);
            let remedy = "import with --scaled (faint paint is lost then), or scale it back in the editor";
            return Err(Error::input(file, "", found, remedy));
        }
        Place::Unclear => {
            let (w, h) = size;
            let found = format!(
                "a canvas of {} x {} pixels, the photo has {w} x {h}, and no layer tells where it lies",
                document.width, document.height
            );
            return Err(Error::input(file, "", found, "give the image its old canvas back in the editor"));
        }
    };
    let canvas = match scale == 1.0 {
        true => PixelRect { x: -offset[0], y: -offset[1], w: document.width, h: document.height },
        false => PixelRect::of_size(size.0, size.1),
    };
    let depth = Depth::try_from(record.depth).map_err(Error::Request)?;
    let profiles = profiles(file, document, record, originals.kept)?;
    let absent = missing(record, sorted).into_iter().map(|(place, layer)| Absent { place, layer }).collect();
    // A profile that says the same as the photo's may be written anew with every save, with the date in it.
    let other_profile = profiles.is_some().then(|| document.icc.as_deref().map(hash_bytes));
    let ground = format!("{offset:?} {scale} {depth:?} {:?} {other_profile:?}", document.depth);
    let (named, only_whole) = (document.format != ExportFormat::Folder, options.only_whole);
    Ok(Desk {
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
        ground,
    })
}

fn where_is(
    document: &EditedDocument,
    record: &ExportRecord,
    sorted: &Sorted,
    originals: Originals,
) -> Result<Place> {
    let size = (record.photo.width, record.photo.height);
    let mut voters = Vec::new();
    if (document.width, document.height) != size {
        let mut largest: Vec<_> = sorted.image_layers.iter().collect();
        largest.sort_by_key(|(place, layers)| (std::cmp::Reverse(layers[0].rect.area()), **place));
        for (place, layers) in largest.into_iter().take(VOTERS) {
            let exported = &record.layers[*place];
            if let Some(base) = originals.pixels(record, exported)? {
                let depth = base.depth();
                // One that cannot be read is left out later, with the reason.
                let Ok(found) = gathered(layers) else { continue };
                voters.push((base, exported.baseline.rect, found.pixels.in_depth(depth), found.rect));
            }
        }
    }
    let voters = voters.iter().map(|(base, at, found, found_at)| (base, *at, found, *found_at));
    Ok(place(document, size, voters))
}

/// A document without a profile is taken for one with the photo's: some editors drop it.
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

fn notes(desk: &Desk) -> Vec<String> {
    let mut notes = Vec::new();
    if desk.offset != [0, 0] {
        let [x, y] = desk.offset;
        notes.push(format!("the canvas was cropped or enlarged: the photo lies at {x}, {y}"));
    }
    if desk.scale != 1.0 {
        notes.push(format!("the image was scaled to {:.4} of its size; faint paint is lost", desk.scale));
    }
    if desk.profiles.is_some() {
        notes.push(
            "its colours are in another profile; changes of less than 3 of 255 are taken for rounding".into(),
        );
    }
    notes
}

/// Helpers that were painted on, and layers of no export.
fn others(desk: &Desk, sorted: &Sorted) -> Result<Vec<LayerReport>> {
    let comparable = desk.scale == 1.0 && desk.profiles.is_none() && desk.offset == [0, 0];
    let helpers = if comparable { &sorted.helpers[..] } else { &[] };
    let looked_at = helpers.par_iter().map(|(layer, helper)| desk.helper(layer, helper));
    let reports = looked_at.collect::<Result<Vec<_>>>()?;
    let stranger = |layer: &&EditedLayer| {
        let mut report = LayerReport::new(&layer.name, None, LayerState::Unknown);
        report.notes.push("it has no [token]; merge it into the layer that it is meant for".into());
        report
    };
    Ok(reports.into_iter().flatten().chain(sorted.unknown.iter().map(stranger)).collect())
}

/// The paint of an image layer by surface.
fn by_surface(record: &ExportRecord, exported: &ExportedLayer, patch: &Patch) -> Vec<OnSurface> {
    let parts = parts(record, exported);
    let on_surface = |share: super::share::Share| {
        let part = &parts.list[share.part];
        OnSurface {
            object: part.object.to_owned(),
            face: part.face,
            triangle: part.triangle,
            beyond: share.beyond,
            outline: part.outline.to_vec(),
            patch: share.patch,
        }
    };
    shared(patch, &parts).into_iter().map(on_surface).collect()
}

fn parts<'a>(record: &'a ExportRecord, exported: &'a ExportedLayer) -> Parts<'a> {
    let shared =
        |element: &Element| record.layers.iter().filter(|l| l.elements.contains(element)).count() > 1;
    let with_tile = |element: &'a Element| (element, shared(element).then_some(exported.needed_rect));
    let elements: Vec<_> = exported.elements.iter().map(with_tile).collect();
    let scenery = Scenery {
        photo: &record.photo,
        camera: &record.camera,
        surfaces: &record.surfaces,
        pieces: &record.pieces,
    };
    scenery.parts(&elements, exported.rect)
}
