//! The command `ortho`.

use serde_json::json;

use super::Outcome;
use super::args::OrthoArgs;
use super::fill::note_stale_fillings;
use super::words::error_text;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_gpu::Gpu;
use quadratura_io::stack_readers::StackReader;
use quadratura_projection::TextureOptions;
use quadratura_sites::open::open;
use quadratura_view::DisplayMode;
use quadratura_views::colour::usual_exposure;
use quadratura_views::ortho::{OrthoOptions, OrthoReport, make, planned};
use quadratura_views::preview;

/// Runs `ortho`: draws an orthographic picture to scale and writes it.
pub fn run(args: &OrthoArgs, task: &Task) -> Result<Outcome> {
    let resolution = args.resolution()?;
    let opened = open(&args.project, task)?;
    // Stacks that change meanwhile stay readable as they were.
    let _reader = StackReader::begin(&args.project);
    let (project, site) = (&opened.project, &opened.site);
    let mut formats = args.format.clone();
    formats.dedup();
    let options = OrthoOptions {
        subject: args.subject(),
        resolution,
        depth_m: args.depth,
        look: args.look.look(project, site, DisplayMode::Colour, usual_exposure(project, site))?,
        out: args.out.clone(),
        name: args.name.clone(),
        formats,
        title: args.title.clone(),
        memory: args.memory.or_default(),
    };
    let plan = planned(&opened, &options)?;
    note_stale_fillings(&args.project, project, site, task)?;
    let gpu = task.timed("start the GPU", Gpu::headless)?;
    let mut look = args.look.preview();
    if args.look.texture_memory.is_none() {
        look.textures =
            TextureOptions { storage: look.textures.storage, ..TextureOptions::within(options.memory) };
    }
    let mut renderer = preview::open(&args.project, project, site, &gpu, &look, task)?;
    let report = make(&opened, &plan, &options, &mut renderer, task)?;
    let mut problems: Vec<String> = opened.problems.errors.iter().map(error_text).collect();
    problems.extend(renderer.problems().iter().map(super::words::worded));
    let mut json = json!(report);
    json["folder"] = json!(report.folder);
    json["problems"] = json!(problems);
    Ok(Outcome { text: text(&report), json, problems })
}

/// Rounds a number to three decimals, which are shown without trailing zeros.
fn short(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}

fn text(report: &OrthoReport) -> String {
    let [width, height] = report.size_px;
    let metres = report.size_px.map(|side| f64::from(side) * report.pixel_m);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let shares = &report.shares;
    let mut text = format!(
        "{} in {}\n{width} x {height} pixels of {} mm: {} x {} m, 1:{} at {} dpi\n\
         record {} (photographed {}, filled from other photos {}), reconstruction {} (painted {}, inpainted {}), shown by no photo {}\n",
        report.files.join(", "),
        report.folder.display(),
        short(1000.0 * report.pixel_m),
        short(metres[0]),
        short(metres[1]),
        short(report.scale),
        short(report.dpi),
        percent(shares.record()),
        percent(shares.photographed),
        percent(shares.filled),
        percent(shares.reconstruction()),
        percent(shares.painted),
        percent(shares.inpainted),
        percent(shares.nothing),
    );
    if let Some(pixel) = report.photo_pixel_m {
        text.push_str(&format!(
            "the best photo has pixels of {:.1} mm on the surface, in the median: points are known to about so much\n",
            1000.0 * pixel
        ));
    }
    if let (Some(epsg), Some([east, north])) = (report.epsg, report.map_corner) {
        text.push_str(&format!("upper left corner: E {east:.3} N {north:.3} in EPSG:{epsg}\n"));
    }
    if let Some([width, height]) = report.page_mm {
        text.push_str(&format!("page: {width:.0} x {height:.0} mm\n"));
    }
    for what in &report.left_out {
        text.push_str(&format!("not shown: {what}\n"));
    }
    text
}
