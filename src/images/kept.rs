//! The layered depth images that were made for views and are kept for the next ones.

use std::sync::Arc;

use super::of_photos::ldi_of_photos;
use super::of_site::SiteCamera;
use super::options::{PhotosOptions, SiteLdiOptions, StackLdiOptions};
use super::reference_camera::{OfPhoto, ReferenceCamera};
use super::site::LdiSite;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId};
use quadratura_base::task::Task;
use quadratura_ldi::Ldi;
use quadratura_views::preview::Preview;

/// What a layered depth image that is kept was made of: photos, the reference first, and the power of two by which its camera
/// was reduced.
type CombinationKey = (Vec<PhotoId>, u32);

/// The layered depth images that were made, as long as memory lasts: those that were used last.
pub struct Kept {
    memory: u64,
    /// Of single photos' stacks.
    stacks: Vec<(PhotoId, Arc<Ldi>)>,
    /// Of several photos, the last used one last.
    combined: Vec<(CombinationKey, Arc<Ldi>)>,
    /// Of everything, in the camera of a photo, the last used one last.
    of_site: Vec<((PhotoId, u32), Arc<Ldi>)>,
}

impl Kept {
    /// Keeps nothing yet; at most `memory` bytes, but always the one in use.
    pub fn new(memory: u64) -> Self {
        Self { memory, stacks: Vec::new(), combined: Vec::new(), of_site: Vec::new() }
    }

    /// Forgets what would be made otherwise now: the stacks' images whose inputs are others, and all that were made of several
    /// photos if any of these are.
    pub fn keep_current(&mut self, site: &LdiSite, options: &StackLdiOptions) {
        let stale: Vec<PhotoId> = self
            .stacks
            .iter()
            .filter(|(photo, ldi)| site.inputs(*photo, options).as_deref() != Some(&ldi.inputs))
            .map(|(photo, _)| *photo)
            .collect();
        self.stacks.retain(|(photo, _)| !stale.contains(photo));
        // The images of dropped stacks may still be in one of several photos: their inputs are not known any more.
        let known = |photo: &PhotoId| self.stacks.iter().any(|(other, _)| other == photo);
        self.combined.retain(|((photos, _), _)| photos.iter().all(known));
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.stacks.clear();
        self.combined.clear();
        self.of_site.clear();
    }

    /// Returns whether the image of a photo's stack is kept.
    pub fn has_stack(&self, photo: PhotoId) -> bool {
        self.stacks.iter().any(|(other, _)| *other == photo)
    }

    /// Returns the layered depth image of a photo's stack.
    ///
    /// # Errors
    /// Those of [`LdiSite::ldi_of_stack`].
    pub fn stack(
        &mut self,
        site: &mut LdiSite,
        photo: PhotoId,
        options: &StackLdiOptions,
        task: &Task,
    ) -> Result<Arc<Ldi>> {
        let found = self.stacks.iter().position(|(other, _)| *other == photo);
        let kept = match found {
            Some(at) => self.stacks.remove(at),
            None => (photo, Arc::new(site.cached_or_made(photo, options, task)?)),
        };
        let ldi = kept.1.clone();
        self.stacks.push(kept);
        limit(&mut self.stacks, self.memory / 2);
        Ok(ldi)
    }

    /// Returns the layered depth images of some photos' stacks. Photos that cannot be used are noted and left out.
    ///
    /// # Errors
    /// [`Error::Request`] where no photo can be used, and [`Error::Cancelled`].
    pub fn stacks(
        &mut self,
        site: &mut LdiSite,
        photos: &[PhotoId],
        options: &StackLdiOptions,
        task: &Task,
    ) -> Result<Vec<OfPhoto>> {
        let mut images = Vec::new();
        for &photo in photos {
            match self.stack(site, photo, options, task) {
                Ok(ldi) => images.push((ldi, photo)),
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => task.note(error.message()),
            }
        }
        match images.is_empty() {
            true => Err(Error::Request("no photo that shows anything of the view can be used".into())),
            false => Ok(images),
        }
    }

    /// Returns the layered depth image of some photos in the camera of the first one, reduced `halvings` times.
    ///
    /// # Errors
    /// Those of [`Self::stacks`] and [`ldi_of_photos`].
    pub fn photos(
        &mut self,
        site: &mut LdiSite,
        photos: &[PhotoId],
        halvings: u32,
        options: &PhotosOptions,
        task: &Task,
    ) -> Result<Arc<Ldi>> {
        let key = (photos.to_vec(), halvings);
        if let Some(at) = self.combined.iter().position(|(other, _)| *other == key) {
            let kept = self.combined.remove(at);
            let ldi = kept.1.clone();
            self.combined.push(kept);
            return Ok(ldi);
        }
        let images = self.stacks(site, photos, &options.stack, task)?;
        let (ref own, first) = images[0];
        let reference =
            ReferenceCamera { camera: own.camera, pose: own.pose, photo: Some(first), gain: own.gain };
        let options = PhotosOptions { scale: options.scale / f64::from(1u32 << halvings), ..options.clone() };
        let ldi = Arc::new(ldi_of_photos(&reference, &images, &options, task)?);
        self.combined.push((key, ldi.clone()));
        limit(&mut self.combined, self.memory / 2);
        Ok(ldi)
    }
}

impl Kept {
    /// Returns the layered depth image of everything that all photos but some know, in the camera of a photo, reduced `halvings`
    /// times.
    ///
    /// # Errors
    /// Those of [`LdiSite::ldi_of_site`].
    pub fn site(
        &mut self,
        site: &mut LdiSite,
        preview: &mut Preview,
        view: ReducedPhotoView,
        options: &SiteLdiOptions,
        task: &Task,
    ) -> Result<Arc<Ldi>> {
        let ReducedPhotoView { photo, halvings, without } = view;
        let key = (photo, halvings);
        let kept = match self.of_site.iter().position(|(other, _)| *other == key) {
            Some(at) => self.of_site.remove(at),
            None => {
                let Photo { camera, pose, .. } = *site.site().photo(photo);
                let scale = options.scale / f64::from(1u32 << halvings);
                let options = SiteLdiOptions { scale, ..*options };
                let camera = SiteCamera { camera, pose, photo: Some(photo), without };
                (key, Arc::new(site.ldi_of_site(preview, camera, &options, task)?))
            }
        };
        let ldi = kept.1.clone();
        self.of_site.push(kept);
        limit(&mut self.of_site, self.memory / 2);
        Ok(ldi)
    }
}

/// A photo's view of what the other photos know.
#[derive(Clone, Copy)]
pub struct ReducedPhotoView<'a> {
    /// The photo whose camera it has.
    pub photo: PhotoId,
    /// How often the camera's resolution is halved.
    pub halvings: u32,
    /// The photos that are left out.
    pub without: &'a [PhotoId],
}

/// Drops the first entries until the others take no more than `memory` bytes; the last one stays.
fn limit<K>(kept: &mut Vec<(K, Arc<Ldi>)>, memory: u64) {
    let mut bytes: u64 = kept.iter().map(|(_, ldi)| ldi.bytes()).sum();
    let mut drop = 0;
    while bytes > memory && drop + 1 < kept.len() {
        bytes -= kept[drop].1.bytes();
        drop += 1;
    }
    kept.drain(..drop);
}
