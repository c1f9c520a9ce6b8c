//! Panels that have the size their user gave them, and never more than their share of the window.

use eframe::egui::containers::panel::{Panel, PanelState};
use eframe::egui::{Rect, Ui, UiBuilder, Vec2};
use serde::{Deserialize, Serialize};

/// Sizes of panels as their user wants them, in points. A small window shows less, and a larger one that again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sizes {
    /// Photos and lists.
    pub left: f32,
    /// What is known of the selection.
    pub right: f32,
    /// Of the left side, the photos.
    pub photos: f32,
    /// What was said.
    pub notes: f32,
    /// The line of time.
    pub flight: f32,
    /// Untextured faces beside a photo.
    pub faces_beside: f32,
    /// Untextured faces below a photo.
    pub faces_below: f32,
}

impl Default for Sizes {
    fn default() -> Self {
        Self {
            left: 290.0,
            right: 310.0,
            photos: 340.0,
            notes: 170.0,
            flight: 150.0,
            faces_beside: 300.0,
            faces_below: 180.0,
        }
    }
}

/// An edge of what is around a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Its left side.
    Left,
    /// Its right side.
    Right,
    /// Above.
    Top,
    /// Below.
    Bottom,
}

/// No panel is smaller, in points.
const LEAST: f32 = 90.0;
/// Sizes are told apart from here on, in points: a panel is laid out in whole pixels.
const SAME: f32 = 1.0;

/// Shows a panel that can be resized. `wanted`: the size that its user gave it last. `most`: it is not larger now. What is
/// wider than the panel ends at its border: a panel that grew with what it holds would not be its user's any more.
pub fn sized_panel(
    ui: &mut Ui,
    (edge, salt): (Edge, &'static str),
    wanted: &mut f32,
    most: f32,
    contents: impl FnOnce(&mut Ui),
) {
    let least = LEAST.min(most);
    let size = wanted.clamp(least, most);
    let panel = match edge {
        Edge::Left => Panel::left(salt),
        Edge::Right => Panel::right(salt),
        Edge::Top => Panel::top(salt),
        Edge::Bottom => Panel::bottom(salt),
    };
    // As it was in the frame before, it would stay as small as the smallest window.
    let outer_rect = Rect::from_min_size(ui.max_rect().min, Vec2::splat(size));
    let id = ui.scope_id().with(salt);
    ui.data_mut(|data| data.insert_persisted(id, PanelState { outer_rect }));
    let panel = panel.resizable(true).default_size(size).size_range(least..=most);
    let shown = panel.show(ui, |ui| kept_within(ui, contents)).response.rect;
    let now = match edge {
        Edge::Left | Edge::Right => shown.width(),
        Edge::Top | Edge::Bottom => shown.height(),
    };
    // Nothing else than a hand changes it.
    if (now - size).abs() > SAME {
        *wanted = now;
    }
}

/// Draws contents in all the room that there is, and in no more.
fn kept_within(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    contents(&mut ui.new_child(UiBuilder::new().max_rect(rect)));
    ui.advance_cursor_after_rect(rect);
}
