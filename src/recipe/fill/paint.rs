//! The project's paint as filling needs it: by photo, on the surfaces of the model.

use std::collections::{BTreeMap, BTreeSet};

use crate::document::Stack;
use crate::document::paint::{PaintBook, Patch};
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::{PaintedSurface, SurfaceId, Surfaces};
use crate::projection::PhotoId;
use crate::raster::in_8_bits;
use crate::recipe::paint::PhotoPaint;
use crate::recipe::paint::by_surface::SurfaceName;
use crate::scene::{FaceId, Model};

/// All paint of a site.
pub(super) struct SitePaint<'a> {
    surfaces: &'a Surfaces,
    faces: BTreeMap<&'a str, &'a [FaceId]>,
    /// In the site's order; none for photos without a stack.
    photos: Vec<Option<(&'a Stack, PhotoPaint)>>,
}

impl<'a> SitePaint<'a> {
    /// Finds the place of what a book says in these stacks, which are in the site's order. No pixel is read yet.
    pub fn of(
        book: &PaintBook,
        store: &PaintStore,
        stacks: &'a [Option<Stack>],
        model: &'a Model,
        surfaces: &'a Surfaces,
    ) -> Self {
        let paint = |stack: &'a Stack| (stack, PhotoPaint::of(book, store.clone(), stack));
        let photos = stacks.iter().map(|stack| stack.as_ref().map(paint)).collect();
        let faces = model.objects.iter().map(|o| (o.name.as_str(), &o.faces[..])).collect();
        Self { surfaces, faces, photos }
    }

    /// The paint of one photo.
    ///
    /// # Errors
    /// What reading a file of paint says.
    pub fn of_photo(&self, photo: PhotoId) -> Result<Vec<PaintedSurface>> {
        let Some((stack, paint)) = &self.photos[photo.0 as usize] else { return Ok(Vec::new()) };
        let by_surface = paint.by_surface(stack)?;
        let painted = by_surface.iter().filter_map(|(name, patch)| Some(painted(self.id(name)?, patch)));
        Ok(painted.collect())
    }

    /// What of a photo's paint is damaged or gone, so that the photo gives what is under it.
    pub fn damaged(&self, photo: PhotoId) -> &[String] {
        self.photos[photo.0 as usize].as_ref().map_or(&[], |(_, paint)| paint.damaged())
    }

    /// The surfaces that are painted on in a photo.
    pub fn surfaces_of(&self, photo: PhotoId) -> BTreeSet<SurfaceId> {
        let Some((stack, paint)) = &self.photos[photo.0 as usize] else { return BTreeSet::new() };
        paint.surfaces(stack).iter().filter_map(|name| self.id(name)).collect()
    }

    /// By face, the photos in which somebody painted on it, rising.
    pub fn painters(&self, model: &Model) -> Vec<Vec<PhotoId>> {
        let mut painters = vec![Vec::new(); model.faces.len()];
        for photo in (0..self.photos.len() as u32).map(PhotoId) {
            for surface in self.surfaces_of(photo) {
                let of_face: &mut Vec<PhotoId> = &mut painters[self.surfaces.get(surface).face.0 as usize];
                if of_face.last() != Some(&photo) {
                    of_face.push(photo);
                }
            }
        }
        painters
    }

    /// A stack may be of an older model.
    fn id(&self, name: &SurfaceName) -> Option<SurfaceId> {
        let face = *self.faces.get(name.object.as_str())?.get(name.face as usize)?;
        self.surfaces.find(face, name.triangle)
    }
}

fn painted(surface: SurfaceId, patch: &Patch) -> PaintedSurface {
    PaintedSurface {
        surface,
        pixels: patch.pixels().map(|colour| colour.map(|colour| colour.map(in_8_bits))),
    }
}
