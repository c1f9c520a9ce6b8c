//! The surface points that a stroke passes: its samples are joined in the picture of the view, and each position on the
//! way is a dab, a sphere around the surface point seen there.

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_document::stroke::{Stroke, StrokeSample};
use quadratura_projection::twin::{ProbedPoint, ReferenceRenderer};
use quadratura_view::Shot;

/// The number of dabs per radius along the stroke. A straight stroke of hard dabs is then narrower between two of them
/// by less than a hundredth of its width.
const DABS_PER_RADIUS: f64 = 6.0;

/// The largest number of dabs; a stroke beyond it is joined with a wider spacing.
const MOST_DABS: f64 = 50_000.0;

/// The distance in pixels of the view, beyond the rim of the dabs, within which surface points are looked at: texels
/// lie between the pixels' centres.
pub const MARGIN_PX: f64 = 1.5;

/// The dabs of a stroke.
pub struct Dabs {
    list: Vec<Dab>,
    hardness: f64,
    /// The share of the radius by which dabs are enlarged for [`Self::reaches`].
    margin: f64,
    /// The dabs by the cell that contains their centre; the side of a cell is the reach of the largest dab.
    cells: FxHashMap<[i64; 3], Vec<u32>>,
    side: f64,
}

/// A sphere of full effect within `hardness` times its radius.
#[derive(Debug, Clone, Copy)]
struct Dab {
    center: DVec3,
    radius: f64,
}

impl Dabs {
    /// Casts the positions of a stroke onto the surface, through see-through surfaces where nothing of them is there; `None`
    /// where none of them meets it.
    ///
    /// # Errors
    /// Returns the errors of reading layer textures.
    pub fn along(
        stroke: &Stroke,
        shot: &Shot,
        renderer: &mut ReferenceRenderer,
        task: &Task,
    ) -> Result<Option<Self>> {
        let samples = joined(&stroke.samples, stroke.brush.radius / DABS_PER_RADIUS);
        let positions: Vec<DVec2> = samples.iter().map(|sample| DVec2::from(sample.at)).collect();
        let points = renderer.seen_points(shot, &positions, task)?;
        let Some(first) = points.iter().flatten().next() else { return Ok(None) };
        let radius = stroke.brush.radius * world_per_px(shot, first);
        let dab = |(sample, point): (&StrokeSample, &Option<ProbedPoint>)| {
            let radius = radius * sample.pressure;
            point.filter(|_| radius > 0.0).map(|point| Dab { center: point.point, radius })
        };
        let list: Vec<Dab> = samples.iter().zip(&points).filter_map(dab).collect();
        let margin = MARGIN_PX / stroke.brush.radius;
        let Some(largest) = list.iter().map(|dab| dab.radius).reduce(f64::max) else { return Ok(None) };
        let side = largest * (1.0 + margin);
        let mut cells: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
        for (index, dab) in (0..).zip(&list) {
            cells.entry(cell_of(dab.center, side)).or_default().push(index);
        }
        Ok(Some(Self { list, hardness: stroke.brush.hardness, margin, cells, side }))
    }

    /// Returns the effect at a surface point, 0 to 1: the largest of all dabs, because a stroke does not add up where
    /// it crosses itself.
    pub fn effect(&self, point: DVec3) -> f64 {
        let effect = |dab: &Dab| falloff(point.distance(dab.center) / dab.radius, self.hardness);
        self.near(point).map(effect).fold(0.0, f64::max)
    }

    /// Returns true when a point is in a dab, or beside one by no more than [`MARGIN_PX`].
    pub fn reaches(&self, point: DVec3) -> bool {
        self.near(point).any(|dab| point.distance(dab.center) < dab.radius * (1.0 + self.margin))
    }

    /// Returns the part of the view's picture that the dabs may cover, with the margin.
    pub fn rect(&self, shot: &Shot) -> PixelRect {
        let picture = shot.camera.rect();
        let of_dab = |dab: &Dab| {
            let in_camera = shot.pose.camera_from_world(dab.center);
            let reach = dab.radius * (1.0 + self.margin);
            let center = shot.camera.image_from_camera(in_camera).filter(|_| in_camera.z > 2.0 * reach)?;
            // Seen from twice its radius or more, a sphere looks at most this much larger than a disc, away from the
            // middle of the picture too.
            let wider = 2.0 * in_camera.length() / in_camera.z;
            let half = wider * reach * shot.camera.fx.max(shot.camera.fy) / in_camera.z + MARGIN_PX;
            let (low, high) = ((center - half).floor(), (center + half).ceil());
            Some(PixelRect::from_edges(low.x as i32, low.y as i32, high.x as i32, high.y as i32))
        };
        let rects: Option<Vec<PixelRect>> = self.list.iter().map(of_dab).collect();
        // A dab around the viewer may be anywhere.
        let hull = rects.map_or(picture, |rects| rects.into_iter().fold(PixelRect::EMPTY, |a, b| a.hull(&b)));
        hull.grown(2).intersection(&picture)
    }

    fn near(&self, point: DVec3) -> impl Iterator<Item = &Dab> {
        let [x, y, z] = cell_of(point, self.side);
        let around =
            (-1..=1).flat_map(move |dx| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dz| [dx, dy, dz])));
        let cells = around.filter_map(move |[dx, dy, dz]| self.cells.get(&[x + dx, y + dy, z + dz]));
        cells.flatten().map(|index| &self.list[*index as usize])
    }
}

/// Returns the effect of a brush at a distance from its middle, as a share of its radius: full up to the share `hardness`, from
/// where it fades out smoothly.
pub fn falloff(share: f64, hardness: f64) -> f64 {
    if share <= hardness {
        return f64::from(share < 1.0);
    }
    let left = ((1.0 - share) / (1.0 - hardness)).max(0.0);
    left * left * (3.0 - 2.0 * left)
}

/// Returns the size in world units of a pixel of the view, at a surface point and across the viewing direction.
pub fn world_per_px(shot: &Shot, point: &ProbedPoint) -> f64 {
    shot.pose.camera_from_world(point.point).z / (shot.camera.fx * shot.camera.fy).sqrt()
}

fn cell_of(point: DVec3, side: f64) -> [i64; 3] {
    (point / side).floor().to_array().map(|at| at as i64)
}

/// Adds positions between the samples, at most `spacing` pixels apart.
fn joined(samples: &[StrokeSample], spacing: f64) -> Vec<StrokeSample> {
    let length = |pair: &[StrokeSample]| DVec2::from(pair[0].at).distance(DVec2::from(pair[1].at));
    let spacing = spacing.max(samples.windows(2).map(length).sum::<f64>() / MOST_DABS);
    let mut joined = samples[..1].to_vec();
    for pair in samples.windows(2) {
        let steps = (length(pair) / spacing).ceil().max(1.0) as u32;
        let between = |step: u32| {
            let share = f64::from(step) / f64::from(steps);
            let mix = |a: f64, b: f64| a + (b - a) * share;
            StrokeSample {
                at: [0, 1].map(|axis| mix(pair[0].at[axis], pair[1].at[axis])),
                pressure: mix(pair[0].pressure, pair[1].pressure),
            }
        };
        joined.extend((1..=steps).map(between));
    }
    joined
}
