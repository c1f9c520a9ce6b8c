//! Reads the list of layers in a PSD, with the positions of their channels.

use super::blocks::{BlockProperties, next_block};
use super::head::{PsdHeader, wide};
use super::masks::{MaskRecord, REAL_MASK, read_mask};
use super::names;
use crate::bytes::Cursor;
use crate::place::rect_at;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;

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
    /// The kind of the channel: 0 red or grey, 1 green, 2 blue, -1 alpha, -2 mask, -3 the other mask of a layer that
    /// has a pixel mask and a vector mask.
    pub id: i16,
    pub at: u64,
    pub length: u64,
}

/// Reads the list; `cursor` contains it and the channels behind it.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when the list is damaged, or when the file ends before the channels do.
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
            .collect::<Result<Vec<_>>>()?;
        let signature: [u8; 4] = cursor.array()?;
        if &signature != b"8BIM" {
            let what = signature.escape_ascii();
            return Err(cursor.damaged(format!("\"{what}\" was found in a layer, expected 8BIM")));
        }
        let blend = cursor.array()?;
        let [opacity, clipping, flags, _]: [u8; 4] = cursor.array()?;
        let length = cursor.u32()?;
        let mut extra = cursor.part(length.into())?;
        let has_real_mask = channels.iter().any(|channel| channel.id == REAL_MASK);
        let mask = read_mask(&mut extra, rect, has_real_mask)?;
        let mut extras = BlockProperties::default();
        if blends_by_ranges(&mut extra)? {
            extras.display.push("Blend If");
        }
        let short_name = names::short(&mut extra)?;
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
pub fn read_rect(cursor: &mut Cursor) -> Result<PixelRect> {
    let edges = [cursor.i32()?, cursor.i32()?, cursor.i32()?, cursor.i32()?];
    let [top, left, bottom, right] = edges.map(i64::from);
    let found = || format!("a rectangle from ({left}, {top}) to ({right}, {bottom})");
    rect_at(left, top, right - left, bottom - top).ok_or_else(|| cursor.damaged(found()))
}

/// Reads the blending ranges; true when they hide part of the layer or of what is below it (Blend If). Each is four
/// bytes: two for where black ends, two for where white begins. Writers leave those of unused channels empty.
fn blends_by_ranges(extra: &mut Cursor) -> Result<bool> {
    const EVERYTHING: [u8; 4] = [0, 0, 255, 255];
    let length = extra.u32()?;
    let ranges = extra.take(length.into())?;
    Ok(ranges.as_chunks::<4>().0.iter().any(|range| *range != EVERYTHING && *range != [0; 4]))
}
