//! What is at the paths of a dialog, looked at beside the window while somebody types.

use eframe::egui::Context;

use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::recipe::discover::{Look, Parts, look_at};

/// A path that did not change for so long is meant, not still being typed.
const TYPED_S: f64 = 0.35;

/// What is wanted, and what was seen last.
#[derive(Default)]
pub struct Looking {
    wanted: Parts,
    since_s: f64,
    asked: Option<Parts>,
    /// What was seen, maybe of other paths than are wanted now.
    pub look: Option<Look>,
}

impl Looking {
    /// These are the paths now.
    pub fn want(&mut self, parts: Parts, now_s: f64) {
        if self.wanted != parts {
            (self.wanted, self.since_s) = (parts, now_s);
        }
    }

    /// What is there, once it is known of the paths as they are.
    pub fn now(&self) -> Option<&Look> {
        self.look.as_ref().filter(|look| look.parts() == self.wanted)
    }
}

impl Editor {
    /// Looks at paths that have been typed to their end.
    pub(super) fn keep_looking(&mut self, context: &Context) {
        let looking = &mut self.opening.looking;
        if looking.asked.as_ref().unwrap_or(&Parts::default()) == &looking.wanted {
            return;
        }
        let rest_s = looking.since_s + TYPED_S - context.input(|input| input.time);
        if rest_s > 0.0 {
            context.request_repaint_after_secs(rest_s as f32);
            return;
        }
        let (parts, before) = (looking.wanted.clone(), looking.look.clone());
        looking.asked = Some(parts.clone());
        self.jobs.stop_kind(Kind::Look);
        self.jobs.start(Kind::Look, "Looking at files", move |task| {
            let look = look_at(&parts, before.as_ref(), task)?;
            Ok(Box::new(move |editor| {
                // A later look may have been asked for, and may even have been quicker.
                if editor.opening.looking.asked.as_ref() == Some(&look.parts()) {
                    editor.opening.looking.look = Some(look);
                }
            }))
        });
    }
}
