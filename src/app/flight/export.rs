//! A picture of the view, or a film of the flight, ordered of the view's painter by a job.

use std::path::PathBuf;

use eframe::egui::{Button, Context, DragValue, Id, Modal, RichText, TextEdit, Ui, vec2};

use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::app::notes::{Note, Weight};
use crate::app::painter::Painter;
use crate::geometry::{Pinhole, Pose};
use crate::projection::Quality;
use crate::recipe::render::{FilmOptions, Look, RenderOptions, RenderReport, render};
use crate::recipe::views::View;
use crate::task::Task;

/// What is about to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// A film of the flight rather than a picture of the view.
    pub film: bool,
    folder: String,
    name: String,
    size: [u32; 2],
}

impl Editor {
    /// Asks how a picture of the view is to be.
    pub fn ask_still(&mut self) {
        let [width, height] = self.space.size_px();
        // As the view is, at twice its size and even sides, as films want them.
        let size = [width, height].map(|side| (2 * side).min(7680) & !1);
        self.ask_export(Export { film: false, folder: String::new(), name: "view".into(), size });
    }

    /// Asks how a film of the flight is to be.
    pub fn ask_film(&mut self) {
        let size = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.size));
        let Some(size) = size else { return };
        self.ask_export(Export { film: true, folder: String::new(), name: "flight.mp4".into(), size });
    }

    fn ask_export(&mut self, export: Export) {
        let Some(session) = &self.session else { return };
        let folder = session.folder.join("pictures").display().to_string();
        self.flights.export = Some(Export { folder, ..export });
    }

    pub(in crate::app) fn export_ui(&mut self, context: &Context) {
        let Some(mut export) = self.flights.export.take() else { return };
        let mut answer = None;
        let modal = Modal::new(Id::unique("export picture")).show(context, |ui| {
            ui.set_width(440.0);
            answer = questions(ui, &mut export);
        });
        match answer {
            Some(true) => self.export(&export),
            Some(false) => (),
            None if modal.should_close() => (),
            None => self.flights.export = Some(export),
        }
    }

    fn export(&mut self, export: &Export) {
        let Some(views) = self.views_of(export) else { return };
        let Some(session) = &self.session else { return };
        let Some(orders) = session.painter.as_ref().map(Painter::orders) else { return };
        let look = Look { quality: Quality::Final, ..self.space.look.clone() };
        let out = PathBuf::from(&export.folder);
        let fps = session.opened.project.flight.as_ref().map_or(25.0, |path| path.fps);
        // Black behind what is not textured, as a screen is where nothing is.
        let film = export.film.then(|| FilmOptions { file: out.join(&export.name), fps, background: [0; 3] });
        let options = RenderOptions { out, film };
        let name = if export.film { "Making a film" } else { "Making a picture" };
        self.jobs.start(Kind::Render, name, move |task| {
            let mut draw = |view: &View, task: &Task| orders.picture(look.shot(view.camera, view.pose), task);
            let report = render(&views, &mut draw, &options, task)?;
            let notes = told(&report);
            Ok(Box::new(move |editor| notes.into_iter().for_each(|note| editor.tell(note))))
        });
    }

    fn views_of(&mut self, export: &Export) -> Option<Vec<View>> {
        let [width, height] = export.size;
        let view = |name: String, (camera, pose): (Pinhole, Pose)| View { name, camera, pose, photo: None };
        if !export.film {
            let here = (self.space.viewpoint.camera(width, height), self.space.viewpoint.pose);
            return Some(vec![view(export.name.clone(), here)]);
        }
        let session = self.session.as_ref()?;
        let mut path = session.opened.project.flight.clone()?;
        path.resize(export.size);
        match path.flight(session.ground.up) {
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

/// Draws the questions; true to make it, false not to.
fn questions(ui: &mut Ui, export: &mut Export) -> Option<bool> {
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
    ui.weak("Nothing that somebody made or changed is overwritten.");
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        let ready = !export.folder.trim().is_empty() && !export.name.trim().is_empty();
        let make = Button::new(RichText::new("Make").strong()).min_size(vec2(96.0, 28.0));
        if ui.add_enabled(ready, make).clicked() {
            return Some(true);
        }
        ui.add(Button::new("Cancel").min_size(vec2(96.0, 28.0))).clicked().then_some(false)
    })
    .inner
}

fn told(report: &RenderReport) -> Vec<Note> {
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
