//! The panels around the views, and the widgets that several of them use.

pub mod bar;
pub mod closing;
pub mod colour;
pub mod dialogs;
pub mod fill;
pub mod flat;
pub mod help;
pub mod inspector;
pub mod layer;
pub mod layer_options;
pub mod masks;
pub mod menu;
pub mod notes;
pub mod paint;
pub mod palette;
pub mod photo;
pub mod photos;
pub mod pictures;
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
use sized::{PanelEdge, PanelSizes, sized_panel};

/// The largest share of the window's width that the left side takes: views keep their space in small windows and with
/// large text.
const LEFT_MOST: f32 = 0.27;
/// The largest share of the window's width that the right side takes: its pages have two columns.
const RIGHT_MOST: f32 = 0.33;
/// Draws the lists on the left and the inspector on the right.
pub fn sides_ui(editor: &mut Editor, sizes: &mut PanelSizes, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let width = ui.available_width();
    if editor.state.settings.lists_shown {
        let (place, most) = ((PanelEdge::Left, "outliner"), LEFT_MOST * width);
        let photos = &mut sizes.photos;
        sized_panel(ui, place, &mut sizes.left, most, |ui| left_ui(editor, photos, ui, asks));
    }
    if editor.state.settings.side_shown {
        let (place, most) = ((PanelEdge::Right, "inspector"), RIGHT_MOST * width);
        sized_panel(ui, place, &mut sizes.right, most, |ui| side::side_ui(editor, ui, asks));
    }
}

/// The largest share of the left side's height that the photos take: the lists below are equally important.
const PHOTOS_MOST: f32 = 0.55;

/// Draws the photos above, objects and layers below. `height` is that of the photos, as the user set it, in points.
fn left_ui(editor: &mut Editor, height: &mut f32, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let most = PHOTOS_MOST * ui.available_height();
    sized_panel(ui, (PanelEdge::Top, "photos"), height, most, |ui| photos::photos_ui(editor, ui, asks));
    outliner_ui(editor, ui, asks);
}

/// Draws a command that switches something, highlighted while it is on.
pub fn toggle_ui(state: &State, ui: &mut Ui, command: &'static Command, asks: &mut Vec<Ask>) {
    let on = command.on.is_some_and(|on| on(state));
    if ui.selectable_label(on, command.name).on_hover_text(command.tooltip).clicked() {
        asks.push(command.asked(state));
    }
}

/// Draws a command as a button with another text; returns whether it was clicked.
pub fn button_ui(ui: &mut Ui, command: &Command, button: Button) -> bool {
    let keys = super::command::first_keys(ui.ctx(), command);
    let keys = if keys.is_empty() { keys } else { format!(" ({keys})") };
    ui.add(button).on_hover_text(format!("{}{keys}: {}", command.name, command.tooltip)).clicked()
}

/// Sets the accessible name of a widget without a text of its own.
pub fn named(response: &Response, name: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}

/// Formats a number with thin spaces between groups: `12 345 678`.
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

/// Draws a selectable name in a table, truncated to `width` points; its tooltip has the full name.
fn name_cell(ui: &mut Ui, selected: bool, name: &str, width: f32) -> Response {
    let size = vec2(width, ui.spacing().interact_size.y);
    let layout = Layout::left_to_right(Align::Center);
    let button = Button::selectable(selected, name).truncate();
    ui.allocate_ui_with_layout(size, layout, |ui| ui.add(button)).inner.on_hover_text(name)
}

/// The smallest width of names in tables, in points.
const LEAST_NAME: f32 = 70.0;

/// Returns the width of names in a table whose other columns take `others` points, with gaps.
fn room_for_names(ui: &Ui, others: f32) -> f32 {
    (ui.available_width() - others).max(LEAST_NAME)
}

/// Draws a small button; `name` is its accessible name.
pub fn small_button(ui: &mut Ui, text: &str, name: &str, tooltip: &str) -> Response {
    let button = ui.small_button(text);
    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    button.on_hover_text(tooltip)
}

/// The size of buttons that answer a question, in points; the width is the smallest.
const ANSWER: Vec2 = vec2(96.0, 28.0);

/// Draws the answers to a question in a row, the first one as the default with the focus; returns the one that was
/// pressed.
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

/// Draws a scrolling list of rows of equal height, at most `most` points high, of which only visible rows are drawn.
pub fn long_list(ui: &mut Ui, id: &str, most: f32, count: usize, mut row: impl FnMut(&mut Ui, usize)) {
    let height = ui.spacing().interact_size.y + 4.0;
    let area = ScrollArea::vertical().id_salt(id).max_height(most).auto_shrink([false, most.is_finite()]);
    area.show_rows(ui, height, count, |ui, rows| rows.for_each(|place| row(ui, place)));
}

/// The width of the number beside a slider, in points: `-1.25 stops` fits.
const NUMBER: f32 = 92.0;
/// The shortest useful slider, in points.
const LEAST_RAIL: f32 = 50.0;
/// The longest useful slider, in points.
const MOST_RAIL: f32 = 140.0;

/// Draws a slider with its name: beside it where there are `names` points of space, otherwise above it.
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

/// Returns the width of a text on one line, in points.
pub fn text_width(ui: &Ui, text: &str) -> f32 {
    let font = TextStyle::Body.resolve(ui.style());
    ui.painter().layout_no_wrap(text.to_owned(), font, ui.visuals().text_color()).size().x
}

/// Formats a count: `1 pixel`, `2 345 pixels`.
pub fn counted(number: u64, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(number))
}

/// Formats a share in percent, with digits that suit its size.
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
