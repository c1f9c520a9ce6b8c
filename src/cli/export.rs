//! The command `export`.

use std::collections::BTreeMap;

use serde_json::json;

use super::Outcome;
use super::args::ExportArgs;
use super::bytes::readable_bytes;
use super::fill::note_stale_fillings;
use super::table::{Table, counted};
use super::words::error_text;
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::io::project::read_project;
use crate::io::stack_store::StackStore;
use crate::recipe::colour::even_factors;
use crate::recipe::export::{ExportOptions, Exported, export, write_provenance};
use crate::recipe::open::{Opened, open_site};
use crate::recipe::survey::{StackState, Survey};
use crate::scene::Photo;
use crate::task::Task;

/// Runs `export`: writes the layered files of the chosen photos, and returns a table of them with a problem for
/// each photo that failed. Stacks that are out of date are noted and exported as they are.
pub fn run(args: &ExportArgs, task: &Task) -> Result<Outcome> {
    let project = read_project(&args.project)?;
    let _lock = ProjectLock::take(&args.project)?;
    let opened = open_site(&args.project, project, task)?;
    let photos = opened.photos_named(&args.photos.names)?;
    note_stale(&opened, &StackStore::new(&args.project), &photos, task)?;
    note_stale_fillings(&args.project, &opened, task)?;
    let evened = match args.even_colour {
        true => {
            task.note("files with matched exposures are for viewing only: they cannot be imported");
            even_factors(&args.project, &opened, task)?
        }
        false => BTreeMap::new(),
    };
    let options = ExportOptions {
        evened,
        format: args.format,
        memory: args.memory.or_default(),
        decisions: Some(opened.project.decisions.clone()),
        ..ExportOptions::default()
    };
    let exported = export(&args.project, &photos, &args.out, &options, task)?;
    if args.provenance {
        write_provenance(&args.project, &photos, &opened.project.decisions, &args.out, task)?;
    }
    Ok(report(&exported, args.photos.problems_of(&opened, task)))
}

/// Notes photos whose stack is out of date; an export writes the stack on disk as it is.
fn note_stale(opened: &Opened, store: &StackStore, photos: &[&Photo], task: &Task) -> Result<()> {
    let survey = Survey::new(opened, store);
    for photo in photos {
        if let StackState::Stale(_) = survey.state(photo)? {
            task.with_subject(&photo.name).note("its stack is out of date; `quadratura build` updates it");
        }
    }
    Ok(())
}

fn report(exported: &Exported, mut problems: Vec<String>) -> Outcome {
    problems.extend(exported.failed.iter().map(|(photo, error)| format!("{photo}: {}", error_text(error))));
    problems.extend(exported.done.iter().flat_map(|done| done.problems.iter().cloned()));
    let mut table = Table::new(&["photo", "groups", "layers", "size", "file"]);
    for done in &exported.done {
        let groups = done.groups.to_string();
        let layers = done.layers.to_string();
        let file = done.path.display().to_string();
        table.row([done.photo.clone(), groups, layers, readable_bytes(done.bytes), file]);
    }
    let bytes = exported.done.iter().map(|done| done.bytes).sum();
    let text = format!(
        "{}\n{} exported, {}\n",
        table.render(),
        counted(exported.done.len(), "photo"),
        readable_bytes(bytes),
    );
    let json = json!({ "photos": exported.done, "problems": problems });
    Outcome { text, json, problems }
}
