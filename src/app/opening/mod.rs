//! The dialogs for opening, creating and relinking projects: chosen or dropped paths, projects open elsewhere, missing
//! parts, and leaving without losing what runs.

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
use crate::app::action::round_trip::import_dropped;
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
use crate::app::state::life::{Goal, LifeEvent};
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::jobs::{Arrival, arrival};
use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::io::lock::ProjectLock;
use crate::io::project::{PROJECT_FILE, read_project};
use crate::io::recovery::UnsavedChanges;
use crate::recipe::discover::SitePart;
use crate::recipe::relink::{gone, missing_photos, parts_of};

/// The state of opening, creating and leaving projects.
#[derive(Default)]
pub struct Opening {
    looking: Looking,
    assistant: Option<Assistant>,
    relinking: Option<Relinking>,
    held: Option<Held>,
    /// Whether the project that is opened next is new: it is checked then.
    check_next: bool,
    /// A counter that grows whenever a project is left: results of earlier rounds are dropped.
    round: u64,
    /// The path typed where there is no file dialog; the welcome page shows it, too.
    pub typed: String,
    typing: bool,
}

/// A request of one of the dialogs.
pub enum DialogRequest {
    /// Opens the assistant, and searches this folder for a site if there is one.
    New(Option<PathBuf>),
    /// Takes a dropped or typed path: a project is opened, anything else starts a new one.
    Take(PathBuf),
    /// Opens a file dialog.
    Choose(Purpose),
    /// Searches the site folder of the assistant.
    Search,
    /// Creates the project that the assistant describes.
    Create,
    /// Closes the open dialog.
    Cancel,
    /// Tries again to open the project.
    TryAgain(PathBuf),
    /// Updates the project with the new paths of its parts.
    Relink,
}

impl Opening {
    /// Returns whether a dialog is open: keys belong to it then.
    pub fn is_asking(&self) -> bool {
        self.assistant.is_some() || self.relinking.is_some() || self.held.is_some() || self.typing
    }
}

/// Runs the periodic checks of the dialogs; called once a frame, before drawing.
pub fn watch_opening(state: &mut State, work: &mut Work) {
    take_chosen(state, work);
    watch_held(state, work);
    happens(state, work, LifeEvent::Frame);
    keep_looking(state, work);
    take_changes(state, work);
}

/// Handles files and folders dropped on the window.
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

/// Handles a request of a dialog.
pub fn grant_opening(state: &mut State, work: &mut Work, request: DialogRequest) {
    match request {
        DialogRequest::New(root) => start_assistant(state, work, root.as_deref()),
        DialogRequest::Take(path) => take_path(state, work, &path),
        DialogRequest::Choose(purpose) => choose(work, purpose),
        DialogRequest::Search => search_site(state, work),
        DialogRequest::Create => happens(state, work, LifeEvent::Leave(Goal::Create)),
        DialogRequest::Cancel => cancel_dialogs(state, work),
        DialogRequest::TryAgain(folder) => open_project(state, work, folder),
        DialogRequest::Relink => relink_parts(state, work),
    }
}

fn cancel_dialogs(state: &mut State, work: &mut Work) {
    if state.opening.assistant.take().is_some() {
        work.jobs.stop_kind(&mut state.running, JobKind::Search);
    }
    work.jobs.stop_kind(&mut state.running, JobKind::Paths);
    (state.opening.relinking, state.opening.held) = (None, None);
    state.opening.typing = false;
}

/// Opens a project, or starts a new one with anything else.
fn take_path(state: &mut State, work: &mut Work, path: &Path) {
    match project_at(path) {
        Some(folder) => happens(state, work, LifeEvent::Leave(Goal::Open(folder))),
        None => start_assistant(state, work, Some(path)),
    }
}

/// Opens the project in `folder` in place of the current one; asks first about unsaved changes and running writes.
pub fn open_project(state: &mut State, work: &mut Work, folder: PathBuf) {
    happens(state, work, LifeEvent::Leave(Goal::Open(folder)));
}

/// Opens the project in `folder`, after all questions were answered.
pub fn open_now(state: &mut State, work: &mut Work, folder: PathBuf) {
    let folder = project_at(&folder).unwrap_or(folder);
    close_project(state, work);
    cancel_dialogs(state, work);
    let name = format!("Opening {}", folder.display());
    let round = state.opening.round;
    work.jobs.start(&mut state.running, JobKind::Open, name, move |task| {
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

/// Handles a project that was opened, with unsaved changes found from an earlier run.
pub fn arrived(state: &mut State, work: &mut Work, (session, recovered): (Session, Option<UnsavedChanges>)) {
    opened(state, work, session);
    recovered.into_iter().for_each(|recovered| offer_recovery(state, work, recovered));
}

/// Drops results that are on their way, because the project was left.
pub fn forget_opening(state: &mut State, work: &mut Work) {
    state.opening.round += 1;
    work.on_disk = None;
}

/// Starts everything that follows opening a project, beside showing it.
pub fn welcome_session(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let parts = parts_of(&session.folder, &session.opened.project);
    // Cameras often name more photos than are used; a photo that was built before is missing.
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

/// Drops an arrival where a project was left since `round`.
fn if_wanted(round: u64, arrival: Arrival) -> Arrival {
    Box::new(move |state| if state.opening.round == round { arrival(state) } else { Vec::new() })
}

/// Returns the project's folder, for a folder with a project or its file.
fn project_at(path: &Path) -> Option<PathBuf> {
    if path.file_name().is_some_and(|name| name == PROJECT_FILE) {
        return path.parent().map(PathBuf::from);
    }
    path.join(PROJECT_FILE).is_file().then(|| path.to_path_buf())
}

/// Turns an error of opening into a dialog, where the user can resolve it.
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
        let names: Vec<&str> = gone.iter().map(|part: &SitePart| part.name()).collect();
        let text = format!("{}: {} not where they were", folder.display(), names.join(", "));
        state.notes.add(Note::new(Weight::Problem, text));
        state.opening.relinking = Some(Relinking::of_parts(folder, parts, &gone));
    }))
}

/// Draws the open dialogs.
pub fn opening_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    let mut requests = Vec::new();
    assistant_ui::assistant_ui(editor, context, &mut requests);
    relinking::relinking_ui(editor, context, &mut requests);
    held::held_ui(editor, context, &mut requests);
    chooser::typing_ui(editor, context, &mut requests);
    asks.extend(requests.into_iter().map(|it| Ask::Project(ProjectAsk::Dialog(it))));
}
