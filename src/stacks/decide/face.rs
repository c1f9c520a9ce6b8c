//! The relation of each photo to one face: whether it textures the face, why not, and what was decided.

use super::state_of_face;
use crate::untextured::{FaceTexture, given};
use quadratura_base::scene::{FaceId, FaceIndex, PhotoId, Site};
use quadratura_document::{Decisions, Element, PhotoDecisions, Stack};

/// The relation of a photo to a face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceInPhoto {
    /// The texture that the photo has for it.
    pub given: FaceTexture,
    /// The decision about the face in this photo, in words; `None` where there is none.
    pub decided: Option<&'static str>,
}

/// The relation of all photos to a face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceInPhotos {
    /// The photos, in the site's order.
    pub photos: Vec<FaceInPhoto>,
    /// The photo to which the face is pinned, which takes precedence wherever it shows the face.
    pub pinned_to: Option<PhotoId>,
}

/// Returns the relation of a site's photos to a face; `stacks` are in their order.
pub fn face_in_photos(
    site: &Site,
    stacks: &[Option<&Stack>],
    decisions: &Decisions,
    face: FaceId,
) -> FaceInPhotos {
    let entry = site.model.face(face);
    let object = site.model.object(entry.object).name.as_str();
    let index = entry.index;
    let names = site.photos.iter().map(|photo| photo.name.as_str());
    let pinned = decisions.pinned(names.clone(), object, index);
    let photo = |(id, name): (PhotoId, &str)| {
        let decided = decisions.of(name);
        let stack = stacks.get(id.index()).copied().flatten();
        let in_stacks = site.model.index_in_stacks(face);
        let given = stack.map_or(FaceTexture::NotBuilt, |stack| given(stack, &decided, object, in_stacks));
        FaceInPhoto { given, decided: state_of_face(&decided, object, index) }
    };
    FaceInPhotos {
        photos: site.photo_ids().zip(names.clone()).map(photo).collect(),
        pinned_to: pinned.and_then(|pinned| site.photo_named(pinned)),
    }
}

/// Returns, for each of an object's faces, how many stacks texture it, without exclusions. Each stack comes with
/// the decisions about its photo.
pub fn photos_of_faces(stacks: &[(&Stack, PhotoDecisions)], object: &str, face_count: usize) -> Vec<u32> {
    let mut counts = vec![0; face_count];
    for (stack, decided) in stacks {
        let elements = stack.visibility_layers.iter().flatten().filter(|element| element.object == object);
        // The rectangle of an impostor stands for all faces.
        let held = |element: &Element| match element.impostor && !element.textured_faces().is_empty() {
            true => FaceIndex::all(face_count).collect(),
            false => element.textured_faces(),
        };
        let mut held: Vec<FaceIndex> = elements.flat_map(held).collect();
        held.sort_unstable();
        held.dedup();
        for index in held.into_iter().filter(|index| !decided.excludes(object, *index)) {
            if let Some(count) = counts.get_mut(index.index()) {
                *count += 1;
            }
        }
    }
    counts
}
