//! Writes the properties of the image and of layers in an XCF: numbered, in lists.

use super::items::XcfItem;
use crate::psd::resources::escaped;
use crate::{LayeredDocument, PixelLayer, Tag};

/// The tag of [`parasite::METADATA`] that holds the document key, as in a PSD.
pub const KEY_TAG: &str = "Xmp.dc.identifier";

/// The numbers of properties.
pub mod number {
    pub const END: u32 = 0;
    pub const COLOUR_MAP: u32 = 1;
    pub const ACTIVE_LAYER: u32 = 2;
    pub const FLOATING_SELECTION: u32 = 5;
    pub const OPACITY: u32 = 6;
    pub const MODE: u32 = 7;
    pub const VISIBLE: u32 = 8;
    pub const LOCK_ALPHA: u32 = 10;
    pub const APPLY_MASK: u32 = 11;
    pub const OFFSETS: u32 = 15;
    pub const COMPRESSION: u32 = 17;
    pub const RESOLUTION: u32 = 19;
    pub const PARASITES: u32 = 21;
    pub const LOCK_CONTENT: u32 = 28;
    pub const GROUP_ITEM: u32 = 29;
    pub const ITEM_PATH: u32 = 30;
    pub const GROUP_FLAGS: u32 = 31;
    pub const LOCK_POSITION: u32 = 32;
    pub const FLOAT_OPACITY: u32 = 33;
    pub const COLOUR_TAG: u32 = 34;
    pub const COMPOSITE_MODE: u32 = 35;
}

/// Names of parasites: small pieces of data that GIMP preserves.
pub mod parasite {
    /// GIMP's parasite with the ICC profile.
    pub const ICC: &str = "icc-profile";
    /// GIMP's parasite with the comment, shown in the properties of the image.
    pub const COMMENT: &str = "gimp-comment";
    /// GIMP's parasite with the metadata: GIMP converts it to XMP when it exports to PSD, and converts a
    /// PSD's XMP to it when that is saved as XCF. It is XML: `<metadata>` with a `<tag
    /// name="Xmp.dc.identifier">` and others.
    pub const METADATA: &str = "gimp-image-metadata";
    /// The parasite with the document key.
    pub const KEY: &str = "quadratura-key";
    /// GIMP's parasite with the text of a text layer.
    pub const TEXT: &str = "gimp-text-layer";
    /// The parasite with the token of an image layer.
    pub const LAYER: &str = "quadratura-layer";
    /// Flags: the parasite stays with the file, and is subject to *Undo*.
    pub const PERSISTENT: u32 = 1;
    pub const UNDOABLE: u32 = 2;
}

/// The number of run-length encoding of tiles.
pub const RLE: u8 = 1;
/// The over operator as GIMP has always had it, and as it reads a PSD's normal mode.
const NORMAL: u32 = 0;
/// The over operator in linear light, the default of GIMP since 2.10.
const NORMAL_IN_LIGHT: u32 = 28;
/// The flag of a group whose layers are shown in the list.
const EXPANDED: u32 = 1;
/// Resolution in pixels per inch; photos have none, but GIMP asks for one.
const PER_INCH: f32 = 72.0;

/// Encodes the properties of the image.
pub fn image_properties(document: &LayeredDocument) -> Vec<u8> {
    let mut out = Vec::new();
    put(&mut out, number::COMPRESSION, &[RLE]);
    put(&mut out, number::RESOLUTION, &[PER_INCH.to_be_bytes(), PER_INCH.to_be_bytes()].concat());
    let mut parasites = Vec::new();
    if let Some(icc) = &document.icc {
        put_parasite(&mut parasites, parasite::ICC, parasite::PERSISTENT | parasite::UNDOABLE, icc);
    }
    put_parasite(&mut parasites, parasite::KEY, parasite::PERSISTENT, document.key.as_bytes());
    let comment = [document.title.as_bytes(), &[0]].concat(); // GIMP wants the NUL here
    put_parasite(&mut parasites, parasite::COMMENT, parasite::PERSISTENT, &comment);
    put_parasite(&mut parasites, parasite::METADATA, parasite::PERSISTENT, metadata(document).as_bytes());
    put(&mut out, number::PARASITES, &parasites);
    put(&mut out, number::END, &[]);
    out
}

/// Returns the metadata with a trailing NUL, as GIMP writes it.
fn metadata(document: &LayeredDocument) -> String {
    let (key, title) = (escaped(&document.key), escaped(&document.title));
    format!(
        "<?xml version='1.0' encoding='UTF-8'?>\n<metadata>\n  <tag name=\"{KEY_TAG}\">{key}</tag>\n  \
         <tag name=\"Xmp.dc.title\">{title}</tag>\n</metadata>\n\0"
    )
}

/// Encodes the properties of a layer or group.
pub fn layer_properties(item: &XcfItem) -> Vec<u8> {
    let mut out = Vec::new();
    if matches!(item, XcfItem::Group(_)) {
        // GIMP forgets what it has read of an entry when it learns that this is a group.
        put(&mut out, number::GROUP_ITEM, &[]);
    }
    put_number(&mut out, number::OPACITY, 255);
    // A group is laid over what is below as a whole.
    let linear_light = match item {
        XcfItem::Group(group) => group.layers.iter().any(|layer| layer.linear_light),
        XcfItem::Layer(layer, _) => layer.linear_light,
    };
    put_number(&mut out, number::MODE, if linear_light { NORMAL_IN_LIGHT } else { NORMAL });
    match item {
        XcfItem::Group(_) => {
            put_number(&mut out, number::VISIBLE, 1);
            put(&mut out, number::OFFSETS, &[0; 8]);
            put_number(&mut out, number::GROUP_FLAGS, EXPANDED);
        }
        XcfItem::Layer(layer, path) => put_layer(&mut out, layer, *path),
    }
    put(&mut out, number::END, &[]);
    out
}

fn put_layer(out: &mut Vec<u8>, layer: &PixelLayer, path: Option<[u32; 2]>) {
    put_number(out, number::VISIBLE, layer.visible.into());
    put(out, number::OFFSETS, &[layer.rect.x.to_be_bytes(), layer.rect.y.to_be_bytes()].concat());
    let locked = layer.locked.into();
    for lock in [number::LOCK_ALPHA, number::LOCK_CONTENT, number::LOCK_POSITION] {
        put_number(out, lock, locked);
    }
    put_number(out, number::COLOUR_TAG, tag_number(layer.tag));
    if layer.selected {
        put(out, number::ACTIVE_LAYER, &[]);
    }
    if let Some(id) = &layer.id {
        let mut parasites = Vec::new();
        put_parasite(&mut parasites, parasite::LAYER, parasite::PERSISTENT, id.as_bytes());
        put(out, number::PARASITES, &parasites);
    }
    if let Some(path) = path {
        put(out, number::ITEM_PATH, path.map(u32::to_be_bytes).as_flattened());
    }
}

fn tag_number(tag: Option<Tag>) -> u32 {
    match tag {
        None => 0,
        Some(Tag::Blue) => 1,
        Some(Tag::Green) => 2,
        Some(Tag::Yellow) => 3,
        Some(Tag::Orange) => 4,
        Some(Tag::Red) => 6,
        Some(Tag::Violet) => 7,
        Some(Tag::Grey) => 8,
    }
}

fn put(out: &mut Vec<u8>, number: u32, payload: &[u8]) {
    out.extend(number.to_be_bytes());
    out.extend((payload.len() as u32).to_be_bytes());
    out.extend(payload);
}

fn put_number(out: &mut Vec<u8>, number: u32, value: u32) {
    put(out, number, &value.to_be_bytes());
}

fn put_parasite(out: &mut Vec<u8>, name: &str, flags: u32, data: &[u8]) {
    put_text(out, name);
    out.extend(flags.to_be_bytes());
    out.extend((data.len() as u32).to_be_bytes());
    out.extend(data);
}

/// Appends a text with its length and a trailing NUL; an empty text is a length of 0.
pub fn put_text(out: &mut Vec<u8>, text: &str) {
    let text: String = text.chars().filter(|c| *c != '\0').collect();
    if text.is_empty() {
        return out.extend([0; 4]);
    }
    out.extend((text.len() as u32 + 1).to_be_bytes());
    out.extend(text.as_bytes());
    out.push(0);
}
