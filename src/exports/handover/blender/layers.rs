//! The image layers, exported as folders that are imported like those for image editors.

use std::path::Path;

use crate::handover::HandoverOptions;
use crate::handover::folder::HandoverFolder;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::export_record::ExportFormat;
use quadratura_editing::export::{ExportOptions, Exported, TreesInSite, export};
use quadratura_io::project::relative_to;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::open::Opened;

/// The folder of image layers.
const LAYERS: &str = "layers";

/// The stacks of the photos that are exported.
pub struct HandedStacks {
    pub store: StackStore,
    /// The stacks of all photos of the site, in its order.
    pub all: Vec<Option<Stack>>,
    /// The same, of the exported photos alone.
    pub chosen: Vec<Option<Stack>>,
    /// The folder of each photo's layers, relative to the export's, in the site's order; empty for others.
    pub folders: Vec<String>,
}

/// Returns the file name of the layer with this token.
pub fn file_of(token: &str) -> String {
    format!("{token}.png")
}

/// Exports the image layers of `photos`, and returns their stacks. Photos without a stack are left out, and so are those that fail.
///
/// # Errors
/// Returns the errors of reading and writing that concern all photos, [`Error::Missing`] when no photo has a stack, or
/// [`Error::Cancelled`].
pub fn handed_stacks(
    folder: &mut HandoverFolder,
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    options: &HandoverOptions,
    task: &Task,
) -> Result<HandedStacks> {
    let store = StackStore::new(project);
    let site = &opened.site;
    let all: Vec<Option<Stack>> =
        site.photos.iter().map(|photo| store.current(&photo.name)).collect::<Result<_>>()?;
    let stack_of = |photo: &Photo| site.photo_named(&photo.name).and_then(|id| all[id.index()].as_ref());
    let (with, without): (Vec<&Photo>, Vec<&Photo>) =
        photos.iter().copied().partition(|photo| stack_of(photo).is_some());
    if with.is_empty() {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    for photo in without {
        folder.leave_out(format!("the image layers of {}: it has no stack yet", photo.name));
    }
    let exporting = ExportOptions {
        format: ExportFormat::Folder,
        guides: false,
        for_scene: true,
        trees: None::<TreesInSite>,
        decisions: Some(opened.project.decisions.clone()),
        memory: options.memory,
        ..ExportOptions::default()
    };
    let Exported { done, failed } = export(project, &with, &folder.path().join(LAYERS), &exporting, task)?;
    for (photo, error) in failed {
        folder.fail(format!("{photo}: its image layers are not exported: {error}"));
    }
    let mut chosen: Vec<Option<Stack>> = vec![None; site.photos.len()];
    let mut folders = vec![String::new(); site.photos.len()];
    for report in done {
        let Some(id) = site.photo_named(&report.photo) else { continue };
        chosen[id.index()] = all[id.index()].clone();
        let path = relative_to(folder.path(), &report.path)?;
        folder.count(path.clone(), report.bytes);
        folders[id.index()] = path;
        report.problems.iter().for_each(|problem| task.note(problem));
    }
    Ok(HandedStacks { store, all, chosen, folders })
}
