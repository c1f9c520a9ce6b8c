//! The bars above the photo: hidden layers, zoom, overlays.

use eframe::egui::{Color32, RichText, Sense, Slider, Ui, Vec2};

use super::drawing::colour_of_depth;
use super::view::PhotoView;
use crate::command::flat;
use crate::panel::bar::{Bar, BarPart, BarPosition};
use crate::panel::flat::scale_ui;
use crate::panel::{named, switch_ui};
use crate::state::flat::photo::PhotoPane;
use crate::state::request::Request;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;

/// The size of the progress indicator, in points.
const SPINNER: f32 = 14.0;
/// The gap between the numbers of visibility layers, in points.
const BETWEEN: f32 = 3.0;

/// The parts of the first bar, the most needed first.
fn looked_at<'a>() -> [BarPart<PhotoView<'a>, PhotoPane>; 5] {
    [
        BarPart::Tool(hidden_layers),
        BarPart::Gap,
        BarPart::Tool(scale),
        BarPart::Gap,
        BarPart::Tool(untextured),
    ]
}
/// The parts of the second bar: switches of overlays.
fn drawn<'a>() -> [BarPart<PhotoView<'a>, PhotoPane>; 8] {
    [
        BarPart::Switch(&flat::OUTLINES),
        BarPart::Tool(legend),
        BarPart::Gap,
        BarPart::Switch(&flat::HATCHING),
        BarPart::Switch(&flat::RECTANGLES),
        BarPart::Switch(&flat::FILLING),
        BarPart::Switch(&flat::PAINT),
        BarPart::Switch(&flat::EVEN),
    ]
}

/// Draws the bars.
pub fn tools_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    photo: PhotoId,
    requests: &mut Vec<Request>,
) {
    let Some(session) = view.session else { return };
    let name = &session.opened.site.photo(photo).name;
    let (name, commands) = (Some(&name[..]), view.commands);
    Bar { of: "photo", name, parts: &looked_at(), commands, view }.show(ui, pane, requests);
    Bar { of: "overlays", name: None, parts: &drawn(), commands, view }.show(ui, pane, requests);
}

/// Returns the number of visibility layers of the photo; 0 before it is built.
fn depth(view: &PhotoView<'_>) -> u32 {
    view.stack().map_or(0, |stack| stack.visibility_layers.len() as u32)
}

fn hidden_layers(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    _: BarPosition,
    _: &mut Vec<Request>,
) {
    let depth = depth(view);
    let busy = view.flat.loading.is_busy();
    ui.horizontal(|ui| {
        ui.add_enabled_ui(depth > 0, |ui| {
            let slider = Slider::new(&mut pane.hidden_layers, 0..=depth);
            let slider = slider.custom_formatter(move |value, _| format!("{value:.0} of {depth} layers"));
            let slider = ui.horizontal(|ui| ui.add(slider.text("hidden"))).inner;
            named(&slider, "layers hidden");
            slider.on_hover_text("Hides visibility layers, nearest first, to show the layers behind them.");
        });
        // The space is always reserved, so that nothing moves when the indicator appears.
        let (rect, _) = ui.allocate_exact_size(Vec2::splat(SPINNER), Sense::hover());
        if busy {
            Spinner::new().paint_at(ui, rect);
        }
    });
}

fn untextured(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    let untextured = view.stack().map_or(0, |stack| stack.untextured.len());
    let text = format!("{} ({untextured})", flat::UNTEXTURED.name);
    let list = switch_ui(ui, pane.reasons_shown, text);
    if list.on_hover_text(flat::UNTEXTURED.tooltip).clicked() {
        requests.push(view.commands.requested(&flat::UNTEXTURED));
    }
}

fn scale(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    let magnification = pane.view.placement.magnification(ui.ctx().pixels_per_point());
    scale_ui(view.commands, ui, magnification, requests);
}

/// Draws the legend of outlines: the visibility layers, from the front.
fn legend(ui: &mut Ui, view: &PhotoView<'_>, pane: &mut PhotoPane, _: BarPosition, _: &mut Vec<Request>) {
    let depth = if view.flat.switches.outlines { depth(view) } else { 0 };
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = BETWEEN;
        for layer in 0..depth {
            let gone = layer < pane.hidden_layers;
            let text = RichText::new(format!(" {} ", layer + 1));
            // The text is dark on its colour: light text on these colours is hard to read.
            let text = match gone {
                true => text.strikethrough().weak(),
                false => text.color(Color32::BLACK).background_color(colour_of_depth(layer)),
            };
            let label = ui.label(text);
            label.on_hover_text(match layer {
                0 => "Outlines of visibility layer 1, the nearest.".to_owned(),
                _ => format!("Outlines of visibility layer {}; 1 is the nearest.", layer + 1),
            });
        }
    });
}
