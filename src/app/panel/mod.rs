//! The panels around the views, and the widgets that several of them use.

pub mod about;
pub mod bar;
pub mod check;
pub mod closing;
pub mod colour;
pub mod dialogs;
pub mod fill;
pub mod flat;
pub mod flight;
mod gone;
pub mod help;
pub mod history;
pub mod inspect;
pub mod inspector;
pub mod layer;
pub mod layer_options;
pub mod lists;
pub mod masks;
pub mod menu;
pub mod merging;
pub mod model_suggestions;
pub mod notes;

mod import_question;
pub mod opening;
pub mod orthophoto;
pub mod paint;
pub mod palette;
pub mod photo;
pub mod photos;
pub mod pictures;
pub mod publish;
pub mod removing;
pub mod save_image;
pub mod settings;
pub mod side;
pub mod sides;
pub mod site_frame;
pub mod space;
pub mod status;
pub mod welcome;

use eframe::egui::{
    Align, Button, Label, Layout, Response, RichText, Role, ScrollArea, Slider, TextStyle, Ui, Vec2,
    WidgetInfo, vec2,
};

use super::command::{Command, Commands};
pub use crate::state::numbers::{counted, grouped, percent};
use crate::state::request::Request;
use crate::widget::dialog::Keys;
use crate::widget::elide::elided;
use crate::widget::look::selection_look;

/// Draws the title of the selection: its kind and its name.
pub fn title(ui: &mut Ui, kind: &str, name: &str) {
    ui.weak(kind);
    ui.label(RichText::new(name).heading());
    ui.add_space(4.0);
}

/// The greatest width of the names of facts, as a share of the page's.
const NAMES_MOST: f32 = 0.45;

/// Draws facts in two columns: names as wide as the widest, values wrapped.
pub fn rows(ui: &mut Ui, rows: &[(&str, String)]) {
    let gap = 12.0;
    let widest = rows.iter().map(|(name, _)| text_width(ui, name)).fold(0.0, f32::max);
    let names = (widest + 1.0).min(NAMES_MOST * ui.available_width());
    let values = ui.available_width() - names - gap;
    for (name, value) in rows {
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = gap;
            ui.scope(|ui| {
                ui.set_width(names);
                ui.add(Label::new(RichText::new(*name).weak()).wrap());
            });
            ui.scope(|ui| {
                ui.set_max_width(values);
                ui.add(Label::new(value).wrap());
            });
        });
    }
}

/// Draws a button for a command; its tooltip gives the reason where the command is not ready.
pub fn button(commands: Commands<'_>, ui: &mut Ui, command: &'static Command, requests: &mut Vec<Request>) {
    let ready = commands.ready(command);
    let button = Button::new(command.name).selected(commands.is_on(command));
    let response = ui.add_enabled(ready.is_ok(), button);
    let response = response.on_hover_text(command.tooltip);
    if response.on_disabled_hover_text(ready.err().unwrap_or_default()).clicked() {
        requests.push(commands.requested(command));
    }
}

/// Draws a command that switches something, highlighted while it is on.
pub fn toggle_ui(
    commands: Commands<'_>,
    ui: &mut Ui,
    command: &'static Command,
    requests: &mut Vec<Request>,
) {
    if switch_ui(ui, commands.is_on(command), command.name).on_hover_text(command.tooltip).clicked() {
        requests.push(commands.requested(command));
    }
}

/// Draws a switch, with a frame also while it is off, so that it does not look like a label.
pub fn switch_ui(ui: &mut Ui, on: bool, text: impl Into<String>) -> Response {
    ui.add(Button::new(text.into()).selected(on))
}

/// Draws a link in the colour of links, underlined.
pub fn link_ui(ui: &mut Ui, text: impl Into<String>) -> Response {
    let color = ui.visuals().hyperlink_color;
    ui.link(RichText::new(text).color(color).underline())
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

/// A name in a table.
struct NameCell<'a> {
    name: &'a str,
    /// The names beside it, from which it differs also when it is shortened.
    others: &'a [&'a str],
    /// The width of the column, in points.
    width: f32,
}

/// Draws a selectable name in a table, shortened to the width of its column; its tooltip has the full name.
fn name_cell(ui: &mut Ui, selected: bool, cell: &NameCell<'_>) -> Response {
    let NameCell { name, others, width } = *cell;
    let size = vec2(width, ui.spacing().interact_size.y);
    let layout = Layout::left_to_right(Align::Center);
    let room = width - 2.0 * ui.spacing().button_padding.x;
    let button = Button::selectable(selected, elided(ui, name, others, room, &TextStyle::Button)).truncate();
    let draw = |ui: &mut Ui| {
        selection_look(ui.visuals_mut());
        ui.add(button)
    };
    let response = ui.allocate_ui_with_layout(size, layout, draw).inner;
    named(&response, name);
    response.on_hover_text(name)
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
