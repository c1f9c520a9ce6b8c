//! The estimation of relief from photos, face by face: the heights at which the photos disagree least.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::options::ReliefOptions;
use super::plot::Plot;
use super::smooth::median_of_nine;
use super::sweep::{FaceView, disagreement, views_of_face};
use super::sweep_view::{SweepView, SweepViews};
use super::{FaceRelief, Relief};
use quadratura_base::error::Result;
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_base::task::Task;

/// The number of cells above which faces are processed one after the other, their rows in parallel, because
/// their cost volumes are large. Smaller faces are processed in parallel.
const LARGE: usize = 1 << 15;

/// The least number of blocks in which a photo has to show a face to be a sweep view of it; fewer show only a
/// corner.
pub(super) const LEAST_BLOCKS: u32 = 8;

/// Estimates the relief of all faces from photos, which show these `faces` ([`seen_faces`]). Billboards and faces that
/// fewer than two photos show have none. The result does not depend on the number of threads.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and those of reading photos back.
pub fn estimate_relief(
    model: &Model,
    sweep_views: &dyn SweepViews,
    faces: &[Vec<(FaceId, u32)>],
    options: &ReliefOptions,
    task: &Task,
) -> Result<Relief> {
    let again = vec![true; model.faces.len()];
    estimate_faces(&Relief::default(), &again, model, sweep_views, faces, options, task)
}

/// Estimates the relief without certain photos, starting from the relief of all, which show these `faces` ([`seen_faces`]): only
/// faces that the photos show are estimated again. It serves to predict photos that did not take part.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and those of reading photos back.
pub fn relief_without(
    relief: &Relief,
    photos: &[PhotoId],
    model: &Model,
    sweep_views: &dyn SweepViews,
    faces: &[Vec<(FaceId, u32)>],
    options: &ReliefOptions,
    task: &Task,
) -> Result<Relief> {
    let mut faces = faces.to_vec();
    let left_out = photos.iter().map(|photo| std::mem::take(&mut faces[photo.index()]));
    let mut again = vec![false; model.faces.len()];
    left_out.flatten().for_each(|(face, _)| again[face.0 as usize] = true);
    estimate_faces(relief, &again, model, sweep_views, &faces, options, task)
}

/// Estimates the relief of the faces that are to be estimated `again`, and takes that of all others from `relief`. `faces` are those
/// that each photo shows ([`seen_faces`]); photos that show none of the former need no pixels.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and those of reading photos back.
pub fn estimate_faces(
    relief: &Relief,
    again: &[bool],
    model: &Model,
    sweep_views: &dyn SweepViews,
    faces: &[Vec<(FaceId, u32)>],
    options: &ReliefOptions,
    task: &Task,
) -> Result<Relief> {
    let mut seen = vec![Vec::new(); model.faces.len()];
    for (w, faces) in faces.iter().enumerate() {
        for (face, blocks) in faces.iter().filter(|(face, _)| again[face.0 as usize]) {
            seen[face.0 as usize].push((w, *blocks));
        }
    }
    let of_face = of_faces(model, sweep_views, &seen, options, task)?;
    let kept = |face: usize| relief.of(FaceId(face as u32)).cloned();
    let of_face = of_face.into_iter().zip(again).enumerate();
    let of_face = of_face.map(|(face, (found, again))| if *again { found } else { kept(face) });
    Ok(Relief { of_face: of_face.collect() })
}

/// Lists the faces whose relief a photo can tell, with the number of blocks in which it shows them.
pub fn seen_faces(model: &Model, sweep_view: &SweepView) -> Vec<(FaceId, u32)> {
    let billboard = |face: FaceId| model.object(model.face(face).object).shows_what_is_behind();
    let mut faces = sweep_view.faces();
    faces.retain(|(face, blocks)| *blocks >= LEAST_BLOCKS && !billboard(*face));
    faces
}

fn of_faces(
    model: &Model,
    sweep_views: &dyn SweepViews,
    seen: &[Vec<(usize, u32)>],
    options: &ReliefOptions,
    task: &Task,
) -> Result<Vec<Option<FaceRelief>>> {
    let plots: Vec<Plot> = model
        .face_ids()
        .filter_map(|face| {
            let of_face = views_of_face(model, face, &seen[face.0 as usize], sweep_views);
            Plot::new(model, face, &of_face, options)
        })
        .collect();
    let (done, total) = (AtomicUsize::new(0), plots.iter().map(Plot::cells).sum::<usize>());
    let one = |plot: Plot| {
        let (face, row) = (plot.face, plot.columns());
        let of_face = views_of_face(model, face, &seen[face.0 as usize], sweep_views);
        let row_done = || {
            let done = done.fetch_add(row, Ordering::Relaxed) + row;
            task.step("relief", done as u64, total as u64)
        };
        let heights = heights(model, &plot, (&of_face, sweep_views), options, &row_done)?;
        Ok((face, plot.with_heights(heights)))
    };
    let (large, small): (Vec<Plot>, Vec<Plot>) = plots.into_iter().partition(|plot| plot.cells() > LARGE);
    let mut found: Vec<(FaceId, FaceRelief)> = large.into_iter().map(one).collect::<Result<_>>()?;
    found.extend(small.into_par_iter().map(one).collect::<Result<Vec<_>>>()?);
    let mut of_face = vec![None; model.faces.len()];
    for (face, relief) in found {
        of_face[face.0 as usize] = Some(relief);
    }
    Ok(of_face)
}

/// Computes the heights of one plot from the photos' disagreement, a preference for the plane, and
/// smoothness.
fn heights(
    model: &Model,
    plot: &Plot,
    sweep_views: (&[FaceView], &dyn SweepViews),
    options: &ReliefOptions,
    row_done: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<f32>> {
    let mut volume = disagreement(model, plot, sweep_views, options, row_done)?.blurred();
    let middle = options.steps as usize;
    for costs in volume.costs.chunks_mut(volume.hypotheses) {
        for (h, cost) in costs.iter_mut().enumerate() {
            *cost += options.prior * h.abs_diff(middle) as f32 / middle as f32;
        }
    }
    let least = median_of_nine(&volume.least(options), plot.columns());
    let step = plot.reach as f32 / middle as f32;
    Ok(least.into_iter().map(|h| (h - middle as f32) * step).collect())
}
