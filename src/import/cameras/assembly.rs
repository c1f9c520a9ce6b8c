//! Judges what the parsers found and keeps what can be used.

use std::path::{Path, PathBuf};

use glam::DVec2;
use rustc_hash::{FxHashMap, FxHashSet};

use super::kept::{CameraPhoto, Cameras, LARGEST_SIDE, MOST_PIXELS};
use super::options::CameraOptions;
use super::photo_name::{objection, short};
use super::photo_paths::PhotoPath;
use super::pose::is_on_a_map;
use super::raw::{Problems, RawCamera, RawImage, RawPhoto};
use super::reconstruction::ReconstructionFiles;
use super::reprojection::Reprojection;
use super::rigs::Rigs;
use super::sizes::SizeSource;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pinhole, Pose, RollingShutter};
use quadratura_base::scene::SparsePoint;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// A parsed camera, or the problem with it.
type RawResult = Result<RawCamera, Objection>;
/// A photo's pose, or the problem with it.
type PoseResult = Result<Pose, Objection>;

/// Takes raw cameras, then images, then points, in file order.
pub struct Assembly<'s> {
    sizes: SizeSource<'s>,
    options: &'s CameraOptions,
    cameras_file: PathBuf,
    images_file: PathBuf,
    points_file: PathBuf,
    /// `None` for a camera that was there but could not be used.
    cameras: FxHashMap<u32, Option<(Pinhole, Lens)>>,
    image_ids: FxHashSet<u32>,
    /// The number of photos that the files list, usable or not.
    listed: usize,
    names: FxHashSet<String>,
    photos: Vec<CameraPhoto>,
    observations: FxHashMap<u64, Vec<(u32, DVec2)>>,
    point_ids: FxHashSet<u64>,
    points: Vec<SparsePoint>,
    problems: Problems,
    notes: Vec<String>,
    /// The number of names with the sign that Windows has between folders.
    backslashes: usize,
    /// The number of keypoints whose positions are no numbers.
    no_places: usize,
    rigs: Option<Rigs>,
    /// Whether the points' positions are those at which their observations meet.
    triangulated: bool,
}

impl<'s> Assembly<'s> {
    pub(super) fn new(
        files: &ReconstructionFiles,
        sizes: SizeSource<'s>,
        options: &'s CameraOptions,
    ) -> Self {
        Self {
            sizes,
            options,
            cameras_file: files.cameras.clone(),
            images_file: files.images.clone(),
            points_file: files.points.clone().unwrap_or_else(|| files.images.clone()),
            cameras: FxHashMap::default(),
            image_ids: FxHashSet::default(),
            listed: 0,
            names: FxHashSet::default(),
            photos: Vec::new(),
            observations: FxHashMap::default(),
            point_ids: FxHashSet::default(),
            points: Vec::new(),
            problems: Problems::default(),
            notes: Vec::new(),
            backslashes: 0,
            no_places: 0,
            rigs: None,
            triangulated: false,
        }
    }

    /// Returns whether sizes that the format does not state are those of the photos' files.
    pub(super) fn knows_sizes(&self) -> bool {
        self.sizes.are_known()
    }

    /// Returns what the user decided about the reading.
    pub(super) fn options(&self) -> &'s CameraOptions {
        self.options
    }

    /// Returns a photo that was taken, by its index.
    pub(super) fn taken(&self, photo: u32) -> &CameraPhoto {
        &self.photos[photo as usize]
    }

    /// Says that positions of points are triangulated from their observations.
    pub(super) fn points_are_triangulated(&mut self) {
        self.triangulated = true;
    }

    /// Has the motion of a camera taken out of a photo.
    pub(super) fn shutter(&mut self, photo: u32, shutter: RollingShutter) {
        self.photos[photo as usize].shutter = Some(shutter);
    }

    /// Takes the poses of rigs, which replace those of photos that are taken after that.
    pub(super) fn rigs(&mut self, rigs: Rigs) {
        self.rigs = Some(rigs);
    }

    /// Something the user should know and that leaves nothing out.
    pub(super) fn note(&mut self, text: String) {
        self.notes.push(text);
    }

    /// Something that leaves one camera, photo or point out.
    pub(super) fn problem(&mut self, file: &Path, place: String, (found, remedy): Objection) {
        self.problems.push(file, Error::input(file, place, found, remedy));
    }

    /// Returns the sizes of photos for a format that does not state them, in the order of `photos`.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; what is wrong with one photo stands in its place.
    pub(super) fn sizes(
        &self,
        photos: &[PhotoPath],
        task: &Task,
    ) -> Result<Vec<Result<[u64; 2], Objection>>> {
        self.sizes.read(photos, task)
    }

    /// Takes a camera that photos refer to by its number.
    pub(super) fn camera(&mut self, place: String, id: u32, raw: Result<RawCamera, Objection>) {
        let judged = if self.cameras.contains_key(&id) {
            Err((format!("camera {id} appears twice"), "keep one; the first is used"))
        } else {
            let camera = |(found, remedy)| (format!("camera {id}: {found}"), remedy);
            raw.and_then(judged_camera).map_err(camera)
        };
        match judged {
            Ok(camera) => {
                self.cameras.insert(id, Some(camera));
            }
            Err(objection) => self.refused_camera(id, place, objection),
        }
    }

    /// Takes a camera that could not even be parsed; the photos that use it are told so.
    pub(super) fn refused_camera(&mut self, id: u32, place: String, objection: Objection) {
        self.cameras.entry(id).or_insert(None);
        self.problem(&self.cameras_file.clone(), place, objection);
    }

    /// Checks that cameras were listed, usable or not.
    ///
    /// # Errors
    /// Returns [`Error::Input`] where the file has none: every photo would be refused for its camera.
    pub(super) fn some_cameras(&self) -> Result<()> {
        if self.cameras.is_empty() {
            let remedy = "use the cameras file that belongs to the images file";
            return Err(Error::input(&self.cameras_file, "", "it lists no camera", remedy));
        }
        Ok(())
    }

    /// Takes a photo that refers to its camera by number, and its observations.
    pub(super) fn image(&mut self, place: String, raw: RawImage<'_>) {
        let RawImage { id, mut pose, camera, name, observations } = raw;
        self.backslashes += usize::from(name.contains('\\'));
        let name = &name.replace('\\', "/");
        self.listed += 1;
        if let Some(rigs) = &mut self.rigs {
            pose = rigs.pose_of(id, name, camera, pose);
        }
        let judged = self.judged_number(id, name).and_then(|()| {
            let raw = RawPhoto { name, camera: self.camera_of(name, camera), pose };
            self.judged_photo(&place, raw)
        });
        match judged {
            Ok(photo) => {
                let index = self.keep(photo);
                self.image_ids.insert(id);
                for (at, point) in observations {
                    self.observations.entry(point).or_default().push((index, at.into()));
                }
            }
            Err(objection) => self.problem(&self.images_file.clone(), place, objection),
        }
    }

    /// Takes an entry for a photo that could not even be parsed.
    pub(super) fn refused_photo(&mut self, place: String, objection: Objection) {
        self.listed += 1;
        self.problem(&self.images_file.clone(), place, objection);
    }

    /// Takes a file for one photo that could not be read.
    pub(super) fn refused_file(&mut self, error: Error) {
        self.listed += 1;
        self.problems.push(&self.images_file, error);
    }

    /// Takes a point that could not even be parsed.
    pub(super) fn point_problem(&mut self, place: String, objection: Objection) {
        self.problem(&self.points_file.clone(), place, objection);
    }

    /// Takes a photo with a camera of its own. Returns its index for [`Assembly::seen_point`], where it can be used.
    pub fn photo(&mut self, place: String, name: &str, camera: RawResult, pose: PoseResult) -> Option<u32> {
        self.listed += 1;
        let quoted = short(name);
        let of_photo = |(found, remedy): Objection| (format!("{quoted}: {found}"), remedy);
        let camera = camera.and_then(judged_camera).map_err(of_photo);
        match self.judged_photo(&place, RawPhoto { name, camera, pose }) {
            Ok(photo) => Some(self.keep(photo)),
            Err(objection) => {
                self.problem(&self.images_file.clone(), place, objection);
                None
            }
        }
    }

    fn keep(&mut self, photo: CameraPhoto) -> u32 {
        self.names.insert(photo.name.clone());
        self.photos.push(photo);
        self.photos.len() as u32 - 1
    }

    fn judged_number(&self, id: u32, name: &str) -> Result<(), Objection> {
        if let Some(objection) = objection(name) {
            return Err(objection);
        }
        if self.image_ids.contains(&id) {
            let found = format!("{} has the number {id} of an earlier photo", short(name));
            return Err((found, "give each photo its own number; the first is used"));
        }
        Ok(())
    }

    fn judged_photo(&self, place: &str, raw: RawPhoto<'_>) -> Result<CameraPhoto, Objection> {
        if let Some(objection) = objection(raw.name) {
            return Err(objection);
        }
        let name = short(raw.name);
        if self.names.contains(raw.name) {
            return Err((format!("{name} appears twice"), "keep one; the first is used"));
        }
        let (camera, lens) = raw.camera?;
        let pose = raw.pose.map_err(|(found, remedy)| (format!("{name}: {found}"), remedy))?;
        Ok(CameraPhoto {
            name: raw.name.to_owned(),
            camera,
            lens,
            pose,
            shutter: None,
            place: place.to_owned(),
        })
    }

    fn camera_of(&self, name: &str, camera: u32) -> Result<(Pinhole, Lens), Objection> {
        let name = short(name);
        match self.cameras.get(&camera) {
            Some(Some(found)) => Ok(*found),
            Some(None) => {
                let found = format!("{name} uses camera {camera}, which cannot be used");
                Err((found, "correct that camera, see above"))
            }
            None => {
                let found = format!("{name} uses camera {camera}, which is not in the cameras file");
                Err((found, "use cameras and images files of the same reconstruction"))
            }
        }
    }

    /// Takes a point that photos refer to by its number; those that no photo here observes are kept too.
    pub(super) fn point(&mut self, place: String, id: u64, position: [f64; 3]) {
        let observations = self.observations.remove(&id).unwrap_or_default();
        self.seen_point(place, id, position, observations);
    }

    /// Takes a point with its observations: indices of photos, and places in these in pixels.
    pub(super) fn seen_point(
        &mut self,
        place: String,
        id: u64,
        position: [f64; 3],
        mut observations: Vec<(u32, DVec2)>,
    ) {
        let all = observations.len();
        observations.retain(|(_, place)| place.is_finite());
        self.no_places += all - observations.len();
        let objection = if !is_on_a_map(position) {
            Some((format!("point {id} at {position:?}, not within 1e15 of the origin"), "remove the point"))
        } else if !self.point_ids.insert(id) {
            Some((format!("point {id} appears twice"), "keep one; the first is used"))
        } else {
            None
        };
        if let Some(objection) = objection {
            return self.problem(&self.points_file.clone(), place, objection);
        }
        self.points.push(SparsePoint { position: position.into(), observations });
    }

    /// All that was kept.
    ///
    /// # Errors
    /// [`Error::Input`] when no photo was: the first problem, or the empty file.
    pub(super) fn finish(self, mut notes: Vec<String>) -> Result<Cameras> {
        let Self { sizes, triangulated, images_file: file, listed, photos, points, problems, .. } = self;
        notes.extend(self.notes);
        if self.backslashes > 0 {
            let (file, count) = (file.display(), self.backslashes);
            notes.push(format!("{file}: \\ in the names of {count} photos is read as /"));
        }
        if self.no_places > 0 {
            let (file, count) = (file.display(), self.no_places);
            notes.push(format!("{file}: {count} keypoints are left out, whose positions are no numbers"));
        }
        notes.extend(self.rigs.map(|rigs| rigs.notes(&file)).into_iter().flatten());
        let problems = problems.finish();
        if photos.is_empty() {
            let remedy = "use a reconstruction in which photos were registered";
            let empty = || Error::input(file, "", "it lists no photo", remedy);
            return Err(problems.into_iter().next().unwrap_or_else(empty));
        }
        notes.extend(wide_note(&file, &photos).filter(|_| sizes.are_known()));
        // Without sizes, places that count from the middle are not where they are.
        let reprojection =
            sizes.are_known().then(|| Reprojection::new(&photos, &points, triangulated)).flatten();
        let warning = reprojection.as_ref().and_then(Reprojection::warning);
        notes.extend(warning.map(|warning| format!("{}: {warning}", file.display())));
        Ok(Cameras { file, listed, photos, points, reprojection, problems, notes })
    }
}

fn judged_camera(raw: RawCamera) -> Result<(Pinhole, Lens), Objection> {
    let RawCamera { size: [width, height], focal: [fx, fy], centre: [cx, cy], lens } = raw;
    let sides = 1..=LARGEST_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) || width * height > MOST_PIXELS {
        let found = format!("{width} x {height} pixels");
        return Err((found, "sides are 1 to 65535 pixels, and the photo up to 268 megapixels"));
    }
    let pinhole = Pinhole { width: width as u32, height: height as u32, fx, fy, cx, cy };
    sensible(&pinhole, &lens)?;
    Ok((pinhole, lens))
}

/// Returns a note about photos with an angle of view that no lens without a fisheye model has, as of focal lengths in millimetres.
fn wide_note(file: &Path, photos: &[CameraPhoto]) -> Option<String> {
    // 147 degrees along the longer side.
    const SHORTEST: f64 = 0.15;
    let longer = |photo: &CameraPhoto| f64::from(photo.camera.width.max(photo.camera.height));
    let is_wide = |photo: &&CameraPhoto| {
        let is_fisheye =
            matches!(photo.lens, Lens::Fisheye { .. } | Lens::PrismFisheye { .. } | Lens::Eucm { .. });
        !is_fisheye && photo.camera.fx < SHORTEST * longer(photo)
    };
    let mut wide = photos.iter().filter(is_wide);
    let first = wide.next()?;
    let angle = 2.0 * (0.5 * longer(first) / first.camera.fx).atan().to_degrees();
    Some(format!(
        "{}: {} photos have a very wide angle of view, such as {} with {angle:.0} degrees; check that focal lengths are in the unit of the \
         format",
        file.display(),
        1 + wide.count(),
        first.name
    ))
}

/// Refuses values with which nothing could be computed; odd but possible ones pass.
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
