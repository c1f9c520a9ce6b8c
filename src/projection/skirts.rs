//! Skirts: strips along the outlines of the model, on which views show what stands there although no face covers it: cornices,
//! tiles, crosses, wherever the model ends a little before the thing that it stands for.
//!
//! A photo's pixels beyond an outline are surroundings, and what stands on the outline is left out of them, because it is
//! near ([`crate::layers::agreement`]). A skirt gives it back at its place: it continues the faces of an edge by a band, in the
//! plane through the edge that looks towards the photos, and shows the surroundings of the photos as far as they are *not* far
//! away. One sees through it elsewhere. Views draw skirts where no face is, so that they occlude nothing, and in a
//! photo's own camera both the skirt and what is behind it show that photo.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::agreement::{Agreement, AgreementGrid};
use super::hidden::{Culling, HiddenFaces};
use super::sources::{
    FILLED, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Server, Sources, Texels,
};
use super::surface::{RayHit, Surface};
use super::{DisplayMode, Shot};
use crate::error::Result;
use crate::geometry::Plane;
use crate::raster::robust::median;
use crate::scene::{Face, FaceId, Model, PhotoId};

/// The width of a skirt, as a share of the longer side of photos: coarse outlines are about as far off.
const BAND: f64 = 0.0075;

/// The part of the band's width by which a skirt begins within the faces, so that no gap is left between them.
const OVERLAP: f64 = 0.25;

/// The distance from an edge, as a share of the band's width, at which a photo is asked whether the edge is an outline.
const PROBE: f64 = 0.3;

/// The number of places along an edge at which photos are asked.
const PLACES: u32 = 5;

/// The largest number of photos that are asked about an edge.
const MOST_ASKED: usize = 12;

/// The agreement of surroundings below which they count as half near and half far away, and by which it is less or more
/// where they are one of both.
const HALF: f64 = 0.5;
const RAMP: f64 = 0.25;

/// The divisor of the confidence of what was filled, and its least alpha.
const FILLED_SHARE: u8 = 4;
const LEAST_ALPHA: u8 = 3;

/// Returns how much of what a photo shows at a pixel of its surroundings stands on an outline, 0 to 1, from its agreement.
fn standing(agreement: f64) -> f64 {
    let share = ((HALF + RAMP - agreement) / (2.0 * RAMP)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The skirts of a site: its model and sources, continued by one face for each skirt.
#[derive(Debug, Clone)]
pub struct Skirts {
    /// The model with the skirts' faces after its own.
    pub model: Arc<Model>,
    /// The sources with the skirts' servers and layer textures after their own.
    pub sources: Arc<Sources>,
    /// The number of their own layer textures.
    own_textures: u32,
    /// The layer textures of the surroundings, of which those of the skirts are made, in their order.
    surroundings: Vec<LayerTextureId>,
    /// The number of the model's own faces.
    own: u32,
    /// The faces that each skirt continues.
    continued: Vec<Vec<FaceId>>,
}

/// An edge of the model with the faces on it.
struct Edge {
    ends: [DVec3; 2],
    faces: Vec<FaceId>,
}

/// A strip along an edge.
struct Strip {
    /// The corners, counter-clockwise as the photos see it.
    corners: [DVec3; 4],
    plane: Plane,
}

impl Skirts {
    /// Returns a site without skirts.
    pub fn none(model: &Arc<Model>, sources: &Arc<Sources>) -> Self {
        Self {
            own: model.faces.len() as u32,
            continued: Vec::new(),
            own_textures: sources.layer_textures.len() as u32,
            surroundings: Vec::new(),
            model: model.clone(),
            sources: sources.clone(),
        }
    }

    /// Finds the skirts of a site; none where the photos have no surroundings. `surface` is the model's.
    pub fn new(model: &Arc<Model>, sources: &Arc<Sources>, surface: &Surface) -> Self {
        let mut skirts = Self::none(model, sources);
        if sources.surroundings.is_empty() {
            return skirts;
        }
        let hidden: HiddenFaces = model.face_ids().filter(|face| model.sees_through(*face)).collect();
        let finder = Finder { model, sources, surface, hidden: &hidden };
        let found: Vec<(Edge, Strip)> = edges(model)
            .into_par_iter()
            .filter_map(|edge| finder.strip(&edge).map(|strip| (edge, strip)))
            .collect();
        // The textures are there even where no edge is an outline: which edges are depends on which photos may texture a face,
        // which decisions change, and textures must stay.
        let of_photos =
            || sources.servers_of_surroundings().iter().filter(|server| !sources.is_dome(server.photo));
        let textures: BTreeSet<LayerTextureId> = of_photos().map(|server| server.layer_texture).collect();
        skirts.surroundings = textures.into_iter().collect();
        let (whole, all) = (Arc::make_mut(&mut skirts.model), Arc::make_mut(&mut skirts.sources));
        let texture =
            |id: &LayerTextureId| LayerTexture { see_through: true, ..sources.layer_texture(*id).clone() };
        all.layer_textures.extend(skirts.surroundings.iter().map(texture));
        for (edge, strip) in found {
            let of_strip = |server: &Server| {
                let at = skirts.surroundings.binary_search(&server.layer_texture).ok()?;
                let layer_texture = LayerTextureId(skirts.own_textures + at as u32);
                strip.server(sources, server, layer_texture)
            };
            let servers: Vec<Server> = of_photos().filter_map(of_strip).collect();
            let first = all.servers.len() as u32;
            all.servers.extend(servers);
            all.of_face.push(first..all.servers.len() as u32);
            push(whole, &strip, model.face(edge.faces[0]));
            skirts.continued.push(edge.faces);
        }
        skirts
    }

    /// Returns the faces of the skirts.
    pub fn faces(&self) -> Range<u32> {
        self.own..self.own + self.continued.len() as u32
    }

    /// Returns the layer textures of the skirts.
    pub fn textures(&self) -> impl Iterator<Item = LayerTextureId> + use<> {
        (self.own_textures..self.own_textures + self.surroundings.len() as u32).map(LayerTextureId)
    }

    /// Returns the layer textures of the skirts that are made of these.
    pub fn textures_of(&self, changed: &[LayerTextureId]) -> Vec<LayerTextureId> {
        let all = self.textures().zip(&self.surroundings);
        all.filter(|(_, of)| changed.contains(of)).map(|(texture, _)| texture).collect()
    }

    /// Returns the layer textures of sources that are not those of skirts.
    pub fn own_textures<'a>(&self, sources: &'a Sources) -> &'a [LayerTexture] {
        &sources.layer_textures[..self.own_textures as usize]
    }

    /// Returns the texels of all layer textures, given those of the sources' own, and the agreement of photos.
    pub fn texels(&self, own: Arc<dyn Texels>, agreement: &Agreement) -> Arc<dyn Texels> {
        let standing = self.surroundings.iter().map(|of| agreement.of(*of).cloned()).collect();
        Arc::new(SkirtTexels {
            own,
            own_textures: self.own_textures,
            of: self.surroundings.clone(),
            standing,
        })
    }

    /// Returns true when a face is a skirt.
    pub fn holds(&self, face: FaceId) -> bool {
        self.faces().contains(&face.0)
    }

    /// Returns the skirts of a view from the farthest to the nearest, without those whose faces are hidden; none where it does
    /// not show surroundings in which what stands on outlines counts less.
    pub fn of_view(&self, shot: &Shot) -> Vec<FaceId> {
        if !shot.surroundings || !shot.blend.agreement || shot.display != DisplayMode::Colour {
            return Vec::new();
        }
        let (eye, hidden) = (shot.viewpoint(), &shot.hidden);
        let is_seen = |of: &[FaceId]| of.iter().any(|face| !hidden.contains(*face));
        let seen = self.faces().zip(&self.continued).filter(|(_, of)| is_seen(of));
        let distance = |face: u32| {
            let corners = self.model.ring_points(FaceId(face));
            (corners.sum::<DVec3>() / 4.0).distance_squared(eye)
        };
        let mut ordered: Vec<(f64, FaceId)> = seen.map(|(face, _)| (distance(face), FaceId(face))).collect();
        ordered.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        ordered.into_iter().map(|(_, face)| face).collect()
    }
}

/// Returns where a ray meets a skirt of this model, as a hit of its face.
pub fn met(model: &Model, skirt: FaceId, origin: DVec3, direction: DVec3) -> Option<RayHit> {
    let plane = &model.face(skirt).plane;
    let t = -plane.signed_distance(origin) / plane.normal.dot(direction);
    let point = origin + direction * t;
    let corners: Vec<DVec3> = model.ring_points(skirt).collect();
    let is_inside = |at: usize| {
        let (from, to) = (corners[at], corners[(at + 1) % corners.len()]);
        plane.normal.dot((to - from).cross(point - from)) >= 0.0
    };
    let is_met = t.is_finite() && t > 0.0 && (0..corners.len()).all(is_inside);
    is_met.then_some(RayHit { t, face: skirt, triangle: 0 })
}

/// Returns the edges of all faces that one does not see through, each once, in a reproducible order. Edges that bridge a hole
/// are none.
fn edges(model: &Model) -> Vec<Edge> {
    let key = |point: DVec3| point.to_array().map(|at| (at + 0.0).to_bits());
    let mut found: BTreeMap<[[u64; 3]; 2], Edge> = BTreeMap::new();
    for face in model.face_ids().filter(|face| !model.face(*face).triangles.is_empty()) {
        if model.object(model.face(face).object).shows_what_is_behind() {
            continue;
        }
        let ring = model.ring(face);
        let pairs: BTreeSet<(u32, u32)> =
            (0..ring.len()).map(|at| (ring[at], ring[(at + 1) % ring.len()])).collect();
        for &(from, to) in pairs.iter().filter(|(from, to)| from != to && !pairs.contains(&(*to, *from))) {
            let ends = [from, to].map(|vertex| model.vertices[vertex as usize]);
            let mut keys = ends.map(key);
            keys.sort_unstable();
            let edge = found.entry(keys).or_insert_with(|| Edge { ends, faces: Vec::new() });
            edge.faces.push(face);
        }
    }
    found.into_values().collect()
}

/// The search for outlines.
struct Finder<'a> {
    model: &'a Model,
    sources: &'a Sources,
    surface: &'a Surface,
    /// The faces that one sees through.
    hidden: &'a HiddenFaces,
}

/// What one photo says of an edge that is an outline in it.
struct Outline {
    /// The unit direction from the edge to the camera.
    towards: DVec3,
    /// The width of a skirt, in world units.
    width: f64,
}

impl Finder<'_> {
    /// Returns the strip along an edge; `None` where it is an outline before surroundings in no photo.
    fn strip(&self, edge: &Edge) -> Option<Strip> {
        let [a, b] = edge.ends;
        let along = (b - a).try_normalize()?;
        let inwards: DVec3 = edge.faces.iter().map(|face| self.inwards(*face, a, b)).sum();
        let photos: BTreeSet<PhotoId> = edge
            .faces
            .iter()
            .flat_map(|face| self.sources.servers_of(*face))
            .map(|server| server.photo)
            .collect();
        let photos: Vec<PhotoId> = photos.into_iter().collect();
        let step = photos.len().div_ceil(MOST_ASKED).max(1);
        let outlines: Vec<Outline> = photos
            .iter()
            .step_by(step)
            .filter_map(|photo| self.outline(edge, along, inwards, self.sources.photo(*photo)))
            .collect();
        let towards = outlines.iter().map(|outline| outline.towards).sum::<DVec3>().try_normalize()?;
        let width = median(&mut outlines.iter().map(|outline| outline.width).collect::<Vec<_>>())?;
        let out = outwards(along, towards, inwards)?;
        let (from, to) = (a - along * width, b + along * width);
        let (within, beyond) = (-out * (OVERLAP * width), out * width);
        let normal = along.cross(out);
        let mut corners = [from + within, to + within, to + beyond, from + beyond];
        let is_turned = normal.dot(towards) < 0.0;
        if is_turned {
            corners.reverse();
        }
        let plane = Plane { normal: if is_turned { -normal } else { normal }, point: a };
        Some(Strip { corners, plane })
    }

    /// Returns the unit direction from the edge into a face, within its plane.
    fn inwards(&self, face: FaceId, a: DVec3, b: DVec3) -> DVec3 {
        let ring: Vec<DVec3> = self.model.ring_points(face).collect();
        let forwards = (0..ring.len()).any(|at| ring[at] == a && ring[(at + 1) % ring.len()] == b);
        let direction = self.model.face(face).plane.normal.cross(b - a).normalize_or_zero();
        if forwards { direction } else { -direction }
    }

    /// Asks a photo whether the edge is an outline in it: a face of the edge on one side, surroundings on the other.
    fn outline(&self, edge: &Edge, along: DVec3, inwards: DVec3, photo: &Projector) -> Option<Outline> {
        let (camera, eye) = (&photo.camera, photo.pose.center_in_world());
        let middle = (edge.ends[0] + edge.ends[1]) / 2.0;
        let out = outwards(along, (eye - middle).try_normalize()?, inwards)?;
        let longer = f64::from(camera.width.max(camera.height));
        let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
        let culling = Culling { hidden: self.hidden, ..Culling::nothing() };
        let widths: Vec<f64> = (0..PLACES)
            .filter_map(|place| {
                let share = (f64::from(place) + 0.5) / f64::from(PLACES);
                let at = edge.ends[0].lerp(edge.ends[1], share);
                let depth = photo.pose.camera_from_world(at).z;
                let width = BAND * longer * depth / camera.fx;
                let shown = |point: DVec3| {
                    let px = camera.image_from_camera(photo.pose.camera_from_world(point));
                    px.filter(|px| px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all())?;
                    Some(self.surface.first_visible(eye, point - eye, culling).map(|hit| hit.face))
                };
                let beside = out * (PROBE * width);
                let is_face = shown(at - beside)?.is_some_and(|face| edge.faces.contains(&face));
                (is_face && shown(at + beside)?.is_none()).then_some(width)
            })
            .collect();
        let width = widths.iter().copied().reduce(f64::max)?;
        Some(Outline { towards: (eye - middle).normalize(), width })
    }
}

/// Returns the unit direction across an edge, away from its faces, as seen from the direction `towards`.
fn outwards(along: DVec3, towards: DVec3, inwards: DVec3) -> Option<DVec3> {
    let across = along.cross(towards).try_normalize()?;
    Some(if across.dot(inwards) > 0.0 { -across } else { across })
}

impl Strip {
    /// Returns the server of the strip that a server of the surroundings makes with this layer texture; `None` where the strip
    /// is behind the camera.
    fn server(&self, sources: &Sources, of: &Server, layer_texture: LayerTextureId) -> Option<Server> {
        let pose = &sources.photo(of.photo).pose;
        let is_before = self.corners.iter().any(|corner| pose.camera_from_world(*corner).z > 0.0);
        let back = self.plane.signed_distance(pose.center_in_world()) < 0.0;
        is_before.then(|| Server { layer_texture, back, pinned: false, ..of.clone() })
    }
}

/// The texels of the skirts' layer textures, beside all others: a photo's surroundings, whose matte is how much of them stands on
/// outlines. Nothing does of what was filled, which hardly counts: what a photo shows through a tree stays as it is in its own
/// camera.
struct SkirtTexels {
    own: Arc<dyn Texels>,
    own_textures: u32,
    /// For each texture of a skirt the layer texture of which it is made, and its agreement; 1 throughout for `None`.
    of: Vec<LayerTextureId>,
    standing: Vec<Option<AgreementGrid>>,
}

impl Texels for SkirtTexels {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        let Some(at) = layer_texture.0.checked_sub(self.own_textures).map(|at| at as usize) else {
            return self.own.layer_texture(layer_texture);
        };
        let mut pixels = self.own.layer_texture(self.of[at])?;
        let (rect, grid) = (pixels.rect, self.standing[at].as_ref());
        let (texels, _) = pixels.rgba.as_chunks_mut::<4>();
        let mut matte = vec![0; texels.len()];
        let places = rect.pixels().zip(texels).zip(&pixels.needed).zip(&mut matte);
        for ((((x, y), texel), needed), matte) in places {
            if texel[3] == 0 {
                continue;
            }
            if *needed & FILLED != 0 {
                texel[3] = (texel[3] / FILLED_SHARE).max(LEAST_ALPHA);
                continue;
            }
            texel[3] = u8::MAX;
            let agreement =
                grid.map_or(1.0, |grid| grid.at(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)));
            *matte = (255.0 * standing(agreement)).round() as u8;
        }
        Ok(LayerTexturePixels { matte: Some(matte), ..pixels })
    }
}

/// Adds a strip to a model as a face of the object of another face. The object does not list it.
fn push(model: &mut Model, strip: &Strip, like: &Face) {
    let first = model.vertices.len() as u32;
    model.vertices.extend(strip.corners);
    let (ring, triangles) = (model.ring_vertices.len() as u32, model.triangles.len() as u32);
    model.ring_vertices.extend(first..first + 4);
    model.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    model.faces.push(Face {
        ring: ring..ring + 4,
        triangles: triangles..triangles + 2,
        plane: strip.plane,
        planar: true,
        ..like.clone()
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::geometry::PixelRect;
    use crate::projection::Domain;
    use crate::projection::sources::COVERED;
    use crate::scene::synthetic::{Modeller, centred, look_at};

    /// The number of rows and columns of the photos.
    const SIDE: u32 = 64;

    /// Two photos, from a little to the left and to the right, each with one layer of all faces and one of the surroundings.
    fn sources(model: &Model) -> Arc<Sources> {
        let eyes = [-1.0, 1.0].map(|x| DVec3::new(x, -10.0, 0.0));
        let projector = |eye: DVec3| Projector {
            name: String::new(),
            camera: centred(SIDE, SIDE, f64::from(SIDE)),
            pose: look_at(eye, DVec3::new(eye.x, 0.0, 0.0)),
        };
        let texture = |photo: u32| LayerTexture {
            photo: PhotoId(photo),
            id: String::new(),
            rect: PixelRect::of_size(SIDE, SIDE),
            see_through: false,
        };
        let server = |layer_texture: u32| Server {
            layer_texture: LayerTextureId(layer_texture),
            photo: PhotoId(layer_texture / 2),
            back: false,
            pinned: false,
            domain: Domain::Whole,
        };
        let faces = model.faces.len() as u32;
        let mut servers: Vec<Server> = (0..faces).flat_map(|_| [server(0), server(2)]).collect();
        servers.extend([server(1), server(3)]);
        Arc::new(Sources {
            photos: eyes.map(projector).to_vec(),
            layer_textures: [0, 0, 1, 1].map(texture).to_vec(),
            servers,
            of_face: (0..faces).map(|face| 2 * face..2 * face + 2).collect(),
            surroundings: 2 * faces..2 * faces + 2,
            ..Sources::default()
        })
    }

    fn wall(m: &mut Modeller, y: f64, half: f64) {
        let corner = DVec3::new(-half, y, -half);
        m.object(format!("wall {y}")).quad_facing(
            DVec3::NEG_Y,
            corner,
            DVec3::X * 2.0 * half,
            DVec3::Z * 2.0 * half,
        );
    }

    fn skirts(model: Arc<Model>) -> Skirts {
        let sources = sources(&model);
        Skirts::new(&model, &sources, &Surface::from_model(&model))
    }

    #[test]
    fn a_wall_before_the_sky_has_a_skirt_along_each_edge_that_continues_it() {
        let mut m = Modeller::new();
        wall(&mut m, 0.0, 2.0);
        let skirts = skirts(m.finish());
        assert_eq!(skirts.faces(), 1..5);
        // 0.75 % of 64 pixels at a distance of 10 focal lengths of 64 pixels.
        let width = BAND * 10.0;
        let mut reaches = Vec::new();
        for face in skirts.faces().map(FaceId) {
            let corners: Vec<DVec3> = skirts.model.ring_points(face).collect();
            let most = corners.iter().map(|p| p.x.abs().max(p.z.abs())).fold(0.0, f64::max);
            reaches.push(most);
            assert!(corners.iter().all(|corner| corner.y.abs() < 1e-9), "the plane looks towards the photos");
            let ring = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
            assert!(ring.y < 0.0 && skirts.model.face(face).plane.normal.dot(ring) > 0.0);
            assert_eq!(skirts.sources.servers_of(face).len(), 2);
        }
        assert!(reaches.iter().all(|reach| (reach - 2.0 - width).abs() < 1e-9), "{reaches:?}");
    }

    #[test]
    fn edges_before_another_face_and_edges_of_what_one_sees_through_have_none() {
        let mut m = Modeller::new();
        wall(&mut m, 0.0, 2.0);
        let before_a_larger_one = {
            wall(&mut m, 1.0, 50.0);
            skirts(m.finish())
        };
        assert!(before_a_larger_one.faces().is_empty());
        let mut m = Modeller::new();
        wall(&mut m, 0.0, 2.0);
        let through = Model::clone(&m.finish()).with_see_through(|_| true);
        assert!(skirts(Arc::new(through)).faces().is_empty());
    }

    #[test]
    fn views_that_hide_a_face_or_show_no_surroundings_have_none() {
        let mut m = Modeller::new();
        wall(&mut m, 0.0, 2.0);
        let skirts = skirts(m.finish());
        let photo = &skirts.sources.photos[0];
        let shot = Shot::new(photo.camera, photo.pose);
        let drawn = skirts.of_view(&shot);
        assert_eq!(drawn.len(), 4);
        let hidden = Shot { hidden: [FaceId(0)].into_iter().collect(), ..shot.clone() };
        assert!(skirts.of_view(&hidden).is_empty());
        assert!(skirts.of_view(&Shot { surroundings: false, ..shot.clone() }).is_empty());
        assert!(skirts.of_view(&Shot { display: DisplayMode::Layer, ..shot.clone() }).is_empty());
        // The ray beside the wall's right edge meets the skirt there, and the one far from it none.
        let right = |x: f64| {
            let direction = DVec3::new(x, 0.0, 0.0) - shot.viewpoint();
            drawn
                .iter()
                .filter(|skirt| met(&skirts.model, **skirt, shot.viewpoint(), direction).is_some())
                .count()
        };
        assert_eq!([right(2.03), right(2.2), right(1.5)], [1, 0, 0]);
    }

    /// Texels of which the first row is filled and the second one empty.
    struct Rows;

    impl Texels for Rows {
        fn layer_texture(&self, id: LayerTextureId) -> Result<LayerTexturePixels> {
            if id.0 > 3 {
                return Err(Error::Request("this is no layer texture of the site".into()));
            }
            let row =
                |y: u32| (if y == 0 { COVERED | FILLED } else { COVERED }, [99, 0, 40][y.min(2) as usize]);
            let all = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |_| row(y)));
            Ok(LayerTexturePixels {
                rect: PixelRect::of_size(SIDE, SIDE),
                rgba: all().flat_map(|(_, alpha)| [7, 8, 9, alpha]).collect(),
                needed: all().map(|(needed, _)| needed).collect(),
                matte: None,
            })
        }
    }

    #[test]
    fn what_counts_less_in_the_surroundings_is_what_a_skirt_shows_and_what_was_filled_hardly_counts() {
        let mut m = Modeller::new();
        wall(&mut m, 0.0, 2.0);
        let skirts = skirts(m.finish());
        let cells: BTreeMap<(u16, u16), u8> = (0..16).map(|y| ((y, 5), 3)).collect();
        let mut agreement = Agreement { of_texture: vec![None; 4] };
        agreement.of_texture[3] = AgreementGrid::new(DVec2::splat(0.25), &cells);
        let texels = skirts.texels(Arc::new(Rows), &agreement);
        let textures: Vec<LayerTextureId> = skirts.textures().collect();
        assert_eq!(textures, [LayerTextureId(4), LayerTextureId(5)]);
        assert_eq!(skirts.textures_of(&[LayerTextureId(3)]), [LayerTextureId(5)]);
        let [plain, standing] = [0, 1].map(|at| texels.layer_texture(textures[at]).unwrap());
        assert!(plain.matte.unwrap().iter().all(|matte| *matte == 0), "the sky alone");
        let at = |x: usize, y: usize| y * SIDE as usize + x;
        let matte = standing.matte.unwrap();
        // The sixth cell of four pixels, from pixel 20 on.
        assert_eq!([matte[at(22, 9)], matte[at(10, 9)]], [255, 0]);
        let alpha = |x: usize, y: usize| standing.rgba[4 * at(x, y) + 3];
        assert_eq!([alpha(22, 0), alpha(22, 1), alpha(22, 2)], [24, 0, 255]);
        assert_eq!(
            texels.layer_texture(LayerTextureId(3)).unwrap(),
            Rows.layer_texture(LayerTextureId(3)).unwrap()
        );
    }
}
