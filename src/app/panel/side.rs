//! The right side: the inspector, the filling of occluded areas, the photos' colour, and imported paint.

use eframe::egui::Ui;
use serde::{Deserialize, Serialize};

use super::{colour, fill, inspector, paint};
use crate::app::editor::Editor;
use crate::app::state::ask::Ask;

/// A tab of the right side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Tab {
    /// The inspector.
    #[default]
    Selection,
    /// Occluded areas.
    Fill,
    /// Exposures of photos.
    Colour,
    /// Imported paint.
    Paint,
}

impl Tab {
    const ALL: [Self; 4] = [Self::Selection, Self::Fill, Self::Colour, Self::Paint];

    fn name(self) -> &'static str {
        match self {
            Self::Selection => "Selection",
            Self::Fill => "Fill",
            Self::Colour => "Colour",
            Self::Paint => "Paint",
        }
    }

    fn tooltip(self) -> &'static str {
        match self {
            Self::Selection => "What is known of the selected photo, layer, object or face.",
            Self::Fill => "What photos do not show: how much of it is seen, and what fills it.",
            Self::Colour => "By how much photos are brighter than each other, and what to do about it.",
            Self::Paint => "What was painted and came home, and the imports that can be taken back.",
        }
    }
}

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
                editor.state.settings.side = tab;
            }
        }
    });
    ui.separator();
    match editor.state.settings.side {
        Tab::Selection => inspector::inspector_ui(editor, ui, asks),
        Tab::Fill => fill::fill_ui(editor, ui, asks),
        Tab::Colour => colour::colour_ui(editor, ui, asks),
        Tab::Paint => paint::paint_ui(editor, ui, asks),
    }
}
