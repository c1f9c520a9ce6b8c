//! Which photos a view needs, and the layered depth images that are made of them: the *controller* of the published system
//! (Gortler, He & Cohen 1997, section 2), with shares of the view instead of angles and distances.

use std::sync::Arc;

use super::StackLdiOptions;
use super::of_photos::{PhotosOptions, Reference, ldi_of_photos};
use super::site::LdiSite;
use crate::error::{Error, Result};
use crate::ldi::Ldi;
use crate::projection::exposure::Shares;
use crate::scene::PhotoId;
use crate::task::Task;

/// The least share of a view from which on a photo is used for it.
const LEAST_SHARE: f64 = 1e-4;

/// Returns the photos with the largest shares of a view, `most` at most, the largest first; of equal ones the first of the
/// site.
pub fn best_photos(shares: &Shares, most: usize) -> Vec<PhotoId> {
    let mut photos: Vec<(f64, PhotoId)> =
        shares.of_photo.iter().copied().zip(PhotoId::all(shares.of_photo.len())).collect();
    photos.retain(|(share, _)| *share > LEAST_SHARE);
    photos.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    photos.into_iter().take(most).map(|(_, photo)| photo).collect()
}

/// The layered depth image of a photo's stack.
pub type OfPhoto = (Arc<Ldi>, PhotoId);

/// What a layered depth image that is kept was made of: photos, the reference first, and the power of two by which its camera
/// was reduced.
type Key = (Vec<PhotoId>, u32);

/// The layered depth images that were made, as long as memory lasts: those that were used last.
pub struct Kept {
    memory: u64,
    /// Of single photos' stacks.
    stacks: Vec<(PhotoId, Arc<Ldi>)>,
    /// Of several photos, the last used one last.
    combined: Vec<(Key, Arc<Ldi>)>,
}

impl Kept {
    /// Keeps nothing yet; at most `memory` bytes, but always the one in use.
    pub fn new(memory: u64) -> Self {
        Self { memory, stacks: Vec::new(), combined: Vec::new() }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.stacks.clear();
        self.combined.clear();
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
        (photos, halvings): (&[PhotoId], u32),
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
        let reference = Reference { camera: own.camera, pose: own.pose, photo: Some(first), gain: own.gain };
        let options = PhotosOptions { scale: options.scale / f64::from(1u32 << halvings), ..options.clone() };
        let ldi = Arc::new(ldi_of_photos(&reference, &images, &options, task)?);
        self.combined.push((key, ldi.clone()));
        limit(&mut self.combined, self.memory / 2);
        Ok(ldi)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_photos_with_the_largest_shares_come_first_and_those_without_are_left_out() {
        let shares = Shares {
            of_photo: vec![0.1, 0.0, 0.3, 0.3, 0.00005, 0.2],
            of_common: 0.0,
            takes_part: vec![true; 6],
        };
        let best = |most: usize| best_photos(&shares, most).iter().map(|photo| photo.0).collect::<Vec<_>>();
        assert_eq!(best(3), [2, 3, 5]);
        assert_eq!(best(9), [2, 3, 5, 0]);
    }
}
