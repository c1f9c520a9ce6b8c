//! What was done to the document, to be undone and done again. Pure: snapshots are shared, nothing is
//! read or written.

use std::collections::VecDeque;
use std::ops::RangeBounds;
use std::path::PathBuf;
use std::sync::Arc;

use super::Project;
use super::masks::{Mask, MaskChange, MaskFrom};
use super::paint::ImportedMask;

/// So many steps can be undone.
pub const MOST_STEPS: usize = 1000;

/// The authored project through time: one step per gesture, each with a name. Steps after the present
/// can be done again until something else is done.
#[derive(Debug, Clone)]
pub struct History {
    /// Oldest first; those before `undone` steps from the end lie in the past.
    steps: VecDeque<Step>,
    /// How many steps at the end are undone.
    undone: usize,
    present: Arc<Project>,
    /// What is on disk; none when no step leads to it.
    saved: Arc<Project>,
    /// The gesture that may still add to the last step.
    gesture: Option<Gesture>,
}

/// What holds together the edits of one drag or one stroke of typing: chosen by whoever edits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Gesture(pub u64);

/// One step.
#[derive(Debug, Clone)]
struct Step {
    /// `merge of 3 layers`.
    name: String,
    change: Change,
}

#[derive(Debug, Clone)]
enum Change {
    /// The project before it and after it.
    Project { before: Arc<Project>, after: Arc<Project> },
    /// Paint came home, of these files, and masks with it. Its number changes when it is imported again.
    Import { number: u32, files: Vec<PathBuf>, masks: Vec<MaskChange> },
}

/// What undoing or doing again came to, and what is left to do for whoever asked.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// [`History::present`] is another project.
    Project,
    /// Take the import with this number back, and tell [`History::took_back`].
    /// [`crate::document::paint::PaintBook::take_back`] takes the last one: where that is another, or none is left, this
    /// cannot be done, and [`History::forget_import`] says so.
    TakeBack(u32),
    /// Import these files again, as they are by now, and tell the new number with
    /// [`History::imported_again`]. The number is that of the import that was taken back.
    ImportAgain(u32, Vec<PathBuf>),
}

impl History {
    /// Begins with a project as it is on disk.
    pub fn new(project: Project) -> Self {
        let present = Arc::new(project);
        Self { steps: VecDeque::new(), undone: 0, saved: present.clone(), present, gesture: None }
    }

    /// The project as it is now.
    pub fn present(&self) -> &Arc<Project> {
        &self.present
    }

    /// Makes a step. Edits of one gesture in a row are one step, which keeps the first one's name; a
    /// gesture that ends where it began leaves none. What changes nothing is no step.
    pub fn edit(&mut self, name: impl Into<String>, project: Project, gesture: Option<Gesture>) {
        let goes_on = gesture.is_some() && self.gesture == gesture && self.undone == 0;
        if *self.present == project {
            return;
        }
        let after = Arc::new(project);
        let open = if goes_on { self.steps.back_mut() } else { None };
        if let Some(Step { change: Change::Project { before, after: end }, .. }) = open {
            let nothing = **before == *after;
            *end = after.clone();
            // The snapshot itself, so that what is saved is known again.
            self.present = if nothing { before.clone() } else { after };
            if nothing {
                self.steps.pop_back();
                self.gesture = None;
            }
            return;
        }
        let before = std::mem::replace(&mut self.present, after.clone());
        self.push(Step { name: name.into(), change: Change::Project { before, after } });
        self.gesture = gesture;
    }

    /// Ends a gesture: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Makes a step of an import that was made. It is on disk already, and of the project nothing changed but the masks
    /// that came with it, there, too.
    pub fn imported(
        &mut self,
        name: impl Into<String>,
        number: u32,
        files: Vec<PathBuf>,
        masks: Vec<MaskChange>,
    ) {
        self.set_masks(masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.after)));
        self.push(Step { name: name.into(), change: Change::Import { number, files, masks } });
        self.gesture = None;
    }

    /// Tells the number that an import has which was done again, in place of its old one, and the masks that came.
    pub fn imported_again(&mut self, old: u32, new: u32, came: Vec<MaskChange>) {
        self.set_masks(came.iter().map(|mask| (&mask.photo, &mask.from, &mask.after)));
        let Some(place) = self.place_of_import(old) else { return };
        // What was done after it was done with the masks that came then.
        let after = came.iter().map(|mask| (&mask.photo, &mask.from, &mask.after));
        self.rewrite(place.., |project| with_masks(project, after.clone()));
        if let Change::Import { number, masks, .. } = &mut self.steps[place].change {
            (*number, *masks) = (new, came);
        }
    }

    fn place_of_import(&self, import: u32) -> Option<usize> {
        let is_it = |step: &Step| matches!(step.change, Change::Import { number, .. } if number == import);
        self.steps.iter().position(is_it)
    }

    /// An import was taken back, and on disk there is again what stood in the places of its masks. Where it is no step
    /// that can be done again, its masks are in no step any more.
    pub fn took_back(&mut self, import: u32, masks: &[ImportedMask]) {
        let put_back = masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.before));
        self.set_masks(put_back.clone());
        if self.place_of_import(import).is_none() && !masks.is_empty() {
            self.rewrite(.., |project| with_masks(project, put_back.clone()));
        }
    }

    /// Masks of the present and of what is on disk.
    fn set_masks<'a>(&mut self, masks: impl ExactSizeIterator<Item = NewMask<'a>> + Clone) {
        if masks.len() > 0 {
            self.present = with_masks(&self.present, masks.clone());
            self.saved = with_masks(&self.saved, masks);
            self.gesture = None;
        }
    }

    /// Makes other projects of what some steps lead from and to.
    fn rewrite(&mut self, steps: impl RangeBounds<usize>, change: impl Fn(&Arc<Project>) -> Arc<Project>) {
        // One after the other has the same project as before and after: it stays one.
        let mut last: Option<(Arc<Project>, Arc<Project>)> = None;
        let mut changed = |project: &mut Arc<Project>| {
            let known =
                last.as_ref().filter(|(old, _)| Arc::ptr_eq(old, project)).map(|(_, new)| new.clone());
            let new = known.unwrap_or_else(|| change(project));
            let old = std::mem::replace(project, new.clone());
            last = Some((old, new));
        };
        for step in self.steps.range_mut(steps) {
            if let Change::Project { before, after } = &mut step.change {
                changed(before);
                changed(after);
            }
        }
    }

    /// Forgets an import, as one that can no longer be taken back or done again. One that was made stays made: steps
    /// before it have its masks from now on.
    pub fn forget_import(&mut self, number: u32) {
        let made = self.place_of_import(number).filter(|place| *place < self.steps.len() - self.undone);
        if let Some((place, Change::Import { masks, .. })) =
            made.map(|place| (place, self.steps[place].change.clone()))
        {
            let after = masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.after));
            self.rewrite(..place, |project| with_masks(project, after.clone()));
        }
        let is_it = |step: &Step| matches!(step.change, Change::Import { number: n, .. } if n == number);
        let past = self.steps.len() - self.undone;
        let after = self.steps.iter().skip(past).filter(|step| is_it(step)).count();
        self.steps.retain(|step| !is_it(step));
        self.undone -= after;
    }

    fn push(&mut self, step: Step) {
        self.steps.truncate(self.steps.len() - self.undone);
        self.undone = 0;
        self.steps.push_back(step);
        if self.steps.len() > MOST_STEPS {
            self.steps.pop_front();
        }
    }

    /// The name of the step that [`Self::undo`] takes back.
    pub fn undoes(&self) -> Option<&str> {
        let place = self.steps.len().checked_sub(self.undone + 1)?;
        Some(&self.steps[place].name)
    }

    /// The name of the step that [`Self::redo`] does again.
    pub fn redoes(&self) -> Option<&str> {
        Some(&self.steps.get(self.steps.len() - self.undone)?.name)
    }

    /// Takes the last step back; none when there is none.
    pub fn undo(&mut self) -> Option<Turn> {
        let place = self.steps.len().checked_sub(self.undone + 1)?;
        self.undone += 1;
        self.gesture = None;
        Some(match &self.steps[place].change {
            Change::Project { before, .. } => {
                self.present = before.clone();
                Turn::Project
            }
            Change::Import { number, .. } => Turn::TakeBack(*number),
        })
    }

    /// Does the last step again that was undone; none when there is none.
    pub fn redo(&mut self) -> Option<Turn> {
        let place = self.steps.len() - self.undone;
        let step = self.steps.get(place)?;
        self.undone -= 1;
        self.gesture = None;
        Some(match &step.change {
            Change::Project { after, .. } => {
                self.present = after.clone();
                Turn::Project
            }
            Change::Import { number, files, .. } => Turn::ImportAgain(*number, files.clone()),
        })
    }

    /// The project as it is on disk, as far as anybody here knows.
    pub fn on_disk(&self) -> &Project {
        &self.saved
    }

    /// Remembers that the present project is on disk.
    pub fn saved(&mut self) {
        self.saved = self.present.clone();
        // What is done from here on can be undone to what was saved.
        self.gesture = None;
    }

    /// Something of the present project is not on disk. Steps that lead back to what was saved make it
    /// clean again, however they came there.
    pub fn is_dirty(&self) -> bool {
        !Arc::ptr_eq(&self.present, &self.saved) && self.present != self.saved
    }
}

/// What stands in a place of a mask: photo, maker, and the mask or nothing.
type NewMask<'a> = (&'a String, &'a MaskFrom, &'a Option<Mask>);

/// The project with these masks; the same one, where it has them.
fn with_masks<'a>(project: &Arc<Project>, masks: impl Iterator<Item = NewMask<'a>>) -> Arc<Project> {
    let mut changed = project.masks.clone();
    masks.for_each(|(photo, from, mask)| changed.set(photo, from, mask.clone()));
    match changed == project.masks {
        true => project.clone(),
        false => Arc::new(Project { masks: changed, ..Project::clone(project) }),
    }
}

#[cfg(test)]
mod tests;
