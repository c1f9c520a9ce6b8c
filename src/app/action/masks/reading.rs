//! Reads the masks that views show.

use std::path::Path;

use crate::state::State;
use crate::state::request::{MaskRequest, Request};
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::PhotoId;
use quadratura_io::mask_store::MaskStore;
use quadratura_sites::open::UnusableMask;

impl State {
    fn masks_read(
        &mut self,
        folder: &Path,
        read: Vec<(String, Spans)>,
        message: Vec<UnusableMask>,
    ) -> Vec<Request> {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == folder) else {
            return Vec::new();
        };
        self.masking.cache.add(read, &session.history.present().masks);
        vec![MaskRequest::Report(message, "cannot be built").into()]
    }
}

/// Starts a job for the masks of a photo that are not loaded yet.
pub fn want_masks(state: &mut State, work: &mut Work, photo: PhotoId) {
    let Some(session) = &state.session else { return };
    let (folder, photo) = (session.folder.clone(), session.opened.site.photo(photo));
    let missing = state.masking.cache.missing(session.history.present().masks.of(&photo.name));
    let reads = state.masking.cache.reading.is_some_and(|job| state.running.is_running(job));
    if missing.is_empty() || reads {
        return;
    }
    let photo = photo.clone();
    let size = [photo.camera.width, photo.camera.height];
    let job = work.jobs.start(&mut state.running, JobKind::FlatView, "Reading masks", move |task| {
        let store = MaskStore::new(&folder);
        let (mut read, mut message) = (Vec::new(), Vec::new());
        for mask in missing {
            task.check_cancelled()?;
            let pixels = store.read(&mask.file, size).unwrap_or_else(|error| {
                let (photo, mask, problem) = (photo.clone(), mask.clone(), error.to_string());
                message.push(UnusableMask { photo, mask, problem });
                Spans::default()
            });
            read.push((mask.file, pixels));
        }
        Ok(Box::new(move |state| state.masks_read(&folder, read, message)))
    });
    state.masking.cache.reading = Some(job);
}
