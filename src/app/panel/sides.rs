//! The sides around the views: photos and lists on the left, the inspector and its neighbours on the right.

use eframe::egui::Ui;

use super::lists::outliner::outliner_ui;
use super::paint::PaintTextures;
use super::photos::{PhotosView, ThumbnailLookup, photos_ui};
use super::pictures::PhotoTextures;
use super::side::side_ui;
use crate::state::State;
use crate::state::lists::ListsState;
use crate::state::panels::PanelSizes;
use crate::state::request::Request;
use crate::widget::sized::{PanelEdge, sized_panel};

/// The largest share of the window's width that the left side takes: views keep their space in small windows and with
/// large text.
const LEFT_MOST: f32 = 0.27;
/// The largest share of the window's width that the right side takes: its pages have two columns.
const RIGHT_MOST: f32 = 0.33;

/// Draws the lists on the left and the inspector on the right. `lists` are out of the state meanwhile.
pub fn sides_ui(
    ui: &mut Ui,
    state: &State,
    sizes: &mut PanelSizes,
    lists: &mut ListsState,
    photos: &PhotoTextures,
    paint: &mut PaintTextures,
    requests: &mut Vec<Request>,
) {
    let width = ui.available_width();
    if state.settings.lists_shown {
        let most = LEFT_MOST * width;
        let height = &mut sizes.photos;
        let thumbnails: ThumbnailLookup<'_> = &|photo| photos.small(photo).map(Into::into);
        sized_panel(ui, PanelEdge::Left, "outliner", &mut sizes.left, most, |ui| {
            left_ui(ui, state, thumbnails, height, lists, requests);
        });
    }
    if state.settings.side_shown {
        let most = RIGHT_MOST * width;
        sized_panel(ui, PanelEdge::Right, "inspector", &mut sizes.right, most, |ui| {
            side_ui(ui, state, paint, requests)
        });
    }
}

/// The largest share of the left side's height that the photos take: the lists below are equally important.
const PHOTOS_MOST: f32 = 0.55;

/// Draws the photos above, objects and layers below. `height` is that of the photos, as the user set it, in points.
fn left_ui(
    ui: &mut Ui,
    state: &State,
    thumbnails: ThumbnailLookup<'_>,
    height: &mut f32,
    lists: &mut ListsState,
    requests: &mut Vec<Request>,
) {
    let most = PHOTOS_MOST * ui.available_height();
    sized_panel(ui, PanelEdge::Top, "photos", height, most, |ui| {
        photos_ui(ui, &PhotosView::new(state), thumbnails, requests)
    });
    outliner_ui(ui, state, lists, requests);
}
