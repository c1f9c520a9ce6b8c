//! Overlays of the 3D view: outlines, cameras, and the photo that the view looks through.

use eframe::egui::epaint::{Mesh, Vertex};
use eframe::egui::{
    Color32, Key, Painter, Pos2, Rect, Shape, Stroke, TextureHandle, TextureId, Ui, pos2, vec2,
};
use glam::DVec3;

use crate::app::panel::pictures::PhotoTextures;
use crate::app::state::State;
use crate::app::state::ask::{Ask, FlatAsk};
use crate::app::state::session::Session;
use crate::app::state::space::memory::SpaceMemory;
use crate::app::state::space::picking::faces_of;
use crate::app::widget::dialog;
use crate::projection::navigation::Viewpoint;
use crate::scene::{FaceId, Photo};

/// The colour of the selection.
pub const SELECTED: Color32 = Color32::from_rgb(0xff, 0xa0, 0x30);
/// The colour of the face under the pointer.
const HOVERED: Color32 = Color32::from_rgb(0xff, 0xe0, 0xa0);
/// The colour of outlines of faces.
const WIRE: Color32 = Color32::from_rgba_premultiplied(70, 90, 110, 110);
/// The colour of outlines of faces on a light background.
const WIRE_ON_LIGHT: Color32 = Color32::from_rgba_premultiplied(24, 34, 46, 150);
/// The colour of cameras.
const CAMERA: Color32 = Color32::from_rgb(0x70, 0xb0, 0xe8);
/// The height of a camera's picture in space, as a share of the site's radius.
const CAMERA_SHARE: f64 = 0.035;

/// The smallest distance of cameras that are drawn, as a multiple of their size.
const NEAR: f64 = 5.0;

/// Draws the overlays.
pub fn overlay_ui(
    ui: &Ui,
    state: &State,
    it: &SpaceMemory,
    (rect, photos): (Rect, &PhotoTextures),
    asks: &mut Vec<Ask>,
) {
    photo_over(ui, state, it, (rect, photos), asks);
    let Some(session) = &state.session else { return };
    let canvas = WorldCanvas { painter: ui.painter_at(rect), rect, view: it.viewpoint };
    if state.space.wireframe || state.device.is_none() {
        canvas.wires(session, if ui.visuals().dark_mode { WIRE } else { WIRE_ON_LIGHT });
    }
    for face in faces_of(state.selection, session) {
        canvas.outline(session, face, Stroke::new(2.0, SELECTED));
    }
    if let Some(face) = it.hovered {
        canvas.outline(session, face, Stroke::new(1.5, HOVERED));
    }
    if state.space.cameras && it.through.is_none() {
        cameras(state, session, &canvas, photos);
    }
}

fn cameras(state: &State, session: &Session, canvas: &WorldCanvas, photos: &PhotoTextures) {
    for (id, photo) in session.opened.site.numbered_photos() {
        let selected = state.photo == Some(id);
        let color = if selected { SELECTED } else { CAMERA };
        let texture = photos.small(id).map(TextureHandle::id);
        let size = session.scene_frame.radius * CAMERA_SHARE;
        // A camera close to the viewpoint would hide the scene.
        if canvas.view.position().distance(photo.pose.center_in_world()) < NEAR * size {
            continue;
        }
        canvas.camera(photo, size, Stroke::new(if selected { 2.0 } else { 1.0 }, color), texture);
    }
}

/// Draws the photo that the view looks through, fitted to the view's height as its camera is.
fn photo_over(
    ui: &Ui,
    state: &State,
    it: &SpaceMemory,
    (rect, photos): (Rect, &PhotoTextures),
    asks: &mut Vec<Ask>,
) {
    // Typed text is no command.
    let typed = ui.ctx().text_edit_focused() || dialog::is_open(ui.ctx());
    let flips = !typed && ui.input(|input| input.key_down(Key::X));
    let shown = it.photo_over != flips;
    let (Some(photo), Some(session), true) = (it.through, &state.session, shown) else { return };
    asks.push(FlatAsk::WantLargePicture(photo).into());
    let camera = &session.opened.site.photo(photo).camera;
    let width = rect.height() * camera.width as f32 / camera.height as f32;
    let frame = Rect::from_center_size(rect.center(), vec2(width, rect.height()));
    let (opacity, wipe) = (it.photo_opacity, it.wipe);
    let Some(texture) = photos.large(photo) else { return };
    let clip = Rect::from_min_max(rect.min, pos2(rect.left() + rect.width() * wipe, rect.bottom()));
    let opacity = if flips && !it.photo_over { 1.0 } else { opacity };
    let tint = Color32::WHITE.gamma_multiply(opacity);
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter_at(clip).image(texture.id(), frame, uv, tint);
    if wipe < 1.0 {
        let stroke = Stroke::new(1.0, Color32::WHITE);
        ui.painter_at(rect).vline(clip.right(), rect.y_range(), stroke);
    }
}

/// A canvas that projects points of the world onto the view.
struct WorldCanvas {
    painter: Painter,
    rect: Rect,
    view: Viewpoint,
}

impl WorldCanvas {
    fn outline(&self, session: &Session, face: FaceId, stroke: Stroke) {
        let vertices = &session.model().vertices;
        for &[from, to] in session.edges.of_face(face) {
            self.line(vertices[from as usize], vertices[to as usize], stroke);
        }
    }

    /// Draws many lines as one mesh: thousands of separate shapes would dominate the frame time. Each line is a ridge,
    /// opaque in the middle and transparent a pixel beside it, and looks as smooth as a line of egui.
    fn wires(&self, session: &Session, colour: Color32) {
        let vertices = &session.model().vertices;
        let mut mesh = Mesh::default();
        for &[from, to] in session.edges.all() {
            let Some(ends) = self.view.segment(vertices[from as usize], vertices[to as usize]) else {
                continue;
            };
            let [from, to] = ends.map(|end| self.at(end));
            if self.rect.intersects(Rect::from_two_pos(from, to)) {
                ridge(&mut mesh, from, to, colour);
            }
        }
        self.painter.add(Shape::mesh(mesh));
    }

    fn line(&self, from: DVec3, to: DVec3, stroke: Stroke) {
        if let Some([from, to]) = self.view.segment(from, to) {
            self.painter.line_segment([self.at(from), self.at(to)], stroke);
        }
    }

    /// Converts a point, in heights of the picture from its centre, to the screen.
    fn at(&self, point: glam::DVec2) -> Pos2 {
        let height = self.rect.height();
        self.rect.center() + vec2(point.x as f32, point.y as f32) * height
    }

    /// Draws the camera of a photo as a pyramid whose tip is the camera's centre and whose base is `size` world units
    /// high. The base shows the photo where `texture` is given.
    fn camera(&self, photo: &Photo, size: f64, stroke: Stroke, texture: Option<TextureId>) {
        let (width, height) = (f64::from(photo.camera.width), f64::from(photo.camera.height));
        let depth = size * photo.camera.fy / height;
        let corner = |x: f64, y: f64| {
            let ray = photo.camera.ray_in_camera(glam::DVec2::new(x * width, y * height));
            photo.pose.world_from_camera(ray * depth)
        };
        if let Some(texture) = texture {
            self.picture(texture, corner);
        }
        let tip = photo.pose.center_in_world();
        let base = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        for (index, from) in base.iter().enumerate() {
            self.line(*from, base[(index + 1) % 4], stroke);
            self.line(tip, *from, stroke);
        }
    }

    /// Draws a picture on a quadrilateral in space, in pieces small enough to look straight.
    fn picture(&self, texture: TextureId, corner: impl Fn(f64, f64) -> DVec3) {
        const PIECES: u32 = 4;
        let mut mesh = Mesh::with_texture(texture);
        for row in 0..=PIECES {
            for column in 0..=PIECES {
                let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(PIECES));
                // A picture partly behind the eye is left out: its outline marks it.
                let Some(point) = self.view.place(corner(u, v)) else { return };
                let (pos, uv) = (self.at(point), pos2(u as f32, v as f32));
                mesh.vertices.push(Vertex { pos, uv, color: Color32::from_white_alpha(215) });
            }
        }
        for row in 0..PIECES {
            for column in 0..PIECES {
                let first = row * (PIECES + 1) + column;
                let below = first + PIECES + 1;
                mesh.add_triangle(first, first + 1, below);
                mesh.add_triangle(below, first + 1, below + 1);
            }
        }
        self.painter.add(Shape::mesh(mesh));
    }
}

/// Draws a line between two positions, two points wide at its base.
fn ridge(mesh: &mut Mesh, from: Pos2, to: Pos2, colour: Color32) {
    let aside = (to - from).normalized().rot90();
    let first = mesh.vertices.len() as u32;
    for end in [from, to] {
        mesh.colored_vertex(end - aside, Color32::TRANSPARENT);
        mesh.colored_vertex(end, colour);
        mesh.colored_vertex(end + aside, Color32::TRANSPARENT);
    }
    for side in 0..2 {
        let corner = first + side;
        mesh.add_triangle(corner, corner + 1, corner + 3);
        mesh.add_triangle(corner + 3, corner + 1, corner + 4);
    }
}
