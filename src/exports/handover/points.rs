//! The points of structure from motion for other programs, with observations in the undistorted photos.

use std::path::Path;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use crate::handover::origin::Placement;
use quadratura_base::error::Result;
use quadratura_base::geometry::Undistortion;
use quadratura_base::scene::{Photo, PhotoPixels, SparsePoint};
use quadratura_base::task::Task;
use quadratura_handover::colmap::HandoverPoint;
use quadratura_import::photo::read_photo;
use quadratura_sites::known_names::cameras_of;
use quadratura_sites::open::Opened;

/// Fewer observations do not make a point.
const FEWEST: usize = 2;

/// Returns the points that at least two of `photos` observe within their undistorted pictures, as they are placed in the files, coloured
/// as the first of these shows them.
///
/// # Errors
/// Returns the errors of reading cameras and photos, or [`quadratura_base::Error::Cancelled`].
pub fn handover_points(
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    placement: &Placement,
    task: &Task,
) -> Result<Vec<HandoverPoint>> {
    if opened.points.is_empty() {
        return Ok(Vec::new());
    }
    let lenses = undistortions(project, opened, task)?;
    let place: FxHashMap<u32, usize> = photos
        .iter()
        .enumerate()
        .filter_map(|(place, photo)| Some((opened.site.photo_named(&photo.name)?.0, place)))
        .collect();
    let observed = |point: &SparsePoint| -> Vec<(usize, DVec2)> {
        let seen = point.observations.iter().filter_map(|&(photo, at)| {
            let place = *place.get(&photo)?;
            let at = match lenses.get(&photos[place].name) {
                Some(lens) => lens.pinhole_from_photo(at)?,
                None => at,
            };
            let camera = &photos[place].camera;
            let size = DVec2::new(camera.width.into(), camera.height.into());
            (at.cmpge(DVec2::ZERO).all() && at.cmplt(size).all()).then_some((place, at))
        });
        seen.collect()
    };
    let mut points: Vec<HandoverPoint> = Vec::new();
    for point in opened.points.iter() {
        let observations = observed(point);
        if observations.len() >= FEWEST {
            let error = mean_error(point.position, &observations, photos);
            points.push(HandoverPoint {
                position: placement.point(point.position),
                colour: [128; 3],
                error,
                observations,
            });
        }
    }
    colour(&mut points, photos, task)?;
    Ok(points)
}

/// Returns how the photos with distorted lenses were undistorted, by name.
fn undistortions(project: &Path, opened: &Opened, task: &Task) -> Result<FxHashMap<String, Undistortion>> {
    let cameras = cameras_of(project, &opened.project, task)?;
    let bent = cameras.photos.into_iter().filter(|photo| !photo.is_pinhole());
    Ok(bent.filter_map(|photo| Some((photo.name.clone(), photo.undistortion()?))).collect())
}

/// Returns the mean distance in pixels between observations and where the cameras show the point; 0 where none shows it.
fn mean_error(position: DVec3, observations: &[(usize, DVec2)], photos: &[&Photo]) -> f64 {
    let distance = |&(place, at): &(usize, DVec2)| {
        let photo = photos[place];
        Some(photo.camera.image_from_camera(photo.pose.camera_from_world(position))?.distance(at))
    };
    let distances: Vec<f64> = observations.iter().filter_map(distance).collect();
    if distances.is_empty() { 0.0 } else { distances.iter().sum::<f64>() / distances.len() as f64 }
}

/// Gives points the colour of the pixel where their first photo observes them.
fn colour(points: &mut [HandoverPoint], photos: &[&Photo], task: &Task) -> Result<()> {
    for (place, photo) in photos.iter().enumerate() {
        task.step("colours of points", place as u64, photos.len() as u64)?;
        let mut of_photo = points.iter_mut().filter(|point| point.observations[0].0 == place).peekable();
        if of_photo.peek().is_none() {
            continue;
        }
        let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
        of_photo.for_each(|point| point.colour = colour_at(&pixels, point.observations[0].1));
    }
    Ok(())
}

/// Returns the colour of the pixel at a position inside of the photo.
fn colour_at(pixels: &PhotoPixels, at: DVec2) -> [u8; 3] {
    let [r, g, b, _] = pixels.rgba16(at.x as u32, at.y as u32);
    [r, g, b].map(|value| (value >> 8) as u8)
}
