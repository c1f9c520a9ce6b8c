//! Sets of layered depth images that together cover a site, in one file: which photos' cameras they have, and their making.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::maker::{BuildCamera, Maker};
use super::options::BuildFrom;
use super::place::{Identity, check_out, free_file_of};
use super::reference_camera::ReferenceCamera;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::{Pinhole, Plane, Pose};
use quadratura_base::scene::{Model, Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_layers::device::StartDevice;
use quadratura_ldi::file::{PackedSet, Packing};
use quadratura_ldi::set::{Chosen, chosen_for_set};
use quadratura_ldi::{Arrangement, Ldi, LdiReport};
use quadratura_projection::Projector;
use quadratura_projection::exposure::{ExposureOptions, RayVisibility, SpreadPoint, spread_points};
use quadratura_projection::model_surface::ModelSurface;
use quadratura_view::weights::pixels_per_unit;

/// The share of the points that is enough.
const ENOUGH: f64 = 0.99;
/// The least resolution with which a camera covers a point, as a share of the best photo's there.
const FINE_ENOUGH: f64 = 0.5;
/// The share of a point's distance by which something may be before it and not hide it: faces that are level with it.
const LEVEL: f64 = 1e-3;

/// A request for a set of layered depth images.
#[derive(Debug, Clone)]
pub struct SetRequest<'a> {
    /// The photos whose cameras may be taken; those without a stack are not.
    pub photos: Vec<PhotoId>,
    /// What the images are made from.
    pub from: BuildFrom,
    /// The largest number of images.
    pub most: usize,
    /// The file to write.
    pub out: &'a Path,
    /// How it is packed.
    pub packing: Packing,
}

/// Several layered depth images in one file.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltSet {
    /// How they belong together.
    pub arrangement: Arrangement,
    /// The file.
    pub file: PathBuf,
    /// Its size in bytes.
    pub bytes: u64,
    /// The images in their order.
    pub images: Vec<ImageOfSet>,
    /// The surface points that a set was chosen by; 0 of a cube.
    pub points: usize,
    /// Files that have the name, were changed or made by others, and were therefore not overwritten.
    pub spared: Vec<PathBuf>,
}

impl BuiltSet {
    /// Returns how many of the points the images cover together.
    pub fn covered(&self) -> usize {
        self.images.iter().filter_map(|image| image.chosen).map(|chosen| chosen.adds).sum()
    }
}

/// An image of a set or a cube.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageOfSet {
    /// The photo's name, or the face's.
    pub name: String,
    /// The points that it covers; `None` for the face of a cube.
    pub chosen: Option<Chosen>,
    /// The number of depth pixels of full resolution.
    pub depth_pixels: u64,
    /// The figures of its making.
    pub report: LdiReport,
    /// Its size in the file in bytes.
    pub bytes: u64,
}

/// Builds a set of layered depth images; a device is started for those of the whole site. A photo that fails does not stop the others; the second list has the reasons.
///
/// # Errors
/// [`Error::Request`] where no photo has a stack or none of them shows a surface, the reasons where none of the images can be
/// made, those of writing, or [`Error::Cancelled`].
pub fn build_set(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &SetRequest,
    start: StartDevice,
    task: &Task,
) -> Result<(BuiltSet, Vec<Error>)> {
    check_out(request.out)?;
    let mut maker = Maker::open(folder, project, site, &request.from, start, task)?;
    let candidates: Vec<PhotoId> =
        request.photos.iter().copied().filter(|photo| maker.source.has_stack(*photo)).collect();
    if candidates.is_empty() {
        let found = "no photo has layers, of which images of a set could be made; ".to_owned();
        return Err(Error::missing((found, Remedy::Build, " builds them")));
    }
    if let missing @ 1.. = request.photos.len() - candidates.len() {
        task.note(format!("{missing} of the photos have no layers yet and are not chosen from"));
    }
    let (chosen, points) = task.timed("choose", || choose(site, &candidates, request))?;
    let count = chosen.len() as u64;
    let mut writing = Writing::new(Arrangement::Set, request.packing);
    let mut failed = maker.unusable(&request.from);
    for (done, one) in (0..).zip(&chosen) {
        task.step("layered depth images", done, count)?;
        let photo = candidates[one.candidate];
        let camera = BuildCamera::of_photo(site, photo);
        let made = maker
            .image_of(&camera, &request.from, task)
            .and_then(|ldi| writing.add(request.out, &camera.name, Some(*one), &ldi));
        match made {
            Ok(()) => (),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => failed.push(error),
        }
    }
    task.step("layered depth images", count, count)?;
    if writing.images.is_empty()
        && let Some(error) = Error::of_all(std::mem::take(&mut failed))
    {
        return Err(error);
    }
    let built = writing.write(request.out, task)?;
    Ok((BuiltSet { points, ..built }, failed))
}

/// Images that are written into one file.
pub(super) struct Writing {
    arrangement: Arrangement,
    packed: PackedSet,
    images: Vec<ImageOfSet>,
    identities: Vec<Identity>,
}

impl Writing {
    /// Begins with none.
    pub fn new(arrangement: Arrangement, packing: Packing) -> Self {
        let packed = PackedSet::new(arrangement, packing);
        Self { arrangement, packed, images: Vec::new(), identities: Vec::new() }
    }

    /// Packs the next image, which need not be kept then.
    ///
    /// # Errors
    /// Those of [`PackedSet::add`].
    pub fn add(&mut self, out: &Path, name: &str, chosen: Option<Chosen>, ldi: &Ldi) -> Result<()> {
        let bytes = self.packed.add(out, ldi)?;
        self.identities.push(Identity::of(ldi));
        self.images.push(ImageOfSet {
            name: name.to_owned(),
            chosen,
            depth_pixels: ldi.levels[0].len() as u64,
            report: ldi.report.clone(),
            bytes,
        });
        Ok(())
    }

    /// Writes the file under the first name that is free or has older versions of the same images.
    ///
    /// # Errors
    /// [`Error::Request`] for a name that is no file's, and those of [`PackedSet::write`].
    pub fn write(self, out: &Path, task: &Task) -> Result<BuiltSet> {
        let Self { arrangement, packed, images, identities } = self;
        let (file, spared) = free_file_of(out, arrangement, &identities, task)?;
        let bytes = task.timed("write", || packed.write(&file))?;
        Ok(BuiltSet { arrangement, file, bytes, images, points: 0, spared })
    }
}

/// A camera that an image of the set may have.
struct CameraCandidate {
    camera: Pinhole,
    pose: Pose,
}

/// Chooses the photos of a set among the candidates; returns the choice and the number of points.
fn choose(site: &Site, candidates: &[PhotoId], request: &SetRequest) -> Result<(Vec<Chosen>, usize)> {
    let model = &*site.model;
    let projector = |photo: &Photo| {
        let Photo { camera, pose, .. } = *photo;
        Projector { name: photo.name.clone(), camera, pose }
    };
    let photos: Vec<Projector> = site.photos.iter().map(projector).collect();
    let visibility = RayVisibility::new(model, &photos);
    let points = spread_points(&photos, candidates, &visibility, &ExposureOptions::default());
    let cameras = candidates.iter().map(|photo| candidate(site.photo(*photo), &request.from));
    let cameras: Vec<CameraCandidate> = cameras.collect::<Result<_>>()?;
    let surface = ModelSurface::from_model(model);
    let resolutions: Vec<Vec<f64>> = points
        .par_iter()
        .map(|point| {
            let own = photos[point.own.index()].pose.center_in_world();
            cameras.iter().map(|camera| camera.resolution(point, own, model, &surface)).collect()
        })
        .collect();
    let covers = |candidate: usize| {
        let covers = |of_point: &Vec<f64>| {
            let best = of_point.iter().copied().fold(0.0, f64::max);
            of_point[candidate] > 0.0 && of_point[candidate] >= FINE_ENOUGH * best
        };
        resolutions.iter().map(covers).collect()
    };
    let covers: Vec<Vec<bool>> = (0..candidates.len()).map(covers).collect();
    let names: Vec<&str> = candidates.iter().map(|photo| site.photo(*photo).name.as_str()).collect();
    let chosen = chosen_for_set(&covers, &names, request.most, ENOUGH);
    if chosen.is_empty() {
        let found =
            "no photo with a stack shows a surface of the model, by which images of a set could be chosen";
        return Err(Error::Request(found.into()));
    }
    Ok((chosen, points.len()))
}

/// Returns the camera that a photo's image would have: grown by the guard band and scaled where several photos are combined.
fn candidate(photo: &Photo, from: &BuildFrom) -> Result<CameraCandidate> {
    let Photo { camera, pose, .. } = *photo;
    let camera = match from {
        BuildFrom::Stack(_) => camera,
        BuildFrom::Photos { options, .. } => {
            ReferenceCamera { camera, pose, photo: None, gain: [0.0; 3] }
                .frame(options.scale, options.guard)?
                .camera
        }
        BuildFrom::Site { options, .. } => {
            ReferenceCamera { camera, pose, photo: None, gain: [0.0; 3] }
                .frame(options.scale, options.guard)?
                .camera
        }
    };
    Ok(CameraCandidate { camera, pose })
}

impl CameraCandidate {
    /// Returns the pixels per world unit with which the camera sees a point on the side that `own` sees, too; 0 where it does not
    /// see it.
    fn resolution(&self, point: &SpreadPoint, own: DVec3, model: &Model, surface: &ModelSurface) -> f64 {
        let SpreadPoint { position, face, .. } = *point;
        let plane = Plane { point: position, ..model.face(face).plane };
        let eye = self.pose.center_in_world();
        let in_camera = self.pose.camera_from_world(position);
        let size = DVec2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        let is_within = |px: DVec2| px.min_element() >= 0.0 && (size - px).min_element() > 0.0;
        let same_side = plane.signed_distance(eye) * plane.signed_distance(own) > 0.0;
        if !same_side || !self.camera.image_from_camera(in_camera).is_some_and(is_within) {
            return 0.0;
        }
        let hit = surface.nearest(eye, position - eye);
        // Without a hit the ray passes the point's own face at its rim.
        if hit.is_some_and(|hit| hit.t < 1.0 - LEVEL) {
            return 0.0;
        }
        pixels_per_unit(&self.camera, &plane, eye, in_camera.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maker::no_device;
    use quadratura_stacks::tiny_site::tiny_stacks;

    #[test]
    fn a_set_of_the_tiny_site_covers_nearly_all_points_and_reports_by_whom() {
        let folder = tempfile::tempdir().unwrap();
        let (project, opened) = tiny_stacks(folder.path()).unwrap();
        let out = folder.path().join("site.ldi");
        let photos = opened.site.photo_ids().collect();
        let from = BuildFrom::Stack(super::super::StackLdiOptions { relief: false, ..Default::default() });
        let request = SetRequest { photos, from, most: 9, out: &out, packing: Packing::Deflate };
        let (built, failed) =
            build_set(&project, &opened.project, &opened.site, &request, &no_device, &Task::silent())
                .unwrap();
        assert!(failed.is_empty() && built.file == out && built.spared.is_empty());
        let adds: Vec<usize> = built.images.iter().map(|image| image.chosen.unwrap().adds).collect();
        assert!(adds.is_sorted_by(|a, b| a >= b) && adds.iter().all(|adds| *adds > 0), "{adds:?}");
        assert!(built.covered() as f64 >= ENOUGH * built.points as f64, "{adds:?} of {}", built.points);
        let read = quadratura_ldi::file::read_ldi_set(&out, &Task::silent()).unwrap();
        assert_eq!(read.images.len(), built.images.len());
        // The same again replaces the file; another choice does not.
        let (again, _) =
            build_set(&project, &opened.project, &opened.site, &request, &no_device, &Task::silent())
                .unwrap();
        assert_eq!((&again.file, &again.images), (&out, &built.images));
        let one = SetRequest { photos: vec![PhotoId::new(1)], ..request };
        let (other, _) =
            build_set(&project, &opened.project, &opened.site, &one, &no_device, &Task::silent()).unwrap();
        assert_eq!((other.images.len(), &other.spared[..]), (1, &[out][..]));
    }
}
