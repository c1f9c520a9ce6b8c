//! Lays a plane of the points on a plane of the model and searches the rest: the turn within the plane, the scale and the
//! two shifts. The model is a map of heights over its plane; points count where the map has a surface at their height.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec3};

use quadratura_base::geometry::Similarity;
use quadratura_base::geometry::triangle::{Triangle, area_vector};

use super::points::Points;
use super::surface::{ModelPlane, NormalisedModel};

/// Cells of the map along a side.
const CELLS: usize = 64;

/// A row of the map in memory: its cells and as many empty ones, which stand for what lies beside either side.
const STRIDE: usize = 2 * CELLS;

/// A map of one height, with space before the first row for shifts to the left.
const LAYER: usize = CELLS + CELLS * STRIDE;

/// Bins of heights: fine near the plane, coarse far from it.
const BINS: usize = 160;

/// The map is larger than the box of the model's plane, because the points' plane may reach farther.
const MARGIN: f64 = 1.6;

/// A scale is this much larger than the one before.
const SCALE_STEP: f64 = 1.03;

/// Scales are tried from a fifth to five times the ratio of the planes' sizes.
const SCALES: f64 = 5.0;

/// The map is made anew after so many scales, because heights are binned in the points' unit.
const SCALES_PER_MAP: usize = 2;

/// The poses that one pair of planes contributes.
const KEPT: usize = 120;

/// A plane of the points with what is counted over it.
pub struct Anchor {
    pub point: DVec3,
    /// Right-handed: u and v in the plane, and the normal towards the observers.
    pub axes: DMat3,
    pub radius: f64,
    /// Angles of likely directions against u, in radians.
    pub angles: Vec<f64>,
    /// Points in the anchor's axes, and on which surfaces each may lie.
    pub counted: Vec<(DVec3, SurfaceKind)>,
}

/// The surfaces that a point may lie on, judged by the plane that it lies on itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceKind {
    Parallel,
    Other,
    Any,
}

impl Anchor {
    /// Describes a plane of the points; `sample` are the points that are counted.
    pub fn new(points: &Points, index: usize, directions: &[DVec3], sample: &[u32]) -> Self {
        let plane = &points.planes[index];
        let u = directions.first().copied().unwrap_or_else(|| plane.normal.any_orthonormal_vector());
        let axes = DMat3::from_cols(u, plane.normal.cross(u), plane.normal);
        let angle = |direction: &DVec3| direction.dot(axes.y_axis).atan2(direction.dot(axes.x_axis));
        let kind =
            |plane: Option<u32>| match plane.map(|of| points.planes[of as usize].normal.dot(axes.z_axis)) {
                None => SurfaceKind::Any,
                Some(cos) if cos.abs() > PARALLEL_COS => SurfaceKind::Parallel,
                Some(_) => SurfaceKind::Other,
            };
        let counted = sample
            .iter()
            .map(|i| &points.sights[*i as usize])
            .map(|sight| (axes.transpose() * (sight.point - plane.point), kind(sight.plane)))
            .collect();
        Self {
            point: plane.point,
            axes,
            radius: plane.radius,
            angles: directions.iter().map(angle).collect(),
            counted,
        }
    }
}

/// Surfaces within 15 degrees count as parallel to the plane.
const PARALLEL_COS: f64 = 0.966;

/// A piece of the model over a cell of the map.
#[derive(Clone, Copy)]
struct ModelPatch {
    cell: u32,
    height: f32,
    parallel: bool,
}

/// The model over one of its planes.
pub struct PlaneHeights {
    /// Right-handed: u and v in the plane, and the side of the plane that is seen.
    axes: DMat3,
    /// The place of the map's corner in the plane, in the model's coordinates.
    corner: DVec3,
    /// The side of a cell, in radii of the model.
    cell: f64,
    pieces: Vec<ModelPatch>,
    angles: Vec<f64>,
    /// Half the side of a square as large as the plane's faces.
    size: f64,
}

/// Returns the best poses with a plane of the points on a plane of the model.
pub fn starts(relief: &PlaneHeights, anchor: &Anchor) -> Vec<Similarity> {
    let guess = anchor.radius / relief.size;
    let turns = turns(&anchor.angles, &relief.angles);
    let steps = (2.0 * SCALES.ln() / SCALE_STEP.ln()).ceil() as usize;
    let (mut map, mut found) = (HeightMap::new(), Vec::new());
    let (mut least, mut of_count) = (1u8, [0usize; 256]);
    for step in 0..steps {
        let scale = |step: usize| guess / SCALES * SCALE_STEP.powi(step as i32);
        if step % SCALES_PER_MAP == 0 {
            map.fill(&relief.pieces, scale(step) * SCALE_STEP.sqrt());
        }
        for turn in &turns {
            let per_cell = 1.0 / (scale(step) * relief.cell);
            let counts = map.count(&anchor.counted, *turn, per_cell);
            for (cell, count) in best_two(&counts, least) {
                found.push((count, step, *turn, cell));
                of_count[usize::from(count)] += 1;
            }
            // Fewer than the last of the kept ones count need not be looked at.
            while of_count[usize::from(least) + 1..].iter().sum::<usize>() >= KEPT {
                least += 1;
            }
        }
    }
    found.sort_by_key(|start| std::cmp::Reverse(start.0));
    found.truncate(KEPT);
    let pose = |(_, step, turn, cell): (u8, usize, f64, usize)| {
        let scale = guess / SCALES * SCALE_STEP.powi(step as i32);
        let place = relief.corner
            + relief.axes.x_axis * ((cell % CELLS) as f64 + 0.5) * relief.cell
            + relief.axes.y_axis * ((cell / CELLS) as f64 + 0.5) * relief.cell;
        let rotation = anchor.axes * DMat3::from_rotation_z(turn) * relief.axes.transpose();
        Similarity { scale, rotation, translation: anchor.point - rotation * (place * scale) }
    };
    found.into_iter().map(pose).collect()
}

/// Returns the turns, in radians, that bring a direction of the model's plane on one of the points' plane, in quarters.
fn turns(of_points: &[f64], of_model: &[f64]) -> Vec<f64> {
    const SAME: f64 = 0.026; // 1.5 degrees
    let mut turns: Vec<f64> = Vec::new();
    for (a, b) in of_points.iter().flat_map(|a| of_model.iter().map(move |b| (a, b))) {
        let turn = (a - b).rem_euclid(FRAC_PI_2);
        let apart = |other: &f64| {
            let off = (turn - other).abs();
            off.min(FRAC_PI_2 - off) > SAME
        };
        if turns.iter().all(apart) {
            turns.push(turn);
        }
    }
    turns.iter().flat_map(|turn| (0..4).map(move |quarter| turn + f64::from(quarter) * FRAC_PI_2)).collect()
}

impl PlaneHeights {
    /// Maps the model over its plane `on`, seen from its front (`side` 1) or from behind (-1).
    pub fn new(surface: &NormalisedModel, on: &ModelPlane, side: f64) -> Self {
        let (normal, u) = (on.normal * side, on.directions[0]);
        let u = u.reject_from(normal).normalize();
        let axes = DMat3::from_cols(u, normal.cross(u), normal);
        let flat = |p: DVec3| axes.transpose() * (p - on.point);
        let triangles = surface.tree.triangles();
        let corners = on.triangles.iter().flat_map(|t| triangles[*t as usize]).map(flat);
        let (low, high) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let side = MARGIN * (high - low).truncate().max_element();
        let cell = side / CELLS as f64;
        let corner_flat = 0.5 * (low + high) - DVec3::new(0.5 * side, 0.5 * side, 0.0);
        let corner_flat = DVec3::new(corner_flat.x, corner_flat.y, 0.0);
        let mut pieces = Vec::new();
        for (triangle, n) in triangles.iter().zip(&surface.normals) {
            let parallel = n.dot(normal).abs() > PARALLEL_COS;
            let triangle: Triangle = triangle.map(|p| (flat(p) - corner_flat) / DVec3::new(cell, cell, 1.0));
            sample_triangle(&triangle, cell, |at, height| {
                let piece = ModelPatch { cell: at, height: height as f32, parallel };
                pieces.push(piece);
            });
        }
        pieces.sort_by(|a, b| a.cell.cmp(&b.cell).then(a.height.total_cmp(&b.height)));
        pieces.dedup_by(|a, b| {
            a.cell == b.cell
                && a.parallel == b.parallel
                && (a.height - b.height).abs() < 2e-3 * (b.height.abs() + 0.01)
        });
        let angle = |direction: &DVec3| direction.dot(axes.y_axis).atan2(direction.dot(axes.x_axis));
        Self {
            axes,
            corner: on.point + axes * corner_flat,
            cell,
            pieces,
            angles: on.directions.iter().map(angle).collect(),
            size: (0.5 * on.area.sqrt()).max(0.36 * 0.5 * side),
        }
    }
}

/// Calls `visit` with cell and height of samples of a triangle, whose x and y are in cells and whose z is in radii;
/// about 0.7 cells apart, and at least one.
fn sample_triangle(&[a, b, c]: &Triangle, cell: f64, mut visit: impl FnMut(u32, f64)) {
    const APART: f64 = 0.7;
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    let most = CELLS as f64;
    if high.x < 0.0 || high.y < 0.0 || low.x >= most || low.y >= most {
        return;
    }
    let mut put = |p: DVec3| {
        if p.x >= 0.0 && p.y >= 0.0 && p.x < most && p.y < most {
            visit(p.y as u32 * CELLS as u32 + p.x as u32, p.z);
        }
    };
    let tall = DVec3::new(1.0, 1.0, 1.0 / cell);
    let flat = area_vector(&[a, b, c]).z.abs();
    if flat < 0.05 * area_vector(&[a * tall, b * tall, c * tall]).length() {
        // An upright face: samples along its edges and between them.
        let longest = ((b - a) * tall).length().max(((c - a) * tall).length()).min(6.0 * most);
        let count = (longest / APART).ceil().clamp(1.0, 200.0) as u32;
        for i in 0..=count {
            let (from, to) =
                (a.lerp(b, f64::from(i) / f64::from(count)), a.lerp(c, f64::from(i) / f64::from(count)));
            let across = (((to - from) * tall).length() / APART).ceil().clamp(1.0, 200.0) as u32;
            (0..=across).for_each(|k| put(from.lerp(to, f64::from(k) / f64::from(across))));
        }
        return;
    }
    // A sloped one: at the middles of the cells that it covers, and at its corners.
    let [x0, y0] = [low.x, low.y].map(|x| x.floor().max(0.0) as u32);
    let [x1, y1] = [high.x, high.y].map(|x| x.ceil().min(most) as u32);
    let area = area_vector(&[a, b, c]).z;
    for y in y0..y1 {
        for x in x0..x1 {
            let p = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
            let part = |from: DVec3, to: DVec3| {
                ((from.x - p.x) * (to.y - p.y) - (from.y - p.y) * (to.x - p.x)) / area
            };
            let (of_a, of_b) = (part(b, c), part(c, a));
            let of_c = 1.0 - of_a - of_b;
            if of_a >= -0.02 && of_b >= -0.02 && of_c >= -0.02 {
                put(DVec3::new(p.x, p.y, of_a * a.z + of_b * b.z + of_c * c.z));
            }
        }
    }
    [a, b, c].into_iter().for_each(put);
}

/// For each bin of heights and each kind of surface, the cells that have one there; only bins with some are held.
struct HeightMap {
    slots: [[Option<u32>; BINS]; 3],
    layers: Vec<u8>,
    used: usize,
    /// The bin of a height by the upper bits of its number.
    bins: Vec<u8>,
}

impl HeightMap {
    fn new() -> Self {
        let bin = |upper: u32| {
            let height = f32::from_bits(upper << 16);
            let off = 10.0 * (height / 0.012).asinh();
            if off.is_finite() { off.round().min(BINS as f32 / 2.0 - 2.0) as u8 } else { 0 }
        };
        let bins = (0..1u32 << 15).map(bin).collect();
        Self { slots: [[None; BINS]; 3], layers: Vec::new(), used: 0, bins }
    }

    /// The bin of a height, in the points' unit.
    fn bin(&self, height: f32) -> usize {
        let off = usize::from(self.bins[(height.abs().to_bits() >> 16) as usize]);
        if height < 0.0 { BINS / 2 - off } else { BINS / 2 + off }
    }

    /// Marks the model's surfaces, enlarged by `scale`.
    fn fill(&mut self, pieces: &[ModelPatch], scale: f64) {
        self.slots = [[None; BINS]; 3];
        self.layers[..self.used * LAYER].fill(0);
        self.used = 0;
        for piece in pieces {
            let bin = self.bin(piece.height * scale as f32);
            let kind = if piece.parallel { SurfaceKind::Parallel } else { SurfaceKind::Other };
            for bin in bin - 1..=bin + 1 {
                for kind in [kind, SurfaceKind::Any] {
                    let at = self.layer(kind, bin);
                    let (x, y) = (piece.cell as usize % CELLS, piece.cell as usize / CELLS);
                    self.layers[at + CELLS + y * STRIDE + x] = 1;
                }
            }
        }
    }

    /// Returns where the layer of a bin begins, which is made if there is none.
    fn layer(&mut self, kind: SurfaceKind, bin: usize) -> usize {
        if let Some(slot) = self.slots[kind as usize][bin] {
            return slot as usize * LAYER;
        }
        let slot = self.used;
        self.used += 1;
        if self.layers.len() < self.used * LAYER {
            self.layers.resize(self.used * LAYER, 0);
        }
        self.slots[kind as usize][bin] = Some(slot as u32);
        slot * LAYER
    }

    /// Counts, for each cell of the map, the points that have a surface at their height if the anchor's middle is there.
    fn count(&self, points: &[(DVec3, SurfaceKind)], turn: f64, per_cell: f64) -> [u64; CELLS * CELLS / 8] {
        let mut counts = [0u64; CELLS * CELLS / 8];
        let (sin, cos) = turn.sin_cos();
        for (point, kind) in points {
            // From the points' axes to the model's: the turn back.
            let x = ((point.x * cos + point.y * sin) * per_cell).round();
            let y = ((point.y * cos - point.x * sin) * per_cell).round();
            let most = CELLS as f64;
            if x.abs() >= most || y.abs() >= most {
                continue;
            }
            let Some(slot) = self.slots[*kind as usize][self.bin(point.z as f32)] else { continue };
            let (x, y) = (x as isize, y as isize);
            let first = (-y).max(0) as usize;
            let last = (CELLS as isize - y).min(CELLS as isize) as usize;
            let start = slot as usize * LAYER + CELLS;
            for row in first..last {
                let from = (start + (row as isize + y) as usize * STRIDE).wrapping_add_signed(x);
                let (from, _) = self.layers[from..from + CELLS].as_chunks::<8>();
                // At most 255 points are counted, so that no byte overflows into the next.
                for (sum, from) in counts[row * 8..row * 8 + 8].iter_mut().zip(from) {
                    *sum += u64::from_le_bytes(*from);
                }
            }
        }
        counts
    }
}

/// Returns the cell with the highest count, and the next one that is not its neighbour, as far as they count `least`.
fn best_two(counts: &[u64; CELLS * CELLS / 8], least: u8) -> Vec<(usize, u8)> {
    let mut counts: [u8; CELLS * CELLS] =
        *counts.map(u64::to_le_bytes).as_flattened().first_chunk().expect("as many bytes");
    let mut found = Vec::new();
    for _ in 0..2 {
        let most = counts.iter().copied().fold(0, u8::max);
        if most < least {
            break;
        }
        let cell = counts.iter().position(|count| *count == most).expect("it is one of them");
        found.push((cell, most));
        let (x, y) = (cell % CELLS, cell / CELLS);
        for row in y.saturating_sub(2)..(y + 3).min(CELLS) {
            counts[row * CELLS + x.saturating_sub(2)..row * CELLS + (x + 3).min(CELLS)].fill(0);
        }
    }
    found
}
