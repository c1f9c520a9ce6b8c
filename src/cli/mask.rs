//! The command `mask`.

use serde_json::json;

use super::Outcome;
use super::args::{Accepted, MaskArgs, PhotoArgs};
use super::lock::read_with_lock_if;
use super::masked::MaskReport;
use super::table::{Table, counted};
use super::words::{command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::{Masks, Project};
use quadratura_files::writable::check_folder;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::write_project;
use quadratura_io::recovery::read_unsaved;
use quadratura_sites::budget::default_memory;
use quadratura_sites::masks::beside::{FoundMask, MasksBeside, UnreadMask, mask_of_file, masks_beside};
use quadratura_sites::masks::{MaskEdit, attach, cleared, edited, tidy};
use quadratura_sites::open::{Opened, open_site, whole_model};
use quadratura_stacks::masks::object::{ObjectMasks, from_object};
use quadratura_stacks::masks::suggest::{
    MARGIN_PX, MaskSuggestion, Suggestions, UNSEEN, accepted, suggest, suggestion_folder, suggestions,
};

/// Runs `mask`: changes masks of transient objects as the arguments ask, and lists the masks.
pub fn run(args: &MaskArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = read_with_lock_if(changes(args), &args.project, task)?;
    if args.suggest {
        // What cannot be written is reported before the work, not after it.
        check_folder(&suggestion_folder(&args.project))?;
    }
    let before = project.masks.clone();
    if let Some(of) = &args.clear {
        project.masks = cleared(&project.masks, &args.photos.names, of)?;
    }
    // A mask that cannot be used leaves its photo out, but this command can replace it.
    let masks = std::mem::take(&mut project.masks);
    let mut opened = open_site(&args.project, project, task)?;
    let (edits, problems) = edits(args, &opened, task)?;
    opened.project.masks = edited(&args.project, &masks, &edits, &opened.site)?;
    if opened.project.masks != before {
        keep(args, &opened.project)?;
    }
    let changed = changed_photos(&before, &opened.project.masks);
    attach(&args.project, &opened.project.masks, &mut opened.site.photos);
    let mut outcome = outcome(args, &opened, changed, problems, task)?;
    if args.suggest {
        let photos = opened.photos_named(&args.photos.names)?;
        let names: Vec<String> = photos.into_iter().map(|photo| photo.name.clone()).collect();
        let margin = args.margin.unwrap_or(MARGIN_PX);
        let found =
            suggest(&args.project, &opened.project, &opened.site, &names, margin, default_memory(), task)?;
        outcome.text = suggestions_text(&found, args);
        outcome.json["suggestions"] = json!(found.list);
        outcome.json["folder"] = json!(suggestion_folder(&args.project));
    }
    Ok(outcome)
}

/// Returns whether the command changes the project. (Suggestions go to `cache/`, which needs no lock.)
fn changes(args: &MaskArgs) -> bool {
    args.clear.is_some()
        || args.find
        || args.add.is_some()
        || !args.object.is_empty()
        || args.accept.is_some()
}

/// Returns the edits that were requested, and problems with files that were found.
fn edits(args: &MaskArgs, opened: &Opened, task: &Task) -> Result<(Vec<MaskEdit>, Vec<String>)> {
    let Opened { site, project, .. } = opened;
    let folder = &args.project;
    let mut edits = Vec::new();
    let mut problems = Vec::new();
    if args.find {
        let asked = opened.photos_named(&args.photos.names)?;
        let MasksBeside { mut found, mut unread, problems: wrong } =
            masks_beside(folder, project, site, task)?;
        let is_asked = |name: &str| asked.iter().any(|photo| photo.name == name);
        found.retain(|found| is_asked(&found.photo));
        unread.retain(|unread| is_asked(&unread.photo));
        if found.is_empty() && unread.is_empty() && wrong.is_empty() {
            task.note(
                "no mask files were found for these photos; expected NAME.mask.png or NAME_mask.png beside the photo NAME.jpg, or masks/NAME.jpg.png"
                    .to_owned(),
            );
        }
        edits.extend(unread.iter().map(UnreadMask::edit));
        edits.extend(found.into_iter().map(FoundMask::edit));
        problems.extend(wrong.iter().chain(unread.iter().map(|unread| &unread.problem)).map(error_text));
    }
    if let Some(file) = &args.add {
        let [photo] = &args.photos.names[..] else {
            return Err(Error::Request("--add needs one photo; name it with --photo".into()));
        };
        edits.push(mask_of_file(folder, project, site, photo, file, task)?.edit());
    }
    if !args.object.is_empty() {
        edits.extend(object_edits(args, opened, task)?);
    }
    if let Some(Accepted(numbers)) = &args.accept {
        let every = || Ok(suggestions(folder)?.list.iter().map(|suggestion| suggestion.number).collect());
        let numbers = if args.all && numbers.is_empty() { every()? } else { numbers.clone() };
        edits.extend(accepted(folder, &numbers, args.margin.unwrap_or(0))?);
    }
    Ok((edits, problems))
}

fn object_edits(args: &MaskArgs, opened: &Opened, task: &Task) -> Result<Vec<MaskEdit>> {
    let model = whole_model(&args.project, &opened.project, task)?;
    let mut masks =
        ObjectMasks::new(&args.project, &opened.project, &opened.site, model, &args.object, task)?;
    let photos = opened.photos_named(&args.photos.names)?;
    let margin = args.margin.unwrap_or(0);
    let mut edits = Vec::new();
    for pattern in &args.object {
        for (photo, done) in photos.iter().zip(0..) {
            task.step("mask objects", done, photos.len() as u64)?;
            let masked = masks.pixels(photo, pattern, margin)?;
            let from = from_object(pattern, margin);
            edits.push(MaskEdit::Put { photo: photo.name.clone(), from, masked });
        }
    }
    Ok(edits)
}

fn keep(args: &MaskArgs, project: &Project) -> Result<()> {
    write_project(&args.project, project)?;
    // If the history of imports or the unsaved changes of a window cannot be read, the files they need are
    // unknown, so all stay.
    let unsaved = read_unsaved(&args.project, project);
    let (Ok(paint), Ok(unsaved)) = (PaintStore::new(&args.project).read(), unsaved) else { return Ok(()) };
    let unsaved = unsaved.map(|found| found.project.masks);
    tidy(&args.project, &[Some(&project.masks), unsaved.as_ref()], &paint)
}

fn changed_photos(before: &Masks, after: &Masks) -> Vec<String> {
    let mut photos: Vec<&str> = before.photos().chain(after.photos()).map(|(photo, _)| photo).collect();
    photos.sort_unstable();
    photos.dedup();
    photos.into_iter().filter(|photo| before.of(photo) != after.of(photo)).map(str::to_owned).collect()
}

fn suggestions_text(found: &Suggestions, args: &MaskArgs) -> String {
    let unseen = format!(
        "{UNSEEN}\nlook through the photos, and mask these with --add, in the window, or in a layer `mask`\n"
    );
    let listed: Vec<&MaskSuggestion> =
        found.list.iter().filter(|suggestion| args.all || suggestion.is_likely()).collect();
    let unlisted = found.list.len() - listed.len();
    let more = match unlisted {
        0 => String::new(),
        _ => format!(
            "{unlisted} more that are hardly objects, such as haze, glare and panes: --all lists them\n"
        ),
    };
    if listed.is_empty() {
        return format!("no transient objects were found\n{more}{unseen}");
    }
    let headings = ["number", "photo", "likelihood", "differs", "x", "y", "width", "height", "masks"];
    let mut table = Table::new(&headings);
    for found in &listed {
        let [x, y, w, h] = <[i64; 4]>::from(found.rect).map(|edge| edge.to_string());
        let likelihood = format!("{:.0} %", 100.0 * found.likelihood);
        let numbers =
            [likelihood, format!("{:.2}", found.score), x, y, w, h, format!("{:.2} %", 100.0 * found.share)];
        table.row([found.number.to_string(), found.photo.clone()].into_iter().chain(numbers));
    }
    let folder = suggestion_folder(&args.project);
    let project = args.project.display();
    format!(
        "{}\ndiffers: mean difference from the other photos (natural logarithm of light); x, y, width, height: pixels\n\
         {} outlined in the pictures in {}; run `quadratura mask {project} --accept 1,2` (or `all`) to mask them\n{more}{unseen}",
        table.render(),
        counted(listed.len(), "suggestion"),
        folder.display(),
    )
}

/// Returns what to do after masks of objects were made: the model may represent an object with another shape than it
/// has, and then the mask does not cover all of it.
fn look_at_objects(args: &MaskArgs) -> String {
    let Some(first) = args.object.first() else { return String::new() };
    let wider = 2 * args.margin.unwrap_or(0).max(12);
    format!(
        "then look whether pieces remain beside a mask, as they do of a round thing that the model shows flat:\n  \
         {}\nwhere they do, use a wider margin, such as {}, or mask them by hand (--add, or a layer `mask`)\n",
        command_for_project("render --cameras photos --out look"),
        command_for_project(&format!("mask --object '{first}' --margin {wider}")),
    )
}

/// Returns the problems with masks that could not be read, whose photos other commands leave out.
fn unread_masks(project: &Project) -> impl Iterator<Item = String> {
    let all = project.masks.photos();
    let unread = all.flat_map(|(photo, masks)| masks.iter().map(move |mask| (photo, mask)));
    unread.filter(|(_, mask)| mask.is_unread()).map(|(photo, mask)| {
        format!(
            "{photo} is left out, because its mask, {}, could not be read; correct it, then {} reads it",
            mask.from.words(),
            command_for_project("mask --find")
        )
    })
}

fn outcome(
    args: &MaskArgs,
    opened: &Opened,
    changed: Vec<String>,
    mut problems: Vec<String>,
    task: &Task,
) -> Result<Outcome> {
    let masked = MaskReport::new(&opened.project, &opened.site)?;
    let none = if masked.photos() == 0 { "nothing is masked\n" } else { "" };
    let mut text = format!("{none}{}", masked.text().trim_start());
    if !changed.is_empty() {
        let (photos, project) = (counted(changed.len(), "photo"), args.project.display());
        text.push_str(&format!(
            "\nmasks of {photos} changed; run `quadratura update {project}` to fill the masked areas\n"
        ));
        text.push_str(&look_at_objects(args));
    }
    if !args.find {
        problems.extend(unread_masks(&opened.project));
    }
    problems.extend(PhotoArgs { names: Vec::new() }.problems_of(&opened.problems, task));
    let json = json!({ "photos": masked.to_json(), "changed": changed, "problems": problems });
    Ok(Outcome { text, json, problems })
}
