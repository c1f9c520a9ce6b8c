//! Conversion of stacks to the photos that can texture each face: `document::Stack` becomes `projection::Sources`.

use std::borrow::Borrow;
use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::far_backdrops::FarBackdrops;
use quadratura_base::geometry::polygon::{fit_plane, newell_normal, triangulate};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{FaceId, FaceIndex, Model, Photo, PhotoId, Site};
use quadratura_document::stack::ImageLayer;
use quadratura_document::{Decisions, PhotoDecisions, Stack};
use quadratura_projection::tiles::in_few_tiles;
use quadratura_projection::{Domain, HalfPlane, LayerTexture, LayerTextureId, Projector, Server, Sources};

/// The distance in pixels by which a piece's domain extends beyond its cut edges: a pixel that a cut crosses shows
/// both sides of it, each looked up at the pixel's centre, which is at most half a diagonal away.
const CUT_SLACK_PX: f64 = 0.75;

/// Points closer than this share of the face's size are equal: pieces are cut in f64 from the face's own corners.
const SAME_PLACE: f64 = 1e-9;

/// Makes the sources of a site from its stacks, in the site's order; photos without a stack (`None`) texture
/// nothing. The decisions exclude photos from faces, and pin faces to photos.
pub fn sources(site: &Site, stacks: &[Option<impl Borrow<Stack>>], decisions: &Decisions) -> Sources {
    let pinned = pinned_faces(site, decisions);
    let faces = FacesByName::new(&site.model);
    let mut sources = Sources::default();
    let mut servers: Vec<(FaceId, Server)> = Vec::new();
    let mut surroundings: Vec<Server> = Vec::new();
    let far = &FarBackdrops::new(site);
    sources.far = far.faces(site);
    for ((id, photo), stack) in site.numbered_photos().zip(stacks) {
        let name = photo.name.clone();
        let camera = photo.camera;
        let pose = photo.pose;
        sources.photos.push(Projector { name, camera, pose });
        if let Some(stack) = stack {
            let decided = &decisions.of(&photo.name);
            let model = &site.model.facing(&Facing::of_pose(&pose));
            let pinned = &pinned;
            let stack = stack.borrow();
            let mut converter =
                StackConverter { model, faces: &faces, photo, id, stack, decided, pinned, far };
            converter.read(&mut sources.layer_textures, &mut servers, &mut surroundings);
        }
    }
    // The sort is stable, so that servers of a face are ordered by photo, then layer texture.
    servers.sort_by_key(|(face, _)| *face);
    let mut at = 0;
    for face in site.model.face_ids() {
        let count = servers[at as usize..].iter().take_while(|(f, _)| *f == face).count() as u32;
        sources.of_face.push(Range { start: at, end: at + count });
        at += count;
    }
    sources.servers = servers.into_iter().map(|(_, server)| server).collect();
    sources.servers.append(&mut surroundings);
    sources.surroundings = at..sources.servers.len() as u32;
    sources.surroundings_scale = surroundings_scale(site, stacks);
    sources
}

/// The share of the median depth of what photos show that is the least scale of the surroundings, so that cameras which
/// all stand in one place have one, too.
const LEAST_SHARE_OF_DEPTH: f64 = 0.1;

/// Returns the distance between cameras from which they see other surroundings, in world units
/// ([`Sources::surroundings_scale`]). Depths are those of the middles of the stacks' surfaces, without backdrops, each
/// counted by its area in the photo.
fn surroundings_scale(site: &Site, stacks: &[Option<impl Borrow<Stack>>]) -> f64 {
    let centres: Vec<DVec3> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    let mean = centres.iter().sum::<DVec3>() / centres.len().max(1) as f64;
    let farthest = centres.iter().map(|centre| centre.distance(mean)).fold(0.0, f64::max);
    let mut depths: Vec<(f64, f64)> = Vec::new();
    for (photo, stack) in site.photos.iter().zip(stacks) {
        let surfaces = stack.iter().flat_map(|stack| &stack.borrow().surfaces);
        for surface in surfaces.filter(|surface| !says_backdrop(&surface.object)) {
            let outline: Vec<DVec3> =
                surface.outline.iter().map(|&p| photo.pose.camera_from_world(DVec3::from(p))).collect();
            let middle = outline.iter().sum::<DVec3>() / outline.len().max(1) as f64;
            let normal = newell_normal(&outline);
            // The area in the photo at the middle: that of the surface, seen at its slant from its depth.
            let area = (normal.dot(middle) / middle.z.powi(3)).abs();
            if middle.z > 0.0 && area.is_finite() {
                depths.push((middle.z, area));
            }
        }
    }
    farthest.max(LEAST_SHARE_OF_DEPTH * weighted_median(depths))
}

/// Returns the median of values with weights; 0 of nothing.
fn weighted_median(mut values: Vec<(f64, f64)>) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = values.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    let mut sum = 0.0;
    let median = values.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    median.map_or(0.0, |(value, _)| *value)
}

/// Returns the photo to which each pinned face is pinned.
fn pinned_faces(site: &Site, decisions: &Decisions) -> BTreeMap<FaceId, PhotoId> {
    if decisions.photos.values().all(|decided| decided.pin.is_empty()) {
        return BTreeMap::new();
    }
    let names = site.photos.iter().map(|photo| photo.name.as_str());
    let pinned = |id: FaceId| {
        let face = site.model.face(id);
        let name = decisions.pinned(names.clone(), &site.model.object(face.object).name, face.index)?;
        Some((id, site.photo_named(name)?))
    };
    site.model.face_ids().filter_map(pinned).collect()
}

/// The faces by object name and index.
struct FacesByName<'a>(BTreeMap<&'a str, &'a [FaceId]>);

impl<'a> FacesByName<'a> {
    fn new(model: &'a Model) -> Self {
        Self(model.objects.iter().map(|o| (o.name.as_str(), &o.faces[..])).collect())
    }

    /// Returns a face; `None` where the present model no longer has it, so that the stack does not texture it.
    fn get(&self, object: &str, index: FaceIndex) -> Option<FaceId> {
        self.0.get(object)?.get(index.index()).copied()
    }
}

/// Converts one photo's stack.
struct StackConverter<'a> {
    model: &'a Model,
    faces: &'a FacesByName<'a>,
    photo: &'a Photo,
    id: PhotoId,
    stack: &'a Stack,
    decided: &'a PhotoDecisions,
    pinned: &'a BTreeMap<FaceId, PhotoId>,
    far: &'a FarBackdrops,
}

impl StackConverter<'_> {
    /// Adds the layer textures of the stack, the faces that they serve, and those that serve the surroundings.
    fn read(
        &mut self,
        layer_textures: &mut Vec<LayerTexture>,
        servers: &mut Vec<(FaceId, Server)>,
        surroundings: &mut Vec<Server>,
    ) {
        let elements: Vec<_> = self.stack.visibility_layers.iter().flatten().collect();
        let mut textures_of = vec![0u32; elements.len()];
        let all = self.stack.image_layers.iter().flat_map(|layer| &layer.elements);
        all.for_each(|&e| textures_of[e.index()] += 1);
        for layer in &self.stack.image_layers {
            let layer_texture = LayerTextureId(layer_textures.len() as u32);
            let rect = in_few_tiles(layer.rect, layer.needed_rect);
            layer_textures.push(LayerTexture {
                photo: self.id,
                id: layer.id.clone(),
                rect,
                see_through: layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some()),
            });
            // A layer of far backdrops serves the surroundings once.
            let mut is_far = self.shows_far(layer);
            for &e in &layer.elements {
                let element = elements[e.index()];
                let shared = textures_of[e.index()] > 1;
                if element.is_surroundings() || std::mem::take(&mut is_far) {
                    let domain = if shared { within(Domain::Whole, layer) } else { Domain::Whole };
                    let (photo, back, pinned) = (self.id, false, false);
                    surroundings.push(Server { layer_texture, photo, back, pinned, domain });
                }
                let mut serve = |index: FaceIndex, domain: Domain| {
                    let excluded = self.decided.excludes(&element.object, index);
                    if let Some(face) = self.faces.get(&element.object, index).filter(|_| !excluded) {
                        let pinned = self.pinned.get(&face) == Some(&self.id);
                        let back = element.back.contains(&index);
                        let domain = if shared { within(domain, layer) } else { domain };
                        let server = Server { layer_texture, photo: self.id, back, pinned, domain };
                        if element.impostor && self.model.stands_for_impostor(face) {
                            // The photo's mirror image serves those who come from behind.
                            let mirrored = Server { back: true, pinned: false, ..server.clone() };
                            servers.push((face, mirrored));
                        }
                        servers.push((face, server));
                    }
                };
                element.faces.iter().for_each(|&index| serve(index, Domain::Whole));
                for &(index, piece) in &element.pieces {
                    for domain in self.piece(&element.object, index, piece) {
                        serve(index, domain);
                    }
                }
            }
        }
    }

    /// Returns whether a layer shows far backdrops alone, from which the photo is not excluded.
    fn shows_far(&self, layer: &ImageLayer) -> bool {
        let is_used = |object: &str, index: FaceIndex| !self.decided.excludes(object, index);
        let elements = || self.stack.numbered_elements().filter(|(index, _)| layer.elements.contains(index));
        self.stack.shows_only(layer, |object| self.far.contains(object))
            && elements().any(|(_, element)| {
                let faces = element.faces.iter().chain(element.pieces.iter().map(|(index, _)| index));
                faces.copied().any(|index| is_used(&element.object, index))
            })
    }

    /// Returns the convex parts of a piece as domains.
    fn piece(&self, object: &str, index: FaceIndex, piece: u32) -> Vec<Domain> {
        let same = |p: &&quadratura_document::stack::FacePiece| {
            p.object == object && p.face == index && p.piece == piece
        };
        let Some(found) = self.stack.pieces.iter().find(same) else { return Vec::new() };
        let Some(face) = self.faces.get(object, index) else { return Vec::new() };
        let ring: Vec<DVec3> = found.polygon.iter().map(|&p| DVec3::from(p)).collect();
        let outline: Vec<DVec3> = self.model.ring_points(face).collect();
        let Some(plane) = fit_plane(&ring) else { return Vec::new() };
        let parts: Vec<Vec<DVec3>> = if is_convex(&ring, plane.normal) {
            vec![ring]
        } else {
            let found = triangulate(&ring, &plane);
            let points: Vec<DVec3> = ring.into_iter().chain(found.crossings).collect();
            found.triangles.iter().map(|t| t.map(|i| points[i as usize]).to_vec()).collect()
        };
        let planar = self.model.face(face).planar;
        let outline = if planar { &outline[..] } else { &[] };
        parts.iter().map(|part| inside(part, outline, &self.photo.camera, &self.photo.pose)).collect()
    }
}

/// Returns true when a planar ring is convex.
fn is_convex(ring: &[DVec3], normal: DVec3) -> bool {
    (0..ring.len()).all(|i| {
        let [a, b, c] = [0, 1, 2].map(|j| ring[(i + j) % ring.len()]);
        let turn = (b - a).cross(c - b);
        turn.dot(normal) >= -SAME_PLACE * turn.length().max((b - a).length() * (c - b).length())
    })
}

/// Returns the half planes, in photo pixels, of those edges of a convex polygon that are not edges of the face. The
/// face's own outline needs no half planes, because nothing is drawn beyond it.
fn inside(polygon: &[DVec3], outline: &[DVec3], camera: &Pinhole, pose: &Pose) -> Domain {
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let middle = pose.camera_from_world(middle);
    let mut sides = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if !is_on_outline(a, b, outline) {
            sides.extend(half_plane(pose.camera_from_world(a), pose.camera_from_world(b), middle, camera));
        }
    }
    if sides.is_empty() { Domain::Whole } else { Domain::Inside(sides) }
}

/// Returns the half plane, in pixels, on the middle's side of the line through two points (camera frame). It is
/// correct for points behind the camera, too, because the plane through the camera and both points is what divides.
fn half_plane(a: DVec3, b: DVec3, middle: DVec3, camera: &Pinhole) -> Option<HalfPlane> {
    let through = a.cross(b);
    let through = if through.dot(middle) < 0.0 { -through } else { through };
    // through . ((x - cx) / fx, (y - cy) / fy, 1) >= 0
    let normal = DVec2::new(through.x / camera.fx, through.y / camera.fy);
    let offset = normal.x * camera.cx + normal.y * camera.cy - through.z;
    let length = normal.length();
    (length > 0.0).then(|| HalfPlane { normal: normal / length, offset: offset / length - CUT_SLACK_PX })
}

/// Returns true when a segment lies on one edge of the outline.
fn is_on_outline(a: DVec3, b: DVec3, outline: &[DVec3]) -> bool {
    let size = outline.iter().map(|p| p.distance(outline[0])).fold(0.0, f64::max);
    (0..outline.len()).any(|i| {
        let (from, to) = (outline[i], outline[(i + 1) % outline.len()]);
        [a, b].iter().all(|&p| distance_to_segment(p, from, to) <= SAME_PLACE * size)
    })
}

/// Returns the distance from a point to a segment.
fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if share.is_finite() { p.distance(a + along * share) } else { p.distance(a) }
}

/// Restricts a domain to the layer's needed rectangle: an element that is too large for one layer is divided among
/// several.
fn within(domain: Domain, layer: &ImageLayer) -> Domain {
    let mut sides = match domain {
        Domain::Whole => Vec::new(),
        Domain::Inside(sides) => sides,
    };
    sides.extend(sides_of(layer.needed_rect));
    Domain::Inside(sides)
}

/// Returns the half planes of a rectangle's sides.
fn sides_of(rect: PixelRect) -> [HalfPlane; 4] {
    let side = |x: f64, y: f64, at: i32| HalfPlane {
        normal: DVec2::new(x, y),
        offset: (x + y) * f64::from(at) - CUT_SLACK_PX,
    };
    [
        side(1.0, 0.0, rect.x),
        side(-1.0, 0.0, rect.right()),
        side(0.0, 1.0, rect.y),
        side(0.0, -1.0, rect.bottom()),
    ]
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    fn camera() -> (Pinhole, Pose) {
        let camera = Pinhole { width: 200, height: 100, fx: 100.0, fy: 100.0, cx: 100.0, cy: 50.0 };
        (camera, Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO })
    }

    #[test]
    fn a_piece_is_bounded_by_its_cut_and_not_by_the_faces_own_outline() {
        let (camera, pose) = camera();
        let at = |x: f64, y: f64| DVec3::new(x, y, 2.0);
        let face = [at(-1.0, -0.5), at(1.0, -0.5), at(1.0, 0.5), at(-1.0, 0.5)];
        let left = [at(-1.0, -0.5), at(0.2, -0.5), at(0.2, 0.5), at(-1.0, 0.5)];
        let domain = inside(&left, &face, &camera, &pose);
        let Domain::Inside(sides) = &domain else { unreachable!("it is cut") };
        assert_eq!(sides.len(), 1);
        // The cut is at x = 100 * 0.2 / 2 + 100.
        assert!(domain.holds(DVec2::new(109.99, 0.0)) && domain.holds(DVec2::new(-50.0, 500.0)));
        assert!(!domain.holds(DVec2::new(110.8, 50.0)));
    }

    #[test]
    fn a_cut_that_passes_behind_the_camera_divides_the_photo_rightly() {
        let (camera, pose) = camera();
        // A floor below the camera, cut along x = 0.1; one end of the cut is behind the camera.
        let at = |x: f64, z: f64| DVec3::new(x, 1.0, z);
        let face = [at(-3.0, -5.0), at(3.0, -5.0), at(3.0, 9.0), at(-3.0, 9.0)];
        let right = [at(0.1, -5.0), at(3.0, -5.0), at(3.0, 9.0), at(0.1, 9.0)];
        let domain = inside(&right, &face, &camera, &pose);
        for z in [0.5, 1.0, 4.0] {
            let px = |x: f64| camera.image_from_camera(at(x, z)).expect("in front");
            assert!(domain.holds(px(0.15)) && !domain.holds(px(0.05)), "at depth {z}");
        }
    }

    #[test]
    fn a_concave_piece_has_a_convex_ring_no_more() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 2.0);
        let square = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let arrow = [at(0.0, 0.0), at(1.0, 0.0), at(0.2, 0.2), at(0.0, 1.0)];
        assert!(is_convex(&square, DVec3::Z) && !is_convex(&arrow, DVec3::Z));
    }
}
