//! The flat views in the window: what they remember is taken out of the state while they are drawn.

use eframe::egui::Ui;

use super::textures::Textures;
use crate::panel::layer::{LayerPaneView, layer_ui};
use crate::panel::photo::view::PhotoView;
use crate::panel::photo::{PhotoMemory, PhotoViewTextures, photo_ui};
use crate::state::State;
use crate::state::request::Request;

/// Draws the view of the photo with its layers.
pub fn photo_view(ui: &mut Ui, state: &mut State, textures: &mut Textures, requests: &mut Vec<Request>) {
    let (mut pane, mut stroke) = (state.flat.photo.clone(), state.masking.stroke.take());
    let mut sizes = state.settings.sizes;
    let memory = PhotoMemory { pane: &mut pane, stroke: &mut stroke, sizes: &mut sizes };
    let mut drawn = PhotoViewTextures {
        photos: &textures.photos,
        flat: &mut textures.flat,
        masks: &mut textures.masks,
        selected_hidden: &mut textures.selected_hidden,
    };
    photo_ui(ui, &PhotoView::new(state), memory, &mut drawn, requests);
    (state.flat.photo, state.masking.stroke, state.settings.sizes) = (pane, stroke, sizes);
}

/// Draws the view of one image layer.
pub fn layer_view(ui: &mut Ui, state: &mut State, textures: &mut Textures, requests: &mut Vec<Request>) {
    let mut pane = state.flat.layer;
    layer_ui(ui, &LayerPaneView::new(state), &mut pane, &mut textures.flat, requests);
    state.flat.layer = pane;
}
