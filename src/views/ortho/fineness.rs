//! How finely photos show what is in an orthophoto.

use glam::DVec2;

use super::OrthoPlan;
use crate::preview::Preview;
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::FaceId;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::{Server, Sources};
use quadratura_sites::open::Opened;
use quadratura_view::Shot;
use quadratura_view::weights::pixels_per_unit;

/// The places along each side of the picture at which photos are asked.
const PLACES: u32 = 32;

/// Returns the side of a pixel of the photo that shows a place best, on the surface there, in world units: the median over the picture.
/// `None` where no photo shows anything.
pub(super) fn photo_pixel(opened: &Opened, plan: &OrthoPlan, preview: &Preview) -> Option<f64> {
    let surface = preview.surface();
    let share = |at: u32| (f64::from(at) + 0.5) / f64::from(PLACES);
    let places = (0..PLACES * PLACES).map(|at| DVec2::new(share(at % PLACES), share(at / PLACES)));
    let [width, height] = plan.size_px().map(f64::from);
    let pixel = |place: DVec2| {
        let (face, point) = seen_at(&surface, &plan.shot, place * DVec2::new(width, height))?;
        best_pixel(opened, preview.sources(), face, point)
    };
    let mut found: Vec<f64> = places.filter_map(pixel).collect();
    upper_median(&mut found)
}

/// Returns the face that an orthographic view shows at a position in pixels, and the point on it, in world coordinates.
pub(crate) fn seen_at(surface: &ModelSurface, shot: &Shot, px: DVec2) -> Option<(FaceId, glam::DVec3)> {
    let (eye, ray) = (shot.viewpoint(), shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px));
    let hit = surface.first_visible(eye, ray, shot.culling())?;
    Some((hit.face, eye + ray * hit.t))
}

/// Returns the side of a pixel, at a point of a face, of the photo that shows it best; in world units.
pub(crate) fn best_pixel(
    opened: &Opened,
    sources: &Sources,
    face: FaceId,
    point: glam::DVec3,
) -> Option<f64> {
    let plane = &opened.site.model.face(face).plane;
    let of_server = |server: &Server| {
        let photo = sources.photo(server.photo);
        let in_photo = photo.pose.camera_from_world(point);
        let px = photo.camera.image_from_camera(in_photo).filter(|px| server.domain.holds(*px))?;
        let is_in = photo.camera.rect().contains_position(px);
        let density = pixels_per_unit(&photo.camera, plane, photo.pose.center_in_world(), in_photo.z);
        (is_in && density > 0.0).then(|| 1.0 / density)
    };
    sources.servers_of(face).iter().filter_map(of_server).min_by(f64::total_cmp)
}
