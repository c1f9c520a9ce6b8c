//! The command `ldi build --cube` and `--set`: several layered depth images in one file.

use std::path::Path;

use serde_json::{Value, json};

use super::build::note_spared;
use crate::Outcome;
use crate::args::LdiBuildArgs;
use crate::bytes::readable_bytes;
use crate::table::Table;
use crate::words::error_text;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_gpu::start_device;
use quadratura_images::{BuildFrom, BuiltSet, CubeRequest, ImageOfSet, SetRequest, build_cube, build_set};
use quadratura_ldi::file::Packing;
use quadratura_sites::open::Opened;

/// Builds a cube or a set.
pub fn run(
    args: &LdiBuildArgs,
    project: &Path,
    opened: &Opened,
    photos: Vec<PhotoId>,
    from: BuildFrom,
    task: &Task,
) -> Result<Outcome> {
    let out = args.out.as_deref().ok_or_else(|| Error::Usage("give --out FILE".into()))?;
    let packing = args.packing.unwrap_or(Packing::Deflate);
    let (built, failed) = match args.set {
        Some(most) => {
            let request = SetRequest { photos, from, most: most as usize, out, packing };
            build_set(project, &opened.project, &opened.site, &request, &start_device, task)?
        }
        None => {
            let [photo] = photos[..] else {
                let found = "a cube is around the place of one photo; name it with --photo";
                return Err(Error::Request(found.into()));
            };
            let request = CubeRequest { photo, from, out, packing };
            (build_cube(project, &opened.project, &opened.site, &request, &start_device, task)?, Vec::new())
        }
    };
    note_spared(&built.spared, &built.file, task);
    if let Some(most) = args.set.filter(|most| built.images.len() as u32 == *most) {
        note_uncovered(&built, most, task);
    }
    let mut problems = args.photos.problems_of(&opened.problems, task);
    problems.extend(failed.iter().map(error_text));
    Ok(Outcome { text: text(&built), json: described(&built, &problems), problems })
}

/// The share of points from which on a set covers a site.
const COVERED: f64 = 0.99;

/// Notes that more images would show more.
fn note_uncovered(built: &BuiltSet, most: u32, task: &Task) {
    let share = built.covered() as f64 / built.points.max(1) as f64;
    if share < COVERED {
        task.note(format!(
            "the set covers {:.1} % of what the photos show; more images than --set {most} would cover more",
            100.0 * share
        ));
    }
}

fn text(built: &BuiltSet) -> String {
    let share = |points: usize| format!("{:.1} %", 100.0 * points as f64 / built.points.max(1) as f64);
    let is_set = built.points > 0;
    let mut names = vec!["image", "depth pixels", "complexity", "layers", "size"];
    names.extend(if is_set { &["covers", "adds"][..] } else { &[] });
    let mut table = Table::new(&names);
    for ImageOfSet { name, chosen, depth_pixels, report, bytes } in &built.images {
        let mut cells = vec![
            name.clone(),
            depth_pixels.to_string(),
            format!("{:.2}", report.depth_complexity),
            report.layers.to_string(),
            readable_bytes(*bytes),
        ];
        cells.extend(chosen.iter().flat_map(|chosen| [share(chosen.covers), share(chosen.adds)]));
        table.row(cells);
    }
    let (file, size) = (built.file.display(), readable_bytes(built.bytes));
    let (count, name) = (built.images.len(), built.arrangement.name());
    let covered = if is_set { format!(", covers {}", share(built.covered())) } else { String::new() };
    format!("{}\n{name} of {count} in {file}, {size}{covered}\n", table.render())
}

fn described(built: &BuiltSet, problems: &[String]) -> Value {
    let image = |image: &ImageOfSet| {
        json!({
            "image": image.name,
            "depth_pixels": image.depth_pixels,
            "bytes": image.bytes,
            "report": image.report,
            "covers": image.chosen.map(|chosen| chosen.covers),
            "adds": image.chosen.map(|chosen| chosen.adds),
        })
    };
    json!({
        "arrangement": built.arrangement.name(),
        "file": built.file,
        "bytes": built.bytes,
        "points": built.points,
        "covered": built.covered(),
        "images": built.images.iter().map(image).collect::<Vec<_>>(),
        "spared": built.spared,
        "problems": problems,
    })
}
