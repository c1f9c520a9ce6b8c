//! Converts records to layers: groups become names, channels become pixels when they are requested.

use std::sync::Arc;

use rayon::prelude::*;

use super::blocks::GroupRole;
use super::head::PsdHeader;
use super::masks::{MASK, edited_mask};
use super::names::blend_name;
use super::planes::{Coding, hash_of_code, read_plane};
use super::records::{ChannelPosition, Record};
use crate::bytes::FileBytes;
use crate::groups::{GroupProperties, OpenGroups};
use crate::{BlendMode, Depth, EditedLayer, Lazy, Raster, StoredColours};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;

const ALPHA: i16 = -1;

/// Converts `records` to layers, both from bottom to top.
pub fn from_records(
    records: Vec<Record>,
    head: &PsdHeader,
    bytes: &Arc<FileBytes>,
    notes: &mut Vec<String>,
) -> Vec<EditedLayer> {
    let mut groups = OpenGroups::default();
    let mut layers = Vec::new();
    for record in records.into_iter().rev() {
        match record.extras.section {
            Some(GroupRole::GroupStart(blend)) => {
                note_unread(&record, "group", notes);
                groups.open(group_traits(&record, blend, head, bytes));
            }
            Some(GroupRole::GroupEnd) => groups.close(notes),
            None => layers.extend(layer(&record, head, bytes, &groups, notes)),
        }
    }
    groups.finish(notes);
    layers.reverse();
    layers
}

fn group_traits(
    record: &Record,
    blend: Option<[u8; 4]>,
    head: &PsdHeader,
    bytes: &Arc<FileBytes>,
) -> GroupProperties {
    let blend = blend.unwrap_or(record.blend);
    GroupProperties {
        name: record.name.clone(),
        visible: record.visible,
        opacity: opacity(record),
        mask: edited_mask(record, head, bytes).map(Arc::new),
        blend: blend_with(record, &blend),
    }
}

fn layer(
    record: &Record,
    head: &PsdHeader,
    bytes: &Arc<FileBytes>,
    groups: &OpenGroups,
    notes: &mut Vec<String>,
) -> Option<EditedLayer> {
    if let Some(what) = record.extras.computed {
        notes.push(format!("layer \"{}\" is {what}, which has no pixels; it is left out", record.name));
        return None;
    }
    if let Some(what) = record.extras.drawn {
        notes.push(format!(
            "layer \"{}\" is {what}: its pixels are read as the editor drew them",
            record.name
        ));
    }
    note_unread(record, "layer", notes);
    let around = groups.around();
    Some(EditedLayer {
        name: record.name.clone(),
        masks: around.masks(edited_mask(record, head, bytes)),
        rect: record.rect,
        visible: record.visible,
        hidden_by_group: around.hidden,
        opacity: opacity(record) * around.opacity,
        blend: around.blend(blend_with(record, &record.blend)),
        groups: around.names,
        id: None,
        locked: record.extras.locked,
        colours: if head.grey { StoredColours::Grey } else { StoredColours::Full },
        pixels: pixels(record, head, bytes),
    })
}

/// Notes what a layer or group has that is not read.
fn note_unread(record: &Record, kind: &str, notes: &mut Vec<String>) {
    // Where it has both, the mask's channel shows the vector mask, too.
    let vector_mask =
        (record.extras.has_vector_mask && record.channel(MASK).is_none()).then_some("its vector mask");
    for what in record.extras.unknown.iter().copied().chain(vector_mask) {
        notes.push(format!(
            "{kind} \"{}\": {what} {} not applied",
            record.name,
            if what.contains(" and ") { "are" } else { "is" }
        ));
    }
}

/// Returns the opacity with that of the pixels alone.
fn opacity(record: &Record) -> f32 {
    let fill = f32::from(record.extras.fill.unwrap_or(255)) / 255.0;
    f32::from(record.opacity) / 255.0 * fill
}

/// Returns how the editor mixes a layer or group of this mode with what is below.
fn blend_with(record: &Record, mode: &[u8; 4]) -> BlendMode {
    match record.clipped {
        true => BlendMode::Other("clipped to the layer below".into()),
        false => with_display(record, mode),
    }
}

/// Returns a blend mode with what else changes how the editor mixes the record with what is below.
fn with_display(record: &Record, mode: &[u8; 4]) -> BlendMode {
    let display = record.extras.display.join(" and ");
    match (matches!(mode, b"norm" | b"pass"), display.is_empty()) {
        (true, true) => BlendMode::Normal,
        (false, true) => BlendMode::Other(blend_name(*mode)),
        (true, false) => BlendMode::Other(format!("normal with {display}")),
        (false, false) => BlendMode::Other(format!("{} with {display}", blend_name(*mode))),
    }
}

/// Returns the pixels of a layer, to be read on request. Grey is read once and repeated; a layer without
/// alpha is opaque.
fn pixels(record: &Record, head: &PsdHeader, bytes: &Arc<FileBytes>) -> Lazy<Raster> {
    let colours: &[i16] = if head.grey { &[0] } else { &[0, 1, 2] };
    let found: Vec<Option<ChannelPosition>> = colours.iter().map(|id| record.channel(*id)).collect();
    let alpha = record.channel(ALPHA);
    let (bytes, coding) = (bytes.clone(), Coding { kind: head.kind, depth: head.depth });
    let (at, PixelRect { w, h, .. }) = (record.at, record.rect);
    let stored: Vec<ChannelPosition> = found.iter().copied().flatten().chain(alpha).collect();
    let code = {
        let bytes = bytes.clone();
        move || hash_of_code(&bytes, &stored, (w, h), coding)
    };
    let read = move || {
        if w == 0 || h == 0 {
            return Ok(Raster::blank(w, h, coding.depth));
        }
        let colours: Option<Vec<ChannelPosition>> = found.iter().copied().collect();
        let colours =
            colours.ok_or_else(|| bytes.damaged(at, "a layer without all of its colour channels"))?;
        let channels: Vec<ChannelPosition> = colours.into_iter().chain(alpha).collect();
        let planes = channels.par_iter().map(|channel| read_plane(&bytes, *channel, w, h, coding));
        let mut planes = planes.collect::<Result<Vec<_>>>()?;
        let alpha = alpha.and_then(|_| planes.pop());
        Ok(Raster::new(w, h, interleaved(&planes, alpha.as_ref(), coding.depth)))
    };
    Lazy::new(read).with_stored_hash(code)
}

/// Interleaves one plane of grey or three of colour to R, G, B, A per pixel.
fn interleaved(colours: &[Samples], alpha: Option<&Samples>, depth: Depth) -> Samples {
    let last = colours.len() - 1;
    let of = |channel: usize| &colours[channel.min(last)];
    match depth {
        Depth::Eight => {
            Samples::U8(interleave([0, 1, 2].map(|c| bytes_of(of(c))), alpha.map(bytes_of), u8::MAX))
        }
        Depth::Sixteen => {
            Samples::U16(interleave([0, 1, 2].map(|c| words_of(of(c))), alpha.map(words_of), u16::MAX))
        }
    }
}

fn bytes_of(samples: &Samples) -> &[u8] {
    if let Samples::U8(samples) = samples { samples } else { &[] }
}

fn words_of(samples: &Samples) -> &[u16] {
    if let Samples::U16(samples) = samples { samples } else { &[] }
}

fn interleave<T: Copy>([red, green, blue]: [&[T]; 3], alpha: Option<&[T]>, full: T) -> Vec<T> {
    let colours = red.iter().zip(green).zip(blue);
    let pixels: Vec<[T; 4]> = match alpha {
        Some(alpha) => colours.zip(alpha).map(|(((r, g), b), a)| [*r, *g, *b, *a]).collect(),
        None => colours.map(|((r, g), b)| [*r, *g, *b, full]).collect(),
    };
    pixels.into_flattened()
}
