//! stub
use crate::document::Stack;
use crate::error::Result;
use crate::layers::fill::FillContext;
use crate::layers::matte::Matte;
use crate::recipe::open::Opened;
use crate::scene::PhotoId;
use crate::task::Task;
use std::path::Path;

/// stub
#[derive(Default)]
pub struct SiteMattes {
    of: Vec<Vec<Matte>>,
}
impl SiteMattes {
    /// stub
    pub fn open(
        _: &Path,
        _: &Opened,
        _: &FillContext,
        _: &[Option<Stack>],
        _: u64,
        _: &Task,
    ) -> Result<Self> {
        Ok(Self::default())
    }
    /// stub
    pub fn of(&self, photo: PhotoId) -> &[Matte] {
        self.of.get(photo.index()).map_or(&[], |of| of)
    }
}
