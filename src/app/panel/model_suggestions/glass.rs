//! Suggestions drawn as glass over a view, and edges of them that the mouse drags along their planes.

use eframe::egui::epaint::Mesh;
use eframe::egui::{Color32, CursorIcon, Painter, PointerButton, Pos2, Response, Shape, Stroke, Ui};
use glam::DVec3;

use super::COLOURS;
use crate::state::model_suggestions::{EdgeGrip, EdgeOfSuggestion, ModelSuggestions, OfferedFace};
use crate::state::request::{ModelRequest, Request};
use quadratura_base::geometry::Pose;
use quadratura_sites::suggest::is_bridge;

/// The distance from an edge within which the pointer takes hold of it, in points.
const REACH: f32 = 7.0;
/// The opacity of glass, and of the glass that the list points at.
const OPACITY: [f32; 2] = [0.22, 0.5];
/// The least depth that is drawn, as a share of a triangle's largest.
const LEAST_DEPTH: f64 = 1e-3;

/// Returns the colour of a suggestion.
pub fn colour_of_offer(index: usize) -> Color32 {
    COLOURS[index % COLOURS.len()]
}

/// A view that glass is drawn over.
pub struct GlassView<'a> {
    /// The painter, clipped to the view.
    pub painter: Painter,
    /// The pose of the view's camera.
    pub pose: Pose,
    /// Where a point of the world in front of the camera is on the screen.
    pub place: &'a dyn Fn(DVec3) -> Option<Pos2>,
    /// The direction in the world in which a position on the screen is seen.
    pub ray: &'a dyn Fn(Pos2) -> DVec3,
}

impl GlassView<'_> {
    /// Draws all suggestions, those that are not wanted as outlines.
    pub fn draw(&self, offered: &ModelSuggestions, grip: &EdgeGrip) {
        for (index, object) in offered.objects.iter().enumerate() {
            let (colour, is_pointed) = (colour_of_offer(index), offered.pointed == Some(index));
            for face in &object.faces {
                if object.wanted || is_pointed {
                    self.fill(face, colour.gamma_multiply(OPACITY[usize::from(is_pointed)]));
                }
                let faint = if object.wanted { 1.0 } else { 0.5 };
                let width = if is_pointed { 2.5 } else { 1.2 };
                self.outline(face, Stroke::new(width, colour.gamma_multiply(faint)));
            }
        }
        if let Some([from, to]) = grip.edge.and_then(|edge| offered.ends(edge)) {
            self.line(from, to, Stroke::new(4.0, Color32::WHITE));
        }
    }

    fn fill(&self, face: &OfferedFace, colour: Color32) {
        let mut mesh = Mesh::default();
        for triangle in &face.triangles {
            let corners: Option<Vec<Pos2>> = self.in_front(triangle).into_iter().map(self.place).collect();
            let Some(corners) = corners.filter(|corners| corners.len() > 2) else { continue };
            let first = mesh.vertices.len() as u32;
            corners.iter().for_each(|at| mesh.colored_vertex(*at, colour));
            (1..corners.len() as u32 - 1).for_each(|i| mesh.add_triangle(first, first + i, first + i + 1));
        }
        self.painter.add(Shape::mesh(mesh));
    }

    fn outline(&self, face: &OfferedFace, stroke: Stroke) {
        for at in (0..face.ring.len()).filter(|at| !is_bridge(&face.ring, *at)) {
            self.line(face.ring[at], face.ring[(at + 1) % face.ring.len()], stroke);
        }
    }

    fn line(&self, from: DVec3, to: DVec3, stroke: Stroke) {
        if let Some(ends) = self.segment(from, to) {
            self.painter.line_segment(ends, stroke);
        }
    }

    /// Returns the part of a segment that is in front of the camera, on the screen.
    fn segment(&self, from: DVec3, to: DVec3) -> Option<[Pos2; 2]> {
        let seen = self.in_front(&[from, to]);
        Some([(self.place)(*seen.first()?)?, (self.place)(*seen.get(1)?)?])
    }

    /// Returns the part of a convex polygon, or of a segment, that is in front of the camera (Sutherland and Hodgman 1974).
    fn in_front(&self, corners: &[DVec3]) -> Vec<DVec3> {
        let depth = |corner: DVec3| self.pose.camera_from_world(corner).z;
        let least = LEAST_DEPTH * corners.iter().map(|corner| depth(*corner).abs()).fold(0.0, f64::max);
        let sides = if corners.len() == 2 { 1 } else { corners.len() };
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for at in 0..sides {
            let (from, to) = (corners[at], corners[(at + 1) % corners.len()]);
            let (near, far) = (depth(from) - least, depth(to) - least);
            if near >= 0.0 {
                kept.push(from);
            }
            if (near >= 0.0) != (far >= 0.0) {
                kept.push(from.lerp(to, near / (near - far)));
            }
            if sides == 1 && far >= 0.0 {
                kept.push(to);
            }
        }
        kept
    }

    /// Takes hold of the edge under the pointer, and drags it.
    pub fn hand(
        &self,
        ui: &Ui,
        offered: &ModelSuggestions,
        grip: &mut EdgeGrip,
        response: &Response,
        requests: &mut Vec<Request>,
    ) {
        let (at, is_down) =
            ui.input(|input| (input.pointer.latest_pos(), input.pointer.button_down(PointerButton::Primary)));
        let Some(at) = at.filter(|_| response.hovered() || response.dragged()) else {
            *grip = EdgeGrip::default();
            return;
        };
        if !is_down {
            *grip = EdgeGrip { edge: self.edge_at(offered, at), is_dragged: false };
        }
        let Some(edge) = grip.edge else { return };
        ui.ctx().set_cursor_icon(CursorIcon::Move);
        grip.is_dragged = is_down && response.dragged_by(PointerButton::Primary);
        if grip.is_dragged
            && let Some(to) = offered.face(edge).and_then(|face| self.on_plane(face, at))
        {
            requests.push(ModelRequest::MoveEdge(edge, to).into());
        }
    }

    /// Returns the edge nearest to a position on the screen, within reach.
    fn edge_at(&self, offered: &ModelSuggestions, at: Pos2) -> Option<EdgeOfSuggestion> {
        let mut best: Option<(f32, EdgeOfSuggestion)> = None;
        for (object, offer) in offered.objects.iter().enumerate().filter(|(_, offer)| offer.wanted) {
            for (face, it) in offer.faces.iter().enumerate() {
                for corner in (0..it.ring.len()).filter(|corner| !is_bridge(&it.ring, *corner)) {
                    let (from, to) = (it.ring[corner], it.ring[(corner + 1) % it.ring.len()]);
                    let Some(ends) = self.segment(from, to) else { continue };
                    let away = distance(at, ends);
                    if away < best.map_or(REACH, |(away, _)| away) {
                        best = Some((away, EdgeOfSuggestion { object, face, corner }));
                    }
                }
            }
        }
        best.map(|(_, edge)| edge)
    }

    /// Returns the point of a face's plane at a position on the screen; `None` where the plane is seen edge-on or is behind.
    fn on_plane(&self, face: &OfferedFace, at: Pos2) -> Option<DVec3> {
        let (eye, ray) = (self.pose.center_in_world(), (self.ray)(at));
        let slope = ray.normalize_or_zero().dot(face.normal);
        let away = (face.ring.first()? - eye).dot(face.normal) / ray.dot(face.normal);
        // Nearly edge-on, a pixel would move the edge by most of the site.
        (slope.abs() > 0.02 && away > 0.0 && away.is_finite()).then(|| eye + ray * away)
    }
}

/// Returns the distance of a position from a segment.
fn distance(at: Pos2, [from, to]: [Pos2; 2]) -> f32 {
    let along = to - from;
    let share = ((at - from).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
    at.distance(from + along * share)
}
