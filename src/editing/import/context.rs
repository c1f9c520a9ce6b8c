//! What all layers of an edited document share: where the photo is on its canvas, and how its colours are stored.

use std::path::Path;

use super::compare::Profiles;
use super::identify::SortedLayers;
use super::layer::DocumentContext;
use super::merged::AbsentLayer;
use super::originals::ExportedPixels;
use super::place::{CanvasPlacement, place, placed_layers};
use super::{ImportOptions, LayerCache};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::{ExportFormat, ExportRecord, ExportedLayer, RecordedIndex};
use quadratura_files::hash::hash_bytes;
use quadratura_io::baselines::Baselines;
use quadratura_io::colour::Conversion;
use quadratura_layered_files::{Depth, EditedDocument, ImageTurn};

/// An edited file with what is in it.
#[derive(Clone, Copy)]
pub struct EditedFile<'a> {
    /// The file.
    pub file: &'a Path,
    /// Its contents, turned back if the image was turned.
    pub document: &'a EditedDocument,
    /// How the image was turned; `None` where it was not.
    pub turn: Option<ImageTurn>,
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

/// Returns the record's layers that are not in the document, with their indices.
pub fn missing<'a>(
    record: &'a ExportRecord,
    sorted: &SortedLayers,
) -> Vec<(RecordedIndex, &'a ExportedLayer)> {
    let all = (0..).map(RecordedIndex).zip(&record.layers);
    all.filter(|(index, _)| !sorted.image_layers.contains_key(index)).collect()
}

/// Collects what all layers of a document share; locates the canvas and compares the profiles.
pub fn document_context<'a>(
    edited: EditedFile,
    record: &'a ExportRecord,
    sorted: &SortedLayers,
    reading: ReadContext<'a>,
) -> Result<DocumentContext<'a>> {
    let EditedFile { file, document, turn } = edited;
    let ReadContext { originals, options, recall, .. } = reading;
    let size = (record.photo.width, record.photo.height);
    let (offset, scale) = match place(document, record, sorted, originals)? {
        CanvasPlacement::At(offset) => (offset, 1.0),
        CanvasPlacement::Scaled(scale) if options.scaled => ([0, 0], scale),
        CanvasPlacement::Scaled(scale) => {
            let turned = turn.map_or_else(String::new, |turn| format!("{} and ", turn.done));
            let found = format!("the image was {turned}scaled to {scale:.4} of its size");
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
    let assigned = match &profiles {
        Some(profiles) if scale == 1.0 => {
            let layers = placed_layers(record, sorted, originals)?;
            let colours = layers.iter().flat_map(|layer| layer.colours(offset));
            profiles.are_assigned(&colours.collect::<Vec<_>>())
        }
        _ => false,
    };
    let profiles = profiles.filter(|_| !assigned);
    let absent =
        missing(record, sorted).into_iter().map(|(index, layer)| AbsentLayer { index, layer }).collect();
    // An equivalent profile may be written anew with every save, with the date in it, so only profiles that differ
    // count.
    let other_profile = profiles.is_some().then(|| document.icc.as_deref().map(hash_bytes));
    let conditions = format!("{offset:?} {scale} {depth:?} {:?} {other_profile:?}", document.depth);
    let named = document.format != ExportFormat::Folder;
    let (only_whole, only_unseen) = (options.only_whole, options.only_unseen);
    Ok(DocumentContext {
        originals,
        record,
        depth,
        turn,
        offset,
        scale,
        canvas,
        profiles,
        assigned,
        rounding: document.rounding,
        absent,
        named,
        only_whole,
        only_unseen,
        recall,
        conditions,
    })
}

/// Compares the profiles; `None` where they agree. A document without a profile is assumed to have the photo's,
/// because some editors drop it.
fn profiles(
    file: &Path,
    document: &EditedDocument,
    record: &ExportRecord,
    kept: &Baselines,
) -> Result<Option<Profiles>> {
    // What an image in greyscale has lost is found by its pixels.
    const GREY: Option<&[u8]> = Some(b"GRAY");
    let Some(found) = document.icc.as_ref().filter(|icc| icc.get(16..20) != GREY) else { return Ok(None) };
    let own = record.profile.as_ref().map(|name| kept.bytes(name)).transpose()?.flatten();
    let wrong = |said: String| Error::input(file, "colour profile", said, "save it with the photo's profile");
    let there = Conversion::between(own.as_deref(), Some(found)).map_err(wrong)?;
    let back = Conversion::between(Some(found), own.as_deref()).map_err(wrong)?;
    Ok(there.zip(back).map(|(there, back)| Profiles { there, back }))
}

/// Returns notes about the document as a whole.
pub fn notes(context: &DocumentContext) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(turn) = context.turn {
        notes.push(format!(
            "the image was {}; its paint is imported as if it had been turned back",
            turn.done
        ));
    }
    if context.offset != [0, 0] {
        let ([x, y], photo) = (context.offset, &context.record.photo);
        notes.push(match (context.canvas.w, context.canvas.h) == (photo.width, photo.height) {
            true => {
                format!("the layers were moved together by {x}, {y}; their paint is imported as if they had been moved back")
            }
            false => format!("the canvas was cropped or enlarged: the photo is at {x}, {y}"),
        });
    }
    if context.scale != 1.0 {
        notes.push(format!("the image was scaled to {:.4} of its size; faint paint is lost", context.scale));
    }
    if context.assigned {
        notes.push(
            "another colour profile was assigned to it and its colours were not converted: they count as colours of the \
             photo's profile"
                .into(),
        );
    }
    if context.profiles.is_some() {
        notes.push(
            "its colours are in another profile; changes of less than 3 of 255 count as rounding".into(),
        );
    }
    notes
}
