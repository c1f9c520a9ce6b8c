//! The project's paint for filling: by photo and surface of the model.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};

use crate::document::Stack;
use crate::document::paint::{PaintBook, PaintPatch};
use crate::document::stack::{FilledPaint, SurfaceName};
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::{PaintedSurface, SurfaceId, Surfaces};
use crate::raster::in_8_bits;
use crate::recipe::paint::PhotoPaint;
use crate::scene::{FaceId, Model, PhotoId};

/// All paint of a site.
pub(super) struct SitePaint<'a> {
    surfaces: &'a Surfaces,
    faces: BTreeMap<&'a str, &'a [FaceId]>,
    /// The stacks with their paint, in the site's order; `None` for photos without a stack.
    photos: Vec<Option<(&'a Stack, PhotoPaint)>>,
}

impl<'a> SitePaint<'a> {
    /// Assigns the paint of a book to these stacks, which are in the site's order. No pixels are read yet.
    pub fn new(
        book: &PaintBook,
        store: &PaintStore,
        stacks: &'a [Option<impl Borrow<Stack>>],
        model: &'a Model,
        surfaces: &'a Surfaces,
    ) -> Self {
        let paint = |stack: &'a Stack| (stack, PhotoPaint::new(book, store.clone(), stack));
        let photos = stacks.iter().map(|stack| stack.as_ref().map(|stack| paint(stack.borrow()))).collect();
        let faces = model.objects.iter().map(|o| (o.name.as_str(), &o.faces[..])).collect();
        Self { surfaces, faces, photos }
    }

    /// Reads the paint of one photo.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn of_photo(&self, photo: PhotoId) -> Result<Vec<PaintedSurface>> {
        let Some((stack, paint)) = &self.photos[photo.index()] else { return Ok(Vec::new()) };
        let by_surface = paint.by_surface(stack)?;
        let painted = by_surface.iter().filter_map(|(name, patch)| Some(painted(self.id(name)?, patch)));
        Ok(painted.collect())
    }

    /// Returns messages about a photo's paint that is damaged or missing, so that the pixels below it are used.
    pub fn damaged(&self, photo: PhotoId) -> &[String] {
        self.photos[photo.index()].as_ref().map_or(&[], |(_, paint)| paint.damaged())
    }

    /// Returns true when some paint of the site is damaged or missing.
    pub fn is_damaged(&self) -> bool {
        self.photos.iter().flatten().any(|(_, paint)| !paint.damaged().is_empty())
    }

    /// Returns the surfaces that have paint in a photo.
    pub fn surfaces_of(&self, photo: PhotoId) -> BTreeSet<SurfaceId> {
        let Some((stack, paint)) = &self.photos[photo.index()] else { return BTreeSet::new() };
        paint.surfaces(stack).iter().filter_map(|name| self.id(name)).collect()
    }

    /// Returns, for each face, the photos in which it has paint, ascending.
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
        let mut placed: Vec<FilledPaint> = photos.flat_map(|(stack, paint)| paint.placed(stack)).collect();
        placed.sort_by(|a, b| (&a.photo, &a.entry).cmp(&(&b.photo, &b.entry)));
        placed
    }

    /// Returns the surface of this name; `None` where the stack was made from an older model that had it.
    pub fn id(&self, name: &SurfaceName) -> Option<SurfaceId> {
        let face = *self.faces.get(name.object.as_str())?.get(name.face.index())?;
        self.surfaces.find(face, name.triangle)
    }
}

/// Converts a patch to 8 bits per channel.
fn painted(surface: SurfaceId, patch: &PaintPatch) -> PaintedSurface {
    PaintedSurface {
        surface,
        pixels: patch.pixels().map(|colour| colour.map(|colour| colour.map(in_8_bits))),
    }
}
