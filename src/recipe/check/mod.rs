//! `quadratura check`: judges a site before work starts.
//!
//! Does the model stand where the photos are, and if not, which transform would bring it there; what
//! is wrong with its faces; what do the photos see of it; and a picture per photo with the model's
//! edges over it.

pub mod alignment;
mod faces;
pub mod mistake;
mod picture;
mod report;
mod seen;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::raster::robust::upper_median;

use rayon::prelude::*;

use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::geometry::{Similarity, axes};
use crate::layers::{Options, Rasteriser};
use crate::scene::{FaceId, Model, Photo, Site, SparsePoint};
use crate::task::Task;
use alignment::{Sighting, agreement, best_alignment, is_plausible};
pub use faces::Surface;
use seen::Seen;

pub use report::{CheckReport, Crossing, FaceReport, Names, PhotoReport, Suggestion, Verdict};

/// What a check needs to know beside the site.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckOptions {
    /// How the model reached the site's world; a suggestion replaces it.
    pub world_from_model: Similarity,
    /// The occlusion tolerance, [`Options::tolerance`].
    pub tolerance: f32,
    /// Where to write the pictures, as `<photo>.jpg`; the folder is made. None: no pictures.
    pub pictures: Option<PathBuf>,
}

impl Default for CheckOptions {
    fn default() -> Self {
        let tolerance = Options::default().tolerance;
        Self { world_from_model: Similarity::IDENTITY, tolerance, pictures: None }
    }
}

/// Judges a site. The points' observations count through the site's photos.
///
/// # Errors
/// [`Error::Io`] when the folder of the pictures cannot be made; [`Error::Gpu`];
/// [`Error::Cancelled`]. A picture that cannot be made is told in its photo's report.
pub fn check_site(
    site: &Site,
    points: &[SparsePoint],
    options: &CheckOptions,
    rasteriser: &dyn Rasteriser,
    task: &Task,
) -> Result<CheckReport> {
    let model = &*site.model;
    let surface = Surface::of(model);
    let seen = look_at_all(site, options, rasteriser, task)?;
    let sightings = sightings(site, points);
    let agreement = (sightings.len() >= ENOUGH_SIGHTINGS)
        .then(|| agreement(&surface.tree, &Similarity::IDENTITY, &thinned(&sightings)));
    let covered = median(seen.iter().map(|s| s.covered));
    let verdict = verdict(agreement, covered);
    let suggestion = match (verdict, agreement) {
        (Verdict::Fits, _) => None,
        (_, Some(now)) => {
            task.timed("search the axes", || by_points(&surface, &sightings, now, options, task))?
        }
        (_, None) => by_cover(&surface, site, covered, options),
    };
    let pictures = pictures(site, &surface, &seen, options, task)?;
    Ok(CheckReport {
        verdict,
        agreement,
        covered,
        suggestion,
        photos: site
            .photos
            .iter()
            .zip(&seen)
            .zip(pictures)
            .map(|((p, s), made)| photo_report(p, s, made))
            .collect(),
        faces: face_report(model, &surface, &seen, verdict, task)?,
    })
}

/// With fewer sightings of sparse points, coverage is judged instead.
const ENOUGH_SIGHTINGS: usize = 50;

/// Sightings that the present state is judged by.
const JUDGED: usize = 5000;

fn look_at_all(
    site: &Site,
    options: &CheckOptions,
    rasteriser: &dyn Rasteriser,
    task: &Task,
) -> Result<Vec<Seen>> {
    let mut seen = Vec::with_capacity(site.photos.len());
    for (done, photo) in site.photos.iter().enumerate() {
        task.step("look through the cameras", done as u64, site.photos.len() as u64)?;
        let task = task.of(&photo.name);
        seen.push(seen::look(&site.model, photo, rasteriser, options.tolerance, &task)?);
    }
    Ok(seen)
}

fn sightings(site: &Site, points: &[SparsePoint]) -> Vec<Sighting> {
    let eyes: Vec<_> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    let of_point = |point: &SparsePoint| {
        let photos = point.observations.iter().filter_map(|&(photo, _)| eyes.get(photo as usize).copied());
        photos.map(|eye| Sighting { eye, point: point.position }).collect::<Vec<_>>()
    };
    points.iter().filter(|point| point.position.is_finite()).flat_map(of_point).collect()
}

fn thinned(sightings: &[Sighting]) -> Vec<Sighting> {
    sightings.iter().step_by(sightings.len().div_ceil(JUDGED).max(1)).copied().collect()
}

/// 0 of nothing.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    upper_median(&mut values.collect::<Vec<_>>()).unwrap_or(0.0)
}

/// A model that meets so many of the sightings fits.
const FITS: f64 = 0.5;

/// A coarse model leaves out much of what the points lie on (trees, furniture, the neighbours), so
/// half of them agreeing is good; by chance a few in a hundred do. Without points, a model that covers
/// a twentieth of most photos at least is where the cameras look.
fn verdict(agreement: Option<f64>, covered: f64) -> Verdict {
    let (value, poor, fits) = match agreement {
        Some(agreement) => (agreement, 0.15, FITS),
        None => (covered, 0.005, 0.05),
    };
    match value {
        v if v >= fits => Verdict::Fits,
        v if v >= poor => Verdict::Poor,
        _ => Verdict::Misses,
    }
}

/// A suggestion must make so many more sightings agree than now.
const WORTH_CHANGING: f64 = 0.1;

/// Whether a model that meets `found` of the sightings when it is moved, and `now` as it stands, is worth moving: only
/// where it fits then. The search tries every axis, scale and place, so that a model of another site meets a fifth, too,
/// somewhere; models of the site itself meet more than four fifths once they stand right.
fn is_worth_moving(found: f64, now: f64) -> bool {
    found >= FITS && found >= now + WORTH_CHANGING
}

fn by_points(
    surface: &Surface,
    sightings: &[Sighting],
    now: f64,
    options: &CheckOptions,
    task: &Task,
) -> Result<Option<Suggestion>> {
    let sightings = thinned(sightings);
    let found = best_alignment(&surface.tree, &sightings, task)?;
    let worth = |a: &alignment::Alignment| {
        is_worth_moving(a.agreement, now) && is_plausible(&surface.tree, &a.correction, &sightings)
    };
    Ok(found.filter(worth).map(|found| Suggestion {
        transform: found.correction.compose(&options.world_from_model).to_string(),
        agreement: Some(found.agreement),
        covered: None,
        alternatives: Vec::new(),
    }))
}

/// Without points: the convention that fills the photos most. Others may do nearly as well.
fn by_cover(surface: &Surface, site: &Site, now: f64, options: &CheckOptions) -> Option<Suggestion> {
    let cover = |(_, rotation)| {
        let correction = Similarity { rotation, ..Similarity::IDENTITY };
        let transform = correction.compose(&options.world_from_model).to_string();
        (median(site.photos.iter().map(|photo| cover(surface, photo, &correction))), transform)
    };
    let mut all: Vec<(f64, String)> = axes::conventions().into_par_iter().map(cover).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (best, transform) = all.first()?.clone();
    let near = all[1..].iter().filter(|(covered, _)| *covered >= 0.8 * best);
    (best >= now + WORTH_CHANGING).then(|| Suggestion {
        transform,
        agreement: None,
        covered: Some(best),
        alternatives: near.map(|(_, transform)| transform.clone()).collect(),
    })
}

/// Share of a grid of rays through the photo that meet the model, moved by `correction`.
fn cover(surface: &Surface, photo: &Photo, correction: &Similarity) -> f64 {
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

type Picture = Option<Result<PathBuf>>;

fn pictures(
    site: &Site,
    surface: &Surface,
    seen: &[Seen],
    options: &CheckOptions,
    task: &Task,
) -> Result<Vec<Picture>> {
    let Some(folder) = &options.pictures else { return Ok(site.photos.iter().map(|_| None).collect()) };
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let jobs: Vec<_> = site.photos.iter().zip(seen).collect();
    let drawn = |(photo, seen): (&Photo, &Seen)| {
        task.go_on()?;
        let path = picture_path(folder, photo);
        let made = task
            .of(&photo.name)
            .timed("draw the edges", || picture::draw(&site.model, surface, photo, seen, &path));
        Ok(Some(made.map(|()| path)))
    };
    jobs.into_par_iter().map(drawn).collect()
}

fn picture_path(folder: &Path, photo: &Photo) -> PathBuf {
    folder.join(format!("{}.jpg", file_name_of_photo(&photo.name)))
}

fn photo_report(photo: &Photo, seen: &Seen, picture: Picture) -> PhotoReport {
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

fn face_report(
    model: &Model,
    surface: &Surface,
    seen: &[Seen],
    verdict: Verdict,
    task: &Task,
) -> Result<FaceReport> {
    let sides = Sides::of(model, seen);
    // Where the model does not stand right, what the photos see of it says nothing.
    let telling = |face: &FaceId| verdict != Verdict::Misses && !model.face_triangles(*face).is_empty();
    let faces = || model.face_ids().filter(telling);
    let is_billboard = |face: FaceId| model.object(model.face(face).object).billboard;
    let doubled = faces::doubled(model);
    let is_flat_thing = |face: FaceId| is_billboard(face) || doubled.two_sided.contains(&face);
    let crossings = faces::crossings(model, surface, task)?;
    Ok(FaceReport {
        count: model.faces.len(),
        degenerate: Names::of(model, faces::degenerate(model).into_iter()),
        not_planar: Names::of(model, faces::not_planar(model).into_iter()),
        duplicate: Names::of(model, doubled.duplicates.iter().copied()),
        flipped: Names::of(model, faces().filter(|&f| sides.is_flipped(f) && !is_flat_thing(f))),
        unseen: Names::of(model, faces().filter(|&f| !sides.is_seen(f))),
        crossing_pairs: crossings.pairs.len(),
        crossing_gave_up: crossings.gave_up,
        crossing: crossings
            .pairs
            .iter()
            .take(report::NAMED)
            .map(|(pair, depth)| Crossing::of(model, *pair, *depth))
            .collect(),
    })
}

/// How many photos see which side of each face.
struct Sides {
    seen: Vec<bool>,
    /// Photos that see the front well, less those that see the back.
    balance: Vec<i32>,
}

/// A face seen at fewer pixels does not say from which side it is meant to be seen: beyond a ridge, a
/// sliver of the other slope shows its back.
const WELL_SEEN_PX: u32 = 64;

impl Sides {
    fn of(model: &Model, seen: &[Seen]) -> Self {
        let mut sides = Self { seen: vec![false; model.faces.len()], balance: vec![0; model.faces.len()] };
        for seen in seen.iter().flat_map(|seen| &seen.faces) {
            sides.seen[seen.face.0 as usize] = true;
            if seen.px >= WELL_SEEN_PX {
                sides.balance[seen.face.0 as usize] += if seen.back { -1 } else { 1 };
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
