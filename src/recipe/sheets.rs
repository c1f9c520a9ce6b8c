//! The files of the current stacks as texels of sheets.

use std::path::PathBuf;

use crate::document::Stack;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_layer, read_mask};
use crate::io::stack_store::StackStore;
use crate::projection::{SheetId, SheetPixels, Texels};

/// Where the texels of each sheet are. Sheets are counted as in [`crate::projection::Sources::sheets`]:
/// photo by photo, image layers as in the stack.
#[derive(Debug, Clone, Default)]
pub struct SheetFiles {
    files: Vec<SheetFile>,
}

#[derive(Debug, Clone)]
struct SheetFile {
    texels: PathBuf,
    needed: PathBuf,
    rect: PixelRect,
    needed_rect: PixelRect,
}

impl SheetFiles {
    /// The image layers of these stacks, in their order. Files are read when they are asked for: where a
    /// build replaces a stack in the meantime they are gone, and the stacks have to be read again.
    pub fn new<'a>(store: &StackStore, stacks: impl IntoIterator<Item = &'a Stack>) -> Self {
        let files = stacks.into_iter().flat_map(|stack| {
            let folder = store.folder(&stack.photo.name);
            stack.image_layers.iter().map(move |layer| SheetFile {
                texels: folder.join(&layer.file),
                needed: folder.join(&layer.needed_file),
                rect: layer.rect,
                needed_rect: layer.needed_rect,
            })
        });
        Self { files: files.collect() }
    }

    /// How many sheets there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// There is no sheet.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

impl Texels for SheetFiles {
    fn sheet(&self, sheet: SheetId) -> Result<SheetPixels> {
        let file = self.files.get(sheet.0 as usize);
        let file = file.ok_or_else(|| Error::Request(format!("there is no image layer {}", sheet.0)))?;
        let rect = file.needed_rect.intersection(&file.rect);
        if rect.is_empty() {
            return Ok(SheetPixels { rect, rgba: Vec::new(), needed: Vec::new() });
        }
        let rgba = read_layer(&file.texels, file.rect, rect)?;
        let needed = read_mask(&file.needed, file.rect, rect)?;
        Ok(SheetPixels { rect, rgba, needed })
    }
}
