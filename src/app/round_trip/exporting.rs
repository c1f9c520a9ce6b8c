//! Exports started by the user: options, folder and photos.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::document::export_record::ExportFormat;
use crate::error::Error;
use crate::io::programs::show_folder;
use crate::recipe::colour::even_factors;
use crate::recipe::export::{ExportOptions, Exported, export, write_provenance};
use crate::scene::Photo;

/// The state of the export dialog.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportDialog {
    /// The format of the files.
    pub format: ExportFormat,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// The photos, by index; empty for all that have layers.
    pub photos: BTreeSet<usize>,
    /// Whether guides of hidden areas are exported.
    pub guides: bool,
    /// Whether pictures of provenance are exported beside the files.
    pub provenance: bool,
    /// Whether photos are exported with matched exposure, for viewing.
    pub even: bool,
    /// The folder of the last export made with this dialog.
    pub done: Option<PathBuf>,
}

impl ExportDialog {
    /// Returns the reason why the export is not possible.
    pub fn problem(&self) -> Option<&'static str> {
        if self.folder.trim().is_empty() {
            return Some("say which folder to export to");
        }
        let odd = self.even && self.format == ExportFormat::Folder;
        odd.then_some("a folder is exported as the stack is: choose another format for even colour")
    }
}

impl State {
    /// Opens the export dialog.
    pub fn choose_export(&mut self) {
        self.round_trip.export.get_or_insert_with(|| ExportDialog {
            format: ExportFormat::Psd,
            folder: "layers".into(),
            photos: BTreeSet::new(),
            guides: true,
            provenance: false,
            even: false,
            done: None,
        });
    }

    fn exported(&mut self, exported: &Exported, out: PathBuf) {
        for (photo, error) in &exported.failed {
            self.tell(Note::about(Weight::Problem, photo, error.to_string()));
        }
        let bytes: u64 = exported.done.iter().map(|done| done.bytes).sum();
        let (count, megabytes) = (exported.done.len(), bytes as f64 / 1e6);
        let photos = if count == 1 { "photo" } else { "photos" };
        let text = format!("Exported {count} {photos} to {}: {megabytes:.1} MB", out.display());
        self.tell(Note::new(Weight::Info, text));
        if let Some(dialog) = &mut self.round_trip.export {
            dialog.done = Some(out);
        }
    }

    /// Shows a folder in the system's file manager.
    pub fn show_folder(&mut self, folder: &std::path::Path) {
        if let Err(error) = show_folder(folder) {
            let said = |error: Error| format!("{}: it could not be shown: {error}", folder.display());
            self.tell(Note::new(Weight::Warning, said(error)));
        }
    }
}

/// Exports with the options of the dialog.
pub fn export_chosen(state: &mut State, work: &mut Work) {
    let (Some(dialog), Some(session)) = (state.round_trip.export.clone(), &state.session) else { return };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let decisions = session.history.present().decisions.clone();
    let out = folder.join(dialog.folder.trim());
    let chosen = |index: &usize| match dialog.photos.is_empty() {
        true => session.photos[*index].stack.is_some(),
        false => dialog.photos.contains(index),
    };
    let indices: Vec<usize> = (0..session.photos.len()).filter(chosen).collect();
    work.jobs.start(&mut state.running, JobKind::Export, "Exporting", move |task| {
        let photos: Vec<&Photo> = indices.iter().map(|index| &opened.site.photos[*index]).collect();
        let evened = match dialog.even {
            true => even_factors(&folder, &opened, task)?,
            false => BTreeMap::new(),
        };
        let options = ExportOptions {
            format: dialog.format,
            guides: dialog.guides,
            evened,
            decisions: Some(decisions.clone()),
            ..ExportOptions::default()
        };
        let exported = export(&folder, &photos, &out, &options, task)?;
        if dialog.provenance {
            write_provenance(&folder, &photos, &decisions, &out, task)?;
        }
        drop(lock);
        Ok(arrival(move |state| state.exported(&exported, out)))
    });
}
