//! What is asked of a filling, and its result.

use std::path::PathBuf;

use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_document::Stack;
use quadratura_document::stack::PropagationEntry;
use quadratura_layers::fill::{FillOptions, FilledRegion};
use quadratura_sites::budget::default_memory;

/// A request to [`super::fill`].
#[derive(Debug, Clone, PartialEq)]
pub struct FillRequest {
    /// The options of the method.
    pub options: FillOptions,
    /// The names of the photos to fill; empty for all.
    pub photos: Vec<String>,
    /// The memory budget in bytes for decoded photos.
    pub memory: u64,
    /// Whether photos with an up-to-date filling are filled again.
    pub force: bool,
    /// Whether earlier versions of stacks are kept, as [`quadratura_io::stack_store::StackStore::keeping_former`] does.
    pub keep_former: bool,
}

/// All photos, a quarter of the available memory, and only what is out of date.
impl Default for FillRequest {
    fn default() -> Self {
        Self {
            options: FillOptions::default(),
            photos: Vec::new(),
            memory: default_memory(),
            force: false,
            keep_former: false,
        }
    }
}

/// The result for one photo.
#[derive(Debug)]
pub struct FilledPhoto {
    /// The photo's name.
    pub photo: String,
    /// The stack with its filling, or the reason why there is none.
    pub stack: Result<Stack>,
    /// Whether the filling was up to date, so that nothing was written.
    pub up_to_date: bool,
    /// Paint that was propagated from other photos to visible texels.
    pub propagated: Vec<PropagationEntry>,
    /// The number of filled texels that were computed anew; the others were taken from the filling before.
    pub anew: u64,
    /// Files that were edited by hand; they were moved to these paths in `inbox/`.
    pub kept: Vec<PathBuf>,
    /// Whether the project's paint has changed since, so that the filling is out of date already.
    pub is_behind: bool,
    /// The texels of `propagated` where it was only reported; empty where they were written.
    pub laid: Vec<FilledRegion>,
}

impl FilledPhoto {
    /// Returns the result for a photo whose filling is up to date.
    pub(super) fn untouched(photo: &Photo, stack: Stack) -> Self {
        let propagated = stack.fill.as_ref().map(|fill| fill.propagated.clone()).unwrap_or_default();
        Self {
            photo: photo.name.clone(),
            stack: Ok(stack),
            up_to_date: true,
            propagated,
            anew: 0,
            kept: Vec::new(),
            is_behind: false,
            laid: Vec::new(),
        }
    }
}
