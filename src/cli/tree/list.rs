//! The command `tree list`.

use std::path::Path;

use serde_json::{Value, json};

use crate::Outcome;
use crate::args::TreeListArgs;
use crate::table::{Table, counted};
use crate::words::command_for_project;
use quadratura_base::error::Result;
use quadratura_base::scene::{Site, up};
use quadratura_base::task::Task;
use quadratura_document::trees::{LightStrength, Strength};
use quadratura_document::{Project, Trees};
use quadratura_sites::open::open;
use quadratura_trees::list::{
    ListedSpecies, doubts, listed_species, listed_trees, outdated_masks, species_problems,
};
use quadratura_trees::paint::listed_paint;

/// Runs `tree list`.
pub fn run(args: &TreeListArgs, task: &Task) -> Result<Outcome> {
    let opened = open(&args.project, task)?;
    listed(&args.project, &opened.project, &opened.site, task)
}

/// Lists species and trees, and what is doubtful about them.
fn listed(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<Outcome> {
    let species = listed_species(folder, &project.trees, task)?;
    note_doubts(project, site, task);
    // Where the book cannot be read, reading the plants notes it.
    let painted = listed_paint(folder).unwrap_or_default();
    for (name, paint) in painted.iter().filter(|(name, _)| !project.trees.species.contains_key(*name)) {
        task.note(format!(
            "{} texels of paint are kept of the species {name:?}, which the project does not have any more; a species of that name \
             shows them again",
            paint.texels
        ));
    }
    let problems = species_problems(&species);
    let json = json!({
        "species": species,
        "trees": listed_trees(project),
        "light": project.trees.light,
        "problems": problems,
    });
    let text = match project.trees.is_empty() {
        true => "no trees; `quadratura tree place` places one\n".to_owned(),
        false => {
            format!("{}{}{}", species_table(&species), trees_table(project, None), light(&project.trees))
        }
    };
    Ok(Outcome { text, json, problems })
}

/// Notes what is doubtful about the trees of a project.
pub fn note_doubts(project: &Project, site: &Site, task: &Task) {
    for doubt in doubts(&project.trees, &site.model, up(&site.photos)) {
        task.note(doubt);
    }
    let outdated = outdated_masks(project);
    if !outdated.is_empty() {
        let (mask, names) = (command_for_project("tree mask"), outdated.join(", "));
        task.note(format!(
            "masks of trees that have changed since are out of date: {names}; {mask} with these names renews them"
        ));
    }
}

fn species_table(species: &[ListedSpecies]) -> String {
    let mut table = Table::new(&["species", "from", "trees", "polygons", "images", "paint", "own height"]);
    for ListedSpecies { species, from, trees, counts, has_images, paint, height, .. } in species {
        let polygons = counts.map_or("unreadable".to_owned(), |counts| counts.polygons.to_string());
        let height = height.map_or(String::new(), |height| format!("{height:.2}"));
        let images = if *has_images { "made" } else { "none" }.to_owned();
        let paint = paint.map_or_else(|| "none".to_owned(), |paint| format!("{} texels", paint.texels));
        table.row([species.clone(), from.clone(), trees.to_string(), polygons, images, paint, height]);
    }
    table.render() + "\n"
}

/// Returns the table of the trees that are placed: of all, or of those of some names.
pub fn trees_table(project: &Project, names: Option<&[String]>) -> String {
    let mut trees = listed_trees(project);
    let count = trees.len();
    trees.retain(|listed| names.is_none_or(|names| names.contains(&listed.tree.name)));
    if trees.is_empty() {
        return String::new();
    }
    let others = match count - trees.len() {
        0 => String::new(),
        others => format!(
            "{} not listed; {} lists all\n",
            counted(others, "other tree"),
            command_for_project("tree list")
        ),
    };
    let mut table = Table::new(&[
        "tree",
        "species",
        "x",
        "y",
        "z",
        "height",
        "width",
        "turn",
        "casts",
        "replaces",
        "masked in",
    ]);
    for listed in trees {
        let tree = listed.tree;
        let [x, y, z] = tree.at.map(|value| format!("{value:.3}"));
        let length = |length: Option<f64>| length.map_or("own".to_owned(), |length| format!("{length:.2}"));
        let (height, width) = (length(tree.height), length(tree.width));
        let replaces = tree.replaces.into_iter().collect::<Vec<_>>().join(", ");
        let masks = format!("{}{}", listed.masks, if listed.masks_outdated { ", out of date" } else { "" });
        let turn = format!("{:.0}", tree.turn);
        let casts = if tree.casts { "a shadow" } else { "" }.to_owned();
        table.row([tree.name, tree.species, x, y, z, height, width, turn, casts, replaces, masks]);
    }
    table.render()
        + "x, y, z: the foot, in the world; lengths in world units; turn in degrees; masked in: photos\n"
        + &others
}

/// Returns what is decided about the light, in words.
pub fn light(trees: &Trees) -> String {
    let numbers = |values: [f64; 3]| values.map(|value| format!("{value:.3}")).join(" ");
    let sun = match trees.light.sun {
        Some(sun) => format!("direction to the sun: {}\n", numbers(sun)),
        None => "direction to the sun: that of a clear day\n".to_owned(),
    };
    let strength = match trees.light.strength {
        Strength::Given(LightStrength { sun, sky, ground }) => {
            format!("light of sun, sky, ground: {}; {}; {}\n", numbers(sun), numbers(sky), numbers(ground))
        }
        Strength::Estimated => "light of sun, sky, ground: estimated from the photos\n".to_owned(),
    };
    let photos = if trees.light.without_photos { "photos: not matched (--photos on)\n" } else { "" };
    format!("\n{sun}{strength}{photos}")
}

/// Returns what programs are told after a change of trees.
pub fn changed_json(project: &Project, changed: &[String]) -> Value {
    json!({ "trees": listed_trees(project), "changed": changed, "light": project.trees.light })
}
