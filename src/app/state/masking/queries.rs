//! Questions about masks, which the whole state answers.

use std::sync::Arc;

use super::Masking;
use super::suggested::{NOTHING, ShownSuggestion};
use crate::state::State;
use crate::state::notes::NoteRemedy;
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_document::masks::Mask;

impl State {
    /// Returns the size of the selected photo, in pixels.
    pub fn selected_photo_size(&self) -> Option<[u32; 2]> {
        let photo = self.selected_photo()?;
        let camera = &self.session.as_ref()?.opened.site.photo(photo).camera;
        Some([camera.width, camera.height])
    }

    /// Returns the numbers of the suggestions for the selected photo that are not masked.
    pub fn open_suggestions(&self) -> Vec<u32> {
        let numbers = |list: &[ShownSuggestion]| list.iter().map(|shown| shown.it.number).collect();
        let open = self.selected_photo().and_then(|photo| self.masking.suggested.last_open_in(photo));
        if let Some(open) = open {
            return numbers(&open);
        }
        // Without the view's list all are returned: masking a masked suggestion again changes nothing.
        let photo = self.selected_photo_name();
        let of_photo = |shown: &&ShownSuggestion| Some(&shown.it.photo) == photo.as_ref();
        self.masking.suggested.list.iter().filter(of_photo).map(|shown| shown.it.number).collect()
    }

    /// Returns the numbers of all suggestions.
    pub fn all_suggestions(&self) -> Vec<u32> {
        self.masking.suggested.list.iter().map(|shown| shown.it.number).collect()
    }
}

impl Masking {
    /// Returns the masked pixels of a photo as far as they are loaded, with the edits in the queue applied.
    pub fn covered(&self, session: &Session, photo: PhotoId) -> Option<Arc<Spans>> {
        let photo = &session.opened.site.photos.get(photo.index())?.name;
        let masks = session.history.present().masks.of(photo);
        Some(self.cache.covered(photo, masks, &self.keeping))
    }

    /// Returns the suggestions for a photo that are not masked. A masked one returns when its mask is undone.
    pub fn suggestions_of(&self, session: &Session, photo: PhotoId) -> Arc<Vec<ShownSuggestion>> {
        let Some(covered) = self.covered(session, photo) else { return Arc::default() };
        self.suggested.open_in(photo, &session.opened.site.photo(photo).name, covered)
    }

    /// Returns the number of findings in a photo that are hardly objects.
    pub fn unlikely_in(&self, session: &Session, photo: PhotoId) -> usize {
        self.suggested.unlikely_in(&session.opened.site.photo(photo).name)
    }

    /// Returns the suggestion at a pixel of a photo.
    pub fn suggestion_at(&self, session: &Session, photo: PhotoId, (x, y): (i32, i32)) -> Option<u32> {
        if !self.suggested.shown {
            return None;
        }
        let open = self.suggestions_of(session, photo);
        // The smallest is returned, so that a suggestion within another can be clicked.
        let at = open.iter().filter(|shown| shown.masked.holds(x, y));
        at.min_by_key(|shown| shown.it.pixels).map(|shown| shown.it.number)
    }

    /// Describes the last search in a photo, until the user has seen it; none where all suggestions are masked or
    /// dismissed.
    pub fn outcome_in(&self, session: &Session, photo: PhotoId) -> Option<String> {
        let outcome = self.suggested.outcome.as_ref()?;
        let name = &session.opened.site.photos.get(photo.index())?.name;
        if outcome.without.contains(name) {
            return Some(NOTHING.into());
        }
        match self.suggestions_of(session, photo).len() {
            0 => None,
            1 => Some("One transient object was found in this photo. A click on it masks it.".into()),
            many => {
                Some(format!("{many} transient objects were found in this photo. A click on one masks it."))
            }
        }
    }
}

impl NoteRemedy {
    /// Returns whether the remedy still applies: the mask may have been replaced.
    pub fn applies(&self, session: Option<&Session>) -> bool {
        let Some(session) = session else { return matches!(self, NoteRemedy::ReadAgain) };
        let stands =
            |photo: &str, mask: &Mask| session.history.present().masks.find(photo, &mask.from) == Some(mask);
        match self {
            // Where reloading has to wait, the click reports the reason.
            NoteRemedy::ReadAgain => true,
            NoteRemedy::SetMask(change) => {
                change.before.as_ref().is_some_and(|mask| stands(&change.photo, mask))
            }
            NoteRemedy::ChooseMask(it) => stands(&it.photo.name, &it.mask),
        }
    }
}

impl Session {
    /// Returns the token of the selected image layer, if it is one of this photo with a matte: the matte brush means that one.
    pub fn matte_layer(&self, selection: Selection, photo: PhotoId) -> Option<String> {
        let Selection::Layer { photo: of, layer } = selection else { return None };
        let stack = self.stack_of(photo).filter(|_| of == photo)?;
        let layer = stack.image_layers.get(layer.index())?;
        layer.fill.as_ref().filter(|fill| fill.matte_file.is_some()).map(|_| layer.id.clone())
    }
}

/// Returns whether a stack has an image layer with a matte.
pub fn has_matte(stack: &Stack) -> bool {
    let mut fills = stack.image_layers.iter().filter_map(|layer| layer.fill.as_ref());
    fills.any(|fill| fill.matte_file.is_some())
}
