//! The project's paint for filling: by photo and surface of the model.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};

use crate::paint::PhotoPaint;
use quadratura_base::error::Result;
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_document::Stack;
use quadratura_document::paint::{PaintBook, PaintEntry, PaintPatch};
use quadratura_document::stack::{FilledPaint, SurfaceName};
use quadratura_io::paint_store::PaintStore;
use quadratura_layers::fill::{FillOptions, FillSurfaceId, FillSurfaces, PaintedSurface};

/// The photos for which paint is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SeenBy {
    /// The photo on which it was painted.
    Itself,
    /// All other photos.
    Others,
}

/// All paint of a site.
pub(super) struct SitePaint<'a> {
    surfaces: &'a FillSurfaces,
    faces: BTreeMap<&'a str, &'a [FaceId]>,
    /// The stacks with their paint, in the site's order; `None` for photos without a stack.
    photos: Vec<Option<StackPaint<'a>>>,
}

/// The paint of one photo.
struct StackPaint<'a> {
    stack: &'a Stack,
    /// All paint.
    own: PhotoPaint,
    /// The paint without that which only this photo sees; `None` where that is all.
    offered: Option<PhotoPaint>,
}

impl<'a> StackPaint<'a> {
    fn new(book: &PaintBook, store: &PaintStore, stack: &'a Stack, options: &FillOptions) -> Self {
        let photo = &stack.photo.name;
        let own = PhotoPaint::new(book, store.clone(), stack);
        let stays = |entry: &PaintEntry| options.stays(&entry.place());
        let offered = book.entries.iter().any(|entry| entry.photo == *photo && stays(entry)).then(|| {
            let entries = book.entries.iter().filter(|entry| !stays(entry)).cloned().collect();
            PhotoPaint::new(&PaintBook { entries, ..book.clone() }, store.clone(), stack)
        });
        Self { stack, own, offered }
    }

    /// Returns all paint that lies on surfaces of the stack.
    fn placed(&self) -> Vec<FilledPaint> {
        let mut placed = self.own.placed(self.stack);
        if let Some(offered) = &self.offered {
            let seen: BTreeSet<String> =
                offered.placed(self.stack).into_iter().map(|paint| paint.entry).collect();
            placed.iter_mut().for_each(|paint| paint.only_here = !seen.contains(&paint.entry));
        }
        placed
    }

    /// Returns the paint that other photos see.
    fn offered(&self) -> &PhotoPaint {
        self.offered.as_ref().unwrap_or(&self.own)
    }
}

impl<'a> SitePaint<'a> {
    /// Assigns the paint of a book to these stacks, which are in the site's order. No pixels are read yet. The
    /// options say which paint stays in its photo.
    pub fn new(
        options: &FillOptions,
        book: &PaintBook,
        store: &PaintStore,
        stacks: &'a [Option<impl Borrow<Stack>>],
        model: &'a Model,
        surfaces: &'a FillSurfaces,
    ) -> Self {
        let paint = |stack: &'a Stack| StackPaint::new(book, store, stack, options);
        let photos = stacks.iter().map(|stack| stack.as_ref().map(|stack| paint(stack.borrow()))).collect();
        let faces = model.objects.iter().map(|o| (o.name.as_str(), &o.faces[..])).collect();
        Self { surfaces, faces, photos }
    }

    /// Reads the paint of one photo: all, or what other photos see of it.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn of_photo(&self, photo: PhotoId, seen_by: SeenBy) -> Result<Vec<PaintedSurface>> {
        let Some(paint) = &self.photos[photo.index()] else { return Ok(Vec::new()) };
        let by_surface = match seen_by {
            SeenBy::Itself => paint.own.by_surface(paint.stack)?,
            SeenBy::Others => paint.offered().by_surface(paint.stack)?,
        };
        let painted = by_surface.iter().filter_map(|(name, patch)| Some(painted(self.id(name)?, patch)));
        Ok(painted.collect())
    }

    /// Returns messages about a photo's paint that is damaged or missing, so that the pixels below it are used.
    pub fn damaged(&self, photo: PhotoId) -> &[String] {
        self.photos[photo.index()].as_ref().map_or(&[], |paint| paint.own.damaged())
    }

    /// Returns true when a photo has paint that other photos must not see.
    pub fn keeps_some(&self, photo: PhotoId) -> bool {
        self.photos[photo.index()].as_ref().is_some_and(|paint| paint.offered.is_some())
    }

    /// Returns true when some paint of the site is damaged or missing.
    pub fn is_damaged(&self) -> bool {
        self.photos.iter().flatten().any(|paint| !paint.own.damaged().is_empty())
    }

    /// Returns the surfaces that have paint in a photo which other photos may see.
    pub fn surfaces_of(&self, photo: PhotoId) -> BTreeSet<FillSurfaceId> {
        let Some(paint) = &self.photos[photo.index()] else { return BTreeSet::new() };
        paint.offered().surfaces(paint.stack).iter().filter_map(|name| self.id(name)).collect()
    }

    /// Returns, for each face, the photos in which it has paint that other photos may see, ascending.
    pub fn painters(&self, model: &Model) -> Vec<Vec<PhotoId>> {
        let mut painters = vec![Vec::new(); model.faces.len()];
        for photo in PhotoId::all(self.photos.len()) {
            for surface in self.surfaces_of(photo) {
                let of_face: &mut Vec<PhotoId> = &mut painters[self.surfaces.get(surface).face.0 as usize];
                if of_face.last() != Some(&photo) {
                    of_face.push(photo);
                }
            }
        }
        painters
    }

    /// Returns all paint that lies on surfaces of the stacks, sorted.
    pub fn placed(&self) -> Vec<FilledPaint> {
        let photos = self.photos.iter().flatten();
        let mut placed: Vec<FilledPaint> = photos.flat_map(StackPaint::placed).collect();
        placed.sort_by(|a, b| (&a.photo, &a.entry).cmp(&(&b.photo, &b.entry)));
        placed
    }

    /// Returns the surface of this name; `None` where the stack was made from an older model that had it.
    pub fn id(&self, name: &SurfaceName) -> Option<FillSurfaceId> {
        let face = *self.faces.get(name.object.as_str())?.get(name.face.index())?;
        self.surfaces.find(face, name.triangle)
    }
}

/// Converts a patch to 8 bits per channel.
fn painted(surface: FillSurfaceId, patch: &PaintPatch) -> PaintedSurface {
    PaintedSurface {
        surface,
        pixels: patch.pixels().map(|colour| colour.map(|colour| colour.map(in_8_bits))),
    }
}
