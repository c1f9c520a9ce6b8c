//! The command `fill`.

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
use crate::io::project::{read_project, write_project};
use crate::io::stack_store::StackStore;
use crate::layers::fill::FillOptions;
use crate::recipe::fill::{FillRequest, FilledPhoto, fill, tell};
use crate::recipe::open::open_site;
use crate::task::Task;

/// Runs `fill`: fills the hidden parts of the chosen photos. A photo that fails becomes a problem.
pub fn run(args: &FillArgs, task: &Task) -> Result<Outcome> {
    let mut project = read_project(&args.project)?;
    let _lock = ProjectLock::take(&args.project)?;
    let options = options(args, &mut project, task)?;
    let mut kept = StackStore::new(&args.project).clean()?;
    let opened = open_site(&args.project, project, task)?;
    opened.photos_named(&args.photos.names)?;
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

/// Returns the project's options with those that were given, and saves them if requested.
fn options(args: &FillArgs, project: &mut Project, task: &Task) -> Result<FillOptions> {
    let options = args.applied_to(&project.fill);
    if options == project.fill || args.dry_run {
        return Ok(options);
    }
    if args.save_options {
        project.fill = options.clone();
        write_project(&args.project, project)?;
    } else {
        task.note(
            "these options apply only to this fill: the next fill without them fills again (--save-options \
             saves them in project.json)",
        );
    }
    Ok(options)
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
