//! The command `update`.

use serde_json::{Value, json};

use super::Outcome;
use super::args::UpdateArgs;
use super::coarse::coarse_text;
use super::fill::gpu_rasteriser;
use super::live::follow;
use super::photo_state_table::{FILLING_HEADINGS, filling_cells};
use super::table::{Table, counted};
use super::transients::note_large;
use super::unexplained::unexplained_line;
use super::words::error_text;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::check::unexplained::{Unexplained, unexplained};
use quadratura_stacks::fill::FillShares;
use quadratura_stacks::fill::propagation::CoarsePaint;
use quadratura_stacks::turns::UpdateSource;
use quadratura_stacks::update::{ProjectOnDisk, UpdateEnd, UpdateRequest, UpdatedPhoto, update};

/// Runs `update`: builds and fills the chosen photos that need it. A photo that fails becomes a problem.
pub fn run(args: &UpdateArgs, task: &Task) -> Result<Outcome> {
    let source = ProjectOnDisk::new(&args.project);
    let opened = source.project(task)?;
    let request = UpdateRequest {
        photos: args.photos.names.clone(),
        only_existing: args.only_existing,
        memory: args.memory.or_default(),
        ..UpdateRequest::default()
    };
    let (problems, left_out) = (
        args.photos.problems_of(&opened.problems, task),
        args.photos.left_out(&opened.site, &opened.problems),
    );
    drop(opened);
    let updated = update(&StackStore::new(&args.project), &source, &request, &gpu_rasteriser, task)?;
    for file in updated.iter().flat_map(|photo| &photo.kept) {
        task.note(format!("a file that was changed by hand was moved to {}", file.display()));
    }
    let opened = source.project(task)?;
    follow(&args.project, &opened, &[], request.memory, task)?;
    note_large(&args.project, &opened.project, &opened.site, &up_to_date(&updated), request.memory, task)?;
    Ok(report(&updated, unexplained(&opened.site, &opened.points).as_ref(), problems, left_out))
}

fn report(
    updated: &[UpdatedPhoto],
    unexplained: Option<&Unexplained>,
    mut problems: Vec<String>,
    left_out: usize,
) -> Outcome {
    let failed: Vec<String> = updated.iter().filter_map(problem).collect();
    let left_out = left_out + failed.len();
    problems.extend(failed);
    let built = updated.iter().filter(|photo| photo.built).count();
    let filled = updated.iter().filter(|photo| photo.filled).count();
    let skipped = updated.iter().filter(|photo| matches!(photo.end, UpdateEnd::NeverBuilt)).count();
    let skipped = match skipped {
        0 => String::new(),
        count => format!(", {count} never built and skipped"),
    };
    let text = match built + filled + problems.len() {
        0 => format!("nothing to do: {} up to date{skipped}\n", counted(current(updated), "photo")),
        _ => format!(
            "{}\n{} built, {} filled, {} up to date{skipped}, {} left out or failed\n",
            table(updated).render(),
            counted(built, "stack"),
            counted(filled, "photo"),
            current(updated),
            left_out,
        ),
    };
    let coarse = coarse(updated);
    let text = text + &coarse_text(&coarse, "keep") + &unexplained_line(unexplained);
    let photos: Vec<Value> = updated.iter().map(to_json).collect();
    let json = json!({
        "photos": photos,
        "too_coarse": coarse,
        "unexplained": unexplained,
        "problems": problems,
    });
    Outcome { text, json, problems }
}

/// Returns the paint that is too coarse for these photos.
fn coarse(updated: &[UpdatedPhoto]) -> Vec<CoarsePaint> {
    let fills = updated.iter().filter_map(|photo| match &photo.end {
        UpdateEnd::Current(stack) => Some((photo.photo.as_str(), stack.fill.as_ref()?)),
        _ => None,
    });
    CoarsePaint::among(
        fills.flat_map(|(photo, fill)| fill.propagated.iter().map(move |paint| (photo, paint))),
    )
}

/// Returns the names of the photos that are up to date, whether they were built now or earlier: the same is told about both.
fn up_to_date(updated: &[UpdatedPhoto]) -> Vec<String> {
    let current = updated.iter().filter(|photo| matches!(photo.end, UpdateEnd::Current(_)));
    current.map(|photo| photo.photo.clone()).collect()
}

/// Returns the number of photos that are up to date and were so before.
fn current(updated: &[UpdatedPhoto]) -> usize {
    let untouched =
        |photo: &&UpdatedPhoto| matches!(photo.end, UpdateEnd::Current(_)) && !photo.built && !photo.filled;
    updated.iter().filter(untouched).count()
}

/// Returns what went wrong with a photo.
fn problem(photo: &UpdatedPhoto) -> Option<String> {
    let name = &photo.photo;
    match &photo.end {
        UpdateEnd::Current(_) | UpdateEnd::NeverBuilt => None,
        UpdateEnd::Failed(error) => Some(format!("{name}: {}", error_text(error))),
        UpdateEnd::Changed => Some(format!(
            "{name}: the project changed each time while this photo was updated; run `quadratura update` again"
        )),
        UpdateEnd::Stopped => Some(format!("{name}: stopped on request")),
    }
}

fn table(updated: &[UpdatedPhoto]) -> Table {
    let headings = [&["photo", "stack", "layers", "filling"], &FILLING_HEADINGS[..]].concat();
    let mut table = Table::new(&headings);
    for photo in updated {
        let Some((stack, [of_stack, of_filling])) = current_stack(photo) else {
            table.row([photo.photo.clone(), state(photo).into()]);
            continue;
        };
        let layers = stack.image_layers.len().to_string();
        let cells = [photo.photo.clone(), of_stack.into(), layers, of_filling.into()].into_iter();
        table.row(cells.chain(filling_cells(stack)));
    }
    table
}

/// Returns the stack of a photo that is up to date now, and the words for its stack and its filling.
fn current_stack(photo: &UpdatedPhoto) -> Option<(&Stack, [&'static str; 2])> {
    let UpdateEnd::Current(stack) = &photo.end else { return None };
    let word = |made, word| if made { word } else { "up to date" };
    Some((stack, [word(photo.built, "built"), word(photo.filled, "filled")]))
}

/// Returns the word for a photo that is not up to date.
fn state(photo: &UpdatedPhoto) -> &'static str {
    match &photo.end {
        UpdateEnd::Current(_) => "up to date",
        UpdateEnd::NeverBuilt => "not built",
        UpdateEnd::Changed => "changed",
        UpdateEnd::Stopped => "stopped",
        UpdateEnd::Failed(_) => "failed",
    }
}

fn to_json(photo: &UpdatedPhoto) -> Value {
    match current_stack(photo) {
        Some((stack, [of_stack, of_filling])) => json!({
            "photo": photo.photo,
            "state": state(photo),
            "stack": of_stack,
            "filling": of_filling,
            "counts": stack.counts,
            "shares": FillShares::from_stack(stack),
        }),
        None => json!({ "photo": photo.photo, "state": state(photo) }),
    }
}
