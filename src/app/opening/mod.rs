//! Projects come and go: chosen, dropped on the window, made anew, found again where parts of them moved, waited for
//! while another program has them, and left without losing what runs.

mod assistant;
mod assistant_ui;
mod chooser;
mod held;
mod looking;
mod on_disk;
mod place;
mod relinking;
mod writing;

use std::path::{Path, PathBuf};

use eframe::egui::Context;

use self::assistant::Assistant;
use self::chooser::Chooser;
pub use self::chooser::Purpose;
use self::held::Held;
use self::looking::Looking;
use self::on_disk::OnDisk;
pub use self::on_disk::changed;
pub use self::place::{is_entered, line, typed_path, typed_ui};
use self::relinking::Relinking;
pub use self::writing::Farewell;
use self::writing::Writing;
use super::editor::{Ask, Editor};
use super::jobs::{Arrival, Kind};
use super::leaving::Leaving;
use super::notes::{Note, Weight};
use super::session::Session;
use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::io::lock::ProjectLock;
use crate::io::project::{PROJECT_FILE, read_project};
use crate::recipe::discover::Part;
use crate::recipe::relink::{gone, missing_photos, parts_of};

/// What is going on around opening, making and leaving projects.
#[derive(Default)]
pub struct Opening {
    chooser: Chooser,
    looking: Looking,
    assistant: Option<Assistant>,
    relinking: Option<Relinking>,
    held: Option<Held>,
    writing: Option<Writing>,
    on_disk: Option<OnDisk>,
    /// The project that is opened next is new: it is checked.
    check_next: bool,
    /// Grows whenever a project is left: what was being opened before is not wanted any more.
    round: u64,
    /// The path being typed where no dialog of the system is at hand; the welcome page has it, too.
    pub typed: String,
    typing: bool,
    title: String,
}

/// What the dialogs want.
pub enum Wish {
    /// The assistant for new projects, for a site in this folder if there is one.
    New(Option<PathBuf>),
    /// A file or folder that was dropped or typed: a project is opened, anything else becomes one.
    Take(PathBuf),
    /// A dialog of the system.
    Choose(Purpose),
    /// Looks for a site in the folder that the assistant has.
    Search,
    /// Makes the project that the assistant describes.
    Create,
    /// Closes whatever dialog is there.
    Cancel,
    /// Tries to open the project again.
    TryAgain(PathBuf),
    /// Tells the project of the places that were found.
    Relink,
    /// What becomes of what runs.
    Leave(Farewell),
}

impl Opening {
    /// A dialog waits for an answer: keys are for it.
    pub fn is_asking(&self) -> bool {
        self.assistant.is_some()
            || self.relinking.is_some()
            || self.held.is_some()
            || self.writing.is_some()
            || self.typing
    }
}

impl Editor {
    /// Does what a dialog wants.
    pub fn grant_opening(&mut self, wish: Wish) {
        match wish {
            Wish::New(root) => self.start_assistant(root.as_deref()),
            Wish::Take(path) => self.take(&path),
            Wish::Choose(purpose) => self.choose(purpose),
            Wish::Search => self.search_site(),
            Wish::Create => self.leave(Leaving::Create),
            Wish::Cancel => self.cancel_dialogs(),
            Wish::TryAgain(folder) => self.open_project(folder),
            Wish::Relink => self.relink(),
            Wish::Leave(farewell) => self.bid(farewell),
        }
    }

    fn cancel_dialogs(&mut self) {
        if self.opening.assistant.take().is_some() {
            self.jobs.stop_kind(Kind::Search);
        }
        self.jobs.stop_kind(Kind::Paths);
        (self.opening.relinking, self.opening.held) = (None, None);
        self.opening.typing = false;
    }

    /// What happens without anybody asking: called once a frame, before anything is drawn.
    pub(super) fn watch_opening(&mut self, context: &Context) {
        self.take_dropped(context);
        self.take_chosen();
        self.watch_held(context);
        self.watch_writing();
        self.keep_looking(context);
        self.take_changes();
        self.show_title(context);
    }

    /// What was dropped on the window.
    fn take_dropped(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        if self.asks() {
            return;
        }
        let paths: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_path_buf()).collect();
        if !self.import_dropped(&paths) {
            paths.iter().for_each(|path| self.take(path));
        }
    }

    /// A project is opened; anything else belongs to a new one.
    fn take(&mut self, path: &Path) {
        match project_at(path) {
            Some(folder) => self.leave(Leaving::Open(folder)),
            None => self.start_assistant(Some(path)),
        }
    }

    /// Opens the project in `folder` instead of the one that is open; asks first where something is not saved or
    /// still written.
    pub fn open_project(&mut self, folder: PathBuf) {
        self.leave(Leaving::Open(folder));
    }

    pub(super) fn open_now(&mut self, folder: PathBuf) {
        let folder = project_at(&folder).unwrap_or(folder);
        self.close_project();
        self.cancel_dialogs();
        let name = format!("Opening {}", folder.display());
        let round = self.opening.round;
        self.jobs.start(Kind::Open, name, move |task| {
            let arrival: Arrival = match Session::open(&folder, task) {
                Ok((session, recovered)) => Box::new(move |editor| {
                    editor.opened(session);
                    recovered.into_iter().for_each(|recovered| editor.offer_recovery(recovered));
                }),
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => obstacle(folder, error)?,
            };
            Ok(if_wanted(round, arrival))
        });
    }

    /// A project is left, or none was open: what is on its way comes too late.
    pub(super) fn forget_opening(&mut self) {
        self.opening.round += 1;
        self.opening.on_disk = None;
    }

    /// What belongs to a project that was just opened, beside showing it.
    pub(super) fn welcome_session(&mut self) {
        let Some(session) = &self.session else { return };
        let parts = parts_of(&session.folder, &session.opened.project);
        // Cameras often name more photos than are used; one that has been built before is missed.
        let built = |photo: &String| session.folder.join("stacks").join(file_name_of_photo(photo)).exists();
        let missing = missing_photos(&session.opened, &parts);
        if missing.iter().any(built) {
            self.opening.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
        }
        if std::mem::take(&mut self.opening.check_next) {
            self.check();
        }
        self.watch_disk();
    }

    /// Shows which files of the open project are missing.
    pub fn show_missing(&mut self) {
        let Some(session) = &self.session else { return };
        let parts = parts_of(&session.folder, &session.opened.project);
        let missing = missing_photos(&session.opened, &parts);
        self.opening.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
    }

    fn show_title(&mut self, context: &Context) {
        let name = self.session.as_ref().map(Session::name);
        let title = name.map_or_else(|| "Quadratura".into(), |name| format!("{name} – Quadratura"));
        if title != self.opening.title {
            context.send_viewport_cmd(eframe::egui::ViewportCommand::Title(title.clone()));
            self.opening.title = title;
        }
    }
}

/// Comes in only where no project was left since `round`.
fn if_wanted(round: u64, arrival: Arrival) -> Arrival {
    Box::new(move |editor| {
        if editor.opening.round == round {
            arrival(editor);
        }
    })
}

/// The project's folder, for a folder with a project or its file.
fn project_at(path: &Path) -> Option<PathBuf> {
    if path.file_name().is_some_and(|name| name == PROJECT_FILE) {
        return path.parent().map(PathBuf::from);
    }
    path.join(PROJECT_FILE).is_file().then(|| path.to_path_buf())
}

/// What keeps a project from being opened: something that the user can be asked about, or an error.
fn obstacle(folder: PathBuf, error: Error) -> Result<Arrival> {
    if let Some(holder) = ProjectLock::holder(&folder) {
        return Ok(Box::new(move |editor| editor.opening.held = Some(Held::by(folder, holder))));
    }
    let Ok(project) = read_project(&folder) else { return Err(error) };
    let parts = parts_of(&folder, &project);
    let gone = gone(&parts);
    if gone.is_empty() {
        return Err(error);
    }
    Ok(Box::new(move |editor| {
        let names: Vec<&str> = gone.iter().map(|part: &Part| part.name()).collect();
        let text = format!("{}: {} not where they were", folder.display(), names.join(", "));
        editor.notes.add(Note::new(Weight::Problem, text));
        editor.opening.relinking = Some(Relinking::of_parts(folder, parts, &gone));
    }))
}

/// Draws the dialogs that are open.
pub fn opening_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    let mut wishes = Vec::new();
    assistant_ui::assistant_ui(editor, context, &mut wishes);
    relinking::relinking_ui(editor, context, &mut wishes);
    held::held_ui(editor, context, &mut wishes);
    writing::writing_ui(editor, context, &mut wishes);
    chooser::typing_ui(editor, context, &mut wishes);
    asks.extend(wishes.into_iter().map(Ask::Opening));
}
