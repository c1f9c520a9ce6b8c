//! Draws the settings.

use eframe::egui::{Button, Context, Grid, RichText, Slider, Ui};

use crate::command::{Commands, file, first_keys, paint};
use crate::state::request::{Flag, Request, WindowRequest};
use crate::state::settings::{Colours, Navigation, Settings};
use crate::widget::dialog::{Dialog, at_the_right};

/// Draws the settings when they are open.
pub fn settings_ui(
    shown: bool,
    settings: &Settings,
    offered: Commands<'_>,
    context: &Context,
    requests: &mut Vec<Request>,
) {
    if !shown {
        return;
    }
    let mut wanted = settings.clone();
    let mut leads = Vec::new();
    let answer = Dialog::new("settings", 480.0).show(context, |ui, keys| {
        ui.heading("Settings");
        ui.add_space(4.0);
        contents(&mut wanted, ui);
        ui.add_space(8.0);
        let leads_on = commands(offered, ui, &mut leads);
        ui.add_space(8.0);
        let button = Button::new(RichText::new("Close").strong()).min_size([96.0, 28.0].into());
        let close = at_the_right(ui, |ui| ui.add(button));
        keys.press(&close) || leads_on
    });
    requests.extend(changes(settings, &wanted));
    if answer.inner || answer.is_left() {
        requests.push(WindowRequest::Hide(Flag::Settings).into());
    }
    // A command may change what is set or shown, so it comes last.
    requests.append(&mut leads);
}

/// Returns the asks for the settings that were changed.
fn changes(known: &Settings, wanted: &Settings) -> Vec<Request> {
    let theme = (known.colours != wanted.colours).then_some(WindowRequest::Theme(wanted.colours));
    let scale = (known.scale != wanted.scale).then_some(WindowRequest::Scale(wanted.scale));
    let mouse = (known.navigation != wanted.navigation).then_some(WindowRequest::Navigate(wanted.navigation));
    let hints = (known.hints != wanted.hints).then_some(WindowRequest::ShowHints(wanted.hints));
    let moving = (known.images_while_moving != wanted.images_while_moving)
        .then_some(WindowRequest::ImagesWhileMoving(wanted.images_while_moving));
    [theme, scale, mouse, hints, moving].into_iter().flatten().map(Request::from).collect()
}

fn contents(settings: &mut Settings, ui: &mut Ui) {
    Grid::new("settings").num_columns(2).spacing([16.0, 12.0]).show(ui, |ui| {
        ui.label("Theme");
        ui.horizontal(|ui| {
            for colours in Colours::ALL {
                ui.radio_value(&mut settings.colours, colours, colours.name());
            }
        });
        ui.end_row();

        ui.label("Size of text and buttons");
        ui.horizontal(|ui| {
            let mut percent = settings.scale * 100.0;
            // The size changes when the slider is released; otherwise it would move away under the pointer.
            let id = ui.scope_id().with("size");
            let dragged = ui.data(|data| data.get_temp::<f32>(id));
            percent = dragged.unwrap_or(percent);
            let range = 100.0 * Settings::SMALLEST..=100.0 * Settings::LARGEST;
            let slider = ui.add(Slider::new(&mut percent, range).suffix(" %").fixed_decimals(0).text("size"));
            if slider.dragged() {
                ui.data_mut(|data| data.insert_temp(id, percent));
            } else {
                ui.data_mut(|data| data.remove::<f32>(id));
                settings.scale = (percent / 5.0).round() * 5.0 / 100.0;
            }
            let keys =
                [&file::LARGER, &file::SMALLER, &file::USUAL].map(|command| first_keys(ui.ctx(), command));
            ui.weak(keys.join(", "));
        });
        ui.end_row();

        ui.label("Mouse in the 3D view");
        ui.vertical(|ui| {
            for navigation in Navigation::ALL {
                ui.radio_value(&mut settings.navigation, navigation, navigation.name());
            }
        });
        ui.end_row();

        ui.label("3D view while it moves");
        ui.checkbox(&mut settings.images_while_moving, "Layered depth images while moving").on_hover_text(
            "Draws layered depth images while the view moves, at a price that does not depend on the model, where they \
             are built; the view at rest shows the model.",
        );
        ui.end_row();

        ui.label("First steps");
        ui.checkbox(&mut settings.hints, "Show hints for the 3D view");
        ui.end_row();
    });
}

/// Draws further commands; returns whether one was chosen, which closes the settings.
fn commands(offered: Commands<'_>, ui: &mut Ui, requests: &mut Vec<Request>) -> bool {
    let mut chosen = false;
    ui.horizontal(|ui| {
        for command in [&paint::CHOOSE_EDITOR, &file::KEYS, &file::LAYOUT] {
            if ui.button(command.name).on_hover_text(command.tooltip).clicked() {
                requests.push(offered.requested(command));
                chosen = true;
            }
        }
    });
    chosen
}
