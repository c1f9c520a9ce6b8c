//! Opening the dialogs of the round trip, and taking in what was chosen in them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::dialogs::{DialogPurpose, ExportDialog, ImportDialog, LAYERS};
use crate::state::State;
use quadratura_document::export_record::ExportFormat;

impl State {
    /// Opens the import dialog.
    pub fn choose_imports(&mut self) {
        self.round_trip
            .dialogs
            .import
            .get_or_insert_with(|| ImportDialog { paths: vec![String::new()], ..ImportDialog::default() });
    }

    /// Opens the export dialog.
    pub fn choose_export(&mut self) {
        self.round_trip.dialogs.export.get_or_insert_with(|| ExportDialog {
            format: ExportFormat::Psd,
            program: None,
            folder: LAYERS.into(),
            photos: BTreeSet::new(),
            guides: true,
            provenance: false,
            even: false,
            tiles: false,
            done: None,
            report: Vec::new(),
        });
    }

    /// Puts the paths that were chosen in a system dialog where they are wanted; nothing where none was chosen.
    pub fn take_chosen(&mut self, wanted: DialogPurpose, chosen: &[PathBuf]) {
        let Some(first) = chosen.first() else { return };
        let text = first.display().to_string();
        match wanted {
            DialogPurpose::Layered => {
                if let Some(dialog) = &mut self.round_trip.dialogs.import {
                    dialog.paths = chosen.iter().map(|path| path.display().to_string()).collect();
                }
            }
            DialogPurpose::ExportFolder => {
                if let Some(dialog) = &mut self.round_trip.dialogs.export {
                    dialog.folder = text;
                }
            }
            DialogPurpose::RenderFolder => {
                if let Some(dialog) = &mut self.flights.export {
                    dialog.folder = text;
                }
            }
            DialogPurpose::ImageFile | DialogPurpose::PageFolder => {
                if let Some(dialog) = &mut self.dialogs.save_image {
                    dialog.path = text;
                }
            }
            DialogPurpose::OrthoFolder => {
                if let Some(dialog) = &mut self.dialogs.orthophoto {
                    dialog.folder = text;
                }
            }
            DialogPurpose::PublishFolder => {
                if let Some(dialog) = &mut self.dialogs.publish {
                    dialog.folder = text;
                }
            }
            DialogPurpose::Program => self.settings.image_editor.program = text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_exports::handover::HandoverFormat;

    #[test]
    fn an_import_begins_with_one_empty_line_and_asking_again_keeps_what_was_typed() {
        let mut state = State::default();
        state.choose_imports();
        let dialog = state.round_trip.dialogs.import.as_mut().unwrap();
        assert_eq!(dialog.paths, [""]);
        dialog.paths[0] = "a.psd".into();
        state.choose_imports();
        assert_eq!(state.round_trip.dialogs.import.unwrap().paths, ["a.psd"]);
    }

    #[test]
    fn an_export_needs_a_folder_and_a_folder_of_files_keeps_the_colours_of_the_stack() {
        let mut state = State::default();
        state.choose_export();
        let dialog = state.round_trip.dialogs.export.as_mut().unwrap();
        assert_eq!(dialog.problem(), None);
        dialog.folder = "  ".into();
        assert_eq!(dialog.problem(), Some("choose a folder to export to"));
        (dialog.folder, dialog.even) = ("layers".into(), true);
        assert_eq!(dialog.problem(), None);
        dialog.format = ExportFormat::Folder;
        assert!(dialog.problem().is_some_and(|reason| reason.contains("matched exposure")));
        dialog.choose(Some(HandoverFormat::Glb));
        assert_eq!((dialog.problem(), dialog.folder.as_str()), (None, "glb"));
        dialog.folder = "for the museum".into();
        dialog.choose(Some(HandoverFormat::Usd));
        assert_eq!(dialog.folder, "for the museum");
    }

    #[test]
    fn chosen_paths_go_where_they_are_wanted_and_nowhere_when_that_is_closed() {
        let mut state = State::default();
        let chosen: Vec<PathBuf> = vec!["a.psd".into(), "b.psd".into()];
        state.take_chosen(DialogPurpose::Layered, &chosen);
        state.take_chosen(DialogPurpose::ExportFolder, &chosen);
        assert!(!state.round_trip.dialogs.is_open());
        state.choose_imports();
        state.choose_export();
        state.take_chosen(DialogPurpose::Layered, &chosen);
        state.take_chosen(DialogPurpose::ExportFolder, &chosen[1..]);
        state.take_chosen(DialogPurpose::Program, &chosen);
        assert_eq!(state.round_trip.dialogs.import.as_ref().unwrap().paths, ["a.psd", "b.psd"]);
        assert_eq!(state.round_trip.dialogs.export.as_ref().unwrap().folder, "b.psd");
        assert_eq!(state.settings.image_editor.program, "a.psd");
    }

    #[test]
    fn a_dialog_that_was_left_without_a_choice_changes_nothing() {
        let mut state = State::default();
        state.settings.image_editor.program = "paint".into();
        state.choose_imports();
        for wanted in [DialogPurpose::Layered, DialogPurpose::ExportFolder, DialogPurpose::Program] {
            state.take_chosen(wanted, &[]);
        }
        assert_eq!(state.settings.image_editor.program, "paint");
        assert_eq!(state.round_trip.dialogs.import.unwrap().paths, [""]);
    }
}
