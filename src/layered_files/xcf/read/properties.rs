//! Reads the properties of the image, a layer or a mask into one structure.

use super::{pointer, text};
use crate::bytes::Cursor;
use crate::xcf::properties::{KEY_TAG, number, parasite};
use quadratura_base::error::Result;

/// The properties in a list; missing ones have their defaults.
#[derive(Debug)]
pub struct Properties {
    /// Opacity, 0..=1.
    pub opacity: f32,
    pub mode: u32,
    /// GIMP's number for which of a layer and what is below it is left where one of them has nothing; negative where GIMP chose
    /// it for the mode.
    pub composite: i32,
    /// Whether GIMP has drawn the pixels from a text.
    pub is_text: bool,
    pub visible: bool,
    pub offset: (i32, i32),
    pub apply_mask: bool,
    pub locked: bool,
    pub group: bool,
    /// The path in the tree: numbers from the top, outermost group first. Empty outside groups.
    pub path: Vec<u32>,
    /// The position of the drawable that a floating selection is attached to.
    pub floating: Option<u64>,
    /// The number of the tiles' compression method.
    pub compression: u8,
    /// R, G, B of each colour of an indexed image.
    pub colour_map: Vec<[u8; 3]>,
    pub icc: Option<Vec<u8>>,
    pub key: Option<String>,
    /// The document key in the metadata that GIMP made of a PSD's XMP.
    pub metadata_key: Option<String>,
    pub layer: Option<String>,
}

impl Default for Properties {
    fn default() -> Self {
        Self {
            opacity: 1.0,
            mode: 0,
            composite: 0,
            is_text: false,
            visible: true,
            offset: (0, 0),
            apply_mask: true,
            locked: false,
            group: false,
            path: Vec::new(),
            floating: None,
            compression: 0,
            colour_map: Vec::new(),
            icc: None,
            key: None,
            metadata_key: None,
            layer: None,
        }
    }
}

/// Maximum depth of groups; GIMP's users nest far less deeply.
const DEEPEST: u64 = 100;
/// Limit on GIMP's metadata in bytes; with a thumbnail in it, it may be long.
const LONGEST_METADATA: u64 = 1 << 22;
/// Limit on this program's own parasites in bytes.
const LONGEST_TOKEN: u64 = 1000;

impl Properties {
    /// Reads a list to its end.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] when the list is damaged.
    pub fn read(cursor: &mut Cursor, wide: bool) -> Result<Self> {
        let mut properties = Self::default();
        loop {
            let (number, length) = (cursor.u32()?, cursor.u32()?);
            match number {
                number::END => return Ok(properties),
                // Old versions of GIMP store a wrong length for this property, so it is ignored.
                number::COLOUR_MAP => properties.colour_map = colour_map(cursor)?,
                _ => {
                    let mut payload = cursor.part(length.into())?;
                    properties.take(number, &mut payload, wide)?;
                }
            }
        }
    }

    fn take(&mut self, number: u32, payload: &mut Cursor, wide: bool) -> Result<()> {
        match number {
            number::FLOATING_SELECTION => self.floating = Some(pointer(payload, wide)?),
            number::OPACITY => self.opacity = payload.u32()?.min(255) as f32 / 255.0,
            number::FLOAT_OPACITY => {
                let opacity = payload.f32()?;
                self.opacity = if opacity.is_finite() { opacity.clamp(0.0, 1.0) } else { 1.0 };
            }
            number::MODE => self.mode = payload.u32()?,
            number::COMPOSITE_MODE => self.composite = payload.i32()?,
            number::VISIBLE => self.visible = payload.u32()? != 0,
            number::APPLY_MASK => self.apply_mask = payload.u32()? != 0,
            number::OFFSETS => self.offset = (payload.i32()?, payload.i32()?),
            number::COMPRESSION => self.compression = payload.u8()?,
            number::LOCK_CONTENT => self.locked = payload.u32()? != 0,
            number::GROUP_ITEM => self.group = true,
            number::ITEM_PATH => {
                let steps = (payload.left() / 4).min(DEEPEST);
                self.path = (0..steps).map(|_| payload.u32()).collect::<Result<_>>()?;
            }
            number::PARASITES => self.parasites(payload)?,
            _ => {}
        }
        Ok(())
    }

    fn parasites(&mut self, payload: &mut Cursor) -> Result<()> {
        while payload.left() > 0 {
            let name = text(payload)?;
            let _flags = payload.u32()?;
            let length = u64::from(payload.u32()?);
            let mut data = payload.part(length)?;
            match name.as_str() {
                parasite::ICC => self.icc = Some(data.take(length)?),
                parasite::KEY => self.key = token(&mut data)?,
                parasite::METADATA => self.metadata_key = key_in_metadata(&mut data)?,
                parasite::LAYER => self.layer = token(&mut data)?,
                parasite::TEXT => self.is_text = true,
                _ => {}
            }
        }
        Ok(())
    }
}

/// Returns the document key from GIMP's metadata. Damage in it is not a reason to refuse a file.
fn key_in_metadata(data: &mut Cursor) -> Result<Option<String>> {
    let bytes = data.take(data.left().min(LONGEST_METADATA))?;
    let text = String::from_utf8_lossy(&bytes);
    let Ok(document) = roxmltree::Document::parse(text.trim_end_matches('\0')) else { return Ok(None) };
    let tag = document.descendants().find(|node| node.attribute("name") == Some(KEY_TAG));
    let key = tag.and_then(|tag| tag.text()).map(|key| key.trim().to_owned());
    Ok(key.filter(|key| !key.is_empty()))
}

/// Reads a short text that may end with a NUL.
fn token(data: &mut Cursor) -> Result<Option<String>> {
    let bytes = data.take(data.left().min(LONGEST_TOKEN))?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_end_matches('\0').trim();
    Ok((!text.is_empty()).then(|| text.to_owned()))
}

fn colour_map(cursor: &mut Cursor) -> Result<Vec<[u8; 3]>> {
    let count = cursor.u32()?;
    if count > 256 {
        return Err(cursor.damaged(format!("a colour map of {count} colours; the maximum is 256")));
    }
    let bytes = cursor.take(3 * u64::from(count))?;
    let (colours, _) = bytes.as_chunks::<3>();
    Ok(colours.to_vec())
}
