//! The command `estimate`.

use serde_json::json;

use super::Outcome;
use super::args::EstimateArgs;
use super::lock::read_to_make;
use super::table::counted;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_sites::open::open_site;
use quadratura_stacks::fill::mattes::mattes;

/// Runs `estimate`: makes what all photos share, where it is not known.
pub fn run(args: &EstimateArgs, task: &Task) -> Result<Outcome> {
    let project = read_to_make(&args.project)?;
    let opened = open_site(&args.project, project, task)?;
    // Mattes come last, and are made from all the others.
    let found = mattes(&args.project, &opened.project, &opened.site, false, args.memory.or_default(), task)?;
    let photos = opened.site.photos.len();
    let problems = found.failed().iter().map(|id| {
        format!(
            "{}: what it shows through see-through surfaces could not be found",
            opened.site.photo(*id).name
        )
    });
    Ok(Outcome {
        text: format!("the estimates of {} are up to date\n", counted(photos, "photo")),
        json: json!({ "photos": photos }),
        problems: problems.collect(),
    })
}
