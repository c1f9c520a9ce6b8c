//! The relief of a project's faces, estimated once from its photos and then cached in `cache/`.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::budget::Budget;
use super::shared::Shared;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::Projector;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::{Relief, ReliefOptions, SweepView, estimate_relief, relief_without};

/// The file `cache/relief.bin`.
const CACHED: CachedKind = CachedKind { name: "relief", version: 2 };

/// The relief of a site, and of the site without some of the photos.
pub struct SiteRelief {
    site: Site,
    memory: u64,
    whole: Arc<Relief>,
    /// The photos prepared for the plane sweep, once they were needed.
    sweep_views: Option<Vec<SweepView>>,
}

impl SiteRelief {
    /// Returns the relief cached in the project's folder if it was made from the same `inputs`; otherwise estimates
    /// and caches it. `memory` is the budget in bytes for photos decoded at the same time.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] when the task was cancelled. A photo that cannot be read is noted and not used;
    /// a cache that cannot be written is noted.
    pub fn open(site: &Site, inputs: &str, folder: &Path, memory: u64, task: &Task) -> Result<Self> {
        let file = folder.join("cache/relief.bin");
        let options = ReliefOptions::default();
        let inputs = &format!("{inputs} {}", options.fingerprint());
        let mut opened = Self { site: site.clone(), memory, whole: Arc::default(), sweep_views: None };
        let _lock = match Shared::find(folder, || read_cached(&file, CACHED, inputs), task)? {
            Shared::Known(relief) => {
                opened.whole = Arc::new(relief);
                return Ok(opened);
            }
            Shared::Missing(lock) => lock,
        };
        opened.prepare_photos(task)?;
        let sweep_views = opened.sweep_views.as_deref().expect("the line above prepared them");
        let relief = estimate_relief(&site.model, sweep_views, &options, task)?;
        // A relief made without some photo must not be cached as that of all photos.
        if sweep_views.iter().all(SweepView::has_pixels)
            && let Err(error) = write_cached(&file, CACHED, inputs, &relief)
        {
            task.note(Message::from("the relief cannot be cached: ").and(&error));
        }
        opened.whole = Arc::new(relief);
        // Prepared photos are large; few pictures need them again.
        opened.sweep_views = None;
        Ok(opened)
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
        self.prepare_photos(task)?;
        let sweep_views = self.sweep_views.as_deref().expect("the line above prepared them");
        let options = ReliefOptions::default();
        relief_without(&self.whole, photos, &self.site.model, sweep_views, &options, task).map(Arc::new)
    }

    /// Prepares all photos for the plane sweep, unless that was done before.
    fn prepare_photos(&mut self, task: &Task) -> Result<()> {
        if self.sweep_views.is_some() {
            return Ok(());
        }
        let surface = ModelSurface::from_model(&self.site.model);
        let budget = Budget::new(self.memory);
        let sweep_view = |photo: &Photo| {
            task.check_cancelled()?;
            let Photo { name, camera, pose, .. } = photo;
            let projector = Projector { name: name.clone(), camera: *camera, pose: *pose };
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
        self.sweep_views = Some(self.site.photos.par_iter().map(sweep_view).collect::<Result<_>>()?);
        Ok(())
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
        let relief = SiteRelief::open(&site, "inputs", folder.path(), 1 << 30, &task).unwrap();
        assert!(relief.whole().of_face.iter().all(Option::is_none));
        assert!(notes.lock().unwrap().iter().any(|note| note.contains("is not used for the relief")));
        assert!(!folder.path().join("cache/relief.bin").exists());
    }
}
