//! The command `check`: assesses a site before work starts.
//!
//! It tests whether the model is aligned with the photos and, if not, suggests a transform that aligns it; it finds
//! defects of the model's faces and what the photos see of them; and it draws the model's edges over each photo.

pub mod alignment;
mod distances;
mod faces;
pub mod fix;
pub mod mistake;
pub mod pairs;
mod picture;
mod report;
mod seen;
mod sunk;
mod turning;
pub mod unexplained;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use quadratura_base::raster::robust::upper_median;

use rayon::prelude::*;

pub use alignment::SearchOutcome;
use alignment::{Observation, agreement, best_alignments};
pub use faces::CheckedSurface;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Similarity, axes};
use quadratura_base::scene::{FaceId, Model, Photo, PhotoId, Site, SparsePoint};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_layers::{Options, Rasteriser};
use seen::VisibleModel;
use unexplained::{Unexplained, unexplained};

pub use report::{
    AlignmentSuggestion, AlternativeTransform, CheckReport, FaceReport, Intersection, Names, ObjectDistances,
    PhotoReport, Verdict,
};

/// Options of [`check_site`].
#[derive(Debug, Clone, PartialEq)]
pub struct CheckOptions {
    /// The transform with which the model reached the site's world; a suggestion replaces it.
    pub world_from_model: Similarity,
    /// The occlusion tolerance, [`Options::tolerance`].
    pub tolerance: f32,
    /// The folder for the pictures `<photo>.jpg`, created if necessary; `None` for no pictures.
    pub pictures: Option<PathBuf>,
}

impl Default for CheckOptions {
    fn default() -> Self {
        let tolerance = Options::default().tolerance;
        Self { world_from_model: Similarity::IDENTITY, tolerance, pictures: None }
    }
}

/// Assesses a site. The points' observations refer to indices of the site's photos.
///
/// # Errors
/// Returns [`Error::Io`] when the folder of the pictures cannot be created, [`Error::Gpu`], or
/// [`Error::Cancelled`]. A picture that cannot be made is reported with its photo.
pub fn check_site(
    site: &Site,
    points: &[SparsePoint],
    options: &CheckOptions,
    rasteriser: &dyn Rasteriser,
    task: &Task,
) -> Result<CheckReport> {
    let model = &*site.model;
    let surface = CheckedSurface::from_model(model);
    let seen = look_at_all(site, options, rasteriser, task)?;
    let sightings = sightings(site, points);
    let agreement = (sightings.len() >= ENOUGH_SIGHTINGS)
        .then(|| agreement(&surface.tree, &Similarity::IDENTITY, &thinned(&sightings)));
    let covered = median(seen.iter().map(|s| s.covered));
    let verdict = verdict(agreement, covered);
    let (search, suggestion) = match (verdict, agreement) {
        (Verdict::Fits, _) => (None, None),
        (_, Some(now)) => {
            let (outcome, suggestion) = task.timed("search the alignment", || {
                by_points(&surface, site, points, (&sightings, now), options, task)
            })?;
            (Some(outcome), suggestion)
        }
        (_, None) => (None, by_cover(&surface, site, covered, options)),
    };
    // What a model leaves out that is not where the photos are says nothing.
    let unexplained = match verdict {
        Verdict::Misses => None,
        _ => task.timed("find unexplained points", || unexplained(site, points)),
    };
    let pictures = pictures(site, &surface, &seen, unexplained.as_ref(), options, task)?;
    Ok(CheckReport {
        verdict,
        agreement,
        covered,
        suggestion,
        search,
        photos: site
            .photos
            .iter()
            .zip(&seen)
            .zip(pictures)
            .map(|((p, s), made)| photo_report(p, s, made))
            .collect(),
        faces: face_report(site, &surface, &seen, verdict, task)?,
        distances: match verdict {
            Verdict::Misses => Vec::new(),
            _ => task.timed("measure distances", || distances::distances(site, &surface, points)),
        },
        unexplained,
    })
}

/// The least number of sparse-point observations for judging by them; with fewer, coverage is judged instead.
const ENOUGH_SIGHTINGS: usize = 50;

/// The most observations by which the present alignment is judged.
const JUDGED: usize = 5000;

/// Renders the model from each photo's camera.
fn look_at_all(
    site: &Site,
    options: &CheckOptions,
    rasteriser: &dyn Rasteriser,
    task: &Task,
) -> Result<Vec<VisibleModel>> {
    let mut seen = Vec::with_capacity(site.photos.len());
    for (done, photo) in site.photos.iter().enumerate() {
        task.step("check views", done as u64, site.photos.len() as u64)?;
        let task = task.with_subject(&photo.name);
        seen.push(seen::look(&site.model, photo, rasteriser, options.tolerance, &task)?);
    }
    Ok(seen)
}

/// Lists the observations of finite points as pairs of camera centre and point.
fn sightings(site: &Site, points: &[SparsePoint]) -> Vec<Observation> {
    let eyes: Vec<_> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    let of_point = |point: &SparsePoint| {
        let photos = point.observations.iter().filter_map(|&(photo, _)| eyes.get(photo as usize).copied());
        photos.map(|eye| Observation { eye, point: point.position }).collect::<Vec<_>>()
    };
    points.iter().filter(|point| point.position.is_finite()).flat_map(of_point).collect()
}

/// Selects every n-th observation, so that at most [`JUDGED`] are left.
fn thinned(sightings: &[Observation]) -> Vec<Observation> {
    sightings.iter().step_by(sightings.len().div_ceil(JUDGED).max(1)).copied().collect()
}

/// 0 of nothing.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    upper_median(&mut values.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Judges the alignment. A coarse model leaves out much of what the points lie on (trees, furniture, neighbouring
/// houses), so matching half of them is good; by chance a few in a hundred match. Without points, a model that
/// covers at least a twentieth of most photos is where the cameras look.
fn verdict(agreement: Option<f64>, covered: f64) -> Verdict {
    let (value, poor, fits) = match agreement {
        Some(agreement) => (agreement, 0.15, 0.5),
        None => (covered, 0.005, 0.05),
    };
    match value {
        v if v >= fits => Verdict::Fits,
        v if v >= poor => Verdict::Poor,
        _ => Verdict::Misses,
    }
}

/// The least gain in the share of matching observations (or covered pixels) that makes a suggestion.
const WORTH_CHANGING: f64 = 0.1;

/// Searches an alignment by the sparse points. `sightings` and the share of them that match now tell whether it is worth a
/// change.
fn by_points(
    surface: &CheckedSurface,
    site: &Site,
    points: &[SparsePoint],
    (sightings, now): (&[Observation], f64),
    options: &CheckOptions,
    task: &Task,
) -> Result<(SearchOutcome, Option<AlignmentSuggestion>)> {
    let sightings = thinned(sightings);
    let (outcome, corrections) = best_alignments(site, points, task)?;
    let transform = |correction: &Similarity| AlternativeTransform {
        transform: correction.compose(&options.world_from_model).to_string(),
        agreement: Some(agreement(&surface.tree, correction, &sightings)),
        covered: None,
    };
    let mut found: Vec<AlternativeTransform> = corrections.iter().map(transform).collect();
    // A model that matches more now than after any change stays.
    found.retain(|found| found.agreement.is_some_and(|then| then > now));
    if found.is_empty() {
        let moved = matches!(outcome, SearchOutcome::Found | SearchOutcome::Several);
        return Ok((if moved { SearchOutcome::Kept } else { outcome }, None));
    }
    let AlternativeTransform { transform, agreement, covered } = found.remove(0);
    Ok((outcome, Some(AlignmentSuggestion { transform, agreement, covered, alternatives: found })))
}

/// Searches the axis convention that covers the photos most, for sites without points. Others may do nearly as
/// well.
fn by_cover(
    surface: &CheckedSurface,
    site: &Site,
    now: f64,
    options: &CheckOptions,
) -> Option<AlignmentSuggestion> {
    let cover = |(_, rotation)| {
        let correction = Similarity { rotation, ..Similarity::IDENTITY };
        let transform = correction.compose(&options.world_from_model).to_string();
        (median(site.photos.iter().map(|photo| cover(surface, photo, &correction))), transform)
    };
    let mut all: Vec<(f64, String)> = axes::conventions().into_par_iter().map(cover).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (best, transform) = all.first()?.clone();
    let near = all[1..].iter().filter(|(covered, _)| *covered >= 0.8 * best);
    (best >= now + WORTH_CHANGING).then(|| AlignmentSuggestion {
        transform,
        agreement: None,
        covered: Some(best),
        alternatives: near
            .map(|(covered, transform)| AlternativeTransform {
                transform: transform.clone(),
                agreement: None,
                covered: Some(*covered),
            })
            .collect(),
    })
}

/// Returns the share of a grid of rays through the photo that hit the model, moved by `correction`.
fn cover(surface: &CheckedSurface, photo: &Photo, correction: &Similarity) -> f64 {
    const COLUMNS: u32 = 24;
    const ROWS: u32 = 16;
    let back = correction.inverse();
    let eye = back.apply(photo.pose.center_in_world());
    let meets = |&(column, row): &(u32, u32)| {
        let at = |i: u32, count: u32, px: u32| (f64::from(i) + 0.5) / f64::from(count) * f64::from(px);
        let px =
            glam::DVec2::new(at(column, COLUMNS, photo.camera.width), at(row, ROWS, photo.camera.height));
        let through = back.apply(photo.pose.world_from_camera(photo.camera.ray_in_camera(px)));
        surface.tree.first_hit(eye, through - eye, f64::INFINITY).is_some()
    };
    let grid = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (column, row)));
    grid.filter(meets).count() as f64 / f64::from(COLUMNS * ROWS)
}

type PictureResult = Option<Result<PathBuf>>;

/// Draws the pictures in parallel; `None` for each photo where no folder is given.
fn pictures(
    site: &Site,
    surface: &CheckedSurface,
    seen: &[VisibleModel],
    unexplained: Option<&Unexplained>,
    options: &CheckOptions,
    task: &Task,
) -> Result<Vec<PictureResult>> {
    let Some(folder) = &options.pictures else { return Ok(site.photos.iter().map(|_| None).collect()) };
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let jobs: Vec<_> = site.photo_ids().zip(seen).collect();
    let drawn = |(id, seen): (PhotoId, &VisibleModel)| {
        task.check_cancelled()?;
        let photo = site.photo(id);
        let path = picture_path(folder, photo);
        let points = unexplained.map_or(&[][..], |found| &found.in_photo[id.index()]);
        let made = task
            .with_subject(&photo.name)
            .timed("draw the edges", || picture::draw(&site.model, surface, photo, seen, points, &path));
        Ok(Some(made.map(|()| path)))
    };
    jobs.into_par_iter().map(drawn).collect()
}

fn picture_path(folder: &Path, photo: &Photo) -> PathBuf {
    folder.join(format!("{}.jpg", file_name_of_photo(&photo.name)))
}

/// Reports on one photo.
fn photo_report(photo: &Photo, seen: &VisibleModel, picture: PictureResult) -> PhotoReport {
    let (picture, problem) = match picture {
        Some(Ok(path)) => (Some(path), None),
        Some(Err(error)) => (None, Some(error.to_string())),
        None => (None, None),
    };
    PhotoReport {
        name: photo.name.clone(),
        in_front: seen.in_front,
        inside: seen.inside,
        covered: seen.covered,
        faces: seen.faces.len(),
        picture,
        problem,
    }
}

/// Reports on the model's faces.
fn face_report(
    site: &Site,
    surface: &CheckedSurface,
    seen: &[VisibleModel],
    verdict: Verdict,
    task: &Task,
) -> Result<FaceReport> {
    let model = &*site.model;
    let sides = FaceVisibility::new(model, seen);
    // Where the model is not aligned, visibility in the photos says nothing about its faces.
    let has_place = |face: FaceId| !model.face_triangles(face).is_empty() && !model.is_replaced(face);
    let is_significant = |face: &FaceId| verdict != Verdict::Misses && has_place(*face);
    let faces = || model.face_ids().filter(is_significant);
    let is_billboard = |face: FaceId| model.object(model.face(face).object).billboard;
    let doubled = faces::doubled(model);
    let is_flat_thing = |face: FaceId| is_billboard(face) || doubled.two_sided.contains(&face);
    let crossings = faces::crossings(model, surface, task)?;
    let (sunk, crossing) = sunk::parted(site, surface, crossings.pairs, task)?;
    Ok(FaceReport {
        count: model.faces.len(),
        degenerate: Names::new(model, faces::degenerate(model).into_iter()),
        not_planar: Names::new(model, faces::not_planar(model).into_iter()),
        duplicate: Names::new(model, doubled.duplicates.iter().copied()),
        flipped: Names::new(model, faces().filter(|&f| sides.is_flipped(f) && !is_flat_thing(f))),
        unseen: Names::new(model, faces().filter(|&f| !sides.is_seen(f))),
        turning: Names::new(model, turning::crossed(model).into_iter()),
        crossing_pairs: crossing.len(),
        sunk_pairs: sunk.len(),
        crossing_gave_up: crossings.gave_up,
        crossing: crossing
            .iter()
            .take(report::NAMED)
            .map(|(pair, depth)| Intersection::new(model, *pair, *depth))
            .collect(),
    })
}

/// From which side the photos see each face.
struct FaceVisibility {
    seen: Vec<bool>,
    /// The number of pixels at which photos show the front, less the number of those at which they show the back.
    balance: Vec<i64>,
}

/// The least number of pixels at which a face's visible side counts: beyond a ridge, a sliver of the other slope
/// shows its back.
const WELL_SEEN_PX: u32 = 64;

impl FaceVisibility {
    fn new(model: &Model, seen: &[VisibleModel]) -> Self {
        let mut sides = Self { seen: vec![false; model.faces.len()], balance: vec![0; model.faces.len()] };
        for seen in seen.iter().flat_map(|seen| &seen.faces) {
            sides.seen[seen.face.0 as usize] = true;
            if seen.px >= WELL_SEEN_PX {
                let px = i64::from(seen.px);
                sides.balance[seen.face.0 as usize] += if seen.back { -px } else { px };
            }
        }
        sides
    }

    fn is_seen(&self, face: FaceId) -> bool {
        self.seen[face.0 as usize]
    }

    fn is_flipped(&self, face: FaceId) -> bool {
        self.balance[face.0 as usize] < 0
    }
}
