//! Merges: one whose image layer would be mostly empty waits for confirmation, and one that is decided is shown before its
//! layers are built.

use super::PendingMerge;
use crate::state::State;
use crate::state::running::{JobKind, Running};
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_layers::{Faces, LayerIndex};
use quadratura_stacks::decide::{LayerEdit, MergeCost, faces_of_layer};

impl State {
    /// Asks for confirmation of a merge.
    pub fn request_to_merge(&mut self, edit: LayerEdit, cost: MergeCost) {
        self.lists.merging = Some(PendingMerge { edit, cost });
    }

    /// Applies the merge that waits where it is confirmed, and forgets it otherwise.
    pub fn confirm_merge(&mut self, confirmed: bool) {
        if let Some(PendingMerge { edit, .. }) = self.lists.merging.take().filter(|_| confirmed) {
            self.decide(&edit);
        }
    }
}

/// Returns the layers of a stack that contain some of these faces.
fn layers_of(stack: &Stack, merge: &[Faces]) -> Vec<LayerIndex> {
    let concerned = |of: &Faces| {
        merge.iter().any(|faces| {
            faces.object == of.object
                && (of.faces.is_empty() || of.faces.iter().any(|index| faces.holds(&of.object, *index)))
        })
    };
    stack.layer_indices().filter(|layer| faces_of_layer(stack, *layer).iter().any(concerned)).collect()
}

impl Session {
    /// Returns the cost of the image layer that several layers of a photo would merge into; none for fewer than two.
    pub fn merge_cost(&self, photo: PhotoId, layers: &[LayerIndex]) -> Option<MergeCost> {
        let (stack, project) = (self.stack_of(photo)?, self.history.present());
        let own = project.decisions.of(&self.opened.site.photo(photo).name).options;
        MergeCost::new(stack, layers, &own.applied_to(&project.options))
    }

    /// Returns the image layers of a photo's present stack that decided merges will make one of, by merge. There are none
    /// once the stack is built.
    pub fn layers_to_merge(&self, photo: PhotoId, running: &Running) -> Vec<Vec<LayerIndex>> {
        let Some(status) = self.photos.get(photo.index()) else { return Vec::new() };
        // After a decision, the states are looked at again in a moment.
        let is_known = self.pending.invalidation.is_none() && !running.runs(JobKind::Survey);
        let Some(stack) = status.stack.as_ref().filter(|_| !is_known || !status.is_current()) else {
            return Vec::new();
        };
        let name = &self.opened.site.photo(photo).name;
        let merges = self.history.present().decisions.of(name).merge;
        merges.iter().map(|merge| layers_of(stack, merge)).filter(|layers| layers.len() > 1).collect()
    }
}
