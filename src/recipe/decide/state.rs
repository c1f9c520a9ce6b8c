//! The effect of decisions on the present stacks and model.

use crate::document::stack::{Reason, Untextured};
use crate::document::{Decisions, PhotoDecisions, Stack};
use crate::layers::Faces;
use crate::recipe::decide::list::decided;
use crate::scene::{Model, Site};

/// Returns the faces that a photo could texture and that are excluded.
pub fn excluded(stack: &Stack, decisions: &PhotoDecisions) -> Vec<Untextured> {
    if decisions.exclude.is_empty() {
        return Vec::new();
    }
    let mut found: Vec<(String, u32)> = Vec::new();
    for element in stack.visibility_layers.iter().flatten() {
        let faces = element.all_faces().into_iter().filter(|face| decisions.excludes(&element.object, *face));
        found.extend(faces.map(|face| (element.object.clone(), face)));
    }
    found.sort_unstable();
    found.dedup();
    let is_listed =
        |object: &str, face: u32| stack.untextured.iter().any(|u| u.object == object && u.face == face);
    found.retain(|(object, face)| !is_listed(object, *face));
    let untextured =
        |(object, face)| Untextured { object, face, reason: Reason::Excluded, by: None, at: None };
    found.into_iter().map(untextured).collect()
}

/// Returns the decision about a face in a photo, in words; `None` where there is none.
pub fn state_of_face(decisions: &PhotoDecisions, object: &str, index: u32) -> Option<&'static str> {
    if decisions.excludes(object, index) {
        return Some("excluded");
    }
    decisions.pin.iter().any(|faces| faces.holds(object, index)).then_some("pinned to this photo")
}

/// Returns messages about decisions that refer to missing photos or faces. They are kept, and apply again when
/// these are back.
pub fn strangers(decisions: &Decisions, site: &Site) -> Vec<String> {
    let mut messages = Vec::new();
    for (photo, decisions) in &decisions.photos {
        let remedy = format!("`quadratura decide --photo {photo} --reset` removes these decisions");
        if !site.photos.iter().any(|known| known.name == *photo) {
            messages.push(format!("decisions about {photo}, which is not among the photos ({remedy})"));
            continue;
        }
        for decided in decided(decisions) {
            for faces in decided.of.iter().filter(|faces| !is_whole(faces, &site.model)) {
                let number = decided.number;
                messages.push(format!("{photo}, decision {number}: the model no longer has all of {faces}"));
            }
        }
    }
    messages
}

fn is_whole(faces: &Faces, model: &Model) -> bool {
    let found = faces.in_model(model).len();
    found > 0 && found >= faces.faces.len()
}
