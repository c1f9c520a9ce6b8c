//! The settings, as they are shown.

use eframe::egui::{Context, Grid, Slider, Ui, Window};

use crate::app::command::{file, first_keys, paint};
use crate::app::editor::{Ask, Editor};
use crate::app::settings::{Colours, Navigation, Settings};

/// Shows them when they are wanted.
pub fn settings_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    let mut open = editor.settings_shown;
    let window = Window::new("Settings").open(&mut open).resizable(false).default_width(420.0);
    window.show(context, |ui| {
        let mut wanted = editor.settings.clone();
        contents(&mut wanted, ui, asks);
        if wanted != editor.settings {
            editor.settings = wanted;
            editor.settings.apply_to(context);
        }
    });
    editor.settings_shown = open && !super::escaped(context);
}

fn contents(settings: &mut Settings, ui: &mut Ui, asks: &mut Vec<Ask>) {
    Grid::new("settings").num_columns(2).spacing([16.0, 12.0]).show(ui, |ui| {
        ui.label("Theme");
        ui.horizontal(|ui| {
            for colours in Colours::ALL {
                ui.selectable_value(&mut settings.colours, colours, colours.name());
            }
        });
        ui.end_row();

        ui.label("Size of text and buttons");
        ui.horizontal(|ui| {
            let mut percent = settings.scale * 100.0;
            // The size changes when the handle is let go: it would run away from under the pointer.
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

        ui.label("First steps");
        ui.checkbox(&mut settings.hints, "Show hints for the 3D view");
        ui.end_row();
    });
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        for command in [&paint::CHOOSE_EDITOR, &file::KEYS, &file::LAYOUT] {
            if ui.button(command.name).on_hover_text(command.tooltip).clicked() {
                asks.push(Ask::Run(command));
            }
        }
    });
}
