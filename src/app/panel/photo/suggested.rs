//! Suggestions for the model over the photo.

use eframe::egui::{Pos2, Response, Ui};
use glam::DVec3;

use super::placed::PlacedPhoto;
use super::view::PhotoView;
use crate::panel::model_suggestions::glass::GlassView;
use crate::state::flat::photo::PhotoPane;
use crate::state::model_suggestions::EdgeGrip;
use crate::state::request::Request;

/// Draws suggestions as glass, and drags their edges while no mask tool is in use.
pub fn suggested_ui(
    ui: &Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    response: &Response,
    placed: &PlacedPhoto,
    requests: &mut Vec<Request>,
) {
    let (Some(offered), Some(session)) = (view.suggested, view.session) else {
        pane.grip = EdgeGrip::default();
        return;
    };
    let photo = session.opened.site.photo(placed.photo);
    let glass = GlassView {
        painter: ui.painter_at(placed.seen.rect),
        pose: photo.pose,
        place: &|point: DVec3| {
            let seen = photo.camera.image_from_camera(photo.pose.camera_from_world(point));
            seen.map(|px| placed.seen.at(px))
        },
        ray: &|at: Pos2| {
            photo.pose.rotation.transpose() * photo.camera.ray_in_camera(placed.seen.position(at))
        },
    };
    if view.masking.tool.is_none() {
        glass.hand(ui, offered, &mut pane.grip, response, requests);
    }
    glass.draw(offered, &pane.grip);
}
