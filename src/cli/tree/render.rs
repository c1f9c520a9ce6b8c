//! The command `tree render`.

use serde_json::json;

use crate::cli::Outcome;
use crate::cli::args::{Shadows, TreeMethod, TreeRenderArgs};
use crate::cli::render::{BEHIND_VIDEOS, USUAL_FPS, table};
use crate::cli::table::counted;
use crate::cli::view_args::size;
use crate::cli::words::error_text;
use crate::error::Result;
use crate::foliage::Plant;
use crate::io::film::kind_of;
use crate::io::plants::read_plant;
use crate::recipe::render::{RenderOptions, RenderReport, VideoOptions, render};
use crate::recipe::trees::{PlantDrawing, PlantViews, plant_views};
use crate::recipe::views::{RequestedView, RequestedViews, Size};
use crate::task::Task;

/// The value of `--cameras` that stands for views around the plant.
const ORBIT: &str = "orbit";

/// Runs `tree render`.
pub fn run(args: &TreeRenderArgs, task: &Task) -> Result<Outcome> {
    // An unsuitable file name is reported before the work, not after it.
    args.pictures.video.as_deref().map(kind_of).transpose()?;
    let plant = task.timed("read", || read_plant(&args.plant.plant, args.plant.seed, task))?;
    let from = match &args.cameras {
        word if word.as_os_str() == ORBIT => PlantViews::Orbit,
        path => PlantViews::At(path.clone()),
    };
    let size = size(args.pictures.size, args.pictures.scale).unwrap_or(Size::Own);
    let views = plant_views(&plant, &from, size, args.pictures.fps, task)?;
    let drawing = PlantDrawing::new(&plant);
    let mut drawing = match args.shadows {
        Shadows::On => task.timed("shadows", || drawing.with_shadows(task))?,
        Shadows::Off => drawing,
    };
    let mut draw = |view: &RequestedView, task: &Task| drawing.picture(view, task);
    let options = RenderOptions {
        out: args.pictures.out.clone(),
        film: film(args, &views),
        film_alone: false,
        legend: None,
        stereo: false,
    };
    let report = render(&views.list, &mut draw, &options, task)?;
    note_empty(&report, task);
    let mut problems: Vec<String> = views.problems.iter().map(error_text).collect();
    problems.extend(report.failed.iter().map(|(view, error)| format!("{view}: {}", error_text(error))));
    Ok(outcome(args, &plant, (&report, drawing.triangles), views.path.is_some(), problems))
}

fn film(args: &TreeRenderArgs, views: &RequestedViews) -> Option<VideoOptions> {
    let fps = args.pictures.fps.or(views.path.as_ref().map(|path| path.fps)).unwrap_or(USUAL_FPS);
    args.pictures.video.clone().map(|file| VideoOptions { file, fps, background: BEHIND_VIDEOS })
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
        task.note(format!("nothing of the plant is in view {first}{others}; the picture is empty"));
    }
}

/// Reports the pictures; the frames of a flight are not listed.
fn outcome(
    args: &TreeRenderArgs,
    plant: &Plant,
    (report, triangles): (&RenderReport, u64),
    is_flight: bool,
    problems: Vec<String>,
) -> Outcome {
    let table = if is_flight { String::new() } else { table(&report.done) + "\n" };
    let film = report.film.as_ref().map_or(String::new(), |film| format!("video: {}\n", film.display()));
    let done = counted(report.done.len(), "picture");
    let of = plant.whole().counts.triangles;
    let text = format!("{table}{done} of {of} triangles in {}\n{film}", args.pictures.out.display());
    let json = json!({
        "pictures": report.done,
        "film": report.film,
        "method": match args.method {
            TreeMethod::Polygons => "polygons",
        },
        "shadows": args.shadows == Shadows::On,
        "counts": plant.whole().counts,
        "projected_triangles": triangles,
        "problems": problems,
    });
    Outcome { text, json, problems }
}
