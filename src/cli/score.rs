//! The command `score`.

use serde_json::json;

use super::Outcome;
use super::table::Table;
use super::unexplained::unexplained_line;
use super::view_args::{ScoreArgs, ScoreBackground, exposure_name, size};
use super::words::{error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_files::writable::check_folder;
use quadratura_gpu::Gpu;
use quadratura_images::StackLdiOptions;
use quadratura_images::viewer::Viewer;
use quadratura_sites::check::unexplained::{Unexplained, unexplained};
use quadratura_sites::open::open;
use quadratura_sites::views::Size;
use quadratura_view::metrics::ImageMetrics;
use quadratura_view::{DisplayMode, Exposure};
use quadratura_views::preview;
use quadratura_views::render::Appearance;
use quadratura_views::score::{
    MeanScore, ObjectScore, PredictionTarget, ScoreOptions, ScoreReport, held_out, leave_one_out, score,
};

/// The default scale: half the photo's size, which reduces the effect of camera noise.
const USUAL_SCALE: f64 = 0.5;
/// Maximum number of objects in the table; `--json` has all.
const MOST_OBJECTS: usize = 12;

/// Runs `score`: compares renderings with the photos at the same cameras.
pub fn run(args: &ScoreArgs, task: &Task) -> Result<Outcome> {
    // What cannot be written is reported before the work, not after it.
    args.pictures.as_deref().map(check_folder).transpose()?;
    let (opened, gpu) =
        rayon::join(|| open(&args.project, task), || task.timed("start the GPU", Gpu::headless));
    let (opened, gpu) = (opened?, gpu?);
    let (targets, problems) = targets(args, &opened.site, task)?;
    let options = ScoreOptions {
        look: Appearance {
            without_surroundings: args.background == ScoreBackground::None,
            ..args.look.look(&opened.project, &opened.site, DisplayMode::Colour, Exposure::Decided)?
        },
        size: size(args.size, args.scale).unwrap_or(Size::Scaled(USUAL_SCALE)),
        only: args.only.clone(),
        trees: opened.project.trees.placed.iter().map(|tree| tree.name.clone()).collect(),
        ignored: args.ignore.clone(),
        ignore_background: args.ignore_background,
        pictures: args.pictures.clone(),
    };
    let mut preview = args.look.preview();
    // Where photos are left out in turn, the fillings of the others are made from them.
    preview.filled &= args.cameras.is_some();
    let stack = StackLdiOptions {
        filled: preview.filled,
        ..args.look.stack(args.background == ScoreBackground::Surroundings)
    };
    let of_images = args.made.options(stack, &opened.site)?;
    let renderer = preview::open(&args.project, &opened.project, &opened.site, &gpu, &preview, task)?;
    let mut renderer = Viewer::new(&args.project, &opened.project, &opened.site, renderer, of_images)?;
    let report = score(&opened.site.model, &targets, &mut renderer, &options, task)?;
    let mut problems: Vec<_> = opened.problems.errors.iter().chain(&problems).map(error_text).collect();
    problems.extend(report.failed.iter().map(|(photo, error)| format!("{photo}: {}", error_text(error))));
    problems.extend(renderer.preview().problems().iter().map(worded));
    let unexplained = unexplained(&opened.site, &opened.points);
    Ok(outcome(args, &options, &report, unexplained.as_ref(), problems))
}

fn targets(args: &ScoreArgs, site: &Site, task: &Task) -> Result<(Vec<PredictionTarget>, Vec<Error>)> {
    match (&args.cameras, &args.photos) {
        // Not with the project's own pinhole images, because held-out photos may have the same names.
        (Some(cameras), Some(photos)) => held_out(cameras, photos, &args.project.join("cache/heldout"), task),
        _ => Ok((leave_one_out(site), Vec::new())),
    }
}

fn outcome(
    args: &ScoreArgs,
    options: &ScoreOptions,
    report: &ScoreReport,
    unexplained: Option<&Unexplained>,
    problems: Vec<String>,
) -> Outcome {
    let text = format!(
        "{}\n{}{}\n{}{}\n{}",
        photos(report),
        legend(args),
        light(args, report),
        objects(&report.objects),
        unexplained_line(unexplained),
        args.pictures.as_ref().map_or(String::new(), |folder| {
            format!("photo, prediction and four times their difference: {}\n", folder.display())
        }),
    );
    let json = json!({
        "asked": asked(args, options),
        "photos": report.views,
        "mean": report.mean,
        "fit_explains": report.mean.as_ref().and_then(MeanScore::unexplained_light),
        "objects": report.objects,
        "unexplained": unexplained,
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Returns the settings that the figures depend on, as JSON.
fn asked(args: &ScoreArgs, options: &ScoreOptions) -> serde_json::Value {
    json!({
        "held_out": args.cameras.is_some(),
        "as": args.made.name(),
        "mode": options.look.blend.mode.name(),
        "photos_per_point": options.look.blend.photos,
        "quality": format!("{:?}", options.look.quality).to_lowercase(),
        "exposure": exposure_name(options.look.exposure),
        "relief": !args.look.flat,
        "agreement": options.look.blend.agreement,
        "without_transients": options.look.blend.without_transients,
        "filled": args.cameras.is_some() && !args.look.unfilled,
        "like": args.look.like,
        "without": args.look.without,
        "only": options.only,
        "ignored": options.ignored,
        "background_ignored": options.ignore_background,
    })
}

fn photos(report: &ScoreReport) -> String {
    let mut table =
        Table::new(&["photo", "covered", "PSNR", "fitted", "SSIM", "with holes: PSNR", "fitted", "SSIM"]);
    for view in &report.views {
        let covered = figures(view.covered.as_ref().map(of_metrics));
        let with_holes = figures(Some(of_metrics(&view.with_holes)));
        table.row([view.photo.clone(), percent(view.coverage)].into_iter().chain(covered).chain(with_holes));
    }
    if let Some(MeanScore { views, coverage, covered, with_holes }) = report.mean {
        let means = |m: &quadratura_views::score::MeanMetrics| (m.psnr, m.psnr_fitted, m.ssim);
        let (covered, with_holes) = (figures(covered.as_ref().map(means)), figures(Some(means(&with_holes))));
        let name = format!("mean of {views}");
        table.row([name, percent(coverage)].into_iter().chain(covered).chain(with_holes));
    }
    table.render()
}

fn of_metrics(metrics: &ImageMetrics) -> (f64, f64, Option<f64>) {
    (metrics.psnr, metrics.psnr_fitted, metrics.ssim)
}

/// Formats PSNR, fitted PSNR and SSIM.
fn figures(figures: Option<(f64, f64, Option<f64>)>) -> [String; 3] {
    let Some((psnr, fitted, ssim)) = figures else { return ["-", "-", "-"].map(String::from) };
    [format!("{psnr:.2}"), format!("{fitted:.2}"), ssim.map_or("-".into(), |ssim| format!("{ssim:.4}"))]
}

/// Explains the columns.
fn legend(args: &ScoreArgs) -> String {
    let predicted = if args.cameras.is_some() {
        "Held-out photos, predicted from the project's."
    } else {
        "Each photo is predicted from the others, without itself and without fillings, which may be made \
         from it."
    };
    let only = match args.only.is_empty() {
        true => String::new(),
        false => format!(" Compared: only pixels whose nearest surface is of {}.", args.only.join(", ")),
    };
    let ignored = match (args.ignore.is_empty(), args.ignore_background) {
        (true, false) => String::new(),
        (true, true) => " Left out: pixels that show no surface.".into(),
        (false, false) => format!(" Left out: {}.", args.ignore.join(", ")),
        (false, true) => format!(" Left out: {}, and pixels that show no surface.", args.ignore.join(", ")),
    };
    let filled = match args.cameras.is_some() && !args.look.unfilled {
        true => " Predictions include what `quadratura fill` put behind surfaces; --unfilled leaves it out.",
        false => "",
    };
    format!(
        "{predicted}{only}{ignored}{filled}\n\
         covered: share of the pixels that were predicted; the PSNR in dB, fitted PSNR and SSIM beside it are for \
         these pixels alone.\n\
         with holes: for all pixels, black where nothing was predicted.\n\
         fitted: after the best gain and offset for each channel of each photo.\n"
    )
}

/// Says when the colour fit explains much of the difference, and what to try.
fn light(args: &ScoreArgs, report: &ScoreReport) -> String {
    let Some(lead) = report.mean.as_ref().and_then(MeanScore::unexplained_light) else {
        return String::new();
    };
    let rule = match (&args.look.exposure, &args.look.like) {
        (None, None) => "other rules of --exposure (`quadratura colour` compares them)",
        _ => "the rule that predicts the project's own photos best, without --exposure and --like",
    };
    format!(
        "The fit explains {lead:.1} dB: colours are off as a whole, by exposure or light. Try {rule}, \
         --like with a photo of the same light, and `quadratura colour --leave-out` for photos of another light.\n"
    )
}

fn objects(objects: &[ObjectScore]) -> String {
    let mut table = Table::new(&["object", "pixels", "covered", "PSNR", "share of error"]);
    for object in objects.iter().take(MOST_OBJECTS) {
        let all = object.pixels + object.holes;
        table.row([
            object.object.clone().unwrap_or_else(|| "(surroundings)".into()),
            all.to_string(),
            percent(object.pixels as f64 / all as f64),
            object.psnr.map_or("-".into(), |psnr| format!("{psnr:.2}")),
            percent(object.error_share),
        ]);
    }
    let more = objects.len().saturating_sub(MOST_OBJECTS);
    let more =
        if more > 0 { format!("... and {more} more objects with smaller shares\n") } else { String::new() };
    format!("Squared error of all photos by object:\n{}{more}", table.render())
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
