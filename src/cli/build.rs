//! The command `build`.

use serde_json::json;

use super::Outcome;
use super::args::BuildArgs;
use super::lock::{lock_and_read, read_to_make};
use super::painted::PaintReport;
use super::stacks::StackTable;
use super::table::counted;
use super::transients::note_large;
use super::words::error_text;
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_io::project::write_project;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Options;
use quadratura_sites::open::open_site;
use quadratura_stacks::build::{BuildOptions, Built, build};
use quadratura_stacks::decide::stale;
use quadratura_views::preview;

/// Runs `build`: builds the stacks of the chosen photos and, unless told otherwise, what previews need. A photo
/// that fails becomes a problem.
pub fn run(args: &BuildArgs, task: &Task) -> Result<Outcome> {
    let mut project = read_to_make(&args.project)?;
    let options = options(args, &mut project, task)?;
    let store = StackStore::new(&args.project);
    // Whoever builds single photos may be one of many, and each cleans up after its own.
    let is_whole = args.photos.names.is_empty() && args.part.part.is_none();
    let mut kept = if is_whole { store.clean()? } else { Vec::new() };
    // The GPU driver starts while the photos are checked.
    let (opened, rasteriser) = rayon::join(
        || open_site(&args.project, project, task),
        || task.timed("start the GPU", || GpuRasteriser::new(&Gpu::headless()?)),
    );
    let (opened, rasteriser) = (opened?, rasteriser?);
    let chosen = args.part.of(&args.photos, &opened.site)?;
    opened.photos_named(&chosen.names)?;
    let options = BuildOptions {
        layers: options,
        decisions: opened.project.decisions.clone(),
        photos: chosen.names.clone(),
        memory: args.memory.or_default(),
        threads: rayon::current_num_threads(),
        force: args.force,
    };
    stale(&opened.project.decisions, &opened.site).iter().for_each(|gone| task.note(gone.clone()));
    note_unknown_objects(&options.layers, &opened.site, task);
    let built = build(&opened.site, &store, &rasteriser, &options, task)?;
    if !args.stacks_only {
        preview::prepare(&args.project, &opened.project, &opened.site, task)?;
    }
    kept.extend(built.iter().flat_map(|built| built.kept.clone()));
    for file in kept {
        task.note(format!("a file that was changed by hand was moved to {}", file.display()));
    }
    // Whether a photo was built now or earlier, the same is told about it.
    let current = built.iter().filter(|photo| photo.stack.is_ok());
    let current: Vec<String> = current.map(|photo| photo.photo.clone()).collect();
    if !args.stacks_only {
        note_large(&args.project, &opened.project, &opened.site, &current, options.memory, task)?;
    }
    let painted = PaintReport::new(&opened.site, &store)?;
    let (problems, left_out) =
        (chosen.problems_of(&opened.problems, task), chosen.left_out(&opened.site, &opened.problems));
    Ok(report(&opened.site, &built, &painted, problems, left_out))
}

/// Returns the project's options with those that were given, and saves them if requested.
fn options(args: &BuildArgs, project: &mut Project, task: &Task) -> Result<Options> {
    let options = args.options.applied_to(&project.options);
    if options == project.options {
        return Ok(options);
    }
    if args.save_options {
        let (_lock, now) = lock_and_read(&args.project, task)?;
        *project = Project { options: options.clone(), ..now };
        write_project(&args.project, project)?;
    } else {
        task.note(
            "these options apply only to this build: the next build without them builds \
             again (--save-options saves them in project.json)",
        );
    }
    Ok(options)
}

/// Reports options of objects that the model does not have.
fn note_unknown_objects(options: &Options, site: &Site, task: &Task) {
    let is_known = |name: &str| site.model.objects.iter().any(|object| object.name == name);
    for name in options.objects.keys().filter(|name| !is_known(name)) {
        task.note(format!("the options of {name:?} have no effect: the model has no object of this name"));
    }
}

fn report(
    site: &Site,
    built: &[Built],
    painted: &PaintReport,
    mut problems: Vec<String>,
    left_out: usize,
) -> Outcome {
    let mut table = StackTable::default();
    for photo in built {
        match &photo.stack {
            Ok(stack) => {
                table.add(&photo.photo, if photo.up_to_date { "up to date" } else { "built" }, Some(stack))
            }
            Err(_) => table.add(&photo.photo, "failed", None),
        }
    }
    let failed = built.iter().filter_map(|built| Some((&built.photo, built.stack.as_ref().err()?)));
    let left_out = left_out + failed.clone().count();
    problems.extend(failed.map(|(photo, error)| format!("{photo}: {}", error_text(error))));
    let fresh = built.iter().filter(|built| built.stack.is_ok() && !built.up_to_date).count();
    let text = format!(
        "{}\n{} built, {} up to date, {} left out or failed; model of {}\n{}",
        table.text(),
        counted(fresh, "stack"),
        built.iter().filter(|built| built.up_to_date).count(),
        left_out,
        counted(site.model.faces.len(), "face"),
        painted.lost(),
    );
    problems.extend(painted.problems());
    let json = json!({ "photos": table.into_json(), "paint": painted.to_json(), "problems": problems });
    Outcome { text, json, problems }
}
