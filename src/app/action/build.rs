//! Actions that show, close, build and fill a project: they start the jobs and apply their results to the state.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::action::known::{leave_known, remember_opened};
use crate::action::masks::repairing::{damaged_masks, tell_problems};
use crate::action::opening::around::{forget_opening, welcome_session};
use crate::action::opening::on_disk::watch_disk;
use crate::action::quality::surroundings::{is_repainted, renew_surroundings};
use crate::action::reread::reopen;
use crate::action::round_trip::watching::{begin_round_trip, leave_round_trip};
use crate::action::space::space_failed;
use crate::action::updating::StackChange;
use crate::state::State;
use crate::state::checks::Checks;
use crate::state::masking::Masking;
use crate::state::model_suggestions::SuggestedModelState;
use crate::state::notes::changed;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::counted;
use crate::state::quality::QualityState;
use crate::state::request::{JobRequest, MaskRequest, Request};
use crate::state::running::JobKind;
use crate::state::selection::SelectionState;
use crate::state::session::{PhotoStatus, Session, stacks_of, survey};
use crate::state::space::SpaceView;
use crate::state::space::brush::SpaceBrush;
use crate::state::trees::{ShownTrees, TreesState};
use crate::state::updating::Updating;
use crate::work::MadePainter;
use crate::work::Work;
use crate::work::autosave::AutosaveWriter;
use crate::work::jobs::arrival;
use crate::work::painter::{Painter, PreviewChange};
use crate::work::pictures::PhotoPictures;
use quadratura_base::error::{Error, Message};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_io::stack_store::StackStore;
use quadratura_sites::budget::default_memory;
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_stacks::build::{BuildOptions, build};
use quadratura_stacks::fill::{FillRequest, fill};
use quadratura_trees::PlantParts;
use quadratura_views::preview::{self, PreviewOptions, ReadStacks};

impl State {
    /// Applies new photo states. Where their stacks are the ones that are shown, only the states change.
    pub fn states_seen(&mut self, folder: &std::path::Path, photos: Vec<PhotoStatus>) -> Vec<Request> {
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else {
            return Vec::new();
        };
        let photos = session.newest(photos);
        let same = session.photos.len() == photos.len()
            && session.photos.iter().zip(&photos).all(|(known, seen)| seen.is_drawn_like(known));
        if !same {
            return self.stacks_changed(folder, photos, Vec::new(), false);
        }
        for (known, seen) in session.photos.iter_mut().zip(photos) {
            *known = seen;
        }
        Vec::new()
    }

    /// Applies stacks that were read again, after files of some were `made` or after a decision.
    pub fn stacks_changed(
        &mut self,
        folder: &std::path::Path,
        photos: Vec<PhotoStatus>,
        notes: Vec<Note>,
        made: bool,
    ) -> Vec<Request> {
        notes.into_iter().for_each(|note| self.notify(note));
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else {
            return Vec::new();
        };
        // The result belongs to a site that has been read again since.
        if photos.len() != session.opened.site.photos.len() {
            return Vec::new();
        }
        let photos = session.newest(photos);
        let before = std::mem::replace(&mut session.photos, photos);
        let same = !made && before.iter().zip(&session.photos).all(|(before, now)| now.is_drawn_like(before));
        self.keep_selection(&before);
        if same {
            // Which photo textures a face may have changed; the colour comparison is unaffected.
            self.quality.fill.forget_stacks();
            vec![JobRequest::Redecide.into()]
        } else {
            self.quality.forget_stacks();
            vec![JobRequest::PreparePainter.into()]
        }
    }
}

/// Shows a project that was opened.
pub fn opened(state: &mut State, work: &mut Work, session: Session) {
    remember_opened(state, work, &session.folder);
    state.space = SpaceView::from_session(&session);
    let first = session.opened.site.photo_ids().next();
    state.selection = SelectionState { photo: first, ..SelectionState::default() };
    state.flat.forget();
    state.lists.forget();
    state.masking = Masking::default();
    state.trees = TreesState::default();
    let autosave = Arc::new(AutosaveWriter::new(&session.folder, session.lock.clone()));
    work.ending.keeps(&autosave);
    work.autosave = Some(autosave);
    work.drop_painter(&mut state.space);
    state.session = Some(session);
    look_at_photos(state, work);
    prepare_painter(state, work);
    begin_round_trip(state, work);
    state.show_exposure();
    tell_problems(state, work);
    welcome_session(state, work);
}

/// Closes the project and stops its jobs.
pub fn close_project(state: &mut State, work: &mut Work) {
    work.jobs.leave_all(&mut state.running);
    forget_opening(state, work);
    leave_round_trip(state, work);
    state.quality = QualityState::default();
    state.checks = Checks::default();
    state.suggested_model = SuggestedModelState::default();
    state.flights.forget();
    state.life.closed();
    state.space.brush = SpaceBrush::default();
    state.trees = TreesState::default();
    // Messages are about this project.
    state.notes.clear();
    leave_known(state);
    state.updating = Updating::default();
    work.drop_painter(&mut state.space);
    state.session = None;
    work.autosave = None;
    state.selection = SelectionState::default();
    state.flat.forget();
    state.lists.forget();
    state.masking = Masking::default();
    work.pictures = PhotoPictures::default();
}

/// Starts the job that makes the renderer of the 3D view from the stacks as they are known, and replaces the current one
/// where there is one.
pub fn prepare_painter(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if session.photos.iter().all(|photo| photo.stack.is_none()) {
        return;
    }
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let (waker, left) = (work.waker.clone(), work.made.clone());
    let book = state.round_trip.book.clone();
    let photos = session.photos.clone();
    work.jobs.stop_kind(&mut state.running, JobKind::Preview);
    // The new renderer gets the present surroundings.
    work.jobs.stop_kind(&mut state.running, JobKind::Surroundings);
    state.space.trouble = None;
    let project = Arc::new(opened.project.clone());
    state.trees.prepared = Some(ShownTrees {
        project,
        hidden: BTreeSet::new(),
        estimate: state.trees.light.estimate(),
        images: state.trees.images.count(),
        plants_version: state.trees.plants_version,
    });
    work.jobs.start(&mut state.running, JobKind::Preview, "Preparing the 3D view", move |task| {
        let made = Gpu::headless().and_then(|gpu| {
            // The list of photos and the status bar say which layers are out of date, as long as they are.
            let options = PreviewOptions {
                without_stack_notes: true,
                tree_parts: PlantParts::CachedImages,
                ..PreviewOptions::default()
            };
            let read = read_stacks(&opened.site, &photos);
            let preview =
                preview::open_read(&folder, &opened.project, &opened.site, read, &gpu, &options, task)?;
            preview.problems().into_iter().for_each(|problem| task.note(problem));
            Painter::new(preview, folder.clone(), opened.clone(), &gpu, task.clone(), waker)
        });
        let model = opened.site.model.clone();
        let request = match made {
            Ok(painter) => {
                left.put(MadePainter { painter, folder, model, book, stacks: stacks_of(&photos) });
                JobRequest::PainterMade
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => JobRequest::PainterFailed(folder, error),
        };
        Ok(Box::new(move |_| vec![request.into()]))
    });
}

/// Returns the stacks of the photos with messages about those that cannot be read.
fn read_stacks(site: &Site, photos: &[PhotoStatus]) -> ReadStacks {
    let stacks = photos.iter().map(|photo| photo.stack.as_deref().cloned()).collect();
    let unread = site.photos.iter().zip(photos).filter(|(_, status)| status.stack.is_none());
    let problems = unread.filter_map(|(photo, status)| {
        let problem = status.problem.as_ref()?;
        Some(Message::from(format!("{}: its stack is not used: {problem}", photo.name)))
    });
    ReadStacks { stacks, problems: problems.collect() }
}

/// Installs the painter that a job has made, unless the project or its model has changed since.
pub fn painter_made(state: &mut State, work: &mut Work) {
    let Some(MadePainter { mut painter, folder, model, book, stacks }) = work.made.take() else { return };
    let is_wanted =
        |session: &&mut Session| session.folder == folder && Arc::ptr_eq(&model, &session.opened.site.model);
    // Objects were excluded or included in the meantime: a job is making another painter.
    let Some(session) = state.session.as_mut().filter(is_wanted) else { return };
    session.solid = painter.surface.clone();
    // The painter was made from earlier decisions: it gets the current ones, and paint that has come since.
    painter.change(PreviewChange::Decisions(session.opened.clone()));
    let is_newer = |now: &&Arc<PaintBook>| book.as_ref().is_none_or(|then| !Arc::ptr_eq(then, now));
    let mut is_repainted_around = false;
    if let Some(now) = state.round_trip.book.as_ref().filter(is_newer) {
        let entries = now.entries.iter().chain(book.iter().flat_map(|then| &then.entries));
        let photos: BTreeSet<String> = entries.map(|entry| entry.photo.clone()).collect();
        painter.change(PreviewChange::Paint(photos.into_iter().collect(), now.clone()));
        is_repainted_around = is_repainted(book.as_deref(), now);
    }
    // Stacks that were made meanwhile; where their layers are others, another painter is needed.
    let change = StackChange::between(&stacks, &stacks_of(&session.photos));
    if change == StackChange::Fillings {
        painter.change(PreviewChange::Fillings(stacks_of(&session.photos)));
    }
    state.space.device = Some(painter.adapter.clone());
    work.painter = Some(painter);
    // It gets the present trees with the next frame, where they are others.
    state.trees.sent = state.trees.prepared.take();
    state.space.refresh();
    if is_repainted_around {
        renew_surroundings(state, work);
    }
    match change {
        StackChange::Layers if !state.running.runs(JobKind::Preview) => prepare_painter(state, work),
        _ => clear_former(state, work),
    }
}

/// Reports that the painter of this project could not be made, or has failed.
pub fn painter_failed(state: &mut State, work: &mut Work, folder: &Path, error: &Error) {
    if state.session.as_ref().is_some_and(|session| session.folder == folder) {
        space_failed(state, work, error);
    }
}

/// Starts the painter for a changed model; the current painter stops at once.
pub fn restart_painter(state: &mut State, work: &mut Work) {
    work.drop_painter(&mut state.space);
    prepare_painter(state, work);
}

/// Resets everything that shows the site, after the site was read again. Where photos and model are the same ones as before,
/// the view keeps its renderer until another one is made.
pub fn site_read(state: &mut State, work: &mut Work, is_same: bool) {
    look_at_photos(state, work);
    if is_same {
        prepare_painter(state, work)
    } else {
        restart_painter(state, work)
    }
    watch_disk(state, work);
}

/// Starts making the thumbnails of the photos again.
fn look_at_photos(state: &mut State, work: &mut Work) {
    state.trees.files_changed();
    work.pictures = PhotoPictures::default();
    if let Some(session) = &state.session {
        work.pictures.start(&session.folder, &session.opened, &mut work.jobs, &mut state.running);
    }
}

/// Deletes superseded layers from disk, once no view shows them any more.
fn clear_former(state: &mut State, work: &mut Work) {
    // An update in the background does it itself when it begins.
    let writes = [JobKind::Build, JobKind::Fill, JobKind::Update, JobKind::Import];
    let writes = writes.into_iter().any(|kind| state.running.runs(kind));
    let Some(session) = state.session.as_mut().filter(|session| session.has_former && !writes) else {
        return;
    };
    session.has_former = false;
    let (store, lock) = (StackStore::new(&session.folder), session.lock.clone());
    let stacks = work.live.stacks.clone();
    // The job counts as building, so that no other job writes stacks at the same time.
    work.jobs.start(&mut state.running, JobKind::Build, "Deleting previous layers", move |_| {
        let _locks = (lock, stacks.take());
        let kept = store.clear_former()?;
        Ok(arrival(move |state| {
            let message = |file: &std::path::PathBuf| {
                format!("The file was changed by hand and is now {}", file.display())
            };
            kept.iter().for_each(|file| state.notify(Note::new(Weight::Warning, message(file))));
        }))
    });
}

/// Starts building the stacks of these photos, or of all where the list is empty.
pub fn build_layers(state: &mut State, work: &mut Work, photos: Vec<String>) {
    let Some(session) = &mut state.session else { return };
    // The updates after the last decisions were stopped: they are done before anything is built.
    if session.is_behind() {
        return reopen(state, work, Some(photos));
    }
    session.has_former = true;
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let (seen, known) = (session.seen.clone(), session.photos.clone());
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Build, "Building layers", move |task| {
        // The lock is held until the job ends, even if the project is closed in the meantime.
        let _locks = (lock, stacks.take());
        let changes = seen.changes(&SiteStamp::new(&folder, &opened.project));
        if !changes.is_empty() {
            return Ok(Box::new(move |state| {
                state.notify(changed(&changes).and(" They are reloaded before the build."));
                vec![JobRequest::Reread(Some(photos)).into()]
            }));
        }
        let store = StackStore::new(&folder).keeping_former();
        store.clean()?;
        let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
        let options = BuildOptions {
            layers: opened.project.options.clone(),
            decisions: opened.project.decisions.clone(),
            photos,
            memory: default_memory(),
            threads: rayon::current_num_threads(),
            force: false,
        };
        let built = build(&opened.site, &store, &rasteriser, &options, task);
        // Stacks that were finished before the build stopped or failed are kept and shown.
        let (built, mut notes) = match built {
            Ok(built) => (built, Vec::new()),
            Err(error) => (Vec::new(), ended("Building layers", &error)),
        };
        let stopped = !notes.is_empty();
        for photo in built.iter().filter(|photo| !matches!(photo.stack, Err(Error::Cancelled))) {
            if let Err(error) = &photo.stack {
                notes.push(Note::about(Weight::Problem, &photo.photo, error.message()));
            }
            let kept = photo
                .kept
                .iter()
                .map(|file| format!("a file was changed by hand and is now {}", file.display()));
            notes.extend(kept.map(|text| Note::about(Weight::Warning, &photo.photo, text)));
        }
        let made = built.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
        let current = built.iter().filter(|photo| photo.up_to_date).count();
        if !stopped {
            let text = format!("Layers built: {}; {current} were up to date", counted(made as u64, "photo"));
            notes.push(Note::new(Weight::Info, text));
            // Gains and relief can also be made later.
            if let Err(error) = preview::prepare(&folder, &opened.project, &opened.site, task) {
                notes.extend(ended("Preparing the view", &error));
            }
        }
        let failed = built.iter().filter(|photo| photo.stack.is_err()).map(|photo| &photo.photo);
        let damaged = damaged_masks(&opened.project, &opened.site, failed);
        // Files that were made again are read again, even where the stack description is unchanged.
        let known = if made > 0 { Vec::new() } else { known };
        let photos = survey(&folder, &opened.project, &opened.site, &known, &Task::silent())?;
        Ok(Box::new(move |state| {
            let mut requests = state.stacks_changed(&folder, photos, notes, made > 0);
            requests.push(MaskRequest::Report(damaged, "is not built").into());
            requests
        }))
    });
}

/// Starts filling the occluded areas of all layers.
pub fn fill_hidden(state: &mut State, work: &mut Work) {
    let Some(session) = &mut state.session else { return };
    session.has_former = true;
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let known = session.photos.clone();
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Fill, "Filling occluded areas", move |task| {
        // The lock is held until the job ends, even if the project is closed in the meantime.
        let _locks = (lock, stacks.take());
        let request = FillRequest {
            options: opened.project.fill.clone(),
            photos: Vec::new(),
            memory: default_memory(),
            force: false,
            keep_former: true,
        };
        let (filled, ending) = match fill(&folder, &opened.project, &opened.site, &request, task) {
            Ok(filled) => (filled, Vec::new()),
            Err(error) => (Vec::new(), ended("Filling occluded areas", &error)),
        };
        let failed = filled.iter().filter_map(|photo| Some((&photo.photo, photo.stack.as_ref().err()?)));
        let mut notes: Vec<Note> =
            failed.map(|(photo, error)| Note::about(Weight::Problem, photo, error.message())).collect();
        let made = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
        match ending.is_empty() {
            true => notes.push(Note::new(
                Weight::Info,
                format!("Occluded areas filled: {}", counted(made as u64, "photo")),
            )),
            false => notes.extend(ending),
        }
        let failed = filled.iter().filter(|photo| photo.stack.is_err()).map(|photo| &photo.photo);
        let damaged = damaged_masks(&opened.project, &opened.site, failed);
        // Files that were made again are read again, even where the stack description is unchanged.
        let known = if made > 0 { Vec::new() } else { known };
        let photos = survey(&folder, &opened.project, &opened.site, &known, &Task::silent())?;
        Ok(Box::new(move |state| {
            let mut requests = state.stacks_changed(&folder, photos, notes, made > 0);
            requests.push(MaskRequest::Report(damaged, "is not filled").into());
            requests
        }))
    });
}

/// Applies the current decisions about which photo textures which face to the renderer, from the stacks that exist; no
/// new renderer is needed. A renderer that is still being made gets the decisions when it is done.
pub fn redecide(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    match &mut work.painter {
        Some(painter) => {
            painter.change(PreviewChange::Decisions(session.opened.clone()));
            state.space.redraw();
        }
        // The reason has been reported; `Restart 3D view` tries again.
        None if state.running.runs(JobKind::Preview) || state.space.trouble.is_some() => (),
        None => prepare_painter(state, work),
    }
}

/// Returns the notes for a job that was stopped or failed; what it had finished by then is kept.
fn ended(work: &str, error: &Error) -> Vec<Note> {
    match error {
        Error::Cancelled => {
            vec![Note::new(Weight::Info, format!("{work}: stopped; finished results are kept"))]
        }
        error => Note::of_error(work, error),
    }
}
