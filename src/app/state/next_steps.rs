//! What to do next with a photo, an object or the project, so that their pages begin with that.

use super::facts::Inspect;
use super::quality::filling::FillSession;
use super::session::{PhotoStatus, Session};
use quadratura_base::scene::{ObjectId, PhotoId};
use quadratura_document::{ImageLayer, Stack};
use quadratura_layers::{ElementIndex, LayerIndex};
use quadratura_stacks::layer_table::LayerFigures;

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

/// A step that the photos of the project wait for, or those that show an object.
#[derive(Debug, Clone, PartialEq)]
pub enum SiteStep {
    /// Build the layers of this number of photos.
    Build(usize),
    /// Fill the occluded areas of this number of photos.
    Fill(usize),
    /// Paint hidden areas.
    Paint(SiteAreas),
    /// Find out why no photo shows this number of faces.
    Cover(usize),
}

/// The image layers of several photos with hidden areas that are worth painting.
#[derive(Debug, Clone, PartialEq)]
pub struct SiteAreas {
    /// The number of these layers.
    pub count: usize,
    /// The number of photos that have some.
    pub photos: usize,
    /// Those with the largest hidden areas, with the share of the layer that is hidden, 0..=1.
    pub largest: Vec<(PhotoId, LayerIndex, f64)>,
}

impl Session {
    /// Returns what to do next with all photos, or with what they show of an object, the most urgent first.
    pub fn next_steps_of_site(
        &self,
        object: Option<ObjectId>,
        fill: &FillSession,
        facts: &Inspect,
    ) -> Vec<SiteStep> {
        let name = object.map(|object| self.model().object(object).name.as_str());
        let mut areas: Vec<(PhotoId, LayerIndex, LayerFigures)> = Vec::new();
        let (mut photos, mut unfilled) = (0, 0);
        for (photo, status) in self.opened.site.photo_ids().zip(&self.photos) {
            let Some(stack) = &status.stack else { continue };
            let elements = name.map(|name| elements_of(stack, name));
            let is_meant = |layer: &ImageLayer| {
                elements.as_ref().is_none_or(|of| layer.elements.iter().any(|it| of.contains(it)))
            };
            let lacks = |layer: &ImageLayer| {
                layer.fill.is_none() && layer.texels_used > layer.texels_visible && is_meant(layer)
            };
            unfilled += usize::from(needs_filling(status) && stack.layers_of_faces().any(lacks));
            let of_photo: Vec<(LayerIndex, LayerFigures)> = self.layers_to_paint(photo, fill);
            let of_photo = of_photo.into_iter().filter(|(layer, _)| is_meant(stack.layer(*layer)));
            let before = areas.len();
            areas.extend(of_photo.map(|(layer, figures)| (photo, layer, figures)));
            photos += usize::from(areas.len() > before);
        }
        areas.sort_by_key(|(photo, layer, figures)| (std::cmp::Reverse(figures.hidden), *photo, *layer));
        let largest = areas.iter().take(MOST_NAMED);
        let largest =
            largest.map(|(photo, layer, figures)| (*photo, *layer, figures.hidden_share())).collect();
        let outdated = self.photos.iter().filter(|photo| !photo.is_current()).count();
        let is_built = self.photos.iter().any(|photo| photo.stack.is_some());
        let counts = object.map_or(&[][..], |object| facts.photos_of_object(object));
        let bare = counts.iter().filter(|count| **count == 0 && is_built).count();
        let steps = [
            (outdated > 0).then_some(SiteStep::Build(outdated)),
            (unfilled > 0).then_some(SiteStep::Fill(unfilled)),
            (!areas.is_empty()).then_some(SiteStep::Paint(SiteAreas { count: areas.len(), photos, largest })),
            (bare > 0).then_some(SiteStep::Cover(bare)),
        ];
        steps.into_iter().flatten().collect()
    }

    /// Returns what to do next with a photo, the most urgent first.
    pub fn next_steps(&self, photo: PhotoId, fill: &FillSession) -> Vec<NextStep> {
        let status = &self.photos[photo.index()];
        let mut steps = Vec::new();
        if !status.is_current() {
            steps.push(NextStep::Build { again: status.stack.is_some() });
        }
        if needs_filling(status) {
            steps.push(NextStep::Fill);
        }
        let areas = self.layers_to_paint(photo, fill);
        if !areas.is_empty() {
            let largest = areas.iter().take(MOST_NAMED);
            let largest = largest.map(|(layer, figures)| (*layer, figures.hidden_share())).collect();
            steps.push(NextStep::Paint(HiddenAreas { count: areas.len(), largest }));
        }
        let name = &self.opened.site.photo(photo).name;
        if self.history.present().masks.of(name).is_empty() {
            steps.push(NextStep::Mask);
        }
        steps
    }

    /// Returns the image layers of a photo whose hidden areas are worth painting and are not painted yet, the largest areas
    /// first.
    fn layers_to_paint(&self, photo: PhotoId, fill: &FillSession) -> Vec<(LayerIndex, LayerFigures)> {
        let Some(stack) = self.stack_of(photo) else { return Vec::new() };
        let camera = &self.opened.site.photo(photo).camera;
        let least = LEAST_SHARE * f64::from(camera.width) * f64::from(camera.height);
        let shares = fill.shares.get(&photo).and_then(|shares| shares.found());
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
        areas
    }
}

/// Returns whether the occluded areas of a photo whose layers are up to date are empty.
fn needs_filling(photo: &PhotoStatus) -> bool {
    photo.is_current() && photo.lacks_filling()
}

/// Returns the elements of an object in a stack.
fn elements_of(stack: &Stack, object: &str) -> Vec<ElementIndex> {
    let elements = stack.numbered_elements().filter(|(_, element)| element.object == object);
    elements.map(|(index, _)| index).collect()
}
