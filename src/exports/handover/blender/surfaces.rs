//! Which image layers texture each face of the model in Blender, and how.

use std::collections::BTreeSet;

use super::confidence::LayerConfidence;
use super::weighing::{Candidate, chosen, face_points};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{FaceId, PhotoId, Site};
use quadratura_handover::blender::scene::{SceneMaterial, SceneUse};
use quadratura_projection::{Domain, Server, Sources};
use quadratura_view::weights::pixels_per_unit;

/// The factor of a pinned photo's weight: more than that of a view from another photo's own camera, 1e10.
const PINNED: f64 = 1e12;
/// The factor for the side of a billboard that the photo did not see: it is used where no photo saw that side.
const OTHER_SIDE: f64 = 1e-6;

/// The site's faces with their photos.
pub struct Surfaces<'a> {
    pub site: &'a Site,
    pub sources: &'a Sources,
    confidences: &'a [LayerConfidence],
    rects: &'a [PixelRect],
    /// The exported photos, in the scene's order.
    photos: &'a [PhotoId],
    most: usize,
    see_through: BTreeSet<FaceId>,
}

/// A photo of a face with its layers.
pub struct PhotoOfFace<'a> {
    pub photo: PhotoId,
    pub servers: Vec<&'a Server>,
    candidate: Candidate,
}

impl<'a> Surfaces<'a> {
    /// Takes the layers' weights and rectangles, in the order of layer textures; at most `most` photos texture a face.
    pub fn new(
        site: &'a Site,
        sources: &'a Sources,
        confidences: &'a [LayerConfidence],
        rects: &'a [PixelRect],
        photos: &'a [PhotoId],
        most: usize,
    ) -> Self {
        let see_through = sources.see_through_faces(&site.model);
        Self { site, sources, confidences, rects, photos, most, see_through }
    }

    /// Returns the photos that are chosen for a face, in the site's order.
    pub fn photos_of(&self, face: FaceId) -> Vec<PhotoOfFace<'a>> {
        let servers = self.sources.servers_of(face);
        let groups = servers.chunk_by(|a, b| a.photo == b.photo);
        let mut found: Vec<PhotoOfFace> = groups.map(|servers| self.weighed(face, servers)).collect();
        let candidates: Vec<Candidate> = found.iter().map(|photo| photo.candidate).collect();
        let kept = chosen(&candidates, self.most);
        let mut place = 0;
        found.retain(|_| {
            place += 1;
            kept.binary_search(&(place - 1)).is_ok()
        });
        found
    }

    /// Returns the scene's number of the photo that shows most of a face; `None` where none does.
    pub fn best_of(&self, photos: &[PhotoOfFace]) -> Option<usize> {
        let by_pixels = |a: &&PhotoOfFace, b: &&PhotoOfFace| {
            a.candidate.pixels.total_cmp(&b.candidate.pixels).then(b.photo.cmp(&a.photo))
        };
        let best = photos.iter().max_by(by_pixels)?;
        self.photos.iter().position(|photo| *photo == best.photo)
    }

    /// Returns the material of a face with these photos.
    pub fn material(&self, face: FaceId, photos: &[PhotoOfFace]) -> SceneMaterial {
        let model = &self.site.model;
        let is_billboard = model.object(model.face(face).object).billboard;
        let mut uses: Vec<SceneUse> = Vec::new();
        for server in photos.iter().flat_map(|photo| &photo.servers) {
            let layer = server.layer_texture.0 as usize;
            let other = if is_billboard { OTHER_SIDE } else { 0.0 };
            let factor = if server.pinned { PINNED } else { 1.0 };
            let sides = if server.back { [other, 1.0] } else { [1.0, other] }.map(|side| side * factor);
            let parts = parts_of(&server.domain, self.rects[layer]);
            match uses.iter_mut().find(|it| it.layer == layer && it.sides == sides) {
                // The whole face includes every part of it.
                Some(found) if found.parts.is_empty() || parts.is_empty() => found.parts.clear(),
                Some(found) => found.parts.extend(parts),
                None => uses.push(SceneUse { layer, sides, parts }),
            }
        }
        SceneMaterial { uses, see_through: self.see_through.contains(&face) }
    }

    /// Finds out how well a photo shows a face by its layers.
    fn weighed(&self, face: FaceId, servers: &'a [Server]) -> PhotoOfFace<'a> {
        let photo = servers[0].photo;
        let projector = self.sources.photo(photo);
        let (center, plane) = (projector.pose.center_in_world(), &self.site.model.face(face).plane);
        let points = face_points(&self.site.model, face);
        let mut pixels = 0.0;
        for point in &points {
            let in_camera = projector.pose.camera_from_world(point.position);
            let Some(px) = projector.camera.image_from_camera(in_camera) else { continue };
            let of_layer = |server: &Server| {
                let weight = self.confidences[server.layer_texture.0 as usize].at(px);
                if server.domain.holds(px) { weight } else { 0.0 }
            };
            let weight = servers.iter().map(of_layer).fold(0.0, f64::max);
            pixels +=
                weight * point.area * pixels_per_unit(&projector.camera, plane, center, in_camera.z).powi(2);
        }
        let middle =
            points.iter().map(|point| point.position).sum::<glam::DVec3>() / points.len().max(1) as f64;
        let direction = (center - middle).try_normalize().unwrap_or(plane.normal);
        let pinned = servers.iter().any(|server| server.pinned);
        let candidate = Candidate { pixels, direction, pinned };
        PhotoOfFace { photo, servers: servers.iter().collect(), candidate }
    }
}

/// Returns the convex parts of a domain, as half planes of positions u, v in the picture of `rect`; none for all of it.
pub fn parts_of(domain: &Domain, rect: PixelRect) -> Vec<Vec<[f64; 3]>> {
    let Domain::Inside(sides) = domain else { return Vec::new() };
    let of_picture = sides.iter().map(|side| {
        let normal = side.normal;
        let from = normal.x * f64::from(rect.x) + normal.y * f64::from(rect.y);
        [normal.x * f64::from(rect.w), normal.y * f64::from(rect.h), side.offset - from]
    });
    vec![of_picture.collect()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use quadratura_projection::HalfPlane;

    #[test]
    fn a_part_is_bounded_in_its_picture_where_it_is_in_the_photo() {
        let side = HalfPlane { normal: DVec2::new(0.6, 0.8), offset: 95.0 };
        let domain = Domain::Inside(vec![side]);
        let rect = PixelRect { x: 30, y: -10, w: 128, h: 64 };
        let [part] = &parts_of(&domain, rect)[..] else { panic!("one part") };
        for px in [DVec2::new(100.0, 40.0), DVec2::new(100.0, 46.0), DVec2::new(40.0, 90.0)] {
            let (u, v) = ((px.x - 30.0) / 128.0, (px.y + 10.0) / 64.0);
            let [a, b, c] = part[0];
            assert_eq!(a * u + b * v >= c, domain.holds(px), "{px}");
        }
        assert!(parts_of(&Domain::Whole, rect).is_empty());
    }
}
