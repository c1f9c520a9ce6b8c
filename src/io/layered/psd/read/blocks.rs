//! The blocks that came to PSD with later versions: a key, a length, and what only some readers know.

use super::{Kind, names};
use crate::error::Result;
use crate::io::layered::bytes::Cursor;

/// One block.
pub struct Block<'f> {
    pub key: [u8; 4],
    pub content: Cursor<'f>,
}

/// Keys whose lengths are wider in a PSB.
const WIDE: [&[u8; 4]; 13] = [
    b"LMsk", b"Lr16", b"Lr32", b"Layr", b"Mt16", b"Mt32", b"Mtrn", b"Alph", b"FMsk", b"lnk2", b"FEid",
    b"FXid", b"PxSD",
];

/// The next block; none at the end. Writers disagree on the padding between blocks (none, to 2, to 4
/// bytes), so up to three zeros are passed over.
///
/// # Errors
/// [`crate::Error::Input`] when there is something else.
pub fn next_block<'f>(cursor: &mut Cursor<'f>, kind: Kind) -> Result<Option<Block<'f>>> {
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
        return Err(cursor.damaged(format!("{} was found, 8BIM was expected", readable(&signature))));
    }
    cursor.skip(4)?;
    let key: [u8; 4] = cursor.array()?;
    let is_wide = kind == Kind::Psb && WIDE.contains(&&key);
    let length = if is_wide { cursor.u64()? } else { cursor.u32()?.into() };
    Ok(Some(Block { key, content: cursor.part(length)? }))
}

fn readable(bytes: &[u8]) -> String {
    format!("\"{}\"", bytes.escape_ascii())
}

/// What the blocks of one layer say.
#[derive(Debug, Default)]
pub struct Extras {
    /// The name in Unicode.
    pub name: Option<String>,
    /// What the record is, when it is no plain layer.
    pub section: Option<Section>,
    /// Locked against painting: completely, or at least its pixels.
    pub locked: bool,
    /// Opacity of the pixels without the layer's style; 255 when nothing is said.
    pub fill: Option<u8>,
    /// A picture that Photoshop computes from no pixels of its own.
    pub computed: Option<&'static str>,
    /// What is not understood, as it is said of the layer.
    pub unknown: Vec<&'static str>,
}

/// What a record is in the tree of groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    /// Above a group's layers; bears its name, and how it is laid over what is below where that is said.
    GroupStart(Option<[u8; 4]>),
    /// Below a group's layers.
    GroupEnd,
}

impl Extras {
    /// Takes in one block.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when it is shorter than its kind.
    pub fn take(&mut self, block: &mut Block) -> Result<()> {
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
            b"vmsk" | b"vsms" => self.unknown_once("its vector mask"),
            _ => {}
        }
    }

    fn unknown_once(&mut self, what: &'static str) {
        if !self.unknown.contains(&what) {
            self.unknown.push(what);
        }
    }
}

fn section(content: &mut Cursor) -> Result<Option<Section>> {
    let kind = content.u32()?;
    Ok(match kind {
        1 | 2 if content.left() >= 8 => {
            content.skip(4)?;
            Some(Section::GroupStart(Some(content.array()?)))
        }
        1 | 2 => Some(Section::GroupStart(None)),
        3 => Some(Section::GroupEnd),
        _ => None,
    })
}
