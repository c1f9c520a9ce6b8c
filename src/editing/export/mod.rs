//! Export to the image editor: one layered file per photo.
//!
//! The photo is at the bottom as a locked reference. Above it is a group per `order`, the nearest on top, with a
//! layer per image layer and a hidden guide that shows where these are hidden in the photo. Where the project has trees, a
//! hidden guide in front shows where they are. A file that was changed since its export is never overwritten.

mod compose;
mod encoded;
mod folder;
mod guide;
mod names;
mod one;
mod place;
mod provenance;
mod trees;
pub mod written;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

pub use compose::{HiddenPixels, StackContent};
pub use names::layer_name;
pub use one::ExportReport;
pub use provenance::write_provenance;
pub use trees::{TreeGuide, TreesInSite};

use self::one::Exporter;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Decisions;
use quadratura_document::export_record::ExportFormat;
use quadratura_files::atomic::remove_dead_leftovers;
use quadratura_io::baselines::Baselines;
use quadratura_io::exports::{ExportStore, WrittenFiles};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::side_by_side::{ParallelPhotos, done_and_failed};

/// Options of [`export`].
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// The file format.
    pub format: ExportFormat,
    /// The margin in pixels around the needed area that a layer keeps, within its rectangle; `None` keeps all of
    /// it. In the folder format, layers are always complete, so that its `stack.json` is valid for them.
    pub margin: Option<u32>,
    /// Whether each group with occluded parts to paint has a hidden guide, and the whole one of trees.
    pub guides: bool,
    /// The trees that a guide shows, where there are guides.
    pub trees: Option<TreesInSite>,
    /// The token of the image layer that is active when the file is opened, in formats that support this.
    pub selected: Option<String>,
    /// The factors for R, G, B that multiply a photo's linear colours, by photo name. Such exports are only for
    /// viewing and cannot be imported. Photos without factors are exported as they are.
    pub evened: BTreeMap<String, [f64; 3]>,
    /// Whether a folder is for a scene that refers to its files: image layers alone, named by token, so that links survive a rebuild. A
    /// folder that was painted on is replaced once that paint is imported, and kept in the project's `inbox/`.
    pub for_scene: bool,
    /// The decisions from which layers get their present names; `None` keeps the names from when they were built.
    pub decisions: Option<Decisions>,
    /// The approximate memory budget in bytes for photos processed at the same time; at least one is processed.
    pub memory: u64,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            format: ExportFormat::Psd,
            margin: Some(8),
            guides: true,
            trees: None,
            selected: None,
            evened: BTreeMap::new(),
            for_scene: false,
            decisions: None,
            memory: 1 << 30,
        }
    }
}

impl ExportOptions {
    /// Returns the margin of layers, which the folder format does not have.
    fn layer_margin(&self) -> Option<u32> {
        self.margin.filter(|_| self.format != ExportFormat::Folder)
    }
}

/// The results for all photos, in their order.
#[derive(Debug, Default)]
pub struct Exported {
    /// The reports of photos that were written.
    pub done: Vec<ExportReport>,
    /// The photos that failed, with the reasons.
    pub failed: Vec<(String, Error)>,
}

/// The stage that is reported for reading one photo.
pub const STAGE_READ: &str = "read photo";
/// The stage that is reported for writing one photo's layers.
pub const STAGE_WRITE: &str = "write layers";
/// The stage that is reported for all photos together.
pub const STAGE: &str = "export";

/// The folders of a project that contain its own files, where exports would be among them.
const OWN_FOLDERS: [&str; 6] = ["stacks", "paint", "masks", "inbox", "exports", "cache"];

/// Checks that exported files are not written among the project's own.
///
/// # Errors
/// Returns [`Error::Request`].
pub fn check_place(project: &Path, out: &Path) -> Result<()> {
    let real = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path)).ok();
    let (Some(folder), Some(place)) = (real(project), real(out)) else { return Ok(()) };
    let is_own = OWN_FOLDERS.iter().any(|own| place.starts_with(folder.join(own)));
    if place == folder || is_own {
        return Err(Error::Request(format!(
            "{}: this folder belongs to the project; export to another one, such as {}",
            out.display(),
            project.join("layers").display()
        )));
    }
    Ok(())
}

/// Exports the current stacks of `photos` from the project in the folder `project` to the folder `out`, which is
/// created if necessary and from which leftovers of killed exports are removed. An error in one photo is in [`Exported::failed`] and does not stop the others.
///
/// # Errors
/// Returns [`Error::Request`] for a folder that belongs to the project, and for the folder format with matched exposure, because its `stack.json` would not be
/// valid, [`Error::Io`] when `out` cannot be created or the records of earlier exports cannot be read, or
/// [`Error::Cancelled`].
pub fn export(
    project: &Path,
    photos: &[&Photo],
    out: &Path,
    options: &ExportOptions,
    task: &Task,
) -> Result<Exported> {
    if !options.evened.is_empty() && options.format == ExportFormat::Folder {
        return Err(Error::Request(
            "--even-colour does not apply to folders; choose the format psd, xcf or ora".into(),
        ));
    }
    check_place(project, out)?;
    fs::create_dir_all(out).map_err(Error::io(out, "create the folder"))?;
    [out, &project.join("exports")].into_iter().for_each(remove_dead_leftovers);
    let records = ExportStore::new(project.join("exports"));
    let paint = PaintStore::new(project);
    let (known, problems) = records.read_all()?;
    problems.iter().for_each(|problem| task.note(problem));
    let trees = options.trees.as_ref().filter(|_| options.guides);
    let trees = trees.map(|trees| trees.grown(project, task)).transpose()?.flatten();
    let exporter = Exporter {
        project,
        stacks: StackStore::new(project),
        kept: Baselines::new(&project.join("exports")),
        book: paint.read()?,
        paint,
        records,
        written: WrittenFiles::from_records(&known),
        trees,
        out,
        options,
    };
    let at_a_time =
        ParallelPhotos { threads: rayon::current_num_threads(), memory: options.memory, stage: STAGE };
    let work = |photo: &&Photo| exporter.export(photo, &task.with_subject(&photo.name));
    let bytes =
        |photo: &&Photo| bytes_for(photo) + if exporter.trees.is_some() { bytes_for_trees(photo) } else { 0 };
    let results = at_a_time.run(photos, bytes, work, task)?;
    let names: Vec<String> = photos.iter().map(|photo| photo.name.clone()).collect();
    let (done, failed) = done_and_failed(&names, results)?;
    exporter.records.remove_old_pixels(&exporter.kept)?;
    note_darker(&done, task);
    Ok(Exported { done, failed })
}

/// Notes once that image editors show edges of see-through layers darker than views do.
fn note_darker(done: &[ExportReport], task: &Task) {
    let of_all: Vec<&ExportReport> = done.iter().filter(|one| one.darker > Some(0.0)).collect();
    let files = match of_all[..] {
        [] => return,
        [one] => format!("the file of {}", one.photo),
        _ => format!("the files of {} photos", of_all.len()),
    };
    let most = of_all.iter().filter_map(|one| one.darker).fold(0.0, f64::max);
    task.note(format!(
        "in image editors, edges of see-through layers are up to {:.0} of 255 darker in {files} than in views and photos, because editors mix \
         encoded values; an XCF opened in GIMP shows them right",
        (most * 255.0).ceil()
    ));
}

/// Returns the peak memory for one photo in bytes. Per pixel these are the photo as RGBA, its merged picture also
/// compressed, and a guide, with 16 bits at worst; in addition a batch of layers before and after compression.
fn bytes_for(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 4 * 2 * 3 + (128 << 20)
}

/// Returns the peak memory for the guide of trees of one photo in bytes: per pixel the nearness of the model with the owners that it is
/// made of, and the guide with 16 bits.
fn bytes_for_trees(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * (4 + 4 + 8)
}
