//! Layered depth images of several photos, whose depth images or whole stacks are warped into one camera.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::choice::best_photos;
use super::options::{PhotosOptions, StackLdiOptions};
use super::reference_camera::{OfPhoto, ReferenceCamera};
use super::site::LdiSite;
use crate::open::Opened;
use crate::sources::sources;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_base::task::Task;
use quadratura_files::hash::Hashing;
use quadratura_ldi::{Frame, Ldi, LdiKind, Source, combine};
use quadratura_projection::exposure::{Shares, shares_of_view};
use quadratura_projection::relief::Relief;
use quadratura_projection::surface::Surface;
use quadratura_view::Shot;

/// Combines photos, whose layered depth images are given in the order of the published rule, into one camera.
///
/// # Errors
/// [`Error::Request`] for a frame that is too large, or [`Error::Cancelled`].
pub fn ldi_of_photos(
    reference: &ReferenceCamera,
    photos: &[(Arc<Ldi>, PhotoId)],
    options: &PhotosOptions,
    task: &Task,
) -> Result<Ldi> {
    let frame = reference.frame(options.scale, options.guard)?;
    combined_into(&frame, reference.photo, &taken(photos, options), (options, options.described()), task)
}

/// Returns what is combined of photos' images: all, or what each photo shows.
pub(super) fn taken(photos: &[OfPhoto], options: &PhotosOptions) -> Vec<OfPhoto> {
    let taken = |ldi: &Arc<Ldi>| if options.hidden { ldi.clone() } else { Arc::new(ldi.depth_image()) };
    photos.iter().map(|(ldi, photo)| (taken(ldi), *photo)).collect()
}

/// Combines photos' images into a frame, of whose centre `own` is, with options in words.
pub(super) fn combined_into(
    frame: &Frame,
    own: Option<PhotoId>,
    photos: &[OfPhoto],
    (options, words): (&PhotosOptions, BTreeMap<String, String>),
    task: &Task,
) -> Result<Ldi> {
    let sources: Vec<Source> =
        photos.iter().map(|(ldi, photo)| Source { ldi, is_own: Some(*photo) == own }).collect();
    let mut hashing = Hashing::default();
    hashing.add(format!("{frame:?} {words:?}").as_bytes());
    photos.iter().for_each(|(ldi, _)| hashing.add(ldi.inputs.as_bytes()));
    let made = combine(LdiKind::Photos, frame, &sources, &options.combining, words, task)?;
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
    let source = |(i, ldi)| Source { ldi, is_own: i == 0 };
    let sources: Vec<Source> = images.iter().enumerate().map(source).collect();
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
        let photo = self.opened().site.photo(first).clone();
        let images = self.images_of(photos, &options.stack, task)?;
        let gain = images[0].0.gain;
        let reference = ReferenceCamera { camera: photo.camera, pose: photo.pose, photo: Some(first), gain };
        ldi_of_photos(&reference, &images, options, task)
    }

    /// Returns the images of photos' stacks. One that cannot be used is noted and left out, but for the first one.
    ///
    /// # Errors
    /// Those of [`Self::ldi_of_stack`] for the first photo, and [`Error::Cancelled`].
    pub(super) fn images_of(
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
        let Photo { camera, pose, .. } = *self.opened().site.photo(photo);
        self.with_best_of(photo, &[(camera, pose)], most)
    }

    /// Returns the photo and those that show most of what some cameras show together, `most` in all, by falling share.
    pub(super) fn with_best_of(
        &self,
        photo: PhotoId,
        cameras: &[(Pinhole, Pose)],
        most: usize,
    ) -> Vec<PhotoId> {
        let Opened { site, project, .. } = self.opened();
        let without: Vec<PhotoId> =
            site.photo_ids().filter(|other| *other == photo || !self.has_stack(*other)).collect();
        let sources = sources(site, self.stacks(), &project.decisions);
        let surface = Surface::from_model(&site.model).with_backs(&site.model, &sources);
        let of_camera = |(camera, pose): &(Pinhole, Pose)| {
            let shot = Shot { without: without.clone(), ..Shot::new(*camera, *pose) };
            shares_of_view(&shot, &site.model, &sources, &surface, &Relief::default())
        };
        let sum = |mut all: Shares, one: Shares| {
            all.of_photo.iter_mut().zip(one.of_photo).for_each(|(sum, share)| *sum += share);
            all
        };
        let shares = cameras.iter().map(of_camera).reduce(sum);
        let others = shares.map_or_else(Vec::new, |all| best_photos(&all, most.saturating_sub(1)));
        std::iter::once(photo).chain(others).collect()
    }
}
