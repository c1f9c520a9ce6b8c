//! The command `decide`.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::Outcome;
use super::args::{DecideArgs, OptionOverride};
use super::lock::read_with_lock_if;
use super::merge_table::MergeTable;
use super::table::Table;
use crate::words::{command_for_project, error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Model, Object, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::decisions::PhotoOptions;
use quadratura_document::stack::UntexturedReason;
use quadratura_document::{PhotoDecisions, Project, Stack};
use quadratura_io::project::write_project;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Faces;
use quadratura_layers::fill::options::matches_pattern;
use quadratura_sites::impostors::{self, ImpostorEdit};
use quadratura_sites::named::index_of_photo;
use quadratura_sites::open::{Opened, open_site};
use quadratura_sites::see_through::{self, SeeThroughEdit};
use quadratura_stacks::decide::{LayerEdit, decided, edited, faces_named, stale};

/// Runs `decide`: changes the decisions about layers as the arguments ask, and lists the decisions.
pub fn run(args: &DecideArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = read_with_lock_if(args.decides(), &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    if args.list {
        // Of other photos there is nothing to list; decisions about photos that are gone can still be changed.
        args.photos.iter().try_for_each(|typed| index_of_photo(&opened.site, typed).map(drop))?;
    }
    let stacks = stacks(&args.project, &opened.site);
    let mut decided = opened.project.clone();
    let present: Vec<_> = stacks.iter().map(Option::as_ref).collect();
    for edit in edits(args, &opened.project, &opened.site, &stacks)? {
        decided = edited(&decided, &edit, &opened.site, &present)
            .map_err(|error| explained(error, &edit, &opened.site))?;
    }
    args.refuse_contradictions(&opened.whole)?;
    decided.impostors = impostors::edited(&decided.impostors, &impostor_edits(args), &opened.whole)?;
    let (whole, photos) = (&opened.whole, &opened.site.photos);
    decided.see_through = see_through::edited(&decided, &see_through_edits(args), whole, photos)?;
    if let Some(work) = see_through::expected_work(&opened.project.see_through, &decided.see_through, whole) {
        task.note(work);
    }
    if decided.impostors != opened.project.impostors {
        // What cannot turn is told with the decision.
        let (photos, transform) = (&opened.site.photos, &decided.world_from_model);
        impostors::with_impostors(opened.whole.clone(), photos, transform, &decided.impostors, task);
    }
    let changed = decided != opened.project;
    let next = match changed {
        false => String::new(),
        true if builds_the_same(&opened.project, &decided) && !pins_leftovers(&decided, &stacks) => {
            "it applies to the next view; no stack has to be built\n".to_owned()
        }
        true => format!("{} applies this to the layers\n", command_for_project("update")),
    };
    if changed {
        write_project(&args.project, &decided)?;
        opened.project = decided;
    }
    let mut outcome = outcome(args, &opened, &stacks, changed, &next);
    if args.list {
        let merges = MergeTable::new(&opened.project, &opened.site, &stacks, &requested(args, &opened.site));
        outcome.text = merges.text() + &next;
        outcome.json["layers"] = merges.into_json();
    }
    Ok(outcome)
}

/// Adds to the refusal of a merge what lists the possible ones.
fn explained(error: Error, edit: &LayerEdit, site: &Site) -> Error {
    let (Error::Request(_), LayerEdit::Merge { photo, .. }) = (&error, edit) else { return error };
    if index_of_photo(site, photo).is_err() {
        return error;
    }
    let photo = if photo.contains(' ') { format!("'{photo}'") } else { photo.clone() };
    let list = command_for_project(&format!("decide --list --photo {photo}"));
    Error::Missing(error.message().and(format!("; {list} lists which layers can be merged")))
}

/// Returns the photos that the arguments name, as far as the site has them; all without a name.
fn requested(args: &DecideArgs, site: &Site) -> Vec<PhotoId> {
    if args.photos.is_empty() {
        return site.photo_ids().collect();
    }
    args.photos.iter().filter_map(|typed| index_of_photo(site, typed).ok()).collect()
}

/// Returns whether both need the same stacks. Exclusions and pins apply when views are drawn, so they need no
/// build.
fn builds_the_same(before: &Project, after: &Project) -> bool {
    let built = |project: &Project| {
        let mut photos = project.decisions.photos.clone();
        photos.values_mut().for_each(|of| (of.exclude, of.pin) = Default::default());
        photos.retain(|_, of| *of != PhotoDecisions::default());
        photos
    };
    let of_objects = |project: &Project| (project.impostors.clone(), project.see_through.clone());
    built(before) == built(after) && of_objects(before) == of_objects(after)
}

/// Returns the edits of impostors that were requested.
fn impostor_edits(args: &DecideArgs) -> Vec<ImpostorEdit> {
    let turns = args.impostor.iter().cloned().map(ImpostorEdit::Turns);
    let stays = args.no_impostor.iter().cloned().map(ImpostorEdit::Stays);
    turns.chain(stays).chain(args.free_impostor.iter().cloned().map(ImpostorEdit::Free)).collect()
}

/// Returns the edits of what one sees through that were requested.
fn see_through_edits(args: &DecideArgs) -> Vec<SeeThroughEdit> {
    let through = args.see_through.iter().cloned().map(SeeThroughEdit::SeeThrough);
    let solid = args.no_see_through.iter().cloned().map(SeeThroughEdit::Solid);
    through.chain(solid).chain(args.free_see_through.iter().cloned().map(SeeThroughEdit::Free)).collect()
}

/// Returns whether a photo is pinned to a face that is in none of its image layers, because it barely shows the face.
fn pins_leftovers(project: &Project, stacks: &[Option<Stack>]) -> bool {
    stacks.iter().flatten().any(|stack| {
        let pins = project.decisions.of(&stack.photo.name).pin;
        let left_out = stack.untextured.iter().filter(|u| u.reason == UntexturedReason::BarelyVisible);
        left_out.into_iter().any(|u| pins.iter().any(|pin| pin.holds(&u.object, u.face)))
    })
}

/// Reads the current stacks; a damaged one counts as missing here.
fn stacks(folder: &std::path::Path, site: &Site) -> Vec<Option<Stack>> {
    let store = StackStore::new(folder);
    site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect()
}

impl DecideArgs {
    /// Returns whether the arguments contain a decision.
    fn decides(&self) -> bool {
        let lists = [
            &self.merge,
            &self.split,
            &self.exclude,
            &self.pin,
            &self.free,
            &self.impostor,
            &self.no_impostor,
            &self.free_impostor,
            &self.see_through,
            &self.no_see_through,
            &self.free_see_through,
        ];
        let options = self.gives_options();
        let named = self.name.is_some() || lists.iter().any(|list| !list.is_empty());
        named || options || self.reset || !self.forget.is_empty()
    }

    /// Checks that no object is given to an option and to one that contradicts it. Names that the model does not have are told elsewhere.
    ///
    /// # Errors
    /// Returns [`Error::Request`] with all objects that are given to both.
    fn refuse_contradictions(&self, whole: &Model) -> Result<()> {
        let named = |patterns: &[String]| -> BTreeSet<String> {
            let meant = |object: &&Object| patterns.iter().any(|it| matches_pattern(&object.name, it));
            whole.objects.iter().filter(meant).map(|object| object.name.clone()).collect()
        };
        let options = [
            [
                ("--impostor", &self.impostor),
                ("--no-impostor", &self.no_impostor),
                ("--free-impostor", &self.free_impostor),
            ],
            [
                ("--see-through", &self.see_through),
                ("--no-see-through", &self.no_see_through),
                ("--free-see-through", &self.free_see_through),
            ],
        ];
        let pairs = options.into_iter().flat_map(|[on, off, free]| [(on, off), (on, free), (off, free)]);
        let refused = pairs.filter_map(|((option, these), (opposite, others))| {
            let both: Vec<String> = named(these).intersection(&named(others)).cloned().collect();
            let objects = names_of_some(&both)?;
            Some(Error::Request(format!(
                "{objects} cannot be given to {option} and to {opposite}; expected each object in one of them at most: \
                 leave it out of the other, or write narrower patterns"
            )))
        });
        Error::of_all(refused.collect()).map_or(Ok(()), Err)
    }

    /// Returns whether the arguments contain options of the photo's own.
    fn gives_options(&self) -> bool {
        let numbers = [self.min_support, self.margin, self.min_visible];
        let shares = [self.tolerance, self.min_share, self.tolerated];
        numbers.iter().any(Option::is_some) || shares.iter().any(Option::is_some)
    }
}

/// The number of objects that a refusal lists.
const LISTED: usize = 5;

/// Returns some names in one phrase; `None` without any.
fn names_of_some(names: &[String]) -> Option<String> {
    let shown = names[..names.len().min(LISTED)].join(", ");
    match names.len().saturating_sub(LISTED) {
        _ if names.is_empty() => None,
        0 => Some(shown),
        more => Some(format!("{shown} and {more} more")),
    }
}

/// Returns the edits that were requested, photo by photo: removals first, then decisions.
fn edits(
    args: &DecideArgs,
    project: &Project,
    site: &Site,
    stacks: &[Option<Stack>],
) -> Result<Vec<LayerEdit>> {
    if args.photos.is_empty() {
        return Ok(args.reset.then_some(LayerEdit::Reset { photo: None }).into_iter().collect());
    }
    let mut edits = Vec::new();
    for photo in &args.photos {
        edits.extend(args.reset.then(|| LayerEdit::Reset { photo: Some(photo.clone()) }));
        let mut numbers = args.forget.clone();
        // From the highest number down, so that the others stay valid.
        numbers.sort_unstable_by(|a, b| b.cmp(a));
        numbers.dedup();
        edits.extend(numbers.into_iter().map(|number| LayerEdit::Forget { photo: photo.clone(), number }));
        edits.extend(of_photo(args, photo, project, site, stacks)?);
    }
    Ok(edits)
}

fn of_photo(
    args: &DecideArgs,
    typed: &str,
    project: &Project,
    site: &Site,
    stacks: &[Option<Stack>],
) -> Result<Vec<LayerEdit>> {
    let mut edits = Vec::new();
    let photo = typed.to_owned();
    // Decisions about a photo that is gone can be removed; decisions about faces need it.
    let stack = index_of_photo(site, typed).ok().and_then(|id| stacks[id.index()].as_ref());
    let named = |typed: &[String]| -> Result<Vec<Faces>> {
        let of = typed.iter().map(|what| faces_named(&site.model, stack, what));
        Ok(of.collect::<Result<Vec<_>>>()?.concat())
    };
    // Removals come before decisions.
    if !args.free.is_empty() {
        edits.push(LayerEdit::Free { photo: photo.clone(), of: named(&args.free)? });
    }
    if !args.split.is_empty() {
        let mut groups = vec![named(&args.split)?];
        groups.extend((!args.from.is_empty()).then(|| named(&args.from)).transpose()?);
        edits.push(LayerEdit::Split { photo: photo.clone(), groups });
    }
    if args.tolerate {
        edits.push(LayerEdit::Tolerate { photo: photo.clone(), of: named(&args.merge)? });
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
    edits.extend(options(args, typed, project, site)?);
    Ok(edits)
}

/// Returns the edit of the photo's own options; those that were not given stay as they are.
fn options(args: &DecideArgs, typed: &str, project: &Project, site: &Site) -> Result<Option<LayerEdit>> {
    let DecideArgs { tolerance, min_support, margin, min_visible, min_share, tolerated, .. } = args;
    if !args.gives_options() {
        return Ok(None);
    }
    let name = &site.photo(index_of_photo(site, typed)?).name;
    let kept = project.decisions.of(name).options;
    let kept = if args.reset { PhotoOptions::default() } else { kept };
    let options = PhotoOptions {
        tolerance: tolerance.map_or(kept.tolerance, |OptionOverride(own)| own),
        min_support: min_support.map_or(kept.min_support, |OptionOverride(own)| own),
        margin: margin.map_or(kept.margin, |OptionOverride(own)| own),
        min_visible: min_visible.map_or(kept.min_visible, |OptionOverride(own)| own),
        min_share: min_share.map_or(kept.min_share, |OptionOverride(own)| own),
        tolerated: tolerated.map_or(kept.tolerated, |OptionOverride(own)| own),
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
    let requested_photos = if args.photos.is_empty() { Vec::new() } else { requested(args, &opened.site) };
    let requested_photos: Vec<&str> =
        requested_photos.into_iter().map(|id| opened.site.photo(id).name.as_str()).collect();
    let mut table = Table::new(&["photo", "", "decision"]);
    let mut rows: Vec<Value> = Vec::new();
    for (photo, decisions) in &opened.project.decisions.photos {
        if !requested_photos.is_empty() && !requested_photos.contains(&photo.as_str()) {
            continue;
        }
        let id = opened.site.photo_named(photo);
        let unsatisfied =
            id.and_then(|id| stacks[id.index()].as_ref()).map(|stack| stack.unsatisfied.clone());
        let all = decided(decisions);
        for one in &all {
            table.row([photo.clone(), one.number.to_string(), one.text.clone()]);
        }
        rows.push(json!({ "photo": photo, "decisions": all, "unmet": unsatisfied.unwrap_or_default() }));
    }
    let turns = |turns: &bool| if *turns { "turns towards the camera" } else { "stays as it is modelled" };
    let impostors = opened.project.impostors.iter();
    let refused = opened.refused_impostors();
    let impostors: String = impostors
        .map(|(object, it)| match refused.get(object) {
            Some(reason) => format!("{object} is to turn towards the camera and cannot: {reason}\n"),
            None => format!("{object} {}\n", turns(it)),
        })
        .collect();
    let through = |through: &bool| if *through { "is see-through" } else { "is solid" };
    let see_through = opened.project.see_through.iter();
    let see_through: String = see_through.map(|(object, it)| format!("{object} {}\n", through(it))).collect();
    let of_objects = impostors + &see_through;
    let missing = stale(&opened.project.decisions, &opened.site);
    let missing: Vec<String> = missing.iter().map(worded).collect();
    let problems: Vec<String> = opened.problems.errors.iter().map(error_text).collect();
    let text = match rows.is_empty() {
        true if requested_photos.is_empty() && !of_objects.is_empty() => String::new(),
        true if requested_photos.is_empty() => "there are no decisions about layers\n".to_owned(),
        true => format!("there are no decisions about {}\n", requested_photos.join(", ")),
        false => table.render(),
    };
    let unsatisfied = rows.iter().flat_map(|row| row["unmet"].as_array().cloned().unwrap_or_default());
    let unsatisfied: Vec<String> =
        unsatisfied.filter_map(|note| Some(format!("not applied: {}\n", note.as_str()?))).collect();
    let missing_text: Vec<String> = missing.iter().map(|note| format!("kept for later: {note}\n")).collect();
    let text = format!("{text}{of_objects}{}{}{next}", unsatisfied.concat(), missing_text.concat());
    let json = json!({ "photos": rows, "impostors": opened.project.impostors,
        "see_through": opened.project.see_through, "changed": changed, "gone": missing, "problems": problems });
    Outcome { text, json, problems }
}
