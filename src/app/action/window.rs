//! Actions on the window itself: visible panels, colours, sizes and notes.

use crate::state::State;
use crate::state::guide::Document;
use crate::state::notes::{Note, Weight};
use crate::state::request::{Flag, WindowRequest};
use crate::work::Work;
use crate::work::pages::{file_in, write_pages};
use quadratura_io::programs::open_with_system;

/// Applies a request about the window.
pub fn apply(state: &mut State, work: &Work, request: WindowRequest) {
    match request {
        WindowRequest::Hide(flag) => *state.flag_mut(flag) = false,
        WindowRequest::Flip(flag) => flip(state, flag),
        WindowRequest::Palette => state.dialogs.palette.toggle(),
        WindowRequest::SortLayers(column) => state.settings.layer_list.sort_by(column),
        WindowRequest::Theme(colours) => state.settings.colours = colours,
        WindowRequest::Resize(steps) => state.settings.resize(steps),
        WindowRequest::Scale(scale) => state.settings.scale = scale,
        WindowRequest::UsualSize => state.settings.scale = 1.0,
        WindowRequest::Navigate(navigation) => state.settings.navigation = navigation,
        WindowRequest::ShowHints(shown) => state.settings.hints = shown,
        WindowRequest::ImagesWhileMoving(on) => state.settings.images_while_moving = on,
        WindowRequest::ResetLayout => {
            state.settings.lay_out_anew();
            state.window.resets = true;
        }
        WindowRequest::ShowTab(tab) => state.settings.side = tab,
        WindowRequest::ShowPane(pane) => state.panes.show(pane),
        WindowRequest::Say(note) => state.notes.add(note),
        WindowRequest::ClearNotes => state.notes.clear(),
        WindowRequest::SeeNotes => state.notes.see(),
        WindowRequest::Read(document) => read(state, work, document),
        WindowRequest::CopyDiagnostics => {
            state.window.copies = Some(state.diagnostics());
            state.notes.add(Note::new(Weight::Info, "Diagnostics were copied to the clipboard"));
        }
    }
}

/// Opens a document with the system's program.
fn read(state: &mut State, work: &Work, document: Document) {
    let Some(folder) = &work.pages else {
        let text = "The document could not be opened: the system names no folder for files of the program";
        return state.notify(Note::about(Weight::Problem, document.name, text));
    };
    let file = file_in(folder, document);
    let note = match write_pages(folder).and_then(|()| open_with_system(&file)) {
        Ok(()) => {
            Note::new(Weight::Info, format!("The document is opened in the browser: {}", file.display()))
        }
        Err(error) => {
            let page =
                if file.is_file() { format!(". Its page is {}", file.display()) } else { String::new() };
            Note::new(Weight::Problem, format!("The document could not be opened: {error}{page}"))
        }
    };
    state.notify(Note { subject: document.name.into(), ..note });
}

fn flip(state: &mut State, flag: Flag) {
    *state.flag_mut(flag) ^= true;
    // The dialog lists what is installed.
    if flag == Flag::ImageEditor && state.round_trip.dialogs.choosing_editor {
        state.editors_found();
    }
}

impl State {
    fn flag_mut(&mut self, flag: Flag) -> &mut bool {
        match flag {
            Flag::Settings => &mut self.dialogs.settings,
            Flag::Notes => &mut self.settings.notes_shown,
            Flag::KeepUpToDate => &mut self.settings.keep_up_to_date,
            Flag::Lists => &mut self.settings.lists_shown,
            Flag::Side => &mut self.settings.side_shown,
            Flag::Help => &mut self.dialogs.help,
            Flag::About => &mut self.dialogs.about,
            Flag::History => &mut self.dialogs.history,
            Flag::LayerOptions => &mut self.dialogs.layer_options,
            Flag::LayerTable => &mut self.settings.layer_list.as_table,
            Flag::Check => &mut self.checks.shown,
            Flag::ImageEditor => &mut self.round_trip.dialogs.choosing_editor,
            Flag::Flight => &mut self.flights.shown,
            Flag::Legend => &mut self.space.legend_shown,
            Flag::Wireframe => &mut self.space.wireframe,
            Flag::Cameras => &mut self.space.cameras,
            Flag::Backs => &mut self.space.look.without_backs,
            Flag::Surroundings => &mut self.space.look.without_surroundings,
            Flag::Agreement => &mut self.space.look.blend.agreement,
            Flag::WithoutTransients => &mut self.space.look.blend.without_transients,
            Flag::Images => &mut self.space.images.on,
            Flag::PhotoOver => &mut self.space.photo_over,
            Flag::Outlines => &mut self.flat.switches.outlines,
            Flag::Hatching => &mut self.flat.switches.hatching,
            Flag::Rectangles => &mut self.flat.switches.rectangles,
            Flag::Filling => &mut self.flat.switches.filling,
            Flag::Paint => &mut self.flat.switches.paint,
            Flag::Even => &mut self.flat.switches.even,
            Flag::Suggestions => &mut self.masking.suggested.shown,
        }
    }
}
