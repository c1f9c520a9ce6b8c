//! A report on the image layers of a photo: how many there are, how much of them the photo shows, and why layers of
//! which it shows little exist.

use serde::Serialize;

use quadratura_base::raster::robust;
use quadratura_document::stack::{Support, UntexturedReason};
use quadratura_document::{Element, ImageLayer, Stack};
use quadratura_layers::ElementIndex;
use quadratura_layers::occlusion_graph::OcclusionGraph;

/// The number of visible pixels below which an image layer is small.
pub const SMALL_PX: u64 = 500;

/// The report on one photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerReport {
    /// The number of image layers.
    pub layers: usize,
    /// The number of objects that the photo shows.
    pub objects: usize,
    /// The number of elements per object.
    pub parts_per_object: f64,
    /// The median, over the image layers, of the visible share of the pixels that surfaces cover.
    pub median_visible: f64,
    /// The number of faces that are in no image layer, because the photo barely shows them.
    pub barely_visible: usize,
    /// The image layers with fewer than [`SMALL_PX`] visible pixels, nearest first.
    pub small: Vec<SmallLayer>,
}

/// An image layer with few visible pixels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SmallLayer {
    /// The layer's token.
    pub id: String,
    /// The layer's name.
    pub name: String,
    /// The number of visible pixels.
    pub visible: u64,
    /// The number of pixels that surfaces cover.
    pub covered: u64,
    /// The reason why the layer exists, in words.
    pub why: String,
}

impl LayerReport {
    /// Makes the report on a stack.
    pub fn new(stack: &Stack) -> Self {
        let elements: Vec<&Element> = stack.visibility_layers.iter().flatten().collect();
        let parts = || elements.iter().filter(|element| !element.is_surroundings());
        let mut objects: Vec<&str> = parts().map(|element| element.object.as_str()).collect();
        objects.sort_unstable();
        objects.dedup();
        let reasons = SmallReasons::new(stack, &elements);
        let small = stack.image_layers.iter().filter(|layer| layer.texels_visible < SMALL_PX);
        let barely = stack.untextured.iter().filter(|u| u.reason == UntexturedReason::BarelyVisible);
        Self {
            layers: stack.image_layers.len(),
            objects: objects.len(),
            parts_per_object: parts().count() as f64 / objects.len().max(1) as f64,
            median_visible: median(stack.layers_of_faces().map(visible_share).collect()),
            barely_visible: barely.count(),
            small: small.map(|layer| reasons.small_layer(layer)).collect(),
        }
    }
}

/// Returns the visible share of the pixels that a layer's surfaces cover.
fn visible_share(layer: &ImageLayer) -> f64 {
    layer.texels_visible as f64 / layer.texels_used.max(1) as f64
}

/// Returns the median; 0 of nothing.
fn median(mut values: Vec<f64>) -> f64 {
    robust::median(&mut values).unwrap_or(0.0)
}

/// What explains small layers.
struct SmallReasons<'a> {
    stack: &'a Stack,
    elements: &'a [&'a Element],
    /// The occlusions between elements of different objects.
    between: OcclusionGraph,
}

impl<'a> SmallReasons<'a> {
    fn new(stack: &'a Stack, elements: &'a [&'a Element]) -> Self {
        let object = |index: ElementIndex| elements.get(index.index()).map(|element| &element.object);
        let others = stack.occlusions.iter().filter(|s| object(s.front) != object(s.back));
        let supports = others.map(|s| (s.front.0, s.back.0, s.px));
        Self { stack, elements, between: OcclusionGraph::new(elements.len() as u32, supports) }
    }

    fn small_layer(&self, layer: &ImageLayer) -> SmallLayer {
        SmallLayer {
            id: layer.id.clone(),
            name: layer.name.clone(),
            visible: layer.texels_visible,
            covered: layer.texels_used,
            why: self.why(layer),
        }
    }

    /// Returns the first reason that applies: a decision or paint, small surfaces, another part of the object in front
    /// or behind; otherwise that other surfaces or a mask hide most of it.
    fn why(&self, layer: &ImageLayer) -> String {
        let held =
            || layer.elements.iter().filter_map(|index| Some((*index, *self.elements.get(index.index())?)));
        let is_spared = |element: &Element| {
            let mut spared = self.stack.spared.iter();
            if element.is_surroundings() {
                return spared.any(|of| of.object == element.object);
            }
            let faces = element.textured_faces();
            spared.any(|of| faces.iter().any(|face| of.holds(&element.object, *face)))
        };
        if held().any(|(_, element)| is_spared(element)) {
            return "kept because of paint, a pin or a merge".into();
        }
        if layer.texels_used < SMALL_PX {
            return format!("its surfaces cover only {} pixels", layer.texels_used);
        }
        let between = held().find_map(|(index, element)| self.beside_its_object(index, element));
        between.unwrap_or_else(|| format!("{:.1} % of it are visible", 100.0 * visible_share(layer)))
    }

    /// Describes what keeps an element apart from another one of its object: something between the two, or else their
    /// own overlap; `None` where it is the only one, or where no occlusion connects it with another.
    fn beside_its_object(&self, index: ElementIndex, element: &Element) -> Option<String> {
        let object = &element.object;
        let is_part = |other: u32| other != index.0 && self.elements[other as usize].object == *object;
        let path = |part: u32| {
            let path = self.between.shortest_path(index.0, part);
            path.or_else(|| self.between.shortest_path(part, index.0))
        };
        let parts = (0..self.elements.len() as u32).filter(|other| is_part(*other));
        if let Some([_, between, ..]) = parts.filter_map(path).min_by_key(Vec::len).as_deref() {
            let between = &self.elements[*between as usize].object;
            return Some(format!("{between} is between it and another part of {object}"));
        }
        let own =
            |s: &&Support| (s.front == index && is_part(s.back.0)) || (s.back == index && is_part(s.front.0));
        let direct = self.stack.occlusions.iter().filter(own).max_by_key(|support| support.px)?;
        let side = if direct.front == index { "in front of" } else { "behind" };
        Some(format!("it is {side} another part of {object}, at {} pixels", direct.px))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::assemble;
    use quadratura_base::scene::Photo;
    use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
    use quadratura_base::task::Task;
    use quadratura_layers::{LayerConstraints, Options, SoftwareRasteriser, sort_photo};

    fn report(modeller: &mut Modeller, options: &Options) -> LayerReport {
        let model = modeller.finish();
        let (camera, pose) = (centred(160, 120, 120.0), camera_is_world());
        let constraints = LayerConstraints::default();
        let task = Task::silent();
        let sorted =
            sort_photo(&model, &camera, &pose, &SoftwareRasteriser, options, &constraints, &task).unwrap();
        let photo =
            Photo { name: "a".into(), camera, pose, file: "a".into(), masks: Vec::new(), exposure: None };
        LayerReport::new(&assemble(&model, &photo, &sorted, options, &constraints, ""))
    }

    #[test]
    fn a_small_layer_comes_with_the_reason_why_it_exists() {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(10.0, [-5.0, -4.0, 5.0, 4.0]);
        // Two sheets of one object; the wall between them hides all but a strip of the farther one.
        modeller.object("sheet").screen(8.0, [-0.5, -0.5, 0.5, 0.5]).screen(12.0, [-5.0, -4.0, 6.2, 4.0]);
        let all = Options { min_visible: 0, ..Options::default() };
        let found = report(&mut modeller, &all);
        assert_eq!((found.layers, found.objects, found.parts_per_object), (3, 2, 1.5));
        let whys: Vec<_> = found.small.iter().map(|layer| layer.why.as_str()).collect();
        assert_eq!(
            whys,
            ["its surfaces cover only 225 pixels", "wall is between it and another part of sheet"],
            "{found:#?}"
        );
    }

    #[test]
    fn the_median_of_an_even_number_is_halfway() {
        assert_eq!(median(vec![0.25, 1.0, 0.5, 0.75]), 0.625);
        assert_eq!((median(vec![3.0, 1.0, 2.0]), median(vec![])), (2.0, 0.0));
    }
}
