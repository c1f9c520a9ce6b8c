//! Versions of a photo's layers, by which results are known to be out of date.

use std::sync::Arc;
use std::time::SystemTime;

use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_io::paint_store::PaintStore;

/// A version of a photo's layers: a stack, with the paint at that time.
#[derive(Debug, Clone)]
pub struct LayersVersion {
    /// The stack that was read.
    pub stack: Arc<Stack>,
    painted: Option<SystemTime>,
}

impl LayersVersion {
    /// Returns the current version of a photo; none before it is built.
    pub fn new(session: &Session, photo: PhotoId) -> Option<Self> {
        let stack = session.stack_of(photo)?.clone();
        Some(Self { stack, painted: PaintStore::new(&session.folder).changed() })
    }
}

impl PartialEq for LayersVersion {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.stack, &other.stack) && self.painted == other.painted
    }
}
