//! The content of a layered file to be written, independent of its format.

use std::collections::HashSet;
use std::sync::Arc;

use super::depth::Depth;
use super::raster::Raster;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;

/// The maximum number of characters in a layer's or group's name. At four bytes each in UTF-8 they fit the
/// 255 bytes of a PSD's short name; Krita 5.1 writes a broken record for longer ones.
pub const LONGEST_NAME: usize = 63;

/// The name of the locked layer that shows what the photo shows of faces in no image layer.
pub const LEFTOVERS: &str = "leftovers - do not paint here";

/// The name of the guide that shows where the trees of the project are.
pub const TREE_GUIDE: &str = "guide of trees - do not paint here";

/// Returns the name of the guide of the group of this order.
pub fn guide_name(order: u32) -> String {
    format!("guide {order} - hatched parts are hidden: paint them")
}

/// A source of a layer's pixels. It may be called several times, and from any thread.
pub type PixelSource<'a> = Box<dyn Fn() -> Result<Arc<Raster>> + Send + Sync + 'a>;

/// A layered image without its pixels, which the layers' sources provide.
pub struct LayeredDocument<'a> {
    /// Width of the canvas in pixels.
    pub width: u32,
    /// Height of the canvas in pixels.
    pub height: u32,
    /// Bit depth of every layer and of the merged picture.
    pub depth: Depth,
    /// ICC profile of all pixels; without one viewers assume sRGB for 8 bits and disagree on 16.
    pub icc: Option<Vec<u8>>,
    /// The document key, which identifies the document on import.
    pub key: String,
    /// The photo's name, for messages.
    pub title: String,
    /// Layers and groups, from bottom to top.
    pub nodes: Vec<LayerNode<'a>>,
    /// The composite of all visible layers, as large as the canvas.
    pub merged: PixelSource<'a>,
}

/// A layer or a group of layers.
pub enum LayerNode<'a> {
    /// A layer outside any group.
    Layer(PixelLayer<'a>),
    /// A group of layers.
    Group(Group<'a>),
}

/// Layers that can be hidden together. A group is never empty: GIMP 2.10 crashes on saving an empty one.
pub struct Group<'a> {
    /// The group's unique name, at most [`LONGEST_NAME`] characters.
    pub name: String,
    /// The group's layers, from bottom to top.
    pub layers: Vec<PixelLayer<'a>>,
}

/// A layer: pixels at a position on the canvas.
pub struct PixelLayer<'a> {
    /// The layer's unique name, at most [`LONGEST_NAME`] characters. It is the only property of a layer that
    /// every editor preserves.
    pub name: String,
    /// Position and size in canvas pixels; may reach outside the canvas.
    pub rect: PixelRect,
    /// The token of the image layer, for formats that store one beside the name.
    pub id: Option<String>,
    /// Whether the layer is visible when the file is opened.
    pub visible: bool,
    /// Whether the layer is locked against changes, where the editor supports it.
    pub locked: bool,
    /// Whether the layer is selected when the file is opened; XCF and OpenRaster can store this.
    pub selected: bool,
    /// Whether the layer is meant to be laid over others in linear light; XCF can store this, other editors do it in the
    /// encoded values.
    pub linear_light: bool,
    /// The layer's colour in the list of layers.
    pub tag: Option<Tag>,
    /// The source of the pixels, which have the size of `rect`.
    pub pixels: PixelSource<'a>,
}

impl<'a> PixelLayer<'a> {
    /// Creates a visible, unlocked layer without token and colour tag. `pixels` provides pixels of the size
    /// of `rect`.
    pub fn new(name: impl Into<String>, rect: PixelRect, pixels: PixelSource<'a>) -> Self {
        Self {
            name: name.into(),
            rect,
            id: None,
            visible: true,
            locked: false,
            selected: false,
            linear_light: false,
            tag: None,
            pixels,
        }
    }
}

/// The colours with which editors mark layers in their lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Tag {
    Red,
    Orange,
    Yellow,
    Green,
    Blue,
    Violet,
    Grey,
}

impl<'a> LayeredDocument<'a> {
    /// Yields all layers, from bottom to top.
    pub fn layers(&self) -> impl Iterator<Item = &PixelLayer<'a>> {
        self.nodes.iter().flat_map(|node| match node {
            LayerNode::Layer(layer) => std::slice::from_ref(layer),
            LayerNode::Group(group) => group.layers.as_slice(),
        })
    }

    /// Checks what every format requires: unique names of limited length, no empty group.
    ///
    /// # Errors
    /// [`Error::Request`] that names the layer or group.
    pub fn check(&self) -> Result<()> {
        let mut seen = HashSet::new();
        for node in &self.nodes {
            if let LayerNode::Group(group) = node {
                if group.layers.is_empty() {
                    return Err(self.wrong(&group.name, "is a group without layers"));
                }
                self.check_name(&group.name, &mut seen)?;
            }
        }
        self.layers().try_for_each(|layer| self.check_name(&layer.name, &mut seen))
    }

    fn check_name<'n>(&self, name: &'n str, seen: &mut HashSet<&'n str>) -> Result<()> {
        if name.chars().count() > LONGEST_NAME {
            return Err(self.wrong(name, "is longer than 63 characters"));
        }
        if !seen.insert(name) {
            return Err(self.wrong(name, "names two layers or groups"));
        }
        Ok(())
    }

    fn wrong(&self, name: &str, what: &str) -> Error {
        Error::Request(format!("the layered image of {}: \"{name}\" {what}", self.title))
    }

    /// Returns the size in bytes of a layer's pixels in memory.
    pub fn bytes_of(&self, layer: &PixelLayer<'a>) -> u64 {
        4 * layer.rect.area() * self.depth.bytes()
    }

    /// Reads the pixels of a layer.
    ///
    /// # Errors
    /// The error of the source; [`Error::Request`] when it returns another size or depth than the layer has.
    pub fn pixels_of(&self, layer: &PixelLayer<'a>) -> Result<Arc<Raster>> {
        self.fetched(&layer.pixels, &layer.name, layer.rect.w, layer.rect.h)
    }

    /// Reads the merged picture.
    ///
    /// # Errors
    /// As [`Self::pixels_of`].
    pub(crate) fn merged_pixels(&self) -> Result<Arc<Raster>> {
        self.fetched(&self.merged, "merged picture", self.width, self.height)
    }

    fn fetched(&self, source: &PixelSource<'a>, name: &str, width: u32, height: u32) -> Result<Arc<Raster>> {
        let pixels = source()?;
        let found = (pixels.width(), pixels.height(), pixels.depth());
        if found == (width, height, self.depth) {
            Ok(pixels)
        } else {
            let (expected, (w, h, depth)) = (self.depth.bits(), found);
            let bits = depth.bits();
            let what =
                format!("has {w} x {h} pixels of {bits} bits, not {width} x {height} of {expected} bits");
            Err(self.wrong(name, &what))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(name: &str) -> PixelLayer<'static> {
        let rect = PixelRect::of_size(2, 2);
        let pixels: PixelSource = Box::new(|| Ok(Arc::new(Raster::blank(2, 3, Depth::Eight))));
        PixelLayer::new(name, rect, pixels)
    }

    fn document(nodes: Vec<LayerNode<'static>>) -> LayeredDocument<'static> {
        LayeredDocument {
            width: 2,
            height: 3,
            depth: Depth::Eight,
            icc: None,
            key: "k".into(),
            title: "a.png".into(),
            nodes,
            merged: Box::new(|| Ok(Arc::new(Raster::blank(2, 3, Depth::Eight)))),
        }
    }

    #[test]
    fn an_empty_group_is_refused() {
        let group = Group { name: "order 0".into(), layers: vec![] };
        let error = document(vec![LayerNode::Group(group)]).check().unwrap_err();
        assert!(error.to_string().contains("order 0"), "{error}");
    }

    #[test]
    fn two_layers_of_one_name_and_a_name_of_64_characters_are_refused() {
        let twice = document(vec![LayerNode::Layer(layer("a")), LayerNode::Layer(layer("a"))]);
        assert!(twice.check().is_err());
        assert!(document(vec![LayerNode::Layer(layer(&"ä".repeat(63)))]).check().is_ok());
        assert!(document(vec![LayerNode::Layer(layer(&"a".repeat(64)))]).check().is_err());
    }

    #[test]
    fn pixels_of_another_size_than_promised_are_an_error() {
        let document = document(vec![LayerNode::Layer(layer("a"))]);
        let error = document.pixels_of(document.layers().next().unwrap()).unwrap_err();
        assert!(error.to_string().contains("2 x 3 pixels"), "{error}");
        assert!(document.merged_pixels().is_ok());
    }
}
