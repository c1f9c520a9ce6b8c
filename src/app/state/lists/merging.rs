//! A merge whose image layer would be mostly empty waits for confirmation.

use super::PendingMerge;
use crate::app::state::State;
use crate::layers::LayerIndex;
use crate::recipe::decide::{LayerEdit, MergeCost};
use crate::scene::PhotoId;

impl State {
    /// Returns the cost of the image layer that several layers of a photo would merge into; none for fewer than two.
    pub fn merge_cost(&self, photo: PhotoId, layers: &[LayerIndex]) -> Option<MergeCost> {
        let session = self.session.as_ref()?;
        let (stack, project) = (session.stack_of(photo)?, session.history.present());
        let own = project.decisions.of(&session.opened.site.photo(photo).name).options;
        MergeCost::new(stack, layers, &own.applied_to(&project.options))
    }

    /// Asks for confirmation of a merge.
    pub fn ask_to_merge(&mut self, edit: LayerEdit, cost: MergeCost) {
        self.lists.merging = Some(PendingMerge { edit, cost });
    }

    /// Applies the merge that waits where it is confirmed, and forgets it otherwise.
    pub fn confirm_merge(&mut self, confirmed: bool) {
        if let Some(PendingMerge { edit, .. }) = self.lists.merging.take().filter(|_| confirmed) {
            self.decide(&edit);
        }
    }
}
