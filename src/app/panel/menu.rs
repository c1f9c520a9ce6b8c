//! The menu bar: the command tables, and recent projects.

use std::path::PathBuf;

use eframe::egui::containers::menu::{MenuBar, MenuConfig};
use eframe::egui::style::ScrollStyle;
use eframe::egui::{Button, Rect, ScrollArea, Shape, Stroke, Ui, pos2, vec2};

use crate::command::{
    self, Command, Commands, Menu, edit, first_keys, flat, flight, images, layers, mask, paint, trees, view,
};
use crate::state::request::{ProjectRequest, Request, WindowRequest};
use crate::state::settings::{Navigation, Settings};
use crate::widget::look::menu_look;

/// The width of menus, in points: names and keys are in separate columns.
const WIDTH: f32 = 230.0;
/// The margin before and behind the names of a menu, in points.
const MARGIN: f32 = 18.0;
/// The smallest distance between a menu and the lower edge of the window, in points.
const BELOW: f32 = 16.0;

/// The commands in the menu of a photo, an empty place between groups.
pub const PHOTO: &[Option<&Command>] = &[
    Some(&view::INTO),
    Some(&flat::SHOW_PHOTO),
    Some(&paint::EDIT),
    Some(&paint::EDIT_FRESH),
    None,
    Some(&images::SAVE),
    Some(&images::PAGE),
    None,
    Some(&layers::BUILD),
    Some(&mask::LOOK),
    Some(&mask::CLEAR),
    None,
    Some(&edit::RESET),
];
/// The commands in the menu of an image layer.
pub const LAYER: &[Option<&Command>] =
    &[None, Some(&flat::SHOW_LAYER), Some(&paint::EDIT), None, Some(&edit::MERGE), Some(&edit::SPLIT)];
/// The commands in the menu of an object or a face.
pub const SURFACE: &[Option<&Command>] = &[
    Some(&view::FRAME),
    Some(&view::HIDE),
    Some(&view::ISOLATE),
    Some(&view::SHOW_OBJECTS),
    None,
    Some(&edit::PIN),
    Some(&edit::EXCLUDE),
    Some(&mask::OBJECT),
    None,
    Some(&edit::SWITCH_OFF),
];

/// The commands in the menu of a tree.
pub const TREE: &[Option<&Command>] = &[
    Some(&view::FRAME),
    Some(&trees::HIDE),
    Some(&trees::SHOW_ALL),
    None,
    Some(&trees::DUPLICATE),
    Some(&trees::REMOVE),
    None,
    Some(&trees::LIGHT),
    Some(&trees::MASK),
];

/// The commands in the menu of a keyframe.
pub const KEYFRAME: &[Option<&Command>] =
    &[Some(&flight::PLAY), Some(&flight::ADD), None, Some(&flight::REMOVE), None, Some(&flight::FILM)];

/// Draws commands in the menu of a right click.
pub fn context_ui(
    commands: Commands<'_>,
    ui: &mut Ui,
    entries: &[Option<&'static Command>],
    requests: &mut Vec<Request>,
) {
    ui.set_min_width(WIDTH);
    with_margin(ui);
    for entry in entries {
        match entry {
            Some(command) if item(commands, ui, command) => {
                requests.push(commands.requested(command));
                ui.close();
            }
            Some(_) => (),
            None => drop(ui.separator()),
        }
    }
}

/// Draws the menu bar.
pub fn menu_ui(commands: Commands<'_>, settings: &Settings, ui: &mut Ui, requests: &mut Vec<Request>) {
    let bar = MenuBar::new().style(menu_look).config(MenuConfig::new().style(menu_look));
    bar.ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.name(), |ui| {
                ui.set_min_width(WIDTH);
                // A menu may be longer than the window is high.
                let most = ui.ctx().content_rect().bottom() - ui.cursor().top() - BELOW;
                // Otherwise it would be no higher than new windows are, and scroll.
                ui.set_max_height(most);
                // The bar is always there where it scrolls, so that one sees that there is more.
                ui.spacing_mut().scroll = ScrollStyle::solid();
                ScrollArea::vertical()
                    .max_height(most)
                    .show(ui, |ui| entries(commands, settings, menu, ui, requests));
            });
        }
    });
}

fn entries(
    commands: Commands<'_>,
    settings: &Settings,
    menu: Menu,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    with_margin(ui);
    for command in command::all().filter(|command| command.menu == menu) {
        if command.starts_group {
            ui.separator();
        }
        if item(commands, ui, command) {
            requests.push(commands.requested(command));
        }
        if command.name == command::file::OPEN.name {
            recent(&settings.known.recent, ui, requests);
        }
    }
    if menu == Menu::Window {
        ui.separator();
        navigation(settings.navigation, ui, requests);
    }
}

fn item(commands: Commands<'_>, ui: &mut Ui, command: &Command) -> bool {
    let why_not = commands.ready(command).err();
    let keys = first_keys(ui.ctx(), command);
    let on = commands.is_on(command);
    let detail = commands.detail(command);
    let name = detail.map_or(command.name.to_owned(), |detail| format!("{} {detail}", command.name));
    let button = Button::selectable(on, name).shortcut_text(keys);
    let draw = |ui: &mut Ui| {
        if on {
            // Keys are weak text, which is hard to read on the background of a switch that is on.
            ui.visuals_mut().weak_text_color = Some(ui.visuals().text_color());
        }
        ui.add_enabled(why_not.is_none(), button).on_hover_text(command.tooltip)
    };
    let response = ui.scope(draw).inner;
    if on {
        tick(ui, response.rect);
    }
    response
        .on_disabled_hover_text(format!(
            "{} Not available: {}.",
            command.tooltip,
            why_not.unwrap_or_default()
        ))
        .clicked()
}

/// Draws the tick of a switch that is on, in the margin of its entry.
fn tick(ui: &Ui, entry: Rect) {
    let stroke = Stroke::new(1.6, ui.visuals().strong_text_color());
    let at = pos2(entry.left() + MARGIN / 2.0, entry.center().y);
    let corners = [vec2(-4.0, 0.0), vec2(-1.0, 3.5), vec2(4.5, -4.0)].map(|corner| at + corner);
    ui.painter().add(Shape::line(corners.to_vec(), stroke));
}

/// Leaves a margin before the names of a menu, for ticks.
fn with_margin(ui: &mut Ui) {
    ui.spacing_mut().button_padding.x = MARGIN;
}

fn recent(projects: &[PathBuf], ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.add_enabled_ui(!projects.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for project in projects {
                let button = Button::new(project.display().to_string());
                if ui
                    .add_enabled(project.is_dir(), button)
                    .on_disabled_hover_text("This folder no longer exists.")
                    .clicked()
                {
                    requests.push(Request::Project(ProjectRequest::Open(project.clone())));
                }
            }
        });
    });
}

fn navigation(now: Navigation, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.menu_button("Mouse in the 3D view", |ui| {
        let mut wanted = now;
        for navigation in Navigation::ALL {
            ui.radio_value(&mut wanted, navigation, navigation.name());
        }
        if wanted != now {
            requests.push(WindowRequest::Navigate(wanted).into());
        }
    });
}
