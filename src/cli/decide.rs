//! `quadratura decide`.

use serde_json::{Value, json};

use super::Outcome;
use super::args::{DecideArgs, OwnOption};
use super::table::Table;
use crate::document::decisions::PhotoOptions;
use crate::document::{PhotoDecisions, Project, Stack};
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::io::project::{read_project, write_project};
use crate::io::stack_store::StackStore;
use crate::layers::Faces;
use crate::recipe::decide::{LayerEdit, decided, edited, faces_named, strangers};
use crate::recipe::named::place_of_photo;
use crate::recipe::open::{Opened, open_site};
use crate::task::Task;

pub fn run(args: &DecideArgs, task: &Task) -> Result<Outcome> {
    let mut project = read_project(&args.project)?;
    let mut _lock = None;
    if args.decides() {
        _lock = Some(ProjectLock::take(&args.project)?);
        // Somebody may have decided something else before the lock was ours.
        project = read_project(&args.project)?;
    }
    let mut opened = open_site(&args.project, project, task)?;
    let stacks = stacks(&args.project, &opened);
    let mut decided = opened.project.clone();
    let present: Vec<_> = stacks.iter().map(Option::as_ref).collect();
    for edit in edits(args, &opened, &stacks)? {
        decided = edited(&decided, &edit, &opened.site, &present)?;
    }
    let changed = decided != opened.project;
    let next = match changed {
        false => "",
        true if builds_the_same(&opened.project, &decided) => {
            "it holds from the next view on; nothing is to be built\n"
        }
        true => "`quadratura build` makes what this changes\n",
    };
    if changed {
        write_project(&args.project, &decided)?;
        opened.project = decided;
    }
    Ok(outcome(args, &opened, &stacks, changed, next))
}

/// Exclusions and pins hold where views are drawn: stacks are the same without them.
fn builds_the_same(before: &Project, after: &Project) -> bool {
    let built = |project: &Project| {
        let mut photos = project.decisions.photos.clone();
        photos.values_mut().for_each(|of| (of.exclude, of.pin) = Default::default());
        photos.retain(|_, of| *of != PhotoDecisions::default());
        photos
    };
    built(before) == built(after)
}

/// A broken stack is as good as none here.
fn stacks(folder: &std::path::Path, opened: &Opened) -> Vec<Option<Stack>> {
    let store = StackStore::new(folder);
    opened.site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect()
}

impl DecideArgs {
    fn decides(&self) -> bool {
        let lists = [&self.merge, &self.split, &self.exclude, &self.pin, &self.free];
        let options = self.tolerance.is_some() || self.min_support.is_some() || self.margin.is_some();
        let named = self.name.is_some() || lists.iter().any(|list| !list.is_empty());
        named || options || self.reset || !self.forget.is_empty()
    }
}

/// What was typed: first what takes back, then what decides, photo by photo.
fn edits(args: &DecideArgs, opened: &Opened, stacks: &[Option<Stack>]) -> Result<Vec<LayerEdit>> {
    if args.photos.is_empty() {
        return Ok(args.reset.then_some(LayerEdit::Reset { photo: None }).into_iter().collect());
    }
    let mut edits = Vec::new();
    for photo in &args.photos {
        edits.extend(args.reset.then(|| LayerEdit::Reset { photo: Some(photo.clone()) }));
        let mut numbers = args.forget.clone();
        // From the last one on: those before it keep their numbers.
        numbers.sort_unstable_by(|a, b| b.cmp(a));
        numbers.dedup();
        edits.extend(numbers.into_iter().map(|number| LayerEdit::Forget { photo: photo.clone(), number }));
        edits.extend(of_photo(args, photo, opened, stacks)?);
    }
    Ok(edits)
}

fn of_photo(
    args: &DecideArgs,
    typed: &str,
    opened: &Opened,
    stacks: &[Option<Stack>],
) -> Result<Vec<LayerEdit>> {
    let mut edits = Vec::new();
    let photo = typed.to_owned();
    // A photo that is gone can be forgotten; whatever names faces needs it.
    let stack = place_of_photo(&opened.site, typed).ok().and_then(|place| stacks[place].as_ref());
    let named = |typed: &[String]| -> Result<Vec<Faces>> {
        let of = typed.iter().map(|what| faces_named(&opened.site.model, stack, what));
        Ok(of.collect::<Result<Vec<_>>>()?.concat())
    };
    // What takes back comes before what decides.
    if !args.free.is_empty() {
        edits.push(LayerEdit::Free { photo: photo.clone(), of: named(&args.free)? });
    }
    if !args.split.is_empty() {
        let mut groups = vec![named(&args.split)?];
        groups.extend((!args.from.is_empty()).then(|| named(&args.from)).transpose()?);
        edits.push(LayerEdit::Split { photo: photo.clone(), groups });
    }
    if !args.merge.is_empty() {
        edits.push(LayerEdit::Merge { photo: photo.clone(), of: named(&args.merge)? });
    }
    if let Some(name) = &args.name {
        let name = (!name.is_empty()).then(|| name.clone());
        edits.push(LayerEdit::Rename { photo: photo.clone(), of: named(&args.of)?, name });
    }
    if !args.exclude.is_empty() {
        edits.push(LayerEdit::Exclude { photo: photo.clone(), of: named(&args.exclude)? });
    }
    if !args.pin.is_empty() {
        edits.push(LayerEdit::Pin { photo: photo.clone(), of: named(&args.pin)? });
    }
    edits.extend(options(args, typed, opened)?);
    Ok(edits)
}

/// Options that were not given stay as they are.
fn options(args: &DecideArgs, typed: &str, opened: &Opened) -> Result<Option<LayerEdit>> {
    let DecideArgs { tolerance, min_support, margin, .. } = args;
    if tolerance.is_none() && min_support.is_none() && margin.is_none() {
        return Ok(None);
    }
    let name = &opened.site.photos[place_of_photo(&opened.site, typed)?].name;
    let kept = opened.project.decisions.of(name).options;
    let kept = if args.reset { PhotoOptions::default() } else { kept };
    let options = PhotoOptions {
        tolerance: tolerance.map_or(kept.tolerance, |OwnOption(own)| own),
        min_support: min_support.map_or(kept.min_support, |OwnOption(own)| own),
        margin: margin.map_or(kept.margin, |OwnOption(own)| own),
    };
    Ok(Some(LayerEdit::Options { photo: typed.to_owned(), options }))
}

fn outcome(
    args: &DecideArgs,
    opened: &Opened,
    stacks: &[Option<Stack>],
    changed: bool,
    next: &str,
) -> Outcome {
    let asked: Vec<&str> = args
        .photos
        .iter()
        .filter_map(|typed| place_of_photo(&opened.site, typed).ok())
        .map(|place| opened.site.photos[place].name.as_str())
        .collect();
    let mut table = Table::new(&["photo", "", "decision"]);
    let mut rows: Vec<Value> = Vec::new();
    for (photo, decisions) in &opened.project.decisions.photos {
        if !asked.is_empty() && !asked.contains(&photo.as_str()) {
            continue;
        }
        let place = opened.site.photos.iter().position(|known| known.name == *photo);
        let unmet = place.and_then(|place| stacks[place].as_ref()).map(|stack| stack.unmet.clone());
        let all = decided(decisions);
        for one in &all {
            table.row([photo.clone(), one.number.to_string(), one.text.clone()]);
        }
        rows.push(json!({ "photo": photo, "decisions": all, "unmet": unmet.unwrap_or_default() }));
    }
    let gone = strangers(&opened.project.decisions, &opened.site);
    let problems: Vec<String> = opened.problems.iter().map(ToString::to_string).collect();
    let text = match rows.is_empty() {
        true => "nothing was decided about layers\n".to_owned(),
        false => table.render(),
    };
    let unmet = rows.iter().flat_map(|row| row["unmet"].as_array().cloned().unwrap_or_default());
    let unmet: Vec<String> =
        unmet.filter_map(|note| Some(format!("not met: {}\n", note.as_str()?))).collect();
    let gone_text: Vec<String> = gone.iter().map(|gone| format!("kept: {gone}\n")).collect();
    let text = format!("{text}{}{}{next}", unmet.concat(), gone_text.concat());
    let json = json!({ "photos": rows, "changed": changed, "gone": gone, "problems": problems });
    Outcome { text, json, problems }
}
