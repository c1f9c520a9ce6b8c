//! Validates what the parsers read and keeps what can be used.

use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec2};
use rustc_hash::{FxHashMap, FxHashSet};

use super::photo_name::{objection, short};
use super::{CameraPhoto, Cameras, Files, LARGEST_SIDE, MOST_PIXELS, Problems, RawCamera, RawImage};
use crate::error::{Error, Result};
use crate::geometry::{Lens, Pinhole, Pose};
use crate::scene::SparsePoint;

/// A finding that refuses a record, and what to do about it.
type Objection = (String, &'static str);

/// Collects raw cameras, then images, then points, in file order.
pub(super) struct Assembly {
    cameras_file: PathBuf,
    images_file: PathBuf,
    points_file: PathBuf,
    /// Cameras by number; `None` for a camera that is in the file but cannot be used.
    cameras: FxHashMap<u32, Option<(Pinhole, Lens)>>,
    image_ids: FxHashSet<u32>,
    names: FxHashSet<String>,
    photos: Vec<CameraPhoto>,
    observations: FxHashMap<u64, Vec<(u32, DVec2)>>,
    point_ids: FxHashSet<u64>,
    points: Vec<SparsePoint>,
    problems: Problems,
    notes: Vec<String>,
}

impl Assembly {
    pub fn new(files: &Files) -> Self {
        Self {
            cameras_file: files.cameras.clone(),
            images_file: files.images.clone(),
            points_file: files.points.clone().unwrap_or_default(),
            cameras: FxHashMap::default(),
            image_ids: FxHashSet::default(),
            names: FxHashSet::default(),
            photos: Vec::new(),
            observations: FxHashMap::default(),
            point_ids: FxHashSet::default(),
            points: Vec::new(),
            problems: Problems::default(),
            notes: Vec::new(),
        }
    }

    /// Adds a note for the user about something that leaves nothing out.
    pub fn note(&mut self, text: String) {
        self.notes.push(text);
    }

    /// Adds a problem that leaves one camera, photo or point out.
    pub fn problem(&mut self, file: &Path, place: String, (found, remedy): Objection) {
        self.problems.push(file, Error::input(file, place, found, remedy));
    }

    /// Adds a camera.
    pub fn camera(&mut self, place: String, raw: &RawCamera<'_>) {
        let checked = if self.cameras.contains_key(&raw.id) {
            Err((format!("camera {} appears twice", raw.id), "keep one; the first is used"))
        } else {
            checked_camera(raw)
        };
        match checked {
            Ok(camera) => {
                self.cameras.insert(raw.id, Some(camera));
            }
            Err(objection) => self.refused_camera(raw.id, place, objection),
        }
    }

    /// Adds a camera that could not be parsed; photos that use it are then reported, too.
    pub fn refused_camera(&mut self, id: u32, place: String, objection: Objection) {
        self.cameras.entry(id).or_insert(None);
        self.problem(&self.cameras_file.clone(), place, objection);
    }

    /// Adds a photo and its observations.
    pub fn image(&mut self, place: String, raw: RawImage<'_>) {
        match self.checked_image(&raw) {
            Ok((camera, lens, pose)) => {
                let name = raw.name.to_owned();
                let index = self.photos.len() as u32;
                self.image_ids.insert(raw.id);
                self.names.insert(name.clone());
                self.photos.push(CameraPhoto { name, camera, lens, pose, place });
                for (at, point) in raw.observations {
                    self.observations.entry(point).or_default().push((index, at.into()));
                }
            }
            Err(objection) => self.problem(&self.images_file.clone(), place, objection),
        }
    }

    fn checked_image(&self, raw: &RawImage<'_>) -> Result<(Pinhole, Lens, Pose), Objection> {
        if let Some(objection) = objection(raw.name) {
            return Err(objection);
        }
        let name = short(raw.name);
        if self.image_ids.contains(&raw.id) {
            let found = format!("{name} has the number {} of an earlier photo", raw.id);
            return Err((found, "give each photo its own number; the first is used"));
        }
        if self.names.contains(raw.name) {
            return Err((format!("{name} appears twice"), "keep one; the first is used"));
        }
        let (camera, lens) = match self.cameras.get(&raw.camera) {
            Some(Some(camera)) => *camera,
            Some(None) => {
                let found = format!("{name} uses camera {}, which cannot be used", raw.camera);
                return Err((found, "correct that camera, see above"));
            }
            None => {
                let found = format!("{name} uses camera {}, which is not in the cameras file", raw.camera);
                return Err((found, "use cameras and images files of the same reconstruction"));
            }
        };
        Ok((camera, lens, pose(raw).map_err(|(found, remedy)| (format!("{name}: {found}"), remedy))?))
    }

    /// Adds a point; points that no photo in the list observes are kept, too.
    pub fn point(&mut self, place: String, id: u64, position: [f64; 3]) {
        let objection = if !is_in_range(position) {
            Some((format!("point {id} at {position:?}, not within 1e15 of the origin"), "remove the point"))
        } else if !self.point_ids.insert(id) {
            Some((format!("point {id} appears twice"), "keep one; the first is used"))
        } else {
            None
        };
        if let Some(objection) = objection {
            return self.problem(&self.points_file.clone(), place, objection);
        }
        let observations = self.observations.remove(&id).unwrap_or_default();
        self.points.push(SparsePoint { position: position.into(), observations });
    }

    /// Returns everything that was kept.
    ///
    /// # Errors
    /// [`Error::Input`] when no photo can be used: the first problem, or that the file is empty.
    pub fn finish(self, mut notes: Vec<String>) -> Result<Cameras> {
        let Self { images_file: file, photos, points, problems, .. } = self;
        notes.extend(self.notes);
        let problems = problems.finish();
        if photos.is_empty() {
            let remedy = "use a reconstruction in which photos were registered";
            let empty = || Error::input(file, "", "it lists no photo", remedy);
            return Err(problems.into_iter().next().unwrap_or_else(empty));
        }
        Ok(Cameras { file, photos, points, problems, notes })
    }
}

fn checked_camera(raw: &RawCamera<'_>) -> Result<(Pinhole, Lens), Objection> {
    let camera = |found: String| format!("camera {}: {found}", raw.id);
    if raw.model.is_spherical() {
        let remedy = "cut the panorama into pinhole views first (COLMAP's panorama script does)";
        return Err((camera("a spherical panorama (EQUIRECTANGULAR) is not a pinhole image".into()), remedy));
    }
    let (width, height) = (raw.width, raw.height);
    let sides = 1..=LARGEST_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) || width * height > MOST_PIXELS {
        let found = format!("{width} x {height} pixels");
        return Err((camera(found), "sides are 1 to 65535 pixels, and the photo up to 268 megapixels"));
    }
    let expected = raw.model.parameter_count();
    if raw.parameters.len() != expected {
        let (name, wanted) = (raw.model.name, raw.model.parameters);
        let found = format!("{} parameters where {name} has {expected} ({wanted})", raw.parameters.len());
        return Err((camera(found), "write all of them, in this order"));
    }
    if let Some(value) = raw.parameters.iter().find(|value| !value.is_finite()) {
        return Err((camera(format!("a parameter is {value}")), "calibrate the camera again"));
    }
    let (pinhole, lens) = raw.model.camera(width as u32, height as u32, raw.parameters);
    sensible(&pinhole, &lens).map_err(|(found, remedy)| (camera(found), remedy))?;
    Ok((pinhole, lens))
}

/// Refuses values that make computation impossible; unusual but possible ones pass.
fn sensible(camera: &Pinhole, lens: &Lens) -> Result<(), Objection> {
    let side = f64::from(camera.width.max(camera.height));
    for focal_length in [camera.fx, camera.fy] {
        // From 179.9 degrees of view to 20 arc seconds.
        if !(focal_length > 1e-3 * side && focal_length < 1e4 * side) {
            return Err((format!("a focal length of {focal_length} pixels"), "calibrate the camera again"));
        }
    }
    for (center, side) in [(camera.cx, camera.width), (camera.cy, camera.height)] {
        // A principal point outside the photo is normal for a crop, but not this far outside.
        if center.abs() > 100.0 * f64::from(side) {
            return Err((format!("a principal point at {center} pixels"), "calibrate the camera again"));
        }
    }
    match *lens {
        Lens::Eucm { alpha, beta } if !(0.0..=1.0).contains(&alpha) || beta <= 0.0 => {
            let found = format!("EUCM with alpha {alpha}, beta {beta}");
            Err((found, "alpha is from 0 to 1 and beta positive"))
        }
        Lens::Fov { omega } if omega.abs() >= std::f64::consts::PI => {
            Err((format!("FOV with omega {omega}"), "omega is an angle below pi"))
        }
        _ => Ok(()),
    }
}

fn pose(raw: &RawImage<'_>) -> Result<Pose, Objection> {
    let [w, x, y, z] = raw.quaternion;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    // Also false for a length that is not a number.
    if !(length > 1e-6 && length < 1e6) {
        let found = format!("the rotation {:?} is not a valid quaternion", raw.quaternion);
        return Err((found, "write QW QX QY QZ of length 1"));
    }
    if !is_in_range(raw.translation) {
        let found = format!("the position {:?} is not within 1e15 of the origin", raw.translation);
        return Err((found, "write TX TY TZ as numbers in the model's unit"));
    }
    let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
    Ok(Pose { rotation, translation: raw.translation.into() })
}

/// Returns whether coordinates are small enough to compute with: beyond 1e15 positions lose whole units and
/// their products overflow. The same limit applies to models.
fn is_in_range(position: [f64; 3]) -> bool {
    position.iter().all(|v| v.abs() <= 1e15)
}
