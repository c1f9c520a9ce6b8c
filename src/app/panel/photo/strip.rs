//! The bar of mask tools, above the photo.

use eframe::egui::{Button, ComboBox, Slider, SliderClamping, Ui};

use super::view::PhotoView;
use crate::command::Commands;
use crate::command::{Command, keys_text, mask};
use crate::panel::bar::{Bar, BarPart, BarPosition};
use crate::panel::{button, named, switch_ui};
use crate::state::masking::queries::has_matte;
use crate::state::masking::tool::MaskTool;
use crate::state::masking::{Masking, RADII_PX};
use crate::state::request::{MaskRequest, Request};
use quadratura_document::stroke::BrushMode;

/// The width of the brush's slider, in points: all tools fit a window of usual size.
const SLIDER: f32 = 60.0;

/// The width of the choice of the matte brush, in points.
const MATTE_WIDTH: f32 = 96.0;

/// The parts of the bar, the most needed first.
fn parts<'a>() -> [BarPart<PhotoView<'a>, ()>; 8] {
    [
        BarPart::Tool(|ui, view, (), _, requests| toggle(view.commands, ui, &mask::BRUSH, "Brush", requests)),
        BarPart::Tool(|ui, view, (), _, requests| toggle(view.commands, ui, &mask::LASSO, "Lasso", requests)),
        BarPart::Tool(|ui, view, (), _, requests| {
            toggle(view.commands, ui, &mask::UNCOVER, "Erase mask", requests)
        }),
        BarPart::Tool(brush),
        BarPart::Gap,
        BarPart::Tool(suggestions),
        BarPart::Tool(|ui, view, (), _, requests| {
            toggle(view.commands, ui, &mask::SHOW, "Show masks", requests)
        }),
        BarPart::Tool(matte),
    ]
}

/// Draws the bar.
pub fn strip_ui(ui: &mut Ui, view: &PhotoView<'_>, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        ui.label("Mask").on_hover_text("Parts of the photo that must not be used: people, cars, flare.");
        let commands = view.commands;
        Bar { of: "masks", name: None, parts: &parts(), commands, view }.show(ui, &mut (), requests);
    });
}

/// Draws the slider of the brush. It is always there, so that selecting a tool does not move the photo.
fn brush(ui: &mut Ui, view: &PhotoView<'_>, (): &mut (), _: BarPosition, requests: &mut Vec<Request>) {
    let brush = view.masking.tool.is_some_and(MaskTool::is_brush);
    ui.add_enabled_ui(brush, |ui| ui.horizontal(|ui| radius(ui, view, requests)));
}

/// Draws the choice of the matte brush, where the photo has mattes.
fn matte(ui: &mut Ui, view: &PhotoView<'_>, (): &mut (), place: BarPosition, requests: &mut Vec<Request>) {
    if !view.stack().is_some_and(has_matte) {
        return;
    }
    let mut choices = |ui: &mut Ui| {
        for command in mask::MATTES {
            let on = view.commands.is_on(command);
            let may = view.commands.ready(command);
            let choice = ui.add_enabled(may.is_ok(), Button::selectable(on, command.name));
            let choice =
                choice.on_hover_text(command.tooltip).on_disabled_hover_text(may.err().unwrap_or_default());
            if choice.clicked() {
                requests.push(view.commands.requested(command));
            }
        }
    };
    if place == BarPosition::Menu {
        choices(ui);
        return;
    }
    // Shorter than the names of the commands, which would be cut off here.
    let text = match view.masking.tool {
        Some(MaskTool::Matte(BrushMode::SeeThrough)) => "Matte: erase",
        Some(MaskTool::Matte(BrushMode::Solid)) => "Matte: solid",
        Some(MaskTool::Matte(_)) => "Matte: solve",
        _ => "Matte brush",
    };
    let combo = ComboBox::from_id_salt("matte brush").selected_text(text).width(MATTE_WIDTH).truncate();
    named(&combo.show_ui(ui, choices).response, "Matte brush");
}

fn suggestions(ui: &mut Ui, view: &PhotoView<'_>, (): &mut (), _: BarPosition, requests: &mut Vec<Request>) {
    if view.masking.suggested.count() > 0 {
        toggle(view.commands, ui, &mask::SUGGESTIONS, "Show suggestions", requests);
    } else {
        button(view.commands, ui, &mask::LOOK, requests);
    }
}

/// Draws a switch with a short text; the bar names its subject.
fn toggle(
    commands: Commands<'_>,
    ui: &mut Ui,
    command: &'static Command,
    text: &str,
    requests: &mut Vec<Request>,
) {
    let on = commands.is_on(command);
    let keys = command.keys.first().map(|keys| format!(" ({})", keys_text(ui.ctx(), keys)));
    let tooltip = format!("{}{}", command.tooltip, keys.unwrap_or_default());
    if switch_ui(ui, on, text).on_hover_text(tooltip).clicked() {
        requests.push(commands.requested(command));
    }
}

fn radius(ui: &mut Ui, view: &PhotoView<'_>, requests: &mut Vec<Request>) {
    let Some(size) = view.photo_size() else { return };
    let before = view.masking.radius_px(size);
    let mut radius = before;
    ui.spacing_mut().slider_width = SLIDER;
    let slider = Slider::new(&mut radius, RADII_PX)
        .logarithmic(true)
        .clamping(SliderClamping::Always)
        .suffix(" px")
        .custom_formatter(|value, _| format!("{value:.1}"))
        .text("size");
    let larger = mask::LARGER.keys.first().map(|keys| keys_text(ui.ctx(), keys)).unwrap_or_default();
    let smaller = mask::SMALLER.keys.first().map(|keys| keys_text(ui.ctx(), keys)).unwrap_or_default();
    ui.add(slider).on_hover_text(format!(
        "Brush size, in pixels of the photo; Ctrl+wheel, {larger} and {smaller} change it, too."
    ));
    if radius != before {
        requests.push(MaskRequest::ResizeBrush(radius / before).into());
    }
}

/// Describes what the mouse does while a tool is in use.
pub fn hint(masking: &Masking, ui: &Ui) -> Option<String> {
    let way = match masking.tool? {
        MaskTool::Lasso => "A line around an area",
        MaskTool::Brush => "A drag",
        MaskTool::Matte(mode) => {
            let does = match mode {
                BrushMode::SeeThrough => "erases",
                BrushMode::Solid => "makes solid",
                _ => "solves",
            };
            // No longer than the hint of the other tools: windows of usual size have one line for it.
            return Some(format!(
                "A drag {does} the selected or nearest see-through layer. Space pans, Esc puts the tool away."
            ));
        }
    };
    let held = ui.input(|input| input.modifiers.command || input.modifiers.alt);
    let does = if masking.uncovers ^ held { "erases the mask" } else { "masks" };
    Some(format!(
        "{way} {does}; Ctrl reverses this. Space or the middle button pans, Esc puts the tool away."
    ))
}
