//! The photo view: a photo at full resolution with the sorted layers drawn over it, which can be hidden one by one.

pub mod drawing;
pub mod loading;
pub mod pointing;
pub mod reasons;
pub mod tools;

use eframe::egui::{CentralPanel, Frame, Panel, Pos2, Rect, Role, Sense, Ui, UiBuilder, WidgetInfo};
use glam::DVec2;

use self::drawing::Picked;
pub use self::drawing::colour_of_depth;
use self::loading::Loading;
use self::pointing::Pointed;
pub use self::tools::scale_ui;
use super::command::{Command, layers};
use super::flat::hatch::hatch;
use super::flat::placement::PlacedPicture;
use super::flat::tiled::AS_IT_IS;
use super::flat::{LayersVersion, LeftButton, PlacedView, background, navigate, nothing_ui};
use super::masking::drawing::masks_ui;
use super::masking::hand::{draws, hand_ui};
use super::masking::strip::strip_ui;
use super::panel::inspector::button;
use super::panel::sized::{PanelEdge, sized_panel};
use crate::app::action::quality::colour::want_estimate;
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::panes::Pane;
use crate::app::state::selection::Selection;
use crate::geometry::PixelRect;
use crate::projection::hatching::PixelMask;
use crate::scene::FaceId;

/// The view width from which a list is beside the photo, in points.
const WIDE: f32 = 700.0;
/// The largest share of the view that the list takes.
const LIST_MOST: f32 = 0.5;
/// The distance from the view's lower edge to the top of a line over the photo, in points.
const OVER: f32 = 64.0;
/// The height of the lines below the photo, in points.
const STATUS: f32 = 50.0;

/// The state of the photo view.
#[derive(Default)]
pub struct PhotoPane {
    /// The number of hidden visibility layers.
    pub hidden_layers: u32,
    /// Whether the list of untextured faces is shown.
    pub reasons_shown: bool,
    loading: Loading,
    /// The placement of the photo.
    pub view: PlacedView,
    /// The photo that is shown.
    photo: Option<usize>,
    pointed: Option<Pointed>,
    selected_hidden: Option<SelectedHidden>,
    reasons: reasons::Filter,
    /// The part to frame once the size of the view is known, as corners in photo pixels.
    sought: Option<[DVec2; 2]>,
    /// The position where a face is occluded, in photo pixels: marked as long as the face is selected.
    mark: Option<(FaceId, DVec2)>,
    /// The rectangle of the clickable line over the photo, as it was drawn last: no stroke starts there.
    pub(super) line: Option<Rect>,
}

/// The areas of the selection that are hidden in the photo.
struct SelectedHidden {
    selection: Selection,
    version: LayersVersion,
    mask: PixelMask,
}

impl PhotoPane {
    /// Shows another photo: fitted to the view, with all layers.
    fn turn_to(&mut self, photo: usize) {
        if self.photo != Some(photo) {
            self.photo = Some(photo);
            self.view.placement.fit();
            (self.hidden_layers, self.pointed, self.mark) = (0, None, None);
        }
    }

    /// Frames a part of a photo, as corners in photo pixels, or all of it. Marks the position where a face is occluded.
    pub fn look_at(&mut self, photo: usize, part: Option<[DVec2; 2]>, mark: Option<(FaceId, DVec2)>) {
        self.turn_to(photo);
        (self.mark, self.sought) = (mark, part);
        self.view.placement.fit();
    }

    /// Frames the requested part, now that the size of the view is known.
    fn show_sought(&mut self, rect: Rect) {
        self.view.rect = Some(rect);
        if let Some([low, high]) = self.sought.take() {
            self.view.placement.show(rect, low, high);
        }
    }

    /// Pans to the position where a face is occluded and marks it; `None` removes the mark.
    fn go_to(&mut self, face: FaceId, position: Option<DVec2>) {
        self.mark = position.map(|position| (face, position));
        if let Some(position) = position {
            self.view.placement.center_on(position);
        }
    }
}

/// Draws the view and handles its input.
pub fn photo_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(photo) = editor.state.selected_photo() else {
        return nothing_ui(ui, "Select a photo in the list to see it here.");
    };
    editor.state.flat.photo.turn_to(photo);
    let mut hidden_layers = editor.state.flat.photo.hidden_layers;
    Panel::top("photo tools").show(ui, |ui| {
        tools::tools_ui(ui, &editor.state, &mut hidden_layers, photo, asks);
        strip_ui(ui, &editor.state, asks);
    });
    editor.state.flat.photo.hidden_layers = hidden_layers;
    let status = Panel::bottom("photo status").exact_size(STATUS);
    status.show(ui, |ui| pointing::status_ui(editor, ui));
    if editor.state.flat.photo.reasons_shown {
        untextured_ui(editor, ui, photo, asks);
    }
    CentralPanel::no_frame().show(ui, |ui| canvas_ui(editor, ui, photo, asks));
}

/// Draws the list of untextured faces: beside the photo where both fit, otherwise below it.
fn untextured_ui(editor: &mut Editor, ui: &mut Ui, photo: usize, asks: &mut Vec<Ask>) {
    let mut sizes = editor.state.settings.sizes;
    let room = ui.available_size() * LIST_MOST;
    let (position, size, most) = match ui.available_width() {
        WIDE.. => ((PanelEdge::Right, "untextured faces"), &mut sizes.faces_width, room.x),
        _ => ((PanelEdge::Bottom, "untextured faces below"), &mut sizes.faces_below, room.y),
    };
    sized_panel(ui, position, size, most, |ui| reasons::reasons_ui(editor, ui, photo, asks));
    editor.state.settings.sizes = sizes;
}

fn canvas_ui(editor: &mut Editor, ui: &mut Ui, photo: usize, asks: &mut Vec<Ask>) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Photo view"));
    let Some(bounds) = bounds(editor, photo) else { return };
    let fill = background(ui);
    ui.painter_at(rect).rect_filled(rect, 0.0, fill);
    editor.state.flat.photo.show_sought(rect);
    let left = if draws(editor, ui) { LeftButton::Draws } else { LeftButton::Moves };
    let seen = navigate(&mut editor.state.flat.photo.view.placement, ui, &response, (rect, bounds), left);
    loading::load(editor, photo);
    hand_ui(editor, ui, &response, &seen, (photo, bounds), asks);
    picture(editor, ui, &seen, bounds, photo);
    drawing::drawing_ui(editor, ui, &seen, photo);
    masks_ui(editor, ui, &seen, photo);
    pointing::point(editor, &response, &seen, photo, asks);
    hint(editor, ui, rect, photo, asks);
}

fn bounds(state: &State, photo: usize) -> Option<PixelRect> {
    let camera = &state.session.as_ref()?.opened.site.photos[photo].camera;
    Some(PixelRect { x: 0, y: 0, w: camera.width, h: camera.height })
}

/// Draws the photo with layers hidden, and hatches the areas that are hidden then, or those of the selection.
fn picture(editor: &mut Editor, ui: &Ui, seen: &PlacedPicture, bounds: PixelRect, photo: usize) {
    update_selected_hidden(editor, photo);
    let light = light(editor, photo);
    let State { session, flat, .. } = &mut editor.state;
    let pictures = &editor.textures.photos;
    let Some(session) = session else { return };
    let (switches, pane) = (&flat.switches, &mut flat.photo);
    let painter = ui.painter_at(seen.rect);
    let frame = seen.rect_of(bounds);
    pane.view.checkerboard.draw(&painter, frame.intersect(seen.rect));
    if let Some(small) = pictures.small(photo).filter(|_| !pane.loading.has_photo(session, photo)) {
        let whole = Rect::from_min_max(Pos2::ZERO, eframe::egui::pos2(1.0, 1.0));
        painter.image(small.id(), frame, whole, eframe::egui::Color32::WHITE);
    }
    let hidden_layers = pane.hidden_layers;
    pane.loading.set_light(session, photo, light);
    let mask = pane.loading.draw(&painter, seen, session, photo, hidden_layers, switches);
    let mask =
        if hidden_layers > 0 { mask } else { pane.selected_hidden.as_ref().map(|hidden| &hidden.mask) };
    if let Some(mask) = mask.filter(|_| switches.hatching) {
        hatch(&painter, seen, mask);
    }
}

/// Returns the photo's light factors, R, G, B: those of blending, where matched exposure is on and known.
fn light(editor: &mut Editor, photo: usize) -> [f64; 3] {
    if !editor.state.flat.switches.even {
        return AS_IT_IS;
    }
    want_estimate(&mut editor.state, &mut editor.work);
    editor.state.even_factors(photo).unwrap_or(AS_IT_IS)
}

/// Updates the areas of the selection that are hidden in the photo, when the selection has changed.
fn update_selected_hidden(editor: &mut Editor, photo: usize) {
    let State { session, flat, selection, .. } = &mut editor.state;
    let version = session.as_ref().and_then(|session| LayersVersion::new(session, photo));
    let pane = &mut flat.photo;
    let (Some(session), Some(version)) = (session, version) else {
        pane.selected_hidden = None;
        return;
    };
    let known = pane.selected_hidden.as_ref();
    if known.is_some_and(|hidden| hidden.selection == *selection && hidden.version == version) {
        return;
    }
    let picked = Picked::new(*selection, session, photo);
    let layers = pane.loading.layers(&version);
    pane.selected_hidden = layers.filter(|_| !picked.is_nothing()).map(|layers| SelectedHidden {
        selection: *selection,
        version,
        mask: layers.hidden_of(|shape| picked.has(shape)),
    });
}

/// Draws the outcome of the search for transient objects, or the next step where the photo's layers are missing or out
/// of date.
fn hint(editor: &mut Editor, ui: &mut Ui, rect: Rect, photo: usize, asks: &mut Vec<Ask>) {
    editor.state.flat.photo.line = None;
    // No hint covers the photo during a stroke.
    if editor.state.masking.is_drawing() {
        return;
    }
    // The latest outcome comes first; layers that are out of date remain so.
    let is_stale = editor.state.session.as_ref().is_some_and(|session| session.photos[photo].word == "stale");
    if let Some(outcome) = editor.state.outcome_in(photo).filter(|_| !is_stale) {
        let (read, line) = over(ui, rect, |ui| {
            ui.label(outcome);
            ui.button("OK").on_hover_text("Hides this line.").clicked()
        });
        editor.state.flat.photo.line = Some(line);
        if read {
            editor.state.forget_outcome();
        }
        return;
    }
    let Some(session) = &editor.state.session else { return };
    let status = &session.photos[photo];
    let text = match status.word {
        "stale" => "This photo’s layers are from before the last change.",
        _ if status.stack.is_none() => "This photo has no layers yet.",
        _ => return,
    };
    let others = session.photos.iter().filter(|photo| !photo.is_current()).count() > 1;
    let commands: &[&'static Command] = match others && status.stack.is_some() {
        true => &[&layers::BUILD_PHOTO, &layers::BUILD],
        false => &[&layers::BUILD_PHOTO],
    };
    let ((), line) = over(ui, rect, |ui| {
        ui.label(text);
        commands.iter().for_each(|command| button(editor, ui, command, asks));
    });
    editor.state.flat.photo.line = Some(line);
}

/// Draws a line over the photo, centred at the bottom; returns its rectangle.
fn over<R>(ui: &mut Ui, rect: Rect, contents: impl FnOnce(&mut Ui) -> R) -> (R, Rect) {
    // The width is that of the frame before, as it is not known earlier.
    let id = ui.scope_id().with("over the photo");
    let width = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(0.0);
    let left = (rect.center().x - width / 2.0).max(rect.left());
    let area = Rect::from_min_max(Pos2::new(left, rect.bottom() - OVER), rect.max);
    let drawn = ui.scope_builder(UiBuilder::new().max_rect(area), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| ui.horizontal(contents).inner)
    });
    let line = drawn.inner.response.rect;
    let framed = line.width();
    if framed != width {
        ui.data_mut(|data| data.insert_temp(id, framed));
        ui.ctx().request_repaint();
    }
    (drawn.inner.inner, line)
}

impl State {
    /// Frames a rectangle of the photo with a margin.
    pub fn show_rect(&mut self, photo: usize, rect: PixelRect) {
        self.panes.show(Pane::Photo);
        let corner = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        let (low, high) = (corner(rect.x, rect.y), corner(rect.right(), rect.bottom()));
        let around = DVec2::splat((high - low).max_element());
        self.flat.photo.look_at(photo, Some([low - around, high + around]), None);
    }

    /// Frames the selection in the photo view; returns whether the photo contains it.
    pub fn frame_in_photo(&mut self) -> bool {
        let Some(photo) = self.selected_photo() else { return false };
        let Self { session, flat, selection, .. } = self;
        let (Some(session), pane) = (session, &mut flat.photo) else { return false };
        if *selection == Selection::Photo(photo) {
            pane.view.fit();
            return true;
        }
        let picked = Picked::new(*selection, session, photo);
        let version = LayersVersion::new(session, photo);
        let layers = version.and_then(|version| pane.loading.layers(&version));
        let shapes = layers.iter().flat_map(|layers| &layers.shapes);
        let bounds = shapes.filter(|shape| picked.has(shape)).map(|shape| shape.covered.bounds());
        let Some(bounds) = bounds.reduce(|all, rect| all.union(&rect)) else { return false };
        if let Some(rect) = pane.view.rect {
            let corner = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
            let margin = 0.1 * f64::from(bounds.w.max(bounds.h));
            let (low, high) = (corner(bounds.x, bounds.y), corner(bounds.right(), bounds.bottom()));
            pane.view.placement.show(rect, low - margin, high + margin);
        }
        true
    }
}
