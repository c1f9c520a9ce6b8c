//! The export of a species to a layered file.

use std::collections::BTreeSet;
use std::path::Path;

use super::content::TreeContent;
use crate::export::written::DocumentPlace;
use crate::export::{ExportReport, STAGE_WRITE, check_place};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::Trees;
use quadratura_document::export_record::{
    ExportFormat, ExportRecord, ExportedFile, ExportedTree, KEY_DIGITS, RECORD_VERSION,
};
use quadratura_document::stack::{StackCamera, StackPhoto};
use quadratura_files::atomic::remove_dead_leftovers;
use quadratura_files::hash::hash_bytes;
use quadratura_files::json::to_json;
use quadratura_foliage::files::images::plant_hash;
use quadratura_foliage::{PaintedSlab, painted};
use quadratura_io::baselines::Baselines;
use quadratura_io::exports::{ExportStore, WrittenFiles};
use quadratura_io::tree_paint::TreePaintStore;
use quadratura_sites::unknown_name::no_such;
use quadratura_trees::paint::{fields, part_of, slabs};
use quadratura_trees::plant_of;

/// The folder of a project that has the records of species' exports.
pub const RECORDS: &str = "exports/trees";

/// Options of [`export_species`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TreeExportOptions {
    /// The file format.
    pub format: ExportFormat,
    /// The name of the sub-object; `None` for the whole plant.
    pub part: Option<String>,
}

/// Exports what six directions see of a species, or of one of its sub-objects, with its paint, to the folder `out`, which is created
/// if necessary. The caller holds the project's lock.
///
/// # Errors
/// [`Error::Missing`] for a species that the project does not have; [`Error::Request`] for a part that it does not have or that has no
/// polygons, and for a folder that belongs to the project; the errors of reading the plant; [`Error::Io`]; [`Error::Cancelled`].
pub fn export_species(
    project: &Path,
    trees: &Trees,
    name: &str,
    out: &Path,
    options: &TreeExportOptions,
    task: &Task,
) -> Result<ExportReport> {
    let species = trees.species.get(name);
    let species =
        species.ok_or_else(|| no_such("species", name, trees.species.keys().map(String::as_str), None))?;
    check_place(project, out)?;
    std::fs::create_dir_all(out).map_err(Error::io(out, "create the folder"))?;
    let folder = project.join(RECORDS);
    [out, &folder].into_iter().for_each(remove_dead_leftovers);
    let plant = plant_of(project, species, task)?;
    let part = options.part.as_deref();
    let object =
        part_of(&plant, part).map_err(|found| Error::Request(format!("the species {name:?}: {found}")))?;
    let (store, records) = (TreePaintStore::new(project), ExportStore::new(&folder));
    let book = store.read()?;
    let fields = fields(&store, &book, name, &plant, task);
    let shown = painted(&plant, object, &fields).plant;
    let documents = book.of_species(name).remove(&part).unwrap_or_default();
    let coats: Vec<PaintedSlab> =
        documents.iter().flat_map(|coats| slabs(&store, coats, name, task)).collect();
    let content = TreeContent::new(name, part, &shown, &coats, task)?;
    let files: BTreeSet<String> = documents.iter().flatten().map(|coat| coat.file.clone()).collect();
    let (title, inputs) = (content.title(), plant_hash(&shown));
    let mut key = hash_bytes(&to_json(&(&title, &inputs, options.format, &content.frame, &files)));
    key.truncate(KEY_DIGITS);
    let document = content.document(&key);
    let kept = Baselines::new(&folder);
    let record = |written: Vec<ExportedFile>| {
        records.write(ExportRecord {
            version: RECORD_VERSION,
            key: key.clone(),
            format: options.format,
            photo: StackPhoto { name: title.clone(), width: document.width, height: document.height },
            camera: no_camera(),
            depth: document.depth.bits(),
            inputs: inputs.clone(),
            files: written.into_iter().collect(),
            evened: None,
            layers: content.exported_layers(&kept)?,
            helpers: vec![content.helper()],
            pieces: Vec::new(),
            surfaces: Vec::new(),
            paint: files.clone(),
            profile: None,
            tree: Some(ExportedTree {
                species: name.to_owned(),
                part: options.part.clone(),
                plant: plant_hash(&plant),
                frame: content.frame,
                samples: content.samples(&kept)?,
                slabs: content.slabs(),
            }),
        })
    };
    let (known, problems) = records.read_all()?;
    problems.iter().for_each(|problem| task.note(problem));
    let written = WrittenFiles::from_records(&known);
    let place = DocumentPlace { out, name: &title, written: &written, format: options.format };
    let done = task
        .timed(STAGE_WRITE, || place.write(&document, &|folder| content.fill(folder, &document), &record))?;
    for file in &done.spared {
        let (old, new) = (file.display(), done.path.display());
        task.note(format!("{old} was changed since it was exported and is kept; this export is {new}"));
    }
    records.remove_old_pixels(&kept)?;
    let (layers, groups) = (content.layer_count(), content.group_count());
    let (path, spared, bytes) = (done.path, done.spared, done.bytes);
    Ok(ExportReport {
        photo: title,
        path,
        spared,
        key,
        layers,
        groups,
        bytes,
        darker: None,
        problems: Vec::new(),
    })
}

/// Returns the camera of a record that is of no photo.
fn no_camera() -> StackCamera {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    StackCamera { K: unit, R: unit, t: [0.0; 3] }
}
