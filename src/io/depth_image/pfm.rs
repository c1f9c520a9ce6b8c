//! Portable float maps: three lines of text, then rows of 32-bit floats from the bottom to the top.
//!
//! Debevec's format: `Pf` for one channel, width and height, and a scale whose sign is the byte order (negative: little-endian).
//! Its absolute value is not applied, as most programs write 1 there whatever they mean; the list's `scale` is.

use super::depth_file::{COPY, DepthFile};
use quadratura_base::error::Result;

/// Reads the numbers of a file, rows from the top.
pub(super) fn read(source: &mut DepthFile, size: [u32; 2]) -> Result<Vec<f32>> {
    let mut header = 0;
    let ends = |byte: u8| byte.is_ascii_whitespace();
    let kind = source.word(ends, &mut header)?;
    if kind == "PF" {
        let found = "three channels of colour (`PF`); expected one channel (`Pf`)";
        return Err(source.wrong("header", found, "save the depth alone, as a PFM file of one channel"));
    }
    if kind != "Pf" {
        return Err(source.wrong("header", format!("{kind:?}; expected \"Pf\""), COPY));
    }
    let mut next = |source: &mut DepthFile| loop {
        // Words may have several spaces between them; what follows the last one is data.
        let word = source.word(ends, &mut header)?;
        if !word.is_empty() {
            return Ok(word);
        }
    };
    let [width, height, scale] = [next(source)?, next(source)?, next(source)?];
    let found = [source.number(&width, "width")?, source.number(&height, "height")?];
    let scale =
        scale.parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0).ok_or_else(|| {
            let found = format!(
                "{scale:?} as the scale; expected a number other than 0, whose sign is the byte order"
            );
            source.wrong("header", found, COPY)
        })?;
    source.check_size(found, size)?;
    let (width, count) = (size[0] as usize, size[0] as usize * size[1] as usize);
    source.check_rest(header, 4 * count as u64)?;
    let from = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let from_the_bottom = source.floats(count, from)?;
    Ok(from_the_bottom.chunks_exact(width).rev().flatten().copied().collect())
}
