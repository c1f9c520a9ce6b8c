//! The right side: the inspector, the filling of occluded areas, the photos' colour, and imported paint.

use eframe::egui::Ui;

use super::{colour, fill, inspector, paint};
use crate::app::editor::Editor;
use crate::app::state::ask::{Ask, WindowAsk};
use crate::app::state::panels::Tab;

/// The width below which tabs are close to each other, in points.
const ROOM: f32 = 270.0;

/// Draws the right side.
pub fn side_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        if ui.available_width() < ROOM {
            (ui.spacing_mut().item_spacing.x, ui.spacing_mut().button_padding.x) = (3.0, 5.0);
        }
        for tab in Tab::ALL {
            let shown = editor.state.settings.side == tab;
            if ui.selectable_label(shown, tab.name()).on_hover_text(tab.tooltip()).clicked() {
                asks.push(WindowAsk::ShowTab(tab).into());
            }
        }
    });
    ui.separator();
    match editor.state.settings.side {
        Tab::Selection => inspector::inspector_ui(editor, ui, asks),
        Tab::Fill => fill::fill_ui(editor, ui, asks),
        Tab::Colour => colour::colour_ui(editor, ui, asks),
        Tab::Paint => paint::paint_ui(ui, &editor.state, &mut editor.textures.paint, asks),
    }
}
