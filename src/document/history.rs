//! What was done to the document, to be undone and done again. Pure: snapshots are shared, nothing is
//! read or written.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use super::Project;

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
    /// Paint came home, of these files. Its number changes when it is imported again.
    Import { number: u32, files: Vec<PathBuf> },
}

/// What undoing or doing again came to, and what is left to do for whoever asked.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// [`History::present`] is another project.
    Project,
    /// Take the import with this number back. [`crate::document::paint::PaintBook::take_back`] takes the last
    /// one: where that is another, or none is left, this cannot be done, and [`History::forget_import`] says so.
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

    /// Makes a step of an import that was made: it is on disk already, and nothing of the project
    /// changed.
    pub fn imported(&mut self, name: impl Into<String>, number: u32, files: Vec<PathBuf>) {
        self.push(Step { name: name.into(), change: Change::Import { number, files } });
        self.gesture = None;
    }

    /// Tells the number that an import has which was done again, in place of its old one.
    pub fn imported_again(&mut self, old: u32, new: u32) {
        for step in &mut self.steps {
            if let Change::Import { number, .. } = &mut step.change
                && *number == old
            {
                *number = new;
            }
        }
    }

    /// Forgets an import, as one that can no longer be taken back or done again.
    pub fn forget_import(&mut self, number: u32) {
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
            Change::Import { number, files } => Turn::ImportAgain(*number, files.clone()),
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Similarity;
    use crate::layers::Options;
    use crate::scene::synthetic::Dice;

    fn project(margin: u32) -> Project {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let project: Project = serde_json::from_str(text).unwrap();
        assert_eq!(project.world_from_model, Similarity::IDENTITY);
        Project { options: Options { margin, ..Options::default() }, ..project }
    }

    /// The names of all steps, oldest first, and how many of them lie in the past.
    fn names(history: &History) -> (Vec<&str>, usize) {
        let names = history.steps.iter().map(|step| step.name.as_str()).collect();
        (names, history.steps.len() - history.undone)
    }

    fn margin(history: &History) -> u32 {
        history.present().options.margin
    }

    #[test]
    fn steps_are_undone_and_done_again_by_name() {
        let mut history = History::new(project(1));
        assert_eq!((history.undo(), history.redo()), (None, None));
        history.edit("merge of 3 layers", project(2), None);
        history.edit("split", project(3), None);
        assert_eq!(history.undoes(), Some("split"));
        assert_eq!(history.undo(), Some(Turn::Project));
        assert_eq!((history.undoes(), history.redoes()), (Some("merge of 3 layers"), Some("split")));
        assert_eq!(margin(&history), 2);
        history.undo();
        assert_eq!((margin(&history), history.undoes()), (1, None));
        assert_eq!(names(&history), (vec!["merge of 3 layers", "split"], 0));
        history.redo();
        history.redo();
        assert_eq!((margin(&history), history.redo()), (3, None));
    }

    #[test]
    fn what_is_done_after_an_undo_takes_the_place_of_what_was_undone() {
        let mut history = History::new(project(1));
        history.edit("a", project(2), None);
        history.edit("b", project(3), None);
        history.undo();
        history.edit("c", project(4), None);
        assert_eq!((history.redo(), names(&history)), (None, (vec!["a", "c"], 2)));
    }

    #[test]
    fn a_gesture_is_one_step_and_one_that_ends_where_it_began_is_none() {
        let mut history = History::new(project(1));
        (2..50).for_each(|m| history.edit("margin", project(m), Some(Gesture(1))));
        assert_eq!(names(&history).0.len(), 1);
        history.edit("margin", project(50), Some(Gesture(2)));
        assert_eq!(names(&history).0.len(), 2, "another gesture is another step");
        history.undo();
        history.edit("margin", project(60), Some(Gesture(2)));
        assert_eq!(names(&history).0.len(), 2, "an undo ends a gesture");
        history.undo();
        history.undo();
        assert_eq!(margin(&history), 1);
        [2, 3, 1].into_iter().for_each(|m| history.edit("margin", project(m), Some(Gesture(3))));
        assert!(history.undoes().is_none() && !history.is_dirty());
        history.edit("margin", project(1), None);
        assert!(history.undoes().is_none(), "what changes nothing is no step");
        history.edit("margin", project(7), Some(Gesture(4)));
        history.end_gesture();
        history.edit("margin", project(8), Some(Gesture(4)));
        assert_eq!(names(&history).0.len(), 2);
    }

    #[test]
    fn it_is_known_whether_the_present_is_saved_before_and_after_the_save() {
        let mut history = History::new(project(1));
        assert!(!history.is_dirty());
        history.edit("a", project(2), Some(Gesture(1)));
        assert!(history.is_dirty());
        history.saved();
        assert!(!history.is_dirty());
        history.edit("a", project(3), Some(Gesture(1)));
        assert_eq!(names(&history).0.len(), 2, "what was saved stays a place to go back to");
        history.undo();
        assert!(!history.is_dirty());
        history.undo();
        assert!(history.is_dirty(), "undone past the save");
        history.edit("b", project(4), None);
        assert!(history.is_dirty());
        history.edit("c", project(2), None);
        assert!(!history.is_dirty(), "the same content by another way");
    }

    #[test]
    fn imports_are_steps_that_say_what_is_to_be_done() {
        let mut history = History::new(project(1));
        history.edit("a", project(2), None);
        let files = vec![PathBuf::from("wall.psd")];
        history.imported("import of wall.psd", 7, files.clone());
        assert!(history.is_dirty() && history.undoes() == Some("import of wall.psd"));
        assert_eq!(history.undo(), Some(Turn::TakeBack(7)));
        assert_eq!(margin(&history), 2);
        assert_eq!(history.undo(), Some(Turn::Project));
        assert_eq!(
            (history.redo(), history.redo()),
            (Some(Turn::Project), Some(Turn::ImportAgain(7, files)))
        );
        history.imported_again(7, 9);
        assert_eq!(history.undo(), Some(Turn::TakeBack(9)));
        history.forget_import(9);
        assert_eq!((history.redo(), history.undoes()), (None, Some("a")));
    }

    #[test]
    fn a_thousand_steps_can_be_undone_and_no_more() {
        let mut history = History::new(project(0));
        (1..=1200).for_each(|m| history.edit(m.to_string(), project(m), None));
        let mut undone = 0;
        while history.undo().is_some() {
            undone += 1;
        }
        assert_eq!((undone, margin(&history)), (MOST_STEPS, 200));
        while history.redo().is_some() {}
        assert_eq!(margin(&history), 1200);
    }

    /// Against a list of states and a place in it.
    #[test]
    fn any_mixture_of_edits_undo_redo_and_saves_is_that_of_a_plain_list() {
        let mut dice = Dice::new(31);
        for _ in 0..50 {
            let (mut history, mut list, mut at, mut saved) = (History::new(project(0)), vec![0], 0, 0);
            for number in 1..200 {
                match dice.whole(0, 9) {
                    0..=3 => {
                        history.edit("edit", project(number), None);
                        list.truncate(at + 1);
                        list.push(number);
                        at += 1;
                    }
                    4..=6 => {
                        assert_eq!(history.undo().is_some(), at > 0);
                        at = at.saturating_sub(1);
                    }
                    7..=8 => {
                        assert_eq!(history.redo().is_some(), at + 1 < list.len());
                        at = (at + 1).min(list.len() - 1);
                    }
                    _ => {
                        history.saved();
                        saved = list[at];
                    }
                }
                assert_eq!(margin(&history), list[at]);
                assert_eq!(history.is_dirty(), list[at] != saved);
            }
        }
    }
}
