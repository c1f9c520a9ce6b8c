//! The right side: the inspector, the filling of occluded areas, the photos' colour, and imported paint.

use eframe::egui::Ui;

use super::colour::ColourView;
use super::fill::FillView;
use super::inspect::view::InspectorView;
use super::paint::{PaintTextures, PaintView};
use super::{colour, fill, inspector, paint};
use crate::state::State;
use crate::state::panels::Tab;
use crate::state::request::{Request, WindowRequest};

/// The width below which tabs are close to each other, in points.
const ROOM: f32 = 270.0;

/// Draws the right side.
pub fn side_ui(ui: &mut Ui, state: &State, paint: &mut PaintTextures, requests: &mut Vec<Request>) {
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        if ui.available_width() < ROOM {
            (ui.spacing_mut().item_spacing.x, ui.spacing_mut().button_padding.x) = (3.0, 5.0);
        }
        for tab in Tab::ALL {
            let shown = state.settings.side == tab;
            if ui.selectable_label(shown, tab.name()).on_hover_text(tab.tooltip()).clicked() {
                requests.push(WindowRequest::ShowTab(tab).into());
            }
        }
    });
    ui.separator();
    match state.settings.side {
        Tab::Selection => inspector::inspector_ui(ui, &InspectorView::new(state), requests),
        Tab::Fill => fill::fill_ui(&FillView::new(state), ui, requests),
        Tab::Colour => colour::colour_ui(&ColourView::new(state), ui, requests),
        Tab::Paint => paint::paint_ui(ui, &PaintView::new(state), paint, requests),
    }
}
