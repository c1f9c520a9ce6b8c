//! The command `fill`.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::FillArgs;
use super::fill_table::FillTable;
use super::lock::{lock_and_read, read_to_make};
use super::propagation_table::PropagatedTable;
use super::table::counted;
use super::words::error_text;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_io::project::change_project;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Rasteriser;
use quadratura_layers::fill::FillOptions;
use quadratura_sites::open::open_site;
use quadratura_stacks::fill::seen::propagation_in_words;
use quadratura_stacks::fill::{FillRequest, FilledPhoto, check_options, fill, stale_fillings, tell};
use quadratura_stacks::survey::{StackState, Survey};
use quadratura_stacks::update::build_needed;

/// Runs `fill`: builds the stacks of the chosen photos that need it, and fills their hidden parts. A photo that fails
/// becomes a problem.
pub fn run(args: &FillArgs, task: &Task) -> Result<Outcome> {
    let project = read_to_make(&args.project)?;
    let store = StackStore::new(&args.project);
    let is_whole = args.photos.names.is_empty() && args.part.part.is_none();
    let mut kept = if is_whole { store.clean()? } else { Vec::new() };
    let opened = open_site(&args.project, project, task)?;
    let chosen = args.part.of(&args.photos, &opened.site)?;
    let photos = opened.photos_named(&chosen.names)?;
    let mut problems = chosen.problems_of(&opened.problems, task);
    let options = args.applied_to(&opened.project.fill);
    check_options(&opened.project, &opened.site, &options)?;
    let memory = args.memory.or_default();
    if args.dry_run {
        let photos = with_stacks(&opened.project, &opened.site, &store, photos, task)?;
        let previewed = fill_those(tell, args, &opened.project, &opened.site, options, photos, task)?;
        return Ok(offered(&previewed, problems));
    }
    save(args, &opened.project.fill, &options, task)?;
    let built = build_needed(&opened.project, &opened.site, &store, &photos, memory, gpu_rasteriser, task)?;
    kept.extend(built.iter().flat_map(|built| built.kept.clone()));
    let failed = built.iter().filter_map(|built| Some((&built.photo, built.stack.as_ref().err()?)));
    let failed: BTreeMap<&String, &Error> = failed.collect();
    problems.extend(failed.iter().map(|(photo, error)| format!("{photo}: {}", error_text(error))));
    let left_out = chosen.left_out(&opened.site, &opened.problems) + failed.len();
    let to_fill = photos.iter().map(|photo| photo.name.clone()).filter(|photo| !failed.contains_key(photo));
    let filled = fill_those(fill, args, &opened.project, &opened.site, options, to_fill.collect(), task)?;
    kept.extend(filled.iter().flat_map(|filled| filled.kept.clone()));
    for file in kept {
        task.note(format!("a file that was changed by hand was moved to {}", file.display()));
    }
    let built: Vec<&str> = built.iter().filter(|it| it.stack.is_ok()).map(|it| it.photo.as_str()).collect();
    Ok(report(&built, &filled, problems, left_out))
}

/// Makes the rasteriser that builds stacks.
pub fn gpu_rasteriser() -> Result<Box<dyn Rasteriser>> {
    Ok(Box::new(GpuRasteriser::new(&Gpu::headless()?)?))
}

/// Returns the names of the photos that have an up-to-date stack, which a dry run is about; notes the others.
fn with_stacks(
    project: &Project,
    site: &Site,
    store: &StackStore,
    photos: Vec<&Photo>,
    task: &Task,
) -> Result<Vec<String>> {
    let survey = Survey::new(project, site, store);
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for photo in photos {
        let current = matches!(survey.state(photo)?, StackState::Current(_));
        if current { &mut with } else { &mut without }.push(photo.name.clone());
    }
    if with.is_empty() {
        return Err(Error::missing((
            "no photo has an up-to-date stack yet; ",
            Remedy::Build,
            " builds them",
        )));
    }
    if !without.is_empty() {
        let found =
            format!("these photos have no up-to-date stack and are left out: {}; ", without.join(", "));
        task.note((found, Remedy::Build, " builds them"));
    }
    Ok(with)
}

/// Fills these photos with `work`, or none where there are none.
fn fill_those(
    work: impl FnOnce(&Path, &Project, &Site, &FillRequest, &Task) -> Result<Vec<FilledPhoto>>,
    args: &FillArgs,
    project: &Project,
    site: &Site,
    options: FillOptions,
    photos: Vec<String>,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    // For the request, no name means all photos.
    if photos.is_empty() {
        return Ok(Vec::new());
    }
    let memory = args.memory.or_default();
    let request = FillRequest { options, photos, memory, force: args.force, keep_former: false };
    work(&args.project, project, site, &request, task)
}

/// Saves options that were given: all of them if requested, else the choice of whose paint is projected where the
/// project has none yet.
fn save(args: &FillArgs, before: &FillOptions, given: &FillOptions, task: &Task) -> Result<()> {
    let mut saved = if args.save_options { given.clone() } else { before.clone() };
    if before.propagate.is_undecided() && !given.propagate.is_undecided() {
        saved.propagate = given.propagate.clone();
        task.note(format!("saved in project.json: {}", propagation_in_words(&saved)));
    }
    if saved != *before {
        let _lock = lock_and_read(&args.project, task)?;
        change_project(&args.project, |project| Ok(Project { fill: saved.clone(), ..project? }))?;
    }
    if saved != *given {
        task.note(
            "these options apply only to this fill: the next fill without them fills again (--save-options \
             saves them in project.json)",
        );
    }
    Ok(())
}

/// Notes fillings that are out of date, for commands that show them as they are.
pub fn note_stale_fillings(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<()> {
    note_stale(folder, stale_fillings(folder, project, site)?.len(), task);
    Ok(())
}

/// Notes so many fillings that are out of date.
pub fn note_stale(folder: &Path, stale: usize, task: &Task) {
    if stale > 0 {
        let photos = counted(stale, "photo");
        task.note(format!(
            "the fillings of {photos} are out of date, and show paint and options as they were then; `quadratura \
             update {}` brings them up to date",
            folder.display()
        ));
    }
}

fn report(built: &[&str], filled: &[FilledPhoto], mut problems: Vec<String>, left_out: usize) -> Outcome {
    let mut table = FillTable::default();
    let mut propagated = PropagatedTable::default();
    for photo in filled {
        match &photo.stack {
            Ok(stack) => {
                table.add(stack, if photo.up_to_date { "up to date" } else { "filled" });
                propagated.add(&photo.photo, &photo.propagated);
            }
            Err(error) => {
                table.add_failed(&photo.photo);
                problems.push(format!("{}: {}", photo.photo, error_text(error)));
            }
        }
    }
    let fresh = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
    let left_out = left_out + filled.iter().filter(|photo| photo.stack.is_err()).count();
    let built_first = match built {
        [] => String::new(),
        built => format!("\n{} built first: {}\n", counted(built.len(), "stack"), built.join(", ")),
    };
    let text = format!(
        "{}{}{built_first}\n{} filled, {} up to date, {} left out or failed\n",
        table.text(),
        propagated.text("paint of other photos, projected to what a photo shows"),
        counted(fresh, "photo"),
        filled.iter().filter(|photo| photo.up_to_date).count(),
        left_out,
    );
    let json = json!({
        "photos": table.into_json(),
        "built": built,
        "propagated": propagated.into_json(),
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Reports the result of a dry run.
fn offered(filled: &[FilledPhoto], mut problems: Vec<String>) -> Outcome {
    let mut propagated = PropagatedTable::default();
    for photo in filled {
        propagated.add(&photo.photo, &photo.propagated);
        problems.extend(
            photo.stack.as_ref().err().map(|error| format!("{}: {}", photo.photo, error_text(error))),
        );
    }
    let preview = propagated.text("paint of other photos that would be projected to what a photo shows");
    let preview =
        if preview.is_empty() { "no paint would be projected to any photo\n".to_owned() } else { preview };
    let json = json!({ "dry_run": true, "propagated": propagated.into_json(), "problems": problems });
    Outcome { text: format!("{preview}nothing was written\n"), json, problems }
}
