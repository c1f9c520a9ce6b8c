//! The command `frame`.

use serde_json::json;

use super::Outcome;
use super::args::FrameArgs;
use super::lock::read_with_lock_if;
use super::table::Table;
use super::words::{command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::frame::FramePart;
use quadratura_io::project::write_project;
use quadratura_sites::open::open_site;
use quadratura_views::frame::{FrameReport, changed, described, report};

/// Runs `frame`: changes the site's frame as the arguments ask, and shows it.
pub fn run(args: &FrameArgs, task: &Task) -> Result<Outcome> {
    let change = args.change().map_err(Error::Usage)?;
    let (_lock, project) = read_with_lock_if(!change.is_empty(), &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    let frame = changed(&opened, &change)?;
    let is_changed = frame != opened.project.frame;
    if is_changed {
        opened.project.frame = frame;
        write_project(&args.project, &opened.project)?;
    }
    let report = report(&opened, &opened.project.frame);
    let problems: Vec<String> = opened.problems.errors.iter().map(error_text).collect();
    let mut json = json!(report);
    json["changed"] = json!(is_changed);
    json["problems"] = json!(problems);
    Ok(Outcome { text: text(&report), json, problems })
}

fn text(report: &FrameReport) -> String {
    let frame = &report.frame;
    let mut table = Table::new(&["", ""]);
    for part in FramePart::ALL {
        let what = described(frame, part).unwrap_or_else(|| "not set".into());
        table.row([part.name().to_owned(), what]);
    }
    let [low, high] = report.extent;
    let size = [0, 1, 2].map(|axis| format!("{:.3}", high[axis] - low[axis])).join(" x ");
    table.row(["size of the model".to_owned(), format!("{size} {}", frame.unit())]);
    let mut text = table.render().trim_start().to_owned();
    if let Some(off) = report.off_cameras_deg {
        text.push_str(&format!("up is {off:.2} degrees from the mean up direction of the cameras\n"));
    }
    if frame.scale.is_none() {
        let unit = command_for_project("frame --unit m");
        let scale = command_for_project("frame --scale A B 12.34");
        text.push_str(&format!(
            "lengths are units of the cameras' world; {scale} sets the scale by a length that is known, and {unit} takes the model's\n"
        ));
    }
    text
}
