//! The command `tree mask`.

use serde_json::json;

use crate::Outcome;
use crate::args::TreeMaskArgs;
use crate::lock::lock_and_read;
use crate::masked::MaskReport;
use crate::words::{command_for_project, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::up;
use quadratura_base::task::Task;
use quadratura_io::project::write_project;
use quadratura_sites::masks::{attach, edited};
use quadratura_sites::open::open_site;
use quadratura_trees::edit::named;
use quadratura_trees::mask::tree_masks;
use quadratura_trees::{PlantParts, SiteTrees, site_trees};

/// Runs `tree mask`: masks the real trees in the photos, where trees of the project stand.
pub fn run(args: &TreeMaskArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let names = match args.trees.is_empty() {
        true => project.trees.placed.iter().map(|tree| tree.name.clone()).collect(),
        false => named(&project.trees, &args.trees)?,
    };
    if names.is_empty() {
        return Err(Error::Request("the project has no trees; place some first".into()));
    }
    let masks = std::mem::take(&mut project.masks);
    let mut opened = open_site(&args.project, project, task)?;
    let up = up(&opened.site.photos);
    let trees = site_trees(&args.project, &opened.project.trees, up, PlantParts::Geometry, task)?;
    let SiteTrees { placed, problems } = trees.expect("some trees are placed");
    let problems: Vec<String> = problems.iter().map(worded).collect();
    let photos = opened.photos_named(&args.photos.names)?;
    let edits = tree_masks(&opened.project, &opened.site, &photos, &placed, &names, args.margin, task)?;
    opened.project.masks = edited(&args.project, &masks, &edits, &opened.site)?;
    write_project(&args.project, &opened.project)?;
    attach(&args.project, &opened.project.masks, &mut opened.site.photos);
    let report = MaskReport::new(&opened.project, &opened.site)?;
    let update = command_for_project("update");
    let text = format!("{}\n{update} updates the layers\n", report.text().trim_start());
    let json = json!({ "photos": report.to_json(), "trees": names, "problems": problems });
    Ok(Outcome { text, json, problems })
}
