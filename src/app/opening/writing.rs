//! A project or the window left while something still writes: asked what becomes of it.

use eframe::egui::{Context, RichText, Spinner};

use super::Wish;
use crate::app::dialog::Dialog;
use crate::app::editor::Editor;
use crate::app::leaving::Leaving;

/// What becomes of what runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Farewell {
    /// It is stopped, and then one leaves.
    Stop,
    /// One leaves when it is done.
    Wait,
    /// Nothing is left.
    Stay,
}

/// Somebody is asked, or waits.
pub struct Writing {
    leaving: Leaving,
    waits: bool,
}

impl Editor {
    /// Leaves; asks first where that ends something that writes.
    pub(in crate::app) fn leave_writers(&mut self, leaving: Leaving) {
        if self.jobs.writing().next().is_none() {
            self.left(leaving);
        } else {
            self.opening.writing = Some(Writing { leaving, waits: false });
        }
    }

    pub(super) fn bid(&mut self, farewell: Farewell) {
        if farewell == Farewell::Stay {
            self.opening.writing = None;
            return;
        }
        if farewell == Farewell::Stop {
            self.jobs.stop_writing();
        }
        self.opening.writing.iter_mut().for_each(|writing| writing.waits = true);
    }

    /// Leaves when what wrote has ended.
    pub(super) fn watch_writing(&mut self) {
        if self.jobs.writing().next().is_none()
            && let Some(Writing { leaving, .. }) = self.opening.writing.take()
        {
            self.left(leaving);
        }
    }
}

fn verb(leaving: &Leaving) -> &'static str {
    match leaving {
        Leaving::Quit => "quit",
        Leaving::Close => "close the project",
        Leaving::Open(_) => "open the other project",
        Leaving::Create => "make the new project",
    }
}

/// Draws it.
pub(super) fn writing_ui(editor: &Editor, context: &Context, wishes: &mut Vec<Wish>) {
    let Some(writing) = &editor.opening.writing else { return };
    let answer = Dialog::new("writing", 460.0).show(context, |ui, keys| {
        ui.heading("Something is still being written");
        for (_, job) in editor.jobs.writing() {
            ui.horizontal(|ui| {
                ui.add(Spinner::new().size(16.0));
                ui.label(RichText::new(&job.name).strong());
                ui.weak(crate::app::panel::status::left(job));
            });
        }
        let verb = verb(&writing.leaving);
        if writing.waits {
            ui.label(format!("As soon as that has ended: {verb}."));
        } else {
            ui.label("What is finished stays in any case; the rest can be made later.");
        }
        ui.add_space(8.0);
        ui.horizontal_wrapped(|ui| {
            // Nothing is lost by waiting, nor by staying once one waits.
            let usual = if writing.waits { Farewell::Stay } else { Farewell::Wait };
            let mut choice = |text: String, farewell| {
                let button = ui.button(text);
                let is_usual = farewell == usual;
                let is_pressed = if is_usual { keys.press_first(&button) } else { button.clicked() };
                if is_pressed {
                    wishes.push(Wish::Leave(farewell));
                }
            };
            choice(format!("Stop it and {verb}"), Farewell::Stop);
            if !writing.waits {
                choice(format!("Wait, then {verb}"), Farewell::Wait);
            }
            choice("Go on working".into(), Farewell::Stay);
        });
    });
    if answer.is_left() {
        wishes.push(Wish::Leave(Farewell::Stay));
    }
}
