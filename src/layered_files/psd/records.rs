//! Writes the list of layers in a PSD, without their pixels.
//!
//! The list goes from bottom to top. A group is a closing record, its layers, and an opening record with its
//! name; both have four empty channels.

use super::variant::PsdVariant;
use crate::{Group, LayerNode, LayeredDocument, PixelLayer, Tag};
use quadratura_base::geometry::PixelRect;

/// The channels of a pixel in the order in which a layer stores them.
pub const CHANNELS: [usize; 4] = [3, 0, 1, 2];
/// The ids of these channels in a PSD; that of alpha is -1.
const CHANNEL_IDS: [i16; 4] = [-1, 0, 1, 2];
/// The bytes of an empty channel: compression method 0, no data.
pub const EMPTY_CHANNEL: [u8; 2] = [0, 0];

/// An entry of the list.
#[derive(Clone, Copy)]
pub enum WrittenRecord<'d, 'a> {
    /// The record below a group's layers.
    GroupEnd,
    /// A layer.
    Layer(&'d PixelLayer<'a>),
    /// The record above a group's layers.
    GroupStart(&'d Group<'a>),
}

/// Lengths of the four channels of each record, in bytes.
pub type ChannelLengths = Vec<[u64; 4]>;

/// Returns all records, from bottom to top.
pub fn records<'d, 'a>(document: &'d LayeredDocument<'a>) -> Vec<WrittenRecord<'d, 'a>> {
    let mut list = Vec::new();
    for node in &document.nodes {
        match node {
            LayerNode::Layer(layer) => list.push(WrittenRecord::Layer(layer)),
            LayerNode::Group(group) => {
                list.push(WrittenRecord::GroupEnd);
                list.extend(group.layers.iter().map(WrittenRecord::Layer));
                list.push(WrittenRecord::GroupStart(group));
            }
        }
    }
    list
}

/// Encodes the number of records and the records. The length in bytes does not depend on `lengths`.
pub fn record_list(records: &[WrittenRecord], lengths: &ChannelLengths, kind: PsdVariant) -> Vec<u8> {
    let count = i16::try_from(records.len()).expect("the caller checked their number");
    let mut out = count.to_be_bytes().to_vec();
    for (index, (record, lengths)) in records.iter().zip(lengths).enumerate() {
        put_record(&mut out, record, index as u32 + 1, lengths, kind);
    }
    out
}

fn put_record(out: &mut Vec<u8>, record: &WrittenRecord, id: u32, lengths: &[u64; 4], kind: PsdVariant) {
    let rect = record.rect();
    for edge in [rect.y, rect.x, rect.bottom(), rect.right()] {
        out.extend(edge.to_be_bytes());
    }
    out.extend((CHANNEL_IDS.len() as u16).to_be_bytes());
    for (channel, length) in CHANNEL_IDS.iter().zip(lengths) {
        out.extend(channel.to_be_bytes());
        kind.put_length(out, *length);
    }
    out.extend(b"8BIM");
    out.extend(record.blend_mode());
    out.extend([255, 0, record.flags(), 0]); // opaque, not clipped to the layer below
    let extra = extra(record, id);
    out.extend((extra.len() as u32).to_be_bytes());
    out.extend(extra);
}

/// Encodes the rest of a record: no mask, no blending ranges, the short name, and the blocks of later
/// versions.
fn extra(record: &WrittenRecord, id: u32) -> Vec<u8> {
    let mut out = vec![0; 8];
    put_short_name(&mut out, record.name());
    put_block(&mut out, b"luni", &long_name(record.name()));
    put_block(&mut out, b"lyid", &id.to_be_bytes());
    match record {
        WrittenRecord::GroupEnd => put_block(&mut out, b"lsct", &3u32.to_be_bytes()),
        WrittenRecord::GroupStart(_) => {
            put_block(&mut out, b"lsct", &[&1u32.to_be_bytes()[..], b"8BIM", b"pass"].concat());
        }
        WrittenRecord::Layer(layer) => {
            if layer.locked {
                put_block(&mut out, b"lspf", &LOCK_ALL.to_be_bytes());
            }
            put_block(&mut out, b"lclr", &[0, tag_number(layer.tag), 0, 0, 0, 0, 0, 0]);
        }
    }
    out
}

/// The value that Photoshop writes for "Lock all".
const LOCK_ALL: u32 = 0x8000_0000;

fn put_block(out: &mut Vec<u8>, key: &[u8; 4], bytes: &[u8]) {
    out.extend(b"8BIM");
    out.extend(key);
    out.extend((bytes.len() as u32).to_be_bytes());
    out.extend(bytes);
}

/// Writes the name in ASCII, padded to four bytes; the encoding of this field depends on the reader's
/// language.
fn put_short_name(out: &mut Vec<u8>, name: &str) {
    let ascii: Vec<u8> = name.chars().map(|c| if c.is_ascii() { c as u8 } else { b'_' }).collect();
    out.push(ascii.len() as u8);
    out.extend(&ascii);
    out.extend(std::iter::repeat_n(0, (4 - (1 + ascii.len()) % 4) % 4));
}

fn long_name(name: &str) -> Vec<u8> {
    let units: Vec<u16> = name.encode_utf16().collect();
    let mut out = (units.len() as u32).to_be_bytes().to_vec();
    out.extend(units.iter().flat_map(|unit| unit.to_be_bytes()));
    out
}

fn tag_number(tag: Option<Tag>) -> u8 {
    match tag {
        None => 0,
        Some(Tag::Red) => 1,
        Some(Tag::Orange) => 2,
        Some(Tag::Yellow) => 3,
        Some(Tag::Green) => 4,
        Some(Tag::Blue) => 5,
        Some(Tag::Violet) => 6,
        Some(Tag::Grey) => 7,
    }
}

impl WrittenRecord<'_, '_> {
    fn name(&self) -> &str {
        match self {
            Self::GroupEnd => "</Layer group>",
            Self::Layer(layer) => &layer.name,
            Self::GroupStart(group) => &group.name,
        }
    }

    fn rect(&self) -> PixelRect {
        match self {
            Self::Layer(layer) => layer.rect,
            _ => PixelRect::EMPTY,
        }
    }

    fn blend_mode(&self) -> &'static [u8; 4] {
        match self {
            Self::GroupStart(_) => b"pass",
            _ => b"norm",
        }
    }

    fn flags(&self) -> u8 {
        const KEEP_ALPHA: u8 = 1;
        const HIDDEN: u8 = 2;
        const VERSION_5: u8 = 8; // says that the next bit means something
        const NO_PIXELS: u8 = 16;
        match self {
            Self::Layer(layer) => {
                let hidden = if layer.visible { 0 } else { HIDDEN };
                VERSION_5 | hidden | if layer.locked { KEEP_ALPHA } else { 0 }
            }
            _ => VERSION_5 | NO_PIXELS,
        }
    }
}
