//! The command `tree render`.

use glam::DVec3;
use serde_json::json;

use super::light::check_sun;
use crate::Outcome;
use crate::args::{FlakesOf, Shadows, TreeMethod, TreeQuality, TreeRenderArgs};
use crate::render::{BEHIND_VIDEOS, USUAL_FPS, table};
use crate::table::counted;
use crate::view_args::size;
use crate::words::error_text;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::writable::check_folder;
use quadratura_foliage::files::read_plant;
use quadratura_foliage::{BakeOptions, FlakeOptions, LayeredOptions, PictureSimilarity, Plant};
use quadratura_sites::views::{RequestedView, RequestedViews, Size};
use quadratura_trees::{PlantDrawing, PlantMethod, PlantViews, ViewComparison, plant_images, plant_views};
use quadratura_views::render::{RenderOptions, RenderReport, VideoOptions, render};

/// The value of `--cameras` that stands for views around the plant.
const ORBIT: &str = "orbit";

/// Runs `tree render`.
pub fn run(args: &TreeRenderArgs, task: &Task) -> Result<Outcome> {
    // What cannot be written is reported before the work, not after it.
    args.pictures.check_places()?;
    args.images.as_deref().map(check_folder).transpose()?;
    let plant = task.timed("read", || read_plant(&args.plant.plant, args.plant.seed, task))?;
    let sun = args.sun.map(DVec3::from_array);
    sun.map(|sun| check_sun(sun, plant.up, "plant")).transpose()?;
    let from = match &args.cameras {
        word if word.as_os_str() == ORBIT => PlantViews::Orbit,
        path => PlantViews::At(path.clone()),
    };
    let size = size(args.pictures.size, args.pictures.scale).unwrap_or(Size::Own);
    let views = plant_views(&plant, &from, size, args.pictures.fps, task)?;
    let drawing = PlantDrawing::new(&plant, method(args, &plant, task)?, sun, args.compare);
    let drawing = if views.path.is_some() { drawing.with_frames() } else { drawing };
    let mut drawing = match has_shadows(args) {
        true => task.timed("shadows", || drawing.with_shadows(task))?,
        false => drawing,
    };
    let mut draw = |view: &RequestedView, task: &Task| drawing.picture(view, task).map(Into::into);
    let options = RenderOptions {
        out: args.pictures.out.clone(),
        film: film(args, &views),
        ..RenderOptions::default()
    };
    let report = render(&views.list, &mut draw, &options, task)?;
    note_empty(&report, task);
    let mut problems: Vec<String> = views.problems.iter().map(error_text).collect();
    problems.extend(report.failed.iter().map(|(view, error)| format!("{view}: {}", error_text(error))));
    Ok(outcome(args, &plant, &report, &drawing, views.path.is_some(), problems))
}

/// Returns whether the plant is drawn with its shadows on itself.
fn has_shadows(args: &TreeRenderArgs) -> bool {
    args.method == TreeMethod::Polygons && args.shadows != Some(Shadows::Off)
}

/// Returns how the plant is drawn; images are read or made.
///
/// # Errors
/// [`Error::Request`] for options without effect; those of [`plant_images`].
fn method(args: &TreeRenderArgs, plant: &Plant, task: &Task) -> Result<PlantMethod> {
    refuse_without_effect(args)?;
    let is_final = args.quality == TreeQuality::Final;
    let images = |options: BakeOptions| {
        let options = BakeOptions { from_parts: args.from_parts, ..options };
        plant_images(plant, args.images.as_deref(), &options, task).map(|(images, _)| images)
    };
    let of_texels = |coarse: FlakeOptions, fine: FlakeOptions| {
        let mut options = if is_final { fine } else { coarse };
        options.walk.threshold = args.tau.unwrap_or(options.walk.threshold);
        options
    };
    Ok(match args.method {
        TreeMethod::Polygons => PlantMethod::Polygons,
        TreeMethod::Layers => {
            let mut options = if is_final { LayeredOptions::FINAL } else { LayeredOptions::PREVIEW };
            options.walk.threshold = args.tau.unwrap_or(options.walk.threshold);
            PlantMethod::Layers(images(BakeOptions::LAYERS)?, options)
        }
        TreeMethod::Planes => {
            let options = of_texels(FlakeOptions::PREVIEW_PLANES, FlakeOptions::FINAL_PLANES);
            PlantMethod::Texels(images(BakeOptions::SLABS)?, options)
        }
        TreeMethod::Flakes => {
            let kind = match args.flakes_of {
                Some(FlakesOf::Layers) => BakeOptions::LAYERS,
                Some(FlakesOf::Slabs) | None => BakeOptions::SLABS,
            };
            PlantMethod::Texels(images(kind)?, of_texels(FlakeOptions::PREVIEW, FlakeOptions::FINAL))
        }
    })
}

/// Refuses options that the method does not know.
fn refuse_without_effect(args: &TreeRenderArgs) -> Result<()> {
    if args.flakes_of.is_some() && args.method != TreeMethod::Flakes {
        return Err(Error::Request(
            "--flakes-of has an effect on --method flakes alone; give that, or leave it out".into(),
        ));
    }
    if args.method == TreeMethod::Polygons {
        let without_effect = [
            (args.tau.is_some(), "--tau"),
            (args.images.is_some(), "--images"),
            (args.from_parts, "--from-parts"),
            (args.compare, "--compare"),
            (args.quality != TreeQuality::default(), "--quality"),
        ];
        if let Some((_, option)) = without_effect.iter().find(|(given, _)| *given) {
            return Err(Error::Request(format!(
                "{option} has no effect on --method polygons; give --method layers, planes or flakes, or leave it out"
            )));
        }
    } else if args.shadows == Some(Shadows::On) {
        return Err(Error::Request(
            "pictures from images have no shadows; give --method polygons, or leave --shadows out".into(),
        ));
    }
    Ok(())
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
    report: &RenderReport,
    drawing: &PlantDrawing,
    is_flight: bool,
    problems: Vec<String>,
) -> Outcome {
    let table = if is_flight { String::new() } else { table(&report.done) + "\n" };
    let film = report.film.as_ref().map_or(String::new(), |film| format!("video: {}\n", film.display()));
    let done = counted(report.done.len(), "picture");
    let of = plant.whole().counts.triangles;
    let compared = drawing.compared.as_deref().map_or(String::new(), similarity_table);
    let text =
        format!("{table}{compared}{done} of {of} triangles in {}\n{film}", args.pictures.out.display());
    let json = json!({
        "pictures": report.done,
        "film": report.film,
        "method": match args.method {
            TreeMethod::Polygons => "polygons",
            TreeMethod::Layers => "layers",
            TreeMethod::Planes => "planes",
            TreeMethod::Flakes => "flakes",
        },
        "shadows": has_shadows(args),
        "sun": drawing.towards_sun().to_array(),
        "counts": plant.whole().counts,
        "projected_triangles": drawing.triangles,
        "layered": drawing.layered,
        "compared": drawing.compared,
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Returns the table of views beside brute force, with the means.
fn similarity_table(compared: &[ViewComparison]) -> String {
    let line = |name: &str, similarity: &PictureSimilarity, speedup: f64| {
        let PictureSimilarity { ssim, coverage, light, height_px, .. } = similarity;
        let percent = |ratio: f64| 100.0 * (ratio - 1.0);
        let (coverage, light) = (percent(*coverage), percent(*light));
        format!("{name:<16} {height_px:>8} {ssim:>8.4} {coverage:>+9.2} % {light:>+8.2} % {speedup:>8.1} x\n")
    };
    let shown: Vec<(&ViewComparison, PictureSimilarity)> =
        compared.iter().filter_map(|of| of.similarity.map(|similarity| (of, similarity))).collect();
    let mut text = format!(
        "{:<16} {:>8} {:>8} {:>11} {:>10} {:>10}\n",
        "beside polygons", "rows", "SSIM", "coverage", "light", "faster"
    );
    for (of, similarity) in &shown {
        text += &line(&of.view, similarity, of.speedup);
    }
    let mean = |value: &dyn Fn(&PictureSimilarity) -> f64| {
        shown.iter().map(|(_, similarity)| value(similarity)).sum::<f64>() / shown.len().max(1) as f64
    };
    let similarity = PictureSimilarity {
        ssim: mean(&|of| of.ssim),
        coverage: mean(&|of| of.coverage),
        light: mean(&|of| of.light),
        covered_px: mean(&|of| of.covered_px),
        height_px: mean(&|of| f64::from(of.height_px)).round() as u32,
    };
    let speedup = shown.iter().map(|(of, _)| of.speedup).sum::<f64>() / shown.len().max(1) as f64;
    text + &line("mean", &similarity, speedup) + &jumps(compared)
}

/// Returns the line on jumps between frames, where there are frames.
fn jumps(compared: &[ViewComparison]) -> String {
    let with_jumps = || compared.iter().filter_map(|of| of.jump.map(|jump| (of, jump)));
    let Some((at, largest)) = with_jumps().max_by(|a, b| a.1.most.total_cmp(&b.1.most)) else {
        return String::new();
    };
    let mean = with_jumps().map(|(_, jump)| jump.mean).sum::<f64>() / with_jumps().count() as f64;
    format!(
        "from frame to frame, blocks of 8 x 8 pixels change by {mean:.2} steps of 255 more or less than those of polygons on average, and by {:.1} \
         at most (frame {})\n",
        largest.most, at.view
    )
}
