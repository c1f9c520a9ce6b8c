//! The folder format: a PNG per image layer of the size of its rectangle, with a `stack.json` that is valid for
//! them; the photo as it is; needed areas and guides in subfolders.
//!
//! ```text
//! <photo>.layers/order-00 tree (k7q2m9).png     image layers, by order
//! <photo>.layers/guides/order-01.png            what is hidden and has to be painted
//! <photo>.layers/guides/trees.png               where the trees of the project are
//! <photo>.layers/needed/k7q2m9.png              where an image layer has to have pixels
//! <photo>.layers/leftovers.png                  what the photo shows of faces in no image layer
//! <photo>.layers/photo.jpg                      the photo
//! <photo>.layers/stack.json
//! ```
//!
//! The token is in round brackets, because shells and ImageMagick interpret square brackets as a pattern or as a
//! part of the picture.

use std::path::Path;

use super::compose::StackContent;
use super::names::{TREE_GUIDE, guide_name, layer_name};
use quadratura_base::error::Result;
use quadratura_document::ImageLayer;
use quadratura_files::json::to_json;
use quadratura_layered_files::document::LEFTOVERS;
use quadratura_layered_files::folder::read::LEFTOVERS_FILE;
use quadratura_layered_files::folder::{NewFolder, TREE_GUIDE_FILE, guide_file};
use quadratura_layered_files::{KEY_FILE, LayeredDocument};

/// The longest readable part of a file name in bytes, so that the name stays below the 255 bytes of file systems.
const LONGEST_READABLE: usize = 120;

/// Fills a folder with the document of `content`; the photo is in `photo_file`.
///
/// # Errors
/// Returns the errors of reading and writing.
pub fn fill(
    folder: &mut NewFolder,
    content: &StackContent,
    document: &LayeredDocument,
    photo_file: &Path,
) -> Result<()> {
    document.check()?;
    let stack = content.stack;
    let mut named: Vec<(String, String)> =
        stack.image_layers.iter().map(|l| (layer_name(&l.name, &l.id), layer_file(l))).collect();
    named.extend(content.orders().into_iter().map(|order| (guide_name(order), guide_file(order))));
    named.push((LEFTOVERS.to_owned(), LEFTOVERS_FILE.to_owned()));
    named.push((TREE_GUIDE.to_owned(), TREE_GUIDE_FILE.to_owned()));
    folder.add_layers(document, |layer| {
        named.iter().find(|(name, _)| *name == layer.name).map(|(_, file)| file.clone())
    })?;
    let mut described = stack.clone();
    // The exported layers contain their filling.
    described.fill = None;
    for layer in &mut described.image_layers {
        layer.fill = None;
        folder.copy(&needed_file(layer), &content.folder.join(&layer.needed_file))?;
        layer.file = layer_file(layer);
        layer.needed_file = needed_file(layer);
    }
    folder.copy(&photo_name(photo_file), photo_file)?;
    folder.add("stack.json", &to_json(&described))?;
    folder.add(KEY_FILE, document.key.as_bytes())
}

/// Fills a folder with the image layers of `content` alone, named by token, for a scene that refers to them.
///
/// # Errors
/// Returns the errors of reading and writing.
pub fn fill_for_scene(
    folder: &mut NewFolder,
    content: &StackContent,
    document: &LayeredDocument,
) -> Result<()> {
    document.check()?;
    let file = |layer: &ImageLayer| format!("{}.png", layer.id);
    let layers = &content.stack.image_layers;
    let named: Vec<(String, String)> =
        layers.iter().map(|layer| (layer_name(&layer.name, &layer.id), file(layer))).collect();
    folder.add_layers(document, |layer| {
        named.iter().find(|(name, _)| *name == layer.name).map(|(_, file)| file.clone())
    })?;
    let mut described = content.stack.clone();
    described.fill = None;
    for layer in &mut described.image_layers {
        layer.fill = None;
        layer.file = file(layer);
        // There is none, as in a stack file without it.
        layer.needed_file = String::new();
    }
    // Nor are there leftovers.
    described.leftovers = Vec::new();
    folder.add("stack.json", &to_json(&described))?;
    folder.add(KEY_FILE, document.key.as_bytes())
}

/// Returns the file name of an image layer.
fn layer_file(layer: &ImageLayer) -> String {
    format!("{}.png", layer_stem(layer))
}

/// Returns the file name of an image layer without its extension: `order-00 tree (k7q2m9)`.
pub(super) fn layer_stem(layer: &ImageLayer) -> String {
    let mut readable: String = layer_name(&layer.name, "").chars().map(harmless).collect();
    readable.truncate(readable.len() - " []".len());
    while readable.len() > LONGEST_READABLE {
        readable.pop();
    }
    format!("order-{:02} {readable} ({})", layer.order, layer.id)
}

/// Replaces characters that file systems or tools do not accept.
fn harmless(c: char) -> char {
    if "/\\:*?\"<>|[]{}%".contains(c) { '_' } else { c }
}

/// Returns the file name of a layer's needed area.
fn needed_file(layer: &ImageLayer) -> String {
    format!("needed/{}.png", layer.id)
}

/// Returns the file name of the photo.
fn photo_name(file: &Path) -> String {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    format!("photo.{extension}")
}
