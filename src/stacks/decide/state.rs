//! The effect of decisions on the present stacks and model.

use crate::decide::list::decided;
use quadratura_base::error::{Message, Remedy};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{FaceIndex, Model, Site};
use quadratura_document::{Decisions, PhotoDecisions};
use quadratura_layers::Faces;

/// The word for a photo that may not texture a surface.
pub const EXCLUDED: &str = "excluded";

/// Returns the decision about a face in a photo, in words; `None` where there is none.
pub fn state_of_face(decisions: &PhotoDecisions, object: &str, index: FaceIndex) -> Option<&'static str> {
    if decisions.excludes(object, index) {
        return Some(EXCLUDED);
    }
    decisions.pin.iter().any(|faces| faces.holds(object, index)).then_some("pinned to this photo")
}

/// Returns messages about decisions that refer to missing photos or faces. They are kept, and apply again when
/// these are back.
pub fn stale(decisions: &Decisions, site: &Site) -> Vec<Message> {
    let mut messages = Vec::new();
    for (photo, decisions) in &decisions.photos {
        if !site.photos.iter().any(|known| known.name == *photo) {
            let found = format!("decisions about {photo}, which is not among the photos (");
            let remedy = Remedy::ResetDecisions(photo.clone());
            messages.push((found, remedy, " removes these decisions)").into());
            continue;
        }
        for decided in decided(decisions) {
            for faces in decided.of.iter().filter(|faces| !is_whole(faces, &site.model)) {
                let number = decided.number;
                messages.push(
                    format!("{photo}, decision {number}: the model no longer has all of {faces}").into(),
                );
            }
        }
    }
    messages
}

fn is_whole(faces: &Faces, model: &Model) -> bool {
    let found = faces.in_model(model).len();
    let is_surroundings = faces.object == SURROUNDINGS && faces.faces.is_empty();
    is_surroundings || found > 0 && found >= faces.faces.len()
}
