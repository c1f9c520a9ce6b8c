//! The relief of a project's faces: estimated once from its photos, then kept in `cache/`.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::budget::Budget;
use crate::error::{Error, Result};
use crate::io::photo::read_photo;
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
    /// [`Error::Io`] and [`Error::Input`] for photos that cannot be read, [`Error::Cancelled`]. A cache
    /// that cannot be written is a note.
    pub fn open(site: &Site, inputs: &str, folder: &Path, memory: u64, task: &Task) -> Result<Self> {
        let file = folder.join("cache/relief.bin");
        let options = ReliefOptions::default();
        let inputs = &format!("{inputs} {options:?}");
        let mut opened = Self { site: site.clone(), memory, whole: Arc::default(), witnesses: None };
        if let Some(relief) = read_relief(&file, inputs) {
            opened.whole = Arc::new(relief);
            return Ok(opened);
        }
        opened.ask(task)?;
        let witnesses = opened.witnesses.as_deref().expect("they were asked in the line above");
        let relief = estimate_relief(&site.model, witnesses, &options, task)?;
        if let Err(error) = write_relief(&file, &relief, inputs) {
            task.note(format!("the relief is not kept: {error}"));
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

    /// Makes the photos witnesses. A photo that cannot be read is one that shows nothing.
    fn ask(&mut self, task: &Task) -> Result<()> {
        if self.witnesses.is_some() {
            return Ok(());
        }
        let surface = Surface::of(&self.site.model);
        let budget = Budget::new(self.memory);
        let witness = |photo: &Photo| {
            task.go_on()?;
            let Photo { name, camera, pose, file } = photo;
            let projector = Projector { name: name.clone(), camera: *camera, pose: *pose };
            // What a decoder holds at once, and the luminance of it.
            let bytes = u64::from(camera.width) * u64::from(camera.height) * 12;
            budget.with(bytes, || {
                let pixels = read_photo(file, camera.width, camera.height)?;
                Ok::<_, Error>(Witness::new(&projector, &pixels, &surface))
            })
        };
        self.witnesses = Some(self.site.photos.par_iter().map(witness).collect::<Result<_>>()?);
        Ok(())
    }
}
