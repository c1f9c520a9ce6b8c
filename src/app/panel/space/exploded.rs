//! Draws the exploded view: a photo's image layers pulled apart in space.

use eframe::egui::epaint::{Mesh, Vertex};
use eframe::egui::{
    Color32, Id, Painter, Pos2, Rect, Response, Shape, Stroke, TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use glam::{DVec2, DVec3};

use super::overlay::SELECTED;
use super::px_of;
use super::view::SpacePaneView;
use crate::panel::photo::drawing::colour_of_depth;
use crate::panel::pictures::image;
use crate::state::flat::version::LayersVersion;
use crate::state::request::{Request, SelectRequest, SpaceRequest};
use crate::state::selection::Selection;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::scene::ShownScene;
use quadratura_editing::exploded::layer_textures::LayerThumbnail;
use quadratura_projection::exploded::Stand;
use quadratura_view::navigation::Viewpoint;

/// The duration of the opening animation, in seconds.
const OPENS_S: f32 = 0.7;
/// The number of pieces of a picture across and down, each small enough to look straight.
const PIECES: u32 = 10;

/// The textures of layer pictures, uploaded one in a frame.
#[derive(Default)]
pub struct LayerTextures {
    version: Option<LayersVersion>,
    /// The textures uploaded so far, in the order of the pictures.
    uploaded: Vec<TextureHandle>,
}

impl LayerTextures {
    /// Returns whether all pictures of the layers that are pulled apart are uploaded.
    pub fn are_complete(&self, scene: ShownScene<'_>) -> bool {
        let version = scene.version_apart();
        let is_this = version.is_some() && self.version == version;
        is_this && scene.panes_apart().is_some_and(|panes| panes.pictures.len() == self.uploaded.len())
    }

    /// Forgets the textures of another version.
    fn follow(&mut self, version: LayersVersion) {
        if self.version.as_ref() != Some(&version) {
            *self = Self { version: Some(version), uploaded: Vec::new() };
        }
    }
}

fn animation() -> Id {
    Id::unique("layers pulled apart")
}

/// Draws the layers, shows the name of the one under the pointer, and selects it when it is clicked.
pub fn exploded_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    textures: &mut LayerTextures,
    requests: &mut Vec<Request>,
) {
    if view.photo != view.scene.space.exploded.photo {
        requests.push(SpaceRequest::FollowSelection.into());
    }
    open(ui, view, it, textures, requests);
    it.is_loading = !textures.are_complete(view.scene);
    pick(ui, view, it, response, rect, requests);
    draw(ui, view, it, rect, textures);
}

/// Requests the layer pictures, uploads one in a frame, and then opens the spacing.
fn open(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    textures: &mut LayerTextures,
    requests: &mut Vec<Request>,
) {
    let Some(version) = view.scene.version_apart() else { return };
    if std::mem::take(&mut it.begins) {
        ui.ctx().animate_value_with_time(animation(), 0.0, 0.0);
    }
    let Some(panes) = view.scene.panes_apart() else {
        requests.push(SpaceRequest::WantLayerPictures.into());
        return;
    };
    textures.follow(version);
    if let Some(next) = panes.pictures.get(textures.uploaded.len()) {
        let name = format!("sheet {}", next.layer.0);
        textures.uploaded.push(ui.ctx().load_texture(name, image(&next.picture), TextureOptions::LINEAR));
        ui.ctx().request_repaint();
        return;
    }
    // The animation starts once all pictures are uploaded.
    it.now_apart = ui.ctx().animate_value_with_time(animation(), it.apart, OPENS_S);
}

fn pick(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    let pointer = response.hover_pos().filter(|_| !response.dragged());
    let pixel = pointer.map(|at| it.pixel_at(px_of(at - rect.min, ui.ctx().pixels_per_point())));
    let layer = pixel.and_then(|pixel| view.scene.layer_at(&pixel, it.now_apart)).map(|(_, layer)| layer);
    it.hovered_layer = layer;
    let (Some(photo), session) = (view.scene.space.exploded.photo, view.scene.session) else { return };
    match layer {
        Some(layer) => {
            let stack = session.stack_of(photo);
            let named = stack
                .and_then(|stack| Some((stack.image_layers.get(layer.index())?, stack.image_layers.last()?)));
            let text = named.map(|(named, deepest)| {
                format!("{}, depth {} of {}, 1 nearest", named.name, named.order + 1, deepest.order + 1)
            });
            response.clone().on_hover_text_at_pointer(text.unwrap_or_default());
            if response.clicked() {
                requests.push(Request::Select(SelectRequest::Only(Selection::Layer { photo, layer })));
            }
        }
        None if response.clicked() => {
            requests.push(Request::Select(SelectRequest::Only(Selection::Photo(photo))))
        }
        None => (),
    }
}

fn draw(ui: &Ui, view: &SpacePaneView<'_>, it: &SpaceMemory, rect: Rect, textures: &LayerTextures) {
    let Some(stand) = view.scene.stand(it.now_apart) else { return };
    let Some(panes) = view.scene.panes_apart() else { return };
    let canvas = ExplodedCanvas { painter: ui.painter_at(rect), rect, view: it.viewpoint, stand };
    let orders: Vec<u32> = panes.pictures.iter().map(|pane| pane.order).collect();
    let weak = ui.visuals().weak_text_color();
    canvas.rays(orders.iter().copied().max().unwrap_or(0), Stroke::new(1.0, weak.gamma_multiply(0.5)));
    let opacities = view.scene.opacities_apart();
    for place in stand.from_behind(&orders, it.viewpoint.position()) {
        let Some(texture) = textures.uploaded.get(place) else { continue };
        let pane = &panes.pictures[place];
        let opacity = opacities.of(pane.layer);
        if opacity == 0 {
            continue;
        }
        canvas.pane(pane, texture, opacity);
        let is_selected = view
            .scene
            .space
            .exploded
            .photo
            .is_some_and(|photo| view.selection.includes(Selection::Layer { photo, layer: pane.layer }));
        let colour = if is_selected { SELECTED } else { colour_of_depth(pane.order) };
        let width: f32 = if is_selected { 3.0 } else { 1.0 };
        let width = if it.hovered_layer == Some(pane.layer) { width.max(2.5) } else { width };
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
        let corners = self.stand.corners(last, quadratura_base::geometry::PixelRect { x: 0, y: 0, w, h });
        let eye = self.stand.pose.center_in_world();
        corners.into_iter().for_each(|corner| self.line(eye, corner, stroke));
    }

    fn outline(&self, pane: &LayerThumbnail, stroke: Stroke) {
        let corners = self.stand.corners(pane.order, pane.rect);
        (0..4).for_each(|i| self.line(corners[i], corners[(i + 1) % 4], stroke));
    }

    /// Draws a layer in pieces; pieces partly behind the eye are left out.
    fn pane(&self, pane: &LayerThumbnail, texture: &TextureHandle, opacity: u8) {
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
            mesh.vertices.push(Vertex {
                pos,
                uv: pos2(u as f32, v as f32),
                color: Color32::from_white_alpha(opacity),
            });
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
