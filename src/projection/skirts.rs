//! Skirts: strips along the outlines of the model, on which views show what stands there although no face covers it: cornices
//! and tiles, wherever the model ends a little before the thing that it stands for.
//!
//! A photo's pixels beyond an outline are surroundings, and what stands on the outline is left out of them, because it is
//! near (`layers::agreement`). A skirt gives it back at its place: it continues the faces of an edge by a band, in the
//! plane through the edge that looks towards the photos, and shows the surroundings of the photos as far as they are *not* far
//! away. One sees through it elsewhere. Views draw skirts where no face is, so that they occlude nothing, and in a
//! photo's own camera both the skirt and what is behind it show that photo.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::agreement::Agreement;
use super::model_surface::{ModelSurface, RayHit};
use super::sources::{
    FILLED, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Server, Sources, Texels,
};
use quadratura_base::error::Result;
use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::{PixelRect, Plane};
use quadratura_base::raster::robust::median;
use quadratura_base::scene::{Face, FaceId, Model, PhotoId};
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::hidden::{Culling, HiddenFaces};
use quadratura_view::{DisplayMode, Shot};

/// The width of a skirt, as a share of the longer side of photos: coarse outlines are about as far off.
pub const BAND: f64 = 0.0075;

/// The part of the band's width by which a skirt begins within the faces, so that no gap is left between them.
const OVERLAP: f64 = 0.25;

/// The distance from an edge, as a share of the band's width, at which a photo is asked whether the edge is an outline.
const PROBE: f64 = 0.3;

/// The number of places along an edge at which photos are asked.
const PLACES: u32 = 5;

/// The largest number of photos that are asked about an edge.
const MOST_ASKED: usize = 12;

/// The agreement of surroundings of which one half stands on an outline, and the distance from it at which all of them do, or
/// none.
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

/// Returns whether most of what a photo shows at a pixel of its surroundings stands on an outline, from its agreement.
pub fn rises_above_outline(agreement: f64) -> bool {
    agreement < HALF
}

/// Returns whether nothing of what a photo shows at a pixel of its surroundings stands on an outline, from its agreement.
pub fn is_far_away(agreement: f64) -> bool {
    agreement >= HALF + RAMP
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
struct ModelEdge {
    ends: [DVec3; 2],
    faces: Vec<FaceId>,
}

/// A strip along an edge.
struct SkirtStrip {
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
    pub fn new(model: &Arc<Model>, sources: &Arc<Sources>, surface: &ModelSurface) -> Self {
        let mut skirts = Self::none(model, sources);
        if sources.surroundings.is_empty() {
            return skirts;
        }
        let sees_through = model.face_ids().filter(|face| model.sees_through(*face));
        let hidden: HiddenFaces = sees_through.chain(sources.far.iter()).collect();
        let finder = OutlineFinder { model, sources, surface, hidden: &hidden };
        let found: Vec<(ModelEdge, SkirtStrip)> = edges(model, &sources.far)
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

    /// Returns the layer textures of the skirts, each with that of the surroundings of which it is made.
    pub fn made_of(&self) -> impl Iterator<Item = (LayerTextureId, LayerTextureId)> {
        self.textures().zip(self.surroundings.iter().copied())
    }

    /// Returns whether a layer texture is one of the skirts'.
    pub fn is_texture(&self, id: LayerTextureId) -> bool {
        id.0 >= self.own_textures
    }

    /// Returns the layer textures of the skirts that are made of those that `changed` names.
    pub fn textures_of(&self, changed: impl Fn(LayerTextureId) -> bool) -> Vec<LayerTextureId> {
        let all = self.textures().zip(&self.surroundings);
        all.filter(|(_, of)| changed(**of)).map(|(texture, _)| texture).collect()
    }

    /// Returns the layer textures of sources that are not those of skirts.
    pub fn own_textures<'a>(&self, sources: &'a Sources) -> &'a [LayerTexture] {
        &sources.layer_textures[..self.own_textures as usize]
    }

    /// Returns the texels of all layer textures, given those of the sources' own, and the agreement of photos.
    pub fn texels(&self, own: Arc<dyn Texels>, agreement: &Agreement) -> Arc<dyn Texels> {
        let standing = self.surroundings.iter().map(|of| agreement.of(*of).cloned()).collect();
        let outlines = self.surroundings.iter().map(|of| agreement.outline_of(*of).cloned()).collect();
        let rect = |id: &LayerTextureId| self.sources.layer_texture(*id).rect;
        let of = self.surroundings.iter().map(|id| (*id, rect(id))).collect();
        Arc::new(SkirtTexels { own, own_textures: self.own_textures, of, standing, outlines })
    }

    /// Returns true when a face is a skirt.
    pub fn holds(&self, face: FaceId) -> bool {
        self.faces().contains(&face.0)
    }

    /// Returns whether a view shows skirts: where it shows surroundings in which what stands on outlines counts less.
    pub fn are_in(&self, shot: &Shot) -> bool {
        shot.surroundings && shot.blend.agreement && shot.display == DisplayMode::Colour
    }

    /// Returns the skirts of a view from the farthest to the nearest, without those whose faces are hidden.
    pub fn of_view(&self, shot: &Shot) -> Vec<FaceId> {
        if !self.are_in(shot) {
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

/// Returns the edges of all faces that one does not see through, without those of far backdrops, each once, in a reproducible
/// order. Edges that bridge a hole
/// are none.
fn edges(model: &Model, far: &HiddenFaces) -> Vec<ModelEdge> {
    let key = |point: DVec3| point.to_array().map(|at| (at + 0.0).to_bits());
    let mut found: BTreeMap<[[u64; 3]; 2], ModelEdge> = BTreeMap::new();
    for face in model.face_ids().filter(|face| !model.face(*face).triangles.is_empty()) {
        if far.contains(face) || model.object(model.face(face).object).shows_what_is_behind() {
            continue;
        }
        let ring = model.ring(face);
        let pairs: BTreeSet<(u32, u32)> =
            (0..ring.len()).map(|at| (ring[at], ring[(at + 1) % ring.len()])).collect();
        for &(from, to) in pairs.iter().filter(|(from, to)| from != to && !pairs.contains(&(*to, *from))) {
            let ends = [from, to].map(|vertex| model.vertices[vertex as usize]);
            let mut keys = ends.map(key);
            keys.sort_unstable();
            let edge = found.entry(keys).or_insert_with(|| ModelEdge { ends, faces: Vec::new() });
            edge.faces.push(face);
        }
    }
    found.into_values().collect()
}

/// The search for outlines.
struct OutlineFinder<'a> {
    model: &'a Model,
    sources: &'a Sources,
    surface: &'a ModelSurface,
    /// The faces that one sees through, and those of far backdrops.
    hidden: &'a HiddenFaces,
}

/// What one photo says of an edge that is an outline in it.
struct Outline {
    /// The unit direction from the edge to the camera.
    towards: DVec3,
    /// The width of a skirt, in world units.
    width: f64,
}

impl OutlineFinder<'_> {
    /// Returns the strip along an edge; `None` where it is an outline before surroundings in no photo.
    fn strip(&self, edge: &ModelEdge) -> Option<SkirtStrip> {
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
        // Skirts of short edges would lie over each other many times.
        let past = along * width.min(a.distance(b) / 2.0);
        let (from, to) = (a - past, b + past);
        let (within, beyond) = (-out * (OVERLAP * width), out * width);
        let normal = along.cross(out);
        let mut corners = [from + within, to + within, to + beyond, from + beyond];
        let is_turned = normal.dot(towards) < 0.0;
        if is_turned {
            corners.reverse();
        }
        let plane = Plane { normal: if is_turned { -normal } else { normal }, point: a };
        Some(SkirtStrip { corners, plane })
    }

    /// Returns the unit direction from the edge into a face, within its plane.
    fn inwards(&self, face: FaceId, a: DVec3, b: DVec3) -> DVec3 {
        let ring: Vec<DVec3> = self.model.ring_points(face).collect();
        let forwards = (0..ring.len()).any(|at| ring[at] == a && ring[(at + 1) % ring.len()] == b);
        let direction = self.model.face(face).plane.normal.cross(b - a).normalize_or_zero();
        if forwards { direction } else { -direction }
    }

    /// Asks a photo whether the edge is an outline in it: a face of the edge on one side, surroundings on the other.
    fn outline(&self, edge: &ModelEdge, along: DVec3, inwards: DVec3, photo: &Projector) -> Option<Outline> {
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

impl SkirtStrip {
    /// Returns the server of the strip that a server of the surroundings makes with this layer texture; `None` where the photo's
    /// layer does not show the strip.
    fn server(&self, sources: &Sources, of: &Server, layer_texture: LayerTextureId) -> Option<Server> {
        let Projector { camera, pose, .. } = sources.photo(of.photo);
        let rect = sources.layer_texture(of.layer_texture).rect;
        let [low, high] = [[rect.x, rect.y], [rect.right(), rect.bottom()]];
        let [low, high] = [low, high].map(|[x, y]| DVec2::new(f64::from(x), f64::from(y)));
        let corners = self.corners.map(|corner| pose.camera_from_world(corner));
        let back = self.plane.signed_distance(pose.center_in_world()) < 0.0;
        let is_shown = !clipped_to_box(&corners, camera, low, high).is_empty();
        is_shown.then(|| Server { layer_texture, back, pinned: false, ..of.clone() })
    }
}

/// The texels of the skirts' layer textures, beside all others: a photo's surroundings, whose matte is how much of them stands on
/// outlines. Nothing does of what was filled, which hardly counts: what a photo shows through a tree stays as it is in its own
/// camera.
struct SkirtTexels {
    own: Arc<dyn Texels>,
    own_textures: u32,
    /// For each texture of a skirt the layer texture of which it is made, with its rectangle, and its agreement; 1 throughout
    /// for `None`.
    of: Vec<(LayerTextureId, PixelRect)>,
    standing: Vec<Option<AgreementGrid>>,
    /// How much of their pixels is something else than sky, likewise.
    outlines: Vec<Option<AgreementGrid>>,
}

impl Texels for SkirtTexels {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        let Some(at) = layer_texture.0.checked_sub(self.own_textures).map(|at| at as usize) else {
            return self.own.layer_texture(layer_texture);
        };
        let (of, place) = self.of[at];
        // Views with skirts need the surroundings, too, and report those that cannot be read.
        let Ok(mut pixels) = self.own.layer_texture(of) else {
            let rect = PixelRect { w: 1, h: 1, ..place };
            return Ok(LayerTexturePixels { rect, rgba: vec![0; 4], needed: vec![0], matte: Some(vec![0]) });
        };
        let rect = pixels.rect;
        let value = |grids: &[Option<AgreementGrid>], x: i32, y: i32| {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            grids[at].as_ref().map_or(1.0, |grid| grid.at(px))
        };
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
            let stands = standing(value(&self.standing, x, y));
            *matte = (255.0 * stands * value(&self.outlines, x, y)).round() as u8;
        }
        Ok(LayerTexturePixels { matte: Some(matte), ..pixels })
    }
}

/// Adds a strip to a model as a face of the object of another face. The object does not list it.
fn push(model: &mut Model, strip: &SkirtStrip, like: &Face) {
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
mod tests;
