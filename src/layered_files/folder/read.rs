//! Reads a folder of PNG files that `export` wrote and an artist has edited.
//!
//! `stack.json` holds the positions of the image layers. A file that was added is positioned if it is as
//! large as the canvas, or if its name contains an image layer's token and it is as large as that layer.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::{GUIDES, TREE_GUIDE_FILE, order_of_guide};
use crate::bytes::SAVE_AGAIN;
use crate::document::{LEFTOVERS, TREE_GUIDE, guide_name};
use crate::place::{is_canvas, not_a_canvas, rect_at, tidy_name};
use crate::png_edited::{self, PngHead};
use crate::{BlendMode, Depth, EditedDocument, EditedLayer, KEY_FILE, Lazy, Raster, StoredColours};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::ExportFormat;
use quadratura_files::hash::hash_file;
use quadratura_files::json::read_json;

/// Name of the file that describes the folder.
pub const STACK_FILE: &str = "stack.json";

/// Name of the file of the leftovers.
pub const LEFTOVERS_FILE: &str = "leftovers.png";

/// Limit in bytes; larger files are not written by this program.
const LARGEST_STACK: u64 = 1 << 28;
const REMEDY: &str = "restore stack.json from the export: it holds the positions of the layers";

/// The fields of `stack.json` that are needed here.
#[derive(Debug, Deserialize)]
struct DescribedStack {
    photo: FolderCanvas,
    /// The image layers, nearest first.
    image_layers: Vec<DescribedLayer>,
    /// The pixels of the leftovers: row, first column, one past the last column.
    #[serde(default)]
    leftovers: Vec<[u32; 3]>,
}

#[derive(Debug, Deserialize)]
struct FolderCanvas {
    width: u32,
    height: u32,
}

#[derive(Debug, Clone, Deserialize)]
struct DescribedLayer {
    id: String,
    #[serde(default)]
    name: String,
    rect: [i64; 4],
    file: String,
}

/// A file with its position.
struct PlacedFile {
    name: String,
    file: PathBuf,
    rect: PixelRect,
    /// The header of the PNG, or why its pixels cannot be used.
    head: Result<PngHead, String>,
    id: Option<String>,
}

/// Reads the description of a folder, without the pixels.
///
/// # Errors
/// [`Error::Input`] when `stack.json` is missing or damaged, [`Error::Io`].
pub fn read(folder: &Path) -> Result<EditedDocument> {
    let stack = folder.join(STACK_FILE);
    if !stack.is_file() {
        return Err(Error::input(stack, "", "it is missing, and every exported folder has one", REMEDY));
    }
    let described: DescribedStack = read_json(&stack, LARGEST_STACK, REMEDY)?;
    let FolderCanvas { width, height } = described.photo;
    if !is_canvas(width, height) {
        return Err(Error::input(stack, "photo", not_a_canvas(width, height), REMEDY));
    }
    let mut notes = Vec::new();
    let mut placed = Vec::new();
    // From bottom to top; a file that was added for a layer lies directly on it.
    let mut added = added_files(folder, &described)?;
    for layer in described.image_layers.iter().rev() {
        placed.extend(own_file(folder, layer, &mut notes));
        added.retain(|file| match added_for(file, layer, &mut notes) {
            Some(found) => {
                placed.push(found);
                false
            }
            None => true,
        });
    }
    placed.extend(
        added.into_iter().filter_map(|file| as_large_as_the_canvas(file, (width, height), &mut notes)),
    );
    placed.extend(leftovers_file(folder, &described));
    let guides = guides(folder);
    let is_deep = |placed: &PlacedFile| placed.head.as_ref().is_ok_and(|head| head.depth == Depth::Sixteen);
    let depth = if placed.iter().any(is_deep) { Depth::Sixteen } else { Depth::Eight };
    let icc = profile(&mut placed, &mut notes);
    let key = fs::read_to_string(folder.join(KEY_FILE)).ok().map(|key| key.trim().to_owned());
    Ok(EditedDocument {
        format: ExportFormat::Folder,
        width,
        height,
        depth,
        rounding: None,
        icc,
        key: key.filter(|key| !key.is_empty()),
        layers: guides
            .into_iter()
            .map(|guide| EditedLayer { visible: false, ..guide.layer(depth) })
            .chain(placed.into_iter().map(|placed| placed.layer(depth)))
            .collect(),
        notes,
    })
}

/// Returns the file that the export wrote for a layer; `None` when it was deleted, which the import reports.
fn own_file(folder: &Path, layer: &DescribedLayer, notes: &mut Vec<String>) -> Option<PlacedFile> {
    let relative = Path::new(&layer.file);
    if !relative.components().all(|part| matches!(part, Component::Normal(_))) {
        notes.push(format!("stack.json: \"{}\" is not in this folder; it is left out", layer.file));
        return None;
    }
    let file = folder.join(relative);
    if !file.is_file() {
        return None;
    }
    placed(format!("{} [{}]", layer.name, layer.id), file, layer, notes)
}

/// Returns the file of the leftovers at the bounding box of their pixels; `None` where there is none.
fn leftovers_file(folder: &Path, described: &DescribedStack) -> Option<PlacedFile> {
    let file = folder.join(LEFTOVERS_FILE);
    let rows = described.leftovers.iter().filter(|_| file.is_file());
    let row = |&[y, x0, x1]: &[u32; 3]| rect_at(x0.into(), y.into(), i64::from(x1) - i64::from(x0), 1);
    let rect = rows.filter_map(row).reduce(|a, b| a.union(&b))?;
    let head = head(&file);
    Some(PlacedFile { name: LEFTOVERS.to_owned(), file, rect, head, id: None })
}

/// Positions a file at a layer, also where it has the size of that layer turned by 90 degrees. A problem with its pixels is
/// reported when they are read.
fn placed(
    name: String,
    file: PathBuf,
    layer: &DescribedLayer,
    notes: &mut Vec<String>,
) -> Option<PlacedFile> {
    let [x, y, w, h] = layer.rect;
    let head = head(&file);
    let is_turned = |head: &PngHead| (i64::from(head.height), i64::from(head.width)) == (w, h);
    let (w, h) = if head.as_ref().is_ok_and(is_turned) { (h, w) } else { (w, h) };
    let rect = noted(&file, rect_at(x, y, w, h).ok_or_else(|| format!("its position is ({x}, {y})")), notes)?;
    let head = head.and_then(|head| match (i64::from(head.width), i64::from(head.height)) == (w, h) {
        true => Ok(head),
        false => Err(format!(
            "{} x {} pixels, but its layer has {w} x {h}, so its position is unknown",
            head.width, head.height
        )),
    });
    Some(PlacedFile { name, file, rect, head, id: Some(layer.id.clone()) })
}

fn noted<T>(file: &Path, found: Result<T, String>, notes: &mut Vec<String>) -> Option<T> {
    found.map_err(|problem| notes.push(format!("{} is left out: {problem}", file.display()))).ok()
}

/// Positions an added file whose name contains the layer's token.
fn added_for(file: &Path, layer: &DescribedLayer, notes: &mut Vec<String>) -> Option<PlacedFile> {
    let name = name_of(file);
    let is_meant = [format!("[{}]", layer.id), format!("({})", layer.id)].iter().any(|id| name.contains(id));
    let found = is_meant.then(|| placed(name, file.to_owned(), layer, notes)).flatten()?;
    noted(file, found.head.clone(), notes).map(|_| found)
}

fn as_large_as_the_canvas(file: PathBuf, canvas: (u32, u32), notes: &mut Vec<String>) -> Option<PlacedFile> {
    let head = noted(&file, head(&file), notes)?;
    if (head.width, head.height) != canvas {
        let found = format!("{} x {} pixels", head.width, head.height);
        let expected =
            format!("only a file as large as the photo, {} x {}, can be positioned", canvas.0, canvas.1);
        return noted(&file, Err(format!("{found}; {expected}")), notes);
    }
    let rect = PixelRect::of_size(canvas.0, canvas.1);
    Some(PlacedFile { name: name_of(&file), file, rect, head: Ok(head), id: None })
}

fn name_of(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the guides, so that an import can say when one was painted on. Where they lie is not known here, only how
/// large they are.
fn guides(folder: &Path) -> Vec<PlacedFile> {
    let files = fs::read_dir(folder.join(GUIDES)).into_iter().flatten().flatten().map(|entry| entry.path());
    let guide = |file: PathBuf| {
        let name = match file.ends_with(TREE_GUIDE_FILE) {
            true => TREE_GUIDE.to_owned(),
            false => guide_name(order_of_guide(file.file_stem()?.to_str()?)?),
        };
        let head = head(&file);
        let rect = head
            .as_ref()
            .map_or(PixelRect::of_size(1, 1), |head| PixelRect::of_size(head.width, head.height));
        Some(PlacedFile { name, file, rect, head, id: None })
    };
    let mut guides: Vec<PlacedFile> = files.filter_map(guide).collect();
    guides.sort_by(|a, b| a.file.cmp(&b.file));
    guides
}

/// Returns the PNG files beside `stack.json` that it does not name, sorted, without the photo.
fn added_files(folder: &Path, described: &DescribedStack) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let entry = entry.map_err(Error::io(folder, "read the folder"))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_png = Path::new(&name).extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        let is_known = described.image_layers.iter().any(|layer| layer.file == name);
        let is_helper = name == "photo.png" || name == LEFTOVERS_FILE;
        if is_png && !is_known && !name.starts_with('.') && !is_helper {
            files.push(entry.path());
        }
    }
    files.sort();
    Ok(files)
}

fn head(file: &Path) -> Result<PngHead, String> {
    let open = File::open(file).map_err(|error| error.to_string())?;
    png_edited::head(BufReader::new(open))
}

/// Returns the colour profile of the first file, which is used for all.
fn profile(placed: &mut [PlacedFile], notes: &mut Vec<String>) -> Option<Vec<u8>> {
    let mut profiles =
        placed.iter_mut().filter_map(|placed| Some((&placed.file, placed.head.as_mut().ok()?.icc.take())));
    let (_, first) = profiles.next()?;
    let others = profiles.filter(|(_, profile)| *profile != first);
    notes.extend(others.map(|(file, _)| {
        format!(
            "{} has another colour profile than the first file; the first one is used for all",
            file.display()
        )
    }));
    first
}

impl PlacedFile {
    fn layer(self, depth: Depth) -> EditedLayer {
        let Self { name, file, rect, head, id } = self;
        let colours = head.as_ref().map_or(StoredColours::Full, |head| head.colours);
        let stored = file.clone();
        let code = move || Ok(format!("{} {depth:?}", hash_file(&stored)?));
        EditedLayer {
            name: tidy_name(&name),
            groups: Vec::new(),
            rect,
            visible: true,
            hidden_by_group: false,
            opacity: 1.0,
            blend: BlendMode::Normal,
            masks: Vec::new(),
            id,
            locked: false,
            colours,
            pixels: Lazy::new(move || pixels(&file, &head, depth)).with_stored_hash(code),
        }
    }
}

fn pixels(file: &Path, head: &Result<PngHead, String>, depth: Depth) -> Result<Raster> {
    let head = head.as_ref().map_err(|found| Error::input(file, "", found, SAVE_AGAIN))?;
    let open = File::open(file).map_err(Error::io(file, "open it"))?;
    let length = open.metadata().map_err(Error::io(file, "read it"))?.len();
    let input = BufReader::with_capacity(1 << 16, open);
    png_edited::raster(input, length, head, depth).map_err(|found| Error::input(file, "", found, SAVE_AGAIN))
}
