//! Out to the image editor: one layered file a photo.
//!
//! The photo lies at the bottom as a locked reference; above it stands a group per `order`, the nearest
//! on top, with a layer per image layer, and a hidden guide that shows where these are hidden in the
//! photo. A file that somebody changed since it was exported is never overwritten.

mod compose;
mod folder;
mod guide;
mod names;
mod one;
mod place;
mod provenance;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

pub use compose::{Content, Hidden};
pub use names::layer_name;
pub use one::ExportReport;
pub use provenance::write_provenance;

use self::one::Exporter;
use super::side_by_side::{SideBySide, done_and_failed};
use crate::document::Decisions;
use crate::document::export_record::ExportFormat;
use crate::error::{Error, Result};
use crate::io::baselines::Baselines;
use crate::io::exports::{ExportStore, WrittenFiles};
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;
use crate::scene::Photo;
use crate::task::Task;

/// How to export.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// The kind of file.
    pub format: ExportFormat,
    /// Pixels around the needed area that a layer keeps, within its rectangle; none: all of it.
    /// In a folder, layers are always whole, so that its `stack.json` holds for them.
    pub margin: Option<u32>,
    /// With a hidden guide in each group that has something to paint.
    pub guides: bool,
    /// Token of the image layer that is painted on when the file is opened, where the format can say so.
    pub selected: Option<String>,
    /// By photo, what its linear colours are multiplied with, R, G, B: for looking at, with no way back. Photos
    /// that are not in it are exported as they are.
    pub evened: BTreeMap<String, [f64; 3]>,
    /// What was decided about photos: layers are called so at once. None: as they were called when they were built.
    pub decisions: Option<Decisions>,
    /// Bytes that the photos under way may take together, about; one is always under way.
    pub memory: u64,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            format: ExportFormat::Psd,
            margin: Some(8),
            guides: true,
            selected: None,
            evened: BTreeMap::new(),
            decisions: None,
            memory: 1 << 30,
        }
    }
}

impl ExportOptions {
    fn layer_margin(&self) -> Option<u32> {
        self.margin.filter(|_| self.format != ExportFormat::Folder)
    }
}

/// What became of all photos, in their order.
#[derive(Debug, Default)]
pub struct Exported {
    /// Those that were written.
    pub done: Vec<ExportReport>,
    /// Those that were not, with the reason.
    pub failed: Vec<(String, Error)>,
}

/// The stages that are reported: of each photo, and of all.
pub const STAGE_READ: &str = "read photo";
/// See [`STAGE_READ`].
pub const STAGE_WRITE: &str = "write layers";
/// See [`STAGE_READ`].
pub const STAGE: &str = "export";

/// Exports the current stacks of `photos` from the project in the folder `project` to the folder `out`,
/// which is made if needed. A fault in one photo is in [`Exported::failed`], the others go on.
///
/// # Errors
/// [`Error::Request`] for a folder of even colour, whose `stack.json` would not hold for it; [`Error::Io`] when
/// `out` cannot be made or the records of former exports cannot be read; [`Error::Cancelled`].
pub fn export(
    project: &Path,
    photos: &[&Photo],
    out: &Path,
    options: &ExportOptions,
    task: &Task,
) -> Result<Exported> {
    if !options.evened.is_empty() && options.format == ExportFormat::Folder {
        return Err(Error::Request(
            "a folder is exported as the stack is; with --even-colour choose psd, xcf or ora".into(),
        ));
    }
    fs::create_dir_all(out).map_err(Error::io(out, "create the folder"))?;
    let records = ExportStore::new(project.join("exports"));
    let paint = PaintStore::new(project);
    let (known, problems) = records.read_all()?;
    problems.iter().for_each(|problem| task.note(problem.to_string()));
    let exporter = Exporter {
        stacks: StackStore::new(project),
        kept: Baselines::new(&project.join("exports")),
        book: paint.read()?,
        paint,
        records,
        written: WrittenFiles::of(&known),
        out,
        options,
    };
    let at_a_time =
        SideBySide { threads: rayon::current_num_threads(), memory: options.memory, stage: STAGE };
    let work = |photo: &&Photo| exporter.export(photo, &task.of(&photo.name));
    let results = at_a_time.run(photos, |photo| bytes_for(photo), work, task)?;
    let names: Vec<String> = photos.iter().map(|photo| photo.name.clone()).collect();
    let (done, failed) = done_and_failed(&names, results)?;
    exporter.records.forget_old_pixels(&exporter.kept)?;
    Ok(Exported { done, failed })
}

/// What a photo takes at its peak. Per pixel: the photo as RGBA, its merged picture and that compressed,
/// a guide; 16 bits at worst. And a batch of layers, before and after compression.
fn bytes_for(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 4 * 2 * 3 + (128 << 20)
}
