//! The command `object`.

use serde_json::json;

use super::Outcome;
use super::args::ObjectArgs;
use super::lock::read_with_lock_if;
use super::table::{Table, counted};
use super::words::command_for_project;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_io::project::write_project;
use quadratura_layers::fill::options::matches_pattern;
use quadratura_sites::objects::{ListedObject, ObjectEdit, edited, listed, masks_of};
use quadratura_sites::open::{refused_impostors, whole_model};

/// Runs `object`: switches objects of the model on or off as the arguments ask, and lists the objects.
pub fn run(args: &ObjectArgs, task: &Task) -> Result<Outcome> {
    let edits: Vec<ObjectEdit> = args
        .on
        .iter()
        .cloned()
        .map(ObjectEdit::On)
        .chain(args.off.iter().cloned().map(ObjectEdit::Off))
        .collect();
    let (_lock, mut project) = read_with_lock_if(!edits.is_empty(), &args.project, task)?;
    let whole = whole_model(&args.project, &project, task)?;
    let off = edited(&project.objects_off, &edits, &whole)?;
    let changed = off != project.objects_off;
    let off_before = project.objects_off.clone();
    if changed {
        project.objects_off = off;
        write_project(&args.project, &project)?;
    }
    let refused = refused_impostors(&args.project, &project, &whole, task);
    let objects = listed(&whole, &project, &refused);
    // After a change, only what it is about is shown.
    let is_shown =
        |object: &&ListedObject| edits.is_empty() || off_before.contains(&object.object) != object.off;
    let shown: Vec<ListedObject> = objects.iter().filter(is_shown).cloned().collect();
    let table = if shown.is_empty() { "nothing changed\n".to_owned() } else { table(&shown) };
    let mut text = format!("{table}{}", summary(&objects));
    if changed {
        text.push('\n');
        text.push_str(&about_masks(args, &project, &shown));
        text.push_str(&format!("run {} to update the layers\n", command_for_project("update")));
    }
    Ok(Outcome { text, json: json!({ "objects": objects, "changed": changed }), problems: Vec::new() })
}

/// Returns what to do about the masks of objects that were removed or restored.
fn about_masks(args: &ObjectArgs, project: &Project, shown: &[ListedObject]) -> String {
    let mut text = String::new();
    for pattern in &args.off {
        let mask = command_for_project(&format!("mask --object '{pattern}' --margin 24"));
        text.push_str(&format!(
            "the photos still show what was removed: {mask} masks it in them, with 24 pixels around it\n"
        ));
        let is_meant = |object: &&ListedObject| object.off && matches_pattern(&object.object, pattern);
        if shown.iter().filter(is_meant).any(|object| object.see_through) {
            let restore = command_for_project(&format!("object --on '{pattern}'"));
            text.push_str(&format!(
                "one sees through some of it, and what is removed has no mattes: to mask only what they hold, {restore}, \
                 mask it, and remove it again\n"
            ));
        }
    }
    let restored: Vec<&str> =
        shown.iter().filter(|object| !object.off).map(|object| object.object.as_str()).collect();
    for (pattern, photos) in masks_of(&project.masks, &restored) {
        let clear = command_for_project(&format!("mask --clear='object:{pattern}'"));
        text.push_str(&format!(
            "{} of {pattern:?} remain in the photos; {clear} removes them\n",
            counted(photos, "mask")
        ));
    }
    text
}

fn table(objects: &[ListedObject]) -> String {
    let mut table = Table::new(&["object", "faces", "", ""]);
    for object in objects {
        let off = if object.off { "removed" } else { "in the model" };
        table.row([object.object.clone(), object.faces.to_string(), off.into(), object.nature()]);
    }
    table.render()
}

fn summary(objects: &[ListedObject]) -> String {
    let off = objects.iter().filter(|object| object.off).count();
    format!("\n{}, {off} removed from the model\n", counted(objects.len(), "object"))
}
