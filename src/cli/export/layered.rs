//! `export` to layered files, for image editors.

use std::collections::BTreeMap;

use serde_json::json;

use super::super::Outcome;
use super::super::args::ExportArgs;
use super::super::bytes::readable_bytes;
use super::super::fill::note_stale_fillings;
use super::super::table::{Table, counted};
use super::super::words::error_text;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::export_record::ExportFormat;
use quadratura_editing::export::{ExportOptions, Exported, TreesInSite, export, write_provenance};
use quadratura_io::stack_store::StackStore;
use quadratura_sites::open::Opened;
use quadratura_stacks::survey::{StackState, Survey};
use quadratura_views::colour::even_factors;

/// Writes the layered files of the chosen photos, and returns a table of them with a problem for each photo that failed.
pub fn run(args: &ExportArgs, format: ExportFormat, opened: &Opened, task: &Task) -> Result<Outcome> {
    let chosen = args.part.of(&args.photos, &opened.site)?;
    let photos = opened.photos_named(&chosen.names)?;
    let photos = with_stacks(
        &opened.project,
        &opened.site,
        &StackStore::new(&args.project),
        &photos,
        &chosen.names,
        task,
    )?;
    note_stale_fillings(&args.project, &opened.project, &opened.site, task)?;
    let evened = match args.even_colour {
        true => {
            task.note("files with matched exposures are for viewing only: they cannot be imported");
            even_factors(&args.project, &opened.project, &opened.site, task)?
        }
        false => BTreeMap::new(),
    };
    let options = ExportOptions {
        trees: TreesInSite::new(&opened.project.trees, &opened.project, &opened.site),
        evened,
        format,
        memory: args.memory.or_default(),
        decisions: Some(opened.project.decisions.clone()),
        ..ExportOptions::default()
    };
    let exported = export(&args.project, &photos, &args.out, &options, task)?;
    if args.provenance {
        write_provenance(&args.project, &photos, &opened.project.decisions, &args.out, task)?;
    }
    Ok(report(&exported, chosen.problems_of(&opened.problems, task)))
}

/// Returns the photos to export. Where none was named, those without a stack are left out, and noted together; so are
/// photos whose stack is out of date, which is exported as it is.
fn with_stacks<'a>(
    project: &Project,
    site: &Site,
    store: &StackStore,
    photos: &[&'a Photo],
    named: &[String],
    task: &Task,
) -> Result<Vec<&'a Photo>> {
    let survey = Survey::new(project, site, store);
    let (mut exported, mut missing, mut stale) = (Vec::new(), Vec::new(), Vec::new());
    for photo in photos {
        match survey.state(photo)? {
            StackState::Missing if named.is_empty() => missing.push(photo.name.as_str()),
            StackState::Stale(_) => {
                stale.push(photo.name.as_str());
                exported.push(*photo);
            }
            _ => exported.push(*photo),
        }
    }
    if exported.is_empty() {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    if !missing.is_empty() {
        let found = format!("these photos have no stack and are not exported: {}; ", missing.join(", "));
        task.note((found, Remedy::Build, " builds them"));
    }
    if !stale.is_empty() {
        let found = format!("the stacks of these photos are out of date: {}; ", stale.join(", "));
        task.note((found, Remedy::Build, " updates them"));
    }
    Ok(exported)
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
