//! Reads the additional blocks of layers in a PSD: a key, a length, and content that only some readers know.

use super::names;
use crate::bytes::Cursor;
use crate::psd::variant::PsdVariant;
use quadratura_base::error::Result;

/// An additional block.
pub struct PsdBlock<'f> {
    pub key: [u8; 4],
    pub content: Cursor<'f>,
}

/// Keys of blocks whose lengths are wider in a PSB.
const WIDE: [&[u8; 4]; 13] = [
    b"LMsk", b"Lr16", b"Lr32", b"Layr", b"Mt16", b"Mt32", b"Mtrn", b"Alph", b"FMsk", b"lnk2", b"FEid",
    b"FXid", b"PxSD",
];

/// Reads the next block; `None` at the end. Writers disagree on the padding between blocks (none, to 2, to 4
/// bytes), so up to three zeros are skipped.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when something else follows.
pub fn next_block<'f>(cursor: &mut Cursor<'f>, kind: PsdVariant) -> Result<Option<PsdBlock<'f>>> {
    const HEADER: u64 = 12;
    let mut padding = 0;
    while padding < 4 && cursor.left() >= HEADER && cursor.clone().u8()? == 0 {
        cursor.skip(1)?;
        padding += 1;
    }
    if cursor.left() < HEADER {
        return Ok(None);
    }
    let signature: [u8; 4] = cursor.clone().array()?;
    if !matches!(&signature, b"8BIM" | b"8B64") {
        return Err(cursor.damaged(format!("found {}, expected 8BIM", readable(&signature))));
    }
    cursor.skip(4)?;
    let key: [u8; 4] = cursor.array()?;
    let is_wide = kind == PsdVariant::Psb && WIDE.contains(&&key);
    let length = if is_wide { cursor.u64()? } else { cursor.u32()?.into() };
    Ok(Some(PsdBlock { key, content: cursor.part(length)? }))
}

fn readable(bytes: &[u8]) -> String {
    format!("\"{}\"", bytes.escape_ascii())
}

/// The properties of a layer from its blocks.
#[derive(Debug, Default)]
pub struct BlockProperties {
    /// The name in Unicode.
    pub name: Option<String>,
    /// The role of the record in the tree of groups, if it is not a plain layer.
    pub section: Option<GroupRole>,
    /// Whether the layer, or at least its pixels, are locked.
    pub locked: bool,
    /// Fill opacity: of the pixels without the layer's style; `None` where it is not stored, which means 255.
    pub fill: Option<u8>,
    /// The kind of a layer that Photoshop computes without pixels of its own.
    pub computed: Option<&'static str>,
    /// The kind of a layer whose pixels the editor has drawn from other data.
    pub drawn: Option<&'static str>,
    /// Whether the layer has a vector mask that is not disabled.
    pub has_vector_mask: bool,
    /// What changes how the editor mixes the layer with those below, beside mode and opacity.
    pub display: Vec<&'static str>,
    /// Features that are not supported, as phrases for messages about the layer.
    pub unknown: Vec<&'static str>,
}

/// The role of a record in the tree of groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroupRole {
    /// The record above a group's layers, which has its name, and its blend mode where that is stored.
    GroupStart(Option<[u8; 4]>),
    /// The record below a group's layers.
    GroupEnd,
}

impl BlockProperties {
    /// Reads one block.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] when it is shorter than its kind requires.
    pub fn take(&mut self, block: &mut PsdBlock) -> Result<()> {
        let content = &mut block.content;
        match &block.key {
            b"luni" => self.name = Some(names::unicode(content)?),
            b"lsct" | b"lsdk" => self.section = section(content)?,
            b"lspf" => {
                const ALL: u32 = 1 << 31;
                const PIXELS: u32 = 1 << 1;
                self.locked = content.u32()? & (ALL | PIXELS) != 0;
            }
            b"iOpa" => self.fill = Some(content.u8()?),
            b"vmsk" | b"vsms" => self.has_vector_mask = is_enabled_vector_mask(content)?,
            // The channels to which blending is restricted; none as a rule.
            b"brst" if content.left() > 0 => self.display.push("channels that are switched off"),
            b"knko" if content.left() > 0 && content.u8()? != 0 => self.display.push("knockout"),
            key => self.take_unread(key),
        }
        Ok(())
    }

    fn take_unread(&mut self, key: &[u8; 4]) {
        match key {
            b"SoCo" | b"GdFl" | b"PtFl" => self.computed = Some("a fill layer"),
            b"brit" | b"levl" | b"curv" | b"expA" | b"vibA" | b"hue " | b"hue2" | b"blnc" | b"blwh"
            | b"phfl" | b"mixr" | b"clrL" | b"nvrt" | b"post" | b"thrs" | b"selc" | b"grdm" => {
                self.computed = Some("an adjustment layer");
            }
            b"lfx2" | b"lrFX" | b"lmfx" => self.unknown_once("its layer style"),
            b"artb" | b"artd" | b"abdd" => self.unknown_once("the background and the edge of its artboard"),
            b"PlLd" | b"SoLd" | b"SoLE" => self.drawn = Some("a smart object"),
            b"TySh" | b"tySh" => self.drawn = Some("a text layer"),
            _ => {}
        }
    }

    fn unknown_once(&mut self, what: &'static str) {
        if !self.unknown.contains(&what) {
            self.unknown.push(what);
        }
    }
}

/// Returns false where the vector mask is disabled; its other data are paths, which are not read.
fn is_enabled_vector_mask(content: &mut Cursor) -> Result<bool> {
    const DISABLED: u32 = 4;
    if content.left() < 8 {
        return Ok(true);
    }
    let _version = content.u32()?;
    Ok(content.u32()? & DISABLED == 0)
}

fn section(content: &mut Cursor) -> Result<Option<GroupRole>> {
    let kind = content.u32()?;
    Ok(match kind {
        1 | 2 if content.left() >= 8 => {
            content.skip(4)?;
            Some(GroupRole::GroupStart(Some(content.array()?)))
        }
        1 | 2 => Some(GroupRole::GroupStart(None)),
        3 => Some(GroupRole::GroupEnd),
        _ => None,
    })
}
