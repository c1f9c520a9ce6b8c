//! What the program has to say: problems, and what became of what was asked for.

use std::time::SystemTime;

use crate::document::masks::MaskChange;
use crate::error::Error;
use crate::recipe::open::UnusableMask;

/// How much a note matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// Something was done.
    Info,
    /// Something is not as it should be; the work goes on.
    Warning,
    /// Something failed.
    Problem,
}

/// What helps, by a click on the note.
#[derive(Debug, Clone, PartialEq)]
pub enum Remedy {
    /// The site is read again.
    ReadAgain,
    /// Another mask in the place of one that cannot be used, or none.
    SetMask(MaskChange),
    /// A file is chosen for a mask of a photo that cannot be used.
    ChooseMask(Box<UnusableMask>),
}

/// One thing said.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// How much it matters.
    pub weight: Weight,
    /// The photo, file or object that it is about; empty for the whole project.
    pub subject: String,
    /// A sentence or two.
    pub text: String,
    /// When it was said.
    pub at: SystemTime,
    /// How often the same was said in a row.
    pub times: u32,
    /// What helps, in a few words each.
    pub remedies: Vec<(String, Remedy)>,
}

impl Note {
    /// About the whole project.
    pub fn new(weight: Weight, text: impl Into<String>) -> Self {
        Self::about(weight, "", text)
    }

    /// About one photo, file or object.
    pub fn about(weight: Weight, subject: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            weight,
            subject: subject.into(),
            text: text.into(),
            at: SystemTime::now(),
            times: 1,
            remedies: Vec::new(),
        }
    }

    /// The same, with a click that helps.
    pub fn with(mut self, words: impl Into<String>, remedy: Remedy) -> Self {
        self.remedies.push((words.into(), remedy));
        self
    }

    /// The same, with more to say.
    pub fn and(mut self, more: &str) -> Self {
        self.text.push_str(more);
        self
    }

    /// What went wrong while `doing`: one note for each thing that did.
    pub fn of_error(doing: &str, error: &Error) -> Vec<Self> {
        match error {
            Error::Several(errors) => errors.iter().flat_map(|error| Self::of_error(doing, error)).collect(),
            error => vec![Self::new(Weight::Problem, format!("{doing}: {error}"))],
        }
    }
}

/// So many are kept; older ones have long been read.
const MOST: usize = 500;

/// All that was said, the newest last.
#[derive(Debug, Default)]
pub struct Notes {
    list: Vec<Note>,
    /// How many were there when somebody last looked.
    seen: usize,
}

impl Notes {
    /// One more; the same as the last one is only counted.
    pub fn add(&mut self, note: Note) {
        if let Some(last) = self.list.last_mut().filter(|l| l.text == note.text && l.subject == note.subject)
        {
            last.times += 1;
            (last.at, last.remedies) = (note.at, note.remedies);
            return;
        }
        // What helps is offered once.
        let same = |l: &Note| !l.remedies.is_empty() && l.text == note.text && l.subject == note.subject;
        if let Some(place) = self.list.iter().position(same) {
            self.list.remove(place);
            // One that nobody has read yet was not counted.
            self.seen -= usize::from(place < self.seen);
        }
        self.list.push(note);
        if self.list.len() > MOST {
            let gone = self.list.len() - MOST;
            self.list.drain(..gone);
            self.seen = self.seen.saturating_sub(gone);
        }
    }

    /// The newest last.
    pub fn list(&self) -> &[Note] {
        &self.list
    }

    /// Those that nobody looked at yet, and how much the weightiest of them matters.
    pub fn unseen(&self) -> (usize, Option<Weight>) {
        let fresh = &self.list[self.seen.min(self.list.len())..];
        (fresh.len(), fresh.iter().map(|note| note.weight).max())
    }

    /// Somebody has looked.
    pub fn see(&mut self) {
        self.seen = self.list.len();
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// `5 minutes ago`, in a sentence.
pub fn ago(passed: std::time::Duration) -> String {
    match passed.as_secs() / 60 {
        0 => "a moment ago".into(),
        1 => "a minute ago".into(),
        minutes @ 2..=119 => format!("{minutes} minutes ago"),
        minutes if minutes < 48 * 60 => format!("{} hours ago", minutes / 60),
        minutes => format!("{} days ago", minutes / 60 / 24),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_note_again_is_counted_and_old_ones_are_dropped() {
        let mut notes = Notes::default();
        (0..3).for_each(|_| notes.add(Note::new(Weight::Warning, "dust")));
        assert_eq!((notes.list().len(), notes.list()[0].times), (1, 3));
        (0..MOST).for_each(|i| notes.add(Note::new(Weight::Info, i.to_string())));
        assert_eq!(notes.list().len(), MOST);
        assert_eq!(notes.unseen().0, MOST);
        notes.see();
        assert_eq!(notes.unseen(), (0, None));
    }

    #[test]
    fn what_helps_is_offered_once_where_it_was_said_last() {
        let mut notes = Notes::default();
        let gone = || Note::new(Weight::Problem, "gone").with("Again", Remedy::ReadAgain);
        [gone(), Note::new(Weight::Info, "dust"), gone()].into_iter().for_each(|note| notes.add(note));
        let texts: Vec<&str> = notes.list().iter().map(|note| note.text.as_str()).collect();
        assert_eq!(texts, ["dust", "gone"]);
    }

    #[test]
    fn several_errors_are_several_notes() {
        let errors = ["a", "b"].map(|text| Error::Request(text.into())).into();
        let notes = Note::of_error("Opening", &Error::Several(errors));
        assert_eq!(notes.iter().map(|n| n.text.as_str()).collect::<Vec<_>>(), ["Opening: a", "Opening: b"]);
    }
}
