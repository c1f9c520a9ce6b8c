//! Projects opened, closed, built and filled: jobs, and what becomes of the editor when they end.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

use eframe::egui::Context;

use super::editor::Editor;
use super::jobs::Kind;
use super::leaving::Leaving;
use super::notes::{Note, Weight};
use super::painter::Painter;
use super::pictures::Pictures;
use super::quality::Quality;
use super::selection::Selection;
use super::session::{Session, survey};
use super::space::Space;
use crate::error::Error;
use crate::gpu::{Gpu, GpuRasteriser};
use crate::io::project::PROJECT_FILE;
use crate::io::stack_store::StackStore;
use crate::recipe::budget::default_memory;
use crate::recipe::build::{BuildOptions, build};
use crate::recipe::check::{CheckOptions, CheckReport, Verdict, check_site};
use crate::recipe::fill::{FillRequest, fill};
use crate::recipe::preview::{self, PreviewOptions};
use crate::task::Task;

/// Dialogs around opening and making projects.
#[derive(Default)]
pub struct Opening {
    /// A folder that is being chosen in a dialog of the system.
    choosing: Option<Receiver<Option<PathBuf>>>,
}

impl Editor {
    /// Asks for a project's folder.
    pub fn choose_project(&mut self) {
        let (send, receive) = channel();
        let context = self.context.clone();
        // The system's dialog waits for the user: not on the window's thread.
        let ask = move || {
            let chosen = rfd::FileDialog::new().set_title("Open the folder of a project").pick_folder();
            let _ = send.send(chosen);
            context.request_repaint();
        };
        if std::thread::Builder::new().name("dialog".into()).spawn(ask).is_ok() {
            self.opening.choosing = Some(receive);
        }
    }

    pub(super) fn take_chosen(&mut self) {
        let Some(receive) = &self.opening.choosing else { return };
        if let Ok(chosen) = receive.try_recv() {
            self.opening.choosing = None;
            chosen.into_iter().for_each(|folder| self.open_project(folder));
        }
    }

    /// A project's folder or file that was dropped on the window is opened.
    pub(super) fn take_dropped(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_path_buf()).collect();
        let Some(path) = paths.first().cloned().filter(|_| !self.import_dropped(&paths)) else { return };
        let folder = if path.is_file() { path.parent().map(PathBuf::from).unwrap_or_default() } else { path };
        if folder.join(PROJECT_FILE).is_file() {
            self.open_project(folder);
        } else {
            let found = format!("{}: this is no project; it has no {PROJECT_FILE}", folder.display());
            self.tell(Note::new(Weight::Problem, found));
        }
    }

    /// Opens the project in `folder` instead of the one that is open; asks first where something is not saved.
    pub fn open_project(&mut self, folder: PathBuf) {
        self.leave(Leaving::Open(folder));
    }

    pub(super) fn open_now(&mut self, folder: PathBuf) {
        let folder = match folder.file_name() {
            Some(name) if name == PROJECT_FILE => folder.parent().map(PathBuf::from).unwrap_or_default(),
            _ => folder,
        };
        self.close_project();
        self.jobs.stop_kind(Kind::Open);
        let name = format!("Opening {}", folder.display());
        self.jobs.start(Kind::Open, name, move |task| {
            let (session, recovered) = Session::open(&folder, task)?;
            Ok(Box::new(move |editor| {
                editor.opened(session);
                recovered.into_iter().for_each(|recovered| editor.offer_recovery(recovered));
            }))
        });
    }

    fn opened(&mut self, session: Session) {
        self.settings.remember(&session.folder);
        for problem in &session.opened.problems {
            self.notes.add(Note::new(Weight::Problem, problem.to_string()));
        }
        self.space = Space::of(&session);
        self.selection = Selection::Nothing;
        self.photo = (!session.photos.is_empty()).then_some(0);
        self.flat.forget();
        self.pictures = Pictures::default();
        self.pictures.start(&session.folder, &session.opened, &mut self.jobs);
        self.session = Some(session);
        self.prepare_painter();
        self.begin_trip();
        self.show_exposure();
    }

    /// Closes the project; what is running on it is stopped.
    pub fn close_project(&mut self) {
        self.jobs.stop_all();
        self.leave_trip();
        self.quality = Quality::default();
        self.session = None;
        self.selection = Selection::Nothing;
        self.flat.forget();
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
        self.jobs.stop_kind(Kind::Preview);
        self.jobs.start(Kind::Preview, "Preparing the 3D view", move |task| {
            let gpu = Gpu::headless()?;
            let preview = preview::open(&folder, &opened, &gpu, &PreviewOptions::default(), task)?;
            preview.problems().into_iter().for_each(|problem| task.note(problem));
            let model = opened.site.model.clone();
            let painter = Painter::new(preview, model, gpu.adapter_summary(), task.clone(), context)?;
            Ok(Box::new(move |editor| {
                if let Some(session) = editor.session.as_mut().filter(|session| session.folder == folder) {
                    session.painter = Some(painter);
                    editor.space.refresh();
                }
            }))
        });
    }

    /// Builds the stacks of these photos, or of all.
    pub fn build(&mut self, photos: Vec<String>) {
        let Some(session) = &self.session else { return };
        let (folder, opened) = (session.folder.clone(), session.opened.clone());
        self.jobs.start(Kind::Build, "Building layers", move |task| {
            let store = StackStore::new(&folder);
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
            let built = build(&opened.site, &store, &rasteriser, &options, task)?;
            let mut notes = Vec::new();
            for photo in &built {
                if let Err(error) = &photo.stack {
                    notes.push(Note::about(Weight::Problem, &photo.photo, error.to_string()));
                }
                let kept =
                    photo.kept.iter().map(|file| format!("changed by hand, so it is now {}", file.display()));
                notes.extend(kept.map(|text| Note::about(Weight::Warning, &photo.photo, text)));
            }
            let made = built.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
            let current = built.iter().filter(|photo| photo.up_to_date).count();
            notes.push(Note::new(
                Weight::Info,
                format!("Layers built: {made} photos; {current} were up to date"),
            ));
            if built.iter().any(|photo| matches!(photo.stack, Err(Error::Cancelled))) {
                notes.retain(|note| !note.text.contains("stopped on request"));
                notes.push(Note::new(Weight::Info, "Building layers: stopped; what was built stays"));
            }
            preview::prepare(&folder, &opened, task).or_else(not_if_stopped)?;
            let photos = survey(&folder, &opened, &Task::silent())?;
            Ok(Box::new(move |editor| editor.stacks_changed(&folder, photos, notes)))
        });
    }

    /// Fills what photos do not show.
    pub fn fill(&mut self) {
        let Some(session) = &self.session else { return };
        let (folder, opened) = (session.folder.clone(), session.opened.clone());
        self.jobs.start(Kind::Fill, "Filling hidden parts", move |task| {
            let request = FillRequest {
                options: opened.project.fill.clone(),
                photos: Vec::new(),
                memory: default_memory(),
                force: false,
            };
            let filled = fill(&folder, &opened, &request, task)?;
            let failed = filled.iter().filter_map(|photo| Some((&photo.photo, photo.stack.as_ref().err()?)));
            let mut notes: Vec<Note> =
                failed.map(|(photo, error)| Note::about(Weight::Problem, photo, error.to_string())).collect();
            let made = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
            notes.push(Note::new(Weight::Info, format!("Hidden parts filled: {made} photos")));
            let photos = survey(&folder, &opened, &Task::silent())?;
            Ok(Box::new(move |editor| editor.stacks_changed(&folder, photos, notes)))
        });
    }

    /// Compares cameras, photos and model.
    pub fn check(&mut self) {
        let Some(session) = &self.session else { return };
        let opened = session.opened.clone();
        self.jobs.start(Kind::Check, "Checking cameras, photos and model", move |task| {
            let project = &opened.project;
            let (world_from_model, tolerance) = (project.world_from_model, project.options.tolerance);
            let options = CheckOptions { world_from_model, tolerance, pictures: None };
            let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
            let report = check_site(&opened.site, &opened.points, &options, &rasteriser, task)?;
            Ok(Box::new(move |editor| {
                editor.settings.notes_shown = true;
                editor.tell(judged(&report));
            }))
        });
    }

    pub(super) fn stacks_changed(
        &mut self,
        folder: &std::path::Path,
        photos: Vec<super::session::PhotoStatus>,
        notes: Vec<Note>,
    ) {
        notes.into_iter().for_each(|note| self.tell(note));
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else { return };
        session.photos = photos;
        self.quality.forget_stacks();
        self.prepare_painter();
    }
}

/// What a check found, in a sentence or two.
fn judged(report: &CheckReport) -> Note {
    let (weight, verdict) = match report.verdict {
        Verdict::Fits => (Weight::Info, "The model fits the photos"),
        Verdict::Poor => (Weight::Warning, "The model fits the photos in part"),
        Verdict::Misses => (Weight::Problem, "The model does not stand where the photos are"),
    };
    let met = report.agreement.map_or(String::new(), |share| {
        format!("; it meets {:.0} % of the sparse points' sightings", 100.0 * share)
    });
    let better = report.suggestion.as_ref().map_or(String::new(), |suggestion| {
        format!(" This transform of the model does better: {}", suggestion.transform)
    });
    Note::new(weight, format!("{verdict}{met}.{better}"))
}

/// Gains and relief can be made later.
fn not_if_stopped(error: Error) -> crate::Result<()> {
    if matches!(error, Error::Cancelled) { Ok(()) } else { Err(error) }
}
