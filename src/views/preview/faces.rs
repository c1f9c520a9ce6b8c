//! Views of chosen faces alone.

use std::collections::BTreeSet;

use super::Preview;
use quadratura_base::error::Result;
use quadratura_base::scene::FaceId;
use quadratura_base::task::Task;
use quadratura_projection::{Sliced, Sources};
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::{Picture, Shot};

impl Preview {
    /// Returns which layer textures texture which faces.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Returns all faces but these.
    pub fn all_but(&self, shown: impl Iterator<Item = FaceId>) -> HiddenFaces {
        let shown: BTreeSet<FaceId> = shown.collect();
        self.site.model.face_ids().filter(|face| !shown.contains(face)).collect()
    }

    /// Draws a view of faces as they are, far backdrops among them, whose place surroundings take in other views.
    ///
    /// # Errors
    /// As [`quadratura_projection::Renders::picture`].
    pub fn picture_of_faces(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        let mut sliced = self.begin_faces(shot, task)?;
        while !self.renderer.advance(&mut sliced, task)? {}
        Ok(sliced.picture())
    }

    /// As [`Self::picture_of_faces`], for a picture that is drawn in slices.
    ///
    /// # Errors
    /// As [`quadratura_projection::Renders::begin`].
    pub fn begin_faces(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        self.make_ready(shot, task)?;
        Ok(self.renderer.begin(shot, task)?.alone_within(&self.textures))
    }
}
