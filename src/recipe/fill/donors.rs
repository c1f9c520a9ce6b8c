//! The photos' files as donors, as many at once as memory allows.

use std::sync::{Arc, Mutex};

use super::paint::SitePaint;
use crate::error::{Error, Result};
use crate::io::photo::read_shown;
use crate::layers::fill::{Donor, Donors, Surfaces};
use crate::projection::{PhotoId, Projector};
use crate::recipe::open::Opened;
use crate::task::Task;

/// Photos, decoded when they are asked for.
pub(super) struct PhotoDonors<'a> {
    opened: &'a Opened,
    surfaces: &'a Surfaces,
    paint: &'a SitePaint<'a>,
    memory: u64,
    task: &'a Task,
    /// The latest last; none for a photo that cannot be read.
    recent: Mutex<Vec<(PhotoId, Option<Arc<Donor>>)>>,
}

impl<'a> PhotoDonors<'a> {
    /// Those of a site with their paint; `memory`: bytes that decoded photos may take together. Who holds one
    /// keeps it.
    pub fn new(
        opened: &'a Opened,
        surfaces: &'a Surfaces,
        paint: &'a SitePaint<'a>,
        memory: u64,
        task: &'a Task,
    ) -> Self {
        Self { opened, surfaces, paint, memory, task, recent: Mutex::default() }
    }

    fn known(&self, photo: PhotoId) -> Option<Option<Arc<Donor>>> {
        let mut recent = self.recent.lock().expect("no holder of this lock panics");
        let place = recent.iter().position(|(other, _)| *other == photo)?;
        let entry = recent.remove(place);
        recent.push(entry.clone());
        Some(entry.1)
    }

    fn keep(&self, photo: PhotoId, donor: &Option<Arc<Donor>>) {
        let mut recent = self.recent.lock().expect("no holder of this lock panics");
        recent.retain(|(other, _)| *other != photo);
        recent.push((photo, donor.clone()));
        let bytes = |entry: &(PhotoId, Option<Arc<Donor>>)| entry.1.as_ref().map_or(0, |donor| donor.bytes());
        let mut all: u64 = recent.iter().map(bytes).sum();
        while all > self.memory && recent.len() > 1 {
            all -= bytes(&recent.remove(0));
        }
    }

    fn read(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        self.task.go_on()?;
        let site = &self.opened.site;
        let file = &site.photos[photo.0 as usize];
        let read = || Ok((read_shown(file)?, self.paint.of_photo(photo)?));
        let (pixels, painted) = match read() {
            Ok(read) => read,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                // Without its paint it would give what was painted over.
                self.task.of(&file.name).note(format!("the photo is not used for filling: {error}"));
                return Ok(None);
            }
        };
        let told = self.task.of(&file.name);
        self.paint.damaged(photo).iter().for_each(|damage| {
            told.note(format!(
                "paint that cannot be read is not used for filling: \
                {damage}"
            ))
        });
        let projector = Projector { name: file.name.clone(), camera: file.camera, pose: file.pose };
        let tolerance = self.opened.project.options.tolerance;
        let (model, surfaces) = (&site.model, self.surfaces);
        Ok(Some(Arc::new(Donor::new(&projector, &pixels, &painted, model, surfaces, tolerance))))
    }
}

impl Donors for PhotoDonors<'_> {
    /// No lock is held while a photo is read: that work is shared among threads, and one that waits for it
    /// may be given other work that asks here. So two may read the same photo once in a while.
    fn donor(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        if let Some(known) = self.known(photo) {
            return Ok(known);
        }
        let donor = self.read(photo)?;
        self.keep(photo, &donor);
        Ok(donor)
    }

    /// Of the largest photo; as many again may be held for what is made of them beside.
    fn at_once(&self) -> usize {
        let photos = self.opened.site.photos.iter();
        let largest = photos.map(|photo| Donor::bytes_of(&photo.camera)).max().unwrap_or(1).max(1);
        (self.memory / (2 * largest)).max(2) as usize
    }
}
