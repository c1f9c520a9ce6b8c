//! The photos' pixels as donors of the filling, decoded on demand within a memory budget.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

use super::paint::{SeenBy, SitePaint};
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::{FaceId, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_io::unmasked::read_unmasked;
use quadratura_layers::agreement::PhotoEvidence;
use quadratura_layers::fill::{Donor, DonorContent, Donors, FillSurfaces};
use quadratura_projection::Projector;
use quadratura_view::agreement::PhotoAgreement;

/// What a filling's memory is divided by for decoded photos, for decoded surroundings, and for rectified surfaces, which take longest to
/// make. The rest is for what is known of the whole site.
const PHOTOS_SHARE: u64 = 4;
pub(super) const SURROUNDINGS_SHARE: u64 = 8;
pub(super) const PLATES_SHARE: u64 = 2;

/// A cache of decoded photos.
pub(super) struct PhotoDonors<'a> {
    project: &'a Project,
    site: &'a Site,
    surfaces: &'a FillSurfaces,
    paint: &'a SitePaint<'a>,
    memory: u64,
    task: &'a Task,
    /// How far other photos confirm each photo, in the site's order; empty where nobody was asked.
    agreement: Vec<PhotoAgreement>,
    /// The photos that were used last, the most recent one at the end; `None` for a photo that cannot be read.
    recent: Mutex<Vec<(SeenPhoto, Option<Arc<Donor>>)>>,
}

/// A photo as it is seen by itself or by others, which differ where some of its paint stays in it.
#[derive(Clone, Copy, PartialEq, Eq)]
struct SeenPhoto {
    photo: PhotoId,
    seen_by: SeenBy,
}

/// Returns the faces that a photo gives although other photos contradict what it shows of them: those that are pinned to it.
pub(super) fn given_by_pin(
    project: &Project,
    site: &Site,
    photo: PhotoId,
    agreement: &PhotoAgreement,
) -> BTreeSet<FaceId> {
    let names = || site.photos.iter().map(|photo| photo.name.as_str());
    let is_pinned = |face: &FaceId| {
        let face = site.model.face(*face);
        let object = &site.model.object(face.object).name;
        project.decisions.pinned(names(), object, face.index) == Some(&site.photo(photo).name)
    };
    let faces: BTreeSet<FaceId> = agreement.contradicted.iter().map(|pixel| pixel.face).collect();
    faces.into_iter().filter(is_pinned).collect()
}

impl<'a> PhotoDonors<'a> {
    /// Makes an empty cache for a site with its paint. `memory` is the filling's budget in bytes, of which decoded
    /// photos take their share; donors in use remain in memory.
    pub fn new(
        project: &'a Project,
        site: &'a Site,
        surfaces: &'a FillSurfaces,
        paint: &'a SitePaint<'a>,
        memory: u64,
        task: &'a Task,
    ) -> Self {
        Self { project, site, surfaces, paint, memory, task, agreement: Vec::new(), recent: Mutex::default() }
    }

    /// Leaves out what other photos contradict, but on faces that are pinned to a photo; `evidence` is in the site's order.
    pub fn without_contradicted(self, evidence: &[PhotoEvidence]) -> Self {
        let of_photo = |(photo, evidence): (PhotoId, &PhotoEvidence)| {
            let mut agreement = evidence.agreement.clone();
            let given = given_by_pin(self.project, self.site, photo, &agreement);
            agreement.contradicted.retain(|pixel| !given.contains(&pixel.face));
            agreement
        };
        let agreement = self.site.photo_ids().zip(evidence).map(of_photo).collect();
        Self { agreement, recent: Mutex::default(), ..self }
    }

    /// Returns a cached donor and marks it as used.
    fn known(&self, photo: SeenPhoto) -> Option<Option<Arc<Donor>>> {
        let mut recent = self.recent.lock().expect("no holder of this lock panics");
        let index = recent.iter().position(|(other, _)| *other == photo)?;
        let entry = recent.remove(index);
        recent.push(entry.clone());
        Some(entry.1)
    }

    /// Adds a donor to the cache and drops the least recently used ones beyond the budget.
    fn keep(&self, photo: SeenPhoto, donor: &Option<Arc<Donor>>) {
        let mut recent = self.recent.lock().expect("no holder of this lock panics");
        recent.retain(|(other, _)| *other != photo);
        recent.push((photo, donor.clone()));
        let bytes =
            |entry: &(SeenPhoto, Option<Arc<Donor>>)| entry.1.as_ref().map_or(0, |donor| donor.bytes());
        let mut all: u64 = recent.iter().map(bytes).sum();
        while all > self.memory / PHOTOS_SHARE && recent.len() > 1 {
            all -= bytes(&recent.remove(0));
        }
    }

    /// Decodes a photo and its paint; `None` where that fails.
    fn read(&self, photo: SeenPhoto) -> Result<Option<Arc<Donor>>> {
        let SeenPhoto { photo, seen_by } = photo;
        self.task.check_cancelled()?;
        let site = self.site;
        let file = site.photo(photo);
        let read = || Ok((read_unmasked(file)?, self.paint.of_photo(photo, seen_by)?));
        let (pixels, painted) = match read() {
            Ok(read) => read,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                // Without its paint the photo would give what was painted over.
                self.task
                    .with_subject(&file.name)
                    .note(Message::from("the photo is not used for filling: ").and(&error));
                return Ok(None);
            }
        };
        let task_of_photo = self.task.with_subject(&file.name);
        self.paint.damaged(photo).iter().for_each(|damage| {
            task_of_photo.note(format!(
                "paint that cannot be read is not used for \
                filling: {damage}"
            ))
        });
        let projector = Projector { name: file.name.clone(), camera: file.camera, pose: file.pose };
        let tolerance = self.project.options.tolerance;
        let (model, surfaces) = (&site.model, self.surfaces);
        let agreement = self.agreement.get(photo.index());
        let content = DonorContent { pixels: &pixels, painted: &painted, agreement };
        Ok(Some(Arc::new(Donor::new(&projector, &content, model, surfaces, tolerance))))
    }

    /// Returns a photo, prepared if it is not in the cache. No lock is held while it is read: that work is divided
    /// among threads, and a thread that waits for it may be given other work that calls this function. So
    /// occasionally two threads read the same photo.
    fn prepared(&self, photo: SeenPhoto) -> Result<Option<Arc<Donor>>> {
        if let Some(known) = self.known(photo) {
            return Ok(known);
        }
        let donor = self.read(photo)?;
        self.keep(photo, &donor);
        Ok(donor)
    }
}

impl Donors for PhotoDonors<'_> {
    fn donor(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        self.prepared(SeenPhoto { photo, seen_by: SeenBy::Others })
    }

    fn own(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        let seen_by = if self.paint.keeps_some(photo) { SeenBy::Itself } else { SeenBy::Others };
        self.prepared(SeenPhoto { photo, seen_by })
    }

    /// Returns the number of donors that fit into half the budget at the size of the largest photo: those in use may take more than
    /// those that are kept.
    fn at_once(&self) -> usize {
        donors_at_once(self.site, self.memory)
    }
}

/// Returns the number of donors of a site that are used at the same time within a budget of `memory` bytes.
pub(super) fn donors_at_once(site: &Site, memory: u64) -> usize {
    let photos = site.photos.iter();
    let largest = photos.map(|photo| Donor::bytes_of(&photo.camera)).max().unwrap_or(1).max(1);
    (memory / (2 * largest)).max(2) as usize
}
