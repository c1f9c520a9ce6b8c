//! The commands that change the trees of a project: `tree species`, `place`, `move` and `remove`.

use std::path::Path;
use std::slice::from_ref;

use super::list::{changed_json, trees_table};
use crate::Outcome;
use crate::args::{Casts, TreeChangeArgs, TreeMoveArgs, TreePlaceArgs, TreeRemoveArgs, TreeSpeciesArgs};
use crate::lock::lock_and_read;
use crate::table::counted;
use crate::words::command_for_project;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::up;
use quadratura_base::task::Task;
use quadratura_document::trees::{Grown, PlantSource, TreeSpecies};
use quadratura_document::{Masks, Project};
use quadratura_foliage::files::list::read_tree_list;
use quadratura_io::project::{relative_to, write_project};
use quadratura_sites::masks::{ClearedMasks, cleared};
use quadratura_sites::open::{open_site, whole_model};
use quadratura_trees::edit::{TreeChange, moved, placed, placed_on, removed, species_removed, species_set};
use quadratura_trees::list::doubts;
use quadratura_trees::plant_of;
use quadratura_trees::street::{Ground, PlacedList, placed_list};

/// Runs `tree species`: adds, replaces or removes a species.
pub fn species(args: &TreeSpeciesArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let name = &args.name;
    let (trees, text) = match &args.from {
        None => (species_removed(&project.trees, name)?, format!("the species {name:?} is removed\n")),
        Some(from) => {
            let from = source(&args.project, from, args.seed)?;
            let species = TreeSpecies { from, up: args.up, unit: args.unit };
            // A plant that cannot be read is refused now, not when it is drawn.
            let plant = task.timed("read", || plant_of(&args.project, &species, task))?;
            let polygons = plant.whole().counts.polygons;
            let text = format!("the species {name:?} has {polygons} polygons\n");
            (species_set(&project.trees, name, species)?, text)
        }
    };
    project.trees = trees;
    write_project(&args.project, &project)?;
    Ok(outcome(&project, text, &[]))
}

fn source(folder: &Path, from: &Path, seed: Option<u64>) -> Result<PlantSource> {
    let grown = Grown { seed };
    match from.to_str().filter(|_| !from.exists()) {
        Some("maple") => return Ok(PlantSource::Maple(grown)),
        Some("oak") => return Ok(PlantSource::Oak(grown)),
        _ => {}
    }
    if seed.is_some() {
        let found = "--seed grows another maple or oak and has no effect on a file; write the seed into the species' file";
        return Err(Error::Request(found.into()));
    }
    relative_to(folder, from).map(PlantSource::File)
}

/// Runs `tree place`.
pub fn place(args: &TreePlaceArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let change = args.change.change();
    let PlacedList { trees, names } = match (&args.list, args.species.as_deref()) {
        (Some(list), species) => place_list(args, &project, list, species, task)?,
        (None, species) => place_some(args, &project, species.unwrap_or_default(), &change)?,
    };
    if names.is_empty() {
        return Ok(outcome(&project, "trees stand there already; nothing changed\n".into(), &[]));
    }
    project.trees = trees;
    write_project(&args.project, &project)?;
    note_doubts_about(&args.project, &project, &names, task)?;
    let mut text =
        format!("{} placed\n{}", counted(names.len(), "tree"), trees_table(&project, Some(&names)));
    if !args.on.is_empty() {
        let (mask, update) = (command_for_project("tree mask"), command_for_project("update"));
        text.push_str(&format!(
            "the photos still show what was replaced: {mask} masks the trees in them; then {update} updates the layers\n"
        ));
    }
    Ok(outcome(&project, text, &names))
}

/// Places one tree, or one in place of each of some objects.
fn place_some(
    args: &TreePlaceArgs,
    project: &Project,
    species: &str,
    change: &TreeChange,
) -> Result<PlacedList> {
    let (trees, names) = if args.on.is_empty() {
        let (trees, name) = placed(&project.trees, species, args.name.as_deref(), change)?;
        (trees, vec![name])
    } else {
        let opened = open_site(&args.project, project.clone(), &Task::silent())?;
        let whole = whole_model(&args.project, project, &Task::silent())?;
        let up = up(&opened.site.photos);
        placed_on(&project.trees, species, &args.on, &whole, up, change)?
    };
    Ok(PlacedList { trees, names })
}

/// Places the trees of a list.
fn place_list(
    args: &TreePlaceArgs,
    project: &Project,
    file: &Path,
    species: Option<&str>,
    task: &Task,
) -> Result<PlacedList> {
    let list = read_tree_list(file)?;
    if !list.ignored.is_empty() {
        let ignored = list.ignored.join(", ");
        task.note(format!("{}: these columns are not read: {ignored}", file.display()));
    }
    let opened = open_site(&args.project, project.clone(), &Task::silent())?;
    let ground = Ground::new(&opened.site.model, up(&opened.site.photos));
    let [first, second] = ground.level_names();
    if [first, second] != ["x", "y"] {
        task.note(format!("x and y of the list are {first} and {second} of the world, which are level"));
    }
    let placed = placed_list(&project.trees, file, list, species, &ground, &args.change.change());
    placed.inspect_err(|_| task.note("no tree of the list was placed"))
}

/// Runs `tree move`.
pub fn move_trees(args: &TreeMoveArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let change = TreeChange { by: args.by, species: args.species.clone(), ..args.change.change() };
    if change == TreeChange::default() {
        let found =
            "nothing to change; give --at, --by, --height, --width, --turn, --tint, --casts or --species";
        return Err(Error::Request(found.into()));
    }
    let (trees, names) = moved(&project.trees, &args.names, &change)?;
    project.trees = trees;
    write_project(&args.project, &project)?;
    note_doubts_about(&args.project, &project, &names, task)?;
    let text = format!("{} changed\n{}", counted(names.len(), "tree"), trees_table(&project, Some(&names)));
    let text = text + &about_masks(&project.masks, &names, "tree mask", "renews");
    Ok(outcome(&project, text, &names))
}

/// Runs `tree remove`.
pub fn remove(args: &TreeRemoveArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let (trees, names) = removed(&project.trees, &args.names)?;
    let before = project.objects_left_out();
    let left_out = Project { trees: trees.clone(), ..project.clone() };
    let update = match before == left_out.objects_left_out() {
        true => String::new(),
        false => {
            format!("what they replaced is back; {} updates the layers\n", command_for_project("update"))
        }
    };
    project.trees = trees;
    write_project(&args.project, &project)?;
    let text = format!("{} removed: {}\n{update}", counted(names.len(), "tree"), names.join(", "));
    // Trees that still stand keep their masks.
    let of_tree = |name: &String| {
        about_masks(&project.masks, from_ref(name), &format!("mask '--clear=tree:{name}'"), "removes")
    };
    let text = text + &names.iter().map(of_tree).collect::<String>();
    Ok(outcome(&project, text, &names))
}

impl TreeChangeArgs {
    fn change(&self) -> TreeChange {
        let Self { at, height, width, turn, tint, casts } = *self;
        let casts = casts.map(|casts| casts == Casts::On);
        TreeChange { at, height, width, turn, tint, casts, ..TreeChange::default() }
    }
}

fn outcome(project: &Project, text: String, changed: &[String]) -> Outcome {
    Outcome { text, json: changed_json(project, changed), problems: Vec::new() }
}

/// Notes what is doubtful about trees that were changed.
fn note_doubts_about(folder: &Path, project: &Project, names: &[String], task: &Task) -> Result<()> {
    let site = open_site(folder, project.clone(), &Task::silent())?.site;
    let about = |doubt: &String| names.iter().any(|name| doubt.contains(&format!("{name:?}")));
    for doubt in doubts(&project.trees, &site.model, up(&site.photos)).into_iter().filter(about) {
        task.note(doubt);
    }
    Ok(())
}

/// Returns what to do about masks of trees that were moved or removed: a command, and what it does with them.
fn about_masks(masks: &Masks, names: &[String], command: &str, does: &str) -> String {
    let has_masks = names.iter().any(|name| cleared(masks, &[], &ClearedMasks::Tree(name.clone())).is_ok());
    match has_masks {
        true => format!(
            "masks of {} remain in the photos; {} {does} them\n",
            names.join(", "),
            command_for_project(command)
        ),
        false => String::new(),
    }
}
