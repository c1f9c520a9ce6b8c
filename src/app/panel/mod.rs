//! The panels around the views.

mod colour;
pub mod dialogs;
mod fill;
pub mod help;
pub mod hint;
pub mod inspector;
pub mod layer_options;
pub mod masks;
pub mod menu;
pub mod notes;
mod paint;
mod photos;
pub mod settings;
pub mod side;
pub mod status;
pub mod welcome;

use eframe::egui::{Align, Button, Layout, Panel, Response, Ui, UiBuilder, vec2};

use super::command::Command;
use super::editor::{Ask, Editor};
use super::lists::outliner_ui;

/// Photos above, objects and layers below.
pub fn left_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let photos = Panel::top("photos").resizable(true).default_size(340.0);
    photos.show(ui, |ui| photos::photos_ui(editor, ui, asks));
    outliner_ui(editor, ui, asks);
}

/// Draws contents; `held`: what is wider than the panel ends at its border. Else the panel grows with what it holds,
/// and one on the right that may not grow any more is pushed out of the window by it.
pub fn kept_within(ui: &mut Ui, held: bool, contents: impl FnOnce(&mut Ui)) {
    if !held {
        return contents(ui);
    }
    let rect = ui.available_rect_before_wrap();
    contents(&mut ui.new_child(UiBuilder::new().max_rect(rect)));
    ui.advance_cursor_after_rect(rect);
}

/// A command that switches something, as a label that is lit while that is on.
pub fn toggle_ui(editor: &Editor, ui: &mut Ui, command: &'static Command, asks: &mut Vec<Ask>) {
    let on = command.on.is_some_and(|on| on(editor));
    if ui.selectable_label(on, command.name).on_hover_text(command.tooltip).clicked() {
        asks.push(Ask::Run(command));
    }
}

/// A command as a button of another text; whether it was clicked.
pub fn button_ui(ui: &mut Ui, command: &Command, button: Button) -> bool {
    let keys = super::command::first_keys(ui.ctx(), command);
    let keys = if keys.is_empty() { keys } else { format!(" ({keys})") };
    ui.add(button).on_hover_text(format!("{}{keys}: {}", command.name, command.tooltip)).clicked()
}

/// What a widget without a text of its own beside it is called, for those who hear the window.
pub fn named(response: &Response, name: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}

/// `12 345 678` with thin groups, as people read numbers.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// A name in a table, to be selected: shortened to `width` points, and whole where the pointer is on it.
fn name_cell(ui: &mut Ui, selected: bool, name: &str, width: f32) -> Response {
    let size = vec2(width, ui.spacing().interact_size.y);
    let layout = Layout::left_to_right(Align::Center);
    let button = Button::selectable(selected, name).truncate();
    ui.allocate_ui_with_layout(size, layout, |ui| ui.add(button)).inner.on_hover_text(name)
}

/// `1 pixel`, `2 345 pixels`.
pub fn counted(number: u64, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(number))
}

/// A share in percent, as precise as it is of interest.
pub fn percent(part: u64, all: u64) -> String {
    let share = 100.0 * part as f64 / all.max(1) as f64;
    if share > 0.0 && share < 10.0 { format!("{share:.1} %") } else { format!("{share:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_shares_rounded() {
        assert_eq!(grouped(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!([grouped(0), grouped(999)], ["0", "999"]);
        assert_eq!([counted(1, "pixel"), counted(0, "pixel")], ["1 pixel", "0 pixels"]);
        assert_eq!([percent(1, 3), percent(1, 300), percent(0, 0)], ["33 %", "0.3 %", "0 %"]);
    }
}
