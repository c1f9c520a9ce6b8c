//! The exploded view: a photo's image layers pulled apart in space, with the one under the pointer and their spacing.

use eframe::egui::epaint::{Mesh, Vertex};
use eframe::egui::{
    Color32, Id, Painter, Pos2, Rect, Response, Shape, Stroke, TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use glam::{DVec2, DVec3};

use super::overlay::SELECTED;
use super::{FIELD_RAD, px_of};
use crate::app::action::flat::slot::{ResultRequest, want};
use crate::app::editor::Editor;
use crate::app::panel::photo::drawing::colour_of_depth;
use crate::app::panel::pictures::image;
use crate::app::state::State;
use crate::app::state::ask::{Ask, SelectAsk};
use crate::app::state::flat::slot::ResultSlot;
use crate::app::state::flat::version::LayersVersion;
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::document::Stack;
use crate::io::stack_store::StackStore;
use crate::projection::exploded::Stand;
use crate::projection::flight::FrameLens;
use crate::projection::navigation::Viewpoint;
use crate::recipe::exploded::layer_textures::{LayerThumbnail, layer_thumbnails};

/// The height of layer pictures, as a share of the site's radius, so that navigation feels the same as in the site.
const HEIGHT_SHARE: f64 = 0.8;
/// The longer side of a photo's layer pictures, in pixels: seen from the side they are smaller than the window.
const LONGEST_PX: u32 = 1024;
/// The duration of the opening animation, in seconds.
const OPENS_S: f32 = 0.7;
/// The default spacing: the distance of the last layer behind the nearest one, as a multiple of the nearest one's
/// distance. It is independent of the number of layers, so that all are visible.
const APART: f32 = 1.8;
/// The largest spacing; see [`APART`].
pub const MOST_APART: f32 = 6.0;
/// The number of pieces of a picture across and down, each small enough to look straight.
const PIECES: u32 = 10;

/// The state of the exploded view.
pub struct Exploded {
    /// The photo whose layers are pulled apart.
    photo: Option<usize>,
    /// The requested spacing: the distance of the last layer behind the nearest one, as a multiple of the nearest one's
    /// distance.
    pub apart: f32,
    /// The current spacing during the animation.
    now_apart: f32,
    /// Whether the animation starts from the beginning.
    begins: bool,
    /// The viewpoint before, and the photo that the view looked through.
    back: Option<(Viewpoint, Option<usize>)>,
    made: ResultSlot<LayersVersion, Panes3D>,
    /// The layer under the pointer, by its index in the stack.
    pub hovered: Option<usize>,
}

/// The layer pictures of a stack.
pub struct Panes3D {
    pictures: Vec<LayerThumbnail>,
    /// The textures uploaded so far.
    textures: Vec<TextureHandle>,
}

impl Default for Exploded {
    fn default() -> Self {
        Self {
            photo: None,
            apart: APART,
            now_apart: 0.0,
            begins: false,
            back: None,
            made: ResultSlot::new(1),
            hovered: None,
        }
    }
}

impl Exploded {
    /// Returns whether the exploded view is on.
    pub fn is_on(&self) -> bool {
        self.photo.is_some()
    }

    /// Returns the current spacing during the animation.
    pub fn now_apart(&self) -> f32 {
        self.now_apart
    }
}

impl State {
    /// Pulls the selected photo's layers apart and views them from the side, or puts them back.
    pub fn toggle_exploded(&mut self) {
        if self.space.exploded.photo.take().is_some() {
            let now_s = self.window.now_s;
            let back = self.space.exploded.back.take();
            if let (Some((view, through)), Some(session)) = (back, &self.session) {
                self.space.fly(view, through, session, now_s);
            }
            return;
        }
        self.space.exploded.back = Some((self.space.viewpoint, self.space.through));
        self.pull_apart();
    }

    /// Pulls apart the layers of the selected photo.
    fn pull_apart(&mut self) {
        let Some(photo) = self.selected_photo() else { return };
        self.panes.show(crate::app::state::panes::Pane::Space);
        self.space.exploded.photo = Some(photo);
        self.space.exploded.now_apart = 0.0;
        let apart = self.space.exploded.apart;
        let (Some(stand), Some(session)) = (self.stand(apart), &self.session) else { return };
        let lens = FrameLens::with_field_of_view(FIELD_RAD);
        let there = stand.side_view(last_order(session, photo), lens, session.scene_frame.up);
        self.space.exploded.begins = true;
        self.fly_to_viewpoint(there);
    }

    /// Returns the layer pictures of the photo's current stack.
    fn panes(&self) -> Option<&Panes3D> {
        let exploded = &self.space.exploded;
        exploded.made.get(&LayersVersion::new(self.session.as_ref()?, exploded.photo?)?)
    }

    /// Returns whether all layer pictures are uploaded.
    pub fn textures_are_complete(&self) -> bool {
        self.panes().is_some_and(|panes| panes.textures.len() == panes.pictures.len())
    }

    /// Returns the stack of the selected photo.
    pub fn selected_stack(&self) -> Option<&Stack> {
        self.session.as_ref()?.photos.get(self.selected_photo()?)?.stack.as_deref()
    }

    /// Returns the positions of the layers in space for a spacing.
    fn stand(&self, apart: f32) -> Option<Stand> {
        let (session, place) = (self.session.as_ref()?, self.space.exploded.photo?);
        let photo = session.opened.site.photos.get(place)?;
        let height = HEIGHT_SHARE * session.scene_frame.radius;
        let step = f64::from(apart) / f64::from(last_order(session, place).max(1));
        Some(Stand::with_height(photo.camera, photo.pose, height, step))
    }

    /// Returns the nearest intersection of a ray from the viewpoint with the layers, and the layer's index in the
    /// stack.
    pub fn layer_along(&self, ray: DVec3) -> Option<(DVec3, usize)> {
        let exploded = &self.space.exploded;
        let stand = self.stand(exploded.now_apart)?;
        let (panes, eye) = (self.panes()?, self.space.viewpoint.position());
        let orders: Vec<u32> = panes.pictures.iter().map(|pane| pane.order).collect();
        stand.from_behind(&orders, eye).into_iter().rev().find_map(|place| {
            let pane = &panes.pictures[place];
            let (t, px) = stand.meet(pane.order, eye, ray)?;
            pane.has(px.x, px.y).then_some((eye + ray * t, pane.layer))
        })
    }
}

/// Returns the order of a photo's farthest layer.
fn last_order(session: &Session, photo: usize) -> u32 {
    let stack = session.photos.get(photo).and_then(|photo| photo.stack.as_ref());
    stack.iter().flat_map(|stack| &stack.image_layers).map(|layer| layer.order).max().unwrap_or(0)
}

fn animation() -> Id {
    Id::unique("layers pulled apart")
}

/// Draws the layers, shows the name of the one under the pointer, and selects it when it is clicked.
pub fn exploded_ui(editor: &mut Editor, ui: &Ui, response: &Response, rect: Rect, asks: &mut Vec<Ask>) {
    if editor.state.selected_photo() != editor.state.space.exploded.photo {
        editor.state.pull_apart();
    }
    make(editor, ui);
    pick(editor, ui, response, rect, asks);
    draw(editor, ui, rect);
}

/// Requests the layer pictures, and uploads one in a frame.
fn make(editor: &mut Editor, ui: &Ui) {
    let (Some(photo), Some(session)) = (editor.state.space.exploded.photo, &editor.state.session) else {
        return;
    };
    let Some(version) = LayersVersion::new(session, photo) else { return };
    let (folder, stack) =
        (StackStore::new(&session.folder).folder(&version.stack.photo.name), version.stack.clone());
    let request = ResultRequest {
        key: version.clone(),
        name: "Pulling layers apart",
        gives_up: true,
        slot: |state| &mut state.space.exploded.made,
    };
    if std::mem::take(&mut editor.state.space.exploded.begins) {
        ui.ctx().animate_value_with_time(animation(), 0.0, 0.0);
    }
    want(&mut editor.state, &mut editor.work, request, move |task| {
        let pictures = layer_thumbnails(&folder, &stack, LONGEST_PX, task)?;
        Ok(Panes3D { pictures, textures: Vec::new() })
    });
    let exploded = &mut editor.state.space.exploded;
    let Some(panes) = exploded.made.take_up(&version) else { return };
    if let Some(next) = panes.pictures.get(panes.textures.len()) {
        let name = format!("sheet {}", next.layer);
        panes.textures.push(ui.ctx().load_texture(name, image(&next.picture), TextureOptions::LINEAR));
        ui.ctx().request_repaint();
        return;
    }
    // The animation starts once all pictures are uploaded.
    exploded.now_apart = ui.ctx().animate_value_with_time(animation(), exploded.apart, OPENS_S);
}

fn pick(editor: &mut Editor, ui: &Ui, response: &Response, rect: Rect, asks: &mut Vec<Ask>) {
    let pointer = response.hover_pos().filter(|_| !response.dragged());
    let ray = pointer.map(|at| {
        let px = px_of(at - rect.min, ui.ctx().pixels_per_point());
        editor.state.space.viewpoint.ray(px, editor.state.space.size_px)
    });
    let layer = ray.and_then(|ray| editor.state.layer_along(ray)).map(|(_, layer)| layer);
    editor.state.space.exploded.hovered = layer;
    let (Some(photo), Some(session)) = (editor.state.space.exploded.photo, &editor.state.session) else {
        return;
    };
    match layer {
        Some(layer) => {
            let stack = session.photos.get(photo).and_then(|photo| photo.stack.as_ref());
            let named = stack.and_then(|stack| stack.image_layers.get(layer));
            let text = named.map(|named| format!("{}, {} from the front", named.name, named.order));
            response.clone().on_hover_text_at_pointer(text.unwrap_or_default());
            if response.clicked() {
                asks.push(Ask::Select(SelectAsk::Only(Selection::Layer { photo, layer })));
            }
        }
        None if response.clicked() => asks.push(Ask::Select(SelectAsk::Only(Selection::Photo(photo)))),
        None => (),
    }
}

fn draw(state: &State, ui: &Ui, rect: Rect) {
    let exploded = &state.space.exploded;
    let Some(stand) = state.stand(exploded.now_apart) else { return };
    let Some(panes) = state.panes() else { return };
    let canvas = ExplodedCanvas { painter: ui.painter_at(rect), rect, view: state.space.viewpoint, stand };
    let orders: Vec<u32> = panes.pictures.iter().map(|pane| pane.order).collect();
    let weak = ui.visuals().weak_text_color();
    canvas.rays(orders.iter().copied().max().unwrap_or(0), Stroke::new(1.0, weak.gamma_multiply(0.5)));
    for place in stand.from_behind(&orders, state.space.viewpoint.position()) {
        let Some(texture) = panes.textures.get(place) else { continue };
        let pane = &panes.pictures[place];
        canvas.pane(pane, texture);
        let is_selected = exploded.photo.is_some_and(|photo| {
            let layer = pane.layer;
            state.selection == Selection::Layer { photo, layer }
                || state.more_layers.contains(&(photo, layer))
        });
        let colour = if is_selected { SELECTED } else { colour_of_depth(pane.order) };
        let width: f32 = if is_selected { 3.0 } else { 1.0 };
        let width = if exploded.hovered == Some(pane.layer) { width.max(2.5) } else { width };
        canvas.outline(pane, Stroke::new(width, colour));
    }
}

struct ExplodedCanvas {
    painter: Painter,
    rect: Rect,
    view: Viewpoint,
    stand: Stand,
}

impl ExplodedCanvas {
    fn at(&self, place: DVec2) -> Pos2 {
        self.rect.center() + vec2(place.x as f32, place.y as f32) * self.rect.height()
    }

    fn line(&self, from: DVec3, to: DVec3, stroke: Stroke) {
        if let Some([from, to]) = self.view.segment(from, to) {
            self.painter.line_segment([self.at(from), self.at(to)], stroke);
        }
    }

    /// Draws lines from the photo's camera through the corners of the photo to the last layer.
    fn rays(&self, last: u32, stroke: Stroke) {
        let (w, h) = (self.stand.camera.width, self.stand.camera.height);
        let corners = self.stand.corners(last, crate::geometry::PixelRect { x: 0, y: 0, w, h });
        let eye = self.stand.pose.center_in_world();
        corners.into_iter().for_each(|corner| self.line(eye, corner, stroke));
    }

    fn outline(&self, pane: &LayerThumbnail, stroke: Stroke) {
        let corners = self.stand.corners(pane.order, pane.rect);
        (0..4).for_each(|i| self.line(corners[i], corners[(i + 1) % 4], stroke));
    }

    /// Draws a layer in pieces; pieces partly behind the eye are left out.
    fn pane(&self, pane: &LayerThumbnail, texture: &TextureHandle) {
        let rect = pane.rect;
        let mut mesh = Mesh::with_texture(texture.id());
        let mut seen = Vec::new();
        for i in 0..(PIECES + 1) * (PIECES + 1) {
            let [u, v] = [i % (PIECES + 1), i / (PIECES + 1)].map(|step| f64::from(step) / f64::from(PIECES));
            let px = DVec2::new(
                f64::from(rect.x) + u * f64::from(rect.w),
                f64::from(rect.y) + v * f64::from(rect.h),
            );
            let place = self.view.place(self.stand.point(pane.order, px));
            seen.push(place.is_some());
            let pos = place.map_or(Pos2::ZERO, |place| self.at(place));
            mesh.vertices.push(Vertex { pos, uv: pos2(u as f32, v as f32), color: Color32::WHITE });
        }
        for row in 0..PIECES {
            for column in 0..PIECES {
                let first = row * (PIECES + 1) + column;
                let below = first + PIECES + 1;
                for corners in [[first, first + 1, below], [below, first + 1, below + 1]] {
                    if corners.iter().all(|corner| seen[*corner as usize]) {
                        mesh.add_triangle(corners[0], corners[1], corners[2]);
                    }
                }
            }
        }
        self.painter.add(Shape::mesh(mesh));
    }
}
