//! Suggestions: transient objects, which appear in one photo only.

use std::cell::RefCell;
use std::sync::Arc;

use crate::state::running::JobId;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::PhotoId;
use quadratura_document::masks::MaskOrigin;
use quadratura_sites::masks::MaskEdit;
use quadratura_stacks::masks::suggest::MaskSuggestion;

/// The outcome of a search that found nothing.
pub const NOTHING: &str = "No transient objects were found.";

/// The likelihood from which on an object is very likely.
const VERY_LIKELY: f64 = 0.75;

/// The suggestions of the project.
pub struct Suggested {
    /// Whether suggestions are drawn over photos.
    pub shown: bool,
    /// The suggestion under the pointer.
    pub pointed: Option<u32>,
    /// The outcome of the last search, until the user has seen it.
    pub outcome: Option<TransientSearch>,
    /// The suggestions that are offered, masked or not.
    pub list: Arc<Vec<ShownSuggestion>>,
    /// Whether what is hardly an object is offered, too.
    with_unlikely: bool,
    /// All that was found.
    found: Vec<ShownSuggestion>,
    /// Whether the suggestions of earlier runs were loaded.
    pub read: bool,
    /// The job that searches.
    pub looking: Option<JobId>,
    /// The suggestions dismissed while a search runs.
    pub dismissed: Vec<u32>,
    open: RefCell<Option<Open>>,
}

impl Default for Suggested {
    fn default() -> Self {
        Self {
            shown: true,
            pointed: None,
            outcome: None,
            list: Arc::default(),
            with_unlikely: false,
            found: Vec::new(),
            read: false,
            looking: None,
            dismissed: Vec::new(),
            open: RefCell::default(),
        }
    }
}

/// The outcome of a search.
pub struct TransientSearch {
    /// The names of photos that were searched and have no transient objects.
    pub without: Vec<String>,
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
        match self.it.likelihood {
            likelihood if likelihood >= VERY_LIKELY => "very likely",
            _ if self.it.is_likely() => "likely",
            _ => "unlikely",
        }
    }

    /// Returns the edit that masks it.
    pub fn edit(&self) -> MaskEdit {
        let masked = Spans::clone(&self.masked);
        MaskEdit::Add { photo: self.it.photo.clone(), from: MaskOrigin::Suggested, masked }
    }
}

/// The suggestions for a photo that are not masked yet.
struct Open {
    photo: PhotoId,
    list: Arc<Vec<ShownSuggestion>>,
    covered: Arc<Spans>,
    shown: Arc<Vec<ShownSuggestion>>,
}

impl Suggested {
    /// Returns the number of suggestions that are offered in all photos, masked or not.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Replaces the suggestions by these, likely or not.
    pub fn put(&mut self, found: Vec<ShownSuggestion>) {
        self.found = found;
        self.list_again();
    }

    /// Removes suggestions, by number.
    pub fn remove(&mut self, numbers: &[u32]) {
        self.found.retain(|shown| !numbers.contains(&shown.it.number));
        self.list_again();
    }

    /// Returns whether what is hardly an object is offered, too.
    pub fn offers_unlikely(&self) -> bool {
        self.with_unlikely
    }

    /// Offers what is hardly an object, or leaves it out.
    pub fn offer_unlikely(&mut self, with_unlikely: bool) {
        self.with_unlikely = with_unlikely;
        self.list_again();
    }

    /// Returns the number of findings in a photo, by name, that are hardly objects.
    pub fn unlikely_in(&self, name: &str) -> usize {
        self.found.iter().filter(|shown| shown.it.photo == name && !shown.it.is_likely()).count()
    }

    fn list_again(&mut self) {
        let offered = self.found.iter().filter(|shown| self.with_unlikely || shown.it.is_likely());
        self.list = Arc::new(offered.cloned().collect());
        (self.open, self.pointed) = (RefCell::default(), None);
    }

    /// Returns the suggestions for a photo, by index and name, that are not covered by its masks. They are found once
    /// for each list and each state of the masks.
    pub fn open_in(&self, photo: PhotoId, name: &str, covered: Arc<Spans>) -> Arc<Vec<ShownSuggestion>> {
        let same = |open: &&Open| {
            open.photo == photo && Arc::ptr_eq(&open.list, &self.list) && Arc::ptr_eq(&open.covered, &covered)
        };
        if let Some(open) = self.open.borrow().as_ref().filter(same) {
            return open.shown.clone();
        }
        let is_open =
            |shown: &&ShownSuggestion| shown.it.photo == *name && !shown.masked.minus(&covered).is_empty();
        let shown: Arc<Vec<ShownSuggestion>> = Arc::new(self.list.iter().filter(is_open).cloned().collect());
        let list = self.list.clone();
        *self.open.borrow_mut() = Some(Open { photo, list, covered, shown: shown.clone() });
        shown
    }

    /// Returns the suggestions of the photo whose open ones were asked for last, where it is this one.
    pub fn last_open_in(&self, photo: PhotoId) -> Option<Arc<Vec<ShownSuggestion>>> {
        self.open.borrow().as_ref().filter(|open| open.photo == photo).map(|open| open.shown.clone())
    }
}
