//! The surfaces of a stack as they appear in the photo: covered pixels, outlines, and depth.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use quadratura_base::geometry::clip::segment_in_box;
use quadratura_base::geometry::spans::Spans;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::FaceIndex;
use quadratura_document::stack::{Element, Stack};
use quadratura_layers::{ElementIndex, LayerIndex};
use quadratura_stacks::paint::parts::{PartSource, camera_of, points};

/// A flat surface, or a piece of one, in an image layer; or the surroundings.
#[derive(Debug, Clone)]
pub struct PeelShape {
    /// The unique name of the object; `[surroundings]` for the surroundings.
    pub object: String,
    /// The face's index within the object; `None` for the surroundings.
    pub face: Option<FaceIndex>,
    /// The element.
    pub element: ElementIndex,
    /// The visibility layer, 0 nearest.
    pub depth: u32,
    /// The index of its image layer in the stack.
    pub layer: LayerIndex,
    /// The index in the model's order; of coplanar surfaces the last one is drawn on top.
    pub rank: usize,
    /// The pixels of the photo that it covers.
    pub covered: Spans,
    /// The outline within the photo, without the bridges to holes.
    pub edges: Vec<Edge>,
    /// `None` for the surroundings, which are infinitely far away.
    plane: Option<CameraPlane>,
}

/// A straight part of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The ends in photo pixels.
    pub ends: [DVec2; 2],
    /// Whether the same element continues on the other side.
    pub inner: bool,
}

/// A plane in the camera's frame: `normal . p = offset`.
#[derive(Debug, Clone, Copy)]
struct CameraPlane {
    normal: DVec3,
    offset: f64,
}

impl PeelShape {
    /// Returns true when it covers a pixel.
    pub fn covers(&self, x: i32, y: i32) -> bool {
        self.covered.holds(x, y)
    }

    /// Returns its depth at the centre of a pixel, along the camera's axis, in world units; infinite for the
    /// surroundings.
    pub fn distance(&self, camera: &Pinhole, x: i32, y: i32) -> f64 {
        let ray = camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        self.plane.map_or(f64::INFINITY, |plane| plane.offset / plane.normal.dot(ray))
    }
}

/// Returns the surfaces of all image layers, in the order of the stack's image layers.
pub fn shapes_of(stack: &Stack) -> Vec<PeelShape> {
    let elements: Vec<(u32, &Element)> = (0u32..)
        .zip(&stack.visibility_layers)
        .flat_map(|(depth, elements)| elements.iter().map(move |element| (depth, element)))
        .collect();
    let (photo, camera) = (&stack.photo, &stack.camera);
    let scenery = PartSource { photo, camera, surfaces: &stack.surfaces, pieces: &stack.pieces };
    let view = PhotoCamera::from_stack(stack);
    let mut shapes = Vec::new();
    for (layer, image_layer) in stack.numbered_layers() {
        for &element in &image_layer.elements {
            let Some(&(depth, its)) = elements.get(element.index()) else { continue };
            let sharing = stack.image_layers.iter().filter(|other| other.elements.contains(&element)).count();
            let tile = (sharing > 1).then_some(image_layer.needed_rect);
            let parts = scenery.parts(&[(its, tile)], image_layer.rect);
            let outlines: Vec<Vec<DVec3>> =
                parts.list.iter().map(|part| points(part.own_outline())).collect();
            let shared = shared_edges(&outlines);
            for (part, outline) in parts.list.iter().zip(&outlines) {
                shapes.push(PeelShape {
                    object: part.object.to_owned(),
                    face: part.face,
                    element,
                    depth,
                    layer,
                    rank: part.rank,
                    covered: view.in_photo(parts.covered(part)),
                    edges: view.edges(outline, &shared),
                    plane: part.face.map(|_| view.plane(outline)),
                });
            }
        }
    }
    shapes
}

/// The ends of an edge in either direction, as the bits of their coordinates.
type EdgeKey = [[u64; 3]; 2];

/// Returns the key of an edge, independent of its direction.
fn key(from: DVec3, to: DVec3) -> EdgeKey {
    // Adding zero makes -0 and 0 equal.
    let mut ends = [from, to].map(|point| (point + DVec3::ZERO).to_array().map(f64::to_bits));
    ends.sort_unstable();
    ends
}

/// Iterates over the edges of a ring.
fn edges_of(ring: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Counts the outlines of one element that have each edge. A surface that is modelled once for each side counts
/// once, because nothing continues beyond its edges.
fn shared_edges(outlines: &[Vec<DVec3>]) -> BTreeMap<EdgeKey, u32> {
    let keys = |outline: &Vec<DVec3>| {
        let mut keys: Vec<EdgeKey> = edges_of(outline).map(|(from, to)| key(from, to)).collect();
        keys.sort_unstable();
        keys
    };
    let different: BTreeSet<Vec<EdgeKey>> = outlines.iter().map(keys).collect();
    let mut walked = BTreeMap::new();
    different.iter().flatten().for_each(|key| *walked.entry(*key).or_default() += 1);
    walked
}

/// The photo's camera.
struct PhotoCamera {
    camera: Pinhole,
    pose: Pose,
}

impl PhotoCamera {
    fn from_stack(stack: &Stack) -> Self {
        let (camera, pose) = camera_of(&stack.photo, &stack.camera);
        Self { camera, pose }
    }

    fn photo(&self) -> PixelRect {
        self.camera.rect()
    }

    /// Clips a set of pixels to the photo.
    fn in_photo(&self, covered: &Spans) -> Spans {
        let photo = self.photo();
        let rows = covered.rows().start.max(0)..covered.rows().end.min(photo.bottom());
        if rows.is_empty() {
            return Spans::default();
        }
        Spans::from_rows(rows, |y, out| {
            let cut = covered.row(y).iter().map(|run| run.start.max(0)..run.end.min(photo.right()));
            out.extend(cut.filter(|run| !run.is_empty()));
        })
    }

    /// Returns the visible edges of an outline.
    fn edges(&self, outline: &[DVec3], walked: &BTreeMap<EdgeKey, u32>) -> Vec<Edge> {
        let mut own: BTreeMap<EdgeKey, u32> = BTreeMap::new();
        edges_of(outline).for_each(|(from, to)| *own.entry(key(from, to)).or_default() += 1);
        let high = DVec2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        let edge = |(from, to): (DVec3, DVec3)| {
            let key = key(from, to);
            // An edge that the outline has twice is a bridge to a hole.
            if own[&key] > 1 {
                return None;
            }
            let ends = [from, to].map(|point| self.pose.camera_from_world(point));
            let [from, to] = segment_in_box(ends, &self.camera, DVec2::ZERO, high)?;
            let ends = [self.camera.image_from_camera(from)?, self.camera.image_from_camera(to)?];
            Some(Edge { ends, inner: walked.get(&key).is_some_and(|times| *times > 1) })
        };
        edges_of(outline).filter_map(edge).collect()
    }

    /// Returns the outline's plane in the camera's frame.
    fn plane(&self, outline: &[DVec3]) -> CameraPlane {
        let ring: Vec<DVec3> = outline.iter().map(|&point| self.pose.camera_from_world(point)).collect();
        let normal = quadratura_base::geometry::polygon::newell_normal(&ring);
        let middle = ring.iter().sum::<DVec3>() / ring.len().max(1) as f64;
        CameraPlane { normal, offset: normal.dot(middle) }
    }
}
