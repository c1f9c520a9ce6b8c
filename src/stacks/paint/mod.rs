//! Paint on the image layers of the present stack: entries are assigned to surfaces, and surfaces to image layers.
//! Nothing is written here: paint is authored, and its appearance in a stack is derived each time.

pub mod by_surface;
mod home;
#[cfg(test)]
mod home_tests;
pub mod lost;
pub mod parts;

use std::cell::OnceCell;
use std::path::Path;

use self::home::{Home, PaintMapping, home};
use self::lost::LostPaint;
use self::parts::{LayerParts, PartSource, SurfacePart, camera_of};
use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_document::paint::{PaintBook, PaintEntry, PaintPatch};
use quadratura_document::stack::{ImageLayer, Stack};
use quadratura_document::{Element, FilesInUse, paint::PaintedView};
use quadratura_io::paint_store::PaintStore;
use quadratura_layers::{ElementIndex, LayerIndex};

/// The paint of one photo, assigned to the image layers of its stack.
#[derive(Debug, Default)]
pub struct PhotoPaint {
    store: Option<PaintStore>,
    /// The entries of the photo, earlier imports first.
    entries: Vec<PaintEntry>,
    views: Vec<PaintedView>,
    /// The entries that may be visible on each image layer, from bottom to top.
    layers: Vec<Vec<PlacedPaint>>,
    /// The entries whose surface is not in the stack.
    lost: Vec<usize>,
    /// Messages about paint that cannot be shown, because its files are damaged or missing.
    damaged: Vec<String>,
    /// The hold on the files of the book.
    _in_use: FilesInUse,
}

/// An entry on an image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct PlacedPaint {
    entry: usize,
    /// The part in the layer; later ones are drawn on top.
    part: usize,
    extent: PaintExtent,
}

/// The pixels of an entry that are visible on a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum PaintExtent {
    /// All pixels.
    All,
    /// The pixels that the part covers.
    Covered,
    /// The pixels that no part of the layer covers.
    Beyond,
}

impl PhotoPaint {
    /// Returns whether no image layer shows paint.
    pub fn is_empty(&self) -> bool {
        self.layers.iter().all(Vec::is_empty)
    }

    /// Reads the paint of the project in the folder `project` for the image layers of `stack`.
    ///
    /// # Errors
    /// Returns the errors of reading the paint book; pixels are read later.
    pub fn open(project: &Path, stack: &Stack) -> Result<Self> {
        let store = PaintStore::new(project);
        let book = store.read()?;
        Ok(Self::new(&book, store, stack))
    }

    /// Assigns the paint of a book that was read. Entries whose files are damaged are not shown; see
    /// [`Self::damaged`].
    pub fn new(book: &PaintBook, store: PaintStore, stack: &Stack) -> Self {
        let mut entries = Vec::new();
        let mut damaged = Vec::new();
        for entry in book.of_photo(&stack.photo.name) {
            match store.check(entry) {
                Ok(()) => entries.push(entry.clone()),
                Err(error) => damaged.push(error.to_string()),
            }
        }
        if entries.is_empty() {
            return Self { damaged, ..Self::default() };
        }
        let current = || PaintedView { photo: stack.photo.clone(), camera: stack.camera.clone() };
        let views =
            entries.iter().map(|e| book.views.get(&e.view).cloned().unwrap_or_else(current)).collect();
        let _in_use = book.in_use.clone();
        let mut paint = Self { store: Some(store), entries, views, damaged, _in_use, ..Self::default() };
        paint.assign(stack);
        paint
    }

    /// Assigns all entries to image layers.
    fn assign(&mut self, stack: &Stack) {
        self.layers = vec![Vec::new(); stack.image_layers.len()];
        let parts = parts_of_stack(stack);
        let all: Vec<(LayerIndex, usize)> = stack
            .layer_indices()
            .zip(&parts)
            .flat_map(|(l, parts)| (0..parts.list.len()).map(move |p| (l, p)))
            .collect();
        let flat: Vec<&SurfacePart> = all.iter().map(|&(l, p)| &parts[l.index()].list[p]).collect();
        for (index, entry) in self.entries.iter().enumerate() {
            let (indices, remodelled) = match home(entry, &flat) {
                Home::Same(indices) => (indices, false),
                Home::Spread(indices) => (indices, true),
                Home::Lost => {
                    self.lost.push(index);
                    continue;
                }
            };
            let at = indices.iter().map(|&part_index| all[part_index]);
            if entry.beyond {
                let layer = stack.layer_with_token(&entry.layer);
                let nearest =
                    at.clone().find(|(l, _)| layer.is_none_or(|layer| layer == *l)).or(at.clone().next());
                let placed = |(l, part): (LayerIndex, usize)| (layer.unwrap_or(l), part);
                if let Some((layer, part)) = nearest.map(placed) {
                    self.layers[layer.index()].push(PlacedPaint {
                        entry: index,
                        part,
                        extent: PaintExtent::Beyond,
                    });
                }
                continue;
            }
            for (layer, part) in at {
                let whole = parts[layer.index()].list[part].is_whole() && !remodelled;
                let extent = if whole { PaintExtent::All } else { PaintExtent::Covered };
                self.layers[layer.index()].push(PlacedPaint { entry: index, part, extent });
            }
        }
        self.layers.iter_mut().for_each(|placed| placed.sort_unstable());
    }

    /// Returns true when there is paint that may be visible on an image layer.
    pub fn is_on(&self, layer: LayerIndex) -> bool {
        self.layers.get(layer.index()).is_some_and(|placed| !placed.is_empty())
    }

    /// Returns the image layers that may look different from `other`, which is paint of the same stack. Files of
    /// paint are named by the hash of their content.
    pub fn differs_on(&self, other: &Self) -> Vec<LayerIndex> {
        let layers = LayerIndex::all(self.layers.len().max(other.layers.len()));
        layers.filter(|&layer| !self.visible_on(layer).eq(other.visible_on(layer))).collect()
    }

    /// Returns what is visible on an image layer: files, their rectangles, and where they are placed.
    fn visible_on(&self, layer: LayerIndex) -> impl Iterator<Item = (&str, PixelRect, usize, PaintExtent)> {
        let placed = self.layers.get(layer.index()).into_iter().flatten();
        placed.map(|placed| {
            let entry = &self.entries[placed.entry];
            (entry.file.as_str(), entry.rect, placed.part, placed.extent)
        })
    }

    /// Returns the paint that is visible on the image layer with index `layer`, in photo pixels; empty where nothing
    /// was painted. `stack` has to be the stack with which the paint was opened. Paint with damaged files is left out.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn on(&self, stack: &Stack, layer: LayerIndex) -> Result<PaintPatch> {
        let mut patch = PaintPatch::of_pixels(&[]);
        if !self.is_on(layer) {
            return Ok(patch);
        }
        let parts = parts_of_layer(stack, layer);
        let all_parts = OnceCell::new();
        for placed in &self.layers[layer.index()] {
            let paint = self.patch(placed.entry, stack)?;
            let visible = paint.picked(|x, y, _| match placed.extent {
                PaintExtent::All => true,
                PaintExtent::Covered => parts.covered(&parts.list[placed.part]).holds(x, y),
                PaintExtent::Beyond => {
                    !all_parts.get_or_init(|| covered_by_all(&parts)).iter().any(|s| s.holds(x, y))
                }
            });
            patch = patch.under(&visible);
        }
        let rect = stack.layer(layer).rect;
        Ok(patch.picked(|x, y, _| rect.contains(x, y)))
    }

    /// Returns messages, with remedies, about paint that cannot be shown because its files are damaged or missing.
    pub fn damaged(&self) -> &[String] {
        &self.damaged
    }

    /// Returns the files of paint that may be visible in the stack, on which an export of it depends.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let lost = |index: &usize| !self.lost.contains(index);
        (0..self.entries.len()).filter(lost).map(|index| self.entries[index].file.as_str())
    }

    /// Returns the paint that has no place in the stack: entries without a surface, and pixels that a changed
    /// surface no longer covers.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn lost(&self, stack: &Stack) -> Result<Vec<LostPaint>> {
        let lost = |entry: &PaintEntry, pixels: u64, reason: &str| LostPaint {
            photo: entry.photo.clone(),
            face: entry.face_name(),
            pixels,
            reason: reason.into(),
        };
        let gone = self.lost.iter().map(|&index| &self.entries[index]);
        let mut all: Vec<_> =
            gone.map(|e| lost(e, e.pixels, "the surface is not in this photo's stack")).collect();
        for (index, entry) in self.entries.iter().enumerate() {
            let unplaced = self.unplaced(index, stack)?;
            if unplaced > 0 {
                all.push(lost(entry, unplaced, "the surface has changed and does not cover these pixels"));
            }
        }
        Ok(all)
    }

    /// Returns the number of pixels of a changed surface's paint that no part covers.
    fn unplaced(&self, index: usize, stack: &Stack) -> Result<u64> {
        let of_entry = |placed: &&PlacedPaint| placed.entry == index;
        let everywhere = self.layers.iter().flatten().filter(of_entry);
        let mut extents = everywhere.map(|placed| placed.extent).peekable();
        if extents.peek().is_none() || extents.any(|extent| extent != PaintExtent::Covered) {
            return Ok(0);
        }
        let mut patch = self.patch(index, stack)?;
        let layers = LayerIndex::all(self.layers.len()).zip(&self.layers);
        for (layer, placed) in layers.filter(|(_, placed)| placed.iter().any(|p| p.entry == index)) {
            let parts = parts_of_layer(stack, layer);
            for placed in placed.iter().filter(of_entry) {
                let covered = parts.covered(&parts.list[placed.part]);
                patch = patch.picked(|x, y, _| !covered.holds(x, y));
            }
        }
        Ok(patch.count())
    }

    /// Reads the pixels of an entry, reprojected if the camera has changed.
    fn patch(&self, index: usize, stack: &Stack) -> Result<PaintPatch> {
        let entry = &self.entries[index];
        let store = self.store.as_ref().expect("of() stores both entries and their store");
        let patch = store.patch(entry)?;
        let (camera, pose) = camera_of(&stack.photo, &stack.camera);
        let photo = PixelRect::of_size(stack.photo.width, stack.photo.height);
        Ok(match PaintMapping::between(entry, &self.views[index], camera, pose) {
            Some(moved) => moved.applied(&patch, photo),
            None => patch,
        })
    }
}

/// Returns the pixels that each part covers.
fn covered_by_all<'p>(parts: &'p LayerParts) -> Vec<&'p Spans> {
    parts.list.iter().map(|part| parts.covered(part)).collect()
}

/// Returns the parts of every image layer of a stack.
fn parts_of_stack(stack: &Stack) -> Vec<LayerParts<'_>> {
    stack.layer_indices().map(|layer| parts_of_layer(stack, layer)).collect()
}

/// Returns the parts of an image layer of a stack.
pub fn parts_of_layer(stack: &Stack, layer: LayerIndex) -> LayerParts<'_> {
    let elements: Vec<&Element> = stack.visibility_layers.iter().flatten().collect();
    let layer = stack.layer(layer);
    let shared = |e: ElementIndex| {
        stack.image_layers.iter().filter(|l: &&ImageLayer| l.elements.contains(&e)).count() > 1
    };
    let with_tile = |&e: &ElementIndex| (elements[e.index()], shared(e).then_some(layer.needed_rect));
    let of_layer: Vec<_> = layer.elements.iter().map(with_tile).collect();
    let scenery = PartSource {
        photo: &stack.photo,
        camera: &stack.camera,
        surfaces: &stack.surfaces,
        pieces: &stack.pieces,
    };
    scenery.parts(&of_layer, layer.rect)
}
