//! Facts about the selection that are looked up once and kept until stacks or decisions change.

use std::sync::Arc;

use super::session::Session;
use quadratura_base::scene::{FaceId, ObjectId};
use quadratura_document::{Project, Stack};
use quadratura_stacks::decide::FaceInPhotos;

/// Facts about the selection, cached until stacks or decisions change.
#[derive(Default)]
pub struct Inspect {
    pub(super) face: Option<(FaceId, FactInputs, FaceInPhotos)>,
    pub(super) object: Option<(ObjectId, FactInputs, Vec<u32>)>,
}

impl Inspect {
    /// Returns how photos see a face, once it was looked up.
    pub fn photos_of_face(&self, face: FaceId) -> Option<&FaceInPhotos> {
        self.face.as_ref().filter(|(of, ..)| *of == face).map(|(.., found)| found)
    }

    /// Returns the number of photos that show each face of an object; empty until it was looked up.
    pub fn photos_of_object(&self, object: ObjectId) -> &[u32] {
        self.object.as_ref().filter(|(of, ..)| *of == object).map_or(&[], |(.., found)| found)
    }
}

/// The inputs that the cached facts depend on.
#[derive(Clone)]
pub(super) struct FactInputs {
    stacks: Vec<Option<Arc<Stack>>>,
    project: Arc<Project>,
}

impl FactInputs {
    pub(super) fn from_session(session: &Session) -> Self {
        let stacks = session.photos.iter().map(|photo| photo.stack.clone()).collect();
        Self { stacks, project: session.history.present().clone() }
    }

    pub(super) fn is_of(&self, session: &Session) -> bool {
        let same = |a: &Option<Arc<Stack>>, b: &Option<Arc<Stack>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let mut stacks = self.stacks.iter().zip(&session.photos);
        Arc::ptr_eq(&self.project, session.history.present())
            && self.stacks.len() == session.photos.len()
            && stacks.all(|(stack, photo)| same(stack, &photo.stack))
    }
}
