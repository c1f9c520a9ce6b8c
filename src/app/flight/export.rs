//! Exports a picture of the view, or a video of the flight; a job orders the frames from the view's painter.

use std::path::{Path, PathBuf};

use eframe::egui::{Button, Context, DragValue, RichText, TextEdit, Ui, vec2};

use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::widget::dialog::{Dialog, Keys};
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::app::work::painter::Painter;
use crate::geometry::{Pinhole, Pose};
use crate::projection::Quality;
use crate::recipe::render::{Appearance, RenderOptions, RenderReport, VideoOptions, render};
use crate::recipe::views::RequestedView;
use crate::task::Task;

/// The options of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// Whether a video of the flight is made rather than a picture of the view.
    pub film: bool,
    folder: String,
    name: String,
    size: [u32; 2],
}

impl Export {
    /// Returns the path of the file that is made.
    fn file(&self) -> PathBuf {
        let name = if self.film { self.name.clone() } else { format!("{}.png", self.name) };
        Path::new(&self.folder).join(name)
    }
}

/// Returns the suggested name, with a number where the folder already has such a file.
fn free_name(folder: &Path, export: &Export) -> String {
    let wanted = Path::new(&export.name);
    let stem = wanted.file_stem().unwrap_or_default().to_string_lossy();
    let ending = wanted.extension().map(|it| format!(".{}", it.to_string_lossy())).unwrap_or_default();
    let name = |number: u32| match number {
        1 => export.name.clone(),
        number => format!("{stem}-{number}{ending}"),
    };
    let of = |name: String| Export { folder: folder.display().to_string(), name, ..export.clone() };
    let is_free = |name: &String| !of(name.clone()).file().exists();
    (1..).map(name).find(is_free).unwrap_or_else(|| export.name.clone())
}

impl Editor {
    pub(in crate::app) fn export_ui(&mut self, context: &Context) {
        let Some(mut export) = self.state.flights.export.take() else { return };
        let dialog = Dialog::new("export picture", 440.0);
        let asked = dialog.show(context, |ui, keys| questions(ui, keys, &mut export));
        match asked.inner {
            Some(true) => export_views(&mut self.state, &mut self.work, &export),
            Some(false) => (),
            None if asked.escaped => (),
            None => self.state.flights.export = Some(export),
        }
    }
}

impl State {
    /// Opens the dialog for a picture of the view.
    pub fn ask_still(&mut self) {
        let [width, height] = self.space.size_px();
        // The default size is twice that of the view, with even sides, as video codecs need.
        let size = [width, height].map(|side| (2 * side).min(7680) & !1);
        self.ask_export(Export { film: false, folder: String::new(), name: "view".into(), size });
    }

    /// Opens the dialog for a video of the flight.
    pub fn ask_film(&mut self) {
        let size = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.size));
        let Some(size) = size else { return };
        self.ask_export(Export { film: true, folder: String::new(), name: "flight.mp4".into(), size });
    }

    fn ask_export(&mut self, export: Export) {
        let Some(session) = &self.session else { return };
        let folder = session.folder.join("pictures");
        let name = free_name(&folder, &export);
        self.flights.export = Some(Export { folder: folder.display().to_string(), name, ..export });
    }

    fn views_of(&mut self, export: &Export) -> Option<Vec<RequestedView>> {
        let [width, height] = export.size;
        let view =
            |name: String, (camera, pose): (Pinhole, Pose)| RequestedView { name, camera, pose, photo: None };
        if !export.film {
            let here = (self.space.viewpoint.camera(width, height), self.space.viewpoint.pose);
            return Some(vec![view(export.name.clone(), here)]);
        }
        let session = self.session.as_ref()?;
        let mut path = session.opened.project.flight.clone()?;
        path.resize(export.size);
        match path.flight(session.scene_frame.up) {
            Ok(flight) => {
                let frames = flight.frames(path.fps).into_iter().zip(1..);
                Some(frames.map(|(camera, number)| view(format!("frame-{number:05}"), camera)).collect())
            }
            Err((place, found)) => {
                self.tell(Note::new(Weight::Problem, format!("the flight, {place}: {found}")));
                None
            }
        }
    }
}

/// Starts rendering the picture or video of a dialog.
pub fn export_views(state: &mut State, work: &mut Work, export: &Export) {
    let Some(views) = state.views_of(export) else { return };
    let Some(session) = &state.session else { return };
    let Some(orders) = work.painter.as_ref().map(Painter::orders) else { return };
    let look = Appearance { quality: Quality::Final, ..state.space.look.clone() };
    let out = PathBuf::from(&export.folder);
    let fps = session.opened.project.flight.as_ref().map_or(25.0, |path| path.fps);
    // The background of a video is black where nothing is textured.
    let film = export.film.then(|| VideoOptions { file: out.join(&export.name), fps, background: [0; 3] });
    let options = RenderOptions { out, film, film_alone: true };
    let name = if export.film { "Making a film" } else { "Making a picture" };
    work.jobs.start(&mut state.running, JobKind::Render, name, move |task| {
        let mut draw =
            |view: &RequestedView, task: &Task| orders.picture(look.shot(view.camera, view.pose), task);
        let report = render(&views, &mut draw, &options, task)?;
        let notes = notes_of_report(&report);
        Ok(arrival(move |state| notes.into_iter().for_each(|note| state.tell(note))))
    });
}

/// Draws the dialog; returns true to export, false to cancel.
fn questions(ui: &mut Ui, keys: &mut Keys, export: &mut Export) -> Option<bool> {
    let title = if export.film { "Make a film of the flight" } else { "Make a picture of the view" };
    ui.label(RichText::new(title).heading());
    ui.add_space(6.0);
    let label = ui.label("Into the folder");
    ui.add(TextEdit::singleline(&mut export.folder).desired_width(f32::INFINITY)).labelled_by(label.id);
    let label =
        ui.label(if export.film { "File of the film (.mp4, .mkv or .apng)" } else { "Name of the picture" });
    ui.add(TextEdit::singleline(&mut export.name).desired_width(f32::INFINITY)).labelled_by(label.id);
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut export.size[0]).range(16..=16_384).suffix(" px wide"));
        ui.add(DragValue::new(&mut export.size[1]).range(16..=16_384).suffix(" px high"));
    });
    let is_video = export.film && !export.name.to_lowercase().ends_with(".apng");
    if is_video && export.size.iter().any(|side| side % 2 == 1) {
        let [width, height] = export.size.map(|side| side & !1);
        ui.weak(format!("A film in this format has even sides: {width} × {height} px."));
    }
    let is_there = !export.name.trim().is_empty() && export.file().exists();
    if is_there {
        let text = format!(
            "{} is there already. As it was made here it is replaced; changed by somebody it stays, and the new one gets \
             a number. Another name keeps both.",
            export.file().display()
        );
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        let ready = !export.folder.trim().is_empty() && !export.name.trim().is_empty();
        let word = if is_there { "Make anyway" } else { "Make" };
        let make = Button::new(RichText::new(word).strong()).min_size(vec2(96.0, 28.0));
        let make = ui.add_enabled(ready, make);
        // A key alone never replaces an existing file.
        let pressed = if is_there { make.clicked() } else { keys.press(&make) };
        if pressed {
            return Some(true);
        }
        ui.add(Button::new("Cancel").min_size(vec2(96.0, 28.0))).clicked().then_some(false)
    })
    .inner
}

fn notes_of_report(report: &RenderReport) -> Vec<Note> {
    let mut notes: Vec<Note> = Vec::new();
    for (view, error) in &report.failed {
        notes.push(Note::about(Weight::Problem, view, error.to_string()));
    }
    if let Some(film) = &report.film {
        notes.push(Note::new(Weight::Info, format!("Film made: {}", film.display())));
    } else if let [one] = &report.done[..] {
        notes.push(Note::new(Weight::Info, format!("Picture made: {}", one.path.display())));
    } else if !report.done.is_empty() {
        notes.push(Note::new(Weight::Info, format!("{} pictures made", report.done.len())));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_a_file_has_is_not_proposed_again() {
        let folder = tempfile::tempdir().unwrap();
        let [still, film] = [(false, "view"), (true, "flight.mp4")].map(|(film, name)| Export {
            film,
            folder: String::new(),
            name: name.into(),
            size: [64, 64],
        });
        let names = || [&still, &film].map(|export| free_name(folder.path(), export));
        assert_eq!(names(), ["view", "flight.mp4"]);
        for file in ["view.png", "view-2.png", "flight.mp4"] {
            std::fs::write(folder.path().join(file), "made").unwrap();
        }
        assert_eq!(names(), ["view-3", "flight-2.mp4"]);
    }
}
