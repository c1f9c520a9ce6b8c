//! Changes of state that follow from imports and exports that have ended.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use super::report::{ImportQuestion, Report, Way};
use super::shown_path;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::{counted, grouped};
use crate::state::panels::Tab;
use crate::state::request::{Request, RoundTripRequest};
use quadratura_document::paint::{PaintBook, PaintImport};
use quadratura_editing::export::Exported;
use quadratura_editing::import::Imported;
use quadratura_editing::import::pictures::ChangedLayer;
use quadratura_editing::import::report::LayerState;
use quadratura_exports::handover::HandedOver;
use quadratura_view::Picture;

impl State {
    /// Handles an import that has ended: reports its result, and updates all views.
    pub fn paint_came(&mut self, imported: Imported, spent: Duration, way: Way) -> Vec<Request> {
        let Some(session) = &self.session else { return Vec::new() };
        let folder = session.folder.clone();
        let failed =
            imported.failed.iter().map(|(_, problem)| Note::new(Weight::Problem, problem.to_string()));
        failed.collect::<Vec<_>>().into_iter().for_each(|note| self.notify(note));
        for file in &imported.files {
            let name = shown_path(&folder, &file.file);
            let painted = file.layers.iter().filter(|layer| layer.state != LayerState::Mask);
            let changed: u64 = painted.map(|layer| layer.changed).sum();
            let text = match changed {
                0 => format!("{name} contains no new paint"),
                1 => format!("{name} contains 1 pixel of new paint"),
                pixels => format!("{name} contains {} pixels of new paint", grouped(pixels)),
            };
            self.notes.add(Note::about(Weight::Info, &file.photo, text));
        }
        let questions = self.request_about(&imported);
        // A save without changes does not switch to another panel.
        if imported.files.is_empty() || (way == Way::Saved && imported.number.is_none()) {
            return questions;
        }
        let photos = imported.files.iter().map(|file| file.photo.clone()).collect();
        let number = imported.number;
        if let Some(number) = number {
            let files = imported.files.iter().map(|file| file.file.clone()).collect();
            let again = if let Way::ByHand { again } = way { again } else { None };
            self.remember_import(number, again, files, imported.masks.clone());
        }
        let book = imported.book.clone();
        self.round_trip.report = Some(Report { imported, spent, looks: Arc::default(), taken_back: false });
        self.settings.side = Tab::Paint;
        let looks = number.map(|number| RoundTripRequest::LookAtImport(number, book.clone()).into());
        let changed = RoundTripRequest::PaintChanged(photos, book.clone()).into();
        questions.into_iter().chain([changed]).chain(looks).collect()
    }

    /// Asks about the files in which so much has changed at once that nothing of them was imported; a file that is
    /// imported now is no question any more.
    fn request_about(&mut self, imported: &Imported) -> Vec<Request> {
        let read = |file: &PathBuf| {
            imported.files.iter().chain(&imported.questioned).any(|report| report.file == *file)
        };
        self.round_trip.questions.retain(|question| !read(&question.file));
        let mut requests = Vec::new();
        for report in &imported.questioned {
            let Some(question) = &report.question else { continue };
            let (file, found) = (report.file.clone(), question.found());
            self.notify(Note::about(Weight::Warning, &report.photo, format!("{}: {found}", file.display())));
            requests.push(RoundTripRequest::LookAtQuestion(file.clone()).into());
            self.round_trip.questions.push(ImportQuestion { file, found, pictures: None });
            self.settings.side = Tab::Paint;
        }
        requests
    }

    /// Adds the pictures to the question about a file.
    pub fn show_question(&mut self, file: &Path, pictures: [Picture; 2]) {
        let question = self.round_trip.questions.iter_mut().find(|question| question.file == file);
        if let Some(question) = question {
            question.pictures = Some(Arc::new(pictures));
        }
    }

    /// Adds the pictures of an import to its report, where that is still the last one.
    pub fn show_looks(&mut self, number: u32, changed: Vec<ChangedLayer>) {
        let report = self.round_trip.report.as_mut().filter(|report| report.imported.number == Some(number));
        if let Some(report) = report {
            report.looks = Arc::new(changed);
        }
    }

    /// Reports that an import cannot be undone any more.
    pub fn not_taken_back(&mut self, number: u32) {
        self.forget_import(number);
        let known = self.round_trip.history.iter().find(|import| import.number == number);
        let what = known.map_or_else(|| format!("Import {number}"), name_of);
        let text = format!("{what} can no longer be undone: other paint is on top of it, or it is too old");
        self.notify(Note::new(Weight::Problem, text));
    }

    /// Reports that an import was undone, and updates all views.
    pub fn taken_back(&mut self, import: PaintImport, book: Arc<PaintBook>) -> Vec<Request> {
        let files = match import.brush {
            Some(_) => "",
            None => ". The edited files do not change; saving one again imports it again",
        };
        let (what, pixels) = (name_of(&import), counted(import.pixels, "pixel"));
        let text = format!("{what} is undone: {pixels} of {} are restored{files}.", import.photos.join(", "));
        self.space.brush.undone(import.number);
        self.notify(Note::new(Weight::Info, text));
        if let Some(report) = &mut self.round_trip.report {
            report.taken_back |= report.imported.number == Some(import.number);
        }
        self.forget_masks_of(&import);
        vec![RoundTripRequest::PaintChanged(import.photos.into_iter().collect(), book).into()]
    }

    /// Updates the list of imports that can be undone, and the photos that have paint, from `book`.
    pub fn history_is(&mut self, book: &PaintBook) {
        self.round_trip.history = book.imports.clone();
        self.round_trip.painted = book.entries.iter().map(|entry| entry.photo.clone()).collect();
    }

    /// Reports an export that has ended.
    pub fn exported(&mut self, exported: &Exported, out: PathBuf) {
        for (photo, error) in &exported.failed {
            self.notify(Note::about(Weight::Problem, photo, error.to_string()));
        }
        let bytes: u64 = exported.done.iter().map(|done| done.bytes).sum();
        let (count, megabytes) = (exported.done.len(), bytes as f64 / 1e6);
        let photos = if count == 1 { "photo" } else { "photos" };
        let text = format!("Exported {count} {photos} to {}: {megabytes:.1} MB", out.display());
        self.notify(Note::new(Weight::Info, text.clone()));
        if let Some(dialog) = &mut self.round_trip.dialogs.export {
            (dialog.done, dialog.report) = (Some(out), vec![text]);
        }
    }

    /// Takes in an export for another program to a folder.
    pub fn handed_over(&mut self, handed: &HandedOver, out: PathBuf) {
        for spared in &handed.spared {
            let found = format!("{} was changed since its export and is kept", spared.display());
            self.notify(Note::new(Weight::Warning, found));
        }
        let bytes: u64 = handed.files.iter().map(|file| file.bytes).sum();
        let (count, megabytes) = (handed.files.len(), bytes as f64 / 1e6);
        let files = if count == 1 { "file" } else { "files" };
        let text = format!("Exported {count} {files} to {}: {megabytes:.1} MB", out.display());
        self.notify(Note::new(Weight::Info, text.clone()));
        if let Some(dialog) = &mut self.round_trip.dialogs.export {
            let baked = handed.baked.iter().map(|baked| {
                let shown = 100.0 * baked.coverage.photographed;
                format!(
                    "{} faces on {} pages; photos show {shown:.1} % of the texels",
                    baked.faces,
                    baked.pages.len()
                )
            });
            let left_out = handed.left_out.iter().map(|what| format!("Not exported: {what}"));
            let failed = handed.failed.iter().map(|what| format!("Failed: {what}"));
            dialog.report = std::iter::once(text).chain(failed).chain(baked).chain(left_out).collect();
            dialog.done = Some(out);
        }
    }
}

/// Returns what an import is, at the beginning of a sentence.
fn name_of(import: &PaintImport) -> String {
    match import.brush {
        Some(mode) => format!("The brush stroke ({})", mode.word()),
        None => format!("Import {}", import.number),
    }
}
