//! The layered document of a sub-object: six views side by side, a group for each, a layer for each slab.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::layers::{BACKDROP, canvas, cell, group_name, readable, title, token};
use crate::export::layer_name;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;
use quadratura_base::task::Task;
use quadratura_document::export_record::{Baseline, ExportedLayer, HelperLayer, HelperRole};
use quadratura_files::json::to_json;
use quadratura_foliage::files::images::mbuffer_bytes;
use quadratura_foliage::{BakeOptions, ImageCopy, PaintedSlab, Plant, SlabFrame, finest_copy, slab_pictures};
use quadratura_io::baselines::Baselines;
use quadratura_layered_files::composite::lay_over;
use quadratura_layered_files::folder::NewFolder;
use quadratura_layered_files::folder::read::STACK_FILE;
use quadratura_layered_files::{Depth, Group, KEY_FILE, LayerNode, LayeredDocument, PixelLayer, Raster};

/// The images of a species' sub-object, with which kind of slabs they are made.
pub const IMAGES: BakeOptions = BakeOptions::SLABS;
/// The greys behind the six views, sRGB.
const GREYS: [u8; 2] = [150, 165];

/// The images of a sub-object as layers.
pub struct TreeContent {
    species: String,
    part: Option<String>,
    /// Where the images are.
    pub frame: SlabFrame,
    images: ImageCopy,
    /// The layers, those of a direction nearest first. Slabs in which nothing is have none.
    layers: Vec<SlabPicture>,
    backdrop: Arc<Raster>,
}

struct SlabPicture {
    direction: usize,
    slab: usize,
    rect: PixelRect,
    pixels: Arc<Raster>,
    opaque: usize,
}

impl TreeContent {
    /// Makes the images of a plant, which is a species, or a sub-object of one, with its paint. `beside` is the paint where it has
    /// nothing, in the order in which it was made.
    ///
    /// # Errors
    /// [`Error::Request`] for a plant without polygons; [`Error::Cancelled`].
    pub fn new(
        species: &str,
        part: Option<&str>,
        plant: &Plant,
        beside: &[PaintedSlab],
        task: &Task,
    ) -> Result<Self> {
        let images = task.timed("bake", || finest_copy(plant, &IMAGES, task))?;
        let empty = || {
            Error::Request(format!(
                "{:?} has no polygons, so there is nothing to paint",
                title(species, part)
            ))
        };
        let images = images.ok_or_else(empty)?;
        let frame = SlabFrame::of(&plant.whole().bounds, &images, IMAGES.slabs);
        let mut layers = Vec::new();
        for (direction, view) in images.views.iter().enumerate() {
            task.check_cancelled()?;
            for (slab, mut pixels) in slab_pictures(view, &frame, direction).into_iter().enumerate() {
                let kept = beside.iter().filter(|of| (of.direction, of.slab) == (direction, slab));
                lay_beside(&mut pixels, &frame, kept);
                let opaque = pixels.iter().filter(|pixel| pixel[3] > 0).count();
                if opaque == 0 {
                    continue;
                }
                let pixels = Raster::new(frame.side, frame.side, Samples::U8(pixels.into_flattened()));
                let rect = cell(direction, frame.side);
                layers.push(SlabPicture { direction, slab, rect, pixels: Arc::new(pixels), opaque });
            }
        }
        if layers.is_empty() {
            return Err(empty());
        }
        let backdrop = Arc::new(backdrop(frame.side));
        let (species, part) = (species.to_owned(), part.map(str::to_owned));
        Ok(Self { species, part, frame, images, layers, backdrop })
    }

    /// Returns the name of the document.
    pub fn title(&self) -> String {
        title(&self.species, self.part.as_deref())
    }

    /// Returns the number of layers.
    pub fn layer_count(&self) -> usize {
        self.layers.len()
    }

    /// Returns the number of groups.
    pub fn group_count(&self) -> usize {
        self.by_direction().len()
    }

    fn by_direction(&self) -> BTreeMap<usize, Vec<&SlabPicture>> {
        let mut groups: BTreeMap<usize, Vec<&SlabPicture>> = BTreeMap::new();
        self.layers.iter().for_each(|layer| groups.entry(layer.direction).or_default().push(layer));
        groups
    }

    fn token(&self, layer: &SlabPicture) -> String {
        token(&self.species, self.part.as_deref(), layer.direction, layer.slab)
    }

    fn name(&self, layer: &SlabPicture) -> String {
        let slabs = usize::from(self.frame.slabs);
        layer_name(&readable(layer.direction, layer.slab, slabs), &self.token(layer))
    }

    /// Makes the document, from bottom to top; `key` identifies it.
    pub fn document(&self, key: &str) -> LayeredDocument<'_> {
        let canvas = canvas(self.frame.side);
        let backdrop = self.backdrop.clone();
        let source = Box::new(move || Ok(backdrop.clone()));
        let mut nodes =
            vec![LayerNode::Layer(PixelLayer { locked: true, ..PixelLayer::new(BACKDROP, canvas, source) })];
        let fullest =
            self.layers.iter().filter(|layer| layer.direction == 0).max_by_key(|layer| layer.opaque);
        let layer = |of: &SlabPicture| {
            let pixels = of.pixels.clone();
            PixelLayer {
                id: Some(self.token(of)),
                selected: fullest.is_some_and(|fullest| fullest.slab == of.slab && of.direction == 0),
                linear_light: true,
                ..PixelLayer::new(self.name(of), of.rect, Box::new(move || Ok(pixels.clone())))
            }
        };
        for (direction, layers) in self.by_direction().into_iter().rev() {
            let layers = layers.into_iter().rev().map(&layer).collect();
            nodes.push(LayerNode::Group(Group { name: group_name(direction), layers }));
        }
        LayeredDocument {
            width: canvas.w,
            height: canvas.h,
            depth: Depth::Eight,
            icc: None,
            key: key.to_owned(),
            title: self.title(),
            nodes,
            merged: Box::new(|| Ok(Arc::new(self.merged()))),
        }
    }

    fn merged(&self) -> Raster {
        let mut merged = (*self.backdrop).clone();
        self.layers.iter().rev().for_each(|layer| lay_over(&mut merged, &layer.pixels, layer.rect));
        merged
    }

    /// Fills a folder with the layers, and with the positions of these.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn fill(&self, folder: &mut NewFolder, document: &LayeredDocument) -> Result<()> {
        document.check()?;
        let file = |layer: &SlabPicture| {
            let readable = readable(layer.direction, layer.slab, usize::from(self.frame.slabs));
            format!("{readable} ({}).png", self.token(layer))
        };
        folder.add_layers(document, |of| {
            self.layers.iter().find(|layer| self.name(layer) == of.name).map(file)
        })?;
        let described = |layer: &SlabPicture| {
            let (id, name) =
                (self.token(layer), readable(layer.direction, layer.slab, usize::from(self.frame.slabs)));
            serde_json::json!({ "id": id, "name": name, "order": layer.slab, "rect": layer.rect, "file": file(layer) })
        };
        let canvas = canvas(self.frame.side);
        let stack = serde_json::json!({
            "photo": { "name": self.title(), "width": canvas.w, "height": canvas.h },
            "image_layers": self.layers.iter().map(described).collect::<Vec<_>>(),
        });
        folder.add(STACK_FILE, &to_json(&stack))?;
        folder.add(KEY_FILE, document.key.as_bytes())
    }

    /// Returns the record's entries for the layers, and stores their pixels in `kept`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn exported_layers(&self, kept: &Baselines) -> Result<Vec<ExportedLayer>> {
        let exported = |layer: &SlabPicture| {
            Ok(ExportedLayer {
                id: self.token(layer),
                name: self.name(layer),
                order: layer.slab as u32,
                rect: layer.rect,
                exported_rect: layer.rect,
                needed_rect: layer.rect,
                pixels: layer.pixels.hash_at(layer.rect.x, layer.rect.y),
                baseline: Baseline { file: kept.store_pixels(&layer.pixels)?, rect: layer.rect },
                elements: Vec::new(),
            })
        };
        self.layers.iter().map(exported).collect()
    }

    /// Returns direction and slab of each layer.
    pub fn slabs(&self) -> Vec<[usize; 2]> {
        self.layers.iter().map(|layer| [layer.direction, layer.slab]).collect()
    }

    /// Stores the samples of each direction; returns the names of their files.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn samples(&self, kept: &Baselines) -> Result<Vec<String>> {
        self.images
            .views
            .iter()
            .map(|view| kept.store_bytes(&mbuffer_bytes(view, self.frame.side), "mb"))
            .collect()
    }

    /// Returns the record's entry for the layer behind the views.
    pub fn helper(&self) -> HelperLayer {
        let rect = canvas(self.frame.side);
        let pixels = self.backdrop.hash_at(0, 0);
        HelperLayer { name: BACKDROP.into(), role: HelperRole::Reference, rect, pixels }
    }
}

/// Shows paint where a slab has nothing: the last one of a texel.
fn lay_beside<'a>(pixels: &mut [[u8; 4]], frame: &SlabFrame, kept: impl Iterator<Item = &'a PaintedSlab>) {
    let mut shown = BTreeMap::new();
    for of in kept {
        let [left, top] = frame.corner(of.direction);
        for pixel in &of.beside {
            let index = |at: f32, from: f64| ((f64::from(at) - from) / frame.delta).floor();
            let (x, y) = (index(pixel.at[0], left), index(pixel.at[1], top));
            let side = f64::from(frame.side);
            if (0.0..side).contains(&x) && (0.0..side).contains(&y) {
                shown.insert(y as usize * frame.side as usize + x as usize, pixel.colour);
            }
        }
    }
    for (index, colour) in shown {
        let pixel = &mut pixels[index];
        if pixel[3] == 0 && colour[3] > 0 {
            *pixel = colour.map(quadratura_base::raster::in_8_bits);
        }
    }
}

/// Draws the layer behind the views, which tells them apart.
fn backdrop(side: u32) -> Raster {
    let canvas = canvas(side);
    let grey = |(x, y): (i32, i32)| GREYS[((x as u32 / side + y as u32 / side) % 2) as usize];
    let samples = canvas.pixels().flat_map(|at| [grey(at), grey(at), grey(at), 255]).collect();
    Raster::new(canvas.w, canvas.h, Samples::U8(samples))
}
