//! The photos' shares of an image, from which the exposure of a view follows.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::near::Shares;
use crate::Sources;
use crate::cells::{Cells, ServerCandidate, Unknown, cells};
use crate::model_surface::{ModelSurface, RayHit};
use crate::relief::{FaceRelief, Relief};
use crate::turned::{MIRRORED, PhotoOnFace, blend_on};
use quadratura_base::geometry::polygon::fit_plane;
use quadratura_base::geometry::{Pinhole, Plane};
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_view::Shot;
use quadratura_view::weights::{
    Claim, OTHER_SIDE, angle_at, border, octaves_missing, pixels_per_unit, shares,
};

/// The number of rays per image, across and down: enough that a single ray at an edge changes the sum by an
/// imperceptible thousandth.
const RAYS: [u32; 2] = [36, 24];

/// Computes the shares of the photos in an image from their weights on a regular grid of rays. At a photo's
/// own camera its share is 1 but for a millionth. The shares change as gradually as the blend does, which
/// keeps exposures from popping.
pub fn visible_shares(
    shot: &Shot,
    model: &Model,
    sources: &Sources,
    surface: &ModelSurface,
    cells: &Cells,
) -> Shares {
    let looker = Looker { shot, model, sources, surface, cells };
    let of_row = |row: u32| {
        let mut of_photo = vec![0.0; sources.photos.len()];
        for column in 0..RAYS[0] {
            for (photo, seen) in looker.look(column, row).into_iter().flatten() {
                of_photo[photo] += seen.weight;
            }
        }
        of_photo
    };
    let rows: Vec<Vec<f64>> = (0..RAYS[1]).into_par_iter().map(of_row).collect();
    // The rows are added in their order, so that the result does not depend on the number of threads.
    let of_photo = (0..sources.photos.len()).map(|photo| rows.iter().map(|row| row[photo]).sum::<f64>());
    let mut of_photo: Vec<f64> = of_photo.collect();
    let all: f64 = of_photo.iter().sum();
    let takes_part =
        (0..sources.photos.len() as u32).map(|photo| !shot.without.contains(&PhotoId(photo))).collect();
    if all > 0.0 {
        of_photo.iter_mut().for_each(|share| *share /= all);
    }
    Shares { of_photo, of_common: if all > 0.0 { 0.0 } else { 1.0 }, takes_part }
}

/// The share of what a view shows that has the resolution of the photos at least, if the view has it.
const RESOLVED: f64 = 0.75;

/// Computes how many times as many pixels along each side the photos have that show what a view shows, with their weights: where
/// they have so many in three quarters of it. In a photo's own camera it is the ratio of the sizes, 1 for the photo's size.
pub fn resolution(
    shot: &Shot,
    model: &Model,
    sources: &Sources,
    surface: &ModelSurface,
    cells: &Cells,
) -> f64 {
    let looker = Looker { shot, model, sources, surface, cells };
    let of_surroundings = octaves_of_surroundings(shot, sources);
    let octaves = |ray: u32| match looker.look(ray % RAYS[0], ray / RAYS[0]) {
        None => of_surroundings,
        Some(seen) => {
            let seen = || seen.iter().map(|(_, seen)| seen).filter(|seen| seen.weight > 0.0);
            let all: f64 = seen().map(|seen| seen.weight).sum();
            let octaves: f64 = seen().map(|seen| seen.weight * seen.octaves_to_spare).sum();
            (all > 0.0).then(|| octaves / all)
        }
    };
    let mut octaves: Vec<f64> = (0..RAYS[0] * RAYS[1]).into_par_iter().filter_map(octaves).collect();
    octaves.sort_by(f64::total_cmp);
    let at = (RESOLVED * octaves.len() as f64) as usize;
    octaves.get(at).map_or(1.0, |octaves| octaves.exp2())
}

/// Returns the octaves by which photos of surroundings have more pixels per radian along their axes, in the median.
fn octaves_of_surroundings(shot: &Shot, sources: &Sources) -> Option<f64> {
    let density = |camera: &Pinhole| 0.5 * (camera.fx * camera.fy).log2();
    let servers = sources.servers_of_surroundings().iter().filter(|_| shot.surroundings);
    let photos = servers.map(|server| server.photo).filter(|photo| photo.index() < sources.photos.len());
    let taking_part = photos.filter(|photo| !shot.without.contains(photo));
    let mut octaves: Vec<f64> =
        taking_part.map(|photo| density(&sources.photo(photo).camera) - density(&shot.camera)).collect();
    octaves.sort_by(f64::total_cmp);
    octaves.get(octaves.len() / 2).copied()
}

/// Side of a cell, in pixels, for shares that are needed without a picture; its value does not matter.
const CELL_PX: u32 = 32;

/// Computes the shares of the photos in a view as [`visible_shares`], with cells of its own.
pub fn shares_of_view(
    shot: &Shot,
    model: &Arc<Model>,
    sources: &Sources,
    surface: &ModelSurface,
    relief: &Relief,
) -> Shares {
    let height = |face| relief.of(face).map_or(0.0, FaceRelief::largest);
    let heights: Vec<f64> = model.face_ids().map(height).collect();
    let model = model.facing(&Facing::of_pose(&shot.pose));
    let cells = cells(&model, sources, shot, CELL_PX, &heights, &[], &Unknown);
    visible_shares(shot, &model, sources, surface, &cells)
}

/// What a photo shows at a point of a view.
struct PhotoAtPoint {
    /// Its weight.
    weight: f64,
    /// The octaves of resolution that it has more than the view; below 0 where it has less.
    octaves_to_spare: f64,
}

/// What a photo claims at a point.
struct PointClaim {
    penalty: f64,
    /// The trust in a photo that the face is pinned to.
    pinned: Option<f64>,
    octaves_to_spare: f64,
}

impl PointClaim {
    const NONE: Self = Self { penalty: f64::INFINITY, pinned: None, octaves_to_spare: 0.0 };
}

struct Looker<'a> {
    shot: &'a Shot,
    model: &'a Model,
    sources: &'a Sources,
    surface: &'a ModelSurface,
    cells: &'a Cells,
}

impl Looker<'_> {
    /// Finds what the photos show at the point where one ray hits the model; `None` where it hits nothing.
    fn look(&self, column: u32, row: u32) -> Option<Vec<(usize, PhotoAtPoint)>> {
        let camera = &self.shot.camera;
        let share = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5)
            / DVec2::new(f64::from(RAYS[0]), f64::from(RAYS[1]));
        let px = share * DVec2::new(f64::from(camera.width), f64::from(camera.height));
        let eye = self.shot.viewpoint();
        let direction = self.shot.pose.rotation.transpose() * camera.ray_in_camera(px);
        let hit = self.surface.first_visible(eye, direction, self.shot.culling())?;
        let Ok(index) = self.cells.faces.binary_search_by_key(&hit.face, |f| f.face) else { return None };
        let side = self.cells.side_px;
        let list = self.cells.of(&self.cells.faces[index], px.x as u32 / side, px.y as u32 / side);
        let point = eye + direction * hit.t;
        let blend = blend_on(self.model, hit.face, &self.shot.blend);
        let claims: Vec<PointClaim> = list.iter().map(|c| self.claim(&hit, c, point)).collect();
        let penalties: Vec<f64> = claims.iter().map(|claim| claim.penalty).collect();
        let pinned: Vec<Option<f64>> = claims.iter().map(|claim| claim.pinned).collect();
        let of_photo = |((candidate, weight), claim): ((&ServerCandidate, f64), &PointClaim)| {
            let photo = self.sources.servers[candidate.server as usize].photo;
            (photo.index(), PhotoAtPoint { weight, octaves_to_spare: claim.octaves_to_spare })
        };
        Some(list.iter().zip(shares(&penalties, &pinned, &blend)).zip(&claims).map(of_photo).collect())
    }

    /// Computes what a photo claims, as far as it is known without access to texels.
    fn claim(&self, hit: &RayHit, candidate: &ServerCandidate, point: DVec3) -> PointClaim {
        let server = &self.sources.servers[candidate.server as usize];
        let photo = self.sources.photo(server.photo);
        let on_face = PhotoOnFace::new(self.model, hit.face, self.shot, photo, server);
        let in_photo = on_face.pose.camera_from_world(point);
        let px = photo.camera.image_from_camera(in_photo).filter(|px| server.domain.holds(*px));
        let (Some(px), Some(plane)) = (px, self.plane(hit)) else { return PointClaim::NONE };
        let (eye, center) = (self.shot.viewpoint(), on_face.pose.center_in_world());
        let other_side = server.back == (plane.signed_distance(eye) > 0.0);
        if other_side && !self.model.object(self.model.face(hit.face).object).billboard {
            return PointClaim::NONE;
        }
        let depth = self.shot.pose.camera_from_world(point).z;
        let in_view = pixels_per_unit(&self.shot.camera, &plane, eye, depth);
        let of_photo = pixels_per_unit(&photo.camera, &plane, center, in_photo.z);
        let octaves = octaves_missing(in_view, of_photo);
        let apart = if self.model.impostor(hit.face).is_some() { MIRRORED } else { OTHER_SIDE };
        let angle = angle_at(point, eye, on_face.seen_from(point)) + if other_side { apart } else { 0.0 };
        let claim =
            Claim { angle, octaves, border: border(&photo.camera, px), confidence: 1.0, agreement: 1.0 };
        let pinned = (server.pinned && !other_side).then(|| claim.trust());
        PointClaim {
            penalty: claim.penalty(&self.shot.blend),
            pinned,
            octaves_to_spare: (of_photo / in_view).log2(),
        }
    }

    /// Returns the plane of a face; of its triangle when the face is not planar.
    fn plane(&self, hit: &RayHit) -> Option<Plane> {
        let face = self.model.face(hit.face);
        if face.planar {
            return Some(face.plane);
        }
        let corners = self.model.face_triangles(hit.face)[hit.triangle as usize];
        fit_plane(&corners.map(|vertex| self.model.vertices[vertex as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{Unknown, cells};
    use crate::{Domain, LayerTexture, LayerTextureId, Projector, Server};
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::synthetic::{Modeller, centred, look_at};

    /// Computes the shares in a view from the front of a wall that one photo saw from the front and one from
    /// behind.
    fn shares(billboard: bool) -> Vec<f64> {
        let mut m = Modeller::new();
        let (origin, u, v) = (DVec3::new(-5.0, 0.0, -5.0), DVec3::X * 10.0, DVec3::Z * 10.0);
        m.object("wall").quad_facing(DVec3::NEG_Y, origin, u, v);
        let mut model = (*m.finish()).clone();
        model.objects[0].billboard = billboard;
        let rect = PixelRect::of_size(64, 64);
        let projector = |y: f64| {
            let pose = look_at(DVec3::new(0.5, y, 0.0), DVec3::ZERO);
            Projector { name: String::new(), camera: centred(64, 64, 64.0), pose }
        };
        let server = |i: u32| Server {
            layer_texture: LayerTextureId(i),
            photo: PhotoId(i),
            back: i == 1,
            pinned: false,
            domain: Domain::Whole,
        };
        let layer_texture =
            |i: u32| LayerTexture { photo: PhotoId(i), id: i.to_string(), rect, see_through: false };
        let sources = Sources {
            photos: [-5.0, 5.0].map(projector).to_vec(),
            layer_textures: (0..2).map(layer_texture).collect(),
            servers: (0..2).map(server).collect(),
            of_face: std::iter::once(0..2).collect(),
            ..Sources::default()
        };
        let shot = Shot::new(centred(64, 64, 64.0), look_at(DVec3::new(-0.5, -4.0, 0.0), DVec3::ZERO));
        let cells = cells(&model, &sources, &shot, 16, &[], &[], &Unknown);
        visible_shares(&shot, &model, &sources, &ModelSurface::from_model(&model), &cells).of_photo
    }

    #[test]
    fn a_photo_of_the_other_side_has_no_part_in_the_exposure_of_what_it_serves_last() {
        for billboard in [false, true] {
            let shares = shares(billboard);
            assert!(shares[0] > 0.999 && shares[1] < 1e-3, "billboard {billboard}: {shares:?}");
        }
    }
}
