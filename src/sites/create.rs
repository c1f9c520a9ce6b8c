//! Creating a project: all inputs are read and checked before anything is written.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::dome_picture::chosen_picture;
use crate::masks::beside::{FoundMask, MasksBeside, UnreadMask, masks_beside};
use crate::masks::{MaskEdit, attach, edited};
use crate::open::{Opened, open_site};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::project::PROJECT_VERSION;
use quadratura_files::lock::{LOCK_FILE, ProjectLock};
use quadratura_import::cameras::{CameraOptions, check_exists};
use quadratura_io::project::{check_is_empty, relative_to, write_project};
use quadratura_layers::Options;
use quadratura_layers::fill::{FillOptions, Propagation};

/// The inputs of a new project. Paths are relative to the working folder.
#[derive(Debug, Clone, Default)]
pub struct NewProject {
    /// The folder of the photos.
    pub photos: PathBuf,
    /// The cameras: a file or a folder of one of the formats that are read.
    pub cameras: PathBuf,
    /// The model's file.
    pub model: PathBuf,
    /// What is read of the cameras.
    pub camera_options: CameraOptions,
    /// The transform from the model to the cameras' world.
    pub world_from_model: Similarity,
    /// The options for building stacks.
    pub options: Options,
    /// A picture of the surroundings, and the direction of its middle in the cameras' world, which is decided where
    /// none is given.
    pub surroundings: Option<(PathBuf, Option<[f64; 3]>)>,
}

/// Creates a project in `folder`, which has to be new or empty. On failure `folder` is left as it was.
///
/// # Errors
/// Returns [`Error::Request`] when the folder is not empty; otherwise the errors of [`crate::open::open`].
pub fn create_project(folder: &Path, new: &NewProject, task: &Task) -> Result<Opened> {
    let was_there = folder.exists();
    check_is_empty(folder)?;
    fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let lock = ProjectLock::take(folder)?;
    // Another program may have created files in the meantime.
    check_is_empty(folder)?;
    let created = fill(folder, new, task);
    drop(lock);
    if created.is_err() {
        leave_as_it_was(folder, was_there);
    }
    created
}

/// Opens the described site, adopts masks found beside the photos, and writes the project file.
fn fill(folder: &Path, new: &NewProject, task: &Task) -> Result<Opened> {
    let mut opened = open_site(folder, described(folder, new)?, task)?;
    let MasksBeside { found, unread, problems } = masks_beside(folder, &opened.project, &opened.site, task)?;
    found.iter().for_each(|found| task.with_subject(&found.photo).note(format!("masked by {}", found.file)));
    if let Some((file, middle)) = &new.surroundings {
        opened.project.surroundings = Some(chosen_picture(folder, &opened.site, file, *middle, task)?);
    }
    let edits = unread.iter().map(UnreadMask::edit).chain(found.into_iter().map(FoundMask::edit));
    let edits: Vec<MaskEdit> = edits.collect();
    opened.project.masks = edited(folder, &opened.project.masks, &edits, &opened.site)?;
    attach(folder, &opened.project.masks, &mut opened.site.photos);
    write_project(folder, &opened.project)?;
    if !unread.is_empty() {
        // Photos whose masks cannot be used are left out; what there is to note was noted.
        opened = open_site(folder, opened.project, &Task::silent())?;
    }
    Arc::get_mut(&mut opened.problems).expect("no clone of them exists yet").errors.extend(problems);
    Ok(opened)
}

/// Describes the new project with paths relative to its folder.
fn described(folder: &Path, new: &NewProject) -> Result<Project> {
    let path = |path: &Path| relative_to(folder, path);
    let photos = path(&new.photos);
    let cameras = check_exists(&new.cameras).and_then(|()| path(&new.cameras));
    let model = path(&new.model);
    match (photos, cameras, model) {
        (Ok(photos), Ok(cameras), Ok(model)) => Ok(Project {
            version: PROJECT_VERSION,
            photos,
            cameras,
            model,
            chunk: new.camera_options.chunk.clone(),
            rolling_shutter: new.camera_options.rolling_shutter,
            world_from_model: new.world_from_model,
            options: new.options.clone(),
            // Paint is seen from everywhere; projects of before are asked.
            fill: FillOptions { propagate: Propagation::all(), ..FillOptions::default() },
            ..Project::default()
        }),
        (photos, cameras, model) => {
            let errors = [photos.err(), cameras.err(), model.err()].into_iter().flatten().collect();
            Err(Error::of_all(errors).expect("one of the three has failed"))
        }
    }
}

/// Removes what a failed attempt created. Files that cannot be removed stay, because the user already gets the
/// failure's reason.
fn leave_as_it_was(folder: &Path, was_there: bool) {
    if was_there {
        let _ = fs::remove_dir_all(folder.join("cache"));
        let _ = fs::remove_dir_all(folder.join("masks"));
        let _ = fs::remove_file(folder.join(LOCK_FILE));
    } else {
        let _ = fs::remove_dir_all(folder);
    }
}
