//! How each photo stands to one face: whether it textures it, why not, and what was decided.

use super::state_of_face;
use crate::document::{Decisions, PhotoDecisions, Stack};
use crate::recipe::untextured::{Given, given};
use crate::scene::{FaceId, Site};

/// How a photo stands to a face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceInPhoto {
    /// What it gives.
    pub given: Given,
    /// What was decided about the face in this photo, in words; none where nothing was.
    pub decided: Option<&'static str>,
}

/// How all photos stand to a face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceInPhotos {
    /// In the site's order.
    pub photos: Vec<FaceInPhoto>,
    /// The photo that goes before all others wherever it shows the face.
    pub pinned_to: Option<usize>,
}

/// How the photos of a site stand to a face; `stacks` in their order.
pub fn face_in_photos(
    site: &Site,
    stacks: &[Option<&Stack>],
    decisions: &Decisions,
    face: FaceId,
) -> FaceInPhotos {
    let it = site.model.face(face);
    let (object, index) = (site.model.object(it.object).name.as_str(), it.index);
    let names = site.photos.iter().map(|photo| photo.name.as_str());
    let pinned = decisions.pinned(names.clone(), object, index);
    let photo = |(place, name): (usize, &str)| {
        let decided = decisions.of(name);
        let stack = stacks.get(place).copied().flatten();
        let given = stack.map_or(Given::NotBuilt, |stack| given(stack, &decided, object, index));
        FaceInPhoto { given, decided: state_of_face(&decided, object, index) }
    };
    FaceInPhotos {
        photos: names.clone().enumerate().map(photo).collect(),
        pinned_to: pinned.and_then(|pinned| names.clone().position(|name| name == pinned)),
    }
}

/// How many of the stacks give texture to each face of an object that has so many; what was excluded is not counted.
/// `stacks` with what was decided about their photos.
pub fn photos_of_faces(stacks: &[(&Stack, PhotoDecisions)], object: &str, faces: usize) -> Vec<u32> {
    let mut counts = vec![0; faces];
    for (stack, decided) in stacks {
        let elements = stack.visibility_layers.iter().flatten().filter(|element| element.object == object);
        let mut held: Vec<u32> = elements.flat_map(|element| element.all_faces()).collect();
        held.sort_unstable();
        held.dedup();
        for index in held.into_iter().filter(|index| !decided.excludes(object, *index)) {
            if let Some(count) = counts.get_mut(index as usize) {
                *count += 1;
            }
        }
    }
    counts
}
