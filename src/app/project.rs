//! Projects shown, closed, built and filled: jobs, and what becomes of the editor when they end.

use std::sync::Arc;

use super::check::Checks;
use super::editor::Editor;
use super::jobs::Kind;
use super::masking::Masking;
use super::masking::repairing::damaged_masks;
use super::notes::{Note, Weight};
use super::opening::changed;
use super::painter::{Change, Painter};
use super::panel::counted;
use super::pictures::Pictures;
use super::quality::Quality;
use super::selection::Selection;
use super::session::{PhotoStatus, Session, survey};
use super::space::Space;
use crate::error::Error;
use crate::gpu::{Gpu, GpuRasteriser};
use crate::io::stack_store::StackStore;
use crate::recipe::budget::default_memory;
use crate::recipe::build::{BuildOptions, build};
use crate::recipe::fill::{FillRequest, fill};
use crate::recipe::preview::{self, PreviewOptions};
use crate::recipe::site_stamp::SiteStamp;
use crate::task::Task;

impl Editor {
    /// Shows a project that was opened.
    pub(super) fn opened(&mut self, session: Session) {
        self.settings.remember(&session.folder);
        self.space = Space::of(&session);
        self.selection = Selection::Nothing;
        self.photo = (!session.photos.is_empty()).then_some(0);
        self.flat.forget();
        self.lists.forget();
        self.masking = Masking::default();
        self.pictures = Pictures::default();
        self.pictures.start(&session.folder, &session.opened, &mut self.jobs);
        self.ending.keeps(&session.keeper);
        self.session = Some(session);
        self.prepare_painter();
        self.begin_trip();
        self.show_exposure();
        self.tell_problems();
        self.welcome_session();
    }

    /// Closes the project; what is running on it is stopped.
    pub fn close_project(&mut self) {
        self.jobs.stop_all();
        self.forget_opening();
        self.leave_trip();
        self.quality = Quality::default();
        self.checks = Checks::default();
        self.flights.forget();
        self.forget_questions();
        self.session = None;
        self.selection = Selection::Nothing;
        self.flat.forget();
        self.lists.forget();
        self.masking = Masking::default();
        self.pictures = Pictures::default();
    }

    /// Makes the renderer of the 3D view, anew where there is one.
    pub fn prepare_painter(&mut self) {
        let Some(session) = &self.session else { return };
        if session.photos.iter().all(|photo| photo.stack.is_none()) {
            return;
        }
        let (folder, opened, context) =
            (session.folder.clone(), session.opened.clone(), self.context.clone());
        let model = opened.site.model.clone();
        self.jobs.stop_kind(Kind::Preview);
        self.space.trouble = None;
        self.jobs.start(Kind::Preview, "Preparing the 3D view", move |task| {
            let made = Gpu::headless().and_then(|gpu| {
                let preview = preview::open(&folder, &opened, &gpu, &PreviewOptions::default(), task)?;
                preview.problems().into_iter().for_each(|problem| task.note(problem));
                let model = opened.site.model.clone();
                Painter::new(preview, model, gpu.adapter_summary(), task.clone(), context)
            });
            if matches!(made, Err(Error::Cancelled)) {
                return Err(Error::Cancelled);
            }
            Ok(Box::new(move |editor| {
                let Some(session) = editor.session.as_mut().filter(|session| session.folder == folder) else {
                    return;
                };
                match made {
                    // Objects were switched meanwhile: another one is on its way.
                    Ok(_) if !Arc::ptr_eq(&model, &session.opened.site.model) => (),
                    Ok(mut painter) => {
                        session.solid = painter.surface.clone();
                        // What was decided while it was made is decided.
                        painter.change(Change::Decisions(session.opened.clone()));
                        session.painter = Some(painter);
                        editor.space.refresh();
                        editor.clear_former();
                    }
                    Err(error) => editor.space_failed(&error),
                }
            }))
        });
    }

    /// Clears layers away that no view shows any more, now that views show those that took their place.
    fn clear_former(&mut self) {
        let writes = [Kind::Build, Kind::Fill, Kind::Import];
        let writes = writes.into_iter().any(|kind| self.jobs.runs(kind));
        let Some(session) = self.session.as_mut().filter(|session| session.has_former && !writes) else {
            return;
        };
        session.has_former = false;
        let (store, lock) = (StackStore::new(&session.folder), session.lock.clone());
        // It counts as building: nobody may write stacks beside it.
        self.jobs.start(Kind::Build, "Clearing former layers away", move |_| {
            let _lock = lock;
            let kept = store.clear_former()?;
            Ok(Box::new(move |editor| {
                let told =
                    |file: &std::path::PathBuf| format!("Changed by hand, so it is now {}", file.display());
                kept.iter().for_each(|file| editor.tell(Note::new(Weight::Warning, told(file))));
            }))
        });
    }

    /// Builds the stacks of these photos, or of all.
    pub fn build(&mut self, photos: Vec<String>) {
        let Some(session) = &mut self.session else { return };
        // What was to follow from the last decisions was stopped: it is not built without them.
        if session.is_behind() {
            return self.reopen(Some(photos));
        }
        session.has_former = true;
        let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
        let (seen, known) = (session.seen.clone(), session.photos.clone());
        self.jobs.start(Kind::Build, "Building layers", move |task| {
            // Held to the end, also where the project is closed meanwhile.
            let _lock = lock;
            let changes = seen.changes(&SiteStamp::of(&folder, &opened.project));
            if !changes.is_empty() {
                return Ok(Box::new(move |editor| {
                    editor.tell(changed(&changes).and(" It is read again before it is built."));
                    editor.reopen(Some(photos));
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
            // What was built until somebody stopped it is there, and so is what failed afterwards.
            let (built, mut notes) = match built {
                Ok(built) => (built, Vec::new()),
                Err(error) => (Vec::new(), ended("Building layers", &error)),
            };
            let stopped = !notes.is_empty();
            for photo in built.iter().filter(|photo| !matches!(photo.stack, Err(Error::Cancelled))) {
                if let Err(error) = &photo.stack {
                    notes.push(Note::about(Weight::Problem, &photo.photo, error.to_string()));
                }
                let kept =
                    photo.kept.iter().map(|file| format!("changed by hand, so it is now {}", file.display()));
                notes.extend(kept.map(|text| Note::about(Weight::Warning, &photo.photo, text)));
            }
            let made = built.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
            let current = built.iter().filter(|photo| photo.up_to_date).count();
            if !stopped {
                let text =
                    format!("Layers built: {}; {current} were up to date", counted(made as u64, "photo"));
                notes.push(Note::new(Weight::Info, text));
                // Gains and relief can be made later, too.
                if let Err(error) = preview::prepare(&folder, &opened, task) {
                    notes.extend(ended("Preparing the view", &error));
                }
            }
            let failed = built.iter().filter(|photo| photo.stack.is_err()).map(|photo| &photo.photo);
            let damaged = damaged_masks(&opened, failed);
            // Files that were made again are read again, also where the stack says the same.
            let known = if made > 0 { Vec::new() } else { known };
            let photos = survey(&folder, &opened, &known, &Task::silent())?;
            Ok(Box::new(move |editor| {
                editor.stacks_changed(&folder, photos, notes, made > 0);
                editor.tell_masks(damaged, "is not built");
            }))
        });
    }

    /// Fills what photos do not show.
    pub fn fill(&mut self) {
        let Some(session) = &mut self.session else { return };
        session.has_former = true;
        let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
        let known = session.photos.clone();
        self.jobs.start(Kind::Fill, "Filling hidden parts", move |task| {
            // Held to the end, also where the project is closed meanwhile.
            let _lock = lock;
            let request = FillRequest {
                options: opened.project.fill.clone(),
                photos: Vec::new(),
                memory: default_memory(),
                force: false,
                keep_former: true,
            };
            let (filled, ending) = match fill(&folder, &opened, &request, task) {
                Ok(filled) => (filled, Vec::new()),
                Err(error) => (Vec::new(), ended("Filling hidden parts", &error)),
            };
            let failed = filled.iter().filter_map(|photo| Some((&photo.photo, photo.stack.as_ref().err()?)));
            let mut notes: Vec<Note> =
                failed.map(|(photo, error)| Note::about(Weight::Problem, photo, error.to_string())).collect();
            let made = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
            match ending.is_empty() {
                true => notes.push(Note::new(
                    Weight::Info,
                    format!("Hidden parts filled: {}", counted(made as u64, "photo")),
                )),
                false => notes.extend(ending),
            }
            let failed = filled.iter().filter(|photo| photo.stack.is_err()).map(|photo| &photo.photo);
            let damaged = damaged_masks(&opened, failed);
            // Files that were made again are read again, also where the stack says the same.
            let known = if made > 0 { Vec::new() } else { known };
            let photos = survey(&folder, &opened, &known, &Task::silent())?;
            Ok(Box::new(move |editor| {
                editor.stacks_changed(&folder, photos, notes, made > 0);
                editor.tell_masks(damaged, "is not filled");
            }))
        });
    }

    /// Photos were looked at: where their stacks are those that are shown, only their states are others.
    pub(super) fn states_seen(&mut self, folder: &std::path::Path, photos: Vec<PhotoStatus>) {
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else { return };
        let same = session.photos.len() == photos.len()
            && session.photos.iter().zip(&photos).all(|(known, seen)| seen.is_drawn_like(known));
        if !same {
            return self.stacks_changed(folder, photos, Vec::new(), false);
        }
        for (known, seen) in session.photos.iter_mut().zip(photos) {
            *known = seen;
        }
    }

    /// Stacks were looked at, after files of some were `made` or something was decided.
    pub(super) fn stacks_changed(
        &mut self,
        folder: &std::path::Path,
        photos: Vec<PhotoStatus>,
        notes: Vec<Note>,
        made: bool,
    ) {
        notes.into_iter().for_each(|note| self.tell(note));
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else { return };
        // A look at a site that was read again meanwhile.
        if photos.len() != session.opened.site.photos.len() {
            return;
        }
        let before = std::mem::replace(&mut session.photos, photos);
        let same = !made && before.iter().zip(&session.photos).all(|(before, now)| now.is_drawn_like(before));
        self.keep_selection(&before);
        if same {
            // Who serves what is decided otherwise; what was compared for colour is the same.
            self.quality.fill.forget_stacks();
            self.redecide();
        } else {
            self.quality.forget_stacks();
            self.prepare_painter();
        }
    }

    /// Photos serve faces as it is decided by now, from the stacks that there are: no new renderer is needed for it. One
    /// that is being made takes it over when it is done.
    fn redecide(&mut self) {
        let Some(session) = &mut self.session else { return };
        match &mut session.painter {
            Some(painter) => {
                painter.change(Change::Decisions(session.opened.clone()));
                self.space.redraw();
            }
            // What is in its way was told; `Restart 3D view` tries again.
            None if self.jobs.runs(Kind::Preview) || self.space.trouble.is_some() => (),
            None => self.prepare_painter(),
        }
    }
}

/// How work ended that did not come to its end: what it made until then stays.
fn ended(work: &str, error: &Error) -> Vec<Note> {
    match error {
        Error::Cancelled => vec![Note::new(Weight::Info, format!("{work}: stopped; what was made stays"))],
        error => Note::of_error(work, error),
    }
}
