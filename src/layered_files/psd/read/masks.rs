//! Reads masks of layers and groups in a PSD, with their density and feather.

use super::head::PsdHeader;
use super::planes::{Coding, hash_of_code, read_plane};
use super::records::{ChannelPosition, Record, read_rect};
use crate::bytes::{Cursor, FileBytes};
use crate::{EditedMask, Grey, Lazy};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;
use std::sync::Arc;

/// The channel of a mask.
pub const MASK: i16 = -2;
/// The channel of the other mask of a layer that has a pixel mask and a vector mask. One of the two is the pixel mask,
/// the other what both let through; writers disagree which.
pub const REAL_MASK: i16 = -3;

/// A record's mask.
#[derive(Debug, Clone, Copy)]
pub struct MaskRecord {
    pub place: MaskPlace,
    /// Whether its pixels were drawn from other data: from a vector mask.
    pub drawn: bool,
    /// The softening of the pixel mask.
    pub pixel: Softening,
    /// The softening of the vector mask.
    pub vector: Softening,
    /// The mask in the channel [`REAL_MASK`].
    pub real: Option<MaskPlace>,
}

/// The position of a mask's pixels and how they are meant.
#[derive(Debug, Clone, Copy)]
pub struct MaskPlace {
    /// Position and size in canvas pixels.
    pub rect: PixelRect,
    /// The value outside `rect`.
    pub outside: u8,
    pub enabled: bool,
    pub inverted: bool,
}

/// What an editor does to a mask when it shows it, without changing its pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softening {
    /// How much the mask hides where it is black: 255 all, 0 nothing.
    pub density: u8,
    /// The radius of the blur, in pixels.
    pub feather: f64,
}

const NO_SOFTENING: Softening = Softening { density: 255, feather: 0.0 };

/// The number of bytes of a [`MaskPlace`] in the file.
const PLACE_BYTES: u64 = 18;
/// The flag for density and feather behind the mask's place.
const SOFTENED: u8 = 16;

/// Reads a mask: nothing, or a place, density and feather where a flag says so, and the place of the other mask where
/// the layer has the channel of one. The specification has the other mask last, files have it first.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when it is shorter than it claims.
pub fn read_mask(extra: &mut Cursor, layer: PixelRect, has_real_mask: bool) -> Result<Option<MaskRecord>> {
    let length = extra.u32()?;
    let mut content = extra.part(length.into())?;
    if length == 0 {
        return Ok(None);
    }
    let rect = read_rect(&mut content)?;
    let [outside, flags] = content.array()?;
    const DRAWN: u8 = 8;
    let place = MaskPlace::new(rect, outside, flags, layer);
    let is_softened = flags & SOFTENED != 0 && content.left() > 0;
    let real_follows = has_real_mask && content.left() >= PLACE_BYTES;
    let (mut real, mut softening) = (None, [NO_SOFTENING; 2]);
    match (is_softened, real_follows) {
        (false, false) => {}
        (false, true) => real = Some(read_real(&mut content, layer)?),
        (true, false) => softening = read_softening(&mut content)?,
        (true, true) => {
            let mut files = content.clone();
            let first = read_real(&mut files, layer);
            let behind = read_softening(&mut files).ok().filter(|_| files.left() < 4);
            match (first, behind) {
                (Ok(first), Some(behind)) => (real, softening) = (Some(first), behind),
                _ => {
                    softening = read_softening(&mut content)?;
                    real = Some(read_real(&mut content, layer)?);
                }
            }
        }
    }
    let [pixel, vector] = softening;
    Ok(Some(MaskRecord { place, drawn: flags & DRAWN != 0, pixel, vector, real }))
}

/// Reads the place of the other mask, which begins with its flags.
fn read_real(content: &mut Cursor, layer: PixelRect) -> Result<MaskPlace> {
    let [flags, outside] = content.array()?;
    Ok(MaskPlace::new(read_rect(content)?, outside, flags, layer))
}

/// Reads density and feather of the pixel mask and of the vector mask, as far as they are stored.
fn read_softening(content: &mut Cursor) -> Result<[Softening; 2]> {
    let stored = content.u8()?;
    if stored > 15 {
        return Err(content.damaged(format!("{stored} as the list of a mask's parameters, expected 0 to 15")));
    }
    let mut found = [NO_SOFTENING; 2];
    for (softening, bit) in found.iter_mut().zip([0, 2]) {
        if stored & (1 << bit) != 0 {
            softening.density = content.u8()?;
        }
        if stored & (2 << bit) != 0 {
            softening.feather = f64::from_be_bytes(content.array()?);
        }
    }
    Ok(found)
}

impl MaskPlace {
    fn new(mut rect: PixelRect, outside: u8, flags: u8, layer: PixelRect) -> Self {
        const RELATIVE: u8 = 1;
        const OFF: u8 = 2;
        const INVERTED: u8 = 4;
        if flags & RELATIVE != 0 {
            (rect.x, rect.y) = (rect.x + layer.x, rect.y + layer.y);
        }
        Self { rect, outside, enabled: flags & OFF == 0, inverted: flags & INVERTED != 0 }
    }

    /// Makes the mask of a channel, to be read on request.
    fn mask(
        self,
        channel: ChannelPosition,
        density: u8,
        head: &PsdHeader,
        bytes: &Arc<FileBytes>,
    ) -> EditedMask {
        let Self { rect, outside, enabled, inverted } = self;
        let (bytes, coding) = (bytes.clone(), Coding { kind: head.kind, depth: head.depth });
        let PixelRect { w, h, .. } = rect;
        let code = {
            let bytes = bytes.clone();
            move || Ok(format!("{} {inverted} {density}", hash_of_code(&bytes, &[channel], (w, h), coding)?))
        };
        let read = move || {
            let samples = read_plane(&bytes, channel, w, h, coding)?;
            let samples = if inverted { negative(samples) } else { samples };
            Ok(Grey::new(w, h, thinned(samples, density)))
        };
        let outside = if inverted { 255 - outside } else { outside };
        EditedMask {
            rect,
            outside: f32::from(thinner(outside.into(), density, 255) as u8) / 255.0,
            enabled,
            lowest_with: None,
            pixels: Lazy::new(read).with_stored_hash(code),
        }
    }
}

/// Returns the mask of a record; `None` where it has none. A mask whose effect is not in its pixels cannot be read.
pub fn edited_mask(record: &Record, head: &PsdHeader, bytes: &Arc<FileBytes>) -> Option<EditedMask> {
    let (mask, channel) = (record.mask?, record.channel(MASK)?);
    let has_vector_mask = record.extras.has_vector_mask || mask.drawn || mask.real.is_some();
    let density = if has_vector_mask { 255 } else { mask.pixel.density };
    let mut edited = mask.place.mask(channel, density, head, bytes);
    if let Some((real, channel)) = mask.real.zip(record.channel(REAL_MASK)) {
        edited.lowest_with = Some(Arc::new(real.mask(channel, 255, head, bytes)));
    }
    if let Some(effect) = mask.effect(has_vector_mask) {
        let (path, place) = (bytes.path().to_owned(), format!("the mask of \"{}\"", record.name));
        let refused = move || {
            let found = format!("it has {effect}, which only the editor can draw");
            let remedy = "apply the mask, or rasterize it, in the editor, and save again";
            Err(Error::input(&path, place.as_str(), found, remedy))
        };
        edited.pixels = Lazy::new(refused);
    }
    Some(edited)
}

impl MaskRecord {
    /// Returns what an editor draws of the mask that its pixels do not have, in words.
    fn effect(&self, has_vector_mask: bool) -> Option<String> {
        // Parameters of a mask that the layer does not have remain from an earlier one.
        let of_pixels =
            Softening { density: if has_vector_mask { self.pixel.density } else { 255 }, ..self.pixel };
        let of_vector = if has_vector_mask { self.vector } else { NO_SOFTENING };
        let named = [(of_pixels, ""), (of_vector, " of its vector mask")];
        let effects = named.iter().flat_map(|(Softening { density, feather }, whose)| {
            let feathered = (*feather != 0.0).then(|| format!("a feather of {feather:.1} pixels{whose}"));
            let percent = (f64::from(*density) / 2.55).round();
            let thinned = (*density != 255).then(|| format!("a density of {percent} %{whose}"));
            feathered.into_iter().chain(thinned)
        });
        let effects: Vec<String> = effects.collect();
        (!effects.is_empty()).then(|| effects.join(" and "))
    }
}

fn negative(samples: Samples) -> Samples {
    match samples {
        Samples::U8(samples) => Samples::U8(samples.into_iter().map(|sample| !sample).collect()),
        Samples::U16(samples) => Samples::U16(samples.into_iter().map(|sample| !sample).collect()),
    }
}

/// Returns what a mask of this density lets through.
fn thinned(samples: Samples, density: u8) -> Samples {
    let thin = |sample: u32, full: u32| thinner(sample, density, full);
    match samples {
        samples if density == 255 => samples,
        Samples::U8(samples) => Samples::U8(samples.into_iter().map(|s| thin(s.into(), 255) as u8).collect()),
        Samples::U16(samples) => {
            Samples::U16(samples.into_iter().map(|s| thin(s.into(), 65535) as u16).collect())
        }
    }
}

/// Returns a sample of 0..=`full` with density, rounded: of what the mask hides, the density's share stays hidden.
fn thinner(sample: u32, density: u8, full: u32) -> u32 {
    full - (u32::from(density) * (full - sample) + 127) / 255
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_density_takes_its_share_of_what_a_mask_hides() {
        assert_eq!([0, 100, 255].map(|m| thinner(m, 255, 255)), [0, 100, 255]);
        assert_eq!([0, 100, 255].map(|m| thinner(m, 0, 255)), [255; 3]);
        assert_eq!([0, 155, 255].map(|m| thinner(m, 102, 255)), [153, 215, 255]);
        assert_eq!([0, 65535].map(|m| thinner(m, 51, 65535)), [52428, 65535]);
    }
}
