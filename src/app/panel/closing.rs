//! Draws the questions before a project is left, and after a crash. `state::life` decides what follows from an answer.

use eframe::egui::{Context, RichText, Ui};

use super::answers_ui;
use super::status::left;
use crate::state::State;
use crate::state::life::{Goal, Life, LifeEvent, Phase, Recovery};
use crate::state::notes::ago;
use crate::state::request::{ProjectRequest, Request};
use crate::state::running::Running;
use crate::state::session::Session;
use crate::widget::dialog::{Dialog, Keys};
use crate::widget::spinner::Spinner;

/// What the questions before a project is left depend on.
pub struct ClosingView<'a> {
    /// The life cycle of the project.
    life: &'a Life,
    /// The open project.
    session: Option<&'a Session>,
    /// The running jobs.
    running: &'a Running,
    /// The number of brush strokes that are not in the layers yet.
    unpainted: usize,
}

impl<'a> ClosingView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            life: &state.life,
            session: state.session.as_ref(),
            running: &state.running,
            unpainted: state.space.brush.unpainted(),
        }
    }
}

/// Draws the open question, if there is one.
pub fn closing_ui(context: &Context, view: &ClosingView<'_>, requests: &mut Vec<Request>) {
    let answer = match (&view.life.phase, &view.life.recovery) {
        (Phase::Asking { failed, .. }, _) => ask_unsaved(context, view, failed.as_deref(), false),
        (Phase::Saving { .. }, _) => ask_unsaved(context, view, None, true),
        (Phase::Staying, Some(recovery)) => {
            let restores = ask_recovery(context, recovery);
            return requests.extend(restores.map(|restores| ProjectRequest::Recover(restores).into()));
        }
        (Phase::Writing { goal, .. }, _) => ask_writing(context, view, goal, false),
        (Phase::Waiting { goal, .. }, _) => ask_writing(context, view, goal, true),
        (Phase::Staying, None) => None,
    };
    requests.extend(answer.map(|event| ProjectRequest::Life(event).into()));
}

/// Asks about unsaved changes, and gives the reason where saving failed.
fn ask_unsaved(
    context: &Context,
    view: &ClosingView<'_>,
    failed: Option<&str>,
    saves: bool,
) -> Option<LifeEvent> {
    let name = view.session.map(Session::name).unwrap_or_default();
    let asked = Dialog::new("leaving", 440.0).show(context, |ui, keys| {
        let answers = match failed {
            None => {
                ui.label(RichText::new(format!("Save changes to {name}?")).heading());
                ui.add_space(4.0);
                ui.label(
                    "Layers, fillings and paint are already on disk. Unsaved decisions will be lost.",
                );
                [("Save", LifeEvent::Save), ("Do not save", LifeEvent::Discard), ("Cancel", LifeEvent::Stay)]
            }
            Some(failed) => {
                ui.label(RichText::new(format!("{name} could not be saved")).heading());
                ui.add_space(4.0);
                ui.colored_label(ui.visuals().error_fg_color, failed);
                ui.label(
                    "The project on disk has not changed, and does not contain your last decisions. Fix the problem, \
                     and try again.",
                );
                [("Try again", LifeEvent::Save), ("Leave without saving", LifeEvent::Discard), ("Stay here", LifeEvent::Stay)]
            }
        };
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            let names = answers.each_ref().map(|(name, _)| *name);
            let chosen = answers_ui(ui, keys, &names);
            if saves {
                ui.add(Spinner::new());
                ui.label("Saving masks…");
            }
            answers.into_iter().find(|(name, _)| chosen == Some(*name)).map(|(_, answer)| answer)
        })
        .inner
    });
    let is_left = asked.is_left();
    asked.inner.or(is_left.then_some(LifeEvent::Stay))
}

/// Asks whether unsaved changes of the last run are restored.
fn ask_recovery(context: &Context, recovery: &Recovery) -> Option<bool> {
    let when = recovery.found.time.elapsed().map_or_else(|_| "the end".into(), ago);
    let mut answer = None;
    Dialog::new("recovery", 440.0).show(context, |ui, keys| {
        ui.label(RichText::new("Recover unsaved changes?").heading());
        ui.add_space(4.0);
        ui.label(format!(
            "The program ended before you saved. Your decisions until {when} were autosaved: restore them, or \
             discard them and continue from the last save."
        ));
        if recovery.found.saved_since {
            ui.colored_label(
                ui.visuals().warn_fg_color,
                "Another program has saved the project since then: restoring replaces its changes.",
            );
        }
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            answer = answers_ui(ui, keys, &["Restore", "Discard"]);
        });
    });
    answer.map(|answer| answer == "Restore")
}

/// Asks about running writes; `waits`: the user has chosen to wait, and can return to the project.
fn ask_writing(context: &Context, view: &ClosingView<'_>, goal: &Goal, waits: bool) -> Option<LifeEvent> {
    let asked = Dialog::new("writing", 460.0).show(context, |ui, keys| {
        ui.heading("Files are still being written");
        for (_, job) in view.running.writing() {
            ui.horizontal(|ui| {
                ui.add(Spinner::new().size(16.0));
                ui.label(RichText::new(&job.name).strong());
                ui.weak(left(job));
            });
        }
        let strokes = view.unpainted;
        if strokes > 0 {
            let text = match strokes {
                1 => "A brush stroke is not in the layers yet: stopping loses it.".to_owned(),
                strokes => format!("{strokes} brush strokes are not in the layers yet: stopping loses them."),
            };
            ui.colored_label(ui.visuals().warn_fg_color, text);
        }
        let verb = verb(goal);
        if waits {
            ui.label(format!("As soon as this has finished: {verb}."));
        } else if strokes == 0 {
            ui.label("Finished results are kept in any case; the rest can be computed later.");
        }
        ui.add_space(8.0);
        writing_answers(ui, keys, verb, waits)
    });
    let is_left = asked.is_left();
    asked.inner.or(is_left.then_some(LifeEvent::Stay))
}

fn writing_answers(ui: &mut Ui, keys: &mut Keys, verb: &str, waits: bool) -> Option<LifeEvent> {
    // The default answer loses nothing: waiting, or staying once it waits.
    let usual = if waits { LifeEvent::Stay } else { LifeEvent::Wait };
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        let mut choice = |text: String, event: LifeEvent| {
            let button = ui.button(text);
            let is_pressed = if event == usual { keys.press_first(&button) } else { button.clicked() };
            if is_pressed {
                chosen = Some(event);
            }
        };
        choice(format!("Stop and {verb}"), LifeEvent::Stop);
        if !waits {
            choice(format!("Wait, then {verb}"), LifeEvent::Wait);
        }
        choice("Continue working".into(), LifeEvent::Stay);
    });
    chosen
}

fn verb(goal: &Goal) -> &'static str {
    match goal {
        Goal::Quit => "quit",
        Goal::Close => "close the project",
        Goal::Open(_) => "open the other project",
        Goal::Create => "create the new project",
    }
}
