//! The only place that changes the state: applies requests, one file for each subject.

pub mod brush;
pub mod build;
pub mod check;
pub mod decide;
pub mod end;
pub mod flat;
pub mod flight;
pub mod known;
pub mod layers;
pub mod life;
pub mod masks;
pub mod model_suggestions;
pub mod objects;
pub mod opening;
pub mod orthophoto;
pub mod publish;
pub mod quality;
pub mod reread;
pub mod round_trip;
pub mod save_image;
pub mod saving;
pub mod select;
pub mod site_frame;
pub mod space;
pub mod trees;
pub mod updating;
pub mod window;

use self::brush::paint_strokes;
use self::build::{
    build_layers, fill_hidden, painter_failed, painter_made, prepare_painter, redecide, restart_painter,
    site_read,
};
use self::check::check_again;
use self::decide::{follow, follow_history, redo, undo};
use self::known::{follow_known, forget_project};
use self::life::{answer_recovery, happens, open_project};
use self::masks::keeping::keep_masks;
use self::opening::assistant::created;
use self::opening::open::open_now;
use self::opening::{arrived, grant_opening};
use self::reread::{reload, reload_if_due, reopen};
use self::saving::{autosave_if_due, save_project};
use self::updating::{keep_up_to_date, stop_job};
use super::state::State;
use super::state::request::{DecideRequest, JobRequest, ProjectRequest, Request};
use super::work::Work;

/// Applies a request, and tells the autosave of unsaved changes.
pub fn apply(state: &mut State, work: &mut Work, request: Request) {
    match request {
        Request::Select(request) => select::apply(state, request),
        Request::Decide(request) => decide(state, work, request),
        Request::Build(request) => build(state, work, request),
        Request::Space(request) => space::apply(state, work, request),
        Request::Flight(request) => flight::apply(state, work, request),
        Request::Flat(request) => flat::apply(state, work, request),
        Request::Mask(request) => masks::apply(state, work, request),
        Request::Quality(request) => quality::apply(state, work, request),
        Request::Check(request) => check::apply(state, work, request),
        Request::Model(request) => model_suggestions::apply(state, work, request),
        Request::RoundTrip(request) => round_trip::apply(state, work, request),
        Request::Project(request) => project(state, work, request),
        Request::Trees(request) => trees::apply(state, work, request),
        Request::Images(request) => save_image::apply(state, work, request),
        Request::Ortho(request) => orthophoto::apply(state, work, request),
        Request::Publish(request) => publish::apply(state, work, request),
        Request::Window(request) => window::apply(state, work, request),
    }
    autosave_if_due(state, work);
}

/// Applies the results that jobs have delivered since the last call.
pub fn take_in(state: &mut State, work: &mut Work) {
    let (notes, arrivals) = work.jobs.receive(&mut state.running);
    notes.into_iter().for_each(|note| state.notify(note));
    for arrival in arrivals {
        arrival(state).into_iter().for_each(|request| apply(state, work, request));
    }
}

/// Continues everything that runs by itself; called once a frame.
pub fn check_cancelled(state: &mut State, work: &mut Work) {
    follow(state, work);
    follow_history(state, work);
    trees::follow_light(state, work);
    trees::follow_images(state, work);
    trees::follow_trees(state, work);
    state.fly_on();
    space::check_cancelled(state, work);
    round_trip::take_home(state, work).into_iter().for_each(|request| apply(state, work, request));
    paint_strokes(state, work);
    check_again(state, work);
    reload_if_due(state, work);
    keep_masks(state, work);
    follow_known(state, work);
    keep_up_to_date(state, work);
}

fn decide(state: &mut State, work: &mut Work, request: DecideRequest) {
    match request {
        DecideRequest::Edit(name, project, gesture) => state.edit(name, *project, gesture),
        DecideRequest::EndGesture => state.end_gesture(),
        DecideRequest::Undo => undo(state, work),
        DecideRequest::Redo => redo(state, work),
        DecideRequest::Layers(edit) => state.decide(&edit),
        DecideRequest::Merge => state.merge_layers(),
        DecideRequest::ConfirmMerge(confirmed) => state.confirm_merge(confirmed),
        DecideRequest::Split => state.split_layer(),
        DecideRequest::Pin => state.pin(),
        DecideRequest::Exclude => state.exclude(),
        DecideRequest::Reset => state.reset_decisions(),
        DecideRequest::Rename(photo, layer, name) => state.rename_layer(photo, layer, &name),
        DecideRequest::Forget(photo, number) => state.forget_decision(photo, number),
        DecideRequest::GoToStep(done) => state.dialogs.history_target = Some(done),
        DecideRequest::AskToRemove(object) => state.request_to_remove(&object),
        DecideRequest::ConfirmRemoval(confirmed) => state.confirm_removal(confirmed),
        DecideRequest::SwitchObject(object, on) => state.switch_object(&object, on),
        DecideRequest::TurnObject(object, turns) => state.turn_object(&object, turns),
        DecideRequest::SeeThroughObject(object, through) => state.see_through_object(&object, through),
        DecideRequest::FreeObject(object) => state.free_object(&object),
        DecideRequest::AllObjectsOn => state.switch_all_on(),
        DecideRequest::Options { edit, goes_on } => state.edit_options(&edit, goes_on),
    }
}

fn build(state: &mut State, work: &mut Work, request: JobRequest) {
    match request {
        JobRequest::Build(photos) => build_layers(state, work, photos),
        JobRequest::Fill => fill_hidden(state, work),
        JobRequest::Reread(None) => reload(state, work),
        JobRequest::Reread(then_build) => reopen(state, work, then_build),
        JobRequest::PreparePainter => prepare_painter(state, work),
        JobRequest::RestartPainter => restart_painter(state, work),
        JobRequest::SiteRead { is_same } => site_read(state, work, is_same),
        JobRequest::PainterMade => painter_made(state, work),
        JobRequest::PainterFailed(folder, error) => painter_failed(state, work, &folder, &error),
        JobRequest::Redecide => redecide(state, work),
        JobRequest::Stop(job) => stop_job(state, work, job),
        JobRequest::StopAll => work.jobs.stop_all(&mut state.running),
    }
}

fn project(state: &mut State, work: &mut Work, request: ProjectRequest) {
    match request {
        ProjectRequest::Open(project) => open_project(state, work, project),
        ProjectRequest::OpenNow(project) => open_now(state, work, project),
        ProjectRequest::Opened(opened) => {
            let (session, recovered) = *opened;
            arrived(state, work, session, recovered);
        }
        ProjectRequest::Created(parts, made) => created(state, work, &parts, *made),
        ProjectRequest::Save => drop(save_project(state, work)),
        ProjectRequest::Life(event) => happens(state, work, event),
        ProjectRequest::Recover(restores) => answer_recovery(state, work, restores),
        ProjectRequest::Forget(project) => forget_project(state, work, &project),
        ProjectRequest::ShowMissing => state.show_missing(),
        ProjectRequest::Dialog(request) => grant_opening(state, work, request),
    }
}

#[cfg(test)]
pub mod tests;
