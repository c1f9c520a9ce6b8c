//! Defects of the model itself, independent of the photos.

use std::collections::hash_map::Entry;
use std::ops::ControlFlow;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use quadratura_base::error::Result;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::geometry::polygon::extent;
use quadratura_base::geometry::triangle::{Triangle, area_vector, crossing_depth};
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;

/// The model's triangles with nonzero area in a hierarchy, each with its face.
pub struct CheckedSurface {
    /// The triangles in world coordinates.
    pub tree: Bvh,
    /// The face of each triangle in the tree.
    pub faces: Vec<FaceId>,
}

impl CheckedSurface {
    /// Builds the hierarchy over the whole model.
    pub fn from_model(model: &Model) -> Self {
        let (mut triangles, mut faces) = (Vec::new(), Vec::new());
        for face in model.face_ids() {
            for corners in model.face_triangles(face) {
                let triangle: Triangle = corners.map(|v| model.vertices[v as usize]);
                if area_vector(&triangle) != DVec3::ZERO {
                    triangles.push(triangle);
                    faces.push(face);
                }
            }
        }
        Self { tree: Bvh::new(triangles), faces }
    }
}

/// Returns the faces without triangles.
pub fn degenerate(model: &Model) -> Vec<FaceId> {
    model.face_ids().filter(|&face| model.face_triangles(face).is_empty()).collect()
}

/// Returns the faces that are not planar.
pub fn not_planar(model: &Model) -> Vec<FaceId> {
    model.face_ids().filter(|&face| !model.face(face).planar).collect()
}

/// Corners closer to each other than this share of the model's extent count as equal.
const SAME_PLACE: f64 = 1e-7;

/// Faces that coincide, corner by corner.
#[derive(Default)]
pub struct Doubled {
    /// Faces with the same corners in the same order as an earlier face.
    pub duplicates: Vec<FaceId>,
    /// Faces with the same corners in the opposite order as another face: a wall modelled with two sides.
    pub two_sided: FxHashSet<FaceId>,
}

/// Finds faces with the same corners.
pub fn doubled(model: &Model) -> Doubled {
    let Some(&origin) = model.vertices.first() else { return Doubled::default() };
    let step = (extent(&model.vertices) * SAME_PLACE).max(f64::MIN_POSITIVE);
    let key = |p: DVec3| ((p - origin) / step).round().to_array().map(|x| x as i64);
    let mut first: FxHashMap<Vec<[i64; 3]>, FaceId> = FxHashMap::default();
    let mut doubled = Doubled::default();
    for face in model.face_ids().filter(|&face| !model.face_triangles(face).is_empty()) {
        let ring: Vec<[i64; 3]> = model.ring_points(face).map(key).collect();
        if let Some(&other_side) = first.get(&from_least(ring.iter().rev().copied().collect())) {
            doubled.two_sided.extend([other_side, face]);
        }
        match first.entry(from_least(ring)) {
            Entry::Occupied(_) => doubled.duplicates.push(face),
            Entry::Vacant(slot) => {
                slot.insert(face);
            }
        }
    }
    doubled
}

/// Rotates a ring so that its least corner comes first.
fn from_least(mut ring: Vec<[i64; 3]>) -> Vec<[i64; 3]> {
    let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
    ring.rotate_left(least);
    ring
}

/// Faces intersect when they reach through each other by more than this share of the smaller one's extent.
const CROSSING: f64 = 1e-2;

/// The number of triangle pairs after which the search is abandoned: a million overlapping faces have too many
/// pairs to test in reasonable time.
const MOST_PAIRS: u64 = 50_000_000;

/// The intersecting faces.
pub struct Crossings {
    /// The pairs, each in model order with its depth in world units; deepest first.
    pub pairs: Vec<([FaceId; 2], f64)>,
    /// Whether the search was abandoned, so that there may be more pairs.
    pub gave_up: bool,
}

/// Finds pairs of intersecting faces.
///
/// # Errors
/// Returns [`quadratura_base::Error::Cancelled`] on request.
pub fn crossings(model: &Model, surface: &CheckedSurface, task: &Task) -> Result<Crossings> {
    let extents: Vec<f64> =
        model.face_ids().map(|face| extent(&model.ring_points(face).collect::<Vec<_>>())).collect();
    let extent_of = |face: FaceId| extents[face.0 as usize];
    let triangles = surface.tree.triangles();
    let mut depths: FxHashMap<[FaceId; 2], f64> = FxHashMap::default();
    let mut looked_at = 0u64;
    let mut stopped = Ok(());
    let end = surface.tree.overlapping_pairs(|a, b| {
        looked_at += 1;
        if looked_at.is_multiple_of(1 << 16) {
            stopped = task.check_cancelled();
        }
        if looked_at > MOST_PAIRS || stopped.is_err() {
            return ControlFlow::Break(());
        }
        let mut pair = [a, b].map(|t| surface.faces[t as usize]);
        pair.sort_unstable();
        let depth = crossing_depth(&triangles[a as usize], &triangles[b as usize]);
        // The faces of an impostor are replaced by one rectangle.
        let turning = pair.iter().any(|face| model.impostor(*face).is_some());
        if pair[0] != pair[1] && !turning && depth > CROSSING * extent_of(pair[0]).min(extent_of(pair[1])) {
            let deepest = depths.entry(pair).or_default();
            *deepest = deepest.max(depth);
        }
        ControlFlow::Continue(())
    });
    stopped?;
    let mut pairs: Vec<_> = depths.into_iter().collect();
    pairs.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    Ok(Crossings { pairs, gave_up: end.is_break() })
}
