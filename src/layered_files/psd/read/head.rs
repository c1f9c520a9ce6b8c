//! Reads the parts of a PSD before the layers: size, colour mode, colour profile, document key.

use crate::Depth;
use crate::bytes::{Cursor, FileBytes};
use crate::place::{is_canvas, not_a_canvas};
use crate::psd::variant::PsdVariant;
use quadratura_base::error::{Error, Result};

/// The signature of PSD and PSB.
pub const SIGNATURE: &[u8] = b"8BPS";

/// The header and the resources that are needed.
#[derive(Debug)]
pub struct PsdHeader {
    pub kind: PsdVariant,
    pub width: u32,
    pub height: u32,
    pub depth: Depth,
    /// Number of channels of the merged picture.
    pub channels: u16,
    /// Whether there is one channel of colour instead of three.
    pub grey: bool,
    pub icc: Option<Vec<u8>>,
    pub key: Option<String>,
    pub notes: Vec<String>,
}

/// Reads a length that is wider in a PSB.
pub fn wide(cursor: &mut Cursor, kind: PsdVariant) -> Result<u64> {
    match kind {
        PsdVariant::Psd => Ok(cursor.u32()?.into()),
        PsdVariant::Psb => cursor.u64(),
    }
}

impl PsdHeader {
    /// Reads up to the layer section.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is damaged, or of an unsupported kind.
    pub fn read(cursor: &mut Cursor, bytes: &FileBytes) -> Result<Self> {
        let mut head = Self::header(cursor, bytes)?;
        let colour_table = cursor.u32()?;
        cursor.skip(colour_table.into())?;
        let resources = cursor.u32()?;
        head.resources(&mut cursor.part(resources.into())?)?;
        Ok(head)
    }

    fn header(cursor: &mut Cursor, bytes: &FileBytes) -> Result<Self> {
        cursor.skip(SIGNATURE.len() as u64)?;
        let kind = match cursor.u16()? {
            1 => PsdVariant::Psd,
            2 => PsdVariant::Psb,
            other => return Err(bytes.damaged(4, format!("version {other}, expected 1 (PSD) or 2 (PSB)"))),
        };
        cursor.skip(6)?;
        let channels = cursor.u16()?;
        let (height, width) = (cursor.u32()?, cursor.u32()?);
        if !is_canvas(width, height) {
            return Err(bytes.damaged(14, not_a_canvas(width, height)));
        }
        let depth = match cursor.u16()? {
            8 => Depth::Eight,
            16 => Depth::Sixteen,
            bits => return Err(not_read(bytes, 22, format!("{bits} bits per channel"))),
        };
        let grey = match cursor.u16()? {
            1 => true,
            3 => false,
            mode => return Err(not_read(bytes, 24, colour_mode(mode))),
        };
        Ok(Self { kind, width, height, depth, channels, grey, icc: None, key: None, notes: Vec::new() })
    }

    fn resources(&mut self, resources: &mut Cursor) -> Result<()> {
        const SMALLEST: u64 = 12;
        while resources.left() >= SMALLEST {
            let at = resources.at();
            let signature: [u8; 4] = resources.array()?;
            if !signature.iter().all(u8::is_ascii_alphanumeric) {
                let what = signature.escape_ascii();
                self.notes.push(format!(
                    "byte {at}: \"{what}\" instead of a resource; the rest of the resources is left out"
                ));
                return Ok(());
            }
            let id = resources.u16()?;
            let name = u64::from(resources.u8()?);
            resources.skip(name + (name + 1) % 2)?;
            let length = u64::from(resources.u32()?);
            let mut content = resources.part(length)?;
            self.resource(id, &mut content, length)?;
            resources.skip((length % 2).min(resources.left()))?;
        }
        Ok(())
    }

    fn resource(&mut self, id: u16, content: &mut Cursor, length: u64) -> Result<()> {
        const ICC: u16 = 1039;
        const XMP: u16 = 1060;
        match id {
            ICC => self.icc = Some(content.take(length)?),
            XMP => match key_in_xmp(&content.take(length)?) {
                Ok(key) => self.key = key,
                Err(problem) => self.notes.push(format!("its XMP cannot be read ({problem})")),
            },
            _ => {}
        }
        Ok(())
    }
}

fn not_read(bytes: &FileBytes, at: u64, found: String) -> Error {
    let remedy = "convert the image to RGB with 8 or 16 bits per channel in the editor, and save it again";
    let expected = format!("{found}; only RGB or grey with 8 or 16 bits can be read");
    Error::input(bytes.path(), format!("byte {at}"), expected, remedy)
}

fn colour_mode(mode: u16) -> String {
    let name = match mode {
        0 => "a bitmap of black and white",
        2 => "indexed colours",
        4 => "CMYK colours",
        7 => "a multichannel image",
        8 => "a duotone",
        9 => "Lab colours",
        other => return format!("colour mode {other}"),
    };
    name.to_owned()
}

/// Returns the text of `dc:identifier`, as an element (as this program and GIMP write it) or as an attribute.
fn key_in_xmp(xmp: &[u8]) -> Result<Option<String>, String> {
    const DUBLIN_CORE: &str = "http://purl.org/dc/elements/1.1/";
    let text = std::str::from_utf8(xmp).map_err(|error| error.to_string())?;
    let text = text.trim_start_matches('\u{feff}').trim_end_matches(['\0', ' ', '\n', '\r']);
    let document = roxmltree::Document::parse(text).map_err(|error| error.to_string())?;
    let found = document.descendants().find_map(|node| {
        let element = node.has_tag_name((DUBLIN_CORE, "identifier")).then(|| node.text()).flatten();
        element.or_else(|| node.attribute((DUBLIN_CORE, "identifier")))
    });
    Ok(found.map(|key| key.trim().to_owned()).filter(|key| !key.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_is_found_as_an_element_and_as_an_attribute() {
        let element =
            "<r xmlns:dc='http://purl.org/dc/elements/1.1/'><dc:identifier> k1 </dc:identifier></r>";
        assert_eq!(key_in_xmp(element.as_bytes()), Ok(Some("k1".into())));
        let attribute = "\u{feff}<r xmlns:d='http://purl.org/dc/elements/1.1/' d:identifier='k2'/>  \0";
        assert_eq!(key_in_xmp(attribute.as_bytes()), Ok(Some("k2".into())));
        assert_eq!(key_in_xmp(b"<r><identifier>other</identifier></r>"), Ok(None));
        assert!(key_in_xmp(b"<r>").is_err() && key_in_xmp(&[0xff]).is_err());
    }
}
