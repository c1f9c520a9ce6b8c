//! Composition of a layered document from a stack: the photo at the bottom, and a group per order, the nearest on
//! top. Above these are the guide of trees and the leftovers.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

use rayon::prelude::*;

use super::encoded::{LaidLayer, largest_difference};
use super::guide::{self, HatchPattern};
use super::names::{REFERENCE, TREE_GUIDE, group_name, guide_name, layer_name, numbered_name};
use super::trees::TreeGuide;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::task::Task;
use quadratura_document::export_record::{Baseline, ExportedLayer, HelperLayer, HelperRole};
use quadratura_document::{Element, ImageLayer, Stack};
use quadratura_files::hash::hash_file;
use quadratura_io::baselines::Baselines;
use quadratura_layered_files::document::LEFTOVERS;
use quadratura_layered_files::png::read_mask;
use quadratura_layered_files::srgb::srgb_profile;
use quadratura_layered_files::{Depth, Group, LayerNode, LayeredDocument, PixelLayer, Raster};
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_pixels::{layer_pixels, unfilled_pixels};
use quadratura_stacks::paint::PhotoPaint;

/// A stack with its pixels, from which a layered document is made.
pub struct StackContent<'a> {
    /// The stack.
    pub stack: &'a Stack,
    /// The folder of its files.
    pub folder: PathBuf,
    /// The pinhole image.
    pub photo: Arc<Raster>,
    /// The photo's colour profile.
    pub icc: Option<Vec<u8>>,
    /// The margin in pixels around the needed area that a layer keeps, within its rectangle; `None` keeps all of
    /// it.
    pub margin: Option<u32>,
    /// Whether guides are included.
    pub guides: bool,
    /// The guide of trees, where the photo shows any.
    pub trees: Option<TreeGuide>,
    /// The token of the layer that is active when the document is opened.
    pub selected: Option<&'a str>,
    /// The paint on the layers.
    pub paint: PhotoPaint,
    /// The factors that multiply the layers' linear colours; `photo` has been multiplied already. Such a document
    /// is only for viewing: its layers have no tokens, because an import would regard the changed colours as paint.
    pub evened: Option<[f64; 3]>,
    /// The task, which is checked for cancellation before each layer is read.
    pub task: &'a Task,
    /// The hashes of the layers' pixels, set once these were composed.
    hashes: Vec<OnceLock<String>>,
    /// The hashes of the guides by order, set once these were drawn.
    guide_hashes: Mutex<BTreeMap<u32, String>>,
    /// Whether painted layers still have hidden pixels without paint.
    unfinished: Vec<OnceLock<bool>>,
}

/// The pixels of an image layer that remain to be painted: needed and not visible in the photo. In photo pixels, within
/// the bounding box of all needed pixels.
pub type HiddenPixels = Image<bool>;

impl<'a> StackContent<'a> {
    /// Takes the stack in `folder` and its photo, with cropped layers and guides.
    pub fn new(
        stack: &'a Stack,
        folder: PathBuf,
        photo: Arc<Raster>,
        icc: Option<Vec<u8>>,
        task: &'a Task,
    ) -> Self {
        let hashes = stack.image_layers.iter().map(|_| OnceLock::new()).collect();
        let unfinished = stack.image_layers.iter().map(|_| OnceLock::new()).collect();
        let paint = PhotoPaint::default();
        let guide_hashes = Mutex::default();
        Self {
            stack,
            folder,
            photo,
            icc,
            margin: Some(8),
            guides: true,
            trees: None,
            selected: None,
            paint,
            evened: None,
            task,
            hashes,
            guide_hashes,
            unfinished,
        }
    }

    /// Makes the document, from bottom to top; `key` identifies it.
    pub fn document(&'a self, key: &str) -> LayeredDocument<'a> {
        let photo = &self.stack.photo;
        let merged = self.photo.clone();
        let mut nodes = vec![LayerNode::Layer(self.reference())];
        nodes.extend(self.orders().into_iter().rev().map(|order| LayerNode::Group(self.group(order))));
        nodes.extend(self.trees.as_ref().map(tree_guide).map(LayerNode::Layer));
        nodes.extend(self.leftovers().map(LayerNode::Layer));
        LayeredDocument {
            width: photo.width,
            height: photo.height,
            depth: self.depth(),
            icc: self.profile(),
            key: key.to_owned(),
            title: photo.name.clone(),
            nodes,
            merged: Box::new(move || Ok(merged.clone())),
        }
    }

    /// Returns the photo's own profile, or sRGB for 16 bits without one, which editors would not assume by
    /// themselves.
    pub fn profile(&self) -> Option<Vec<u8>> {
        self.icc.clone().or_else(|| (self.depth() == Depth::Sixteen).then(srgb_profile))
    }

    /// Returns the bit depth of the photo, which is that of all layers.
    pub fn depth(&self) -> Depth {
        self.photo.depth()
    }

    /// Returns the record's entries for the image layers, and stores their pixels in `kept`. There are no entries
    /// with matched exposure.
    ///
    /// # Errors
    /// Returns an error when a layer's file cannot be read, or its pixels cannot be stored.
    pub fn exported_layers(&self, kept: &Baselines) -> Result<Vec<ExportedLayer>> {
        if self.evened.is_some() {
            return Ok(Vec::new());
        }
        let elements: Vec<&Element> = self.stack.visibility_layers.iter().flatten().collect();
        let exported = |(index, layer): (LayerIndex, &ImageLayer)| {
            Ok(ExportedLayer {
                id: layer.id.clone(),
                name: layer_name(&layer.name, &layer.id),
                order: layer.order,
                rect: layer.rect,
                exported_rect: self.exported_rect(layer),
                needed_rect: layer.needed_rect,
                pixels: self.hash(index)?,
                baseline: self.baseline(index, kept)?,
                elements: layer.elements.iter().map(|e| elements[e.index()].clone()).collect(),
            })
        };
        self.stack.numbered_layers().map(exported).collect()
    }

    /// Stores the pixels that a layer is later compared with; without paint and filling they are the stack's own
    /// file.
    fn baseline(&self, index: LayerIndex, kept: &Baselines) -> Result<Baseline> {
        let layer = self.layer(index);
        if !self.paint.is_on(index) && layer.fill.is_none() {
            let file = self.folder.join(&layer.file);
            return Ok(Baseline { file: kept.store_file(&file, &hash_file(&file)?)?, rect: layer.rect });
        }
        let rect = self.exported_rect(layer);
        Ok(Baseline { file: kept.store_pixels(&*self.pixels(index)?)?, rect })
    }

    /// Returns the record's entries for the other layers, from the top.
    ///
    /// # Errors
    /// Returns an error when a guide has to be drawn and its pixels cannot be read.
    pub fn helpers(&self) -> Result<Vec<HelperLayer>> {
        let orders = self.orders();
        let guides = orders.into_iter().filter_map(|order| {
            let guided = self.guided(order);
            let rect = self.needed_by(&guided)?;
            let helper =
                |pixels| HelperLayer { name: guide_name(order), role: HelperRole::Guide, rect, pixels };
            Some(self.guide_hash(order, &guided, rect).map(helper))
        });
        let leftovers = self.leftovers_rect().map(|rect| {
            let pixels = self.leftover_pixels(rect).hash_at(rect.x, rect.y);
            Ok(HelperLayer { name: LEFTOVERS.into(), role: HelperRole::Leftovers, rect, pixels })
        });
        let trees = self.trees.as_ref().map(|trees| {
            let role = HelperRole::Guide;
            Ok(HelperLayer { name: TREE_GUIDE.into(), role, rect: trees.rect, pixels: trees.hash() })
        });
        let mut helpers: Vec<_> = leftovers.into_iter().chain(trees).chain(guides).collect::<Result<_>>()?;
        let (rect, pixels) = (self.canvas(), self.photo.hash_at(0, 0));
        helpers.push(HelperLayer { name: REFERENCE.into(), role: HelperRole::Reference, rect, pixels });
        Ok(helpers)
    }

    /// Returns the rectangle of the pixels of `layer` in the document: the needed part with a margin, within the
    /// layer's rectangle.
    pub fn exported_rect(&self, layer: &ImageLayer) -> PixelRect {
        match self.margin {
            Some(margin) => layer.needed_rect.grown(margin).intersection(&layer.rect),
            None => layer.rect,
        }
    }

    fn canvas(&self) -> PixelRect {
        PixelRect::of_size(self.stack.photo.width, self.stack.photo.height)
    }

    fn layer(&self, index: LayerIndex) -> &'a ImageLayer {
        self.stack.layer(index)
    }

    /// Returns all orders, nearest first.
    pub fn orders(&self) -> Vec<u32> {
        let mut orders: Vec<u32> = self.stack.image_layers.iter().map(|layer| layer.order).collect();
        orders.sort_unstable();
        orders.dedup();
        orders
    }

    /// Returns the indices of the image layers of one order, as the stack lists them.
    fn in_order(&self, order: u32) -> Vec<LayerIndex> {
        let layers = self.stack.numbered_layers();
        layers.filter(|(_, layer)| layer.order == order).map(|(index, _)| index).collect()
    }

    /// Returns the indices of the image layers of one order that remain to be painted.
    fn guided(&self, order: u32) -> Vec<LayerIndex> {
        let mut layers = self.in_order(order);
        layers.retain(|i| self.guides && self.is_unfinished(*i));
        layers
    }

    /// Returns true when the layer has hidden pixels without paint. An error while reading the pixels counts as
    /// true, because they are read again later, which reports the error.
    fn is_unfinished(&self, index: LayerIndex) -> bool {
        let is_hidden = self.layer(index).texels_visible < self.layer(index).texels_used;
        let any_left = || self.hidden(index).map_or(true, |hidden| hidden.pixels().contains(&true));
        if self.paint.is_on(index) {
            *self.unfinished[index.index()].get_or_init(any_left)
        } else {
            is_hidden
        }
    }

    /// Returns the bounding box of the needed parts of these layers.
    fn needed_by(&self, layers: &[LayerIndex]) -> Option<PixelRect> {
        layers.iter().map(|i| self.layer(*i).needed_rect).reduce(|a, b| a.union(&b))
    }

    /// Makes the locked layer of the photo.
    fn reference(&'a self) -> PixelLayer<'a> {
        let photo = self.photo.clone();
        let pixels = Box::new(move || Ok(photo.clone()));
        PixelLayer { locked: true, ..PixelLayer::new(REFERENCE, self.canvas(), pixels) }
    }

    /// Makes the locked layer of the pixels that show leftovers, in front of all others; `None` where there are none.
    fn leftovers(&'a self) -> Option<PixelLayer<'a>> {
        let rect = self.leftovers_rect()?;
        let pixels = Box::new(move || Ok(Arc::new(self.leftover_pixels(rect))));
        Some(PixelLayer { locked: true, ..PixelLayer::new(LEFTOVERS, rect, pixels) })
    }

    /// Returns the bounding box of the pixels that show leftovers; `None` where there are none.
    fn leftovers_rect(&self) -> Option<PixelRect> {
        let row =
            |&[y, x0, x1]: &[u32; 3]| PixelRect { x: x0 as i32, y: y as i32, w: x1.saturating_sub(x0), h: 1 };
        let rows = self.stack.leftovers.iter().map(row).map(|row| row.intersection(&self.canvas()));
        rows.filter(|row| !row.is_empty()).reduce(|a, b| a.union(&b))
    }

    /// Copies the photo's pixels that show leftovers to a raster of `rect`.
    fn leftover_pixels(&self, rect: PixelRect) -> Raster {
        let mut raster = Raster::blank(rect.w, rect.h, self.depth());
        for &[y, x0, x1] in &self.stack.leftovers {
            for x in (x0..x1).filter(|&x| rect.contains(x as i32, y as i32)) {
                let (u, v) = (x - rect.x as u32, y - rect.y as u32);
                raster.set_rgba16(u, v, self.photo.rgba16(x, y));
            }
        }
        raster
    }

    /// Makes the group of one order.
    fn group(&'a self, order: u32) -> Group<'a> {
        let last = self.orders().last().copied().unwrap_or(0);
        let guided = self.guided(order);
        let mut layers: Vec<PixelLayer> = self
            .in_order(order)
            .into_iter()
            .rev()
            .map(|index| PixelLayer {
                tag: self.colour(index, &guided).map(guide::tag),
                ..self.image_layer(index)
            })
            .collect();
        layers.extend(self.guide(order, guided));
        Group { name: group_name(order, last), layers }
    }

    /// Returns the number of the group of linked layers that contains a layer.
    fn link(&self, index: LayerIndex) -> Option<usize> {
        let id = &self.layer(index).id;
        self.stack.linked.iter().position(|layers| layers.contains(id))
    }

    /// Returns the number of a layer's colour: linked layers have the same in all orders; others with something to
    /// paint, `guided`, have the free ones in turn.
    fn colour(&self, index: LayerIndex, guided: &[LayerIndex]) -> Option<usize> {
        if let Some(link) = self.link(index) {
            return Some(guide::linked_colour(link));
        }
        let taken: Vec<usize> =
            guided.iter().filter_map(|i| self.link(*i)).map(guide::linked_colour).collect();
        let unlinked: Vec<&LayerIndex> = guided.iter().filter(|i| self.link(**i).is_none()).collect();
        let at = unlinked.iter().position(|i| **i == index)?;
        Some(guide::free_colours(&taken).nth(at).unwrap_or(at))
    }

    /// Makes the layer of an image layer; with matched exposure it has no token.
    fn image_layer(&'a self, index: LayerIndex) -> PixelLayer<'a> {
        let (layer, plain) = (self.layer(index), self.evened.is_none());
        let name = match plain {
            true => layer_name(&layer.name, &layer.id),
            false => numbered_name(&layer.name, index.index() + 1),
        };
        let pixels = Box::new(move || self.pixels(index));
        PixelLayer {
            id: plain.then(|| layer.id.clone()),
            selected: plain && self.selected == Some(layer.id.as_str()),
            linear_light: sees_through(layer),
            ..PixelLayer::new(name, self.exported_rect(layer), pixels)
        }
    }

    /// Makes the guide of an order, if anything remains to be painted.
    fn guide(&'a self, order: u32, guided: Vec<LayerIndex>) -> Option<PixelLayer<'a>> {
        let rect = self.needed_by(&guided)?;
        let pixels = Box::new(move || self.drawn_guide(order, &guided, rect).map(Arc::new));
        Some(PixelLayer { visible: false, ..PixelLayer::new(guide_name(order), rect, pixels) })
    }

    /// Draws the guide of an order and stores its hash.
    fn drawn_guide(&self, order: u32, guided: &[LayerIndex], rect: PixelRect) -> Result<Raster> {
        let photo = &self.stack.photo;
        let pattern = HatchPattern::for_photo(photo.width, photo.height);
        let parts: Vec<_> = guided.par_iter().map(|i| self.hidden(*i)).collect::<Result<_>>()?;
        let colours = guided.iter().map(|i| self.colour(*i, guided).unwrap_or(0));
        let parts: Vec<_> = colours.zip(parts).collect();
        let raster = guide::draw(parts, rect, pattern, self.depth());
        let mut hashes = self.guide_hashes.lock().expect("no holder of this lock panics");
        hashes.insert(order, raster.hash_at(rect.x, rect.y));
        Ok(raster)
    }

    /// Returns the hash of a guide, which is known once it was drawn, as every format does.
    fn guide_hash(&self, order: u32, guided: &[LayerIndex], rect: PixelRect) -> Result<String> {
        let known = || self.guide_hashes.lock().expect("no holder of this lock panics").get(&order).cloned();
        if let Some(hash) = known() {
            return Ok(hash);
        }
        Ok(self.drawn_guide(order, guided, rect)?.hash_at(rect.x, rect.y))
    }

    /// Composes the pixels of a layer as exported, and stores their hash.
    fn pixels(&self, index: LayerIndex) -> Result<Arc<Raster>> {
        self.task.check_cancelled()?;
        let layer = self.layer(index);
        let rect = self.exported_rect(layer);
        let whole = layer_pixels(self.stack, &self.folder, &self.paint, index)?;
        let mut pixels = whole.cropped(moved(rect, &layer.rect));
        if let Some(factors) = self.evened {
            pixels.multiply_light(factors);
        }
        self.hashes[index.index()].get_or_init(|| pixels.hash_at(rect.x, rect.y));
        Ok(Arc::new(pixels))
    }

    /// Returns by how much the layers over each other differ between linear light and encoded values, as a share of the full
    /// range; `None` without see-through layers.
    ///
    /// # Errors
    /// Returns an error when a layer's file cannot be read.
    pub fn encoded_difference(&self) -> Result<Option<f64>> {
        let see_through = self.stack.image_layers.iter().filter(|layer| sees_through(layer));
        let rect = see_through.map(|layer| layer.needed_rect).reduce(|a, b| a.union(&b));
        let Some(rect) = rect else { return Ok(None) };
        let laid = |index: LayerIndex| {
            let (layer, pixels) = (self.layer(index), self.pixels(index)?);
            Ok(LaidLayer { rect: self.exported_rect(layer), pixels, linear_light: sees_through(layer) })
        };
        let farthest_first = self.stack.layer_indices().rev().map(laid);
        largest_difference(rect.intersection(&self.canvas()), farthest_first).map(Some)
    }

    /// Returns the hash of a layer's pixels.
    fn hash(&self, index: LayerIndex) -> Result<String> {
        if self.hashes[index.index()].get().is_none() {
            self.pixels(index)?;
        }
        Ok(self.hashes[index.index()].get().expect("fetching the pixels hashes them").clone())
    }

    /// Returns the pixels of a layer that remain to be painted.
    fn hidden(&self, index: LayerIndex) -> Result<HiddenPixels> {
        self.task.check_cancelled()?;
        let layer = self.layer(index);
        let colours = unfilled_pixels(self.stack, &self.folder, &self.paint, index)?;
        let needed = read_mask(&self.folder.join(&layer.needed_file), layer.rect)?;
        let is_empty =
            |x: i32, y: i32| !colours.has_colour((x - layer.rect.x) as u32, (y - layer.rect.y) as u32);
        let rect = layer.needed_rect.intersection(&layer.rect);
        Ok(HiddenPixels::from_fn(rect, |(x, y)| needed.holds(x, y) && is_empty(x, y)))
    }
}

/// Makes the hidden, locked layer of the guide of trees.
fn tree_guide(guide: &TreeGuide) -> PixelLayer<'_> {
    let pixels = Box::new(|| Ok(guide.pixels.clone()));
    PixelLayer { visible: false, locked: true, ..PixelLayer::new(TREE_GUIDE, guide.rect, pixels) }
}

/// Returns whether the alpha of a layer is a matte.
fn sees_through(layer: &ImageLayer) -> bool {
    layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some())
}

/// Returns `rect` relative to the top-left corner of `origin`.
fn moved(rect: PixelRect, origin: &PixelRect) -> PixelRect {
    PixelRect { x: rect.x - origin.x, y: rect.y - origin.y, ..rect }
}
