//! Reads the list of layers in a PSD, with the positions of their channels.

use super::blocks::{BlockProperties, next_block};
use super::head::PsdHeader;
use super::{names, wide};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layered::bytes::Cursor;
use crate::io::layered::place::rect_at;

/// An entry of the list: a layer, or one of the two ends of a group.
#[derive(Debug)]
pub struct Record {
    /// The position in the file, in bytes.
    pub at: u64,
    pub rect: PixelRect,
    pub channels: Vec<ChannelPosition>,
    pub blend: [u8; 4],
    pub opacity: u8,
    /// Whether the layer is clipped to the layer below.
    pub clipped: bool,
    pub visible: bool,
    pub mask: Option<MaskRecord>,
    pub name: String,
    pub extras: BlockProperties,
}

/// The position of a channel's code in the file.
#[derive(Debug, Clone, Copy)]
pub struct ChannelPosition {
    /// The kind of the channel: 0 red or grey, 1 green, 2 blue, -1 alpha, -2 mask.
    pub id: i16,
    pub at: u64,
    pub length: u64,
}

/// A record's mask.
#[derive(Debug, Clone, Copy)]
pub struct MaskRecord {
    /// Position and size in canvas pixels.
    pub rect: PixelRect,
    /// The value outside `rect`.
    pub outside: u8,
    pub enabled: bool,
    pub inverted: bool,
}

/// Reads the list; `cursor` contains it and the channels behind it.
///
/// # Errors
/// [`crate::Error::Input`] when the list is damaged, or when the file ends before the channels do.
pub fn read_records(cursor: &mut Cursor, head: &PsdHeader) -> Result<Vec<Record>> {
    // A negative count means that the merged picture has an alpha channel.
    let count = cursor.i16()?.unsigned_abs();
    let mut records = Vec::new();
    for _ in 0..count {
        records.push(Record::read(cursor, head)?);
    }
    for channel in records.iter_mut().flat_map(|record| &mut record.channels) {
        channel.at = cursor.at();
        cursor.skip(channel.length)?;
    }
    Ok(records)
}

impl Record {
    fn read(cursor: &mut Cursor, head: &PsdHeader) -> Result<Self> {
        let at = cursor.at();
        let rect = read_rect(cursor)?;
        let channels = (0..cursor.u16()?)
            .map(|_| Ok(ChannelPosition { id: cursor.i16()?, length: wide(cursor, head.kind)?, at: 0 }))
            .collect::<Result<_>>()?;
        let signature: [u8; 4] = cursor.array()?;
        if &signature != b"8BIM" {
            let what = signature.escape_ascii();
            return Err(cursor.damaged(format!("\"{what}\" was found in a layer, expected 8BIM")));
        }
        let blend = cursor.array()?;
        let [opacity, clipping, flags, _]: [u8; 4] = cursor.array()?;
        let length = cursor.u32()?;
        let mut extra = cursor.part(length.into())?;
        let mask = read_mask(&mut extra, rect)?;
        let ranges = extra.u32()?;
        extra.skip(ranges.into())?;
        let short_name = names::short(&mut extra)?;
        let mut extras = BlockProperties::default();
        while let Some(mut block) = next_block(&mut extra, head.kind)? {
            extras.take(&mut block)?;
        }
        const HIDDEN: u8 = 2;
        let name = extras.name.take().unwrap_or(short_name);
        let (clipped, visible) = (clipping != 0, flags & HIDDEN == 0);
        Ok(Self { at, rect, channels, blend, opacity, clipped, visible, mask, name, extras })
    }

    /// Returns the channel with this id.
    pub fn channel(&self, id: i16) -> Option<ChannelPosition> {
        self.channels.iter().copied().find(|channel| channel.id == id)
    }
}

/// Reads a rectangle, stored as top, left, bottom, right.
fn read_rect(cursor: &mut Cursor) -> Result<PixelRect> {
    let edges = [cursor.i32()?, cursor.i32()?, cursor.i32()?, cursor.i32()?];
    let [top, left, bottom, right] = edges.map(i64::from);
    let found = || format!("a rectangle from ({left}, {top}) to ({right}, {bottom})");
    rect_at(left, top, right - left, bottom - top).ok_or_else(|| cursor.damaged(found()))
}

/// Reads a mask, which takes 0 or 20 bytes; longer ones repeat themselves in more detail.
fn read_mask(extra: &mut Cursor, layer: PixelRect) -> Result<Option<MaskRecord>> {
    let length = extra.u32()?;
    let mut content = extra.part(length.into())?;
    if length == 0 {
        return Ok(None);
    }
    let mut rect = read_rect(&mut content)?;
    let [outside, flags] = content.array()?;
    const RELATIVE: u8 = 1;
    const OFF: u8 = 2;
    const INVERTED: u8 = 4;
    if flags & RELATIVE != 0 {
        (rect.x, rect.y) = (rect.x + layer.x, rect.y + layer.y);
    }
    Ok(Some(MaskRecord { rect, outside, enabled: flags & OFF == 0, inverted: flags & INVERTED != 0 }))
}
