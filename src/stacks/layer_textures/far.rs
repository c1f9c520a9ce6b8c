//! The layers of far backdrops, which views show as surroundings.

use std::borrow::Borrow;
use std::sync::Arc;

use super::LayerTextureFiles;
use crate::far_backdrops::FarBackdrops;
use quadratura_document::Stack;

impl LayerTextureFiles {
    /// Returns the same with the layers of far backdrops as surroundings, of which photos show all that is known: what was filled on
    /// them behind everything is not used, but paint from other photos is.
    pub fn with_far(self, stacks: &[Option<impl Borrow<Stack>>], far: Arc<FarBackdrops>) -> Self {
        if far.is_empty() {
            return self;
        }
        let mut files = self.files.to_vec();
        for file in &mut files {
            let Some(stack) = stacks.get(file.photo.index()).and_then(Option::as_ref) else { continue };
            let stack: &Stack = stack.borrow();
            if stack.shows_only(stack.layer(file.layer), |object| far.contains(object)) {
                file.filled = file.filled.take().filter(|filled| filled.propagated.is_some());
                file.propagated_alone = true;
                file.longest_of_surroundings = Some(stack.photo.width.max(stack.photo.height));
            }
        }
        Self { files: files.into(), far, ..self }
    }
}
