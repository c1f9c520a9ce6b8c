//! Overlays of the 3D view: outlines, cameras, and the photo that the view looks through.

use std::collections::BTreeMap;

use eframe::egui::epaint::{Mesh, Vertex};
use eframe::egui::{
    Color32, CursorIcon, Key, Painter, Pos2, Rect, Role, Sense, Shape, Stroke, StrokeKind, TextureHandle,
    TextureId, Ui, WidgetInfo, pos2, vec2,
};
use glam::DVec3;

use super::view::SpacePaneView;
use crate::panel::pictures::PhotoTextures;
use crate::state::request::{FlatRequest, Request};
use crate::state::session::Session;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::faces_of;
use crate::widget::dialog;
use quadratura_base::raster::robust::of_rank;
use quadratura_base::scene::impostor::{Facing, Impostor};
use quadratura_base::scene::{FaceId, ObjectId, Photo};
use quadratura_view::navigation::Viewpoint;

/// Half the width of the wipe line for the pointer, and the width of its handle, in points.
const WIPE_HANDLE: f32 = 7.0;
/// The colour of the selection.
pub const SELECTED: Color32 = Color32::from_rgb(0xff, 0xa0, 0x30);
/// The colour of the face under the pointer.
pub const HOVERED: Color32 = Color32::from_rgb(0xff, 0xe0, 0xa0);
/// The colour of outlines of faces.
const WIRE: Color32 = Color32::from_rgba_premultiplied(70, 90, 110, 110);
/// The colour of outlines of faces on a light background.
const WIRE_ON_LIGHT: Color32 = Color32::from_rgba_premultiplied(24, 34, 46, 150);
/// The colour of outlines of surfaces that are drawn as glass.
const GLASS: Color32 = Color32::from_rgba_premultiplied(70, 110, 130, 130);
/// The colour of cameras.
const CAMERA: Color32 = Color32::from_rgb(0x70, 0xb0, 0xe8);
/// The number of cameras, the nearest ones, that are drawn with their pictures: hundreds would hide the scene.
const MOST_PICTURES: usize = 48;

/// The distances of cameras, as multiples of their size, between which they fade: nearer ones are not drawn.
const FADES: [f64; 2] = [5.0, 12.0];
/// The opacity of the picture of a camera that is under the pointer: one sees and clicks what is behind it.
const IN_THE_WAY: f32 = 0.15;

/// Returns the viewpoint of the picture on the screen: what is drawn over it has to fit it, even while the picture of a
/// view that has moved is still being drawn. It is that of the view where there is no picture.
pub fn seen_from(view: &SpacePaneView<'_>, it: &SpaceMemory) -> Viewpoint {
    match view.scene.space.has_picture() && view.scene.space.device.is_some() {
        true => view.scene.space.seen_from(),
        false => it.viewpoint,
    }
}

/// Draws the overlays.
pub fn overlay_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    rect: Rect,
    photos: &PhotoTextures,
    requests: &mut Vec<Request>,
) {
    photo_over(ui, view, it, rect, photos, requests);
    let session = view.scene.session;
    let canvas = WorldCanvas { painter: ui.painter_at(rect), rect, view: seen_from(view, it) };
    if view.scene.space.wireframe || view.scene.space.device.is_none() {
        canvas.wires(session, if ui.visuals().dark_mode { WIRE } else { WIRE_ON_LIGHT });
    }
    for face in view.scene.glass() {
        canvas.outline(session, face, Stroke::new(1.0, GLASS));
    }
    let faces = faces_of(view.selection.main, session);
    let is_impostor = |face: &FaceId| session.model().impostor(*face).is_some();
    // All faces of an impostor are one rectangle.
    let rectangles: BTreeMap<ObjectId, FaceId> = faces
        .iter()
        .filter(|face| is_impostor(face))
        .map(|face| (session.model().face(*face).object, *face))
        .collect();
    for face in faces.iter().copied().filter(|face| !is_impostor(face)).chain(rectangles.into_values()) {
        canvas.outline(session, face, Stroke::new(2.0, SELECTED));
    }
    if let Some(face) = it.hovered {
        canvas.outline(session, face, Stroke::new(1.5, HOVERED));
    }
    if view.scene.space.cameras && it.through.is_none() {
        let pointer = ui.input(|input| input.pointer.hover_pos());
        cameras(view, session, &canvas, photos, pointer);
    }
}

/// Returns the opacity of a camera at a distance, in multiples of its size.
fn opacity_at(distance: f64) -> f32 {
    let [gone, whole] = FADES;
    ((distance - gone) / (whole - gone)).clamp(0.0, 1.0) as f32
}

fn cameras(
    view: &SpacePaneView<'_>,
    session: &Session,
    canvas: &WorldCanvas,
    photos: &PhotoTextures,
    pointer: Option<Pos2>,
) {
    let (eye, size) = (canvas.view.position(), session.camera_size);
    let distance = |photo: &Photo| eye.distance(photo.pose.center_in_world());
    let mut distances: Vec<f64> = session.opened.site.photos.iter().map(distance).collect();
    let farthest = of_rank(&mut distances, MOST_PICTURES).unwrap_or(f64::INFINITY);
    for (id, photo) in session.opened.site.numbered_photos() {
        let selected = view.selection.photo == Some(id);
        let color = if selected { SELECTED } else { CAMERA };
        let away = distance(photo);
        let texture = photos.small(id).filter(|_| away < farthest || selected).map(TextureHandle::id);
        // A camera close to the viewpoint would hide the scene.
        let opacity = opacity_at(away / size);
        if opacity <= 0.0 {
            continue;
        }
        let stroke = Stroke::new(if selected { 2.0 } else { 1.0 }, color.gamma_multiply(opacity));
        canvas.camera(photo, size, stroke, texture, opacity, pointer);
    }
}

/// Draws the photo that the view looks through, fitted to the view's height as its camera is.
fn photo_over(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    rect: Rect,
    photos: &PhotoTextures,
    requests: &mut Vec<Request>,
) {
    // Typed text is no command.
    let typed = ui.ctx().text_edit_focused() || dialog::is_open(ui.ctx());
    let flips = !typed && ui.input(|input| input.key_down(Key::X));
    let shown = it.photo_over != flips;
    let (Some(photo), session, true) = (it.through, view.scene.session, shown) else { return };
    requests.push(FlatRequest::WantLargePicture(photo).into());
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
    wipe_line(ui, it, rect);
}

/// Draws the line up to which the photo is drawn, with a handle; a drag moves it.
fn wipe_line(ui: &Ui, it: &mut SpaceMemory, rect: Rect) {
    let at = pos2(rect.left() + rect.width() * it.wipe, rect.center().y);
    let line = Rect::from_center_size(at, vec2(2.0 * WIPE_HANDLE, rect.height())).intersect(rect);
    let response = ui.interact(line, ui.scope_id().with("wipe line"), Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Wipe line"));
    if response.dragged() {
        it.wipe = (it.wipe + response.drag_delta().x / rect.width()).clamp(0.0, 1.0);
    }
    let lit = response.hovered() || response.dragged();
    if lit {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let painter = ui.painter_at(rect);
    let stroke = Stroke::new(if lit { 2.0 } else { 1.0 }, Color32::WHITE);
    if it.wipe < 1.0 || lit {
        painter.vline(at.x, rect.y_range(), stroke);
    }
    let handle = Rect::from_center_size(at, vec2(WIPE_HANDLE, 4.0 * WIPE_HANDLE));
    painter.rect(handle, 2.0, Color32::from_black_alpha(120), stroke, StrokeKind::Inside);
}

/// A canvas that projects points of the world onto the view.
pub struct WorldCanvas {
    /// The painter, clipped to the view.
    pub painter: Painter,
    /// The rectangle of the view, in points.
    pub rect: Rect,
    /// Where the picture is seen from.
    pub view: Viewpoint,
}

impl WorldCanvas {
    /// Draws the outline of a face; of an impostor that of the rectangle that faces the eye.
    fn outline(&self, session: &Session, face: FaceId, stroke: Stroke) {
        if let Some(impostor) = session.model().impostor(face) {
            self.rectangle(impostor).into_iter().for_each(|[from, to]| self.line(from, to, stroke));
            return;
        }
        let vertices = &session.model().vertices;
        for &[from, to] in session.edges.of_face(face) {
            self.line(vertices[from as usize], vertices[to as usize], stroke);
        }
    }

    /// Returns the edges of the rectangle of an impostor that faces the eye.
    fn rectangle(&self, impostor: &Impostor) -> [[DVec3; 2]; 4] {
        let corners = impostor.corners(&Facing::of_pose(&self.view.pose));
        [0, 1, 2, 3].map(|corner| [corners[corner], corners[(corner + 1) % 4]])
    }

    /// Draws many lines as one mesh: thousands of separate shapes would dominate the frame time. Each line is a ridge,
    /// opaque in the middle and transparent a pixel beside it, and looks as smooth as a line of egui.
    fn wires(&self, session: &Session, colour: Color32) {
        let vertices = &session.model().vertices;
        let mut mesh = Mesh::default();
        let modelled = session.edges.all().iter().map(|edge| edge.map(|vertex| vertices[vertex as usize]));
        let impostors = session.model().objects.iter().filter_map(|object| object.impostor.as_ref());
        for [from, to] in modelled.chain(impostors.flat_map(|impostor| self.rectangle(impostor))) {
            let Some(ends) = self.view.segment(from, to) else {
                continue;
            };
            let [from, to] = ends.map(|end| self.at(end));
            if self.rect.intersects(Rect::from_two_pos(from, to)) {
                ridge(&mut mesh, from, to, colour);
            }
        }
        self.painter.add(Shape::mesh(mesh));
    }

    /// Draws a line between two points of the world, as far as it is in front of the eye.
    pub fn line(&self, from: DVec3, to: DVec3, stroke: Stroke) {
        if let Some([from, to]) = self.view.segment(from, to) {
            self.painter.line_segment([self.at(from), self.at(to)], stroke);
        }
    }

    /// Returns where a point of the world is in the view; `None` behind the viewpoint.
    pub fn place(&self, point: DVec3) -> Option<Pos2> {
        self.view.place(point).map(|at| self.at(at))
    }

    /// Converts a point, in heights of the picture from its centre, to the screen.
    fn at(&self, point: glam::DVec2) -> Pos2 {
        let height = self.rect.height();
        self.rect.center() + vec2(point.x as f32, point.y as f32) * height
    }

    /// Draws the camera of a photo as a pyramid whose tip is the camera's centre and whose base is `size` world units
    /// high. The base shows the photo where `texture` is given.
    fn camera(
        &self,
        photo: &Photo,
        size: f64,
        stroke: Stroke,
        texture: Option<TextureId>,
        opacity: f32,
        pointer: Option<Pos2>,
    ) {
        let (width, height) = (f64::from(photo.camera.width), f64::from(photo.camera.height));
        let depth = size * photo.camera.fy / height;
        let corner = |x: f64, y: f64| {
            let ray = photo.camera.ray_in_camera(glam::DVec2::new(x * width, y * height));
            photo.pose.world_from_camera(ray * depth)
        };
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        let on_screen: Option<Vec<Pos2>> =
            corners.iter().map(|corner| self.view.place(*corner).map(|at| self.at(at))).collect();
        let is_in_the_way = on_screen.zip(pointer).is_some_and(|(corners, at)| is_within(&corners, at));
        if let Some(texture) = texture {
            self.picture(texture, if is_in_the_way { IN_THE_WAY } else { opacity }, corner);
        }
        let tip = photo.pose.center_in_world();
        let base = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        for (index, from) in base.iter().enumerate() {
            self.line(*from, base[(index + 1) % 4], stroke);
            self.line(tip, *from, stroke);
        }
    }

    /// Draws a picture on a quadrilateral in space, in pieces small enough to look straight.
    fn picture(&self, texture: TextureId, opacity: f32, corner: impl Fn(f64, f64) -> DVec3) {
        const PIECES: u32 = 4;
        let mut mesh = Mesh::with_texture(texture);
        for row in 0..=PIECES {
            for column in 0..=PIECES {
                let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(PIECES));
                // A picture partly behind the eye is left out: its outline marks it.
                let Some(point) = self.view.place(corner(u, v)) else { return };
                let (pos, uv) = (self.at(point), pos2(u as f32, v as f32));
                mesh.vertices.push(Vertex {
                    pos,
                    uv,
                    color: Color32::from_white_alpha((215.0 * opacity) as u8),
                });
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

/// Returns whether a position is within a convex outline.
fn is_within(corners: &[Pos2], at: Pos2) -> bool {
    let side = |index: usize| {
        let (from, to) = (corners[index], corners[(index + 1) % corners.len()]);
        let (edge, offset) = (to - from, at - from);
        edge.x * offset.y - edge.y * offset.x
    };
    let sides: Vec<f32> = (0..corners.len()).map(side).collect();
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
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
