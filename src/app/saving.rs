//! Saving what was decided, and keeping what is not saved for the case that the program ends.

use std::path::Path;
use std::time::{Duration, Instant};

use super::editor::Editor;
use super::jobs::Kind;
use super::notes::{Note, Weight};
use crate::document::Project;
use crate::error::{Error, Result};
use crate::io::project::change_project;

/// What a gesture edits is kept when nothing has been edited for so long, in seconds: a slider that is being dragged is
/// not written at every step. Every other edit is kept at once.
const KEPT_AFTER_S: f64 = 0.4;
/// And at the latest so long after the first edit that is not kept, in seconds: somebody who works without a rest loses
/// no more than that.
const KEPT_AT_LATEST_S: f64 = 2.0;
/// Where it could not be kept, it is tried again after so long, in seconds: a disk was full, and may not be any more.
const KEPT_AGAIN_S: f64 = 5.0;
/// A window that ends waits no longer than this for masks that are being written: a slow disk takes some seconds.
const LAST_WAIT: Duration = Duration::from_secs(8);
/// How often it looks whether they are.
const LOOKS_EVERY: Duration = Duration::from_millis(4);

/// When the present project is to be kept.
#[derive(Debug, Default)]
pub struct DueKeep {
    is_due: bool,
    /// A gesture goes on, of which only the end matters.
    in_gesture: bool,
    edited_s: f64,
    /// When the first edit was made that is not kept.
    unkept_s: f64,
    /// It is not kept before: the last try failed.
    not_before_s: f64,
}

impl DueKeep {
    /// Something was edited.
    pub fn edited(&mut self, in_gesture: bool, now_s: f64) {
        if !self.is_due {
            self.unkept_s = now_s;
        }
        (self.is_due, self.in_gesture, self.edited_s) = (true, in_gesture, now_s);
    }

    /// The gesture has ended.
    pub fn gesture_ended(&mut self) {
        self.in_gesture = false;
    }

    fn is_time(&self, now_s: f64) -> bool {
        let rests = now_s - self.edited_s >= KEPT_AFTER_S || now_s - self.unkept_s >= KEPT_AT_LATEST_S;
        self.is_due && (rests || !self.in_gesture) && now_s >= self.not_before_s
    }
}

impl Editor {
    /// Something is not saved.
    pub fn is_dirty(&self) -> bool {
        self.session.as_ref().is_some_and(|session| session.history.is_dirty()) || !self.masking.is_kept()
    }

    /// Saves the project; whether it is saved now. Where it is not, a note says why.
    pub fn save_project(&mut self) -> bool {
        match self.save() {
            Ok(()) => true,
            Err(error) => {
                self.tell(Note::new(Weight::Problem, format!("The project was not saved: {error}")));
                false
            }
        }
    }

    /// Saves the project.
    ///
    /// # Errors
    /// [`Error::Io`]: what is on disk is as it was, and what is not saved stays so.
    pub(super) fn save(&mut self) -> Result<()> {
        let Some(session) = &mut self.session else { return Ok(()) };
        let (folder, project, known) =
            (&session.folder, session.history.present(), session.history.on_disk());
        let save = || {
            change_project(folder, |now| {
                // An import that has just ended has put its masks there.
                let masks = now.map(|now| project.masks.with_news(&known.masks, &now.masks));
                let masks = masks.unwrap_or_else(|_| project.masks.clone());
                Ok(Project { masks, ..Project::clone(project) })
            })
        };
        let ((), forgotten) = session.keeper.saved(save)?;
        session.history.saved();
        session.due.keep = DueKeep::default();
        if let Err(error) = forgotten {
            self.tell(Note::new(Weight::Warning, error.to_string()));
        }
        Ok(())
    }

    /// Forgets what is not saved: the project was left so by its user.
    pub fn discard_unsaved(&mut self) {
        self.masking.forget_waiting();
        let Some(session) = &mut self.session else { return };
        session.due.keep = DueKeep::default();
        if let Err(error) = session.keeper.forget() {
            self.tell(Note::new(Weight::Warning, error.to_string()));
        }
    }

    /// Keeps what is not saved, when it is time to.
    pub(super) fn keep_if_due(&mut self) {
        let now_s = self.now_s();
        let writes = self.jobs.runs(Kind::Keep);
        let Some(session) = self.session.as_mut().filter(|session| session.due.keep.is_due) else { return };
        if !session.due.keep.is_time(now_s) || writes {
            return self.context.request_repaint_after_secs(KEPT_AFTER_S as f32);
        }
        session.due.keep.is_due = false;
        let (folder, keeper) = (session.folder.clone(), session.keeper.clone());
        self.jobs.start(Kind::Keep, "Keeping what is not saved", move |_| {
            let kept = keeper.write();
            drop(keeper);
            Ok(Box::new(move |editor| kept.unwrap_or_else(|error| editor.not_kept(&folder, &error))))
        });
    }

    /// Keeps what is not saved at once: the program may be about to end.
    pub(super) fn keep_now(&mut self) {
        let kept = self.session.as_ref().map_or(Ok(()), |session| session.keeper.write());
        if let Err(error) = kept {
            self.notes.add(Note::new(Weight::Problem, error.to_string()));
        }
    }

    fn not_kept(&mut self, folder: &Path, error: &Error) {
        let now_s = self.now_s();
        if let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) {
            session.due.keep.edited(false, now_s);
            session.due.keep.not_before_s = now_s + KEPT_AGAIN_S;
        }
        let text = format!(
            "What is not saved could not be kept for the case of a crash; it is tried again: {error}"
        );
        self.tell(Note::new(Weight::Problem, text));
    }

    /// The window ends, whoever ends it: masks that wait are written, and what is not saved and not given up is kept.
    pub(super) fn end(&mut self) {
        self.jobs.stop_all_but(Kind::Mask);
        let since = Instant::now();
        while !self.masking.is_kept() && self.session.is_some() && since.elapsed() < LAST_WAIT {
            let (_, arrivals) = self.jobs.receive();
            arrivals.into_iter().for_each(|arrival| arrival(self));
            self.keep_masks();
            std::thread::sleep(LOOKS_EVERY);
        }
        self.keep_now();
        self.jobs.stop_all();
    }
}

impl Drop for Editor {
    /// A display that is gone takes the window with it, and asks nobody.
    fn drop(&mut self) {
        // While a panic is on its way another one would end everything at once.
        let _ = super::crash::guarded(|| self.end());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_decided_is_kept_at_once_and_a_gesture_when_it_rests_or_lasts() {
        let mut due = DueKeep::default();
        assert!(!due.is_time(0.0));
        due.edited(false, 1.0);
        assert!(due.is_time(1.0));
        let mut due = DueKeep::default();
        (0..30).for_each(|step| due.edited(true, 1.0 + 0.05 * f64::from(step)));
        assert!(!due.is_time(2.5) && due.is_time(2.5 + KEPT_AFTER_S));
        due.edited(true, 3.0);
        assert!(due.is_time(3.0), "two seconds after the first");
        let mut due = DueKeep::default();
        due.edited(true, 1.0);
        due.gesture_ended();
        assert!(due.is_time(1.0));
        due.not_before_s = 6.0;
        assert!(!due.is_time(5.0) && due.is_time(6.0));
    }
}
