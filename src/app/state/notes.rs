//! The messages of the program: problems, and results of actions.

use std::time::SystemTime;

use quadratura_base::error::{Error, Message};
use quadratura_document::masks::MaskChange;
use quadratura_sites::open::UnusableMask;

/// The severity of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// An action has succeeded.
    Info,
    /// Something needs attention; the work continues.
    Warning,
    /// An action has failed.
    Problem,
}

/// A remedy that a note offers by click.
#[derive(Debug, Clone, PartialEq)]
pub enum NoteRemedy {
    /// Reads the site again.
    ReadAgain,
    /// Replaces a mask that cannot be used by another one, or removes it.
    SetMask(Box<MaskChange>),
    /// Chooses a file for a photo's mask that cannot be used.
    ChooseMask(Box<UnusableMask>),
}

/// A message.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The severity.
    pub weight: Weight,
    /// The photo, file or object that the note is about; empty for the whole project.
    pub subject: String,
    /// The text: a sentence or two.
    pub text: Message,
    /// The time of the note.
    pub at: SystemTime,
    /// The number of times that the note was repeated in a row.
    pub times: u32,
    /// The remedies, each with a short label.
    pub remedies: Vec<(String, NoteRemedy)>,
}

impl Note {
    /// Makes a note about the whole project.
    pub fn new(weight: Weight, text: impl Into<Message>) -> Self {
        Self::about(weight, "", text)
    }

    /// Makes a note about one photo, file or object.
    pub fn about(weight: Weight, subject: impl Into<String>, text: impl Into<Message>) -> Self {
        Self {
            weight,
            subject: subject.into(),
            text: text.into(),
            at: SystemTime::now(),
            times: 1,
            remedies: Vec::new(),
        }
    }

    /// Adds a remedy to the note.
    pub fn with(mut self, words: impl Into<String>, remedy: NoteRemedy) -> Self {
        self.remedies.push((words.into(), remedy));
        self
    }

    /// Appends a sentence to the note.
    pub fn and(mut self, more: &str) -> Self {
        self.text = self.text.and(more);
        self
    }

    /// Makes the notes for an error while `doing` something: one for each problem.
    pub fn of_error(doing: &str, error: &Error) -> Vec<Self> {
        match error {
            Error::Several(errors) => errors.iter().flat_map(|error| Self::of_error(doing, error)).collect(),
            error => {
                let text = Message::from(format!("{doing}: ")).and(error.message());
                vec![Self::new(Weight::Problem, text)]
            }
        }
    }
}

/// The number of notes that are kept; older ones have been read.
const MOST: usize = 500;

/// The list of notes, the newest last.
#[derive(Debug, Default)]
pub struct NoteLog {
    list: Vec<Note>,
    /// The number of notes that the user has seen.
    seen: usize,
}

impl NoteLog {
    /// Adds a note; a repetition of the last one is only counted.
    pub fn add(&mut self, note: Note) {
        if let Some(last) = self.list.last_mut().filter(|l| l.text == note.text && l.subject == note.subject)
        {
            last.times += 1;
            (last.at, last.remedies) = (note.at, note.remedies);
            return;
        }
        // A remedy is offered once.
        let same = |l: &Note| !l.remedies.is_empty() && l.text == note.text && l.subject == note.subject;
        if let Some(index) = self.list.iter().position(same) {
            self.list.remove(index);
            // A note that the user has not seen is not counted.
            self.seen -= usize::from(index < self.seen);
        }
        self.list.push(note);
        if self.list.len() > MOST {
            let gone = self.list.len() - MOST;
            self.list.drain(..gone);
            self.seen = self.seen.saturating_sub(gone);
        }
    }

    /// Returns the notes, the newest last.
    pub fn list(&self) -> &[Note] {
        &self.list
    }

    /// Returns the number of unseen notes, and their highest severity.
    pub fn unseen(&self) -> (usize, Option<Weight>) {
        let fresh = &self.list[self.seen.min(self.list.len())..];
        (fresh.len(), fresh.iter().map(|note| note.weight).max())
    }

    /// Marks all notes as seen.
    pub fn see(&mut self) {
        self.seen = self.list.len();
    }

    /// Removes all notes.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Makes the note about files that have changed on disk: `The model and photos have changed on disk …`
pub fn changed(parts: &[&str]) -> Note {
    let (last, first) = parts.split_last().unwrap_or((&"something", &[]));
    let parts =
        if first.is_empty() { (*last).to_owned() } else { format!("{} and {last}", first.join(", ")) };
    Note::new(Weight::Warning, format!("Files have changed on disk: {parts}."))
}

/// Returns notes about plants whose files have changed on disk, by these: those that are there, and those that are missing.
pub fn plants_changed(there: &[String], missing: &[String]) -> Vec<Note> {
    let named = |files: &[String]| match files {
        [file] => format!("file {file}"),
        files => format!("files {}", files.join(", ")),
    };
    let changed = (!there.is_empty()).then(|| {
        let (files, have) = (named(there), if there.len() == 1 { "has" } else { "have" });
        let text =
            format!("Plants of the {files} {have} changed on disk. Their trees are shown as they are now.");
        Note::new(Weight::Info, text)
    });
    let lost = (!missing.is_empty()).then(|| {
        let (are, these) = if missing.len() == 1 { ("is", "this plant") } else { ("are", "these plants") };
        let text = format!("The {} {are} missing. Trees of {these} are not shown.", named(missing));
        Note::new(Weight::Warning, text)
    });
    changed.into_iter().chain(lost).collect()
}

/// Formats a time that has passed, for use in a sentence: `5 minutes ago`.
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
        let mut notes = NoteLog::default();
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
        let mut notes = NoteLog::default();
        let gone = || Note::new(Weight::Problem, "gone").with("Again", NoteRemedy::ReadAgain);
        [gone(), Note::new(Weight::Info, "dust"), gone()].into_iter().for_each(|note| notes.add(note));
        let texts: Vec<String> = notes.list().iter().map(|note| note.text.to_string()).collect();
        assert_eq!(texts, ["dust", "gone"]);
    }

    #[test]
    fn several_errors_are_several_notes() {
        let errors = ["a", "b"].map(|text| Error::Request(text.into())).into();
        let notes = Note::of_error("Opening", &Error::Several(errors));
        assert_eq!(
            notes.iter().map(|n| n.text.to_string()).collect::<Vec<_>>(),
            ["Opening: a", "Opening: b"]
        );
    }

    #[test]
    fn plants_that_have_changed_and_plants_that_are_missing_are_different_notes() {
        let texts = |there: &[&str], missing: &[&str]| {
            let files = |files: &[&str]| files.iter().map(|file| (*file).to_owned()).collect::<Vec<_>>();
            let notes = plants_changed(&files(there), &files(missing));
            notes.iter().map(|note| (note.weight, note.text.to_string())).collect::<Vec<_>>()
        };
        let changed =
            "Plants of the files a.plant, b.glb have changed on disk. Their trees are shown as they are now.";
        let lost = "The file c.plant is missing. Trees of this plant are not shown.";
        assert_eq!(texts(&["a.plant", "b.glb"], &[]), [(Weight::Info, changed.to_owned())]);
        assert_eq!(texts(&[], &["c.plant"]), [(Weight::Warning, lost.to_owned())]);
        assert_eq!(texts(&["a.plant"], &["c.plant"]).len(), 2);
    }
}
