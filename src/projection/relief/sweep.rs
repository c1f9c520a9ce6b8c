//! How much the photos disagree about a face, for each height over its plane: a plane sweep (Collins, *A
//! Space-Sweep Approach to True Multi-Image Matching*, 1996) with a robust spread.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::detail::Detail;
use super::options::ReliefOptions;
use super::plot::Plot;
use super::smooth::Volume;
use super::witness::Witness;
use crate::error::Result;
use crate::projection::weights::pixels_per_unit;
use crate::raster::robust::median;
use crate::scene::{FaceId, Model};
use crate::task::Task;

/// Texels of the details that are compared to a cell's side: it sees some texture, and the details are
/// no finer than what one height can bring into register.
pub(super) const TEXELS_PER_CELL: f64 = 2.0;

/// How a photo sees a plot: homogeneous pixels of `low + u, v` on the plane and `t` over it are
/// `origin + u * along[0] + v * along[1] + t * along[2]`, the third one the depth.
struct Sight<'a> {
    witness: &'a Witness,
    detail: &'a Detail,
    texels_per_px: f64,
    origin: DVec3,
    along: [DVec3; 3],
}

impl<'a> Sight<'a> {
    fn new(witness: &'a Witness, plot: &Plot, px_per_unit: f64) -> Self {
        let (camera, rotation) = (&witness.camera, witness.pose.rotation);
        let homogeneous =
            |p: DVec3| DVec3::new(camera.fx * p.x + camera.cx * p.z, camera.fy * p.y + camera.cy * p.z, p.z);
        let (detail, texel_px) = witness.detail(plot.cell * px_per_unit / TEXELS_PER_CELL);
        let low = plot.frame.raised(plot.low);
        Self {
            witness,
            detail,
            texels_per_px: 1.0 / texel_px,
            origin: homogeneous(witness.pose.camera_from_world(low)),
            along: [plot.frame.u, plot.frame.v, plot.normal].map(|axis| homogeneous(rotation * axis)),
        }
    }

    /// Where the photo has the middle of a cell, homogeneous; `None` outside of it.
    fn middle(&self, at: DVec2) -> Option<DVec3> {
        let h = self.origin + self.along[0] * at.x + self.along[1] * at.y;
        let camera = &self.witness.camera;
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        let inside = h.z > 0.0 && h.x >= 0.0 && h.y >= 0.0 && h.x < width * h.z && h.y < height * h.z;
        inside.then_some(h)
    }

    /// The detail over the middle.
    #[inline]
    fn detail_at(&self, middle: DVec3, height: f64) -> Option<f32> {
        let h = middle + self.along[2] * height;
        if h.z <= 0.0 {
            return None;
        }
        let scale = self.texels_per_px / h.z;
        self.detail.at((h.x * scale) as f32, (h.y * scale) as f32)
    }
}

/// The disagreement of `witnesses` (each with its mean pixels per world unit there) about a plot.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn disagreement(
    model: &Model,
    plot: &Plot,
    witnesses: &[(&Witness, f64)],
    options: &ReliefOptions,
    task: &Task,
) -> Result<Volume> {
    let sights: Vec<Sight> = witnesses.iter().map(|(w, px)| Sight::new(w, plot, *px)).collect();
    let hypotheses = options.hypotheses();
    let row = plot.columns() * hypotheses;
    let mut costs = vec![0.0; row * plot.rows()];
    costs.par_chunks_mut(row).enumerate().try_for_each(|(y, costs)| {
        task.go_on()?;
        let mut here = Vec::with_capacity(sights.len());
        for (x, costs) in costs.chunks_mut(hypotheses).enumerate() {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * plot.cell;
            choose(model, plot, &sights, at, options, &mut here);
            cell_costs(&here, plot.reach, costs);
        }
        Ok(())
    })?;
    Ok(Volume { columns: plot.columns(), hypotheses, costs })
}

/// A photo that shows a cell: how, where, and with how many pixels to a world unit.
type Here<'a> = (&'a Sight<'a>, DVec3, f64);

/// The photos that show the middle of a cell, not too obliquely; of too many those with most pixels there.
fn choose<'a>(
    model: &Model,
    plot: &Plot,
    sights: &'a [Sight<'a>],
    at: DVec2,
    options: &ReliefOptions,
    here: &mut Vec<Here<'a>>,
) {
    let point = plot.frame.raised(plot.low + at);
    let plane = &model.face(plot.face).plane;
    here.clear();
    here.extend(sights.iter().filter_map(|sight| {
        let middle = sight.middle(at)?;
        let Witness { camera, pose, .. } = sight.witness;
        let eye = pose.center_in_world();
        let cosine = plane.signed_distance(eye).abs() / (eye - point).length();
        let shows = |image_px| sight.witness.shows(model, plot.face, point, image_px);
        let serves = cosine >= options.least_cosine && shows(middle.truncate() / middle.z);
        serves.then(|| (sight, middle, pixels_per_unit(camera, plane, eye, middle.z)))
    }));
    if here.len() > options.most_photos {
        // Stable: ties by photo.
        here.sort_by(|a, b| b.2.total_cmp(&a.2));
        here.truncate(options.most_photos);
    }
}

/// What each height costs at one cell. Heights for which fewer than two photos say anything cost what
/// the others cost on average: they are neither for nor against.
fn cell_costs(here: &[Here], reach: f64, costs: &mut [f32]) {
    let middle = (costs.len() / 2) as f64;
    let (mut values, mut sum, mut count) = (Vec::with_capacity(here.len()), 0.0, 0);
    for (h, cost) in costs.iter_mut().enumerate() {
        let height = (h as f64 - middle) / middle * reach;
        values.clear();
        values.extend(here.iter().filter_map(|(sight, middle, _)| sight.detail_at(*middle, height)));
        *cost = spread(&mut values).unwrap_or(f32::NAN);
        if !cost.is_nan() {
            sum += *cost;
            count += 1;
        }
    }
    let mean = if count > 0 { sum / count as f32 } else { 0.0 };
    costs.iter_mut().filter(|cost| cost.is_nan()).for_each(|cost| *cost = mean);
}

/// The mean distance from the median, each counted up to one deviation: a photo with something else in
/// the way (people, leaves) does not decide. Few values lie nearer to their own median than many, hence
/// the factor. `None` for fewer than two values. (To leave the farthest quarter out altogether predicts
/// photos 0.1 dB worse.)
fn spread(values: &mut [f32]) -> Option<f32> {
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

/// The witnesses of a face that are of use, those on the side from which most of it is seen, with their
/// pixels per world unit at the middle of its corners.
pub fn witnesses_of<'a>(
    model: &Model,
    face: FaceId,
    seen: &[(usize, u32)],
    witnesses: &'a [Witness],
) -> Vec<(&'a Witness, f64)> {
    let plane = &model.face(face).plane;
    let height = |w: &Witness| plane.signed_distance(w.pose.center_in_world());
    let front: f64 = seen.iter().map(|&(w, blocks)| f64::from(blocks) * height(&witnesses[w]).signum()).sum();
    let of_side = seen.iter().map(|&(w, _)| &witnesses[w]).filter(|w| height(w) * front > 0.0);
    let middle = model.ring_points(face).sum::<DVec3>() / model.ring(face).len().max(1) as f64;
    of_side.map(|w| (w, w.camera.fx / (w.pose.center_in_world() - middle).length())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photos_that_agree_cost_nothing_and_one_that_does_not_little() {
        assert_eq!(spread(&mut [0.3; 5]), Some(0.0));
        let one_off = spread(&mut [0.3, 0.3, 9.0, 0.3, 0.3]).unwrap();
        assert!((one_off - 0.2 * (5.0f32 / 4.0).sqrt()).abs() < 1e-6);
        assert_eq!(spread(&mut [0.3]), None);
    }
}
