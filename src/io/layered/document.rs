//! What a layered file says, whatever its format.

use std::collections::HashSet;
use std::sync::Arc;

use super::depth::Depth;
use super::raster::Raster;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;

/// The most characters of a layer's or group's name. Four bytes each in UTF-8 still fit the 255 of
/// a PSD's short name; Krita 5.1 writes a broken record for longer ones.
pub const LONGEST_NAME: usize = 63;

/// Where a layer's pixels come from. It may be asked more than once, and from any thread.
pub type Source<'a> = Box<dyn Fn() -> Result<Arc<Raster>> + Send + Sync + 'a>;

/// A layered image without its pixels, which the layers yield when asked.
pub struct LayeredDocument<'a> {
    /// Canvas, in pixels.
    pub width: u32,
    /// Canvas, in pixels.
    pub height: u32,
    /// Of every layer and of the merged picture.
    pub depth: Depth,
    /// The colour profile of all pixels; without one viewers take 8 bits for sRGB, and disagree on 16.
    pub icc: Option<Vec<u8>>,
    /// What the document is known by when it comes back.
    pub key: String,
    /// For people: the photo's name.
    pub title: String,
    /// From the bottom to the top.
    pub nodes: Vec<Node<'a>>,
    /// The picture of all visible layers, as large as the canvas.
    pub merged: Source<'a>,
}

/// A layer or a group of layers.
pub enum Node<'a> {
    /// A layer outside any group.
    Layer(Layer<'a>),
    /// Layers that can be hidden together.
    Group(Group<'a>),
}

/// Layers that can be hidden together. Never empty: GIMP 2.10 crashes on saving an empty one.
pub struct Group<'a> {
    /// Unique, at most [`LONGEST_NAME`] characters.
    pub name: String,
    /// From the bottom to the top.
    pub layers: Vec<Layer<'a>>,
}

/// Pixels with a place on the canvas.
pub struct Layer<'a> {
    /// Unique, at most [`LONGEST_NAME`] characters: the only thing about a layer that every editor
    /// gives back.
    pub name: String,
    /// In canvas pixels; may reach outside the canvas.
    pub rect: PixelRect,
    /// The token of the image layer, for formats that keep one beside the name.
    pub id: Option<String>,
    /// Shown when the file is opened.
    pub visible: bool,
    /// Not to be changed, where the editor knows such a thing.
    pub locked: bool,
    /// The one that is painted on when the file is opened, where the format can say so: XCF and OpenRaster can.
    pub selected: bool,
    /// Its colour in the list of layers.
    pub tag: Option<Tag>,
    /// As large as `rect`.
    pub pixels: Source<'a>,
}

impl<'a> Layer<'a> {
    /// A layer as most are: shown, free to be changed, with nothing but its name to be known by. `pixels`: as large as
    /// `rect`.
    pub fn new(name: impl Into<String>, rect: PixelRect, pixels: Source<'a>) -> Self {
        let (name, id, tag) = (name.into(), None, None);
        Self { name, rect, id, visible: true, locked: false, selected: false, tag, pixels }
    }
}

/// The colours by which editors mark layers in their lists.
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
    /// All layers, from the bottom to the top.
    pub fn layers(&self) -> impl Iterator<Item = &Layer<'a>> {
        self.nodes.iter().flat_map(|node| match node {
            Node::Layer(layer) => std::slice::from_ref(layer),
            Node::Group(group) => group.layers.as_slice(),
        })
    }

    /// Checks what every format relies on: names unique and not too long, no empty group.
    ///
    /// # Errors
    /// [`Error::Request`] that names the offender.
    pub fn check(&self) -> Result<()> {
        let mut seen = HashSet::new();
        for node in &self.nodes {
            if let Node::Group(group) = node {
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

    /// What the pixels of one of its layers take.
    pub fn bytes_of(&self, layer: &Layer<'a>) -> u64 {
        4 * layer.rect.area() * self.depth.bytes()
    }

    /// The pixels of one of its layers.
    ///
    /// # Errors
    /// What the source says; [`Error::Request`] when it yields another size or depth than promised.
    pub fn pixels_of(&self, layer: &Layer<'a>) -> Result<Arc<Raster>> {
        self.fetched(&layer.pixels, &layer.name, layer.rect.w, layer.rect.h)
    }

    /// The merged picture.
    ///
    /// # Errors
    /// As [`Self::pixels_of`].
    pub fn merged_pixels(&self) -> Result<Arc<Raster>> {
        self.fetched(&self.merged, "merged picture", self.width, self.height)
    }

    fn fetched(&self, source: &Source<'a>, name: &str, width: u32, height: u32) -> Result<Arc<Raster>> {
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

    fn layer(name: &str) -> Layer<'static> {
        let rect = PixelRect::of_size(2, 2);
        let pixels: Source = Box::new(|| Ok(Arc::new(Raster::blank(2, 3, Depth::Eight))));
        Layer::new(name, rect, pixels)
    }

    fn document(nodes: Vec<Node<'static>>) -> LayeredDocument<'static> {
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
        let error = document(vec![Node::Group(group)]).check().unwrap_err();
        assert!(error.to_string().contains("order 0"), "{error}");
    }

    #[test]
    fn two_layers_of_one_name_and_a_name_of_64_characters_are_refused() {
        let twice = document(vec![Node::Layer(layer("a")), Node::Layer(layer("a"))]);
        assert!(twice.check().is_err());
        assert!(document(vec![Node::Layer(layer(&"ä".repeat(63)))]).check().is_ok());
        assert!(document(vec![Node::Layer(layer(&"a".repeat(64)))]).check().is_err());
    }

    #[test]
    fn pixels_of_another_size_than_promised_are_an_error() {
        let document = document(vec![Node::Layer(layer("a"))]);
        let error = document.pixels_of(document.layers().next().unwrap()).unwrap_err();
        assert!(error.to_string().contains("2 x 3 pixels"), "{error}");
        assert!(document.merged_pixels().is_ok());
    }
}
