//! Reads names in a PSD: of layers, in two encodings, and of blend modes.

use crate::bytes::Cursor;
use crate::place::tidy_name;
use quadratura_base::error::Result;

/// Reads a text in UTF-16 that follows its number of units.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when the block is too short.
pub fn unicode(content: &mut Cursor) -> Result<String> {
    let bytes = u64::from(content.u32()?) * 2;
    let bytes = content.take(bytes)?;
    let (pairs, _) = bytes.as_chunks::<2>();
    let units: Vec<u16> = pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
    Ok(tidy_name(&String::from_utf16_lossy(&units)))
}

/// Reads the short name, which is padded with its length to four bytes. Its encoding is not stored: it is
/// read as UTF-8 where possible, else as one character per byte.
///
/// # Errors
/// As [`unicode`].
pub fn short(cursor: &mut Cursor) -> Result<String> {
    let length = u64::from(cursor.u8()?);
    let bytes = cursor.take(length)?;
    // A writer may omit the padding behind the last field of a record.
    let padding = ((length + 1).next_multiple_of(4) - (length + 1)).min(cursor.left());
    cursor.skip(padding)?;
    let text = String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().iter().map(|byte| char::from(*byte)).collect());
    Ok(tidy_name(&text))
}

/// Returns the name under which users know a blend mode.
pub fn blend_name(key: [u8; 4]) -> String {
    let name = match &key {
        b"pass" => "pass through",
        b"norm" => "normal",
        b"diss" => "dissolve",
        b"dark" => "darken",
        b"mul " => "multiply",
        b"idiv" => "colour burn",
        b"lbrn" => "linear burn",
        b"dkCl" => "darker colour",
        b"lite" => "lighten",
        b"scrn" => "screen",
        b"div " => "colour dodge",
        b"lddg" => "linear dodge",
        b"lgCl" => "lighter colour",
        b"over" => "overlay",
        b"sLit" => "soft light",
        b"hLit" => "hard light",
        b"vLit" => "vivid light",
        b"lLit" => "linear light",
        b"pLit" => "pin light",
        b"hMix" => "hard mix",
        b"diff" => "difference",
        b"smud" => "exclusion",
        b"fsub" => "subtract",
        b"fdiv" => "divide",
        b"hue " => "hue",
        b"sat " => "saturation",
        b"colr" => "colour",
        b"lum " => "luminosity",
        other => return other.escape_ascii().to_string(),
    };
    name.to_owned()
}
