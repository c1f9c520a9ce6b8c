//! `quadratura fill`.

use serde_json::json;

use super::Outcome;
use super::args::FillArgs;
use super::fill_table::FillTable;
use super::table::counted;
use crate::document::Project;
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::io::project::{read_project, write_project};
use crate::io::stack_store::StackStore;
use crate::layers::fill::FillOptions;
use crate::recipe::fill::{FillRequest, FilledPhoto, fill};
use crate::recipe::open::open_site;
use crate::task::Task;

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
    };
    let filled = fill(&args.project, &opened, &request, task)?;
    kept.extend(filled.iter().flat_map(|filled| filled.kept.clone()));
    for file in kept {
        task.note(format!("a file that was changed by hand is now {}", file.display()));
    }
    Ok(report(&filled, args.photos.problems_of(&opened, task)))
}

/// The project's options with those that were given; kept in the project if that is wanted.
fn options(args: &FillArgs, project: &mut Project, task: &Task) -> Result<FillOptions> {
    let options = args.applied_to(&project.fill);
    if options == project.fill {
        return Ok(options);
    }
    if args.save_options {
        project.fill = options.clone();
        write_project(&args.project, project)?;
    } else {
        task.note(
            "these options hold for this time only: the next fill without them fills again (--save-options \
             keeps them in project.json)",
        );
    }
    Ok(options)
}

fn report(filled: &[FilledPhoto], mut problems: Vec<String>) -> Outcome {
    let mut table = FillTable::default();
    for photo in filled {
        match &photo.stack {
            Ok(stack) => table.add(stack, if photo.up_to_date { "up to date" } else { "filled" }),
            Err(error) => {
                table.add_failed(&photo.photo);
                problems.push(format!("{}: {error}", photo.photo));
            }
        }
    }
    let fresh = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
    let text = format!(
        "{}\n{} filled, {} up to date, {} left out or failed\n",
        table.text(),
        counted(fresh, "photo"),
        filled.iter().filter(|photo| photo.up_to_date).count(),
        problems.len(),
    );
    let json = json!({ "photos": table.into_json(), "problems": problems });
    Outcome { text, json, problems }
}
