//! Questions about masks, which the whole state answers.

use std::sync::Arc;

use super::suggested::{NOTHING, ShownSuggestion};
use crate::state::State;
use crate::state::notes::NoteRemedy;
use crate::state::selection::Selection;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_document::masks::Mask;

impl State {
    /// Returns the token of the selected image layer, if it is one of this photo with a matte: the matte brush means that one.
    pub fn matte_layer(&self, photo: PhotoId) -> Option<String> {
        let Selection::Layer { photo: of, layer } = self.selection.main else { return None };
        let stack = self.session.as_ref()?.stack_of(photo).filter(|_| of == photo)?;
        let layer = stack.image_layers.get(layer.index())?;
        layer.fill.as_ref().filter(|fill| fill.matte_file.is_some()).map(|_| layer.id.clone())
    }

    /// Returns whether the selected photo has an image layer with a matte.
    pub fn has_matte(&self) -> bool {
        let has_matte = |stack: &Stack| {
            let mut fills = stack.image_layers.iter().filter_map(|layer| layer.fill.as_ref());
            fills.any(|fill| fill.matte_file.is_some())
        };
        self.selected_stack().is_some_and(has_matte)
    }

    /// Returns the size of the selected photo, in pixels.
    pub fn selected_photo_size(&self) -> Option<[u32; 2]> {
        let photo = self.selected_photo()?;
        let camera = &self.session.as_ref()?.opened.site.photo(photo).camera;
        Some([camera.width, camera.height])
    }

    /// Returns the masked pixels of a photo as far as they are loaded, with the edits in the queue applied.
    pub fn covered(&self, photo: PhotoId) -> Option<Arc<Spans>> {
        let session = self.session.as_ref()?;
        let photo = &session.opened.site.photos.get(photo.index())?.name;
        let masks = session.history.present().masks.of(photo);
        Some(self.masking.cache.covered(photo, masks, &self.masking.keeping))
    }

    /// Returns the suggestions for a photo that are not masked. A masked one returns when its mask is undone.
    pub fn suggestions_of(&self, photo: PhotoId) -> Arc<Vec<ShownSuggestion>> {
        let (Some(covered), Some(session)) = (self.covered(photo), &self.session) else {
            return Arc::default();
        };
        self.masking.suggested.open_in(photo, &session.opened.site.photo(photo).name, covered)
    }

    /// Returns the number of findings in a photo that are hardly objects.
    pub fn unlikely_in(&self, photo: PhotoId) -> usize {
        let session = self.session.as_ref();
        session.map_or(0, |it| self.masking.suggested.unlikely_in(&it.opened.site.photo(photo).name))
    }

    /// Returns the suggestion at a pixel of a photo.
    pub fn suggestion_at(&self, photo: PhotoId, (x, y): (i32, i32)) -> Option<u32> {
        if !self.masking.suggested.shown {
            return None;
        }
        let open = self.suggestions_of(photo);
        // The smallest is returned, so that a suggestion within another can be clicked.
        let at = open.iter().filter(|shown| shown.masked.holds(x, y));
        at.min_by_key(|shown| shown.it.pixels).map(|shown| shown.it.number)
    }

    /// Describes the last search in a photo, until the user has seen it; none where all suggestions are masked or
    /// dismissed.
    pub fn outcome_in(&self, photo: PhotoId) -> Option<String> {
        let outcome = self.masking.suggested.outcome.as_ref()?;
        let name = &self.session.as_ref()?.opened.site.photos.get(photo.index())?.name;
        if outcome.without.contains(name) {
            return Some(NOTHING.into());
        }
        match self.suggestions_of(photo).len() {
            0 => None,
            1 => Some("One transient object was found in this photo. A click on it masks it.".into()),
            many => {
                Some(format!("{many} transient objects were found in this photo. A click on one masks it."))
            }
        }
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

    /// Returns whether the remedy still applies: the mask may have been replaced.
    pub fn can_remedy(&self, remedy: &NoteRemedy) -> bool {
        let Some(session) = &self.session else { return matches!(remedy, NoteRemedy::ReadAgain) };
        let stands =
            |photo: &str, mask: &Mask| session.history.present().masks.find(photo, &mask.from) == Some(mask);
        match remedy {
            // Where reloading has to wait, the click reports the reason.
            NoteRemedy::ReadAgain => true,
            NoteRemedy::SetMask(change) => {
                change.before.as_ref().is_some_and(|mask| stands(&change.photo, mask))
            }
            NoteRemedy::ChooseMask(it) => stands(&it.photo.name, &it.mask),
        }
    }
}
