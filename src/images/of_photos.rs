//! Layered depth images of several photos, whose depth images or whole stacks are warped into one camera.

use std::sync::Arc;

use super::choice::best_photos;
use super::options::{PhotosOptions, StackLdiOptions};
use super::reference_camera::{OfPhoto, ReferenceCamera};
use super::site::LdiSite;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_base::task::Task;
use quadratura_files::hash::Hashing;
use quadratura_ldi::{Ldi, LdiKind, SourceImage, combine};
use quadratura_projection::exposure::shares_of_view;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::Relief;
use quadratura_stacks::sources::sources;
use quadratura_view::Shot;

/// Combines photos, whose layered depth images are given in the order of the published rule, into one camera.
///
/// # Errors
/// [`Error::Request`] for a frame that is too large, or [`Error::Cancelled`].
pub fn ldi_of_photos(
    reference: &ReferenceCamera,
    photos: &[OfPhoto],
    options: &PhotosOptions,
    task: &Task,
) -> Result<Ldi> {
    let frame = reference.frame(options.scale, options.guard)?;
    let taken = |ldi: &Arc<Ldi>| if options.hidden { ldi.clone() } else { Arc::new(ldi.depth_image()) };
    let taken: Vec<OfPhoto> = photos.iter().map(|(ldi, photo)| (taken(ldi), *photo)).collect();
    let is_own = |photo: PhotoId| Some(photo) == reference.photo;
    let sources: Vec<SourceImage> =
        taken.iter().map(|(ldi, photo)| SourceImage { ldi, is_own: is_own(*photo) }).collect();
    let words = options.described();
    let mut hashing = Hashing::default();
    hashing.add(format!("{frame:?} {words:?}").as_bytes());
    taken.iter().for_each(|(ldi, _)| hashing.add(ldi.inputs.as_bytes()));
    let made = combine(LdiKind::Photos, &frame, &sources, &options.combining, words, task)?;
    Ok(Ldi { inputs: hashing.hash(), ..made })
}

/// Combines depth images from elsewhere into the camera of the first one.
///
/// # Errors
/// [`Error::Request`] for a frame that is too large, or [`Error::Cancelled`].
pub fn combined_depth_images(images: &[Ldi], options: &PhotosOptions, task: &Task) -> Result<Ldi> {
    let first = images.first().ok_or_else(|| Error::Request("there is no depth image to combine".into()))?;
    let Ldi { camera, pose, gain, .. } = *first;
    let reference = ReferenceCamera { camera, pose, photo: Some(PhotoId::new(0)), gain };
    let frame = reference.frame(options.scale, options.guard)?;
    let source = |(i, ldi)| SourceImage { ldi, is_own: i == 0 };
    let sources: Vec<SourceImage> = images.iter().enumerate().map(source).collect();
    let mut words = options.described();
    words.insert("from".to_owned(), LdiKind::Depth.name().to_owned());
    combine(LdiKind::Depth, &frame, &sources, &options.combining, words, task)
}

impl LdiSite<'_> {
    /// Makes the layered depth image of some photos in the camera of the first one. One of the others that cannot be used is
    /// noted and left out.
    ///
    /// # Errors
    /// Those of [`Self::ldi_of_stack`] for the first photo, and those of [`ldi_of_photos`].
    pub fn ldi_of_photos(&mut self, photos: &[PhotoId], options: &PhotosOptions, task: &Task) -> Result<Ldi> {
        let first = *photos.first().ok_or_else(|| Error::Request("no photo is left to combine".into()))?;
        let photo = self.site().photo(first).clone();
        let images = self.images_of(photos, &options.stack, task)?;
        let gain = images[0].0.gain;
        let reference = ReferenceCamera { camera: photo.camera, pose: photo.pose, photo: Some(first), gain };
        ldi_of_photos(&reference, &images, options, task)
    }

    /// Returns the images of photos' stacks. One that cannot be used is noted and left out, but for the first one.
    ///
    /// # Errors
    /// Those of [`Self::ldi_of_stack`] for the first photo, and [`Error::Cancelled`].
    fn images_of(
        &mut self,
        photos: &[PhotoId],
        stack: &StackLdiOptions,
        task: &Task,
    ) -> Result<Vec<OfPhoto>> {
        let mut images = Vec::new();
        for &photo in photos {
            match self.cached_or_made(photo, stack, task) {
                Ok(ldi) => images.push((Arc::new(ldi), photo)),
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) if images.is_empty() => return Err(error),
                Err(error) => task.note(error.message()),
            }
        }
        Ok(images)
    }

    /// Returns the photo and those that show most of what it shows, `most` in all, by falling share.
    pub fn with_best(&self, photo: PhotoId, most: usize) -> Vec<PhotoId> {
        let site = self.site();
        let without: Vec<PhotoId> =
            site.photo_ids().filter(|other| *other == photo || !self.has_stack(*other)).collect();
        let sources = sources(site, self.stacks(), &self.project().decisions);
        let surface = ModelSurface::from_model(&site.model).with_backs(&site.model, &sources);
        let Photo { camera, pose, .. } = *site.photo(photo);
        let shot = Shot { without, ..Shot::new(camera, pose) };
        let shares = shares_of_view(&shot, &site.model, &sources, &surface, &Relief::default());
        let others = best_photos(&shares, most.saturating_sub(1));
        std::iter::once(photo).chain(others).collect()
    }
}
