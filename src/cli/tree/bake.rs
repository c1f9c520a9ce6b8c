//! The command `tree bake`.

use serde_json::json;

use crate::Outcome;
use crate::args::TreeBakeArgs;
use crate::bytes::readable_bytes;
use crate::table::Table;
use crate::words::worded;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::writable::check_folder;
use quadratura_io::project::read_project;
use quadratura_trees::baked::{BakeRequest, BakedSpecies, baked};

/// Runs `tree bake`: makes the images of species that have none, or of all.
pub fn run(args: &TreeBakeArgs, task: &Task) -> Result<Outcome> {
    let project = read_project(&args.project)?;
    // What cannot be kept is reported before the work, not after it.
    check_folder(&args.project.join("cache"))?;
    let request = BakeRequest { force: args.force, from_parts: args.from_parts };
    let (species, problems) = baked(&args.project, &project.trees, &args.species, request, task)?;
    let problems: Vec<String> = problems.iter().map(worded).collect();
    let text = match species.is_empty() && problems.is_empty() {
        true => "no species; `quadratura tree species` or `quadratura tree place` adds one\n".to_owned(),
        false => table(&species),
    };
    let json = json!({ "species": species, "problems": problems });
    Ok(Outcome { text, json, problems })
}

fn table(species: &[BakedSpecies]) -> String {
    let mut table = Table::new(&["species", "sub-objects with images", "samples", "on disk", ""]);
    for BakedSpecies { species, sub_objects, samples, bytes, is_new, from_parts } in species {
        let state = match (is_new, from_parts) {
            (true, false) => "made",
            (true, true) => "made from parts",
            (false, false) => "up to date",
            (false, true) => "up to date, from parts",
        };
        table.row([
            species.clone(),
            sub_objects.to_string(),
            samples.to_string(),
            readable_bytes(*bytes),
            state.to_owned(),
        ]);
    }
    table.render()
}
