//! Files and folders chosen in a dialog of the system. Where there is none, the path is typed.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use eframe::egui::{Context, RichText};

use super::place::line;
use super::{DialogRequest, typed_path};
use crate::app::action::masks::repairing::bring_mask;
use crate::app::editor::Editor;
use crate::app::opening::assistant::start_assistant;
use crate::app::opening::open_project;
use crate::app::opening::relinking::copy_photo;
use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::widget::dialog::Dialog;
use crate::app::work::Work;
use crate::recipe::discover::SitePart;
use crate::recipe::open::UnusableMask;

/// The purpose of a file dialog.
#[derive(Debug, Clone, PartialEq)]
pub enum Purpose {
    /// A project to open.
    Project,
    /// The site folder that the assistant searches.
    Site,
    /// A part of a new project, or the new path of a missing part.
    Part(SitePart),
    /// The folder of a new project.
    Folder,
    /// The file of a missing photo, by the photo's name.
    Photo(String),
    /// A file that replaces a mask that cannot be used.
    Mask(Box<UnusableMask>),
}

impl Purpose {
    fn title(&self) -> String {
        match self {
            Self::Project => "Open the folder of a project".into(),
            Self::Site => "The folder of a site: photos, cameras and a model".into(),
            Self::Part(part) => format!("{}: {}", part.name(), part.accepted()),
            Self::Folder => "An empty folder for the project".into(),
            Self::Photo(name) => format!("The file of {name}"),
            Self::Mask(it) => format!("The mask of {}: black is masked", it.photo.name),
        }
    }

    /// Shows the dialog and waits for the user.
    fn ask(&self) -> Option<PathBuf> {
        let dialog = rfd::FileDialog::new().set_title(self.title());
        match self {
            Self::Part(SitePart::Model) => dialog.add_filter("Models", &["obj", "gltf", "glb"]).pick_file(),
            Self::Photo(_) => dialog.pick_file(),
            Self::Mask(_) => dialog.add_filter("Masks", &["png"]).pick_file(),
            _ => dialog.pick_folder(),
        }
    }
}

/// A dialog that answers faster than a user could click was never shown.
const NEVER_SEEN: Duration = Duration::from_millis(400);

/// The file dialog that is open.
#[derive(Default)]
pub struct Chooser {
    waiting: Option<(Purpose, Instant, Receiver<Option<PathBuf>>)>,
}

impl State {
    fn without_dialog(&mut self, purpose: &Purpose) {
        if let Purpose::Mask(it) = purpose {
            return self.tell_place_of_mask(it);
        }
        self.opening.typing = *purpose == Purpose::Project;
        if !self.opening.typing {
            let text = "This desktop shows no dialog for files: type the path, or drop it on the window";
            self.tell(Note::new(Weight::Warning, text));
        }
    }
}

/// Opens a file dialog.
pub fn choose(work: &mut Work, purpose: Purpose) {
    let (send, receive) = channel();
    let (waker, asked) = (work.waker.clone(), purpose.clone());
    // The dialog blocks until the user answers, so it has a thread of its own.
    let ask = move || {
        let _ = send.send(asked.ask());
        waker.wake();
    };
    if std::thread::Builder::new().name("dialog".into()).spawn(ask).is_ok() {
        work.chooser.waiting = Some((purpose, Instant::now(), receive));
    }
}

/// Handles the answer of the file dialog.
pub fn take_chosen(state: &mut State, work: &mut Work) {
    let Some((purpose, since, receive)) = &work.chooser.waiting else { return };
    let (purpose, at_once) = (purpose.clone(), since.elapsed() < NEVER_SEEN);
    let chosen = match receive.try_recv() {
        Ok(chosen) => chosen,
        Err(TryRecvError::Disconnected) => None,
        Err(TryRecvError::Empty) => return,
    };
    work.chooser.waiting = None;
    match chosen {
        Some(path) => take_choice(state, work, purpose, path),
        None if at_once => state.without_dialog(&purpose),
        None => (),
    }
}

fn take_choice(state: &mut State, work: &mut Work, purpose: Purpose, path: PathBuf) {
    match purpose {
        Purpose::Project => open_project(state, work, path),
        Purpose::Site => start_assistant(state, work, Some(&path)),
        Purpose::Photo(name) => copy_photo(state, work, &name, &path),
        Purpose::Mask(it) => bring_mask(state, work, *it, path),
        Purpose::Folder => {
            if let Some(assistant) = &mut state.opening.assistant {
                assistant.goes_to(&path);
            }
        }
        Purpose::Part(part) => {
            if let Some(assistant) = &mut state.opening.assistant {
                assistant.places[part as usize].set(&path);
            } else if let Some(relinking) = &mut state.opening.relinking {
                relinking.found(part, &path);
            }
        }
    }
}

/// Draws the dialog for typing the path of a project, where there is no file dialog.
pub(super) fn typing_ui(editor: &mut Editor, context: &Context, requests: &mut Vec<DialogRequest>) {
    if !editor.state.opening.typing {
        return;
    }
    let answer = Dialog::new("type a path", 520.0).show(context, |ui, keys| {
        ui.heading("Open a project");
        ui.label("This desktop shows no dialog for folders. Type the path of a project's folder:");
        keys.begin_at(&line(ui, &mut editor.state.opening.typed, "Folder of the project", 500.0));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let path = typed_path(&editor.state.opening.typed);
            let there = path.is_dir();
            let open = ui.add_enabled(there, eframe::egui::Button::new(RichText::new("Open").strong()));
            if keys.press(&open) {
                requests.extend([DialogRequest::Cancel, DialogRequest::Take(path)]);
            }
            if ui.button("Cancel").clicked() {
                requests.push(DialogRequest::Cancel);
            }
        });
    });
    if answer.escaped {
        requests.push(DialogRequest::Cancel);
    }
}
