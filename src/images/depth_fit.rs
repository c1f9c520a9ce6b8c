//! How depth images agree with sparse points: which kind of numbers they have, and whether their scale is right.

use quadratura_base::error::{Error, Result};
use quadratura_base::raster::robust::upper_median;
use quadratura_base::task::Task;
use quadratura_io::depth_image::{DepthEntry, DepthKind, DepthList, DepthMap};

/// With fewer points nothing is said: medians would be those of chance.
const LEAST_POINTS: usize = 10;

/// The ratio of medians from which on a difference of scale is noted.
const NOTED: f64 = 1.1;

/// The ratio of medians from which on depths are refused.
const REFUSED: f64 = 2.0;

/// Another kind is named where its misfit is this share of the list's kind's, or less...
const CLEARLY_BETTER: f64 = 1.0 / 3.0;

/// ...and where the misfit of the list's kind is larger than this: good depths miss triangulated points by less.
const LEAST_MISFIT: f64 = 0.01;

/// What a depth image says where its photo saw a sparse point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparsePointDepth {
    /// The number, after scale and offset.
    number: f64,
    /// The length of the pixel's ray, scaled to z = 1.
    ray: f64,
    /// The point's depth along the axis, in world units.
    depth: f64,
}

/// How depths of one kind fit sparse points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DepthKindFit {
    kind: DepthKind,
    /// The median of depths over the points' depths.
    ratio: f64,
    /// The median difference from that ratio, as a share.
    misfit: f64,
}

impl SparsePointDepth {
    /// Returns what a depth image says of the points that its photo saw; none where its camera is not from the cameras' files.
    pub fn all(list: &DepthList, entry: &DepthEntry, map: &DepthMap) -> Vec<Self> {
        let Some(photo) = entry.photo else { return Vec::new() };
        let seen = list
            .points
            .iter()
            .filter(|point| point.observations.iter().any(|(seen_by, _)| *seen_by == photo));
        let depth = |point: &quadratura_base::scene::SparsePoint| {
            let in_camera = entry.pose.camera_from_world(point.position);
            let at = entry.camera.image_from_camera(in_camera)?.floor();
            let inside =
                at.x >= 0.0 && at.y >= 0.0 && at.x < f64::from(map.width) && at.y < f64::from(map.height);
            let number =
                f64::from(map.at(inside.then_some(at.x as u32)?, at.y as u32)) * entry.scale + entry.offset;
            let ray = entry.camera.ray_in_camera(at + 0.5).length();
            (number > 0.0 && number.is_finite()).then_some(Self { number, ray, depth: in_camera.z })
        };
        seen.filter_map(depth).collect()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    upper_median(&mut values).expect("some points have a ratio")
}

/// Returns how depths of a kind fit; `None` where too few points have any.
fn fit(kind: DepthKind, points: &[SparsePointDepth], background: f64) -> Option<DepthKindFit> {
    let ratio = |point: &SparsePointDepth| {
        let inverse_depth = kind.inverse_depth(point.number, point.ray, background);
        (inverse_depth > 0.0).then(|| 1.0 / (inverse_depth * point.depth))
    };
    let ratios: Vec<f64> = points.iter().filter_map(ratio).collect();
    (ratios.len() >= LEAST_POINTS).then(|| {
        let middle = median(ratios.clone());
        let misfit = median(ratios.iter().map(|ratio| (ratio / middle).ln().abs()).collect()).exp_m1();
        DepthKindFit { kind, ratio: middle, misfit }
    })
}

/// Returns how all kinds fit, the best first.
fn fits(points: &[SparsePointDepth], background: f64) -> Vec<DepthKindFit> {
    let mut fits: Vec<DepthKindFit> =
        DepthKind::ALL.iter().filter_map(|kind| fit(*kind, points, background)).collect();
    fits.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    fits
}

/// Returns a share as words: `0.42 %`.
fn percent(share: f64) -> String {
    match 100.0 * share {
        small if small < 1.0 => format!("{small:.2} %"),
        small if small < 10.0 => format!("{small:.1} %"),
        large => format!("{large:.0} %"),
    }
}

/// Returns the error for an image whose list does not say what its numbers are; it says which kind fits, where points tell it.
pub fn missing_kind(list: &DepthList, entry: &DepthEntry, points: &[SparsePointDepth]) -> Error {
    let mut found = "`kind` is missing; expected `axis` (depth along the camera's axis, as of COLMAP, EEVEE and most engines), \
                     `ray` (distance from the camera, as of Cycles) or `inverse` (1 / depth, also disparities)"
        .to_owned();
    let fits = fits(points, entry.background);
    let Some((best, others)) = fits.split_first() else {
        let remedy = "add the kind that the program writes which made the depths";
        return Error::input(&list.file, &entry.place, found, remedy);
    };
    let others: Vec<String> = others
        .iter()
        .map(|fit| format!("`{}` misses them by {}", fit.kind.name(), percent(fit.misfit)))
        .collect();
    let (kind, misfit) = (best.kind.name(), percent(best.misfit));
    found += &format!(
        "; `{kind}` fits {} sparse points within {misfit}, apart from scale; {}",
        points.len(),
        others.join(", ")
    );
    Error::input(&list.file, &entry.place, found, format!("add `\"kind\": \"{kind}\"` to this image"))
}

/// Returns what to say where another kind fits clearly better than the list's own.
fn better_kind(own: DepthKindFit, points: &[SparsePointDepth], background: f64) -> Option<String> {
    let is_better = |fit: &DepthKindFit| {
        fit.kind != own.kind && own.misfit > LEAST_MISFIT && fit.misfit <= CLEARLY_BETTER * own.misfit
    };
    let fit = fits(points, background).into_iter().find(is_better)?;
    let (better, misfit) = (fit.kind.name(), percent(fit.misfit));
    let (named, own) = (own.kind.name(), percent(own.misfit));
    Some(format!("`{better}` fits the sparse points within {misfit}, `{named}` within {own}: check `kind`"))
}

/// Compares the scale of depths of a kind with the sparse points.
///
/// # Errors
/// [`Error::Input`] where they differ by more than a factor of 2, unless `force` is given.
pub fn check_scale(
    list: &DepthList,
    entry: &DepthEntry,
    kind: DepthKind,
    points: &[SparsePointDepth],
    force: bool,
    task: &Task,
) -> Result<()> {
    let Some(own) = fit(kind, points, entry.background) else {
        if entry.photo.is_some() {
            task.detail(format!(
                "{} sparse points have a depth here, too few to check the scale",
                points.len()
            ));
        }
        return Ok(());
    };
    let better = better_kind(own, points, entry.background);
    let ratio = own.ratio.max(1.0 / own.ratio);
    let compared =
        format!("the depths are {:.3} times those of {} sparse points (medians)", own.ratio, points.len());
    if ratio > REFUSED && !force {
        // The scale of another kind is another one.
        let remedy = match &better {
            Some(_) => "correct `kind`, then compare again".to_owned(),
            None => right_scale(entry, kind, own.ratio),
        };
        let remedy = format!("{remedy}, or use `--force`");
        let better = better.map_or(String::new(), |better| format!("; {better}"));
        let found = format!("{compared}{better}; expected 1, at most a factor of {REFUSED}");
        return Err(Error::input(&list.file, &entry.place, found, remedy));
    }
    let is_of_kind = better.is_none();
    better.into_iter().for_each(|better| task.note(better));
    match ratio > NOTED && is_of_kind {
        true => task.note(format!("{compared}; {}", right_scale(entry, kind, own.ratio))),
        false => task.detail(compared),
    }
    Ok(())
}

/// Returns what to do about a scale. An offset is in the number, too, so that no scale alone is right.
fn right_scale(entry: &DepthEntry, kind: DepthKind, ratio: f64) -> String {
    if entry.offset != 0.0 {
        return "correct `scale` and `offset`".to_owned();
    }
    let scale = if kind == DepthKind::Inverse { entry.scale * ratio } else { entry.scale / ratio };
    format!("with `\"scale\": {scale:.6}` they would agree")
}
