//! The hold that a document in memory has on the files that it names.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// A hold on the files that a document names: they are not deleted while the document, or a copy of it, is in memory. It
/// is no part of the document: it is neither written nor compared. The default holds nothing.
#[derive(Clone, Default)]
pub struct FilesInUse(Option<Arc<dyn Any + Send + Sync>>);

impl FilesInUse {
    /// Makes a hold that lasts as long as `held` is referred to.
    pub fn new(held: Arc<dyn Any + Send + Sync>) -> Self {
        Self(Some(held))
    }

    /// Returns whether both are one hold, of copies of one document.
    pub fn is_that_of(&self, held: &Arc<dyn Any + Send + Sync>) -> bool {
        self.0.as_ref().is_some_and(|own| Arc::ptr_eq(own, held))
    }
}

/// Documents that differ in their holds alone are equal.
impl PartialEq for FilesInUse {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for FilesInUse {}

impl fmt::Debug for FilesInUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "in use" } else { "not held" })
    }
}
