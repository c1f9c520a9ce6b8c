//! The photo view: a photo at full resolution with the sorted layers drawn over it, which can be hidden one by one.

pub mod drawing;
mod hand;
pub mod masked;
mod over;
pub mod picture;
mod placed;
mod pointing;
mod reasons;
mod strip;
mod suggested;
mod tools;
pub mod view;

use eframe::egui::{CentralPanel, Panel, Role, Sense, Ui, WidgetInfo};

use self::hand::{StrokeTarget, draws, hand_ui};
use self::masked::{MaskMeshes, masks_ui};
use self::picture::{SelectedHidden, picture_ui};
use self::placed::PlacedPhoto;
use self::view::PhotoView;
use super::flat::placement::screen_rect;
use super::flat::{FlatTextures, LeftButton, background, navigate, nothing_ui};
use super::pictures;
use crate::state::flat::photo::PhotoPane;
use crate::state::masking::stroke::MaskStroke;
use crate::state::panels::PanelSizes;
use crate::state::request::{FlatRequest, Request};
use crate::widget::focus::{FocusKind, mark};
use crate::widget::sized::{PanelEdge, sized_panel};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;

/// The view width from which a list is beside the photo, in points.
const WIDE: f32 = 700.0;
/// The largest share of the view that the list takes.
const LIST_MOST: f32 = 0.5;
/// The height of the lines below the photo, in points.
const STATUS: f32 = 50.0;

/// State of the view that lasts from frame to frame.
pub struct PhotoMemory<'a> {
    /// The view.
    pub pane: &'a mut PhotoPane,
    /// The stroke of a mask tool.
    pub stroke: &'a mut Option<MaskStroke>,
    /// The sizes of the lists beside and below the photo.
    pub sizes: &'a mut PanelSizes,
}

/// Textures and meshes that the view reuses.
pub struct PhotoViewTextures<'a> {
    /// The thumbnails, which are shown until photos are loaded.
    pub photos: &'a pictures::PhotoTextures,
    /// The pictures of the flat views.
    pub flat: &'a mut FlatTextures,
    /// The masks.
    pub masks: &'a mut MaskMeshes,
    /// The areas of the selection that are hidden in the photo.
    pub selected_hidden: &'a mut Option<SelectedHidden>,
}

/// Draws the view and handles its input.
pub fn photo_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    memory: PhotoMemory<'_>,
    textures: &mut PhotoViewTextures<'_>,
    requests: &mut Vec<Request>,
) {
    let Some(photo) = view.photo else {
        return nothing_ui(ui, "Select a photo in the list to see it here.");
    };
    let PhotoMemory { pane, stroke, sizes } = memory;
    pane.turn_to(photo);
    Panel::top("photo tools").show(ui, |ui| {
        tools::tools_ui(ui, view, pane, photo, requests);
        strip::strip_ui(ui, view, requests);
    });
    let status = Panel::bottom("photo status").exact_size(STATUS);
    status.show(ui, |ui| pointing::status_ui(ui, view, pane));
    if pane.reasons_shown {
        untextured_ui(ui, view, pane, sizes, photo, requests);
    }
    let central = CentralPanel::no_frame();
    central.show(ui, |ui| canvas_ui(ui, view, pane, stroke, textures, photo, requests));
    requests.push(FlatRequest::WantPhoto(photo).into());
}

/// Draws the list of untextured faces: beside the photo where both fit, otherwise below it.
fn untextured_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    sizes: &mut PanelSizes,
    photo: PhotoId,
    requests: &mut Vec<Request>,
) {
    let room = ui.available_size() * LIST_MOST;
    let (edge, name, size, most) = match ui.available_width() {
        WIDE.. => (PanelEdge::Right, "untextured faces", &mut sizes.faces_width, room.x),
        _ => (PanelEdge::Bottom, "untextured faces below", &mut sizes.faces_below, room.y),
    };
    sized_panel(ui, edge, name, size, most, |ui| reasons::reasons_ui(ui, view, pane, photo, requests));
}

fn canvas_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    stroke: &mut Option<MaskStroke>,
    textures: &mut PhotoViewTextures<'_>,
    photo: PhotoId,
    requests: &mut Vec<Request>,
) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Photo view"));
    mark(&response, FocusKind::View);
    let Some(bounds) = bounds(view, photo) else { return };
    let fill = background(ui);
    ui.painter_at(rect).rect_filled(rect, 0.0, fill);
    pane.show_sought(screen_rect(rect));
    let left =
        if draws(view, ui) || pane.grip.edge.is_some() { LeftButton::Draws } else { LeftButton::Moves };
    let seen = navigate(&mut pane.view.placement, ui, &response, rect, bounds, left);
    let placed = PlacedPhoto { photo, bounds, seen };
    let target = StrokeTarget { placed: &placed, line: pane.line };
    hand_ui(ui, view, stroke, &response, &target, requests);
    picture_ui(ui, view, pane, textures, &placed, requests);
    drawing::drawing_ui(ui, view, pane, &placed);
    masks_ui(ui, view, stroke.as_ref(), textures.masks, &placed, requests);
    suggested::suggested_ui(ui, view, pane, &response, &placed, requests);
    pointing::point(ui, view, pane, &response, &placed, requests);
    // Nothing covers the photo during a stroke.
    let line = if stroke.is_none() { over::line_ui(ui, view, rect, photo, requests) } else { None };
    pane.line = line.map(screen_rect);
}

fn bounds(view: &PhotoView<'_>, photo: PhotoId) -> Option<PixelRect> {
    let camera = &view.session?.opened.site.photo(photo).camera;
    Some(PixelRect { x: 0, y: 0, w: camera.width, h: camera.height })
}
