//! The relief of a project's faces, estimated once from its photos and then cached in `cache/`.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::inputs::hash_of_model;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::{FaceId, Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::Projector;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::{
    Relief, ReliefOptions, SweepView, estimate_faces, relief_without, seen_faces,
};
use quadratura_sites::budget::Budget;
use quadratura_sites::shared::Shared;

/// The file `cache/relief.bin`.
const CACHED: CachedKind = CachedKind { name: "relief", version: 3 };

/// The relief as it is kept: it can be told which faces a change of some photos concerns.
#[derive(Debug, Default, Serialize, Deserialize)]
struct KeptRelief {
    /// Of each photo, in the site's order, the hash of what it tells the relief.
    photos: Vec<String>,
    /// The faces that each photo shows, with the number of blocks.
    faces: Vec<Vec<(FaceId, u32)>>,
    relief: Relief,
}

/// The relief of a site, and of the site without some of the photos.
pub struct SiteRelief {
    site: Site,
    memory: u64,
    whole: Arc<Relief>,
    /// The photos prepared for the plane sweep, once they were needed.
    sweep_views: Option<Vec<SweepView>>,
}

impl SiteRelief {
    /// Returns the relief kept in the project's folder, of which the faces are estimated anew that a photo shows whose hash in
    /// `photos` is another one than then; without one, all are. `photos` are in the site's order, `memory` is the budget in bytes
    /// for photos decoded at the same time.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] when the task was cancelled. A photo that cannot be read is noted and not used;
    /// a cache that cannot be written is noted.
    pub fn open(site: &Site, photos: Vec<String>, folder: &Path, memory: u64, task: &Task) -> Result<Self> {
        let file = folder.join("cache/relief.bin");
        let options = ReliefOptions::default();
        let basis = &format!("{} {}", hash_of_model(&site.model), options.fingerprint());
        let mut opened = Self { site: site.clone(), memory, whole: Arc::default(), sweep_views: None };
        let kept = || read_cached::<KeptRelief>(&file, CACHED, basis);
        let _lock = match Shared::find(folder, || kept().filter(|kept| kept.photos == photos), task)? {
            Shared::Known(kept) => {
                opened.whole = Arc::new(kept.relief);
                return Ok(opened);
            }
            Shared::Missing(lock) => lock,
        };
        let (relief, is_whole) = opened.renewed(kept().unwrap_or_default(), photos, &options, task)?;
        // A relief made without some photo must not be kept as that of all photos.
        if is_whole && let Err(error) = write_cached(&file, CACHED, basis, &relief) {
            task.note(Message::from("the relief cannot be cached: ").and(&error));
        }
        opened.whole = Arc::new(relief.relief);
        Ok(opened)
    }

    /// Brings a relief that was kept up to date, and returns whether all photos could be read that this took.
    fn renewed(
        &self,
        mut kept: KeptRelief,
        photos: Vec<String>,
        options: &ReliefOptions,
        task: &Task,
    ) -> Result<(KeptRelief, bool)> {
        let model = &self.site.model;
        let mut again = vec![kept.photos.is_empty(); model.faces.len()];
        let mut concern = |faces: &[(FaceId, u32)]| {
            faces.iter().for_each(|(face, _)| again[face.0 as usize] = true);
        };
        let mut known: FxHashMap<String, Vec<(FaceId, u32)>> =
            kept.photos.drain(..).zip(kept.faces.drain(..)).collect();
        let found: Vec<Option<Vec<(FaceId, u32)>>> = photos.iter().map(|photo| known.remove(photo)).collect();
        // What is left was told by photos that are no longer as they were.
        known.values().for_each(|faces| concern(faces));
        let mut needed: Vec<bool> = found.iter().map(Option::is_none).collect();
        let mut views = self.prepared(|photo| needed[photo.index()], task)?;
        let faces = found.into_iter().zip(&views).map(|(known, view)| {
            known.unwrap_or_else(|| {
                let faces = seen_faces(model, view);
                concern(&faces);
                faces
            })
        });
        let mut faces: Vec<Vec<(FaceId, u32)>> = faces.collect();
        let is_concerned = |faces: &[(FaceId, u32)]| faces.iter().any(|(face, _)| again[face.0 as usize]);
        let more: Vec<bool> =
            faces.iter().zip(&needed).map(|(faces, known)| !known && is_concerned(faces)).collect();
        for (id, view) in self.site.photo_ids().zip(self.prepared(|photo| more[photo.index()], task)?) {
            if more[id.index()] {
                (views[id.index()], needed[id.index()]) = (view, true);
            }
        }
        let unread: Vec<bool> =
            views.iter().zip(needed).map(|(view, needed)| needed && !view.has_pixels()).collect();
        faces.iter_mut().zip(&unread).filter(|(_, unread)| **unread).for_each(|(faces, _)| faces.clear());
        let is_whole = !unread.contains(&true);
        let relief = estimate_faces(&kept.relief, &again, model, &views, &faces, options, task)?;
        Ok((KeptRelief { photos, faces, relief }, is_whole))
    }

    /// Returns the relief from all photos.
    pub fn whole(&self) -> &Arc<Relief> {
        &self.whole
    }

    /// Returns the relief that is estimated without these photos.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`].
    pub fn without(&mut self, photos: &[PhotoId], task: &Task) -> Result<Arc<Relief>> {
        if photos.is_empty() {
            return Ok(self.whole.clone());
        }
        let views = match self.sweep_views.take() {
            Some(views) => views,
            None => self.prepared(|_| true, task)?,
        };
        let views = self.sweep_views.insert(views);
        let options = ReliefOptions::default();
        relief_without(&self.whole, photos, &self.site.model, views, &options, task).map(Arc::new)
    }

    /// Prepares those photos for the plane sweep that are wanted; the others have no pixels.
    fn prepared(&self, is_wanted: impl Fn(PhotoId) -> bool + Sync, task: &Task) -> Result<Vec<SweepView>> {
        let surface = ModelSurface::from_model(&self.site.model);
        let budget = Budget::new(self.memory);
        let sweep_view = |id: PhotoId| {
            task.check_cancelled()?;
            let photo = self.site.photo(id);
            let Photo { name, camera, pose, .. } = photo;
            let projector = Projector { name: name.clone(), camera: *camera, pose: *pose };
            if !is_wanted(id) {
                return Ok(SweepView::blind(&projector));
            }
            // Memory of a decoder and of the luminance image.
            let bytes = u64::from(camera.width) * u64::from(camera.height) * 12;
            budget.with(bytes, || match read_unmasked(photo) {
                Ok(pixels) => Ok(SweepView::new(&projector, &pixels, &surface)),
                Err(Error::Cancelled) => Err(Error::Cancelled),
                Err(error) => {
                    let task = task.with_subject(name);
                    task.note("the photo is not used for the relief, because it cannot be read");
                    // Whatever builds the photo's stack fails with the reason.
                    task.detail(error.to_string());
                    Ok(SweepView::blind(&projector))
                }
            })
        };
        self.site.photo_ids().collect::<Vec<_>>().into_par_iter().map(sweep_view).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_base::task::Event;

    #[test]
    fn a_photo_that_cannot_be_read_is_told_and_the_relief_made_without_it_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut site = closed_form::two_quads().site();
        site.photos[0].file = folder.path().join("gone.png");
        let notes: Arc<Mutex<Vec<String>>> = Arc::default();
        let sink = notes.clone();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                sink.lock().unwrap().push(text.to_string());
            }
        });
        let relief =
            SiteRelief::open(&site, vec!["a".into(), "b".into()], folder.path(), 1 << 30, &task).unwrap();
        assert!(relief.whole().of_face.iter().all(Option::is_none));
        assert!(notes.lock().unwrap().iter().any(|note| note.contains("is not used for the relief")));
        assert!(!folder.path().join("cache/relief.bin").exists());
    }
}
