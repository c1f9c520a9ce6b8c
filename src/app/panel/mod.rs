//! The panels around the views.

pub mod bar;
pub mod colour;
pub mod dialogs;
pub mod fill;
pub mod help;
pub mod inspector;
pub mod layer_options;
pub mod leaving;
pub mod masks;
pub mod menu;
pub mod notes;
pub mod paint;
pub mod palette;
pub mod photos;
pub mod settings;
pub mod side;
pub mod sized;
pub mod status;
pub mod welcome;

use eframe::egui::{
    Align, Button, Layout, Response, RichText, Role, ScrollArea, Slider, TextStyle, Ui, Vec2, WidgetInfo,
    vec2,
};

use super::command::Command;
use super::lists::outliner_ui;
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::widget::dialog::Keys;
use sized::{Edge, Sizes, sized_panel};

/// The most that the left side takes of the window's width: in a small window, and with large text, the views have room.
const LEFT_MOST: f32 = 0.27;
/// The most that the right side takes of the window's width: its pages have two columns.
const RIGHT_MOST: f32 = 0.33;
/// Lists on the left, what is known of the selection on the right.
pub fn sides_ui(editor: &mut Editor, sizes: &mut Sizes, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let width = ui.available_width();
    if editor.state.settings.lists_shown {
        let (place, most) = ((Edge::Left, "outliner"), LEFT_MOST * width);
        let photos = &mut sizes.photos;
        sized_panel(ui, place, &mut sizes.left, most, |ui| left_ui(editor, photos, ui, asks));
    }
    if editor.state.settings.side_shown {
        let (place, most) = ((Edge::Right, "inspector"), RIGHT_MOST * width);
        sized_panel(ui, place, &mut sizes.right, most, |ui| side::side_ui(editor, ui, asks));
    }
}

/// The most that photos take of the left side's height: the lists below are as important.
const PHOTOS_MOST: f32 = 0.55;

/// Photos above, objects and layers below. `height`: that of the photos, as their user wants it, in points.
fn left_ui(editor: &mut Editor, height: &mut f32, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let most = PHOTOS_MOST * ui.available_height();
    sized_panel(ui, (Edge::Top, "photos"), height, most, |ui| photos::photos_ui(editor, ui, asks));
    outliner_ui(editor, ui, asks);
}

/// A command that switches something, as a label that is lit while that is on.
pub fn toggle_ui(state: &State, ui: &mut Ui, command: &'static Command, asks: &mut Vec<Ask>) {
    let on = command.on.is_some_and(|on| on(state));
    if ui.selectable_label(on, command.name).on_hover_text(command.tooltip).clicked() {
        asks.push(command.asked(state));
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

/// Names in tables have this much room at least, in points.
const LEAST_NAME: f32 = 70.0;

/// The width of names in a table whose other columns take `others` points, with the gaps between them.
fn room_for_names(ui: &Ui, others: f32) -> f32 {
    (ui.available_width() - others).max(LEAST_NAME)
}

/// A small button; `name` says for whom it is, which its place says to the eye.
pub fn small_button(ui: &mut Ui, text: &str, name: &str, tooltip: &str) -> Response {
    let button = ui.small_button(text);
    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    button.on_hover_text(tooltip)
}

/// Height of buttons that answer a question, and their width at least, in points.
const ANSWER: Vec2 = vec2(96.0, 28.0);

/// Answers to a question in a row, the first one as the usual one, which has the focus; the one that was pressed.
pub fn answers_ui(ui: &mut Ui, keys: &mut Keys, answers: &[&'static str]) -> Option<&'static str> {
    let mut chosen = None;
    for (place, answer) in answers.iter().enumerate() {
        let is_usual = place == 0;
        let text = if is_usual { RichText::new(*answer).strong() } else { RichText::new(*answer) };
        let button = ui.add(Button::new(text).min_size(ANSWER));
        let is_pressed = if is_usual { keys.press_first(&button) } else { button.clicked() };
        if is_pressed {
            chosen = Some(*answer);
        }
    }
    chosen
}

/// A list of rows of one height, `most` points high at most, of which only those in sight are made.
pub fn long_list(ui: &mut Ui, id: &str, most: f32, count: usize, mut row: impl FnMut(&mut Ui, usize)) {
    let height = ui.spacing().interact_size.y + 4.0;
    let area = ScrollArea::vertical().id_salt(id).max_height(most).auto_shrink([false, most.is_finite()]);
    area.show_rows(ui, height, count, |ui, rows| rows.for_each(|place| row(ui, place)));
}

/// What the number beside a slider takes, in points: `-1.25 stops` has room.
const NUMBER: f32 = 92.0;
/// A shorter rail cannot be aimed at, in points.
const LEAST_RAIL: f32 = 50.0;
/// A longer one is no better, in points.
const MOST_RAIL: f32 = 140.0;

/// A slider with its name: beside it where there is room for `names` points, else above it.
pub fn slider_ui(ui: &mut Ui, name: &str, names: f32, slider: Slider<'_>) -> Response {
    let gap = ui.spacing().item_spacing.x;
    let rail = ui.available_width() - NUMBER - gap - names - gap;
    if rail >= LEAST_RAIL {
        ui.spacing_mut().slider_width = rail.min(MOST_RAIL);
        return ui.add(slider.text(name));
    }
    let label = ui.label(name);
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER - gap).clamp(LEAST_RAIL, MOST_RAIL);
    ui.add(slider).labelled_by(label.id)
}

/// How wide a text is on one line, in points.
pub fn text_width(ui: &Ui, text: &str) -> f32 {
    let font = TextStyle::Body.resolve(ui.style());
    ui.painter().layout_no_wrap(text.to_owned(), font, ui.visuals().text_color()).size().x
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
