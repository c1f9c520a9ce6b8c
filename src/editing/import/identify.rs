//! Identification of the export of a file and of its layers: by token, then by key, then by position and content.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::{
    ExportRecord, ExportedLayer, HelperLayer, KEY_DIGITS, RecordedIndex,
};
use quadratura_layered_files::{EditedDocument, EditedLayer};

/// Returns the token of one of `layers` that a name contains: the last one in brackets. Editors append to names
/// after it (` copy`, `#1`, a NUL).
pub fn token_in<'a>(name: &str, layers: &'a [ExportedLayer]) -> Option<&'a str> {
    let bracketed = name.rsplit('[').filter_map(|rest| rest.split(']').next());
    let known = |token: &str| layers.iter().find(|layer| layer.id == token.trim());
    bracketed.filter_map(known).map(|layer| layer.id.as_str()).next()
}

/// Returns the token of a layer, from its name or from where the format stores one beside the name.
fn token_of<'a>(layer: &EditedLayer, layers: &'a [ExportedLayer]) -> Option<&'a str> {
    let beside = || layers.iter().find(|l| Some(&l.id) == layer.id.as_ref()).map(|l| l.id.as_str());
    token_in(&layer.name, layers).or_else(beside)
}

/// Returns the export that a document comes from: the one with its key; otherwise the one with most of its tokens,
/// and of several the one whose pixels most of its layers still have. `None` where nothing identifies it.
pub fn record_of<'a>(document: &EditedDocument, records: &'a [ExportRecord]) -> Option<&'a ExportRecord> {
    if let Some(record) = records.iter().find(|record| Some(&record.key) == document.key.as_ref()) {
        return Some(record);
    }
    let tokens = |record: &ExportRecord| {
        let mut found: Vec<_> = document.layers.iter().filter_map(|l| token_of(l, &record.layers)).collect();
        found.sort_unstable();
        found.dedup();
        found.len()
    };
    let most = records.iter().map(tokens).max().unwrap_or(0);
    let candidates: Vec<&ExportRecord> = records.iter().filter(|record| tokens(record) == most).collect();
    if let ([only], true) = (&candidates[..], most > 0) {
        return Some(only);
    }
    let hashes = hashes_of(document);
    let untouched = |record: &&ExportRecord| {
        let known = |hash: &String| record.layers.iter().any(|layer| layer.pixels == *hash);
        let same_kind = record.format == document.format;
        (hashes.iter().filter(|hash| known(hash)).count(), same_kind)
    };
    let best = candidates.into_iter().max_by_key(untouched);
    // Without tokens, only unchanged pixels identify an export.
    best.filter(|record| most > 0 || untouched(record).0 > 0)
}

/// Rejects a file with the key of an export that this project does not know. It must not be compared with another
/// export: tokens are the same in all projects of the same photos and model, and differences between projects would
/// be taken for paint.
///
/// # Errors
/// Returns [`Error::Input`] with the key.
pub fn refuse_foreign(file: &Path, document: &EditedDocument, records: &[ExportRecord]) -> Result<()> {
    let Some(key) = document.key.as_deref().filter(|key| looks_like_a_key(key)) else { return Ok(()) };
    if records.iter().any(|record| record.key == key) {
        return Ok(());
    }
    let found = format!("it was exported with the key {key}, but exports/{key}.json is not in this project");
    let remedy = "import it into the project that it was exported from, or restore that record (and \
        exports/pixels) from a copy; otherwise export again, and copy the painted layers over in the image \
        editor";
    Err(Error::input(file, "", found, remedy))
}

/// Returns true when a key has the form that this program writes; editors have document keys of other forms.
fn looks_like_a_key(key: &str) -> bool {
    key.len() == KEY_DIGITS && key.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// Returns the hashes of all layers' pixels at their positions.
fn hashes_of(document: &EditedDocument) -> Vec<String> {
    // Unreadable layers are ignored here and reported later.
    let hash = |layer: &EditedLayer| Some(layer.pixels.read().ok()?.hash_at(layer.rect.x, layer.rect.y));
    document.layers.par_iter().filter_map(hash).collect()
}

/// A document's layers by kind.
#[derive(Debug, Default)]
pub struct SortedLayers<'a> {
    /// The image layers by index in the record: all layers with its token, from bottom to top.
    pub image_layers: BTreeMap<RecordedIndex, Vec<&'a EditedLayer>>,
    /// The photo and guides, with their entries in the record.
    pub helpers: Vec<(&'a EditedLayer, &'a HelperLayer)>,
    /// The layers called `mask`, whose paint masks the photo.
    pub masks: Vec<&'a EditedLayer>,
    /// The layers that belong to no export.
    pub unknown: Vec<&'a EditedLayer>,
}

/// Identifies the layers of a document that comes from `record`. A layer that lost its token is identified by the
/// rectangle of its pixels, if that is unambiguous.
pub fn sorted<'a>(document: &'a EditedDocument, record: &'a ExportRecord) -> SortedLayers<'a> {
    let mut sorted = SortedLayers::default();
    let index = |token: &str| record.layers.iter().position(|layer| layer.id == token).map(RecordedIndex);
    for layer in &document.layers {
        match token_of(layer, &record.layers).and_then(index) {
            Some(index) => sorted.image_layers.entry(index).or_default().push(layer),
            None => match helper_of(layer, record) {
                Some(helper) => sorted.helpers.push((layer, helper)),
                None if is_mask(&layer.name) => sorted.masks.push(layer),
                None => sorted.unknown.push(layer),
            },
        }
    }
    let without_token = std::mem::take(&mut sorted.unknown);
    for layer in &without_token {
        let free = |at: &RecordedIndex| !sorted.image_layers.contains_key(at);
        let same_place = |at: &RecordedIndex| record.layers[at.0].exported_rect == layer.rect;
        let mut candidates = (0..record.layers.len()).map(RecordedIndex).filter(free).filter(same_place);
        let same_rect = without_token.iter().filter(|other| other.rect == layer.rect).count();
        match (candidates.next(), candidates.next(), same_rect) {
            (Some(index), None, 1) => drop(sorted.image_layers.insert(index, vec![layer])),
            _ => sorted.unknown.push(layer),
        }
    }
    sorted
}

/// Returns true for `mask` in any letter case, and with what editors append to names: `mask #1`, `Mask copy`.
fn is_mask(name: &str) -> bool {
    let name = name.trim().to_lowercase();
    name.strip_prefix("mask").is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
}

/// Returns the helper to which a layer's name belongs; editors may append to it.
fn helper_of<'a>(layer: &EditedLayer, record: &'a ExportRecord) -> Option<&'a HelperLayer> {
    record.helpers.iter().find(|helper| layer.name.starts_with(&helper.name))
}

/// Makes the error for a file that is not an export of this project.
pub fn foreign(file: &Path) -> Error {
    Error::input(
        file,
        "",
        "it is not an export of this project: neither its key nor a layer's [token] is in the project's \
         exports/",
        "import it into the project that it was exported from, or export again and paint there",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_document::export_record::Baseline;

    fn layer(id: &str) -> ExportedLayer {
        let rect = PixelRect::of_size(1, 1);
        ExportedLayer {
            id: id.into(),
            name: format!("wall [{id}]"),
            order: 0,
            rect,
            exported_rect: rect,
            needed_rect: rect,
            pixels: String::new(),
            baseline: Baseline { file: String::new(), rect },
            elements: vec![],
        }
    }

    #[test]
    fn a_layer_of_masks_is_known_whatever_an_editor_made_of_its_name() {
        assert!(
            ["mask", "Mask", " MASK ", "mask #1", "mask copy", "mask-2"].iter().all(|name| is_mask(name))
        );
        assert!(!["masks", "masked", "unmask", "wall mask", "mask2"].iter().any(|name| is_mask(name)));
    }

    #[test]
    fn a_token_is_found_whatever_an_editor_made_of_the_name() {
        let layers = [layer("k7q2m9"), layer("abcd")];
        for name in [
            "wall [k7q2m9]",
            "wall [k7q2m9]#1",
            "wall [k7q2m9] copy",
            "wall [k7q2m9] Kopie #3\0",
            "my (wall) [x] [k7q2m9] [later]",
            "[k7q2m9 ]",
            "copy of [abcd][k7q2m9]",
        ] {
            assert_eq!(token_in(name, &layers), Some("k7q2m9"), "{name}");
        }
        for name in ["wall", "wall [other]", "wall k7q2m9", "wall [k7q2", "[]", "]["] {
            assert_eq!(token_in(name, &layers), None, "{name}");
        }
    }
}
