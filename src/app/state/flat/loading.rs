//! Results of jobs for the flat views: the photo, its layers, the photo with layers hidden, image layers.

use std::path::PathBuf;
use std::sync::Arc;

use super::layer::LayerKey;
use super::levels::Levels;
use super::slot::ResultSlot;
use super::version::LayersVersion;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_editing::layer_view::LegendEntries;
use quadratura_editing::peel::{PeelOptions, PhotoLayers};
use quadratura_projection::hatching::PixelMask;

/// The number of photos kept in memory: the current one and the previous one.
const MOST_PHOTOS: usize = 2;
/// The number of pictures with layers hidden that are kept: one of 6 megapixels takes 40 MB.
const MOST_PEELED: usize = 6;
/// The number of pictures of image layers that are kept.
const MOST_IMAGE_LAYERS: usize = 6;

/// A photo without some of its front layers.
pub struct PeeledPicture {
    /// The picture.
    pub levels: Levels,
    /// The areas that nothing shows.
    pub hidden: PixelMask,
}

/// The picture of an image layer.
pub struct ImageLayerPicture {
    /// The picture.
    pub levels: Levels,
    /// The areas that the photo does not show.
    pub hidden: PixelMask,
    /// The meaning of its colours.
    pub legend: LegendEntries,
}

/// A version of a photo's layers, and what is taken off.
pub type PeelKey = (LayersVersion, PeelOptions);

/// Results of jobs for the flat views.
pub struct Loading {
    /// The photos, by file.
    pub photos: ResultSlot<PathBuf, Levels>,
    /// The layers of photos.
    pub layers: ResultSlot<LayersVersion, Arc<PhotoLayers>>,
    /// Photos with layers hidden.
    pub peeled: ResultSlot<PeelKey, PeeledPicture>,
    /// Image layers.
    pub image_layers: ResultSlot<LayerKey, ImageLayerPicture>,
}

impl Default for Loading {
    fn default() -> Self {
        Self {
            photos: ResultSlot::new(MOST_PHOTOS),
            layers: ResultSlot::new(MOST_PHOTOS),
            peeled: ResultSlot::new(MOST_PEELED),
            image_layers: ResultSlot::new(MOST_IMAGE_LAYERS),
        }
    }
}

/// The picture of a photo that is drawn, and the areas that nothing shows, where layers are hidden.
pub type ShownPhoto<'a> = (&'a Levels, Option<&'a PixelMask>);

impl Loading {
    /// Returns the layers of a photo, once they are loaded.
    pub fn layers(&self, version: &LayersVersion) -> Option<Arc<PhotoLayers>> {
        self.layers.get(version).cloned()
    }

    /// Returns the photo itself, once it is loaded.
    pub fn photo(&self, session: &Session, photo: PhotoId) -> Option<&Levels> {
        self.photos.get(&session.opened.site.photo(photo).file)
    }

    /// Returns whether a job for the photo view is running.
    pub fn is_busy(&self) -> bool {
        self.photos.is_busy() || self.layers.is_busy() || self.peeled.is_busy()
    }

    /// Returns the requested picture of a photo, or the closest that exists.
    pub fn shown(&self, session: &Session, photo: PhotoId, peeling: &PeelOptions) -> Option<ShownPhoto<'_>> {
        let whole = || self.photo(session, photo).map(|levels| (levels, None));
        let version = LayersVersion::new(session, photo);
        let key = version.map(|version| (version, peeling.clone()));
        let Some(key) = key.filter(|key| self.is_peeled(key)) else { return whole() };
        // The previous picture is shown until the next one is made.
        let previous = || self.peeled.last(|(version, _)| *version == key.0);
        let peeled = self.peeled.get(&key).or_else(previous);
        peeled.map(|picture| (&picture.levels, Some(&picture.hidden))).or_else(whole)
    }

    /// Returns whether the requested picture of a photo is not made yet, and another one is shown in its place.
    pub fn is_behind(&self, session: &Session, photo: PhotoId, peeling: &PeelOptions) -> bool {
        let file = &session.opened.site.photo(photo).file;
        if self.photos.get(file).is_none() {
            return !self.photos.has_failed(file);
        }
        let Some(version) = LayersVersion::new(session, photo) else { return false };
        if self.layers.get(&version).is_none() && !self.layers.has_failed(&version) {
            return peeling.hides();
        }
        let key = (version, peeling.clone());
        self.is_peeled(&key) && self.peeled.get(&key).is_none() && !self.peeled.has_failed(&key)
    }

    /// Returns whether the picture differs from the photo itself.
    pub fn is_peeled(&self, (version, peeling): &PeelKey) -> bool {
        let is_other = |layers: &Arc<PhotoLayers>| {
            (peeling.paint && layers.is_painted()) || (peeling.filling && layers.is_propagated_on())
        };
        peeling.hides() || self.layers.get(version).is_some_and(is_other)
    }

    /// Returns the colour shown at a pixel, R, G, B.
    pub fn colour(
        &self,
        session: &Session,
        photo: PhotoId,
        peeling: &PeelOptions,
        (x, y): (i32, i32),
    ) -> Option<[u8; 3]> {
        let key = LayersVersion::new(session, photo).map(|version| (version, peeling.clone()));
        let peeled = key.filter(|key| self.is_peeled(key)).and_then(|key| self.peeled.get(&key));
        let levels = peeled.map(|peeled| &peeled.levels).or_else(|| self.photo(session, photo))?;
        let picture = &levels[0];
        let [r, g, b, a] = picture.pixels()[picture.rect().index(x, y)?];
        (a > 0).then_some([r, g, b])
    }
}
