//! Random layered documents, small enough to be written and read hundreds of times.

use std::fs::File;
use std::io::{BufWriter, Cursor};
use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::layered_files::psd::{self, PsdVariant};
use quadratura::testing::layered_files::xcf::{self, XcfVersion};
use quadratura::testing::layered_files::{
    Depth, FormatFit, Group, LayerNode, LayeredDocument, PixelLayer, PixelSource, Raster, ora,
};
use quadratura::testing::scene::Samples;

/// A document in plain values.
#[derive(Debug, Clone)]
pub struct Plan {
    pub size: (u32, u32),
    pub depth: Depth,
    pub icc: Option<Vec<u8>>,
    /// From the bottom; those of a group follow each other.
    pub layers: Vec<LayerPlan>,
}

#[derive(Debug, Clone)]
pub struct LayerPlan {
    pub group: Option<usize>,
    pub rect: PixelRect,
    pub visible: bool,
    pub locked: bool,
    pub seed: u32,
}

impl LayerPlan {
    pub fn name(&self, index: usize) -> String {
        format!("Säule <{index}> & 門 [t{index}]")
    }

    pub fn id(&self, index: usize) -> String {
        format!("t{index}")
    }

    pub fn groups(&self) -> Vec<String> {
        self.group.map(group_name).into_iter().collect()
    }

    /// Noise, runs and emptiness; colours under transparent pixels, too.
    pub fn pixels(&self, depth: Depth) -> Raster {
        let PixelRect { w, h, .. } = self.rect;
        let value = |i: u32| match (i / 4 + self.seed) / 9 % 3 {
            0 => 0,
            1 => i.wrapping_add(self.seed).wrapping_mul(2_654_435_761),
            _ => 0xd031_7720u32.wrapping_mul(self.seed + 1),
        };
        let samples = 0..4 * w * h;
        let samples = match depth {
            Depth::Eight => Samples::U8(samples.map(|i| (value(i) >> 24) as u8).collect()),
            Depth::Sixteen => Samples::U16(samples.map(|i| (value(i) >> 16) as u16).collect()),
        };
        Raster::new(w, h, samples)
    }
}

fn group_name(number: usize) -> String {
    format!("order {number}")
}

pub const KEY: &str = "k0123456789abcdef";

impl Plan {
    pub fn document(&self) -> LayeredDocument<'_> {
        let mut nodes: Vec<LayerNode> = Vec::new();
        for (index, layer) in self.layers.iter().enumerate() {
            let node = self.layer(index, layer);
            match (layer.group, nodes.last_mut()) {
                (Some(number), Some(LayerNode::Group(group))) if group.name == group_name(number) => {
                    group.layers.push(node);
                }
                (Some(number), _) => {
                    nodes.push(LayerNode::Group(Group { name: group_name(number), layers: vec![node] }));
                }
                (None, _) => nodes.push(LayerNode::Layer(node)),
            }
        }
        let (width, height) = self.size;
        let merged: PixelSource = Box::new(move || Ok(Arc::new(Raster::blank(width, height, self.depth))));
        let (depth, icc) = (self.depth, self.icc.clone());
        LayeredDocument { width, height, depth, icc, key: KEY.into(), title: "a.png".into(), nodes, merged }
    }

    fn layer<'a>(&'a self, index: usize, layer: &'a LayerPlan) -> PixelLayer<'a> {
        let pixels = Box::new(move || Ok(Arc::new(layer.pixels(self.depth))));
        PixelLayer {
            id: Some(layer.id(index)),
            visible: layer.visible,
            locked: layer.locked,
            selected: index == 0,
            ..PixelLayer::new(layer.name(index), layer.rect, pixels)
        }
    }

    /// Writes it to `file` in this format.
    pub fn write(&self, file: &Path, format: Format) {
        let document = self.document();
        match format {
            Format::Psd(kind) => {
                assert_eq!(
                    psd::write(File::create(file).unwrap(), file, &document, kind).unwrap(),
                    FormatFit::Whole
                );
            }
            Format::Xcf(version) => {
                assert_eq!(
                    xcf::write(File::create(file).unwrap(), file, &document, version).unwrap(),
                    FormatFit::Whole
                );
            }
            Format::Ora => {
                ora::write(BufWriter::new(File::create(file).unwrap()), file, &document).unwrap();
            }
        }
    }

    /// The bytes of such a file.
    pub fn bytes(&self, format: Format) -> Vec<u8> {
        let (document, path, mut out) = (self.document(), Path::new("test"), Cursor::new(Vec::new()));
        match format {
            Format::Psd(kind) => drop(psd::write(&mut out, path, &document, kind).unwrap()),
            Format::Xcf(version) => drop(xcf::write(&mut out, path, &document, version).unwrap()),
            Format::Ora => ora::write(&mut out, path, &document).unwrap(),
        }
        out.into_inner()
    }
}

/// What is written.
#[derive(Debug, Clone, Copy)]
pub enum Format {
    Psd(PsdVariant),
    Xcf(XcfVersion),
    Ora,
}

/// XCF of this depth: 8 bits in either width of pointers.
pub fn xcf_of(depth: Depth, wide: bool) -> Format {
    Format::Xcf(match (depth, wide) {
        (Depth::Sixteen, _) => XcfVersion::Twelve,
        (Depth::Eight, true) => XcfVersion::Eleven,
        (Depth::Eight, false) => XcfVersion::Three,
    })
}

/// Documents of up to 7 layers, some of them outside the canvas, empty, or larger than a tile.
pub fn plans() -> impl Strategy<Value = Plan> {
    let depth = prop_oneof![Just(Depth::Eight), Just(Depth::Sixteen)];
    let icc = prop_oneof![Just(None), proptest::collection::vec(any::<u8>(), 130..150).prop_map(Some)];
    let layers = proptest::collection::vec(layer_plans(), 1..7);
    ((1u32..90, 1u32..90), depth, icc, layers).prop_map(|(size, depth, icc, mut layers)| {
        // Layers of one group follow each other, and no group comes twice.
        layers.sort_by_key(|layer| layer.group);
        Plan { size, depth, icc, layers }
    })
}

fn layer_plans() -> impl Strategy<Value = LayerPlan> {
    let rect = (-70i32..100, -70i32..100, 1u32..140, 1u32..80);
    let rect = rect.prop_map(|(x, y, w, h)| PixelRect { x, y, w, h });
    let group = proptest::option::of(0usize..3);
    (group, rect, any::<bool>(), any::<bool>(), 0u32..1000)
        .prop_map(|(group, rect, visible, locked, seed)| LayerPlan { group, rect, visible, locked, seed })
}
