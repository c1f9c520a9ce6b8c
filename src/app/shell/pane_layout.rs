//! The centre of the window: 3D view, photo and image layer as tabs, which can be dragged side by side.

use eframe::Storage;
use eframe::egui::{Id, Order, Rect, Response, Stroke, StrokeKind, Ui, WidgetText};
use egui_tiles::{Behavior, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse};

use super::flat::{layer_view, photo_view};
use super::textures::Textures;
use crate::panel::space::space_ui;
use crate::panel::space::view::SpacePaneView;
use crate::state::State;
use crate::state::panes::{KeyOwner, Pane, PaneVisibility, Panes};
use crate::state::request::Request;
use crate::state::space::memory::SpaceMemory;
use crate::widget::dialog;
use crate::widget::focus::{FocusKind, focused};
use crate::widget::look::focus_stroke;

/// The key of the layout in eframe's storage.
const LAYOUT: &str = "layout";

/// The width of the frame around the view to which keys belong, in points.
const FRAME: f32 = 1.0;

/// The layout of the panes: the views as tabs, some of them side by side.
pub struct PaneLayout {
    tree: Tree<Pane>,
}

impl Default for PaneLayout {
    fn default() -> Self {
        let tree = Tree::new_tabs(Id::unique("centre"), Pane::ALL.to_vec());
        Self { tree }
    }
}

impl PaneLayout {
    /// Loads the stored layout. Returns the default where none is stored, or where a view is missing or occurs twice.
    pub fn stored(storage: Option<&dyn Storage>) -> Self {
        let tree = storage.and_then(|storage| eframe::get_value::<Tree<Pane>>(storage, LAYOUT));
        let whole = |tree: &Tree<Pane>| Pane::ALL.iter().all(|pane| is_once_in(tree, *pane));
        tree.filter(whole).map_or_else(Self::default, |tree| Self { tree })
    }

    /// Stores the layout for the next run.
    pub fn store(&self, storage: &mut dyn Storage) {
        eframe::set_value(storage, LAYOUT, &self.tree);
    }

    /// Brings the tab of a view to the front.
    pub fn show(&mut self, pane: Pane) {
        self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(other) if *other == pane));
    }

    /// Mirrors in the state which views are visible, and which would be if each came to the front.
    pub fn notify(&self, panes: &mut Panes) {
        let seen_if = Pane::ALL.map(|pane| {
            let mut layout = Self { tree: self.tree.clone() };
            layout.show(pane);
            layout.seen()
        });
        panes.laid_out(self.seen(), seen_if);
    }

    /// Returns which views are in front of their tabs.
    fn seen(&self) -> PaneVisibility {
        let active = self.tree.active_tiles();
        Pane::ALL.map(|pane| self.tree.tiles.find_pane(&pane).is_some_and(|tile| active.contains(&tile)))
    }
}

fn is_once_in(tree: &Tree<Pane>, pane: Pane) -> bool {
    tree.tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(other) if *other == pane)).count() == 1
}

/// Returns whether a tile is a view or contains it.
fn holds(tiles: &Tiles<Pane>, tile: TileId, pane: Pane) -> bool {
    match tiles.get(tile) {
        Some(Tile::Pane(other)) => *other == pane,
        Some(Tile::Container(container)) => container.children().any(|child| holds(tiles, *child, pane)),
        None => false,
    }
}

/// Draws the views.
pub fn centre_ui(
    ui: &mut Ui,
    layout: &mut PaneLayout,
    state: &mut State,
    textures: &mut Textures,
    requests: &mut Vec<Request>,
) {
    let focus_is_beside = matches!(focused(ui.ctx()), FocusKind::List | FocusKind::Control);
    let mut views = Views { state, textures, requests, used: None, under_pointer: None };
    layout.tree.ui(&mut views, ui);
    let (used, under_pointer) = (views.used, views.under_pointer);
    used.into_iter().for_each(|pane| state.panes.use_pane(pane));
    state.panes.point(under_pointer, focus_is_beside);
}

/// Draws the 3D view on a copy of what it remembers.
fn space_view(ui: &mut Ui, state: &mut State, textures: &mut Textures, requests: &mut Vec<Request>) {
    let mut it = SpaceMemory::new(state);
    let Some(view) = SpacePaneView::new(state) else { return };
    space_ui(ui, &view, &mut it, &mut textures.space, &textures.photos, requests);
    it.put_back(state);
}

/// Returns whether the pointer is in a view: over its contents, its toolbars, or a window that lets keys through, but
/// not over a menu.
fn has_pointer(ui: &Ui, rect: Rect) -> bool {
    let Some(at) = ui.input(|input| input.pointer.hover_pos()) else { return false };
    let is_menu = ui.ctx().layer_id_at(at).is_some_and(|layer| layer.order > Order::Middle);
    rect.contains(at) && !is_menu
}

struct Views<'a> {
    state: &'a mut State,
    textures: &'a mut Textures,
    requests: &'a mut Vec<Request>,
    used: Option<Pane>,
    under_pointer: Option<Pane>,
}

impl Behavior<Pane> for Views<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        let rect = ui.max_rect();
        let used = ui.input(|input| input.pointer.any_pressed() || input.smooth_scroll_delta().y != 0.0);
        if used && ui.rect_contains_pointer(rect) {
            self.used = Some(*pane);
        }
        if has_pointer(ui, rect) {
            self.under_pointer = Some(*pane);
        }
        match pane {
            Pane::Space => space_view(ui, self.state, self.textures, self.requests),
            Pane::Photo => photo_view(ui, self.state, self.textures, self.requests),
            Pane::Layer => layer_view(ui, self.state, self.textures, self.requests),
        }
        self.frame_ui(ui, rect, *pane);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.name().into()
    }

    fn tab_title_for_tile(&mut self, tiles: &Tiles<Pane>, tile: TileId) -> WidgetText {
        // Views may be side by side under one tab.
        let held = Pane::ALL.into_iter().filter(|pane| holds(tiles, tile, *pane));
        held.map(Pane::name).collect::<Vec<_>>().join(" + ").into()
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<Pane>, tile: TileId, tab: Response) -> Response {
        if tab.clicked()
            && let Some(pane) = tiles.get_pane(&tile)
        {
            self.used = Some(*pane);
        }
        tab.on_hover_text("Drag the tab to the side of another view to see both.")
    }

    fn simplification_options(&self) -> SimplificationOptions {
        // A single view keeps its tab, by which it can be dragged back.
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn tab_bar_height(&self, _: &eframe::egui::Style) -> f32 {
        28.0
    }
}

impl Views<'_> {
    /// Draws a frame around the view to which keys belong.
    fn frame_ui(&self, ui: &Ui, rect: Rect, pane: Pane) {
        let has_keys = self.state.panes.key_owner() == KeyOwner::View(pane);
        if has_keys && !ui.ctx().text_edit_focused() && !dialog::is_open(ui.ctx()) {
            let stroke = Stroke::new(FRAME, focus_stroke(ui.visuals()).color);
            ui.painter().rect_stroke(rect, 0.0, stroke, StrokeKind::Inside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_that_comes_to_the_front_hides_the_others_of_its_tabs_and_what_would_be_seen_is_known_before() {
        let (mut layout, mut panes) = (PaneLayout::default(), Panes::default());
        layout.notify(&mut panes);
        assert_eq!((panes.used(), layout.seen()), (Pane::Space, [true, false, false]));
        for pane in [Pane::Layer, Pane::Photo] {
            panes.show(pane);
            panes.take_to_front().into_iter().for_each(|pane| layout.show(pane));
            let seen = Pane::ALL.map(|other| other == pane);
            assert_eq!((layout.seen(), Pane::ALL.map(|pane| panes.is_shown(pane))), (seen, seen));
            layout.notify(&mut panes);
            assert_eq!((panes.used(), Pane::ALL.map(|pane| panes.is_shown(pane))), (pane, seen));
        }
    }

    #[test]
    fn a_kept_layout_comes_back_and_one_that_lacks_a_view_does_not() {
        #[derive(Default)]
        struct Memory(std::collections::BTreeMap<String, String>);
        impl Storage for Memory {
            fn get_string(&self, key: &str) -> Option<String> {
                self.0.get(key).cloned()
            }
            fn set_string(&mut self, key: &str, value: String) {
                self.0.insert(key.into(), value);
            }
            fn remove_string(&mut self, key: &str) {
                self.0.remove(key);
            }
            fn flush(&mut self) {}
        }
        let mut storage = Memory::default();
        let mut layout = PaneLayout::default();
        layout.show(Pane::Photo);
        layout.store(&mut storage);
        assert!(PaneLayout::stored(Some(&storage)).seen()[Pane::Photo as usize]);
        layout.tree = Tree::new_tabs(Id::unique("centre"), vec![Pane::Photo]);
        layout.store(&mut storage);
        assert!(PaneLayout::stored(Some(&storage)).seen()[Pane::Space as usize]);
    }
}
