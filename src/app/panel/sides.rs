//! The sides around the views: photos and lists on the left, the inspector and its neighbours on the right.

use eframe::egui::Ui;

use super::lists::outliner::outliner_ui;
use super::photos::{Thumbnails, photos_ui};
use super::side::side_ui;
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::lists::ListsState;
use crate::app::state::panels::PanelSizes;
use crate::app::widget::sized::{PanelEdge, sized_panel};

/// The largest share of the window's width that the left side takes: views keep their space in small windows and with
/// large text.
const LEFT_MOST: f32 = 0.27;
/// The largest share of the window's width that the right side takes: its pages have two columns.
const RIGHT_MOST: f32 = 0.33;

/// Draws the lists on the left and the inspector on the right. `lists` are out of the state meanwhile.
pub fn sides_ui(
    editor: &mut Editor,
    sizes: &mut PanelSizes,
    lists: &mut ListsState,
    ui: &mut Ui,
    asks: &mut Vec<Ask>,
) {
    let width = ui.available_width();
    if editor.state.settings.lists_shown {
        let (place, most) = ((PanelEdge::Left, "outliner"), LEFT_MOST * width);
        let photos = &mut sizes.photos;
        let thumbnails: Thumbnails<'_> = &|photo| editor.work.pictures.small(photo).map(Into::into);
        sized_panel(ui, place, &mut sizes.left, most, |ui| {
            left_ui(ui, &editor.state, thumbnails, (photos, lists), asks);
        });
    }
    if editor.state.settings.side_shown {
        let (place, most) = ((PanelEdge::Right, "inspector"), RIGHT_MOST * width);
        sized_panel(ui, place, &mut sizes.right, most, |ui| side_ui(editor, ui, asks));
    }
}

/// The largest share of the left side's height that the photos take: the lists below are equally important.
const PHOTOS_MOST: f32 = 0.55;

/// Draws the photos above, objects and layers below. `height` is that of the photos, as the user set it, in points.
fn left_ui(
    ui: &mut Ui,
    state: &State,
    thumbnails: Thumbnails<'_>,
    (height, lists): (&mut f32, &mut ListsState),
    asks: &mut Vec<Ask>,
) {
    let most = PHOTOS_MOST * ui.available_height();
    sized_panel(ui, (PanelEdge::Top, "photos"), height, most, |ui| photos_ui(ui, state, thumbnails, asks));
    outliner_ui(ui, state, lists, asks);
}
