//! The only place that changes the state: applies asks, one file for each subject.

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
pub mod objects;
pub mod opening;
pub mod quality;
pub mod reread;
pub mod round_trip;
pub mod save_image;
pub mod saving;
pub mod select;
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
use super::state::ask::{Ask, BuildAsk, DecideAsk, ProjectAsk};
use super::work::Work;

/// Applies an ask, and tells the autosave of unsaved changes.
pub fn apply(state: &mut State, work: &mut Work, ask: Ask) {
    match ask {
        Ask::Select(ask) => select::apply(state, ask),
        Ask::Decide(ask) => decide(state, work, ask),
        Ask::Build(ask) => build(state, work, ask),
        Ask::Space(ask) => space::apply(state, work, ask),
        Ask::Flight(ask) => flight::apply(state, work, ask),
        Ask::Flat(ask) => flat::apply(state, work, ask),
        Ask::Mask(ask) => masks::apply(state, work, ask),
        Ask::Quality(ask) => quality::apply(state, work, ask),
        Ask::Check(ask) => check::apply(state, work, ask),
        Ask::RoundTrip(ask) => round_trip::apply(state, work, ask),
        Ask::Project(ask) => project(state, work, ask),
        Ask::Trees(ask) => trees::apply(state, work, ask),
        Ask::Images(ask) => save_image::apply(state, work, ask),
        Ask::Window(ask) => window::apply(state, work, ask),
    }
    autosave_if_due(state, work);
}

/// Applies the results that jobs have delivered since the last call.
pub fn take_in(state: &mut State, work: &mut Work) {
    let (notes, arrivals) = work.jobs.receive(&mut state.running);
    notes.into_iter().for_each(|note| state.tell(note));
    for arrival in arrivals {
        arrival(state).into_iter().for_each(|ask| apply(state, work, ask));
    }
}

/// Continues everything that runs by itself; called once a frame.
pub fn go_on(state: &mut State, work: &mut Work) {
    follow(state, work);
    follow_history(state, work);
    trees::follow_light(state, work);
    trees::follow_images(state, work);
    trees::follow_trees(state, work);
    state.fly_on();
    space::go_on(state, work);
    round_trip::take_home(state, work).into_iter().for_each(|ask| apply(state, work, ask));
    paint_strokes(state, work);
    check_again(state, work);
    reload_if_due(state, work);
    keep_masks(state, work);
    follow_known(state, work);
    keep_up_to_date(state, work);
}

fn decide(state: &mut State, work: &mut Work, ask: DecideAsk) {
    match ask {
        DecideAsk::Edit(name, project, gesture) => state.edit(name, *project, gesture),
        DecideAsk::EndGesture => state.end_gesture(),
        DecideAsk::Undo => undo(state, work),
        DecideAsk::Redo => redo(state, work),
        DecideAsk::Layers(edit) => state.decide(&edit),
        DecideAsk::Merge => state.merge_layers(),
        DecideAsk::ConfirmMerge(confirmed) => state.confirm_merge(confirmed),
        DecideAsk::Split => state.split_layer(),
        DecideAsk::Pin => state.pin(),
        DecideAsk::Exclude => state.exclude(),
        DecideAsk::Reset => state.reset_decisions(),
        DecideAsk::Rename(photo, layer, name) => state.rename_layer(photo, layer, &name),
        DecideAsk::Forget(photo, number) => state.forget_decision(photo, number),
        DecideAsk::GoToStep(done) => state.history_target = Some(done),
        DecideAsk::AskToRemove(object) => state.ask_to_remove(&object),
        DecideAsk::ConfirmRemoval(confirmed) => state.confirm_removal(confirmed),
        DecideAsk::SwitchObject(object, on) => state.switch_object(&object, on),
        DecideAsk::TurnObject(object, turns) => state.turn_object(&object, turns),
        DecideAsk::SeeThroughObject(object, through) => state.see_through_object(&object, through),
        DecideAsk::FreeObject(object) => state.free_object(&object),
        DecideAsk::AllObjectsOn => state.switch_all_on(),
        DecideAsk::Options { edit, goes_on } => state.edit_options(&edit, goes_on),
    }
}

fn build(state: &mut State, work: &mut Work, ask: BuildAsk) {
    match ask {
        BuildAsk::Build(photos) => build_layers(state, work, photos),
        BuildAsk::Fill => fill_hidden(state, work),
        BuildAsk::Reread(None) => reload(state, work),
        BuildAsk::Reread(then_build) => reopen(state, work, then_build),
        BuildAsk::PreparePainter => prepare_painter(state, work),
        BuildAsk::RestartPainter => restart_painter(state, work),
        BuildAsk::SiteRead { is_same } => site_read(state, work, is_same),
        BuildAsk::PainterMade => painter_made(state, work),
        BuildAsk::PainterFailed(folder, error) => painter_failed(state, work, &folder, &error),
        BuildAsk::Redecide => redecide(state, work),
        BuildAsk::Stop(job) => stop_job(state, work, job),
        BuildAsk::StopAll => work.jobs.stop_all(&mut state.running),
    }
}

fn project(state: &mut State, work: &mut Work, ask: ProjectAsk) {
    match ask {
        ProjectAsk::Open(project) => open_project(state, work, project),
        ProjectAsk::OpenNow(project) => open_now(state, work, project),
        ProjectAsk::Opened(opened) => {
            let (session, recovered) = *opened;
            arrived(state, work, session, recovered);
        }
        ProjectAsk::Created(parts, made) => created(state, work, &parts, *made),
        ProjectAsk::Save => drop(save_project(state, work)),
        ProjectAsk::Life(event) => happens(state, work, event),
        ProjectAsk::Recover(restores) => answer_recovery(state, work, restores),
        ProjectAsk::Forget(project) => forget_project(state, work, &project),
        ProjectAsk::ShowMissing => state.show_missing(),
        ProjectAsk::Dialog(request) => grant_opening(state, work, request),
    }
}

#[cfg(test)]
pub mod tests;
