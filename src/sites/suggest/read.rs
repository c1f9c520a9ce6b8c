//! Reads what a model is suggested from: cameras, points, and photos at the working size.

use std::path::Path;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::budget::default_memory;
use crate::known_names::cameras_of;
use crate::open::{Opened, open};
use crate::photos::found_photos;
use crate::side_by_side::ParallelPhotos;
use crate::thumbnail::reduced;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{PixelRect, Similarity};
use quadratura_base::raster::Image;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::{Model, Photo, PhotoPixels};
use quadratura_base::task::Task;
use quadratura_import::cameras::{CameraOptions, Cameras, read_cameras_as};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::framing::resized;
use quadratura_suggest::{FINE_PX, SourcePhoto, SourcePoint};

/// The stage that is reported.
const STAGE: &str = "read photos";

/// An observation that is farther off than this, in pixels, is an error and no part of its point.
const MOST_OFF_PX: f64 = 4.0;

/// A point whose observations are off by more than this on average tells nothing.
const MOST_ERROR_PX: f64 = 2.5;

/// What was read.
pub struct SuggestionSources {
    /// The cameras with their points.
    pub cameras: Cameras,
    /// The names of photos, and the photos, sorted by name.
    pub photos: Vec<(String, SourcePhoto)>,
    /// The model that is there.
    pub given: Option<PresentModel>,
    /// What could not be used.
    pub problems: Vec<Error>,
}

/// The model that is there, in the cameras' world.
pub struct PresentModel {
    /// The model, without what only stands for what is far away.
    pub model: Arc<Model>,
    /// The transform from the model's file.
    pub world_from_model: Similarity,
}

/// Reads a project, and its model where it stays.
pub fn of_project(folder: &Path, add: bool, task: &Task) -> Result<SuggestionSources> {
    let opened = open(folder, task)?;
    let mut sources = of_opened(folder, &opened, add, task)?;
    if let Some(problems) = Arc::into_inner(opened.problems) {
        sources.problems.splice(0..0, problems.errors);
    }
    Ok(sources)
}

/// Reads the photos and cameras of an opened project; its model stays with `add`.
pub fn of_opened(folder: &Path, opened: &Opened, add: bool, task: &Task) -> Result<SuggestionSources> {
    let cameras = cameras_of(folder, &opened.project, &Task::silent())?;
    let given = add.then(|| PresentModel {
        model: Arc::new(opened.site.model.without(|object| says_backdrop(&object.name))),
        world_from_model: opened.project.world_from_model,
    });
    let read = |photo: &Photo| read_unmasked(photo);
    let bytes = |photo: &Photo| 12 * u64::from(photo.camera.width) * u64::from(photo.camera.height);
    let (photos, problems) = seen(&opened.site.photos, bytes, |photo| photo, read, task)?;
    Ok(SuggestionSources { cameras, photos, given, problems })
}

/// Reads photos and cameras without a project; nothing is written.
pub fn of_folders(
    photos: &Path,
    cameras: &Path,
    options: &CameraOptions,
    task: &Task,
) -> Result<SuggestionSources> {
    let mut cameras = read_cameras_as(photos, cameras, options, task)?;
    cameras.notes.iter().for_each(|note| task.note(note));
    let (plans, notes, mut problems) = found_photos(&cameras, photos, task)?;
    notes.iter().for_each(|note| task.note(note));
    problems.splice(0..0, std::mem::take(&mut cameras.problems));
    if plans.is_empty() {
        let none = || Error::input(&cameras.file, "", "it lists no photo", "give the cameras of the photos");
        return Err(Error::of_all(problems).unwrap_or_else(none));
    }
    let bytes = |plan: &crate::photo_plan::PhotoPlan| {
        plan.memory() + 12 * u64::from(plan.photo.camera.width) * u64::from(plan.photo.camera.height)
    };
    let (photos, more) = seen(&plans, bytes, |plan| &plan.photo, |plan| plan.pixels(task), task)?;
    problems.extend(more);
    Ok(SuggestionSources { cameras, photos, given: None, problems })
}

/// Photos by name, and the problems with others.
type NamedPhotos = (Vec<(String, SourcePhoto)>, Vec<Error>);

/// Reads photos and reduces them, several at a time; a fault in one is its own.
fn seen<I: Sync>(
    items: &[I],
    bytes: impl Fn(&I) -> u64 + Sync,
    photo: impl Fn(&I) -> &Photo + Sync,
    read: impl Fn(&I) -> Result<PhotoPixels> + Sync,
    task: &Task,
) -> Result<NamedPhotos> {
    let at_a_time =
        ParallelPhotos { threads: rayon::current_num_threads(), memory: default_memory(), stage: STAGE };
    let work =
        |item: &I| read(item).map(|pixels| (photo(item).name.clone(), at_working_size(photo(item), &pixels)));
    let (mut photos, mut problems) = (Vec::new(), Vec::new());
    for result in at_a_time.run(items, bytes, work, task)? {
        match result {
            Ok(photo) => photos.push(photo),
            Err(error) => problems.push(error),
        }
    }
    photos.sort_by(|a, b| a.0.cmp(&b.0));
    Ok((photos, problems))
}

fn at_working_size(photo: &Photo, pixels: &PhotoPixels) -> SourcePhoto {
    let picture = reduced(pixels, FINE_PX);
    let rgba = picture.rgba.as_chunks::<4>().0.to_vec();
    let mut camera = resized(&photo.camera, picture.width, picture.height);
    // Sides are rounded one by one.
    let tall = f64::from(picture.height) / f64::from(photo.camera.height);
    (camera.fy, camera.cy) = (photo.camera.fy * tall, photo.camera.cy * tall);
    let pixels = Image::new(PixelRect::of_size(picture.width, picture.height), rgba);
    SourcePhoto { camera, pose: photo.pose, pixels }
}

/// Returns the points with their observers among the photos of these names, and the error of their observations.
pub fn seen_points(cameras: &Cameras, names: &[&str]) -> Vec<SourcePoint> {
    let number: FxHashMap<&str, u32> = names.iter().copied().zip(0..).collect();
    let numbers: Vec<Option<u32>> =
        cameras.photos.iter().map(|photo| number.get(photo.name.as_str()).copied()).collect();
    let seen = |point: &quadratura_base::scene::SparsePoint| {
        let mut observers = Vec::new();
        let (mut error_rad, mut error_px) = (0.0, 0.0);
        for (photo, at) in &point.observations {
            let Some(Some(number)) = numbers.get(*photo as usize) else { continue };
            let camera = &cameras.photos[*photo as usize];
            let Some(shown) = camera.image_from_world(point.position) else { continue };
            let off = shown.distance(*at);
            if off <= MOST_OFF_PX && !observers.contains(number) {
                observers.push(*number);
                error_px += off;
                error_rad += off.max(0.5) / camera.camera.fx;
            }
        }
        let count = observers.len() as f64;
        let is_tracked = !point.observations.is_empty();
        let usable = if is_tracked { observers.len() > 1 && error_px < MOST_ERROR_PX * count } else { true };
        // Of points without observations nothing is known; a pixel is usual.
        let unknown_rad = cameras.photos.first().map_or(1e-3, |photo| 1.0 / photo.camera.fx);
        let error_rad = if is_tracked { error_rad / count } else { unknown_rad };
        usable.then_some(SourcePoint { position: point.position, observers, error_rad })
    };
    cameras.points.iter().filter_map(seen).collect()
}
