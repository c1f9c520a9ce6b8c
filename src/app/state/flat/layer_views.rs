//! The way in which the window shows image layers: eye, solo and opacity. It is a view of the stack, no decision: it is
//! not saved, and neither exports nor novel views depend on it.

use std::collections::{BTreeMap, BTreeSet};

use quadratura_base::scene::PhotoId;
use quadratura_document::{ImageLayer, Stack};
use quadratura_editing::peel::Opacities;

/// The eyes, solo layers and opacities of all photos' image layers.
#[derive(Debug, Clone, Default)]
pub struct LayerViews {
    of: BTreeMap<PhotoId, StackView>,
}

/// The view of one stack. Layers are named by their tokens, which a rebuild keeps.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct StackView {
    hidden: BTreeSet<String>,
    solo: Option<String>,
    opacities: BTreeMap<String, u8>,
}

impl StackView {
    /// Returns the opacity with which a layer is drawn, 0 to 255.
    fn drawn(&self, layer: &ImageLayer) -> u8 {
        let is_left_out = match &self.solo {
            Some(solo) => *solo != layer.id,
            None => self.hidden.contains(&layer.id),
        };
        if is_left_out { 0 } else { self.opacities.get(&layer.id).copied().unwrap_or(u8::MAX) }
    }
}

impl LayerViews {
    /// Returns whether a layer is drawn: its eye is open, or it is the solo layer where there is one.
    pub fn is_shown(&self, photo: PhotoId, layer: &ImageLayer) -> bool {
        self.of.get(&photo).is_none_or(|view| match &view.solo {
            Some(solo) => *solo == layer.id,
            None => !view.hidden.contains(&layer.id),
        })
    }

    /// Returns whether a layer is the only one that is drawn.
    pub fn is_solo(&self, photo: PhotoId, layer: &ImageLayer) -> bool {
        self.of.get(&photo).is_some_and(|view| view.solo.as_ref() == Some(&layer.id))
    }

    /// Returns the opacity of a layer, 0 to 255.
    pub fn opacity(&self, photo: PhotoId, layer: &ImageLayer) -> u8 {
        self.of.get(&photo).and_then(|view| view.opacities.get(&layer.id)).copied().unwrap_or(u8::MAX)
    }

    /// Returns whether all layers of a photo are drawn, and opaque.
    pub fn is_plain(&self, photo: PhotoId) -> bool {
        self.of.get(&photo).is_none_or(|view| *view == StackView::default())
    }

    /// Returns the opacities with which a stack's layers are drawn.
    pub fn drawn(&self, photo: PhotoId, stack: &Stack) -> Opacities {
        let Some(view) = self.of.get(&photo) else { return Opacities::default() };
        stack.numbered_layers().map(|(index, layer)| (index, view.drawn(layer))).collect()
    }

    /// Opens or closes the eye of a layer; where another layer is solo, that ends.
    pub fn show(&mut self, photo: PhotoId, layer: &ImageLayer, on: bool) {
        let view = self.of.entry(photo).or_default();
        view.solo = None;
        match on {
            true => view.hidden.remove(&layer.id),
            false => view.hidden.insert(layer.id.clone()),
        };
    }

    /// Draws only this layer of a photo, or all again where it was the only one.
    pub fn turn_solo(&mut self, photo: PhotoId, layer: &ImageLayer) {
        let view = self.of.entry(photo).or_default();
        view.solo = Some(layer.id.clone()).filter(|id| view.solo.as_ref() != Some(id));
    }

    /// Sets the opacity of a layer, 0 to 255.
    pub fn set_opacity(&mut self, photo: PhotoId, layer: &ImageLayer, opacity: u8) {
        let opacities = &mut self.of.entry(photo).or_default().opacities;
        match opacity {
            u8::MAX => opacities.remove(&layer.id),
            _ => opacities.insert(layer.id.clone(), opacity),
        };
    }

    /// Draws all layers of a photo, opaque.
    pub fn reset(&mut self, photo: PhotoId) {
        self.of.remove(&photo);
    }
}
