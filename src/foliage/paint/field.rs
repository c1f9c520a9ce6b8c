//! The paint of a sub-object, found again at any point of it.

use glam::{DMat3, DVec3};

use super::change::Change;
use super::frame::SlabFrame;
use super::slabs::PaintedSlab;
use crate::bounds::Ball;

/// Paint reaches this many texels around the point where it was put. Surfaces within 1.5 texels of depth share a sample, whose
/// depth is their mean.
const REACH: f64 = 2.0;

/// The paint of a sub-object: that of several files, in the order in which they were imported. Each changes what those before it show.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PaintField {
    documents: Vec<Vec<Slab>>,
}

/// A slab's points by the texel in which they are.
#[derive(Debug, Clone, PartialEq)]
struct Slab {
    paint: PaintedSlab,
    view_from_object: DMat3,
    /// The points in rotated coordinates, less the corner of the image, in texels; in the order of `first`.
    points: Vec<SlabPoint>,
    /// Columns and rows of texels that have points: the first ones, and how many.
    low: [i32; 2],
    size: [usize; 2],
    /// For each of these texels, row by row, where its points begin, and at last the number of all.
    first: Vec<u32>,
    /// The depths of the nearest point and of the slab's far end, in texels.
    depths: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct SlabPoint {
    at: [f32; 3],
    change: Change,
    leaf: bool,
}

/// A change that was found, with how far it is, in texels.
#[derive(Clone, Copy)]
struct FoundChange {
    distance: f64,
    change: Change,
}

impl FoundChange {
    fn nearer(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(a), Some(b)) => Some(if b.distance < a.distance { b } else { a }),
            (a, b) => a.or(b),
        }
    }
}

impl PaintField {
    /// Makes the paint of files in the order in which they were imported, each a list of painted slabs.
    pub fn new(documents: Vec<Vec<PaintedSlab>>) -> Self {
        let documents = documents.into_iter().map(|mut slabs| {
            slabs.sort_by_key(|slab| (slab.direction, slab.slab));
            slabs.into_iter().filter(|slab| !slab.points.is_empty()).map(Slab::new).collect::<Vec<_>>()
        });
        Self { documents: documents.filter(|slabs| !slabs.is_empty()).collect() }
    }

    /// Returns true where there is no paint.
    pub fn is_empty(&self) -> bool {
        self.documents.is_empty()
    }

    /// Returns the painted slabs of each file.
    pub fn documents(&self) -> impl Iterator<Item = impl Iterator<Item = &PaintedSlab>> {
        self.documents.iter().map(|slabs| slabs.iter().map(|slab| &slab.paint))
    }

    /// Returns the change of a surface at a point, in the frame of the sub-object that was painted. Of each file it is that of the
    /// nearest painted point within two texels, unless a point that was seen from the same direction and not painted is nearer; a
    /// leaf that others hide from a direction has the change of those that hide it.
    pub fn at(&self, point: DVec3, is_leaf: bool) -> Change {
        let of = |slabs: &Vec<Slab>| in_document(slabs, point, is_leaf);
        self.documents.iter().filter_map(of).fold(Change::NONE, |all, change| all.then(&change))
    }

    /// Returns whether paint may reach something in a ball, in the frame of the sub-object that was painted.
    pub fn touches(&self, ball: &Ball) -> bool {
        self.documents.iter().flatten().any(|slab| slab.touches(ball))
    }
}

/// Returns the change that one file makes at a point.
fn in_document(slabs: &[Slab], point: DVec3, is_leaf: bool) -> Option<Change> {
    let (mut best, mut of_direction): (Option<FoundChange>, Option<FoundChange>) = (None, None);
    let painted = |found: Option<FoundChange>| found.filter(|found| !found.change.is_none());
    for (index, slab) in slabs.iter().enumerate() {
        of_direction = FoundChange::nearer(of_direction, slab.find(point, is_leaf));
        let next = slabs.get(index + 1);
        if next.is_none_or(|next| next.paint.direction != slab.paint.direction) {
            best = FoundChange::nearer(best, painted(of_direction.take()));
        }
    }
    best.map(|found| found.change)
}

impl Slab {
    fn new(paint: PaintedSlab) -> Self {
        let view_from_object = SlabFrame::rotation(paint.direction);
        let [x, y] = paint.corner;
        let corner = DVec3::new(x, y, 0.0);
        let in_texels = |at: DVec3| (view_from_object * at - corner) / paint.delta;
        let mut points: Vec<([i32; 2], SlabPoint)> = Vec::with_capacity(paint.points.len());
        for of in &paint.points {
            let at = in_texels(of.at.as_dvec3());
            let point = SlabPoint { at: at.as_vec3().to_array(), change: of.change, leaf: of.leaf };
            points.push((texel(at), point));
        }
        // Stable: points of one texel stay in their order.
        points.sort_by_key(|([column, row], _)| (*row, *column));
        let columns = || points.iter().map(|([column, _], _)| *column);
        let rows = || points.iter().map(|([_, row], _)| *row);
        let low = [columns().min().unwrap_or(0), rows().min().unwrap_or(0)];
        let high = [columns().max().unwrap_or(0), rows().max().unwrap_or(0)];
        let size = [0, 1].map(|axis| (i64::from(high[axis]) - i64::from(low[axis]) + 1) as usize);
        let mut first = vec![0u32; size[0] * size[1] + 1];
        for ([column, row], _) in &points {
            first[(row - low[1]) as usize * size[0] + (column - low[0]) as usize + 1] += 1;
        }
        (1..first.len()).for_each(|index| first[index] += first[index - 1]);
        let nearest = points.iter().fold(f64::INFINITY, |low, (_, point)| low.min(f64::from(point.at[2])));
        let depths = [nearest, paint.far / paint.delta];
        let points = points.into_iter().map(|(_, point)| point).collect();
        Self { paint, view_from_object, points, low, size, first, depths }
    }

    /// Returns a point of the sub-object in rotated coordinates less the corner of the image, in texels.
    #[inline]
    fn in_texels(&self, point: DVec3) -> DVec3 {
        let [x, y] = self.paint.corner;
        (self.view_from_object * point - DVec3::new(x, y, 0.0)) / self.paint.delta
    }

    /// Returns the points of a texel.
    #[inline]
    fn of_texel(&self, column: i32, row: i32) -> &[SlabPoint] {
        let (x, y) = (i64::from(column) - i64::from(self.low[0]), i64::from(row) - i64::from(self.low[1]));
        if x < 0 || y < 0 || x >= self.size[0] as i64 || y >= self.size[1] as i64 {
            return &[];
        }
        let index = y as usize * self.size[0] + x as usize;
        &self.points[self.first[index] as usize..self.first[index + 1] as usize]
    }

    /// Returns what is nearest to a point.
    fn find(&self, point: DVec3, is_leaf: bool) -> Option<FoundChange> {
        let at = self.in_texels(point);
        let [nearest, far] = self.depths;
        if at.z < nearest - REACH || at.z > far + REACH {
            return None;
        }
        let [column, row] = texel(at);
        let mut best: Option<FoundChange> = None;
        for (dx, dy) in [-1, 0, 1].into_iter().flat_map(|dy| [-1, 0, 1].map(|dx| (dx, dy))) {
            for of in self.of_texel(column.saturating_add(dx), row.saturating_add(dy)) {
                let distance = DVec3::from_array(of.at.map(f64::from)).distance(at);
                if distance <= REACH {
                    best = FoundChange::nearer(best, Some(FoundChange { distance, change: of.change }));
                }
            }
        }
        if best.is_some() || !is_leaf || at.z > far {
            return best;
        }
        let hides = |of: &&SlabPoint| of.leaf && f64::from(of.at[2]) < at.z;
        let hiding = self.of_texel(column, row).iter().filter(hides);
        let behind =
            |of: &SlabPoint| FoundChange { distance: REACH + at.z - f64::from(of.at[2]), change: of.change };
        hiding.map(behind).fold(None, |best, found| FoundChange::nearer(best, Some(found)))
    }

    /// Returns whether something in a ball may be painted.
    fn touches(&self, ball: &Ball) -> bool {
        let (at, radius) = (self.in_texels(ball.middle), ball.radius / self.paint.delta + REACH);
        let [nearest, far] = self.depths;
        if at.z + radius < nearest || at.z - radius > far {
            return false;
        }
        let range = |axis: usize| {
            let (low, count) = (f64::from(self.low[axis]), self.size[axis]);
            let first = (at[axis] - radius - low).floor().clamp(0.0, count as f64) as usize;
            let last = (at[axis] + radius - low + 1.0).ceil().clamp(0.0, count as f64) as usize;
            first..last
        };
        let may_reach = |of: &SlabPoint| !of.change.is_none() && f64::from(of.at[2]) <= at.z + radius;
        range(1).any(|row| {
            let columns = range(0);
            let of_row = row * self.size[0];
            let (from, to) = (of_row + columns.start, of_row + columns.end);
            self.points[self.first[from] as usize..self.first[to.max(from)] as usize].iter().any(may_reach)
        })
    }
}

/// Returns the texel of a place.
#[inline]
fn texel(at: DVec3) -> [i32; 2] {
    [at.x.floor() as i32, at.y.floor() as i32]
}
