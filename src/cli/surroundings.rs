//! The command `surroundings`.

use serde_json::json;

use super::Outcome;
use super::args::SurroundingsArgs;
use super::lock::read_with_lock_if;
use super::table::Table;
use super::words::{command_for_project, error_text};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_io::project::write_project;
use quadratura_sites::dome_picture::chosen_picture;
use quadratura_sites::open::open_site;
use quadratura_stacks::dome_report::{DomeExport, DomeReport, check_target, dome_report};

/// Runs `surroundings`: sets or removes the user's picture, exports the dome, and reports what is known.
pub fn run(args: &SurroundingsArgs, task: &Task) -> Result<Outcome> {
    let changes = args.set.is_some() || args.remove;
    let (_lock, project) = read_with_lock_if(changes, &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    if changes {
        let choose = |file| chosen_picture(&args.project, &opened.site, file, args.middle, task);
        let chosen = args.set.as_deref().map(choose).transpose()?;
        // What cannot be written is told before anything is saved.
        args.export.as_deref().map_or(Ok(()), check_target)?;
        if chosen != opened.project.surroundings {
            opened.project.surroundings = chosen;
            write_project(&args.project, &opened.project)?;
        }
    }
    let export = args.export.clone().map(|file| DomeExport { file, width: args.width, middle: args.middle });
    let report = dome_report(&args.project, &opened.project, &opened.site, export.as_ref(), task)?;
    let problems: Vec<String> = opened.problems.errors.iter().map(error_text).collect();
    let mut json = json!(report);
    json["problems"] = json!(problems);
    Ok(Outcome { text: text(&report), json, problems })
}

fn text(report: &DomeReport) -> String {
    let mut table = Table::new(&["", ""]);
    table.row(["photos with surroundings".to_owned(), report.photos.to_string()]);
    let picture = report.picture.as_ref().filter(|_| report.picture_used);
    let known = match (picture, report.known) {
        (Some(picture), _) => format!("from the picture {}", picture.picture),
        (None, Some(known)) => format!("{:.0} %", 100.0 * known),
        (None, None) => {
            let update = command_for_project("update");
            format!(
                "nothing: no photo has such a layer; {update} builds it where photos show more than the model"
            )
        }
    };
    if let Some(near) = report.known_near.filter(|_| picture.is_none()) {
        let near = format!("{:.0} % known from photos, the rest inpainted", 100.0 * near);
        table.row(["around the model, as views near the photos see it".to_owned(), near]);
    }
    table.row(["all directions".to_owned(), known]);
    if let Some(picture) = picture {
        let [x, y, z] = picture.middle;
        table.row(["its middle looks along".to_owned(), format!("{x},{y},{z}")]);
    }
    if let (Some(file), Some([x, y, z])) = (&report.exported, report.middle) {
        table.row(["written".to_owned(), file.display().to_string()]);
        let middle =
            format!("{x},{y},{z}, as it says itself; if another program drops that, give --middle to --set");
        table.row(["its middle looks along".to_owned(), middle]);
    }
    table.render().trim_start().to_owned()
}
