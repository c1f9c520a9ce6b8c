//! Opening a project: cameras, photos and model are read and combined into a site.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::impostors::{RefusedImpostors, refused, turns, with_impostors};
use crate::known_names::{as_known, cameras_of};
use crate::masks::attach;
use crate::masks::beside::why_unread;
use crate::named::{meant, photos_named};
use crate::photos::{PhotoImport, import_photos};
use crate::see_through::with_see_through;
use quadratura_base::error::{Error, Message, Remedy, Result};
use quadratura_base::scene::{Model, Photo, Site, SparsePoint};
use quadratura_base::scene::{up, up_of};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::masks::{Mask, MaskOrigin};
use quadratura_import::cameras::{CameraPhoto, Cameras, Reprojection};
use quadratura_import::models::read_model;
use quadratura_io::mask_file::check_mask;
use quadratura_io::mask_store::MaskStore;
use quadratura_io::project::{PROJECT_FILE, read_project, resolved, respelled};

/// A project and the site that it describes. Functions take those parts of it that they use.
#[derive(Debug)]
pub struct Opened {
    /// The contents of `project.json`.
    pub project: Project,
    /// Photos, cameras and model in the cameras' world, without removed objects.
    pub site: Site,
    /// The complete model, including removed objects.
    pub whole: Arc<Model>,
    /// The points from structure from motion, in the cameras' world; their observations refer to indices of the
    /// site's photos.
    pub points: Arc<Vec<SparsePoint>>,
    /// How far the points' observations lie from where the cameras show them; `None` where too few are observed.
    pub reprojection: Option<Reprojection>,
    /// The photos that are not in the site, and why.
    pub problems: Arc<OpeningProblems>,
}

/// The photos that the cameras' files list and that are not in the opened site, and why.
#[derive(Debug, Default)]
pub struct OpeningProblems {
    /// The number of photos that the cameras' files list, with those that are not in the site.
    pub listed: usize,
    /// The problems of entries of the cameras' files, of photos and of masks, which are not used for that reason.
    pub errors: Vec<Error>,
    /// The photos with unusable files, by name, with the reason.
    pub left_out: Vec<(String, String)>,
    /// The unusable masks; their photos are left out.
    pub unmasked: Vec<UnusableMask>,
}

/// An unusable mask. Its photo is left out, because it would show what should be masked.
#[derive(Debug, Clone, PartialEq)]
pub struct UnusableMask {
    /// The photo that is left out.
    pub photo: Photo,
    /// The mask.
    pub mask: Mask,
    /// The problem with the mask.
    pub problem: String,
}

/// Opens the project in `folder`. Causes of missing photos are in [`Opened::problems`]; other findings are noted.
///
/// # Errors
/// Returns [`Error::Input`] and [`Error::Io`] for what concerns all photos: no project, no cameras, no model, or no
/// usable photo; all of them together in [`Error::Several`].
pub fn open(folder: &Path, task: &Task) -> Result<Opened> {
    let project = read_project(folder)?;
    open_site(folder, project, task)
}

/// Opens a project that is not on disk yet; see [`open`].
///
/// # Errors
/// Returns the errors of [`open`].
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
    let (photos, unmasked) = with_masks(folder, &project, import.photos, &cameras.photos, task);
    let reasons = import.problems.iter().map(ToString::to_string);
    let of_masks = unmasked.iter().map(|it| (it.photo.name.clone(), it.error().to_string()));
    let left_out = import.left_out.into_iter().zip(reasons).chain(of_masks).collect();
    let of_masks = unmasked.iter().map(UnusableMask::error);
    let errors = cameras.problems.into_iter().chain(import.problems).chain(of_masks).collect();
    let problems = Arc::new(OpeningProblems { listed: cameras.listed, errors, left_out, unmasked });
    let whole = Arc::new(model);
    let model = working_model(&whole, &photos, &project, task)?;
    let site = Site { photos, model };
    let points = Arc::new(points_of_photos(cameras.points, &cameras.photos, &site.photos));
    Ok(Opened { project, site, whole, points, reprojection: cameras.reprojection, problems })
}

impl Opened {
    /// Returns which objects of the complete model cannot turn towards cameras although they are to.
    pub fn refused_impostors(&self) -> RefusedImpostors {
        let (project, up) = (&self.project, up(&self.site.photos));
        refused(&self.whole, up, &project.world_from_model, &project.impostors)
    }

    /// Returns the same site with another project, which is in `folder`. The two projects must be equal in
    /// everything that the site is made from (files, the model's transform), except the photos' masks.
    pub fn with_project(&self, folder: &Path, project: Project) -> Self {
        let mut site = self.site.clone();
        attach(folder, &project.masks, &mut site.photos);
        Self {
            project,
            site,
            whole: self.whole.clone(),
            points: self.points.clone(),
            reprojection: self.reprojection.clone(),
            problems: self.problems.clone(),
        }
    }

    /// Returns the same site with a project that differs in the removed objects and in nothing else that the site
    /// is made from. No file is read.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when no object would remain.
    pub fn with_objects(&self, folder: &Path, project: Project, task: &Task) -> Result<Self> {
        let model = working_model(&self.whole, &self.site.photos, &project, task)?;
        let mut opened = self.with_project(folder, project);
        opened.site.model = model;
        Ok(opened)
    }

    /// Returns the photos that `names` refer to; see [`photos_named`].
    ///
    /// # Errors
    /// Returns [`Error::Request`]; for photos with unusable files it contains the reason.
    pub fn photos_named(&self, names: &[String]) -> Result<Vec<&Photo>> {
        photos_named(&self.site, names).map_err(|unknown| {
            let known = &self.problems.left_out;
            let photos: Vec<&str> = known.iter().map(|(photo, _)| photo.as_str()).collect();
            let mut left_out: Vec<usize> = names.iter().flat_map(|name| meant(name, &photos)).collect();
            left_out.sort_unstable();
            left_out.dedup();
            let reasons = left_out.into_iter().map(|index| &known[index]);
            let reasons =
                reasons.map(|(photo, why)| Error::Request(format!("photo {photo} is left out: {why}")));
            Error::of_all(reasons.collect()).unwrap_or(unknown)
        })
    }
}

/// Adds the masks to the photos. Photos with an unusable mask are left out, because they would show what should be
/// masked; these masks are returned as well.
fn with_masks(
    folder: &Path,
    project: &Project,
    mut photos: Vec<Photo>,
    cameras: &[CameraPhoto],
    task: &Task,
) -> (Vec<Photo>, Vec<UnusableMask>) {
    let (masks, store) = (&project.masks, MaskStore::new(folder));
    attach(folder, masks, &mut photos);
    let known = |name: &str| photos.iter().any(|photo| photo.name == name);
    for (name, _) in masks.photos().filter(|(name, _)| !known(name)) {
        task.note(format!("project.json has masks of {name}, which is not among the photos"));
    }
    let mut masked = Vec::with_capacity(photos.len());
    let mut unmasked = Vec::new();
    for photo in photos {
        let size = [photo.camera.width, photo.camera.height];
        let problem = |mask: &Mask| match &mask.from {
            MaskOrigin::File(name) if mask.is_unread() => {
                let camera = cameras.iter().find(|camera| camera.name == photo.name)?;
                Some(why_unread(&resolved(folder, &project.photos), name, camera))
            }
            _ => check_mask(&store.path(&mask.file), size).err().map(|problem| problem.to_string()),
        };
        let found: Vec<(&Mask, String)> =
            masks.of(&photo.name).iter().filter_map(|mask| Some((mask, problem(mask)?))).collect();
        if found.is_empty() {
            masked.push(photo);
        } else {
            let of_one = |(mask, problem): (&Mask, String)| UnusableMask {
                photo: photo.clone(),
                mask: mask.clone(),
                problem,
            };
            unmasked.extend(found.into_iter().map(of_one));
        }
    }
    (masked, unmasked)
}

impl UnusableMask {
    /// Returns the error for the command line.
    pub fn error(&self) -> Error {
        let (photo, problem) = (&self.photo.name, &self.problem);
        let found = format!("{photo} is left out, because a mask of it cannot be used: {problem}");
        if self.mask.is_unread() {
            let read = Message::from((format!("{found}; then "), Remedy::FindMasks, " reads it, or "));
            return Error::missing(read.and(Remedy::ClearMasks).and(" has the photo used without it"));
        }
        Error::missing((
            format!("{found}. "),
            Remedy::ClearMasks,
            " removes its masks, which can be created again",
        ))
    }
}

/// Returns the model without removed objects, in which impostors turn, and what one sees through is marked.
fn working_model(whole: &Arc<Model>, photos: &[Photo], project: &Project, task: &Task) -> Result<Arc<Model>> {
    let model = without_removed(whole, project, task)?;
    let model = with_impostors(model, photos, &project.world_from_model, &project.impostors, task);
    Ok(with_see_through(model, &project.see_through, task))
}

/// Returns the model without removed objects.
fn without_removed(whole: &Arc<Model>, project: &Project, task: &Task) -> Result<Arc<Model>> {
    let off = project.objects_left_out();
    if off.is_empty() {
        return Ok(whole.clone());
    }
    for name in off.iter().filter(|name| whole.objects.iter().all(|object| object.name != ***name)) {
        let what = if project.objects_off.contains(*name) { "removes" } else { "has a tree in place of" };
        task.note(format!("project.json {what} the object {name:?}, which the model does not have"));
    }
    let working = whole.without(|object| off.contains(&object.name));
    if working.faces.is_empty() {
        let found = "all objects are removed from the model in this project";
        return Err(Error::missing((format!("{found}; "), Remedy::RestoreObject, " restores one")));
    }
    Ok(Arc::new(working))
}

/// Reads the complete model of a project in the cameras' world, including removed objects.
///
/// # Errors
/// Returns the errors of [`open`].
pub fn whole_model(folder: &Path, project: &Project, task: &Task) -> Result<Model> {
    read_world_model(folder, project, task)
}

/// Returns which objects of the complete model cannot turn towards cameras although they are to. Only the cameras are read
/// for it, which know what is up; where they cannot be read nothing is refused, and commands that need them say why.
pub fn refused_impostors(folder: &Path, project: &Project, whole: &Model, task: &Task) -> RefusedImpostors {
    if !whole.objects.iter().any(|object| turns(object, &project.impostors)) {
        return RefusedImpostors::new();
    }
    let Ok(cameras) = cameras_of(folder, project, task) else { return RefusedImpostors::new() };
    let up = up_of(cameras.photos.iter().map(|photo| &photo.pose));
    refused(whole, up, &project.world_from_model, &project.impostors)
}

/// Converts observations from indices of the cameras' file to indices of `photos`. Observations in missing photos
/// are dropped.
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

/// Reads the cameras and imports their photos.
fn read_pictures(folder: &Path, project: &Project, task: &Task) -> Result<(Cameras, PhotoImport)> {
    let file = resolved(folder, &project.cameras);
    let photo_folder = resolved(folder, &project.photos);
    let cameras = task.timed("read cameras", || cameras_of(folder, project, task));
    // A wrong photo folder is reported even where the cameras are wrong, too.
    let missing = (!photo_folder.is_dir()).then(|| no_such_folder(folder, &photo_folder));
    let cameras = match (cameras, missing) {
        (Ok(cameras), None) => cameras,
        (cameras, missing) => {
            let errors = cameras.err().into_iter().chain(missing).collect();
            return Err(Error::of_all(errors).expect("one of the two has failed"));
        }
    };
    let paths = [&project.photos, &project.cameras].map(|path| respelled(folder, path));
    paths.iter().flatten().chain(&cameras.notes).for_each(|note| task.note(note));
    let import =
        task.timed("import photos", || import_photos(&cameras, &photo_folder, &folder.join("cache"), task))?;
    import.notes.iter().for_each(|note| task.note(note));
    if import.photos.is_empty() {
        return Err(Error::of_all(cameras.problems.into_iter().chain(import.problems).collect())
            .unwrap_or_else(|| {
                Error::input(file, "", "it lists no photo", "give the cameras of the photos")
            }));
    }
    Ok((cameras, import))
}

/// Makes the error for a missing photo folder.
fn no_such_folder(project: &Path, photos: &Path) -> Error {
    let file = project.join(PROJECT_FILE);
    let remedy = match file.is_file() {
        true => format!("restore it, or set \"photos\" in {} to the folder with the photos", file.display()),
        false => "give the folder of the photos".to_owned(),
    };
    let found =
        if photos.exists() { "this is a file, expected a folder" } else { "this folder does not exist" };
    Error::input(photos, "", found, remedy)
}

/// Reads the model and transforms it to the cameras' world.
fn read_world_model(folder: &Path, project: &Project, task: &Task) -> Result<Model> {
    let file = resolved(folder, &project.model);
    let (mut model, notes) = task.timed("read model", || read_model(&file, task))?;
    let renamed = as_known(folder, project, &mut model);
    let path = respelled(folder, &project.model);
    path.into_iter().chain(notes).chain(renamed).for_each(|note| task.note(note));
    Ok(model.transformed(&project.world_from_model))
}
