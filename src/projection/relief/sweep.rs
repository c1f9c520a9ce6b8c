//! The disagreement of the photos about a face for each height over its plane: a plane sweep (Collins, *A
//! Space-Sweep Approach to True Multi-Image Matching*, 1996) with a robust measure of deviation.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::detail::Detail;
use super::options::ReliefOptions;
use super::plot::Plot;
use super::smooth::Volume;
use super::sweep_view::{SweepView, SweepViews};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::robust::median;
use quadratura_base::scene::{FaceId, Model};
use quadratura_view::weights::pixels_per_unit;

/// The number of texels of the compared details per side of a cell: enough that a cell contains some texture,
/// and not finer than one height can bring into register.
pub(super) const TEXELS_PER_CELL: f64 = 2.0;

/// The number of cells along both sides of the squares in which the costs of a face are found: only the photos that show something
/// of a square are in memory then.
const TILE: usize = 64;

/// A photo that shows a face.
#[derive(Clone, Copy)]
pub struct FaceView<'a> {
    /// The number of the photo.
    number: usize,
    /// Its camera and pose.
    pub camera: &'a Pinhole,
    pose: &'a Pose,
    /// Its pixels per world unit at the mean of the face's corners.
    pub px_per_unit: f64,
}

/// The projection of a plot into a photo: homogeneous pixel coordinates of the point at `low + u, v` on the
/// plane and `t` above it are `origin + u * along[0] + v * along[1] + t * along[2]`; the third component is
/// the depth.
struct PlotView<'a> {
    sweep_view: &'a SweepView,
    detail: &'a Detail,
    texels_per_px: f64,
    map: PlotMap,
}

/// The linear part of a [`PlotView`], with the size of the photo.
#[derive(Clone, Copy)]
struct PlotMap {
    size: DVec2,
    origin: DVec3,
    along: [DVec3; 3],
}

impl PlotMap {
    fn new(view: &FaceView, plot: &Plot) -> Self {
        let FaceView { camera, pose, .. } = *view;
        let homogeneous =
            |p: DVec3| DVec3::new(camera.fx * p.x + camera.cx * p.z, camera.fy * p.y + camera.cy * p.z, p.z);
        let low = plot.frame.raised(plot.low);
        Self {
            size: DVec2::new(f64::from(camera.width), f64::from(camera.height)),
            origin: homogeneous(pose.camera_from_world(low)),
            along: [plot.frame.u, plot.frame.v, plot.normal].map(|axis| homogeneous(pose.rotation * axis)),
        }
    }

    /// Projects a point of the plane to homogeneous pixel coordinates.
    fn projected(&self, at: DVec2) -> DVec3 {
        self.origin + self.along[0] * at.x + self.along[1] * at.y
    }

    /// Returns whether the photo may show something of a rectangle of the plane, which it does not when all four corners are beyond
    /// one of its sides: projection is linear.
    fn may_show(&self, corners: [DVec2; 4]) -> bool {
        let corners = corners.map(|corner| self.projected(corner));
        let sides: [&dyn Fn(DVec3) -> f64; 5] =
            [&|h| h.z, &|h| h.x, &|h| h.y, &|h| self.size.x * h.z - h.x, &|h| self.size.y * h.z - h.y];
        sides.iter().all(|side| corners.iter().any(|corner| side(*corner) >= 0.0))
    }
}

impl<'a> PlotView<'a> {
    fn new(sweep_view: &'a SweepView, map: PlotMap, plot: &Plot, px_per_unit: f64) -> Self {
        let (detail, texel_px) = sweep_view.detail(plot.cell * px_per_unit / TEXELS_PER_CELL);
        Self { sweep_view, detail, texels_per_px: 1.0 / texel_px, map }
    }

    /// Projects the centre of a cell to homogeneous pixel coordinates; `None` outside of the photo.
    fn middle(&self, at: DVec2) -> Option<DVec3> {
        let h = self.map.projected(at);
        let [width, height] = self.map.size.to_array();
        let inside = h.z > 0.0 && h.x >= 0.0 && h.y >= 0.0 && h.x < width * h.z && h.y < height * h.z;
        inside.then_some(h)
    }

    /// Samples the detail at a height over the cell's centre.
    #[inline]
    fn detail_at(&self, middle: DVec3, height: f64) -> Option<f32> {
        let h = middle + self.map.along[2] * height;
        if h.z <= 0.0 {
            return None;
        }
        let scale = self.texels_per_px / h.z;
        self.detail.at((h.x * scale) as f32, (h.y * scale) as f32)
    }
}

/// Computes the disagreement of the `views` of a plot, for every cell and height, square by square; `sweep_views` has their pixels.
/// `row_done` is called once for each row of cells: a large face takes minutes.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], as `row_done` says, and those of reading photos back.
pub fn disagreement(
    model: &Model,
    plot: &Plot,
    (views, sweep_views): (&[FaceView], &dyn SweepViews),
    options: &ReliefOptions,
    row_done: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Volume> {
    let maps: Vec<PlotMap> = views.iter().map(|view| PlotMap::new(view, plot)).collect();
    let hypotheses = options.hypotheses();
    let row = plot.columns() * hypotheses;
    let mut costs = vec![0.0; row * plot.rows()];
    for (band, costs) in costs.chunks_mut(row * TILE).enumerate() {
        let rows = band * TILE..(band * TILE + TILE).min(plot.rows());
        for first in (0..plot.columns()).step_by(TILE) {
            let columns = first..(first + TILE).min(plot.columns());
            let at = |x: usize, y: usize| DVec2::new(x as f64, y as f64) * plot.cell;
            let corners = [
                at(columns.start, rows.start),
                at(columns.end, rows.start),
                at(columns.start, rows.end),
                at(columns.end, rows.end),
            ];
            let shown = views.iter().zip(&maps).filter(|(_, map)| map.may_show(corners));
            let shown: Vec<(&FaceView, &PlotMap)> = shown.collect();
            let read = shown.iter().map(|(view, _)| sweep_views.view(view.number));
            let read: Vec<Arc<SweepView>> = read.collect::<Result<_>>()?;
            let views = read.iter().zip(&shown);
            let views: Vec<PlotView> =
                views.map(|(read, (view, map))| PlotView::new(read, **map, plot, view.px_per_unit)).collect();
            let is_last = columns.end == plot.columns();
            costs.par_chunks_mut(row).zip(rows.clone()).try_for_each(|(costs, y)| {
                let costs = &mut costs[columns.start * hypotheses..columns.end * hypotheses];
                let mut here = Vec::with_capacity(views.len());
                for (x, costs) in columns.clone().zip(costs.chunks_mut(hypotheses)) {
                    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * plot.cell;
                    choose(model, plot, &views, at, options, &mut here);
                    cell_costs(&here, plot.reach, costs);
                }
                if is_last { row_done() } else { Ok(()) }
            })?;
        }
    }
    Ok(Volume { columns: plot.columns(), hypotheses, costs })
}

/// A photo that shows a cell: its projection, the cell's centre in it, and its pixels per world unit there.
type CellPhoto<'a> = (&'a PlotView<'a>, DVec3, f64);

/// Selects the photos that show the centre of a cell not too obliquely; of too many, those with the highest
/// resolution.
fn choose<'a>(
    model: &Model,
    plot: &Plot,
    views: &'a [PlotView<'a>],
    at: DVec2,
    options: &ReliefOptions,
    here: &mut Vec<CellPhoto<'a>>,
) {
    let point = plot.frame.raised(plot.low + at);
    let plane = &model.face(plot.face).plane;
    here.clear();
    here.extend(views.iter().filter_map(|view| {
        let middle = view.middle(at)?;
        let SweepView { camera, pose, .. } = view.sweep_view;
        let eye = pose.center_in_world();
        let cosine = plane.signed_distance(eye).abs() / (eye - point).length();
        let shows = |image_px| view.sweep_view.shows(model, plot.face, point, image_px);
        let usable = cosine >= options.least_cosine && shows(middle.truncate() / middle.z);
        usable.then(|| (view, middle, pixels_per_unit(camera, plane, eye, middle.z)))
    }));
    if here.len() > options.most_photos {
        // The sort is stable, so ties are resolved by photo.
        here.sort_by(|a, b| b.2.total_cmp(&a.2));
        here.truncate(options.most_photos);
    }
}

/// Computes the cost of each height at one cell. A height that fewer than two photos can judge gets the mean
/// cost of the other heights, so that it is neither preferred nor avoided.
fn cell_costs(here: &[CellPhoto], reach: f64, costs: &mut [f32]) {
    let middle = (costs.len() / 2) as f64;
    let mut values = Vec::with_capacity(here.len());
    let mut sum = 0.0;
    let mut count = 0;
    for (h, cost) in costs.iter_mut().enumerate() {
        let height = (h as f64 - middle) / middle * reach;
        values.clear();
        values.extend(here.iter().filter_map(|(view, middle, _)| view.detail_at(*middle, height)));
        *cost = deviation(&mut values).unwrap_or(f32::NAN);
        if !cost.is_nan() {
            sum += *cost;
            count += 1;
        }
    }
    let mean = if count > 0 { sum / count as f32 } else { 0.0 };
    costs.iter_mut().filter(|cost| cost.is_nan()).for_each(|cost| *cost = mean);
}

/// Computes the mean distance from the median, each distance limited to one deviation, so that a photo with
/// an obstacle (people, leaves) does not decide. The factor corrects for the fact that few values lie nearer
/// to their own median than many. Returns `None` for fewer than two values. (Leaving out the farthest quarter
/// altogether predicts photos 0.1 dB worse.)
fn deviation(values: &mut [f32]) -> Option<f32> {
    let count = values.len();
    if count < 2 {
        return None;
    }
    let median = median(values)?;
    // They are sorted now: the sum does not depend on the photos' order.
    let sum: f32 = values.iter().map(|value| (value - median).abs().min(1.0)).sum();
    let count = count as f32;
    Some(sum / count * (count / (count - 1.0)).sqrt())
}

/// Returns the sweep views of a face that can be used: those on the side from which most of the face is seen.
pub fn views_of_face<'a>(
    model: &Model,
    face: FaceId,
    seen: &[(usize, u32)],
    sweep_views: &'a dyn SweepViews,
) -> Vec<FaceView<'a>> {
    let plane = &model.face(face).plane;
    let middle = model.ring_points(face).sum::<DVec3>() / model.ring(face).len().max(1) as f64;
    let height = |number: usize| plane.signed_distance(sweep_views.camera(number).1.center_in_world());
    let front: f64 = seen.iter().map(|&(w, blocks)| f64::from(blocks) * height(w).signum()).sum();
    let of_side = seen.iter().map(|&(w, _)| w).filter(|w| height(*w) * front > 0.0);
    of_side
        .map(|number| {
            let (camera, pose) = sweep_views.camera(number);
            let px_per_unit = camera.fx / (pose.center_in_world() - middle).length();
            FaceView { number, camera, pose, px_per_unit }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photos_that_agree_cost_nothing_and_one_that_does_not_little() {
        assert_eq!(deviation(&mut [0.3; 5]), Some(0.0));
        let one_off = deviation(&mut [0.3, 0.3, 9.0, 0.3, 0.3]).unwrap();
        assert!((one_off - 0.2 * (5.0f32 / 4.0).sqrt()).abs() < 1e-6);
        assert_eq!(deviation(&mut [0.3]), None);
    }
}
