//! What is at the paths of a dialog, looked at beside the window while somebody types.

use std::time::Instant;

use eframe::egui::Context;

use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::recipe::discover::{Look, Parts, look_at};

/// A path that did not change for so long is meant, not still being typed.
const TYPED_S: f64 = 0.35;
/// Files change while a dialog is open, as when a model is exported again: it is looked so often,
const AGAIN_S: f64 = 2.0;
/// and where a look takes long, as on a drive far away, no more than so much of the time goes into it.
const SHARE: f64 = 0.05;

/// What is wanted, and what was seen last.
#[derive(Default)]
pub struct Looking {
    wanted: Parts,
    since_s: f64,
    asked: Option<Parts>,
    asked_s: f64,
    /// How long the last look took.
    took_s: f64,
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
        let now_s = context.input(|input| input.time);
        let is_shown = self.opening.assistant.is_some() || self.opening.relinking.is_some();
        let looking = &mut self.opening.looking;
        let is_new = looking.asked.as_ref().unwrap_or(&Parts::default()) != &looking.wanted;
        // What is looked at is not asked for again before it is seen.
        if !is_new && (!is_shown || looking.asked.is_none() || self.jobs.runs(Kind::Paths)) {
            return;
        }
        let due_s = if is_new {
            looking.since_s + TYPED_S
        } else {
            looking.asked_s + AGAIN_S.max(looking.took_s / SHARE)
        };
        let rest_s = due_s - now_s;
        if rest_s > 0.0 {
            context.request_repaint_after_secs(rest_s as f32);
            return;
        }
        let (parts, before) = (looking.wanted.clone(), looking.look.clone());
        (looking.asked, looking.asked_s) = (Some(parts.clone()), now_s);
        self.jobs.stop_kind(Kind::Paths);
        self.jobs.start(Kind::Paths, "Looking at files", move |task| {
            let since = Instant::now();
            let look = look_at(&parts, before.as_ref(), task)?;
            let took_s = since.elapsed().as_secs_f64();
            Ok(Box::new(move |editor| {
                // A later look may have been asked for, and may even have been quicker.
                if editor.opening.looking.asked.as_ref() == Some(&look.parts()) {
                    editor.opening.looking.look = Some(look);
                    editor.opening.looking.took_s = took_s;
                }
            }))
        });
    }
}
