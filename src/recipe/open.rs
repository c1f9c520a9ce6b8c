//! A project's folder becomes a site: cameras, photos and model are read and brought together.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::masks::attach;
use super::named::{is_short_for, photos_named};
use super::photos::{PhotoImport, import_photos};
use crate::document::masks::Mask;
use crate::document::{Masks, Project};
use crate::error::{Error, Result};
use crate::io::cameras::{CameraPhoto, Cameras, read_cameras_of};
use crate::io::mask_file::check_mask;
use crate::io::models::read_model;
use crate::io::project::{PROJECT_FILE, read_project, resolved};
use crate::scene::{Model, Photo, Site, SparsePoint};
use crate::task::Task;

/// A project and the site that it describes.
#[derive(Debug)]
pub struct Opened {
    /// What `project.json` says.
    pub project: Project,
    /// Photos, cameras and model, in the cameras' world; without objects that are switched off.
    pub site: Site,
    /// The model with objects that are switched off, too.
    pub whole: Arc<Model>,
    /// What structure from motion triangulated, in the cameras' world; observations count through
    /// the site's photos.
    pub points: Arc<Vec<SparsePoint>>,
    /// Why photos of the cameras' file are not in the site; one each.
    pub problems: Arc<Vec<Error>>,
    /// Photos whose files cannot be used, by name, with the reason.
    pub left_out: Vec<(String, String)>,
    /// Masks that cannot be used; their photos are left out.
    pub unmasked: Arc<Vec<Unmasked>>,
}

/// A mask that cannot be used: its photo would show what it must not.
#[derive(Debug, Clone, PartialEq)]
pub struct Unmasked {
    /// The photo that is left out.
    pub photo: Photo,
    /// Its mask.
    pub mask: Mask,
    /// What is wrong with that.
    pub problem: String,
}

/// Opens the project in `folder`. What leaves something out is in `problems`, what does not is noted.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] for what concerns all photos: no project, no cameras, no
/// model, or not one photo that can be used; all of them in one [`Error::Several`].
pub fn open(folder: &Path, task: &Task) -> Result<Opened> {
    let project = read_project(folder)?;
    open_site(folder, project, task)
}

/// The same for a project that is not on disk yet.
///
/// # Errors
/// As [`open`].
pub fn open_site(folder: &Path, project: Project, task: &Task) -> Result<Opened> {
    let (pictures, model) =
        rayon::join(|| read_pictures(folder, &project, task), || read_world_model(folder, &project, task));
    let ((cameras, import), model) = match (pictures, model) {
        (Ok(pictures), Ok(model)) => (pictures, model),
        (pictures, model) => {
            let errors = [pictures.err(), model.err()].into_iter().flatten().collect();
            return Err(Error::of_all(errors).expect("one of the two has failed"));
        }
    };
    let (photos, unmasked) = with_masks(folder, &project.masks, import.photos, task);
    let reasons = import.problems.iter().map(ToString::to_string);
    let of_masks = unmasked.iter().map(|it| (it.photo.name.clone(), it.error().to_string()));
    let left_out = import.left_out.into_iter().zip(reasons).chain(of_masks).collect();
    let of_masks = unmasked.iter().map(Unmasked::error);
    let problems = Arc::new(cameras.problems.into_iter().chain(import.problems).chain(of_masks).collect());
    let unmasked = Arc::new(unmasked);
    let whole = Arc::new(model);
    let site = Site { photos, model: working_model(&whole, &project, task)? };
    let points = Arc::new(points_of_photos(cameras.points, &cameras.photos, &site.photos));
    Ok(Opened { project, site, whole, points, problems, left_out, unmasked })
}

impl Opened {
    /// The same site with another project, which is in `folder`: one that differs in nothing that the site is made of
    /// (files, place of the model), but for the masks of its photos.
    pub fn with_project(&self, folder: &Path, project: Project) -> Self {
        let mut site = self.site.clone();
        attach(folder, &project.masks, &mut site.photos);
        Self {
            project,
            site,
            whole: self.whole.clone(),
            points: self.points.clone(),
            problems: self.problems.clone(),
            left_out: self.left_out.clone(),
            unmasked: self.unmasked.clone(),
        }
    }

    /// The same with a project that differs in the objects that are switched off, and in nothing else that the site is
    /// made of. No file is read.
    ///
    /// # Errors
    /// [`Error::Request`] when nothing would be left of the model.
    pub fn with_objects(&self, folder: &Path, project: Project, task: &Task) -> Result<Self> {
        let model = working_model(&self.whole, &project, task)?;
        let mut opened = self.with_project(folder, project);
        opened.site.model = model;
        Ok(opened)
    }

    /// The photos that `names` ask for: [`photos_named`].
    ///
    /// # Errors
    /// [`Error::Request`]; for photos whose files cannot be used, why.
    pub fn photos_named(&self, names: &[String]) -> Result<Vec<&Photo>> {
        photos_named(&self.site, names).map_err(|unknown| {
            let is_meant = |photo: &str| names.iter().any(|name| name == photo || is_short_for(name, photo));
            let reasons = self.left_out.iter().filter(|(photo, _)| is_meant(photo));
            let reasons =
                reasons.map(|(photo, why)| Error::Request(format!("photo {photo} is left out: {why}")));
            Error::of_all(reasons.collect()).unwrap_or(unknown)
        })
    }
}

/// The photos with their masks; and the masks that cannot be used, whose photos would show what they must not.
fn with_masks(
    folder: &Path,
    masks: &Masks,
    mut photos: Vec<Photo>,
    task: &Task,
) -> (Vec<Photo>, Vec<Unmasked>) {
    attach(folder, masks, &mut photos);
    let known = |name: &str| photos.iter().any(|photo| photo.name == name);
    for (name, _) in masks.photos().filter(|(name, _)| !known(name)) {
        task.note(format!("project.json has masks of {name}, which is not among the photos"));
    }
    let (mut masked, mut unmasked) = (Vec::with_capacity(photos.len()), Vec::new());
    for photo in photos {
        let size = [photo.camera.width, photo.camera.height];
        let of_photo = masks.of(&photo.name).iter().zip(&photo.masks);
        let unusable = of_photo.filter_map(|(mask, file)| Some((mask, check_mask(file, size).err()?)));
        let found: Vec<(&Mask, String)> =
            unusable.map(|(mask, problem)| (mask, problem.to_string())).collect();
        if found.is_empty() {
            masked.push(photo);
        } else {
            let of_one = |(mask, problem): (&Mask, String)| Unmasked {
                photo: photo.clone(),
                mask: mask.clone(),
                problem,
            };
            unmasked.extend(found.into_iter().map(of_one));
        }
    }
    (masked, unmasked)
}

impl Unmasked {
    /// As the command line tells it.
    pub fn error(&self) -> Error {
        let (photo, problem) = (&self.photo.name, &self.problem);
        Error::Request(format!(
            "{photo} is left out, because a mask of it cannot be used: {problem}. `quadratura mask --clear` takes its \
             masks away; --find, --add and --object make them again"
        ))
    }
}

/// Without the objects that are switched off.
fn working_model(whole: &Arc<Model>, project: &Project, task: &Task) -> Result<Arc<Model>> {
    let off = &project.objects_off;
    if off.is_empty() {
        return Ok(whole.clone());
    }
    for name in off.iter().filter(|name| whole.objects.iter().all(|object| object.name != **name)) {
        task.note(format!("project.json switches off {name:?}, which the model does not have"));
    }
    let working = whole.without(|object| off.contains(&object.name));
    if working.faces.is_empty() {
        let found = "all objects of the model are switched off";
        return Err(Error::Request(format!("{found}; `quadratura object --on NAME` brings one back")));
    }
    Ok(Arc::new(working))
}

/// The whole model of a project in the cameras' world, with what is switched off.
///
/// # Errors
/// As [`open`].
pub fn whole_model(folder: &Path, project: &Project, task: &Task) -> Result<Model> {
    read_world_model(folder, project, task)
}

/// The points, with observations that count through `photos` instead of the cameras' file. Those of
/// photos that are not there are left out.
fn points_of_photos(
    mut points: Vec<SparsePoint>,
    cameras: &[CameraPhoto],
    photos: &[Photo],
) -> Vec<SparsePoint> {
    let index: BTreeMap<&str, u32> = photos.iter().map(|photo| photo.name.as_str()).zip(0..).collect();
    let renumbered: Vec<Option<u32>> =
        cameras.iter().map(|photo| index.get(photo.name.as_str()).copied()).collect();
    for point in &mut points {
        point.observations.retain_mut(|(photo, _)| {
            let found = renumbered.get(*photo as usize).copied().flatten();
            *photo = found.unwrap_or(*photo);
            found.is_some()
        });
    }
    points
}

fn read_pictures(folder: &Path, project: &Project, task: &Task) -> Result<(Cameras, PhotoImport)> {
    let file = resolved(folder, &project.cameras);
    let photo_folder = resolved(folder, &project.photos);
    let cameras = task.timed("read cameras", || read_cameras_of(&photo_folder, &file, task));
    // A wrong photo folder is worth knowing even where the cameras are wrong, too.
    let missing = (!photo_folder.is_dir()).then(|| no_such_folder(folder, &photo_folder));
    let cameras = match (cameras, missing) {
        (Ok(cameras), None) => cameras,
        (cameras, missing) => {
            let errors = cameras.err().into_iter().chain(missing).collect();
            return Err(Error::of_all(errors).expect("one of the two has failed"));
        }
    };
    cameras.notes.iter().for_each(|note| task.note(note));
    let import =
        task.timed("import photos", || import_photos(&cameras, &photo_folder, &folder.join("cache"), task))?;
    import.notes.iter().for_each(|note| task.note(note));
    if import.photos.is_empty() {
        return Err(Error::of_all(cameras.problems.into_iter().chain(import.problems).collect())
            .unwrap_or_else(|| {
                Error::input(file, "", "it names no photo", "give the cameras of the photos")
            }));
    }
    Ok((cameras, import))
}

fn no_such_folder(project: &Path, photos: &Path) -> Error {
    let file = project.join(PROJECT_FILE);
    let remedy = match file.is_file() {
        true => format!("bring it back, or say as \"photos\" in {} where the photos are now", file.display()),
        false => "give the folder of the photos".to_owned(),
    };
    Error::input(photos, "", "there is no such folder", remedy)
}

fn read_world_model(folder: &Path, project: &Project, task: &Task) -> Result<Model> {
    let file = resolved(folder, &project.model);
    let (model, notes) = task.timed("read model", || read_model(&file, task))?;
    notes.iter().for_each(|note| task.note(note));
    Ok(model.transformed(&project.world_from_model))
}
