//! Several layered depth images warped into one camera, whose pixels keep all that the sources show along each ray.
//!
//! Gortler, He & Cohen 1997, section 2.2: depth images are warped into the camera of one of them, and samples that fall into
//! one pixel share a layer where their depths are close. [`Combining::published`] does just this. The default collects the
//! samples of a pixel first and merges them whatever their order ([`super::merge`]), samples sources at the centres of the pixels
//! that they cover, and brings all sources to one exposure in linear light.
//!
//! Rows of the camera are made one group after the other: threads collect the samples of parts of the sources, by strips
//! of rows, and then merge strip by strip.

mod collect;
mod neighbourhood;
mod surfaces;

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use self::collect::{CollectCanvas, Collected, STRIP, Strip};
use self::surfaces::CommonSurfaces;
use super::finish::{Row, SampleCounts, Unfinished};
use super::layout::{Ldi, LdiKind};
use super::merge::{Merging, SurfaceSample, merge_as_published_into, merge_into};
use super::transfer::Transfer;
use super::warp::{Plan, WarpOptions};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::light::bytes_of_light_times;
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// About how many samples are collected before they are merged: some 60 MiB, or [`LEAST_ROWS`] and a strip for each thread where these
/// have more.
const SAMPLES_AT_ONCE: usize = 1 << 21;
/// The least number of rows of which samples are collected at once: source pixels that are up to 16 rows away are looked at, too.
const LEAST_ROWS: u32 = 64;
/// How many parts of tiles of a source one thread takes at once.
const TILE_PARTS: usize = 8;

/// The camera into which sources are combined.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonCamera {
    /// The camera, with the size of the frame in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// Where the photo is in the frame; `None` where the camera is no photo's.
    pub photo_rect: Option<PixelRect>,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
}

impl CommonCamera {
    /// Makes the frame of a camera, grown on each side by the share `guard` of its width and height: the guard band, which
    /// keeps what moves into the picture when the viewpoint does. Growth is in whole pixels, so that the photo's pixels stay
    /// pixels.
    pub fn new(camera: Pinhole, pose: Pose, gain: [f64; 3], guard: f64, is_photo: bool) -> Self {
        let [x, y] = [camera.width, camera.height].map(|side| (f64::from(side) * guard).round() as u32);
        let photo_rect = PixelRect { x: x as i32, y: y as i32, w: camera.width, h: camera.height };
        let (width, height) = (camera.width + 2 * x, camera.height + 2 * y);
        let (cx, cy) = (camera.cx + f64::from(x), camera.cy + f64::from(y));
        let camera = Pinhole { width, height, cx, cy, ..camera };
        Self { camera, pose, photo_rect: is_photo.then_some(photo_rect), gain }
    }
}

/// A layered depth image, or a depth image, which is one of a single layer, that is combined with others.
#[derive(Debug, Clone, Copy)]
pub struct SourceImage<'a> {
    /// The image.
    pub ldi: &'a Ldi,
    /// Whether it is of the camera into which all are combined. At most one is.
    pub is_own: bool,
}

/// How sources are combined.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Combining {
    /// How samples become layers. The published rule takes the tolerance and the number of layers from it.
    pub merging: Merging,
    /// True for the published system: one sample a source pixel, in the order of the sources, means of stored values,
    /// whatever the exposures.
    pub published: bool,
}

/// Combines sources into one camera. The result is the same for every number of threads and, but for the published rule, for
/// every order of the sources other than the camera's own.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn combine(
    kind: LdiKind,
    frame: &CommonCamera,
    sources: &[SourceImage],
    combining: &Combining,
    options: BTreeMap<String, String>,
    task: &Task,
) -> Result<Ldi> {
    // Most sources have about one sample a pixel.
    let rows_at_once = SAMPLES_AT_ONCE / (sources.len() * frame.camera.width as usize).max(1);
    let least = LEAST_ROWS.max(STRIP * rayon::current_num_threads() as u32);
    combine_in_parts(kind, frame, sources, combining, options, least.max(rows_at_once as u32), task)
}

/// The same with at most this many rows of the camera collected at once, in whole strips of [`STRIP`] rows and at least one. From
/// [`LEAST_ROWS`] on the result does not depend on their number.
pub(super) fn combine_in_parts(
    kind: LdiKind,
    frame: &CommonCamera,
    sources: &[SourceImage],
    combining: &Combining,
    options: BTreeMap<String, String>,
    rows_at_once: u32,
    task: &Task,
) -> Result<Ldi> {
    let ldis: Vec<&Ldi> = sources.iter().map(|source| source.ldi).collect();
    let surfaces = CommonSurfaces::new(&frame.camera, &frame.pose, &ldis);
    let (rows, mut counts) =
        task.timed("merge", || merged_rows(frame, sources, &surfaces, combining, rows_at_once, task))?;
    counts.unknown_surfaces = surfaces.unknown;
    let mut names: Vec<String> = Vec::new();
    ldis.iter().flat_map(|ldi| &ldi.sources).for_each(|name| {
        if !names.contains(name) {
            names.push(name.clone());
        }
    });
    let CommonCamera { camera, pose, photo_rect, gain } = *frame;
    let (surfaces, inputs) = (surfaces.list, String::new());
    let unfinished = Unfinished {
        kind,
        inputs,
        camera,
        pose,
        photo_rect,
        gain,
        surfaces,
        sources: names,
        rows,
        counts,
        options,
    };
    unfinished.finish(task)
}

/// Warps all sources into the frame and merges the samples of each pixel.
fn merged_rows(
    frame: &CommonCamera,
    sources: &[SourceImage],
    surfaces: &CommonSurfaces,
    combining: &Combining,
    rows_at_once: u32,
    task: &Task,
) -> Result<(Vec<Row>, SampleCounts)> {
    let shot = Shot { backs: false, ..Shot::new(frame.camera, frame.pose) };
    // The published system has one resolution.
    let level = combining.published.then_some(0);
    let options = WarpOptions { level, ..WarpOptions::default() };
    let plans: Vec<Plan> = sources.iter().map(|source| Plan::new(source.ldi, &shot, &options)).collect();
    let exposed = |source: &SourceImage| match combining.published {
        true => exposed(&frame.gain, frame),
        false => exposed(&source.ldi.gain, frame),
    };
    let exposed: Vec<[[u8; 256]; 3]> = sources.iter().map(exposed).collect();
    let collected = |i: usize| {
        let source = &sources[i];
        let (ldi, level) = (source.ldi, plans[i].level);
        let transfer = Transfer::new(&level.camera, &ldi.pose, &frame.camera, &frame.pose);
        // The camera's own photo is source 0, which merging keeps.
        let number = if source.is_own { 0 } else { i as u16 + 1 };
        let (numbers, bytes) = (&surfaces.numbers[i][..], &exposed[i]);
        Collected::new(ldi, level, number, transfer, numbers, bytes, combining.published)
    };
    let collected: Vec<Collected> = (0..sources.len()).map(collected).collect();
    let Pinhole { width, height, .. } = frame.camera;
    let rows_at_once = (rows_at_once / STRIP * STRIP).clamp(STRIP, height.next_multiple_of(STRIP));
    let (mut rows, mut counts) = (Vec::with_capacity(height as usize), SampleCounts::default());
    for top in (0..height).step_by(rows_at_once as usize) {
        let part = top..height.min(top + rows_at_once);
        let parts = collected_in(&plans, &collected, width, &part, task)?;
        let of_strip = |strip: u32| {
            task.check_cancelled()?;
            let size = [width, STRIP.min(part.end - part.start - strip * STRIP)];
            let strips = parts.iter().map(|strips| &strips[strip as usize]);
            let samples: Vec<&Strip> = strips.filter(|strip| !strip.is_empty()).collect();
            Ok(merged(&samples, size, &surfaces.list, combining))
        };
        let strips = (0..(part.end - part.start).div_ceil(STRIP)).into_par_iter().map(of_strip);
        for (of_strip, counted) in strips.collect::<Result<Vec<_>>>()? {
            rows.extend(of_strip);
            counts += counted;
        }
    }
    Ok((rows, counts))
}

/// Collects the samples of all sources in some rows of the common camera: strips from the top, for each of several parts of the
/// sources.
fn collected_in(
    plans: &[Plan],
    collected: &[Collected],
    width: u32,
    rows: &Range<u32>,
    task: &Task,
) -> Result<Vec<Vec<Strip>>> {
    let tile_parts: Vec<Vec<usize>> =
        plans.par_iter().map(|plan| plan.tile_parts_on::<CollectCanvas>(rows)).collect();
    let parts = tile_parts.iter().enumerate();
    let parts =
        parts.flat_map(|(source, tile_parts)| tile_parts.chunks(TILE_PARTS).map(move |part| (source, part)));
    let parts: Vec<(usize, &[usize])> = parts.collect();
    let of_part = |(source, tile_parts): (usize, &[usize])| {
        task.check_cancelled()?;
        let canvas = CollectCanvas::new(&collected[source], width, rows);
        Ok(plans[source].draw_tile_parts(tile_parts, rows, canvas).strips)
    };
    parts.into_par_iter().map(of_part).collect()
}

/// Merges the samples of a strip, which are in several lists.
fn merged(
    samples: &[&Strip],
    [width, rows]: [u32; 2],
    surfaces: &[super::LdiSurface],
    combining: &Combining,
) -> (Vec<Row>, SampleCounts) {
    let mut out: Vec<Row> = vec![Row::new(); rows as usize];
    let mut layers = Vec::new();
    let (mut sorted, ends) = by_pixel(samples, (width * rows) as usize);
    let mut counts = SampleCounts { samples: sorted.len() as u64, ..SampleCounts::default() };
    let mut start = 0;
    for (pixel, &end) in (0..).zip(&ends) {
        let group = &mut sorted[start..end as usize];
        start = end as usize;
        if group.is_empty() {
            continue;
        }
        let (x, row) = ((pixel % width) as u16, &mut out[(pixel / width) as usize]);
        let before = row.len();
        let dropped = if combining.published {
            group.sort_unstable_by_key(|sample| (sample.source, sample.place));
            merge_as_published_into(group, &combining.merging, &mut layers, |pixel| row.push((x, pixel)))
        } else {
            merge_into(group, surfaces, 1.0, &combining.merging, |pixel| row.push((x, pixel)))
        };
        counts.dropped += dropped;
        counts.merged += group.len() as u64 - (row.len() - before) as u64 - dropped;
    }
    (out, counts)
}

/// Returns samples pixel by pixel, those of one pixel in the order in which they were, and the end of each of the `pixels`
/// pixels.
fn by_pixel(samples: &[&Strip], pixels: usize) -> (Vec<SurfaceSample>, Vec<u32>) {
    let mut ends = vec![0u32; pixels];
    for (pixel, _) in samples.iter().copied().flatten() {
        ends[*pixel as usize] += 1;
    }
    let mut sum = 0;
    for end in &mut ends {
        // At first where the pixel begins; its samples move it to its end.
        (sum, *end) = (sum + *end, sum);
    }
    let mut sorted = vec![SurfaceSample::default(); sum as usize];
    for (pixel, sample) in samples.iter().copied().flatten() {
        let at = &mut ends[*pixel as usize];
        sorted[*at as usize] = *sample;
        *at += 1;
    }
    (sorted, ends)
}

/// Returns stored values at the frame's exposure by stored values at another one.
fn exposed(gain: &[f64; 3], frame: &CommonCamera) -> [[u8; 256]; 3] {
    std::array::from_fn(|c| match frame.gain[c] - gain[c] {
        0.0 => std::array::from_fn(|byte| byte as u8),
        difference => bytes_of_light_times(difference.exp()),
    })
}
