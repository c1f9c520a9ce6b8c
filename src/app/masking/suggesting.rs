//! Transient objects, which appear in one photo only: found by a job, shown with numbers, masked by a click.

use std::path::Path;
use std::sync::Arc;

use crate::app::masking::keeping::MaskWork;
use crate::app::masking::keeping::queue_mask;
use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::panes::Pane;
use crate::app::state::running::{JobId, JobKind};
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::document::masks::MaskOrigin;
use crate::error::Result;
use crate::geometry::Spans;
use crate::recipe::budget::default_memory;
use crate::recipe::masks::MaskEdit;
use crate::recipe::masks::suggest::{MaskSuggestion, dismiss, pixels, suggest, suggestions};
use crate::task::Task;

/// The mean differences, in natural logarithms of light, above which an object is very likely, and likely, transient: a
/// factor of 2.5 and of 1.8.
const VERY_LIKELY: f64 = 0.9;
const LIKELY: f64 = 0.6;

/// The suggestions of the project.
pub struct Suggested {
    /// Whether suggestions are drawn over photos.
    pub shown: bool,
    /// The suggestion under the pointer.
    pub pointed: Option<u32>,
    /// The outcome of the last search, until the user has seen it.
    outcome: Option<SearchOutcome>,
    list: Arc<Vec<ShownSuggestion>>,
    /// Whether the suggestions of earlier runs were loaded.
    read: bool,
    looking: Option<JobId>,
    /// The suggestions dismissed while a search runs.
    dismissed: Vec<u32>,
    open: Option<Open>,
}

impl Default for Suggested {
    fn default() -> Self {
        Self {
            shown: true,
            pointed: None,
            outcome: None,
            list: Arc::default(),
            read: false,
            looking: None,
            dismissed: Vec::new(),
            open: None,
        }
    }
}

/// The outcome of a search.
struct SearchOutcome {
    /// The names of photos that were searched and have no transient objects.
    without: Vec<String>,
}

/// A suggestion as it is shown.
#[derive(Clone)]
pub struct ShownSuggestion {
    /// The suggestion.
    pub it: MaskSuggestion,
    /// The pixels that would be masked.
    pub masked: Arc<Spans>,
}

impl ShownSuggestion {
    /// Returns the confidence in words.
    pub fn confidence(&self) -> &'static str {
        match self.it.score {
            score if score >= VERY_LIKELY => "very likely",
            score if score >= LIKELY => "likely",
            _ => "perhaps",
        }
    }

    fn edit(&self) -> MaskEdit {
        let masked = Spans::clone(&self.masked);
        MaskEdit::Add { photo: self.it.photo.clone(), from: MaskOrigin::Suggested, masked }
    }
}

/// The suggestions for a photo that are not masked yet.
struct Open {
    photo: usize,
    list: Arc<Vec<ShownSuggestion>>,
    covered: Arc<Spans>,
    shown: Arc<Vec<ShownSuggestion>>,
}

impl Suggested {
    /// Returns the number of suggestions in all photos, masked or not.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    fn put(&mut self, list: Vec<ShownSuggestion>) {
        (self.list, self.open, self.pointed) = (Arc::new(list), None, None);
    }
}

impl State {
    /// Returns the suggestions for a photo that are not masked. A masked one returns when its mask is undone.
    pub fn suggestions_of(&mut self, photo: usize) -> Arc<Vec<ShownSuggestion>> {
        let Some(covered) = self.covered(photo) else { return Arc::default() };
        let list = self.masking.suggested.list.clone();
        let same = |open: &&Open| {
            open.photo == photo && Arc::ptr_eq(&open.list, &list) && Arc::ptr_eq(&open.covered, &covered)
        };
        if let Some(open) = self.masking.suggested.open.as_ref().filter(same) {
            return open.shown.clone();
        }
        let Some(session) = &self.session else { return Arc::default() };
        let name = &session.opened.site.photos[photo].name;
        let is_open =
            |shown: &&ShownSuggestion| shown.it.photo == *name && !shown.masked.minus(&covered).is_empty();
        let shown: Arc<Vec<ShownSuggestion>> = Arc::new(list.iter().filter(is_open).cloned().collect());
        self.masking.suggested.open = Some(Open { photo, list, covered, shown: shown.clone() });
        shown
    }

    /// Returns the suggestion at a pixel of a photo.
    pub fn suggestion_at(&mut self, photo: usize, (x, y): (i32, i32)) -> Option<u32> {
        if !self.masking.suggested.shown {
            return None;
        }
        let open = self.suggestions_of(photo);
        // The smallest is returned, so that a suggestion within another can be clicked.
        let at = open.iter().filter(|shown| shown.masked.holds(x, y));
        at.min_by_key(|shown| shown.it.pixels).map(|shown| shown.it.number)
    }

    fn transients_found(&mut self, folder: &Path, looked_at: &[String], mut list: Vec<ShownSuggestion>) {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == folder) else { return };
        let is_new = |photo: &String| looked_at.is_empty() || looked_at.contains(photo);
        // These were dismissed while the search ran.
        let gone = std::mem::take(&mut self.masking.suggested.dismissed);
        list.retain(|shown| is_new(&shown.it.photo) || !gone.contains(&shown.it.number));
        let names = session.opened.site.photos.iter().map(|photo| &photo.name);
        let has_none = |name: &&String| list.iter().all(|shown| shown.it.photo != **name);
        let without = names.filter(|name| is_new(name)).filter(has_none).cloned().collect();
        let new = list.iter().filter(|shown| is_new(&shown.it.photo));
        let mut photos: Vec<&str> = new.map(|shown| shown.it.photo.as_str()).collect();
        let found = photos.len();
        photos.sort_unstable();
        photos.dedup();
        let text = match found {
            0 => NOTHING.to_owned(),
            1 => format!("One thing is in {} alone. A click on it masks it.", photos[0]),
            many => format!(
                "{many} things are in one photo alone, {}. A click on one masks it.",
                in_short(&photos)
            ),
        };
        self.masking.suggested.put(list);
        self.masking.suggested.shown = true;
        self.masking.suggested.outcome = Some(SearchOutcome { without });
        self.tell(Note::new(Weight::Info, text));
    }

    /// Describes the last search in a photo, until the user has seen it; none where all suggestions are masked or
    /// dismissed.
    pub fn outcome_in(&mut self, photo: usize) -> Option<String> {
        let outcome = self.masking.suggested.outcome.as_ref()?;
        let name = &self.session.as_ref()?.opened.site.photos.get(photo)?.name;
        if outcome.without.contains(name) {
            return Some(NOTHING.into());
        }
        match self.suggestions_of(photo).len() {
            0 => None,
            1 => Some("One thing is in this photo alone. A click on it masks it.".into()),
            many => Some(format!("{many} things are in this photo alone. A click on one masks it.")),
        }
    }

    /// Marks the outcome as seen.
    pub fn forget_outcome(&mut self) {
        self.masking.suggested.outcome = None;
    }

    /// Returns the numbers of the suggestions for the selected photo that are not masked.
    pub fn open_suggestions(&self) -> Vec<u32> {
        let photo = self.selected_photo_name();
        let of_photo = |shown: &&ShownSuggestion| Some(&shown.it.photo) == photo.as_ref();
        // Without the view's list all are returned: masking a masked suggestion again changes nothing.
        match self.masking.suggested.open.as_ref().filter(|open| Some(open.photo) == self.selected_photo()) {
            Some(open) => open.shown.iter().map(|shown| shown.it.number).collect(),
            None => {
                self.masking.suggested.list.iter().filter(of_photo).map(|shown| shown.it.number).collect()
            }
        }
    }

    /// Returns the numbers of all suggestions.
    pub fn all_suggestions(&self) -> Vec<u32> {
        self.masking.suggested.list.iter().map(|shown| shown.it.number).collect()
    }

    /// Dismisses suggestions, by number.
    pub fn dismiss_suggestions(&mut self, numbers: &[u32]) {
        let Some(session) = &self.session else { return };
        let list = self.masking.suggested.list.iter();
        let rest = list.filter(|shown| !numbers.contains(&shown.it.number)).cloned().collect();
        let dismissed = dismiss(&session.folder, numbers);
        self.masking.suggested.put(rest);
        if self.running.runs(JobKind::Suggest) {
            self.masking.suggested.dismissed.extend(numbers);
        }
        if let Err(error) = dismissed {
            self.tell(Note::new(Weight::Warning, error.to_string()));
        }
    }
}

/// Starts the search for transient objects in these photos, or in all where the list is empty.
pub fn look_for_transients(state: &mut State, work: &mut Work, photos: Vec<String>) {
    let Some(session) = &state.session else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let job = work.jobs.start(
        &mut state.running,
        JobKind::Suggest,
        "Looking for what only one photo shows",
        move |task| {
            let found = suggest(&folder, &opened, &photos, default_memory(), task)?;
            let list = shown(&folder, found.list, task)?;
            Ok(arrival(move |state| state.transients_found(&folder, &photos, list)))
        },
    );
    state.masking.suggested.looking = Some(job);
    state.masking.suggested.dismissed.clear();
    state.panes.show(Pane::Photo);
}

/// Loads the suggestions of earlier runs, once.
pub fn want_suggestions(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if std::mem::replace(&mut state.masking.suggested.read, true) {
        return;
    }
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Reading suggestions", move |task| {
        // There is no list, or it has an unknown format: a new search replaces it.
        let list = suggestions(&folder).and_then(|found| shown(&folder, found.list, task));
        Ok(arrival(move |state| {
            let same = state.session.as_ref().is_some_and(|session| session.folder == folder);
            if let (Ok(list), true) = (list, same && state.masking.suggested.looking.is_none()) {
                state.masking.suggested.put(list);
            }
        }))
    });
}

/// Masks suggestions by their numbers, as one step.
pub fn accept_suggestions(state: &mut State, work: &mut Work, numbers: &[u32]) {
    let list = state.masking.suggested.list.clone();
    let meant: Vec<&ShownSuggestion> =
        list.iter().filter(|shown| numbers.contains(&shown.it.number)).collect();
    let name = match meant[..] {
        [] => return,
        [one] => format!("mask of {} by suggestion {}", one.it.photo, one.it.number),
        _ => format!("mask by {} suggestions", meant.len()),
    };
    queue_mask(
        state,
        work,
        name,
        MaskWork::Edits(Arc::new(meant.into_iter().map(ShownSuggestion::edit).collect())),
    );
}

const NOTHING: &str = "Nothing was found that the other photos do not show, too.";

/// Formats the first names of many photos.
fn in_short(photos: &[&str]) -> String {
    match photos {
        [one] => format!("in {one}"),
        [one, other] => format!("in {one} and {other}"),
        [one, rest @ ..] => format!("in {one} and {} other photos", rest.len()),
        [] => String::new(),
    }
}

fn shown(folder: &Path, list: Vec<MaskSuggestion>, task: &Task) -> Result<Vec<ShownSuggestion>> {
    let read = |it: MaskSuggestion| {
        task.go_on()?;
        Ok(ShownSuggestion { masked: Arc::new(pixels(folder, &it)?), it })
    };
    list.into_iter().map(read).collect()
}
