//! The brush in the 3D view: mouse, keys, its circle on the surface, and strokes that are not painted yet.

use eframe::egui::epaint::Mesh;
use eframe::egui::{
    Color32, ComboBox, CursorIcon, Event, Key, Modifiers, PointerButton, Pos2, Rect, Response, Shape, Slider,
    Stroke as Line, TextureId, Ui, pos2, vec2,
};
use glam::{DVec2, DVec3};

use super::overlay::seen_from;
use super::px_of;
use super::view::SpacePaneView;
use crate::panel::bar::{BarPart, BarPosition};
use crate::panel::named;
use crate::state::notes::{Note, Weight};
use crate::state::request::{Request, WindowRequest};
use crate::state::space::brush::{DrawnStroke, RADII_PX};
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::ViewPixel;
use crate::widget::dialog;
use quadratura_base::scene::FaceId;
use quadratura_base::scene::impostor::Facing;
use quadratura_document::stroke::{BrushMode, StrokeSample};
use quadratura_view::navigation::Viewpoint;

/// The parts of the brush's bar.
pub fn tools<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 5] {
    [
        BarPart::Tool(mode),
        BarPart::Tool(size),
        BarPart::Tool(hardness),
        BarPart::Tool(opacity),
        BarPart::Tool(colour),
    ]
}

/// The number of corners of circles.
const CORNERS: u32 = 48;
/// The colour of the brush's circle, and of its shadow.
const CIRCLE: [Color32; 2] = [Color32::from_black_alpha(160), Color32::WHITE];
/// The colour of a stroke that clones or heals, in a picture of another view.
const COPIES: Color32 = Color32::from_rgba_premultiplied(110, 110, 110, 110);
/// The colour of a stroke that erases, while it is drawn.
const ERASES: Color32 = Color32::from_rgb(0xff, 0x60, 0xa0);

/// Handles mouse and keys while the brush is in use.
pub fn hand_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    if !it.brush.on {
        return;
    }
    let has_keys = view.has_keys && !dialog::is_open(ui.ctx());
    if has_keys && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
        // Escape cancels the stroke first, then puts the brush away.
        it.brush.on = it.brush.give_up();
        // The bars show the state of the frame before.
        ui.ctx().request_repaint();
        return;
    }
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    }
    let density = ui.ctx().pixels_per_point();
    let place = |at: Pos2| px_of(at - rect.min, density);
    let may_begin = response.hovered() || response.is_pointer_button_down_on();
    let mut pressure = 1.0;
    for event in ui.input(|input| input.events.clone()) {
        match event {
            Event::Touch { force: Some(force), .. } => pressure = f64::from(force).clamp(0.0, 1.0),
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, modifiers }
                if may_begin && rect.contains(pos) =>
            {
                response.request_focus();
                let pixel = it.pixel_at(place(pos));
                if seen_from(view, it) != it.viewpoint {
                    let text = "The picture is not of this view yet: paint when it is";
                    requests.push(WindowRequest::Say(Note::new(Weight::Info, text)).into());
                } else if modifiers.command || modifiers.alt {
                    it.brush.source = view.scene.point_at(&pixel).or(it.brush.source);
                } else if !it.brush.begin(&pixel, pressure) {
                    let text =
                        "Pick a source first: Ctrl+click where colours are to be taken from, in this view";
                    requests.push(WindowRequest::Say(Note::new(Weight::Info, text)).into());
                }
            }
            Event::PointerMoved(at) => it.brush.go_to(place(at), pressure),
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => {
                it.brush.go_to(place(pos), pressure);
                it.brush.end();
            }
            _ => (),
        }
    }
}

/// Draws strokes that are not painted yet, the brush's circle and its source.
pub fn brush_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &SpaceMemory,
    response: &Response,
    rect: Rect,
    picture: Option<TextureId>,
) {
    let canvas = BrushCanvas { ui, rect, view: seen_from(view, it), picture };
    for drawn in it.brush.previews() {
        canvas.stroke(view, drawn);
    }
    if !it.brush.on {
        return;
    }
    if let Some(source) = it.brush.source.filter(|_| it.brush.brush.mode.has_source()) {
        canvas.cross(source);
    }
    if let Some(at) = response.hover_pos() {
        let pixel = it.pixel_at(px_of(at - rect.min, ui.ctx().pixels_per_point()));
        canvas.circle(view, &pixel, at, it.brush.brush.radius);
    }
}

struct BrushCanvas<'a> {
    ui: &'a Ui,
    rect: Rect,
    view: Viewpoint,
    picture: Option<TextureId>,
}

impl BrushCanvas<'_> {
    /// Draws a stroke as it will be, but for healing and for what hides it. In a picture of another view the copied
    /// colours are not known: a light band marks where they will be.
    fn stroke(&self, view: &SpacePaneView<'_>, drawn: &DrawnStroke) {
        let stroke = &drawn.stroke;
        let is_here = (drawn.viewpoint.pose, drawn.viewpoint.lens) == (self.view.pose, self.view.lens);
        let points = self.rect.height() / stroke.view.height as f32;
        let at = |px: [f64; 2]| vec2(px[0] as f32, px[1] as f32) * points;
        let offset = stroke.source.map(|source| at(source) - at(stroke.samples[0].at));
        let (texture, shift) = match (offset, self.picture) {
            (Some(offset), Some(texture)) if is_here => (texture, Some(offset)),
            _ => (TextureId::default(), None),
        };
        let colour = match stroke.brush.mode {
            BrushMode::Erase => ERASES.gamma_multiply(0.4),
            _ if shift.is_some() => Color32::WHITE,
            mode if mode.has_source() => COPIES,
            _ => Color32::from_rgb(stroke.brush.colour[0], stroke.brush.colour[1], stroke.brush.colour[2]),
        };
        let colour = colour.gamma_multiply(stroke.brush.opacity as f32);
        let mut mesh = Mesh::with_texture(texture);
        let uv = |at: Pos2| match shift {
            Some(shift) => {
                let from = at + shift - self.rect.min;
                pos2(from.x / self.rect.width(), from.y / self.rect.height())
            }
            None => eframe::egui::epaint::WHITE_UV,
        };
        for [center, inner, outer] in self.dabs(view, drawn) {
            let first = mesh.vertices.len() as u32;
            let corners = center.iter().chain(&inner).map(|at| (*at, colour));
            for (pos, color) in corners.chain(outer.iter().map(|at| (*at, Color32::TRANSPARENT))) {
                mesh.vertices.push(eframe::egui::epaint::Vertex { pos, uv: uv(pos), color });
            }
            for i in 0..CORNERS {
                let next = (i + 1) % CORNERS;
                let [a, b] = [first + 1 + i, first + 1 + next];
                mesh.add_triangle(first, a, b);
                mesh.add_triangle(a, a + CORNERS, b);
                mesh.add_triangle(b, a + CORNERS, b + CORNERS);
            }
        }
        self.ui.painter_at(self.rect).add(Shape::mesh(mesh));
    }

    /// Returns the dabs of a stroke, as discs on the surfaces that it passes: the centre of each, the outline of full
    /// effect, and the outline. They have the same size on the surface all along the stroke.
    fn dabs(&self, view: &SpacePaneView<'_>, drawn: &DrawnStroke) -> Vec<[Vec<Pos2>; 3]> {
        let stroke = &drawn.stroke;
        let size_px = [stroke.view.width, stroke.view.height];
        let surface = |sample: &StrokeSample| {
            let at_px = DVec2::from(sample.at);
            let pixel = ViewPixel { viewpoint: drawn.viewpoint, size_px, at_px };
            let (point, face) = view.scene.surface_at(&pixel)?;
            Some((point, normal_seen(view, drawn.viewpoint, face)?))
        };
        let Some((first, _)) = stroke.samples.iter().find_map(surface) else { return Vec::new() };
        let camera = drawn.viewpoint.camera(size_px[0], size_px[1]);
        let depth = drawn.viewpoint.pose.camera_from_world(first).z;
        let radius = stroke.brush.radius * depth / (camera.fx * camera.fy).sqrt();
        let dab = |sample: &StrokeSample| {
            let (point, normal) = surface(sample)?;
            let (u, v) = normal.any_orthonormal_pair();
            let disc = |share: f64| {
                let reach = radius * sample.pressure * share;
                self.ring(|angle| self.place(point + (u * angle.cos() + v * angle.sin()) * reach))
            };
            Some([vec![self.place(point)?], disc(stroke.brush.hardness)?, disc(1.0)?])
        };
        between(&stroke.samples, stroke.brush.radius / 3.0).iter().filter_map(dab).collect()
    }

    /// Draws the brush's circle on the surface under the pointer; in the plane of the picture where there is none.
    fn circle(&self, view: &SpacePaneView<'_>, pixel: &ViewPixel, at: Pos2, radius_px: f64) {
        let on_surface = || {
            let (point, face) = (view.scene.point_at(pixel)?, view.scene.face_at(pixel)?);
            let normal = normal_seen(view, pixel.viewpoint, face)?;
            let camera = pixel.viewpoint.camera(pixel.size_px[0], pixel.size_px[1]);
            let depth = pixel.viewpoint.pose.camera_from_world(point).z;
            let radius = radius_px * depth / (camera.fx * camera.fy).sqrt();
            let (u, v) = normal.any_orthonormal_pair();
            let canvas = BrushCanvas { view: pixel.viewpoint, ..*self };
            canvas.ring(|angle| canvas.place(point + (u * angle.cos() + v * angle.sin()) * radius))
        };
        let points = radius_px as f32 / self.ui.ctx().pixels_per_point();
        let flat = |angle: f64| Some(at + vec2(angle.cos() as f32, angle.sin() as f32) * points);
        let Some(ring) = on_surface().or_else(|| self.ring(flat)) else { return };
        let painter = self.ui.painter_at(self.rect);
        for (colour, width) in CIRCLE.into_iter().zip([3.0, 1.0]) {
            painter.add(Shape::closed_line(ring.clone(), Line::new(width, colour)));
        }
    }

    fn ring(&self, corner: impl Fn(f64) -> Option<Pos2>) -> Option<Vec<Pos2>> {
        (0..CORNERS).map(|i| corner(std::f64::consts::TAU * f64::from(i) / f64::from(CORNERS))).collect()
    }

    fn cross(&self, point: DVec3) {
        let Some(at) = self.place(point) else { return };
        let painter = self.ui.painter_at(self.rect);
        for (colour, width) in CIRCLE.into_iter().zip([3.0, 1.0]) {
            let line = Line::new(width, colour);
            painter.line_segment([at - vec2(7.0, 0.0), at + vec2(7.0, 0.0)], line);
            painter.line_segment([at - vec2(0.0, 7.0), at + vec2(0.0, 7.0)], line);
        }
    }

    fn place(&self, point: DVec3) -> Option<Pos2> {
        let at = self.view.place(point)?;
        Some(self.rect.center() + vec2(at.x as f32, at.y as f32) * self.rect.height())
    }
}

/// Returns positions along a stroke, `step` pixels apart.
fn between(samples: &[StrokeSample], step: f64) -> Vec<StrokeSample> {
    let mut all = samples[..1].to_vec();
    for pair in samples.windows(2) {
        let [from, to] = [0, 1].map(|i: usize| DVec2::from(pair[i].at));
        let steps = (from.distance(to) / step.max(1.0)).ceil().max(1.0) as u32;
        all.extend((1..=steps).map(|i| StrokeSample {
            at: from.lerp(to, f64::from(i) / f64::from(steps)).to_array(),
            pressure: pair[1].pressure,
        }));
    }
    all
}

fn mode(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, place: BarPosition, _: &mut Vec<Request>) {
    let modes = [BrushMode::Colour, BrushMode::Clone, BrushMode::Heal, BrushMode::Erase];
    let choices = |ui: &mut Ui, now: &mut BrushMode| {
        for other in modes {
            ui.selectable_value(now, other, mode_name(other)).on_hover_text(mode_tooltip(other));
        }
    };
    if place == BarPosition::Menu {
        choices(ui, &mut it.brush.brush.mode);
        return;
    }
    let now = it.brush.brush.mode;
    let combo = ComboBox::from_id_salt("brush mode").selected_text(mode_name(now));
    named(&combo.show_ui(ui, |ui| choices(ui, &mut it.brush.brush.mode)).response, "Brush mode");
}

fn size(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let slider = Slider::new(&mut it.brush.brush.radius, RADII_PX).logarithmic(true).max_decimals(0);
    ui.horizontal(|ui| {
        ui.add(slider.text("size")).on_hover_text("Radius in pixels of the view; [ and ] change it.")
    });
}

fn hardness(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let slider = Slider::new(&mut it.brush.brush.hardness, 0.0..=1.0).show_value(false).text("hardness");
    ui.horizontal(|ui| ui.add(slider).on_hover_text("Share of the radius with full effect."));
}

fn opacity(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let is_used = it.brush.brush.mode != BrushMode::Erase;
    ui.add_enabled_ui(is_used, |ui| {
        let slider = Slider::new(&mut it.brush.brush.opacity, 0.0..=1.0).show_value(false).text("opacity");
        ui.horizontal(|ui| ui.add(slider));
    });
}

fn colour(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    if it.brush.brush.mode.has_source() {
        let source = if it.brush.source.is_none() {
            "First Ctrl+click where colours are taken from"
        } else if it.brush.brush.mode == BrushMode::Heal {
            "Ctrl+click: other source. Colours adapt once it is painted"
        } else {
            "Ctrl+click: other source"
        };
        ui.weak(source);
    } else if it.brush.brush.mode == BrushMode::Colour {
        named(&ui.color_edit_button_srgb(&mut it.brush.brush.colour), "Brush colour");
    }
}

fn mode_name(mode: BrushMode) -> &'static str {
    match mode {
        BrushMode::Colour => "Colour",
        BrushMode::Clone => "Clone",
        BrushMode::Heal => "Heal",
        BrushMode::Erase => "Erase strokes",
        BrushMode::SeeThrough => "See through",
        BrushMode::Solid => "Solid",
        BrushMode::Solve => "Unknown, solve",
    }
}

fn mode_tooltip(mode: BrushMode) -> &'static str {
    match mode {
        BrushMode::Colour => "Paints with a colour.",
        BrushMode::Clone => "Paints with what the view shows at the source.",
        BrushMode::Heal => {
            "Clones, and adapts the colours to those around the stroke. While it is drawn, you see the clone."
        }
        BrushMode::Erase => {
            "Removes paint of earlier strokes in the whole circle; paint of the image editor stays."
        }
        BrushMode::SeeThrough => "In the photo view: one sees through the layer here.",
        BrushMode::Solid => "In the photo view: the layer is solid here.",
        BrushMode::Solve => "In the photo view: how much of the layer is here follows from the colours.",
    }
}
/// Returns the normal of a face as a viewer sees it.
fn normal_seen(view: &SpacePaneView<'_>, viewpoint: Viewpoint, face: FaceId) -> Option<DVec3> {
    let model = view.scene.session.model();
    Some(model.plane_facing(face, &Facing::of_pose(&viewpoint.pose)).normal)
}
