//! A cache of the pixels of masks. Files of masks never change, so that the pixels of a file stay valid.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::ask::{Ask, MaskAsk};
use crate::app::state::running::{JobId, JobKind};
use crate::app::work::Work;
use crate::document::Masks;
use crate::document::masks::Mask;
use crate::geometry::Spans;
use crate::io::mask_store::MaskStore;
use crate::recipe::open::UnusableMask;

/// The number of cached files beyond which files of no current mask are dropped: a few hundred kilobytes each.
const MOST: usize = 200;

/// The cache of mask pixels.
#[derive(Default)]
pub struct Known {
    by_file: BTreeMap<String, Arc<Spans>>,
    reading: Option<JobId>,
    covered: Option<Covered>,
    /// A number that changes with the cache and with the queue of edits.
    pub revision: u64,
}

/// All masked pixels of a photo.
struct Covered {
    photo: String,
    files: Vec<String>,
    revision: u64,
    pixels: Arc<Spans>,
}

impl Known {
    /// Adds pixels that were read. A mask that could not be read counts as empty: its error is reported once.
    pub fn add(&mut self, read: impl IntoIterator<Item = (String, Spans)>, masks: &Masks) {
        self.by_file.extend(read.into_iter().map(|(file, pixels)| (file, Arc::new(pixels))));
        if self.by_file.len() > MOST {
            let named = masks.files();
            self.by_file.retain(|file, _| named.contains(file.as_str()));
        }
        self.revision += 1;
    }

    fn missing(&self, masks: &[Mask]) -> Vec<Mask> {
        masks.iter().filter(|mask| !self.by_file.contains_key(&mask.file)).cloned().collect()
    }
}

impl State {
    /// Returns the masked pixels of a photo as far as they are loaded, with the edits in the queue applied.
    pub fn covered(&mut self, photo: usize) -> Option<Arc<Spans>> {
        let session = self.session.as_ref()?;
        let photo = &session.opened.site.photos.get(photo)?.name;
        let masks = session.history.present().masks.of(photo);
        let masking = &mut self.masking;
        let known = &mut masking.known;
        let files: Vec<String> = masks.iter().map(|mask| mask.file.clone()).collect();
        let same = |c: &&Covered| c.photo == *photo && c.files == files && c.revision == known.revision;
        if let Some(covered) = known.covered.as_ref().filter(same) {
            return Some(covered.pixels.clone());
        }
        let of_files = files.iter().filter_map(|file| known.by_file.get(file));
        let of_files = of_files.fold(Spans::default(), |all, pixels| all.union(pixels));
        let pixels = Arc::new(masking.keeping.applied_to(of_files, photo));
        let covered =
            Covered { photo: photo.clone(), files, revision: known.revision, pixels: pixels.clone() };
        known.covered = Some(covered);
        Some(pixels)
    }

    fn masks_read(
        &mut self,
        folder: &std::path::Path,
        read: Vec<(String, Spans)>,
        message: Vec<UnusableMask>,
    ) -> Vec<Ask> {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == folder) else {
            return Vec::new();
        };
        self.masking.known.add(read, &session.history.present().masks);
        vec![MaskAsk::Report(message, "cannot be built").into()]
    }
}

/// Starts a job for the masks of a photo that are not loaded yet.
pub fn want_masks(state: &mut State, work: &mut Work, photo: usize) {
    let Some(session) = &state.session else { return };
    let (folder, photo) = (session.folder.clone(), &session.opened.site.photos[photo]);
    let missing = state.masking.known.missing(session.history.present().masks.of(&photo.name));
    let reads = state.masking.known.reading.is_some_and(|job| state.running.is_running(job));
    if missing.is_empty() || reads {
        return;
    }
    let photo = photo.clone();
    let size = [photo.camera.width, photo.camera.height];
    let job = work.jobs.start(&mut state.running, JobKind::FlatView, "Reading masks", move |task| {
        let store = MaskStore::new(&folder);
        let (mut read, mut message) = (Vec::new(), Vec::new());
        for mask in missing {
            task.go_on()?;
            let pixels = store.read(&mask.file, size).unwrap_or_else(|error| {
                let (photo, mask, problem) = (photo.clone(), mask.clone(), error.to_string());
                message.push(UnusableMask { photo, mask, problem });
                Spans::default()
            });
            read.push((mask.file, pixels));
        }
        Ok(Box::new(move |state| state.masks_read(&folder, read, message)))
    });
    state.masking.known.reading = Some(job);
}
