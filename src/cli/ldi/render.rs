//! The command `ldi render`.

use std::path::Path;

use serde_json::json;

use super::input::{read_images, read_partly};
use crate::Outcome;
use crate::args::LdiRenderArgs;
use crate::render::{BEHIND_VIDEOS, USUAL_FPS, table};
use crate::table::counted;
use crate::view_args::{PHOTOS, size};
use crate::words::error_text;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_images::COMFORTABLE;
use quadratura_images::view::{LdiDrawing, views_of};
use quadratura_ldi::warp::check_splat;
use quadratura_ldi::{LdiSet, Shown, Spacing, SplatKind, WarpOptions};
use quadratura_sites::views::{RequestedView, RequestedViews, Size, ViewRequest, ViewSource};
use quadratura_views::render::{RenderOptions, RenderReport, VideoOptions, render};

/// The meaning of pixels without any colour.
const NOTHING_THERE: &str = "nothing in the image (transparent)";

/// Runs `ldi render`.
pub fn run(args: &LdiRenderArgs, task: &Task) -> Result<Outcome> {
    // What cannot be written is reported before the work, not after it.
    args.pictures.check_places()?;
    let (sets, mut problems) = read_all(args, task)?;
    let warp_options = warp_options(args);
    sets.iter().try_for_each(|set| check_splat(set, warp_options.splat))?;
    let source = match &args.cameras {
        Some(path) if path.as_os_str() != PHOTOS => ViewSource::At(path.clone()),
        _ => ViewSource::Photos,
    };
    let size = size(args.pictures.size, args.pictures.scale).unwrap_or(Size::Own);
    let views = views_of(&sets, &ViewRequest { source, size, fps: args.pictures.fps }, task)?;
    let mut drawing = LdiDrawing::new(&sets, warp_options, args.quality, args.stereo, args.show.shown());
    let mut draw = |view: &RequestedView, task: &Task| drawing.picture(view, task).map(Into::into);
    let film = film(args, &views);
    let (out, stereo) = (args.pictures.out.clone(), args.stereo.is_some());
    let grey = args.show.shown().is_some();
    let options = RenderOptions { out, film, stereo, grey, ..RenderOptions::default() };
    let report = render(&views.list, &mut draw, &options, task)?;
    note_too_near(&drawing.too_near, task);
    note_uncomfortable(&drawing.uncomfortable, task);
    note_empty(&report, task);
    problems.extend(views.problems.iter().map(error_text));
    problems.extend(report.failed.iter().map(|(view, error)| format!("{view}: {}", error_text(error))));
    let mut outcome = outcome(args, &report, views.path.is_some(), problems);
    if let Some(shown) = args.show.shown().filter(|_| !report.done.is_empty() || report.film.is_some()) {
        let layers = sets.iter().flat_map(|set| &set.images).map(|ldi| ldi.report.layers).max().unwrap_or(1);
        let uncovered = (shown != Shown::Holes).then_some(NOTHING_THERE);
        outcome.explain(&shown.legend(layers), uncovered);
    }
    Ok(outcome)
}

/// Reads the files. One that cannot be used is a problem, and the others go on.
fn read_all(args: &LdiRenderArgs, task: &Task) -> Result<(Vec<LdiSet>, Vec<String>)> {
    let (mut sets, mut errors) = (Vec::new(), Vec::new());
    for file in &args.files {
        match task.timed("read", || read(file, args.partial, task)) {
            Ok(set) => sets.push(set),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => errors.push(error),
        }
    }
    if sets.is_empty()
        && let Some(error) = Error::of_all(std::mem::take(&mut errors))
    {
        return Err(error);
    }
    Ok((sets, errors.iter().map(error_text).collect()))
}

fn read(path: &Path, partial: bool, task: &Task) -> Result<LdiSet> {
    if partial && !path.is_dir() { read_partly(path, task) } else { read_images(path, task) }
}

fn warp_options(args: &LdiRenderArgs) -> WarpOptions {
    match args.published {
        true => WarpOptions { splat: SplatKind::Over, spacing: Spacing::Table, ..WarpOptions::default() },
        false => WarpOptions { splat: args.splat, ..WarpOptions::default() },
    }
}

fn film(args: &LdiRenderArgs, views: &RequestedViews) -> Option<VideoOptions> {
    let fps = args.pictures.fps.or(views.path.as_ref().map(|path| path.fps)).unwrap_or(USUAL_FPS);
    args.pictures.video.clone().map(|file| VideoOptions { file, fps, background: BEHIND_VIDEOS })
}

/// Notes views that were taken from so near that splats do not close the gaps.
fn note_too_near(too_near: &[(String, f64)], task: &Task) {
    let Some((view, share)) = too_near.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let others = match too_near.len() - 1 {
        0 => String::new(),
        others => format!(", and more than 1 % in {}", counted(others, "other view")),
    };
    task.note(format!(
        "{view}: {:.1} % of the depth pixels are too near for what the image resolves, and have gaps between them{others}; \
         give views that are farther away, smaller pictures, or an image of a camera that is nearer",
        // Of those of a set, each image has its own share.
        (100.0 * share).min(100.0)
    ));
}

/// Notes views of which something is nearer than the distance between the eyes allows.
fn note_uncomfortable(views: &[(String, f64)], task: &Task) {
    let Some((view, near)) = views.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let others = match views.len() - 1 {
        0 => String::new(),
        others => format!(", and in {}", counted(others, "other view")),
    };
    task.note(format!(
        "the eyes are farther apart than 1/20 of the depth of what is near, {near:.3} world units in {view}{others}, which is \
         uncomfortable to look at; give --stereo {:.3} or less",
        COMFORTABLE * near
    ));
}

/// Notes views that show nothing.
fn note_empty(report: &RenderReport, task: &Task) {
    let empty: Vec<&str> =
        report.done.iter().filter(|done| done.textured == 0.0).map(|done| done.view.as_str()).collect();
    if let Some(first) = empty.first() {
        let others = match empty.len() - 1 {
            0 => String::new(),
            others => format!(", and {}", counted(others, "other view")),
        };
        task.note(format!("nothing of the image is in view {first}{others}; the picture is empty"));
    }
}

/// Reports the pictures; the frames of a flight are not listed.
fn outcome(args: &LdiRenderArgs, report: &RenderReport, is_flight: bool, problems: Vec<String>) -> Outcome {
    let table = if is_flight { String::new() } else { table(&report.done) + "\n" };
    let film = report.film.as_ref().map_or(String::new(), |film| format!("video: {}\n", film.display()));
    let done = counted(report.done.len(), "picture");
    let text = format!("{table}{done} in {}\n{film}", args.pictures.out.display());
    let json = json!({ "pictures": report.done, "film": report.film, "problems": problems });
    Outcome { text, json, problems }
}
