//! The help: the functions of keys and mouse.

use eframe::egui::{Align2, Context, Grid, Label, RichText, ScrollArea, Ui, Window};

use crate::command;
use crate::state::request::{Flag, Request, WindowRequest};
use crate::state::settings::Navigation;
use crate::widget::dialog::escaped;

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

/// The width of a column of the help, in points: the longest line fits.
const COLUMN: f32 = 400.0;
/// The height of the help's frame, with the distance from the window's edges, in points.
const FRAME: f32 = 110.0;

/// Draws the help when it is open: in as many columns as fit into the window.
pub fn help_ui(shown: bool, navigation: Navigation, context: &Context, requests: &mut Vec<Request>) {
    if !shown {
        return;
    }
    let mut open = true;
    let room = context.content_rect().size();
    let lines = lines(navigation, context);
    let columns = ((room.x / COLUMN) as usize).clamp(1, 3);
    let (width, most) = (COLUMN * columns as f32 - 60.0, (room.y - FRAME).max(FRAME));
    let window = Window::new("Keys and mouse").open(&mut open).auto_sized().collapsible(false);
    window.pivot(Align2::CENTER_CENTER).default_pos(context.content_rect().center()).show(context, |ui| {
        ui.set_width(width.min(room.x - FRAME));
        ScrollArea::vertical().max_height(most).auto_shrink([false, true]).show(ui, |ui| {
            ui.columns(columns, |columns| {
                let of_one = lines.len().div_ceil(columns.len());
                for (place, (ui, lines)) in columns.iter_mut().zip(lines.chunks(of_one)).enumerate() {
                    column_ui(ui, place, lines);
                }
            });
        });
    });
    if !open || escaped(context) {
        requests.push(WindowRequest::Hide(Flag::Help).into());
    }
}

/// A line of the help.
struct HelpEntry {
    keys: String,
    /// What the keys do.
    what: &'static str,
    /// More about that, for the tooltip; empty for none.
    more: &'static str,
}

fn lines(navigation: Navigation, context: &Context) -> Vec<HelpEntry> {
    let mouse = mouse(navigation);
    let of_mouse =
        mouse.iter().chain(LISTS).map(|(keys, what)| HelpEntry { keys: (*keys).to_owned(), what, more: "" });
    let commands = command::all().filter(|command| !command.keys.is_empty()).map(|command| {
        let keys: Vec<String> = command.keys.iter().map(|keys| command::keys_text(context, keys)).collect();
        HelpEntry { keys: keys.join(", "), what: command.name, more: command.tooltip }
    });
    of_mouse.chain(commands).collect()
}

/// The share of a column that the keys take.
const KEYS_SHARE: f32 = 0.4;

fn column_ui(ui: &mut Ui, place: usize, lines: &[HelpEntry]) {
    let keys_width = KEYS_SHARE * ui.available_width();
    Grid::new(("help", place)).num_columns(2).striped(true).min_col_width(keys_width).show(ui, |ui| {
        for HelpEntry { keys, what, more } in lines {
            ui.scope(|ui| {
                ui.set_max_width(keys_width);
                ui.add(Label::new(RichText::new(keys).strong()).wrap());
            });
            let label = ui.add(Label::new(*what).wrap());
            if !more.is_empty() {
                label.on_hover_text(*more);
            }
            ui.end_row();
        }
    });
}
