//! Resizable panels: each keeps the user's size, up to its share of the window.

use eframe::egui::containers::panel::{Panel, PanelState};
use eframe::egui::{Rect, Ui, UiBuilder, Vec2};

/// The edge of the surrounding area that a panel is attached to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PanelEdge {
    /// The left edge.
    Left,
    /// The right edge.
    Right,
    /// The top edge.
    Top,
    /// The bottom edge.
    Bottom,
}

/// The smallest size of a panel, in points.
const LEAST: f32 = 90.0;
/// The smallest difference between two sizes, in points: panels are laid out in whole pixels.
const SAME: f32 = 1.0;

/// Draws a resizable panel. `wanted` is the user's last size, `most` the limit. Contents wider than the panel are
/// clipped: a panel that grew with its contents would lose the user's size.
pub fn sized_panel(
    ui: &mut Ui,
    edge: PanelEdge,
    salt: &'static str,
    wanted: &mut f32,
    most: f32,
    contents: impl FnOnce(&mut Ui),
) {
    let least = LEAST.min(most);
    let size = wanted.clamp(least, most);
    let panel = match edge {
        PanelEdge::Left => Panel::left(salt),
        PanelEdge::Right => Panel::right(salt),
        PanelEdge::Top => Panel::top(salt),
        PanelEdge::Bottom => Panel::bottom(salt),
    };
    // The size is set in every frame: the panel would otherwise keep that of the smallest window so far.
    let outer_rect = Rect::from_min_size(ui.max_rect().min, Vec2::splat(size));
    let id = ui.scope_id().with(salt);
    ui.data_mut(|data| data.insert_persisted(id, PanelState { outer_rect }));
    let panel = panel.resizable(true).default_size(size).size_range(least..=most);
    let shown = panel.show(ui, |ui| kept_within(ui, contents)).response.rect;
    let now = match edge {
        PanelEdge::Left | PanelEdge::Right => shown.width(),
        PanelEdge::Top | PanelEdge::Bottom => shown.height(),
    };
    // Only a drag by the user changes it.
    if (now - size).abs() > SAME {
        *wanted = now;
    }
}

/// Draws contents in exactly the available space.
fn kept_within(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    contents(&mut ui.new_child(UiBuilder::new().max_rect(rect)));
    ui.advance_cursor_after_rect(rect);
}
