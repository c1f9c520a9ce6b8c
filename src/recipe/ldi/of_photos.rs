//! Layered depth images of several photos, whose depth images or whole stacks are warped into one camera.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::StackLdiOptions;
use super::controller::{OfPhoto, best_photos};
use super::site::LdiSite;
use crate::open::Opened;
use crate::sources::sources;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_base::task::Task;
use quadratura_files::hash::Hashing;
use quadratura_ldi::layout::LONGEST_SIDE;
use quadratura_ldi::merge::Merging;
use quadratura_ldi::{Combining, Frame, Ldi, LdiKind, Source, combine};
use quadratura_projection::exposure::{Shares, shares_of_view};
use quadratura_projection::relief::Relief;
use quadratura_projection::surface::Surface;
use quadratura_view::Shot;

/// How photos are combined into one layered depth image.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotosOptions {
    /// What is taken from each photo.
    pub stack: StackLdiOptions,
    /// Whether what is hidden in each photo is taken, too: all of its stack instead of its depth image.
    pub hidden: bool,
    /// The share of its sides by which the photo's frame is grown on each side.
    pub guard: f64,
    /// The factor of the reference camera's resolution.
    pub scale: f64,
    /// How samples become layers.
    pub combining: Combining,
}

impl Default for PhotosOptions {
    fn default() -> Self {
        Self {
            stack: StackLdiOptions::default(),
            hidden: false,
            guard: 0.3,
            scale: 1.0,
            combining: Combining::default(),
        }
    }
}

impl PhotosOptions {
    /// The published system: depth images in the order in which they are given, one sample a pixel, no guard band.
    pub fn published() -> Self {
        let combining = Combining { published: true, ..Combining::default() };
        Self { guard: 0.0, combining, ..Self::default() }
    }

    /// Returns the options by their names on the command line.
    pub(super) fn described(&self) -> BTreeMap<String, String> {
        let Self { stack, hidden, guard, scale, combining } = self;
        let Merging { epsilon, keep, layers, .. } = combining.merging;
        let mut words = stack.described(LdiKind::Photos);
        words.extend(
            [
                ("hidden", hidden.to_string()),
                ("guard", guard.to_string()),
                ("scale", scale.to_string()),
                ("epsilon", epsilon.to_string()),
                ("layers", layers.to_string()),
                ("merge", if keep { "keep" } else { "mean" }.to_owned()),
                ("published", combining.published.to_string()),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        words
    }
}

/// The camera of a layered depth image of photos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The camera, before it is scaled and grown.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The photo whose camera it is.
    pub photo: Option<PhotoId>,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
}

impl Reference {
    /// Returns the frame of the layered depth image, with the factor of the resolution and the guard band.
    ///
    /// # Errors
    /// [`Error::Request`] for a frame that is too large.
    pub(super) fn frame(&self, scale: f64, guard: f64) -> Result<Frame> {
        let camera = scaled(&self.camera, scale);
        let frame = Frame::new((camera, self.pose), self.gain, guard, self.photo.is_some());
        let Pinhole { width, height, .. } = frame.camera;
        if width.max(height) > LONGEST_SIDE {
            return Err(Error::Request(format!(
                "the frame of the layered depth image would have {width} x {height} pixels; its sides have at most \
                 {LONGEST_SIDE}: give a smaller --ldi-scale or --guard"
            )));
        }
        Ok(frame)
    }
}

/// Returns a camera of another resolution.
fn scaled(camera: &Pinhole, scale: f64) -> Pinhole {
    let side = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
    let (width, height) = (side(camera.width), side(camera.height));
    let (x, y) = (f64::from(width) / f64::from(camera.width), f64::from(height) / f64::from(camera.height));
    Pinhole { width, height, fx: camera.fx * x, fy: camera.fy * y, cx: camera.cx * x, cy: camera.cy * y }
}

/// Combines photos, whose layered depth images are given in the order of the published rule, into one camera.
///
/// # Errors
/// [`Error::Request`] for a frame that is too large, or [`Error::Cancelled`].
pub fn ldi_of_photos(
    reference: &Reference,
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
    let reference = Reference { camera, pose, photo: Some(PhotoId::new(0)), gain };
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
        let reference = Reference { camera: photo.camera, pose: photo.pose, photo: Some(first), gain };
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
