//! The relief of a project's faces, estimated once from its photos and then cached in `cache/`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::inputs::hash_of_model;
use crate::shelf::{Shelf, Shelved};
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{FaceId, Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::Projector;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::{
    Relief, ReliefOptions, SweepView, SweepViews, estimate_faces, relief_without, seen_faces,
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
    /// The project's folder.
    folder: PathBuf,
    memory: u64,
    whole: Arc<Relief>,
    /// The photos prepared for the plane sweep, once they were needed.
    sweep_views: Option<PreparedViews>,
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
        let (site, folder_of) = (site.clone(), folder.to_owned());
        let mut opened = Self { site, folder: folder_of, memory, whole: Arc::default(), sweep_views: None };
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
        let mut views = self.no_views();
        let needed: Vec<bool> = found.iter().map(Option::is_none).collect();
        self.prepare(&mut views, &needed, task)?;
        let faces = found.into_iter().zip(&mut views.faces).map(|(known, prepared)| {
            known.unwrap_or_else(|| {
                concern(prepared);
                prepared.clone()
            })
        });
        let mut faces: Vec<Vec<(FaceId, u32)>> = faces.collect();
        let is_concerned = |faces: &[(FaceId, u32)]| faces.iter().any(|(face, _)| again[face.0 as usize]);
        let more: Vec<bool> =
            faces.iter().zip(&needed).map(|(faces, known)| !known && is_concerned(faces)).collect();
        self.prepare(&mut views, &more, task)?;
        let unread = needed.iter().zip(&more).zip(&views.has_pixels);
        let unread: Vec<bool> = unread.map(|((needed, more), has)| (*needed || *more) && !has).collect();
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
            None => {
                let mut views = self.no_views();
                self.prepare(&mut views, &vec![true; self.site.photos.len()], task)?;
                views
            }
        };
        let views = self.sweep_views.insert(views);
        let (model, options) = (&self.site.model, ReliefOptions::default());
        relief_without(&self.whole, photos, model, views, &views.faces, &options, task).map(Arc::new)
    }

    /// Returns the photos before any is prepared.
    fn no_views(&self) -> PreparedViews {
        let count = self.site.photos.len();
        PreparedViews {
            shelf: Shelf::new(count, self.memory / 2, &self.folder.join("cache")),
            cameras: self.site.photos.iter().map(|photo| (photo.camera, photo.pose)).collect(),
            has_pixels: vec![false; count],
            faces: vec![Vec::new(); count],
        }
    }

    /// Prepares those photos for the plane sweep that are wanted.
    fn prepare(&self, views: &mut PreparedViews, is_wanted: &[bool], task: &Task) -> Result<()> {
        let surface = ModelSurface::from_model(&self.site.model);
        let budget = Budget::new(self.memory);
        let shelf = &views.shelf;
        let faces_of = |id: &PhotoId| {
            task.check_cancelled()?;
            let photo = self.site.photo(*id);
            let Photo { name, camera, pose, .. } = photo;
            let projector = Projector { name: name.clone(), camera: *camera, pose: *pose };
            // Memory of a decoder and of the luminance image.
            let bytes = u64::from(camera.width) * u64::from(camera.height) * 12;
            let read = || Ok(SweepView::new(&projector, &read_unmasked(photo)?, &surface));
            match budget.with(bytes, read) {
                Ok(view) => {
                    let faces = seen_faces(&self.site.model, &view);
                    shelf.put(id.index(), view)?;
                    Ok(Some(faces))
                }
                Err(Error::Cancelled) => Err(Error::Cancelled),
                Err(error) => {
                    let task = task.with_subject(name);
                    task.note("the photo is not used for the relief, because it cannot be read");
                    // Whatever builds the photo's stack fails with the reason.
                    task.detail(error.to_string());
                    Ok(None)
                }
            }
        };
        let wanted: Vec<PhotoId> = self.site.photo_ids().filter(|id| is_wanted[id.index()]).collect();
        let found: Vec<Option<Vec<(FaceId, u32)>>> =
            wanted.par_iter().map(faces_of).collect::<Result<_>>()?;
        for (id, faces) in wanted.into_iter().zip(found) {
            if let Some(faces) = faces {
                (views.has_pixels[id.index()], views.faces[id.index()]) = (true, faces);
            }
        }
        Ok(())
    }
}

/// Photos prepared for the plane sweep, in the site's order.
struct PreparedViews {
    shelf: Shelf<SweepView>,
    cameras: Vec<(Pinhole, Pose)>,
    /// Whether they are prepared: they were wanted, and can be read.
    has_pixels: Vec<bool>,
    /// The faces that they show, with the number of blocks.
    faces: Vec<Vec<(FaceId, u32)>>,
}

impl Shelved for SweepView {
    fn bytes(&self) -> u64 {
        self.bytes()
    }
}

impl SweepViews for PreparedViews {
    fn camera(&self, number: usize) -> (&Pinhole, &Pose) {
        let (camera, pose) = &self.cameras[number];
        (camera, pose)
    }

    fn view(&self, number: usize) -> Result<Arc<SweepView>> {
        Ok(self.shelf.get(number)?.expect("a photo that shows faces was prepared"))
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
