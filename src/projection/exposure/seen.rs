//! The exposure of a view: that of the photos that it is made of.

use glam::{DVec2, DVec3};

use super::Shares;
use crate::projection::cells::{Candidate, Cells};
use crate::projection::surface::Surface;
use crate::projection::weights::{Claim, angle_at, border, octaves_missing, pixels_per_unit, weights};
use crate::projection::{PhotoId, Shot, Sources};
use crate::scene::{FaceId, Model};

/// Rays per picture, across and down: enough that one more or less at an edge is a thousandth of the
/// whole, which no eye sees.
const RAYS: [u32; 2] = [36, 24];

/// The shares of the photos in a picture: how much weight each has on a regular grid of rays. In a
/// photo's own camera its own is 1 but for a millionth; they change as gradually as the blend does, which
/// is what keeps colours from popping.
pub fn seen_shares(
    shot: &Shot,
    model: &Model,
    sources: &Sources,
    surface: &Surface,
    cells: &Cells,
) -> Shares {
    let looker = Looker { shot, model, sources, surface, cells };
    let mut of_photo = vec![0.0; sources.photos.len()];
    for row in 0..RAYS[1] {
        for column in 0..RAYS[0] {
            looker.look(column, row, &mut |photo: usize, weight: f64| of_photo[photo] += weight);
        }
    }
    let all: f64 = of_photo.iter().sum();
    let takes_part =
        (0..sources.photos.len() as u32).map(|photo| !shot.without.contains(&PhotoId(photo))).collect();
    if all > 0.0 {
        of_photo.iter_mut().for_each(|share| *share /= all);
    }
    Shares { of_photo, of_common: if all > 0.0 { 0.0 } else { 1.0 }, takes_part }
}

struct Looker<'a> {
    shot: &'a Shot,
    model: &'a Model,
    sources: &'a Sources,
    surface: &'a Surface,
    cells: &'a Cells,
}

impl Looker<'_> {
    /// Tells the weights of the photos where one ray meets the model.
    fn look(&self, column: u32, row: u32, tell: &mut impl FnMut(usize, f64)) {
        let camera = &self.shot.camera;
        let share = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5)
            / DVec2::new(f64::from(RAYS[0]), f64::from(RAYS[1]));
        let px = share * DVec2::new(f64::from(camera.width), f64::from(camera.height));
        let eye = self.shot.viewpoint();
        let direction = self.shot.pose.rotation.transpose() * camera.ray_in_camera(px);
        let Some(hit) = self.surface.nearest(eye, direction) else { return };
        let Ok(place) = self.cells.faces.binary_search_by_key(&hit.face, |f| f.face) else { return };
        let side = self.cells.side_px;
        let list = self.cells.of(&self.cells.faces[place], px.x as u32 / side, px.y as u32 / side);
        let point = eye + direction * hit.t;
        let penalties: Vec<f64> = list.iter().map(|c| self.penalty(hit.face, c, point)).collect();
        for (candidate, weight) in list.iter().zip(weights(&penalties, &self.shot.blend)) {
            let photo = self.sources.servers[candidate.server as usize].photo;
            tell(photo.0 as usize, weight);
        }
    }

    /// As far as it is known without looking at texels.
    fn penalty(&self, face: FaceId, candidate: &Candidate, point: DVec3) -> f64 {
        let server = &self.sources.servers[candidate.server as usize];
        let photo = self.sources.photo(server.photo);
        let in_photo = photo.pose.camera_from_world(point);
        let px = photo.camera.image_from_camera(in_photo).filter(|px| server.domain.holds(*px));
        let Some(px) = px else { return f64::INFINITY };
        let plane = &self.model.face(face).plane;
        let (eye, center) = (self.shot.viewpoint(), photo.pose.center_in_world());
        let depth = self.shot.pose.camera_from_world(point).z;
        let octaves = octaves_missing(
            pixels_per_unit(&self.shot.camera, plane, eye, depth),
            pixels_per_unit(&photo.camera, plane, center, in_photo.z),
        );
        let angle = angle_at(point, eye, center);
        Claim { angle, octaves, border: border(&photo.camera, px), confidence: 1.0 }.penalty(&self.shot.blend)
    }
}
