//! The memory of the view of one image layer.

use super::placement::PlacedView;
use super::version::LayersVersion;
use crate::state::selection::Selection;
use quadratura_base::scene::PhotoId;
use quadratura_editing::layer_view::LayerViewContent;
use quadratura_layers::LayerIndex;

/// The aspect of a layer that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Aspect {
    /// The pixels of the layer.
    #[default]
    Pixels,
    /// The confidence of its texels.
    Confidence,
    /// The provenance of its texels.
    Provenance,
}

/// A layer of a version of a stack, by index, and the look of its picture.
pub type LayerKey = (LayersVersion, LayerIndex, LayerViewContent);

/// State of the view of an image layer that lasts from frame to frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct LayerPane {
    /// The aspect that is shown.
    pub aspect: Aspect,
    /// The photo, and the layer's index in its stack.
    pub layer: Option<(PhotoId, LayerIndex)>,
    /// The placement of the picture.
    pub view: PlacedView,
    /// The pixel under the pointer, in photo pixels.
    pub pixel: Option<(i32, i32)>,
}

impl LayerPane {
    /// Follows the selection: shows a layer that was selected.
    pub fn follow(&mut self, selection: Selection) {
        if let Selection::Layer { photo, layer } = selection
            && self.layer != Some((photo, layer))
        {
            self.layer = Some((photo, layer));
            self.view.fit();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_that_is_selected_is_fitted_once_and_stays_when_something_else_is_selected() {
        let mut pane = LayerPane::default();
        let layer = Selection::Layer { photo: PhotoId(1), layer: LayerIndex(2) };
        pane.follow(layer);
        assert_eq!(pane.layer, Some((PhotoId(1), LayerIndex(2))));
        pane.view.placement.pan(glam::Vec2::X);
        pane.follow(layer);
        pane.follow(Selection::Photo(PhotoId(0)));
        assert!(pane.layer == Some((PhotoId(1), LayerIndex(2))) && !pane.view.placement.is_fitted());
        pane.follow(Selection::Layer { photo: PhotoId(1), layer: LayerIndex(3) });
        assert!(pane.view.placement.is_fitted());
    }
}
