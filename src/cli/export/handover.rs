//! `export` to the formats of other programs.

use std::path::Path;

use serde_json::json;

use super::super::Outcome;
use super::super::args::{ExportArgs, ExportTarget};
use super::super::bytes::readable_bytes;
use super::super::fill::note_stale_fillings;
use super::super::table::counted;
use super::super::words::error_text;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_exports::handover::baked::report::BakedReport;
use quadratura_exports::handover::blender::blend::make_blend;
use quadratura_exports::handover::{HandedOver, HandoverFormat, HandoverOptions, PHOTOS_PER_FACE, hand_over};
use quadratura_gpu::Gpu;
use quadratura_layers::device::SiteDevice;
use quadratura_sites::open::Opened;

/// The formats of layered files.
const LAYERED: &str = "psd, folder, ora and xcf";

/// The formats of other programs.
const OTHERS: &str = "blender, cameras, glb, obj, usd, exr and nuke";

/// The formats of models with textures.
const BAKED: &str = "glb, obj and usd";

/// Checks that no argument of other formats was given.
///
/// # Errors
/// Returns [`Error::Usage`].
pub fn check(args: &ExportArgs) -> Result<()> {
    let format = match args.format {
        ExportTarget::Layered(_) | ExportTarget::Page => None,
        ExportTarget::Handover(format) => Some(format),
    };
    let is_page = args.format == ExportTarget::Page;
    let is_layered = format.is_none() && !is_page;
    let is_blender = format == Some(HandoverFormat::Blender);
    let is_baked = format.is_some_and(HandoverFormat::is_baked);
    let is_obj = format == Some(HandoverFormat::Obj);
    let has_tiles = format.is_some_and(HandoverFormat::has_tiles);
    let (baked, page) = (&args.baked, &args.page);
    // The argument, whether it was given, whether it applies, and the formats that it is for.
    let given = [
        ("--provenance", args.provenance, is_layered, LAYERED),
        ("--even-colour", args.even_colour, is_layered, LAYERED),
        ("--world", args.handover.world, !is_layered, OTHERS),
        ("--blend", args.handover.blend, is_blender, "blender"),
        ("--photos-per-face", args.handover.photos_per_face.is_some(), is_blender, "blender"),
        ("--density", baked.density.is_some(), is_baked, BAKED),
        ("--page-size", baked.page_size.is_some(), is_baked, BAKED),
        ("--png", baked.png, is_baked, BAKED),
        ("--holes", baked.holes, is_baked, BAKED),
        ("--udim", baked.udim, has_tiles, "obj and usd: GLB has no tiles, its pages are materials"),
        ("--up", baked.up.is_some(), is_obj, "obj"),
        ("--title", page.title.is_some(), is_page, "page"),
        ("--quality", page.quality.is_some(), is_page, "page"),
        ("--longest", page.longest.is_some(), is_page, "page"),
        ("--budget", page.budget.is_some(), is_page, "page"),
        ("--credit", !page.credit.is_empty(), is_page, "page"),
        ("--licence", page.licence.is_some(), is_page, "page"),
        ("--viewpoint", page.viewpoint.is_some(), is_page, "page"),
        ("--keep-names", page.keep_names, is_page, "page"),
        ("--keep-coordinates", page.keep_coordinates, is_page, "page"),
        ("--open", page.open, is_page, "page"),
    ];
    match given.iter().find(|(_, given, applies, _)| *given && !applies) {
        Some((name, _, _, formats)) => {
            let found = match format {
                Some(format) => format.name(),
                None if is_page => "pages",
                None => "layered files",
            };
            Err(Error::Usage(format!("{name} does not apply to {found}; it is for --format {formats}")))
        }
        None => Ok(()),
    }
}

/// Writes the folder of the format, and returns a list of what is in it and of what was left out.
pub fn run(args: &ExportArgs, format: HandoverFormat, opened: &Opened, task: &Task) -> Result<Outcome> {
    let chosen = args.part.of(&args.photos, &opened.site)?;
    let photos = opened.photos_named(&chosen.names)?;
    let options = HandoverOptions {
        format,
        photos_per_face: args.handover.photos_per_face.unwrap_or(PHOTOS_PER_FACE),
        baked: args.baked.options(args.memory.or_default()),
        world: args.handover.world,
        memory: args.memory.or_default(),
    };
    let start =
        || -> Result<Box<dyn SiteDevice>> { Ok(Box::new(task.timed("start the GPU", Gpu::headless)?)) };
    if options.format.is_baked() {
        note_stale_fillings(&args.project, &opened.project, &opened.site, task)?;
    }
    let done = hand_over(&args.project, opened, &photos, &args.out, &options, &start, task)?;
    let mut problems = chosen.problems_of(&opened.problems, task);
    problems.extend(done.failed.iter().cloned());
    let blend = args.handover.blend.then(|| make_blend(&args.out, task));
    let blend = match blend.transpose() {
        Ok(blend) => blend,
        Err(error) => {
            problems.push(error_text(&error));
            None
        }
    };
    Ok(report(args, &done, blend.as_deref(), photos.len(), problems))
}

fn report(
    args: &ExportArgs,
    done: &HandedOver,
    blend: Option<&Path>,
    photos: usize,
    problems: Vec<String>,
) -> Outcome {
    let bytes = done.files.iter().map(|file| file.bytes).sum();
    let mut text = format!(
        "{} of {} in {}, {}\n",
        counted(done.files.len(), "file"),
        counted(photos, "photo"),
        args.out.display(),
        readable_bytes(bytes),
    );
    let [x, y, z] = done.origin;
    match (done.frame_from_world.is_some(), done.origin == [0.0; 3]) {
        (false, true) => (),
        (false, false) => text.push_str(&format!("coordinates are those of the world less {x}, {y}, {z}\n")),
        (true, is_zero) => {
            let less = if is_zero { String::new() } else { format!(" less {x}, {y}, {z}") };
            let frame = "the site's frame (`quadratura frame`)";
            text.push_str(&format!(
                "coordinates are those of {frame}{less}; --world writes those of the cameras\n"
            ));
        }
    }
    if let Some(baked) = &done.baked {
        text.push_str(&baked_text(baked));
    }
    for what in &done.left_out {
        text.push_str(&format!("not exported: {what}\n"));
    }
    if let Some(blend) = blend {
        text.push_str(&format!("Blender made {}\n", blend.display()));
    }
    let json = json!({ "blend": blend, "photos": photos, "export": done, "problems": problems });
    Outcome { text, json, problems }
}

/// Returns what there is to say about a baked model.
fn baked_text(baked: &BakedReport) -> String {
    let pages: Vec<String> =
        baked.pages.iter().map(|[width, height]| format!("{width} x {height}")).collect();
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let coverage = &baked.coverage;
    let limited = match baked.density_cap {
        Some(cap) => format!(", at most {cap:.1}, so that all fit one page: --density sets another limit"),
        None => String::new(),
    };
    format!(
        "{} of {} on {} of {} texels; {:.1} texels per unit{limited}\n\
         of the texels photos show {}, {} are filled from other photos, {} are inpainted, {} are shown by no photo; {} are finer than any photo\n",
        counted(baked.charts, "chart"),
        counted(baked.faces, "face"),
        counted(baked.pages.len(), "page"),
        pages.join(", "),
        baked.density,
        percent(coverage.photographed),
        percent(coverage.filled),
        percent(coverage.inpainted),
        percent(coverage.nothing),
        percent(baked.upsampled),
    )
}
