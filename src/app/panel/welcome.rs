//! The welcome page, which is shown when no project is open.

use eframe::egui::{Align, Button, Layout, RichText, Role, ScrollArea, Ui, Vec2, WidgetInfo, vec2};

use super::opening::place::{is_entered, line};
use super::small_button;
use crate::command::{Command, Commands, file, first_keys};
use crate::state::State;
use crate::state::opening::DialogRequest;
use crate::state::opening::place::typed_path;
use crate::state::request::{ProjectRequest, Request};
use crate::state::running::JobKind;
use crate::widget::spinner::Spinner;
use std::path::PathBuf;

/// The size of the button of a recent project, in points.
const RECENT: Vec2 = vec2(360.0, 28.0);
/// The size of a row of a recent project with its remove button, in points.
const ROW: Vec2 = vec2(394.0, 28.0);
/// The number of characters of a path that fit beside a name.
const LONGEST: usize = 30;
/// The space above, as a share of the window's height.
const ABOVE: f32 = 0.12;

/// What the welcome page shows.
pub struct WelcomeView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// Whether a project is being opened.
    opens: bool,
    /// The recent projects, the last one first.
    recent: &'a [PathBuf],
}

impl<'a> WelcomeView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            opens: state.running.runs(JobKind::Open),
            recent: &state.settings.known.recent,
        }
    }
}

/// Draws the welcome page.
pub fn welcome_ui(view: &WelcomeView<'_>, path: &mut String, ui: &mut Ui, requests: &mut Vec<Request>) {
    let above = ABOVE * ui.available_height();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| contents(view, path, above, ui, requests));
}

fn contents(view: &WelcomeView<'_>, path: &mut String, above: f32, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.vertical_centered(|ui| {
        ui.add_space(above);
        ui.label(RichText::new("Quadratura").size(40.0).strong());
        ui.label(
            RichText::new("Turn photos of a site into layers to paint on, and a scene to move through.")
                .size(16.0),
        );
        ui.add_space(24.0);
        if view.opens {
            ui.add(Spinner::new().size(32.0));
            ui.label("Opening…");
            return;
        }
        large(view, ui, &file::NEW, requests);
        ui.add_space(4.0);
        large(view, ui, &file::OPEN, requests);
        ui.add_space(4.0);
        large(view, ui, &file::SAMPLE, requests);
        ui.add_space(8.0);
        ui.weak("or drop a site folder or project folder on this window, or type its path:");
        typed(path, ui, requests);
        recent(view, ui, requests);
    });
}

fn typed(typed: &mut String, ui: &mut Ui, requests: &mut Vec<Request>) {
    let line = line(ui, typed, "Folder of a site or project", 300.0);
    let path = typed_path(typed);
    if is_entered(&line) {
        match path.exists() {
            true => {
                requests.push(Request::Project(ProjectRequest::Dialog(DialogRequest::Take(path.clone()))))
            }
            // The text field keeps the focus.
            false => line.request_focus(),
        }
    }
    if !typed.trim().is_empty() && !path.exists() {
        ui.weak("There is no such folder.");
    }
}

fn large(view: &WelcomeView<'_>, ui: &mut Ui, command: &'static Command, requests: &mut Vec<Request>) {
    let keys = first_keys(ui.ctx(), command);
    let button =
        Button::new(RichText::new(command.name).size(16.0)).shortcut_text(keys).min_size(vec2(300.0, 38.0));
    let ready = view.commands.ready(command).is_ok();
    if ui.add_enabled(ready, button).on_hover_text(command.tooltip).clicked() {
        requests.push(view.commands.requested(command));
    }
}

fn recent(view: &WelcomeView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    if view.recent.is_empty() {
        return;
    }
    ui.add_space(22.0);
    ui.strong("Recent projects");
    for project in view.recent {
        let there = project.is_dir();
        let name = project.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let row = |ui: &mut Ui| {
            let above = project.parent().map(|above| above.display().to_string()).unwrap_or_default();
            let button = Button::new(&name).shortcut_text(shortened(&above)).min_size(RECENT);
            let response = ui.add_enabled(there, button).on_hover_text(project.display().to_string());
            response.widget_info(|| WidgetInfo::labeled(Role::Button, there, &name));
            let gone = format!("{} no longer exists.", project.display());
            if response.on_disabled_hover_text(gone).clicked() {
                requests.push(Request::Project(ProjectRequest::Open(project.clone())));
            }
            let tooltip = format!("Removes {name} from this list; its files are kept.");
            if small_button(ui, "×", &format!("Remove {name} from list"), &tooltip).clicked() {
                requests.push(Request::Project(ProjectRequest::Forget(project.clone())));
            }
        };
        ui.allocate_ui_with_layout(ROW, Layout::left_to_right(Align::Center), row);
    }
}

/// Returns the end of a path, which says more than its start.
fn shortened(path: &str) -> String {
    let letters = path.chars().count();
    match letters > LONGEST {
        true => format!("…{}", path.chars().skip(letters - LONGEST).collect::<String>()),
        false => path.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_path_the_end_is_shown() {
        assert_eq!(shortened("/ada/sites"), "/ada/sites");
        let long = shortened("/ada/a disk with a rather long name/work/2024/sites");
        assert_eq!(long.chars().count(), LONGEST + 1);
        assert!(long.starts_with('…') && long.ends_with("/2024/sites"), "{long}");
    }
}
