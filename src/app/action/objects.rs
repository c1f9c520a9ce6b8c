//! Following of removed objects: the model in use and the state of photos are computed again.

use crate::action::reread::not_followed;
use crate::state::State;
use crate::state::pending::Invalidation;
use crate::state::running::JobKind;
use crate::state::session::survey;
use crate::work::Work;
use quadratura_document::Project;

/// Starts replacing the model by the one with the current objects, and finds which stacks are out of date.
pub fn follow_objects(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let project = Project::clone(session.history.present());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Open, "Updating objects", move |task| {
        let switched = || {
            let opened = opened.with_objects(&folder, project, task)?;
            let photos = survey(&folder, &opened.project, &opened.site, &[], task)?;
            Ok((opened, photos))
        };
        match switched() {
            Ok((opened, photos)) => Ok(Box::new(move |state| state.take_model(&folder, opened, photos))),
            Err(error) => Ok(not_followed(folder, Invalidation::Objects, error)),
        }
    });
}
