//! What to do next with a photo, so that its page begins with that.

use super::State;
use crate::layers::LayerIndex;
use crate::recipe::layer_table::LayerFigures;
use crate::scene::PhotoId;

/// The number of image layers that are named.
const MOST_NAMED: usize = 3;
/// The smallest hidden area that is worth painting, as a share of the photo's pixels: less is hardly seen.
const LEAST_SHARE: f64 = 0.001;
/// The share of a layer's hidden area from which it counts as painted.
const PAINTED_SHARE: f64 = 0.5;

/// A step that a photo waits for.
#[derive(Debug, Clone, PartialEq)]
pub enum NextStep {
    /// Build its layers, again where there are some.
    Build { again: bool },
    /// Fill its occluded areas.
    Fill,
    /// Paint hidden areas.
    Paint(HiddenAreas),
    /// Mask what is not part of the site.
    Mask,
}

/// The image layers with hidden areas that are worth painting.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenAreas {
    /// The number of these layers.
    pub count: usize,
    /// Those with the largest hidden areas, with the share of the layer that is hidden, 0..=1.
    pub largest: Vec<(LayerIndex, f64)>,
}

impl State {
    /// Returns what to do next with a photo, the most urgent first.
    pub fn next_steps(&self, photo: PhotoId) -> Vec<NextStep> {
        let Some(session) = &self.session else { return Vec::new() };
        let status = &session.photos[photo.index()];
        let mut steps = Vec::new();
        if !status.is_current() {
            steps.push(NextStep::Build { again: status.stack.is_some() });
        }
        if status.is_current() && status.lacks_filling() {
            steps.push(NextStep::Fill);
        }
        if let Some(areas) = self.hidden_areas(photo).filter(|areas| areas.count > 0) {
            steps.push(NextStep::Paint(areas));
        }
        let name = &session.opened.site.photo(photo).name;
        if session.history.present().masks.of(name).is_empty() {
            steps.push(NextStep::Mask);
        }
        steps
    }

    /// Returns the image layers of a photo whose hidden areas are worth painting and are not painted yet; none without layers.
    fn hidden_areas(&self, photo: PhotoId) -> Option<HiddenAreas> {
        let session = self.session.as_ref()?;
        let (stack, camera) = (session.stack_of(photo)?, &session.opened.site.photo(photo).camera);
        let least = LEAST_SHARE * f64::from(camera.width) * f64::from(camera.height);
        let shares = self.quality.fill.shares.get(&photo).and_then(|shares| shares.found());
        let painted = |layer: usize| {
            shares.and_then(|shares| shares.get(layer)).map_or(0.0, |shares| shares.painted as f64)
        };
        let mut areas: Vec<(LayerIndex, LayerFigures)> = (stack.image_layers.iter().enumerate())
            .filter(|(_, layer)| !stack.is_of_surroundings(layer))
            .map(|(index, layer)| (LayerIndex::new(index), LayerFigures::from_layer(layer)))
            .filter(|(layer, figures)| {
                let hidden = figures.hidden as f64;
                hidden >= least && painted(layer.index()) < PAINTED_SHARE * hidden
            })
            .collect();
        areas.sort_by_key(|(layer, figures)| (std::cmp::Reverse(figures.hidden), *layer));
        let largest = areas.iter().take(MOST_NAMED).map(|(layer, figures)| (*layer, figures.hidden_share()));
        Some(HiddenAreas { count: areas.len(), largest: largest.collect() })
    }
}
