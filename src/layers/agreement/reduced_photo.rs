//! Reduced photos with their colours prepared for comparison, and the surface points that they show.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::tints::TintLevels;
use crate::fill::{Donor, FillSurfaceId, FillSurfaces};
use quadratura_projection::exposure::LightGroups;
use quadratura_projection::relief::Relief;
use quadratura_view::agreement::PhotoAgreement;
use quadratura_view::optics::Optics;
use quadratura_view::optics::squared_radius;

/// The sine of the least angle, about two degrees, under which a surface is compared. The ground of a square is seen under
/// three degrees from its far side, where people stand.
const GRAZING: f64 = 0.03;

/// A reduced photo.
pub struct ReducedPhoto {
    /// The photo's camera, and the surface that each pixel shows.
    pub donor: Donor,
    /// How much of each pixel shows its face ([`super::outlines()`]).
    pub outlines: PhotoAgreement,
    /// The colours in the common exposure.
    pub(super) tints: TintLevels,
}

impl ReducedPhoto {
    /// Builds the colours of a donor that was made from the reduced photo. `gain` is the photo's exposure relative to the
    /// common one (natural logarithms).
    pub fn new(donor: Donor, outlines: PhotoAgreement, gain: [f64; 3], optics: &Optics) -> Self {
        let tints = tints(&donor, gain, optics);
        Self { donor, outlines, tints }
    }

    /// Replaces the exposure with which the photo is compared, given as in [`Self::new`].
    pub fn set_exposure(&mut self, gain: [f64; 3], optics: &Optics) {
        self.tints = tints(&self.donor, gain, optics);
    }

    /// Projects a world point to pixel coordinates; `None` outside of the photo.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let camera = &self.donor.camera;
        let px = camera.image_from_camera(self.donor.pose.camera_from_world(point))?;
        camera.rect().contains_position(px).then_some(px)
    }
}

/// Brings a donor's colours to the common exposure.
fn tints(donor: &Donor, gain: [f64; 3], optics: &Optics) -> TintLevels {
    let (width, height) = (donor.camera.width, donor.camera.height);
    let light = |x: u32, y: u32| {
        donor.shows_any(x, y).then(|| {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let light = optics.undone(donor.pixel(x, y).map(f64::from), squared_radius(&donor.camera, px));
            [0, 1, 2].map(|c| (light[c] * (-gain[c]).exp()) as f32)
        })
    };
    let row = |y: u32| (0..width).map(move |x| (x, y));
    let light = (0..height).into_par_iter().flat_map_iter(row).map(|(x, y)| light(x, y)).collect();
    TintLevels::new([width as usize, height as usize], light)
}

/// The data that the comparisons of all photos of a site share.
pub struct ReducedPhotos<'a> {
    /// The reduced photos, in the site's order; `None` where a photo cannot be read.
    pub photos: &'a [Option<ReducedPhoto>],
    /// The surfaces of the model in world coordinates.
    pub surfaces: &'a FillSurfaces,
    /// The photos' groups of light.
    pub groups: &'a LightGroups,
    /// The heights of the true surface over the model's.
    pub relief: &'a Relief,
}

impl ReducedPhotos<'_> {
    /// Returns the surface that a photo shows at a pixel, and the point in world coordinates; `None` beside depth
    /// discontinuities, at grazing angles, and on billboards, through which one sees what is behind.
    pub fn visible_point(&self, photo: &ReducedPhoto, x: u32, y: u32) -> Option<(FillSurfaceId, DVec3)> {
        let donor = &photo.donor;
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let item = donor.owner(x, y)?;
        let seen = donor.seen(item);
        let id = self.surfaces.id(seen.face, seen.triangle);
        let surface = self.surfaces.get(id);
        if surface.billboard || !donor.shows(item, px) {
            return None;
        }
        let eye = donor.pose.center_in_world();
        let ray = (donor.pose.rotation.transpose() * donor.camera.ray_in_camera(px)).normalize();
        let slope = surface.plane.normal.dot(ray);
        if slope.abs() < GRAZING {
            return None;
        }
        let on_plane = eye - ray * (surface.plane.signed_distance(eye) / slope);
        let relief = self.relief.of(surface.face);
        let point = relief.map_or(on_plane, |relief| relief.meet(eye, on_plane, surface.plane.normal));
        Some((id, point))
    }

    /// Returns the pixel position at which a photo shows a surface point, well inside what it shows of the surface.
    pub fn seen(&self, photo: &ReducedPhoto, id: FillSurfaceId, point: DVec3) -> Option<DVec2> {
        let item = photo.donor.item(id)?;
        let normal = self.surfaces.get(id).plane.normal;
        let ray = (point - photo.donor.pose.center_in_world()).normalize();
        if normal.dot(ray).abs() < GRAZING {
            return None;
        }
        photo.place(point).filter(|px| photo.donor.shows(item, *px))
    }
}
