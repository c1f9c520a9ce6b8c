//! `Edit in …`: opens a photo's stack in the installed image editor, or in the chosen one.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::shown_path;
use crate::app::state::State;
use crate::app::state::ask::RoundTripAsk;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::state::selection::Selection;
use crate::app::work::Work;
use crate::document::ImageLayer;
use crate::document::export_record::ExportFormat;
use crate::io::programs::{ImageEditor, check_program, image_editors, start_with};
use crate::recipe::editing::document_to_edit;
use crate::recipe::export::{ExportOptions, layer_name};

/// The choice of the image editor, stored from run to run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct EditorChoice {
    /// A supported image editor, which is located automatically; none for the program below.
    pub editor: Option<ImageEditor>,
    /// The path of another program.
    pub program: String,
    /// The format that the other program reads.
    pub format: ExportFormat,
}

impl Default for EditorChoice {
    fn default() -> Self {
        Self { editor: Some(ImageEditor::Gimp), program: String::new(), format: ExportFormat::Psd }
    }
}

/// A program that opens exports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditingProgram {
    /// The name for display.
    pub name: String,
    /// The path of its executable.
    pub program: PathBuf,
    /// The format of the file that it opens.
    pub format: ExportFormat,
}

impl EditorChoice {
    /// Returns the program to use: the chosen one if it is installed, otherwise the first one found.
    pub fn tool(&self, found: &[(ImageEditor, PathBuf)]) -> Option<EditingProgram> {
        let known = |(editor, program): &(ImageEditor, PathBuf)| EditingProgram {
            name: editor.name().into(),
            program: program.clone(),
            format: editor.format(),
        };
        let Some(chosen) = self.editor else {
            let program = PathBuf::from(&self.program);
            let name = program.file_stem()?.to_string_lossy().into_owned();
            return Some(EditingProgram { name, program, format: self.format });
        };
        found.iter().find(|(editor, _)| *editor == chosen).or_else(|| found.first()).map(known)
    }
}

impl State {
    /// Returns the installed image editors.
    pub fn editors_found(&mut self) -> &[(ImageEditor, PathBuf)] {
        self.round_trip.found.get_or_insert_with(image_editors)
    }

    /// Returns the selected layer of a photo.
    fn paintable_layer(&self, index: usize) -> Option<&ImageLayer> {
        let Selection::Layer { photo, layer } = self.selection else { return None };
        let stack = self.session.as_ref()?.photos[photo].stack.as_ref()?;
        stack.image_layers.get(layer).filter(|_| photo == index)
    }
}

/// Opens the selected photo's stack in the image editor. `fresh`: makes a new export even where one exists.
pub fn edit_photo(state: &mut State, work: &mut Work, fresh: bool) {
    let choice = state.settings.image_editor.clone();
    let Some(tool) = choice.tool(state.editors_found()) else {
        state.round_trip.choosing_editor = true;
        return;
    };
    if let Err(error) = check_program(&tool.program) {
        state.round_trip.choosing_editor = true;
        return state.tell(Note::new(Weight::Problem, error.to_string()));
    }
    let (Some(session), Some(index)) = (&state.session, state.selected_photo()) else { return };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let layer = state.paintable_layer(index).map(|layer| (layer.name.clone(), layer.id.clone()));
    let decisions = Some(session.history.present().decisions.clone());
    let name = format!("Preparing {} for {}", opened.site.photos[index].name, tool.name);
    work.jobs.start(&mut state.running, JobKind::Export, name, move |task| {
        let photo = &opened.site.photos[index];
        let selected = layer.as_ref().map(|(_, token)| token.clone());
        let options = ExportOptions { format: tool.format, selected, decisions, ..ExportOptions::default() };
        let document = document_to_edit(&folder, photo, &options, fresh, task)?;
        drop(lock);
        let (teller, name) = (task.clone(), tool.name.clone());
        let failed = move |how| teller.note(format!("{name} has ended at once: {how}"));
        start_with(&tool.program, &document.file, failed)?;
        let file = shown_path(&folder, &document.file);
        let begun = if document.begun { ", as you left it," } else { "" };
        let layer = layer.map_or(String::new(), |(name, token)| {
            format!(" Paint on the layer “{}”.", layer_name(&name, &token))
        });
        let text =
            format!("{file}{begun} opens in {}.{layer} What you save there comes home by itself.", tool.name);
        let note = Note::about(Weight::Info, &photo.name, text);
        Ok(Box::new(move |state| {
            state.tell(note);
            state.settings.notes_shown = true;
            vec![RoundTripAsk::WatchForSaves.into()]
        }))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chosen_editor_is_used_if_it_is_there_else_the_first_one_found_or_the_own_program() {
        let found: Vec<(ImageEditor, PathBuf)> =
            vec![(ImageEditor::Krita, "/bin/krita".into()), (ImageEditor::Photoshop, "/bin/ps".into())];
        let choice = |editor, program: &str| EditorChoice {
            editor,
            program: program.into(),
            format: ExportFormat::Psd,
        };
        let name = |choice: EditorChoice| choice.tool(&found).map(|tool| (tool.name, tool.format));
        let krita = Some(("Krita".to_owned(), ExportFormat::Ora));
        assert_eq!(name(choice(Some(ImageEditor::Krita), "")), krita);
        assert_eq!(name(choice(Some(ImageEditor::Gimp), "")), krita, "GIMP is not there");
        assert_eq!(name(choice(None, "/opt/paint")), Some(("paint".to_owned(), ExportFormat::Psd)));
        assert_eq!(name(choice(None, "")), None);
        assert_eq!(choice(Some(ImageEditor::Gimp), "").tool(&[]), None);
    }
}
