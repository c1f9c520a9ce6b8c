//! The relief of a project's faces: estimated once from its photos, then kept in `cache/`.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::budget::Budget;
use crate::error::{Error, Result};
use crate::io::photo::read_shown;
use crate::io::relief_file::{read_relief, write_relief};
use crate::projection::relief::{Relief, ReliefOptions, Witness, estimate_relief, relief_without};
use crate::projection::surface::Surface;
use crate::projection::{PhotoId, Projector};
use crate::scene::{Photo, Site};
use crate::task::Task;

/// A site's relief, and how it would be without some of the photos.
pub struct SiteRelief {
    site: Site,
    memory: u64,
    whole: Arc<Relief>,
    /// The photos as witnesses, once they were asked.
    witnesses: Option<Vec<Witness>>,
}

impl SiteRelief {
    /// That in `cache/` of the project's folder if it was made of the same `inputs`, else a new one, which
    /// is put there. `memory`: bytes that photos decoded at the same time may take.
    ///
    /// # Errors
    /// [`Error::Cancelled`]. A photo that cannot be read is a note and tells nothing; a cache that cannot
    /// be written is a note.
    pub fn open(site: &Site, inputs: &str, folder: &Path, memory: u64, task: &Task) -> Result<Self> {
        let file = folder.join("cache/relief.bin");
        let options = ReliefOptions::default();
        let inputs = &format!("{inputs} {}", options.fingerprint());
        let mut opened = Self { site: site.clone(), memory, whole: Arc::default(), witnesses: None };
        if let Some(relief) = read_relief(&file, inputs) {
            opened.whole = Arc::new(relief);
            return Ok(opened);
        }
        opened.ask(task)?;
        let witnesses = opened.witnesses.as_deref().expect("they were asked in the line above");
        let relief = estimate_relief(&site.model, witnesses, &options, task)?;
        // What was made without a photo must not stand for all of them once that can be read again.
        if witnesses.iter().all(Witness::sees)
            && let Err(error) = write_relief(&file, &relief, inputs)
        {
            task.note(format!("the relief cannot be cached: {error}"));
        }
        opened.whole = Arc::new(relief);
        Ok(opened)
    }

    /// Of all photos.
    pub fn whole(&self) -> &Arc<Relief> {
        &self.whole
    }

    /// As if these photos had not been there.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn without(&mut self, photos: &[PhotoId], task: &Task) -> Result<Arc<Relief>> {
        if photos.is_empty() {
            return Ok(self.whole.clone());
        }
        self.ask(task)?;
        let witnesses = self.witnesses.as_deref().expect("they were asked in the line above");
        let options = ReliefOptions::default();
        relief_without(&self.whole, photos, &self.site.model, witnesses, &options, task).map(Arc::new)
    }

    /// Makes the photos witnesses.
    fn ask(&mut self, task: &Task) -> Result<()> {
        if self.witnesses.is_some() {
            return Ok(());
        }
        let surface = Surface::of(&self.site.model);
        let budget = Budget::new(self.memory);
        let witness = |photo: &Photo| {
            task.go_on()?;
            let Photo { name, camera, pose, .. } = photo;
            let projector = Projector { name: name.clone(), camera: *camera, pose: *pose };
            // What a decoder holds at once, and the luminance of it.
            let bytes = u64::from(camera.width) * u64::from(camera.height) * 12;
            budget.with(bytes, || match read_shown(photo) {
                Ok(pixels) => Ok(Witness::new(&projector, &pixels, &surface)),
                Err(Error::Cancelled) => Err(Error::Cancelled),
                Err(error) => {
                    task.of(name).note(format!("the photo is not used for the relief: {error}"));
                    Ok(Witness::blind(&projector))
                }
            })
        };
        self.witnesses = Some(self.site.photos.par_iter().map(witness).collect::<Result<_>>()?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::scene::synthetic::closed_form;
    use crate::task::Event;

    #[test]
    fn a_photo_that_cannot_be_read_is_told_and_the_relief_made_without_it_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut site = closed_form::two_quads().site();
        site.photos[0].file = folder.path().join("gone.png");
        let notes: Arc<Mutex<Vec<String>>> = Arc::default();
        let told = notes.clone();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                told.lock().unwrap().push(text);
            }
        });
        let relief = SiteRelief::open(&site, "inputs", folder.path(), 1 << 30, &task).unwrap();
        assert!(relief.whole().of_face.iter().all(Option::is_none));
        assert!(notes.lock().unwrap().iter().any(|note| note.contains("is not used for the relief")));
        assert!(!folder.path().join("cache/relief.bin").exists());
    }
}
