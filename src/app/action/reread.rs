//! Reads the site again, as the project now describes it.

use std::path::PathBuf;

use crate::state::State;
use crate::state::notes::{Note, NoteRemedy, Weight};
use crate::state::pending::Invalidation;
use crate::state::request::{JobRequest, MaskRequest};
use crate::state::running::JobKind;
use crate::state::selection::Selection;
use crate::state::session::survey;
use crate::work::Work;
use crate::work::jobs::{Arrival, arrival};
use quadratura_base::error::Error;
use quadratura_document::Project;
use quadratura_sites::open::open_site;
use quadratura_sites::site_stamp::SiteStamp;

/// Reads the site again once other jobs have ended: what they bring belongs to the site as it is.
pub fn reload(state: &mut State, work: &mut Work) {
    let waits = state.running.all().next().map(|(_, job)| {
        let how = if job.kind == JobKind::Update { " or is paused" } else { "" };
        format!("Reload from disk waits until “{}” has ended{how}", job.name)
    });
    match (waits, &mut state.session) {
        (Some(text), Some(session)) => {
            session.pending.reload = true;
            state.notify(Note::new(Weight::Info, text));
        }
        _ => reopen(state, work, None),
    }
}

/// Starts the reading of the site that waits, where nothing else runs.
pub fn reload_if_due(state: &mut State, work: &mut Work) {
    let waits = state.session.as_ref().is_some_and(|session| session.pending.reload);
    if waits && state.running.is_idle() {
        reopen(state, work, None);
    }
}

/// Starts reading the site again, as the project now describes it. Then, if `then_build` is given, builds these photos
/// (all where the list is empty).
pub fn reopen(state: &mut State, work: &mut Work, then_build: Option<Vec<String>>) {
    let Some(session) = &mut state.session else { return };
    // Reading the site again includes all pending updates.
    session.pending.reread();
    let (folder, project) = (session.folder.clone(), session.history.present().clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Open, "Reloading the site", move |task| {
        let seen = SiteStamp::new(&folder, &project);
        let read = || {
            let opened = open_site(&folder, Project::clone(&project), task)?;
            let photos = survey(&folder, &opened.project, &opened.site, &[], task)?;
            Ok((opened, photos))
        };
        let (opened, photos) = match read() {
            Ok(read) => read,
            Err(error) => return Ok(not_followed(folder, Invalidation::Site, error)),
        };
        let count = photos.len();
        Ok(Box::new(move |state| {
            let Some(session) = state.session.as_mut().filter(|session| session.folder == folder) else {
                return Vec::new();
            };
            let is_same = session.opened.site.photos == opened.site.photos
                && session.opened.site.model == opened.site.model;
            let before = std::mem::take(&mut session.photos);
            session.set_site(opened, photos);
            session.seen = seen;
            if is_same {
                state.keep_selection(&before);
            } else {
                // Photos, objects and faces may have changed: earlier indices are invalid.
                state.select(Selection::Nothing);
                state.selection.photo = state.selection.photo.filter(|photo| photo.index() < count);
                state.space.forget_site();
                state.space.refresh();
            }
            state.flat.forget();
            let build = then_build.map(|photos| JobRequest::Build(photos).into());
            let requests = [JobRequest::SiteRead { is_same }.into(), MaskRequest::ReportProblems.into()];
            requests.into_iter().chain(build).collect()
        }))
    });
}

/// Returns the arrival of an update that failed: the update is pending again.
pub fn not_followed(folder: PathBuf, invalidation: Invalidation, error: Error) -> Arrival {
    arrival(move |state| {
        let Some(session) = state.session.as_mut().filter(|session| session.folder == folder) else {
            return;
        };
        session.pending.failed(invalidation);
        let (weight, why) = match error {
            Error::Cancelled => (Weight::Warning, "stopped".to_owned()),
            error => (Weight::Problem, error.to_string()),
        };
        let text = format!("The site was not reloaded ({why}): views and photos show its previous state.");
        state.notify(Note::new(weight, text).with("Reload from disk", NoteRemedy::ReadAgain));
    })
}
