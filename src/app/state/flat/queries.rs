//! Questions about the flat views.

use super::layer::{Aspect, LayerKey, LayerPane};
use super::photo::Pointed;
use super::version::LayersVersion;
use super::{FlatViews, Switches};
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::ImageLayer;
use quadratura_editing::layer_view::LayerViewContent;
use quadratura_editing::peel::PeelOptions;

impl FlatViews {
    /// Returns the layer that the view of an image layer shows, if it exists.
    pub fn looked_at_layer(&self, session: &Session, pane: &LayerPane) -> Option<(LayerKey, ImageLayer)> {
        let (photo, index) = pane.layer?;
        let version = LayersVersion::new(session, photo)?;
        let layer = version.stack.image_layers.get(index.index())?.clone();
        let switches = &self.switches;
        let look = match pane.aspect {
            Aspect::Pixels => LayerViewContent::Pixels { filling: switches.filling, paint: switches.paint },
            Aspect::Confidence => LayerViewContent::Confidence,
            Aspect::Provenance => LayerViewContent::Provenance,
        };
        Some(((version, index, look), layer))
    }

    /// Returns what the photo view leaves out of a photo, without the front `hidden_layers`.
    pub fn peeling(&self, session: &Session, photo: PhotoId, hidden_layers: u32) -> PeelOptions {
        let Switches { filling, paint, .. } = self.switches;
        let stack = session.stack_of(photo);
        let opacities = stack.map(|stack| self.layer_views.drawn(photo, stack)).unwrap_or_default();
        PeelOptions { hidden_layers, filling, paint, opacities }
    }

    /// Returns what a pixel of a photo shows, without the front `hidden_layers`; none outside of the photo.
    pub fn pointed_in_photo(
        &self,
        session: &Session,
        photo: PhotoId,
        pixel: (i32, i32),
        hidden_layers: u32,
    ) -> Option<Pointed> {
        let camera = &session.opened.site.photos.get(photo.index())?.camera;
        let inside = |at: i32, size: u32| at >= 0 && (at as u32) < size;
        if !inside(pixel.0, camera.width) || !inside(pixel.1, camera.height) {
            return None;
        }
        let loading = &self.loading;
        let version = LayersVersion::new(session, photo);
        let layers = version.as_ref().and_then(|version| loading.layers(version));
        let peeling = self.peeling(session, photo, hidden_layers);
        let hits = layers.map(|layers| layers.at(pixel.0, pixel.1, &peeling)).unwrap_or_default();
        let colour = loading.colour(session, photo, &peeling, pixel);
        Some(Pointed { pixel, colour, hits, version })
    }
}
