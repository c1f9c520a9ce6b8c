//! Projects come and go: chosen, dropped on the window, made anew, found again where parts of them moved, waited for
//! while another program has them, and left without losing what runs.

pub mod assistant;
pub mod assistant_ui;
pub mod chooser;
pub mod held;
pub mod looking;
pub mod on_disk;
pub mod place;
pub mod relinking;

use std::path::{Path, PathBuf};

use eframe::egui::Context;

use self::assistant::Assistant;
pub use self::chooser::Purpose;
use self::held::Held;
use self::looking::Looking;
pub use self::on_disk::changed;
pub use self::place::{is_entered, line, typed_path, typed_ui};
use self::relinking::Relinking;
use crate::app::action::build::close_project;
use crate::app::action::build::opened;
use crate::app::action::life::{happens, offer_recovery};
use crate::app::check::check_project;
use crate::app::editor::Editor;
use crate::app::opening::assistant::search_site;
use crate::app::opening::assistant::start_assistant;
use crate::app::opening::chooser::choose;
use crate::app::opening::chooser::take_chosen;
use crate::app::opening::held::watch_held;
use crate::app::opening::looking::keep_looking;
use crate::app::opening::on_disk::take_changes;
use crate::app::opening::on_disk::watch_disk;
use crate::app::opening::relinking::relink_parts;
use crate::app::state::State;
use crate::app::state::ask::{Ask, ProjectAsk};
use crate::app::state::life::{Event, Goal};
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::Kind;
use crate::app::state::session::Session;
use crate::app::trip::import_dropped;
use crate::app::work::Work;
use crate::app::work::jobs::{Arrival, arrival};
use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::io::lock::ProjectLock;
use crate::io::project::{PROJECT_FILE, read_project};
use crate::io::recovery::UnsavedChanges;
use crate::recipe::discover::Part;
use crate::recipe::relink::{gone, missing_photos, parts_of};

/// What is going on around opening, making and leaving projects.
#[derive(Default)]
pub struct Opening {
    looking: Looking,
    assistant: Option<Assistant>,
    relinking: Option<Relinking>,
    held: Option<Held>,
    /// The project that is opened next is new: it is checked.
    check_next: bool,
    /// Grows whenever a project is left: what was being opened before is not wanted any more.
    round: u64,
    /// The path being typed where no dialog of the system is at hand; the welcome page has it, too.
    pub typed: String,
    typing: bool,
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
}

impl Opening {
    /// A dialog waits for an answer: keys are for it.
    pub fn is_asking(&self) -> bool {
        self.assistant.is_some() || self.relinking.is_some() || self.held.is_some() || self.typing
    }
}

/// What happens without anybody asking: called once a frame, before anything is drawn.
pub fn watch_opening(state: &mut State, work: &mut Work) {
    take_chosen(state, work);
    watch_held(state, work);
    happens(state, work, Event::Frame);
    keep_looking(state, work);
    take_changes(state, work);
}

/// What was dropped on the window.
pub fn take_dropped(state: &mut State, work: &mut Work, paths: &[PathBuf]) {
    if state.asks() {
        return;
    }
    if !import_dropped(state, work, paths) {
        paths.iter().for_each(|path| take_path(state, work, path));
    }
}

impl State {
    /// Shows which files of the open project are missing.
    pub fn show_missing(&mut self) {
        let Some(session) = &self.session else { return };
        let parts = parts_of(&session.folder, &session.opened.project);
        let missing = missing_photos(&session.opened, &parts);
        self.opening.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
    }
}

/// Does what a dialog wants.
pub fn grant_opening(state: &mut State, work: &mut Work, wish: Wish) {
    match wish {
        Wish::New(root) => start_assistant(state, work, root.as_deref()),
        Wish::Take(path) => take_path(state, work, &path),
        Wish::Choose(purpose) => choose(work, purpose),
        Wish::Search => search_site(state, work),
        Wish::Create => happens(state, work, Event::Leave(Goal::Create)),
        Wish::Cancel => cancel_dialogs(state, work),
        Wish::TryAgain(folder) => open_project(state, work, folder),
        Wish::Relink => relink_parts(state, work),
    }
}

fn cancel_dialogs(state: &mut State, work: &mut Work) {
    if state.opening.assistant.take().is_some() {
        work.jobs.stop_kind(&mut state.running, Kind::Search);
    }
    work.jobs.stop_kind(&mut state.running, Kind::Paths);
    (state.opening.relinking, state.opening.held) = (None, None);
    state.opening.typing = false;
}

/// A project is opened; anything else belongs to a new one.
fn take_path(state: &mut State, work: &mut Work, path: &Path) {
    match project_at(path) {
        Some(folder) => happens(state, work, Event::Leave(Goal::Open(folder))),
        None => start_assistant(state, work, Some(path)),
    }
}

/// Opens the project in `folder` instead of the one that is open; asks first where something is not saved or
/// still written.
pub fn open_project(state: &mut State, work: &mut Work, folder: PathBuf) {
    happens(state, work, Event::Leave(Goal::Open(folder)));
}

/// Opens the project in `folder`: all that had to be asked was asked.
pub fn open_now(state: &mut State, work: &mut Work, folder: PathBuf) {
    let folder = project_at(&folder).unwrap_or(folder);
    close_project(state, work);
    cancel_dialogs(state, work);
    let name = format!("Opening {}", folder.display());
    let round = state.opening.round;
    work.jobs.start(&mut state.running, Kind::Open, name, move |task| {
        let arrival: Arrival = match Session::open(&folder, task) {
            Ok(opened) => {
                let opened = ProjectAsk::Opened(Box::new(opened));
                Box::new(move |_| vec![opened.into()])
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => obstacle(folder, error)?,
        };
        Ok(if_wanted(round, arrival))
    });
}

/// A project was opened, and what was not saved last time was found.
pub fn arrived(state: &mut State, work: &mut Work, (session, recovered): (Session, Option<UnsavedChanges>)) {
    opened(state, work, session);
    recovered.into_iter().for_each(|recovered| offer_recovery(state, work, recovered));
}

/// A project is left, or none was open: what is on its way comes too late.
pub fn forget_opening(state: &mut State, work: &mut Work) {
    state.opening.round += 1;
    work.on_disk = None;
}

/// What belongs to a project that was just opened, beside showing it.
pub fn welcome_session(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let parts = parts_of(&session.folder, &session.opened.project);
    // Cameras often name more photos than are used; one that has been built before is missed.
    let built = |photo: &String| session.folder.join("stacks").join(file_name_of_photo(photo)).exists();
    let missing = missing_photos(&session.opened, &parts);
    if missing.iter().any(built) {
        state.opening.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
    }
    if std::mem::take(&mut state.opening.check_next) {
        check_project(state, work);
    }
    watch_disk(state, work);
}

/// Comes in only where no project was left since `round`.
fn if_wanted(round: u64, arrival: Arrival) -> Arrival {
    Box::new(move |state| if state.opening.round == round { arrival(state) } else { Vec::new() })
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
        return Ok(arrival(move |state| state.opening.held = Some(Held::by(folder, holder))));
    }
    let Ok(project) = read_project(&folder) else { return Err(error) };
    let parts = parts_of(&folder, &project);
    let gone = gone(&parts);
    if gone.is_empty() {
        return Err(error);
    }
    Ok(arrival(move |state| {
        let names: Vec<&str> = gone.iter().map(|part: &Part| part.name()).collect();
        let text = format!("{}: {} not where they were", folder.display(), names.join(", "));
        state.notes.add(Note::new(Weight::Problem, text));
        state.opening.relinking = Some(Relinking::of_parts(folder, parts, &gone));
    }))
}

/// Draws the dialogs that are open.
pub fn opening_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    let mut wishes = Vec::new();
    assistant_ui::assistant_ui(editor, context, &mut wishes);
    relinking::relinking_ui(editor, context, &mut wishes);
    held::held_ui(editor, context, &mut wishes);
    chooser::typing_ui(editor, context, &mut wishes);
    asks.extend(wishes.into_iter().map(|it| Ask::Project(ProjectAsk::Dialog(it))));
}
