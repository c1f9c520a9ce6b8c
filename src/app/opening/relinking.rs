//! Missing parts of a project: shown, located, and the project updated with their new paths.

use std::path::{Path, PathBuf};

use eframe::egui::{Button, Context, RichText, ScrollArea, Ui};

use super::place::{PathField, part_found, part_line, wrongs};
use super::{DialogRequest, Purpose};
use crate::app::editor::Editor;
use crate::app::opening::open_project;
use crate::app::state::State;
use crate::app::state::ask::{Ask, ProjectAsk};
use crate::app::state::running::JobKind;
use crate::app::widget::dialog::{Dialog, Keys, scrolled};
use crate::app::work::Work;
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::recipe::discover::{SitePart, SiteParts};
use crate::recipe::relink::{bring_photo, guess, relink, relinked};

/// The missing parts of a project, and their possible new paths.
pub struct Relinking {
    folder: PathBuf,
    was: SiteParts,
    /// The paths in the order of [`SitePart::ALL`]; a part that is not missing has its current path.
    places: [PathField; 3],
    /// The parts that are missing.
    asked: Vec<SitePart>,
    /// The parts whose new paths were guessed and not confirmed.
    guessed: Vec<SitePart>,
    /// The photos that are missing in the photos' folder.
    photos: Vec<String>,
    errors: Vec<String>,
}

impl Relinking {
    /// Makes the dialog for missing parts: the project cannot be opened.
    pub fn of_parts(folder: PathBuf, was: SiteParts, gone: &[SitePart]) -> Self {
        let mut relinking = Self::new(folder, was, gone.to_vec(), Vec::new());
        relinking.guess_others(&[]);
        relinking
    }

    /// Makes the dialog for single missing photos of an open project.
    pub fn of_photos(folder: PathBuf, was: SiteParts, photos: Vec<String>) -> Self {
        Self::new(folder, was, vec![SitePart::Photos], photos)
    }

    fn new(folder: PathBuf, was: SiteParts, asked: Vec<SitePart>, photos: Vec<String>) -> Self {
        let place = |part: SitePart| {
            let mut place = PathField { searched: true, ..PathField::default() };
            if !asked.contains(&part) || !photos.is_empty() {
                place.set(was.path(part));
            }
            place
        };
        let places = SitePart::ALL.map(place);
        Self { folder, was, places, asked, guessed: Vec::new(), photos, errors: Vec::new() }
    }

    fn parts(&self) -> SiteParts {
        let [photos, cameras, model] = [0, 1, 2].map(|part: usize| self.places[part].path());
        SiteParts { photos, cameras, model }
    }

    /// Sets the new path of a part; the others are guessed from it.
    pub fn found(&mut self, part: SitePart, path: &Path) {
        self.places[part as usize].set(path);
        self.settled(part);
    }

    fn settled(&mut self, part: SitePart) {
        self.guessed.retain(|other| *other != part);
        let moved = (self.was.path(part).to_path_buf(), self.places[part as usize].path());
        if moved.0 != moved.1 && moved.1.exists() {
            self.guess_others(&[moved]);
        }
    }

    /// Guesses the paths of parts that the user has not located.
    fn guess_others(&mut self, moved: &[(PathBuf, PathBuf)]) {
        let project = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        for part in self.asked.clone() {
            let place = &mut self.places[part as usize];
            if !place.typed.is_empty() && !self.guessed.contains(&part) {
                continue;
            }
            if let Some(path) = guess(self.was.path(part), moved, &project, Path::exists) {
                place.set(&path);
                self.guessed.retain(|other| *other != part);
                self.guessed.push(part);
            }
        }
    }
}

impl State {
    fn brought(&mut self, name: &str, brought: Result<()>) -> Vec<Ask> {
        let Some(relinking) = &mut self.opening.relinking else { return Vec::new() };
        match brought {
            Ok(()) => relinking.photos.retain(|photo| photo != name),
            Err(error) => relinking.errors.push(error.to_string()),
        }
        let is_whole = relinking.photos.is_empty();
        is_whole.then(|| ProjectAsk::Open(relinking.folder.clone()).into()).into_iter().collect()
    }
}

/// Starts copying the file of a photo to where the project expects it.
pub fn copy_photo(state: &mut State, work: &mut Work, name: &str, file: &Path) {
    let Some(relinking) = &mut state.opening.relinking else { return };
    relinking.errors.clear();
    let (photos, name, file) = (relinking.was.photos.clone(), name.to_owned(), file.to_path_buf());
    work.jobs.start(&mut state.running, JobKind::Import, format!("Copying {name}"), move |_| {
        let brought = bring_photo(&photos, &name, &file);
        Ok(Box::new(move |state| state.brought(&name, brought)))
    });
}

/// Updates the project with the new paths: an open one by a step that can be undone, one that cannot be opened in its
/// file.
pub fn relink_parts(state: &mut State, work: &mut Work) {
    let Some(relinking) = &state.opening.relinking else { return };
    let (folder, parts) = (relinking.folder.clone(), relinking.parts());
    let open = state.session.as_ref().filter(|session| session.folder == folder);
    let message = match open {
        Some(session) => relinked(session.history.present(), &folder, &parts).map(Some),
        None => ProjectLock::take(&folder).and_then(|_lock| relink(&folder, &parts)).map(|()| None),
    };
    match message {
        Ok(Some(project)) => {
            state.opening.relinking = None;
            state.edit("new places of files", project, None);
        }
        Ok(None) => open_project(state, work, folder),
        Err(error) => {
            if let Some(relinking) = &mut state.opening.relinking {
                relinking.errors = vec![error.to_string()];
            }
        }
    }
}

/// Draws the dialog.
pub(super) fn relinking_ui(editor: &mut Editor, context: &Context, requests: &mut Vec<DialogRequest>) {
    let Some(mut relinking) = editor.state.opening.relinking.take() else { return };
    // Escape first leaves the text field.
    let types = context.text_edit_focused();
    let answer = Dialog::new("relink", 680.0).show(context, |ui, keys| {
        scrolled(ui, |ui| match relinking.photos.is_empty() {
            true => parts_ui(editor, &mut relinking, ui, requests),
            false => photos_ui(editor, &mut relinking, ui, requests),
        });
        wrongs(ui, &relinking.errors);
        ui.add_space(8.0);
        buttons(editor, &relinking, ui, keys, requests);
    });
    if answer.escaped && !types {
        requests.push(DialogRequest::Cancel);
    }
    editor.state.opening.looking.want(relinking.parts(), context.input(|input| input.time));
    editor.state.opening.relinking = Some(relinking);
}

fn parts_ui(state: &State, relinking: &mut Relinking, ui: &mut Ui, requests: &mut Vec<DialogRequest>) {
    ui.heading("Parts of the project have moved");
    ui.label(format!(
        "{} is whole, but what it is made of is not where it was. Say where it is now; what belongs with it is found \
         by itself.",
        relinking.folder.display()
    ));
    asked_ui(state, relinking, ui, requests);
}

fn asked_ui(state: &State, relinking: &mut Relinking, ui: &mut Ui, requests: &mut Vec<DialogRequest>) {
    for part in relinking.asked.clone() {
        ui.add_space(6.0);
        let place = &mut relinking.places[part as usize];
        let before = place.typed.clone();
        part_line(ui, part, place, requests);
        if place.typed != before {
            relinking.settled(part);
        }
        let place = &relinking.places[part as usize];
        ui.indent(("was", part.name()), |ui| {
            ui.weak(format!("It was {}", relinking.was.path(part).display()));
            if relinking.guessed.contains(&part) {
                ui.weak("Guessed: look whether it is the right one.");
            }
        });
        part_found(ui, part, place, state.opening.looking.look.as_ref());
    }
}

fn photos_ui(state: &State, relinking: &mut Relinking, ui: &mut Ui, requests: &mut Vec<DialogRequest>) {
    ui.heading("Photos are missing");
    ui.label(
        "The cameras name these photos, and they are not in the photos' folder. All else works without them.",
    );
    ui.add_space(4.0);
    ScrollArea::vertical().max_height(180.0).show(ui, |ui| {
        for photo in &relinking.photos {
            ui.horizontal(|ui| {
                ui.label(photo);
                let button = ui.button("Its file…").on_hover_text(format!(
                    "Chooses the file of {photo}; a copy of it is put into the photos' folder."
                ));
                if button.clicked() {
                    requests.push(DialogRequest::Choose(Purpose::Photo(photo.clone())));
                }
            });
        }
    });
    ui.label("Or all photos are in another folder now:");
    asked_ui(state, relinking, ui, requests);
}

fn buttons(
    state: &State,
    relinking: &Relinking,
    ui: &mut Ui,
    keys: &mut Keys,
    requests: &mut Vec<DialogRequest>,
) {
    ui.horizontal(|ui| {
        let whole = state.opening.looking.now().is_some_and(|look| look.is_whole());
        let moved = relinking.parts() != relinking.was;
        let button = Button::new(RichText::new("Use these places").strong()).min_size([150.0, 30.0].into());
        let response = ui.add_enabled(whole && moved && !state.running.runs(JobKind::Open), button);
        let response = response.on_hover_text("The project is told of them and opened.");
        let response = response.on_disabled_hover_text("Something is still missing, or nothing has changed.");
        if keys.press(&response) {
            requests.push(DialogRequest::Relink);
        }
        let again = Button::new("Try again").min_size([90.0, 30.0].into());
        if ui.add(again).on_hover_text("Opens the project as it is: the files are back.").clicked() {
            requests.push(DialogRequest::TryAgain(relinking.folder.clone()));
        }
        if ui.add(Button::new("Leave it").min_size([80.0, 30.0].into())).clicked() {
            requests.push(DialogRequest::Cancel);
        }
    });
}
