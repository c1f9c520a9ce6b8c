//! The command `fill`.

use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::FillArgs;
use super::fill_table::FillTable;
use super::propagation_table::PropagatedTable;
use super::table::counted;
use super::words::error_text;
use crate::document::Project;
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::io::project::{change_project, read_project};
use crate::io::stack_store::StackStore;
use crate::layers::fill::FillOptions;
use crate::recipe::fill::seen::propagation_in_words;
use crate::recipe::fill::{FillRequest, FilledPhoto, check_options, fill, stale_fillings, tell};
use crate::recipe::open::{Opened, open_site};
use crate::task::Task;

/// Runs `fill`: fills the hidden parts of the chosen photos. A photo that fails becomes a problem.
pub fn run(args: &FillArgs, task: &Task) -> Result<Outcome> {
    let project = read_project(&args.project)?;
    let _lock = ProjectLock::take(&args.project)?;
    let mut kept = StackStore::new(&args.project).clean()?;
    let opened = open_site(&args.project, project, task)?;
    opened.photos_named(&args.photos.names)?;
    let options = args.applied_to(&opened.project.fill);
    check_options(&opened, &options)?;
    if !args.dry_run {
        save(args, &opened.project.fill, &options, task)?;
    }
    let request = FillRequest {
        options,
        photos: args.photos.names.clone(),
        memory: args.memory.or_default(),
        force: args.force,
        keep_former: false,
    };
    let fill = if args.dry_run { tell } else { fill };
    let filled = fill(&args.project, &opened, &request, task)?;
    kept.extend(filled.iter().flat_map(|filled| filled.kept.clone()));
    for file in kept {
        task.note(format!("a file that was changed by hand was moved to {}", file.display()));
    }
    let problems = args.photos.problems_of(&opened, task);
    Ok(if args.dry_run { offered(&filled, problems) } else { report(&filled, problems) })
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
pub fn note_stale_fillings(folder: &Path, opened: &Opened, task: &Task) -> Result<()> {
    let stale = stale_fillings(folder, opened)?;
    if !stale.is_empty() {
        let photos = counted(stale.len(), "photo");
        task.note(format!(
            "the fillings of {photos} are out of date, and show paint and options as they were then; `quadratura fill \
             {}` updates them",
            folder.display()
        ));
    }
    Ok(())
}

fn report(filled: &[FilledPhoto], mut problems: Vec<String>) -> Outcome {
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
    let text = format!(
        "{}{}\n{} filled, {} up to date, {} left out or failed\n",
        table.text(),
        propagated.text("paint of other photos, projected to what a photo shows"),
        counted(fresh, "photo"),
        filled.iter().filter(|photo| photo.up_to_date).count(),
        problems.len(),
    );
    let json =
        json!({ "photos": table.into_json(), "propagated": propagated.into_json(), "problems": problems });
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
