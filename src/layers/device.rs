//! What draws views of a site with its trees, and what makes such renderers: a device, or one that stands in for it.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_foliage::PlacedTrees;
use quadratura_projection::{SiteContent, SiteRenderer, TextureOptions};

/// A renderer of a site and of the trees that stand in it.
pub trait PlantedRenderer: SiteRenderer {
    /// Replaces the trees; `None` for none.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant with too many instances; [`quadratura_base::Error::Gpu`]. The trees before
    /// remain.
    fn set_trees(&mut self, placed: Option<Arc<PlacedTrees>>) -> Result<()>;
}

/// A device that draws sites.
pub trait SiteDevice {
    /// Makes the renderer of a site, without trees, with texture memory of its own.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`].
    fn renderer(&self, site: SiteContent<'_>, textures: TextureOptions) -> Result<Box<dyn PlantedRenderer>>;
}

/// Starts a device when something turns out to need one.
pub type StartDevice<'a> = &'a dyn Fn() -> Result<Box<dyn SiteDevice>>;
