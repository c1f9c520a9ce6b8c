//! Keeps everything up to date in the background: photos whose stacks exist and are out of date are built and filled.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::action::masks::repairing::damaged_masks;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::counted;
use crate::state::progress::Progress;
use crate::state::request::{MaskRequest, Request};
use crate::state::running::{Job, JobId, JobKind};
use crate::state::session::{PhotoStatus, Session, stacks_of, survey};
use crate::work::Work;
use crate::work::jobs::{Arrival, arrival};
use crate::work::live_project::LiveProject;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Rasteriser;
use quadratura_sites::open::Opened;
use quadratura_stacks::fill::projected::nearest_first;
use quadratura_stacks::turns::UpdateSource;
use quadratura_stacks::update::{UpdateEnd, UpdateRequest, UpdatedPhoto, update};

/// Publishes the project for updates, and starts or stops the update in the background.
pub fn keep_up_to_date(state: &mut State, work: &mut Work) {
    let settled = |session: &&Session| !session.is_behind();
    let is_other = work.live.publish(state.session.as_ref().filter(settled));
    work.live.give_way(state.updates_wait());
    if is_other {
        state.updating.want();
    }
    if state.running.runs(JobKind::Update) && state.stops_updating() {
        work.jobs.stop_kind(&mut state.running, JobKind::Update);
        state.updating.want();
    }
    if let Some(share) = state.running.progress(JobKind::Update).and_then(Progress::share) {
        state.updating.reached = share;
    }
    list_built(state, work);
    if state.updates_now() {
        start(state, work);
    } else if state.can_show_updates() && state.updating.shows(work.live.turns(), state.window.now_s) {
        show_finished(state, work);
    }
}

/// Stops a job. An update in the background would begin again, so it is switched off.
pub fn stop_job(state: &mut State, work: &mut Work, job: JobId) {
    let is_update = |(id, running): (JobId, &Job)| id == job && running.kind == JobKind::Update;
    if state.running.all().any(is_update) {
        state.settings.keep_up_to_date = false;
    }
    work.jobs.stop(&mut state.running, job);
}

fn start(state: &mut State, work: &mut Work) {
    let view = &state.space.viewpoint;
    let photos = |session: &Session| nearest_first(&session.opened.site, view.position(), view.pivot);
    let Some(photos) = state.session.as_ref().map(photos) else { return };
    let photos = state.in_view_first(photos);
    let Some(session) = &mut state.session else { return };
    let site = &session.opened.site;
    let request = UpdateRequest {
        photos: photos.iter().map(|photo| site.photo(*photo).name.clone()).collect(),
        only_existing: true,
        // The other half is for the views.
        together: (rayon::current_num_threads() / 2).max(1),
        keep_former: true,
        stops: work.live.new_stops(),
        ..UpdateRequest::default()
    };
    let clears = session.has_former;
    session.has_former = true;
    let (opened, known) = (session.opened.clone(), session.photos.clone());
    let job = BackgroundUpdate { live: work.live.clone(), opened, known, request, clears };
    state.updating.begin();
    state.round_trip.is_behind = false;
    let folder = session.folder.clone();
    let run = move |task: &Task| job.run(&folder, task);
    let id = work.jobs.start(&mut state.running, JobKind::Update, "Updating layers", run);
    // What was stopped by an edit goes on: its bar does, too.
    if let Some(job) = state.running.get_mut(id) {
        job.progress = Progress::continuing(state.updating.reached);
    }
}

struct BackgroundUpdate {
    live: LiveProject,
    /// The project as it is when the update begins.
    opened: Arc<Opened>,
    known: Vec<PhotoStatus>,
    request: UpdateRequest,
    /// Whether versions that nothing names any more are deleted before.
    clears: bool,
}

impl BackgroundUpdate {
    fn run(self, folder: &Path, task: &Task) -> Result<Arrival> {
        let updated = self.update(folder, task);
        // What was finished before the end is shown.
        let opened = self.live.project(task).unwrap_or_else(|_| self.opened.clone());
        let photos = survey(folder, &opened.project, &opened.site, &self.known, &Task::silent())?;
        let folder = folder.to_path_buf();
        // Photos that changed meanwhile, or were stopped, are left to the next update.
        let is_left = |photo: &UpdatedPhoto| matches!(photo.end, UpdateEnd::Changed | UpdateEnd::Stopped);
        let is_complete = match &updated {
            Ok(updated) => !updated.iter().any(is_left),
            Err(error) => !matches!(error, Error::Cancelled),
        };
        Ok(Box::new(move |state| {
            let (updated, mut notes) = match updated {
                Ok(updated) => (updated, Vec::new()),
                Err(Error::Cancelled) => (Vec::new(), Vec::new()),
                Err(error) => (Vec::new(), Note::of_error("Updating layers", &error)),
            };
            if is_complete {
                state.updating.reached = 0.0;
            }
            let failed = failures(&updated);
            let damaged = damaged_masks(&opened.project, &opened.site, failed.keys());
            notes.extend(results(&updated));
            let news = state.updating.failed(failed);
            let damaged = if news.is_empty() { Vec::new() } else { damaged };
            notes.extend(news);
            let built = updated.iter().any(|photo| photo.built);
            let mut requests = state.updated(&folder, photos, notes, built);
            requests.push(MaskRequest::Report(damaged, "is not up to date").into());
            requests
        }))
    }

    fn update(&self, folder: &Path, task: &Task) -> Result<Vec<UpdatedPhoto>> {
        let store = StackStore::new(folder);
        if self.clears {
            let _right = self.live.right(task)?;
            store.clear_former()?;
        }
        let rasteriser =
            || -> Result<Box<dyn Rasteriser>> { Ok(Box::new(GpuRasteriser::new(&Gpu::headless()?)?)) };
        update(&store, &self.live, &self.request, &rasteriser, task)
    }
}

/// Returns why photos could not be updated, by name.
fn failures(updated: &[UpdatedPhoto]) -> BTreeMap<String, String> {
    let failed = updated.iter().filter_map(|photo| match &photo.end {
        UpdateEnd::Failed(error) => Some((photo.photo.clone(), error.to_string())),
        _ => None,
    });
    failed.collect()
}

/// Returns the notes about what was made, and about files of the user that stood in the way.
fn results(updated: &[UpdatedPhoto]) -> Vec<Note> {
    let kept = updated.iter().flat_map(|photo| photo.kept.iter().map(move |file| (&photo.photo, file)));
    let mut notes: Vec<Note> = kept
        .map(|(photo, file)| {
            let text = format!("a file was changed by hand and is now {}", file.display());
            Note::about(Weight::Warning, photo, text)
        })
        .collect();
    let made = updated.iter().filter(|photo| photo.built || photo.filled).count();
    if made > 0 {
        let text = format!("The layers of {} were brought up to date", counted(made as u64, "photo"));
        notes.push(Note::new(Weight::Info, text));
    }
    notes
}

/// Starts listing the photos as built that a running build has finished. Views show them when the build has ended: their
/// renderer is made of all stacks at once.
fn list_built(state: &mut State, work: &mut Work) {
    let built = state.running.progress(JobKind::Build).map_or(0, Progress::done);
    // Without a build, there is nothing to look at, and the next one begins to count.
    let can = built == 0 || state.can_list_built();
    let is_due = can && state.updating.lists(built, state.window.now_s) && built > 0;
    let Some(session) = state.session.as_ref().filter(|_| is_due) else { return };
    let (folder, opened, known) = (session.folder.clone(), session.opened.clone(), session.photos.clone());
    work.jobs.start(&mut state.running, JobKind::Survey, "Checking layers", move |task| {
        let photos = survey(&folder, &opened.project, &opened.site, &known, task)?;
        Ok(arrival(move |state| state.list_built(&folder, photos)))
    });
}

/// Starts showing what a running update has finished.
fn show_finished(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened, known) = (session.folder.clone(), session.opened.clone(), session.photos.clone());
    work.jobs.start(&mut state.running, JobKind::Survey, "Checking layers", move |task| {
        let photos = survey(&folder, &opened.project, &opened.site, &known, task)?;
        // While stacks are being built, the renderer would be made again and again.
        let builds = photos.iter().any(|photo| photo.stack.is_some() && !photo.is_current());
        Ok(Box::new(move |state| match builds {
            true => Vec::new(),
            false => state.updated(&folder, photos, Vec::new(), false),
        }))
    });
}

/// How stacks differ from those that are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StackChange {
    /// They are the same.
    None,
    /// Their image layers are the same, in other files or with other fillings.
    Fillings,
    /// Their image layers are others.
    Layers,
}

impl StackChange {
    /// Compares the stacks that are known with those that were seen, both in the site's order.
    pub fn between(known: &[Option<Arc<Stack>>], seen: &[Option<Arc<Stack>>]) -> Self {
        let same_layers = |both: (&Option<Arc<Stack>>, &Option<Arc<Stack>>)| match both {
            (Some(known), Some(seen)) => known.inputs == seen.inputs && known.is_placed_like(seen),
            (known, seen) => known.is_none() && seen.is_none(),
        };
        let is_same = |known: &Option<Arc<Stack>>, seen: &Option<Arc<Stack>>| match (known, seen) {
            (Some(known), Some(seen)) => Arc::ptr_eq(known, seen),
            (known, seen) => known.is_none() && seen.is_none(),
        };
        let mut both = known.iter().zip(seen);
        if known.len() != seen.len() || !both.clone().all(same_layers) {
            Self::Layers
        } else if both.all(|(known, seen)| is_same(known, seen)) {
            Self::None
        } else {
            Self::Fillings
        }
    }
}

impl State {
    /// Lists photos as built while the build goes on. At its end, everything is read anew.
    pub(super) fn list_built(&mut self, folder: &Path, photos: Vec<PhotoStatus>) {
        let builds = self.running.runs(JobKind::Build);
        let is_same = |session: &&mut Session| {
            builds && session.folder == folder && session.photos.len() == photos.len()
        };
        let Some(session) = self.session.as_mut().filter(is_same) else { return };
        let photos = session.newest(photos);
        let before = std::mem::replace(&mut session.photos, photos);
        self.keep_selection(&before);
        self.quality.forget_stacks();
    }

    /// Shows stacks that an update has made; `built`: it has written layers, even where they are described as before.
    fn updated(
        &mut self,
        folder: &Path,
        photos: Vec<PhotoStatus>,
        notes: Vec<Note>,
        built: bool,
    ) -> Vec<Request> {
        if self.running.runs(JobKind::Render) {
            // A film is drawn by the renderer of the 3D view, which new layers replace: they are shown afterwards.
            self.updating.want();
            notes.into_iter().for_each(|note| self.notify(note));
            return Vec::new();
        }
        let Some(session) = &self.session else { return Vec::new() };
        let photos = session.newest(photos);
        match StackChange::between(&stacks_of(&session.photos), &stacks_of(&photos)) {
            StackChange::Fillings if !built => self.fillings_changed(folder, photos, notes),
            StackChange::None if !built => {
                notes.into_iter().for_each(|note| self.notify(note));
                self.states_seen(folder, photos)
            }
            _ => self.stacks_changed(folder, photos, notes, true),
        }
    }
}
