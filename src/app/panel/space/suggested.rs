//! Suggestions for the model in the 3D view.

use eframe::egui::{Pos2, Rect, Response, Ui};
use glam::DVec3;

use super::overlay::{WorldCanvas, seen_from};
use super::px_of;
use super::view::SpacePaneView;
use crate::panel::model_suggestions::glass::GlassView;
use crate::state::model_suggestions::EdgeGrip;
use crate::state::request::Request;
use crate::state::space::memory::SpaceMemory;

/// Draws suggestions as glass, and drags their edges.
pub fn suggested_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    let Some(offered) = view.suggested else {
        it.grip = EdgeGrip::default();
        return;
    };
    let viewpoint = seen_from(view, it);
    let canvas = WorldCanvas { painter: ui.painter_at(rect), rect, view: viewpoint };
    let (density, size_px) = (ui.ctx().pixels_per_point(), it.size_px);
    let glass = GlassView {
        painter: canvas.painter.clone(),
        pose: viewpoint.pose,
        place: &|point: DVec3| canvas.place(point),
        ray: &|at: Pos2| viewpoint.ray(px_of(at - rect.min, density), size_px),
    };
    glass.hand(ui, offered, &mut it.grip, response, requests);
    glass.draw(offered, &it.grip);
}
