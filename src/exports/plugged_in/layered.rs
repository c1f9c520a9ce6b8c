//! A layered format as small as one can be: whatever knows layered formats must know it, too. It takes the place of XCF.

#![cfg(test)]

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;
use quadratura_document::export_record::ExportFormat;
use quadratura_layered_files::document::LayeredDocument;
use quadratura_layered_files::edited::{BlendMode, EditedDocument, EditedLayer, Lazy};
use quadratura_layered_files::format::{FileFormat, LayeredFormat, Variant};
use quadratura_layered_files::{Depth, FileBytes, FormatFit, Raster};

/// The entry of the dummy format in the registry.
pub const FORMAT: LayeredFormat = LayeredFormat {
    format: ExportFormat::Xcf,
    title: "Dummy",
    name: "dummy",
    about: "A format for tests",
    file: Some(FileFormat {
        extensions: &["dummy"],
        signature: b"dummy layers\n",
        variants: |_| vec![Variant { extension: "dummy", write }],
        read,
    }),
};

/// Behind the signature and before the pixels, as JSON that ends with a line feed.
#[derive(Serialize, Deserialize)]
struct DummyHeader {
    size: [u32; 2],
    key: String,
    /// Name and rectangle, from the bottom to the top; 8 bits of R, G, B, A follow in the same order.
    layers: Vec<(String, PixelRect)>,
}

fn write(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    document.check()?;
    let layers = document.layers().map(|layer| (layer.name.clone(), layer.rect)).collect();
    let head = DummyHeader { size: [document.width, document.height], key: document.key.clone(), layers };
    let mut bytes = b"dummy layers\n".to_vec();
    bytes.extend(serde_json::to_vec(&head).unwrap());
    bytes.push(b'\n');
    for layer in document.layers() {
        let pixels = document.pixels_of(layer)?;
        let Samples::U8(samples) = pixels.samples() else {
            return Err(Error::Request("the dummy has 8 bits".into()));
        };
        bytes.extend(samples);
    }
    file.write_all(&bytes).map_err(Error::io(path, "write it"))?;
    Ok(FormatFit::Whole)
}

fn read(bytes: &Arc<FileBytes>) -> Result<EditedDocument> {
    let mut whole = Vec::new();
    File::open(bytes.path()).unwrap().read_to_end(&mut whole).unwrap();
    let mut parts = whole.splitn(3, |byte| *byte == b'\n');
    let (_, head, pixels) = (parts.next(), parts.next().unwrap(), parts.next().unwrap());
    let head: DummyHeader = serde_json::from_slice(head).unwrap();
    let mut pixels = pixels;
    let layer = |(name, rect): (String, PixelRect)| {
        let (own, rest) = pixels.split_at(4 * rect.area() as usize);
        pixels = rest;
        let own = own.to_vec();
        let raster = move || Ok(Raster::new(rect.w, rect.h, Samples::U8(own.clone())));
        EditedLayer { blend: BlendMode::Normal, ..EditedLayer::plain(&name, rect, Lazy::new(raster)) }
    };
    let layers = head.layers.into_iter().map(layer).collect();
    Ok(EditedDocument {
        format: ExportFormat::Xcf,
        width: head.size[0],
        height: head.size[1],
        depth: Depth::Eight,
        rounding: None,
        icc: None,
        key: Some(head.key),
        layers,
        notes: Vec::new(),
    })
}
