//! The help: the functions of keys and mouse.

use eframe::egui::{Context, Grid, ScrollArea, Window};

use crate::app::command;
use crate::app::state::State;
use crate::app::state::ask::{Ask, Flag, WindowAsk};
use crate::app::state::settings::Navigation;
use crate::app::widget::dialog::escaped;

/// The mouse functions in the 3D view.
const SIMPLE: &[(&str, &str)] = &[
    ("Left drag", "orbit around the point under the pointer"),
    ("Right drag, Shift+left drag", "pan"),
    ("Alt+left drag", "look around"),
    ("Wheel", "dolly to the point under the pointer"),
    ("Click, double click", "select an object (again: its face), frame it"),
    ("W A S D, Q E", "fly; with Shift faster"),
    ("X, held", "flip between photo and view"),
];

const BLENDER: &[(&str, &str)] = &[
    ("Middle drag", "orbit around the point under the pointer"),
    ("Shift+middle drag", "pan"),
    ("Right drag", "look around"),
    ("Wheel", "dolly to the point under the pointer"),
    ("Click, double click", "select an object (again: its face), frame it"),
    ("W A S D, Q E", "fly; with Shift faster"),
    ("X, held", "flip between photo and view"),
];

/// The key functions in the lists of layers and objects.
const LISTS: &[(&str, &str)] = &[
    ("Up, Down in a list", "from row to row; with Shift several layers"),
    ("Right, Left in a list", "open or close a row"),
    ("Enter in a list", "frame an object or face, show only this layer"),
];

/// Returns the mouse functions, those for beginners first.
pub fn mouse(navigation: Navigation) -> &'static [(&'static str, &'static str)] {
    match navigation {
        Navigation::Simple => SIMPLE,
        Navigation::Blender => BLENDER,
    }
}

/// Draws the help when it is open.
pub fn help_ui(state: &State, context: &Context, asks: &mut Vec<Ask>) {
    let mut open = state.help_shown;
    let window = Window::new("Keys and mouse").open(&mut open).default_width(420.0).default_height(520.0);
    window.show(context, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            let mouse = mouse(state.settings.navigation);
            Grid::new("mouse").num_columns(2).striped(true).show(ui, |ui| {
                for (keys, what) in mouse.iter().chain(LISTS) {
                    ui.strong(*keys);
                    ui.label(*what);
                    ui.end_row();
                }
                for command in command::all().filter(|command| !command.keys.is_empty()) {
                    let keys: Vec<String> =
                        command.keys.iter().map(|keys| command::keys_text(ui.ctx(), keys)).collect();
                    ui.strong(keys.join(", "));
                    ui.label(command.name).on_hover_text(command.tooltip);
                    ui.end_row();
                }
            });
        });
    });
    if state.help_shown && (!open || escaped(context)) {
        asks.push(WindowAsk::Hide(Flag::Help).into());
    }
}
