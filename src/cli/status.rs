//! The command `status`.

use serde_json::{Value, json};

use super::Outcome;
use super::args::StatusArgs;
use super::import::when;
use super::table::{Table, counted};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::lease::Holder;
use quadratura_io::failures::Failure;
use quadratura_sites::open::open;
use quadratura_stacks::status::{PhotoStatus, ProjectStatus, status};

/// Runs `status`: shows what is done, what is worked on and where, and what failed.
pub fn run(args: &StatusArgs, task: &Task) -> Result<Outcome> {
    let opened = open(&args.project, task)?;
    let status = status(&args.project, &opened.project, &opened.site, task)?;
    Ok(Outcome { text: text(&status), json: to_json(&status), problems: Vec::new() })
}

fn text(status: &ProjectStatus) -> String {
    let mut text = String::new();
    let mut running = Table::new(&["at work on", "program", "host", "process", "since (UTC)"]);
    for (what, holder) in workers(status) {
        let cells = [
            what,
            holder.program.clone(),
            holder.host.clone(),
            holder.process.to_string(),
            when(holder.since),
        ];
        running.row(cells);
    }
    if workers(status).next().is_some() {
        text += &format!("{}\n", running.render());
    }
    let failed: Vec<(&PhotoStatus, &Failure)> =
        status.photos.iter().filter_map(|photo| Some((photo, photo.failure.as_ref()?))).collect();
    for (photo, failure) in &failed {
        let Failure { program, host, process, time, error } = failure;
        let when = when(*time);
        text += &format!(
            "{} failed in {program} (process {process} on {host}, {when} UTC): {error}\n",
            photo.photo
        );
    }
    let count = |is: &dyn Fn(&PhotoStatus) -> bool| status.photos.iter().filter(|photo| is(photo)).count();
    text += &format!(
        "{}: {} with an up-to-date stack, {} filled, {} at work, {} failed; {}\n",
        counted(status.photos.len(), "photo"),
        count(&|photo| photo.stack == "current"),
        count(&PhotoStatus::is_done),
        count(&|photo| photo.worker.is_some()),
        failed.len(),
        match count(&|photo| !photo.is_done()) {
            0 => "everything is done".to_owned(),
            left => format!("{left} left to do"),
        }
    );
    text
}

/// Returns what is worked on, and by whom.
fn workers(status: &ProjectStatus) -> impl Iterator<Item = (String, &Holder)> {
    let author = status.author.iter().map(|holder| ("the project".to_owned(), holder));
    let estimates = status.estimates.iter().map(|holder| ("the estimates of all photos".to_owned(), holder));
    let photos = status.photos.iter().filter_map(|photo| Some((photo.photo.clone(), photo.worker.as_ref()?)));
    author.chain(estimates).chain(photos)
}

fn to_json(status: &ProjectStatus) -> Value {
    let photo = |photo: &PhotoStatus| {
        json!({
            "photo": photo.photo,
            "stack": photo.stack,
            "filling": photo.filling,
            "done": photo.is_done(),
            "worker": photo.worker.as_ref().map(worker),
            "failure": photo.failure,
        })
    };
    json!({
        "photos": status.photos.iter().map(photo).collect::<Vec<_>>(),
        "done": status.photos.iter().filter(|photo| photo.is_done()).count(),
        "estimates": status.estimates.as_ref().map(worker),
        "author": status.author.as_ref().map(worker),
    })
}

fn worker(holder: &Holder) -> Value {
    json!({
        "program": holder.program,
        "host": holder.host,
        "process": holder.process,
        "since": holder.since,
    })
}
