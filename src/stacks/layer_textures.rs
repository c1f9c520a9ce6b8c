//! Layer textures of the current stacks, read from their files with filling and paint.

mod bleed;
mod dome;
mod far;
mod filling;
mod origins;
mod see_through;
mod spared_paint;
pub mod surroundings;

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::bleed::mark_bleed;
pub use self::dome::KNOWN;
use self::filling::TextureFilling;
use self::see_through::lay_see_through_paint;
use self::surroundings::lower_beside_outlines;
use crate::far_backdrops::FarBackdrops;
use crate::layer_pixels::shown;
use crate::paint::PhotoPaint;
use crate::projected_paint::ProjectedPaint;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_base::raster::over::on_opaque;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_document::paint::PaintBook;
use quadratura_document::paint::PaintPatch;
use quadratura_document::stack::origins::origin_of;
use quadratura_io::layer_reader::{read_layer, read_mask};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_files::recorded_hash;
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::LayerIndex;
use quadratura_projection::dome::Dome;
use quadratura_projection::sources::{BLEED, COVERED, FILLED};
use quadratura_projection::{LayerTextureId, LayerTexturePixels, Texels};
use quadratura_view::legend::Origin;

/// The files of each layer texture. Layer textures are numbered as in [`quadratura_projection::Sources::layer_textures`]:
/// photo by photo, image layers as in the stack.
#[derive(Debug, Clone, Default)]
pub struct LayerTextureFiles {
    files: Arc<[LayerTextureFile]>,
    /// The stacks with their paint, by photo; empty where paint is not shown.
    painted: Vec<Option<PaintedStack>>,
    /// Paint on other photos that the files do not contain yet, by layer texture.
    projected: BTreeMap<LayerTextureId, Arc<ProjectedPaint>>,
    /// The hold on the stacks, which keeps these files on disk.
    reader: Option<Arc<StackReader>>,
    /// The dome, whose sides are the layer textures after those of the files; `None` shows nothing there.
    dome: Option<Arc<Dome>>,
    /// Whether the dome is empty in directions that no photo shows.
    known_dome: bool,
    /// The backdrops whose layers show surroundings.
    far: Arc<FarBackdrops>,
}

/// A stack and the paint on it.
#[derive(Debug, Clone)]
struct PaintedStack {
    stack: Arc<Stack>,
    paint: Arc<PhotoPaint>,
}

/// The files of one layer texture.
#[derive(Debug, Clone)]
struct LayerTextureFile {
    texels: PathBuf,
    needed: PathBuf,
    filled: Option<FilledFiles>,
    /// The image layer's rectangle, in photo pixels.
    rect: PixelRect,
    needed_rect: PixelRect,
    /// The index of the photo.
    photo: PhotoId,
    /// The index of the image layer in the stack.
    layer: LayerIndex,
    /// The photo's longer side in pixels where the layer shows the surroundings.
    longest_of_surroundings: Option<u32>,
    /// Whether of the filling only paint of other photos is used.
    propagated_alone: bool,
}

impl LayerTextureFile {
    /// Returns whether the layer texture has a matte.
    fn sees_through(&self) -> bool {
        self.filled.as_ref().is_some_and(|filled| filled.matte.is_some())
    }

    /// Returns whether all files of two versions of a layer texture have the same content. Files that are the same on
    /// disk, and those with the same bytes, do.
    fn same_content(&self, other: &Self) -> bool {
        let files = |file: &Self| {
            let filled = file.filled.iter().flat_map(|filled| {
                let always = [filled.colours.clone(), filled.confidence.clone()];
                let optional = [&filled.propagated, &filled.matte, &filled.foreground];
                always.into_iter().map(Some).chain(optional.map(Clone::clone))
            });
            [Some(file.texels.clone()), Some(file.needed.clone())]
                .into_iter()
                .chain(filled)
                .collect::<Vec<_>>()
        };
        let (ours, theirs) = (files(self), files(other));
        let same = |(a, b): (&Option<PathBuf>, &Option<PathBuf>)| match (a, b) {
            (Some(a), Some(b)) => a == b || same_file(a, b),
            (a, b) => a == b,
        };
        ours.len() == theirs.len() && ours.iter().zip(&theirs).all(same)
    }
}

/// The files of the filling of a layer texture.
#[derive(Debug, Clone)]
struct FilledFiles {
    colours: PathBuf,
    confidence: PathBuf,
    provenance: PathBuf,
    /// The sources that the provenance file's numbers stand for.
    origins: Arc<[Origin]>,
    /// The paint that was propagated from other photos over visible texels.
    propagated: Option<PathBuf>,
    /// The matte, where the surfaces are see-through.
    matte: Option<PathBuf>,
    /// Their own colours where the photo shows them mixed with what is behind.
    foreground: Option<PathBuf>,
}

impl LayerTextureFiles {
    /// Returns the same files with a hold on the stacks, which began before the stacks were read: while it lasts, the files
    /// of former versions stay on disk, too.
    pub fn held_by(self, reader: StackReader) -> Self {
        Self { reader: Some(Arc::new(reader)), ..self }
    }

    /// Lists the image layers of these stacks, in their order; photos without a stack have `None`. Files are read
    /// when they are needed: where a build replaces a stack in the meantime they no longer exist, and the stacks
    /// have to be read again, unless a hold keeps them ([`Self::held_by`]). `filled` tells whether fillings of hidden texels are used.
    pub fn new(store: &StackStore, stacks: &[Option<impl Borrow<Stack>>], filled: bool) -> Self {
        let stacks = PhotoId::all(stacks.len())
            .zip(stacks)
            .filter_map(|(photo, stack)| Some((photo, stack.as_ref()?.borrow())));
        let files = stacks.flat_map(|(photo, stack)| {
            let folder = store.folder(&stack.photo.name);
            let names = stack.fill.iter().flat_map(|fill| &fill.origins);
            let origins: Arc<[Origin]> = names.map(|name| origin_of(name)).collect();
            stack.numbered_layers().map(move |(index, layer)| LayerTextureFile {
                texels: folder.join(&layer.file),
                needed: folder.join(&layer.needed_file),
                filled: layer.fill.as_ref().filter(|_| filled).map(|fill| FilledFiles {
                    colours: folder.join(&fill.filled_file),
                    confidence: folder.join(&fill.confidence_file),
                    provenance: folder.join(&fill.provenance_file),
                    origins: origins.clone(),
                    propagated: fill.propagation_file.as_ref().map(|file| folder.join(file)),
                    matte: fill.matte_file.as_ref().map(|file| folder.join(file)),
                    foreground: fill.foreground_file.as_ref().map(|file| folder.join(file)),
                }),
                rect: layer.rect,
                needed_rect: layer.needed_rect,
                photo,
                layer: index,
                propagated_alone: false,
                longest_of_surroundings: stack
                    .is_of_surroundings(layer)
                    .then(|| stack.photo.width.max(stack.photo.height)),
            })
        });
        Self { files: files.collect(), ..Self::default() }
    }

    /// Returns the same with the project's present paint.
    ///
    /// # Errors
    /// Returns an error when the paint book cannot be read.
    pub fn with_paint(self, store: &StackStore, stacks: &[Option<Stack>]) -> Result<Self> {
        let book = PaintStore::new(store.project()).read()?;
        Ok(self.with_paint_of(store, stacks, &book))
    }

    /// Returns the same with the paint of a book.
    pub(super) fn with_paint_of(
        mut self,
        store: &StackStore,
        stacks: &[Option<Stack>],
        book: &PaintBook,
    ) -> Self {
        let paint = PaintStore::new(store.project());
        let of_stack = |stack: &Stack| PaintedStack {
            stack: Arc::new(stack.clone()),
            paint: Arc::new(PhotoPaint::new(book, paint.clone(), stack)),
        };
        self.painted = stacks.iter().map(|stack| stack.as_ref().map(of_stack)).collect();
        self
    }

    /// Returns the same with the paint of these photos (indices in the site) in `book`, the project's present paint,
    /// and the layer textures that may have changed by it.
    pub fn repainted(
        &self,
        store: &StackStore,
        book: &PaintBook,
        photos: &[PhotoId],
    ) -> (Self, Vec<LayerTextureId>) {
        let paint = PaintStore::new(store.project());
        let mut repainted = self.clone();
        let mut changed = Vec::new();
        for &photo in photos {
            let Some(Some(painted)) = repainted.painted.get_mut(photo.index()) else { continue };
            let now = PhotoPaint::new(book, paint.clone(), &painted.stack);
            let layers = now.differs_on(&painted.paint);
            let is_other = |file: &&LayerTextureFile| file.photo == photo && layers.contains(&file.layer);
            let layer_textures = (0..).map(LayerTextureId).zip(self.files.iter());
            changed.extend(
                layer_textures.filter(|(_, file)| is_other(file)).map(|(layer_texture, _)| layer_texture),
            );
            painted.paint = Arc::new(now);
        }
        (repainted, changed)
    }

    /// Returns the same with the present stacks (in the site's order) where these have the same image layers, in other
    /// files, and the layer textures whose files differ; `None` where image layers are others.
    pub fn with_stacks(
        &self,
        store: &StackStore,
        stacks: &[Option<Arc<Stack>>],
        filled: bool,
    ) -> Option<(Self, Vec<LayerTextureId>)> {
        let fresh = Self::new(store, stacks, filled).with_far(stacks, self.far.clone());
        let same = |(a, b): (&LayerTextureFile, &LayerTextureFile)| {
            let is_same = a.sees_through() == b.sees_through();
            is_same && (a.photo, a.layer, a.rect, a.needed_rect) == (b.photo, b.layer, b.rect, b.needed_rect)
        };
        if fresh.len() != self.len() || !self.files.iter().zip(fresh.files.iter()).all(same) {
            return None;
        }
        let other = |(a, b): (&LayerTextureFile, &LayerTextureFile)| !a.same_content(b);
        let pairs = (0..).map(LayerTextureId).zip(self.files.iter().zip(fresh.files.iter()));
        let mut changed: BTreeSet<LayerTextureId> =
            pairs.filter(|(_, pair)| other(*pair)).map(|(id, _)| id).collect();
        // What was shown before it was in the files is in those of a new version.
        let same_version = |id: &LayerTextureId| {
            let [before, now] = [self, &fresh].map(|files| files.file(*id).map(|file| &file.texels));
            matches!((before, now), (Ok(before), Ok(now)) if before == now)
        };
        let (kept, filed): (BTreeMap<_, _>, BTreeMap<_, _>) =
            self.projected.clone().into_iter().partition(|(id, _)| same_version(id));
        changed.extend(filed.into_keys());
        let reader = self.reader.clone();
        let mut now = Self { files: fresh.files, projected: kept, reader, ..self.clone() };
        for (painted, stack) in now.painted.iter_mut().zip(stacks) {
            painted.iter_mut().zip(stack).for_each(|(painted, stack)| painted.stack = stack.clone());
        }
        Some((now, changed.into_iter().collect()))
    }

    /// Returns the same with paint on these photos that the files do not contain yet, instead of what was shown so of
    /// them before, and the layer textures that change by it.
    pub fn with_projected(
        &self,
        photos: &[PhotoId],
        projected: Vec<ProjectedPaint>,
    ) -> (Self, Vec<LayerTextureId>) {
        let mut now = self.clone();
        let layer_textures = || (0..).map(LayerTextureId).zip(self.files.iter());
        let of_photos = |id: &LayerTextureId| self.file(*id).is_ok_and(|file| photos.contains(&file.photo));
        now.projected.retain(|id, _| !of_photos(id));
        for paint in projected {
            let is_its = |file: &LayerTextureFile| (file.photo, file.layer) == (paint.photo, paint.layer);
            let id = layer_textures().find(|(_, file)| is_its(file)).map(|(id, _)| id);
            id.into_iter().for_each(|id| drop(now.projected.insert(id, Arc::new(paint.clone()))));
        }
        let differs = |id: &LayerTextureId| self.projected.get(id) != now.projected.get(id);
        let changed = layer_textures().map(|(id, _)| id).filter(differs).collect();
        (now, changed)
    }

    /// Returns the stacks on which paint is shown, in the site's order.
    pub fn stacks(&self) -> Vec<Option<Arc<Stack>>> {
        self.painted.iter().map(|painted| painted.as_ref().map(|painted| painted.stack.clone())).collect()
    }

    /// Returns messages about paint that cannot be shown, with remedies.
    pub fn problems(&self) -> Vec<String> {
        let paint = self.painted.iter().flatten().map(|painted| &painted.paint);
        paint.flat_map(|paint| paint.damaged().iter().cloned()).collect()
    }

    /// Returns the files of a layer texture.
    fn file(&self, layer_texture: LayerTextureId) -> Result<&LayerTextureFile> {
        let file = self.files.get(layer_texture.0 as usize);
        file.ok_or_else(|| Error::Request(format!("there is no image layer {}", layer_texture.0)))
    }

    /// Returns what tells whether a layer texture without filling and paint shows the same as before: the hashes of its files, and
    /// its place.
    pub fn content(&self, layer_texture: LayerTextureId) -> impl serde::Serialize + use<> {
        let file = self.file(layer_texture).ok();
        file.map(|file| {
            let hashes = [&file.texels, &file.needed].map(|file| recorded_hash(file));
            let [rect, needed] = [file.rect, file.needed_rect].map(<[i64; 4]>::from);
            (hashes, rect, needed, file.longest_of_surroundings)
        })
    }

    /// Returns the number of layer textures.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Returns true when there are no layer textures.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

impl Texels for LayerTextureFiles {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        if let Some(side) = self.side_of_dome(layer_texture) {
            return Ok(dome::pixels(self.dome.as_deref(), side, self.known_dome));
        }
        let file = self.file(layer_texture)?;
        // The photo's pixels just outside of the layer's outlines are useful for filtering.
        let rect = file.needed_rect.grown(1).intersection(&file.rect);
        if file.needed_rect.is_empty() || rect.is_empty() {
            return Ok(LayerTexturePixels {
                rect,
                rgba: vec![0; 4 * rect.area() as usize],
                needed: vec![0; rect.area() as usize],
                matte: None,
            });
        }
        let mut rgba = read_layer(&file.texels, file.rect, rect)?;
        let mut needed = read_mask(&file.needed, file.rect, rect)?;
        mark_bleed(&rgba, &mut needed, rect.w as usize);
        let mut filling =
            file.filled.as_ref().map(|files| TextureFilling::read(files, file.rect, rect)).transpose()?;
        if file.propagated_alone {
            filling = filling.map(TextureFilling::propagated_alone);
        }
        if let Some(longest) = file.longest_of_surroundings {
            let filled = filling.as_ref().map(|filling| &filling.confidence[..]);
            lower_beside_outlines(&mut rgba, filled, rect, longest);
        }
        if let Some(projected) = self.projected.get(&layer_texture) {
            filling.get_or_insert_with(|| TextureFilling::of_nothing(rect)).take(projected, rect, &rgba);
        }
        let mut matte = None;
        if let Some(filling) = filling {
            filling.lay_foreground(&mut rgba);
            filling.lower_unknown(&mut rgba);
            fill_in(&mut rgba, &mut needed, &filling.colours, &filling.confidence);
            if let Some(propagated) = &filling.propagated {
                lay_propagated(&mut rgba, &mut needed, propagated, &filling.confidence);
            }
            matte = filling.solid_where_propagated().matte;
        }
        if let Some(Some(PaintedStack { stack, paint })) = self.painted.get(file.photo.index()) {
            let paint = paint.on(stack, file.layer)?;
            match &mut matte {
                Some(matte) => lay_see_through_paint(&mut rgba, &mut needed, matte, rect, &paint),
                None => lay_paint(&mut rgba, &mut needed, rect, &paint),
            }
        }
        Ok(LayerTexturePixels { rect, rgba, needed, matte })
    }
}

/// Returns whether two files have the same bytes; false where one cannot be read.
fn same_file(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(std::fs::read);
    matches!((a, b), (Ok(a), Ok(b)) if a == b)
}

/// Gives empty texels the colour of the filling, with its confidence as alpha.
fn fill_in(rgba: &mut [u8], needed: &mut [u8], colours: &[u8], confidence: &[u16]) {
    let filling = colours.as_chunks::<4>().0.iter().zip(confidence);
    let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(needed);
    for ((texel, needed), (colour, confidence)) in texels.zip(filling) {
        if texel[3] == 0 && *confidence > 0 {
            let [r, g, b, _] = *colour;
            *texel = [r, g, b, (*confidence).min(255) as u8];
            *needed |= FILLED;
        }
    }
}

/// Gives visible texels the paint that was propagated from another photo, with its confidence as alpha.
fn lay_propagated(rgba: &mut [u8], needed: &mut [u8], colours: &[u8], confidence: &[u16]) {
    let propagated = colours.as_chunks::<4>().0.iter().zip(confidence);
    let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(needed);
    for ((texel, needed), (colour, confidence)) in
        texels.zip(propagated).filter(|(_, (colour, _))| colour[3] > 0)
    {
        let [r, g, b, _] = *colour;
        *texel = [r, g, b, (*confidence).min(255) as u8];
        *needed |= FILLED;
    }
}

/// Puts paint on texels: opaque like the photo where faces cover them; elsewhere only its colour is kept, for
/// filtering.
fn lay_paint(rgba: &mut [u8], needed: &mut [u8], rect: PixelRect, paint: &PaintPatch) {
    for (x, y, colour) in paint.iter() {
        let Some(at) = rect.index(x, y) else { continue };
        let mut texel = shown(colour).map(in_8_bits);
        let (covered, a) = (needed[at] & COVERED != 0, texel[3]);
        let below = &mut rgba[4 * at..4 * at + 4];
        if needed[at] & FILLED != 0 && a != 0 {
            texel = over_filling(texel, below);
        }
        below.copy_from_slice(&[texel[0], texel[1], texel[2], if covered { texel[3] } else { 0 }]);
        needed[at] = if covered || a == 0 { needed[at] & COVERED } else { BLEED };
    }
}

/// Blends semitransparent paint with the filling below it.
pub fn over_filling(paint: [u8; 4], filling: &[u8]) -> [u8; 4] {
    let [r, g, b, alpha] = paint;
    let opaque = [r, g, b, u8::MAX];
    [0, 1, 2, 3].map(|i| on_opaque(opaque[i], alpha, filling[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_pixels_with_a_colour_lie_beside_what_the_layer_shows() {
        let (stone, other, none) = ([0, 0, 0, 255], [9, 0, 0, 0], [0; 4]);
        let rgba = [[stone, other, other, none], [none, none, other, other]].concat().concat();
        let mut needed = [COVERED, COVERED, COVERED, 0, COVERED, COVERED, 0, COVERED];
        let before = needed;
        mark_bleed(&rgba, &mut needed, 4);
        let marked: Vec<bool> =
            needed.iter().zip(before).map(|(now, before)| *now == before | BLEED).collect();
        assert_eq!(marked, [false, true, false, false, false, false, false, false]);
        // In rows of five, the seventh texel touches the first.
        mark_bleed(&rgba, &mut needed, 5);
        assert_eq!(
            needed.map(|needed| needed & BLEED != 0),
            [false, true, false, false, false, false, true, false]
        );
    }

    #[test]
    fn a_filling_never_takes_the_place_of_what_the_photo_shows() {
        let mut rgba = vec![1, 2, 3, 255, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut needed = vec![1, 1, 1];
        fill_in(&mut rgba, &mut needed, &[[7, 8, 9, 255]; 3].concat(), &[30, 30, 0]);
        assert_eq!(rgba, [1, 2, 3, 255, 7, 8, 9, 30, 0, 0, 0, 0]);
        assert_eq!(needed, [1, 1 | FILLED, 1]);
    }

    #[test]
    fn paint_of_another_photo_takes_the_place_of_what_the_photo_shows_and_is_trusted_less() {
        let mut rgba = [[1, 2, 3, 255]; 2].concat();
        let mut needed = vec![COVERED; 2];
        lay_propagated(&mut rgba, &mut needed, &[7, 8, 9, 255, 0, 0, 0, 0], &[100, 0]);
        assert_eq!((rgba, needed), (vec![7, 8, 9, 100, 1, 2, 3, 255], vec![COVERED | FILLED, COVERED]));
    }

    #[test]
    fn paint_is_there_like_the_photo_and_helps_past_the_outline() {
        let rect = PixelRect { x: 3, y: 0, w: 4, h: 1 };
        let mut rgba = vec![9u8; 16];
        let mut needed = vec![COVERED, COVERED, BLEED, 0];
        let red = [65535, 0, 0, 65535];
        let paint = PaintPatch::of_pixels(&[(3, 0, red), (4, 0, [0; 4]), (5, 0, red), (9, 0, red)]);
        lay_paint(&mut rgba, &mut needed, rect, &paint);
        assert_eq!(rgba, [255, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 0, 9, 9, 9, 9]);
        assert_eq!(needed, [COVERED, COVERED, BLEED, 0]);
        let (mut filled, mut needed) = (vec![100, 0, 0, 55], vec![COVERED | FILLED]);
        let soft = PaintPatch::of_pixels(&[(0, 0, [0, 65535, 0, 51 * 257])]);
        lay_paint(&mut filled, &mut needed, PixelRect::of_size(1, 1), &soft);
        assert_eq!(
            (filled, needed),
            (vec![80, 51, 0, 95], vec![COVERED]),
            "soft paint lets the filling through"
        );
    }
}
