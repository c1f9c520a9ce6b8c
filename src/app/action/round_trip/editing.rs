//! `Edit in …`: opens a photo's stack in the installed image editor, or in the chosen one.

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::request::RoundTripRequest;
use crate::state::round_trip::shown_path;
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_editing::editing::document_to_edit;
use quadratura_editing::export::{ExportOptions, TreesInSite, layer_name};
use quadratura_io::programs::{check_program, start_with};

/// Opens the selected photo's stack in the image editor. `fresh`: makes a new export even where one exists.
pub fn edit_photo(state: &mut State, work: &mut Work, fresh: bool) {
    let choice = state.settings.image_editor.clone();
    let Some(tool) = choice.tool(state.editors_found()) else {
        state.round_trip.dialogs.choosing_editor = true;
        return;
    };
    if let Err(error) = check_program(&tool.program) {
        state.round_trip.dialogs.choosing_editor = true;
        return state.notify(Note::new(Weight::Problem, error.message()));
    }
    let (Some(session), Some(id)) = (&state.session, state.selected_photo()) else { return };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let layer = state.paintable_layer(id).map(|layer| (layer.name.clone(), layer.id.clone()));
    let present = session.history.present();
    let decisions = Some(present.decisions.clone());
    let trees = TreesInSite::new(&present.trees, &opened.project, &opened.site);
    let name = format!("Preparing {} for {}", opened.site.photo(id).name, tool.name);
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, name, move |task| {
        // Files of layers that are being updated are read when they are complete.
        let written = stacks.take();
        let photo = opened.site.photo(id);
        let selected = layer.as_ref().map(|(_, token)| token.clone());
        let options =
            ExportOptions { format: tool.format, trees, selected, decisions, ..ExportOptions::default() };
        let document = document_to_edit(&folder, photo, &options, fresh, task)?;
        drop((lock, written));
        let (teller, name) = (task.clone(), tool.name.clone());
        let failed = move |how| teller.note(format!("{name} ended immediately: {how}"));
        start_with(&tool.program, &document.file, failed)?;
        let file = shown_path(&folder, &document.file);
        let begun = if document.begun { ", as you left it," } else { "" };
        let layer = layer.map_or(String::new(), |(name, token)| {
            format!(" Paint on the layer “{}”.", layer_name(&name, &token))
        });
        let text = format!(
            "{file}{begun} opens in {}.{layer} What you save there is imported automatically.",
            tool.name
        );
        let note = Note::about(Weight::Info, &photo.name, text);
        Ok(Box::new(move |state| {
            state.notify(note);
            // Who edits photo after photo knows where it is said.
            if !std::mem::replace(&mut state.round_trip.opened_messages, true) {
                state.settings.notes_shown = true;
            }
            vec![RoundTripRequest::WatchForSaves.into()]
        }))
    });
}
