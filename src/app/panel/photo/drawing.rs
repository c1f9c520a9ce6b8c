//! Overlays on the photo: outlines of elements by depth, rectangles of image layers, the selection, and the shape under
//! the pointer.

use eframe::egui::{Align2, Color32, FontId, Painter, Rect, Stroke, StrokeKind, Ui};

use super::placed::PlacedPhoto;
use super::view::PhotoView;
use crate::panel::flat::placement::PlacedPicture;
use crate::state::flat::photo::PhotoPane;
use crate::state::flat::picked::Picked;
use crate::state::flat::version::LayersVersion;
use crate::state::selection::Selection;
use quadratura_document::Stack;
use quadratura_editing::peel::{PeelOptions, PeelShape, PhotoLayers};
use quadratura_layers::LayerIndex;

/// The colour of the selection.
const SELECTED: Color32 = Color32::from_rgb(0xff, 0xa0, 0x30);
/// The colour of the shape under the pointer.
const POINTED: Color32 = Color32::from_rgb(0xff, 0xf0, 0xc0);
/// The colour of layers that will be one.
pub const MERGED: Color32 = Color32::from_rgb(0x7c, 0xe0, 0x7c);
/// The colours of outlines of visibility layers, from front to back, repeated.
const DEPTHS: [Color32; 7] = [
    Color32::from_rgb(0xff, 0x5c, 0x5c),
    Color32::from_rgb(0xff, 0xc8, 0x3d),
    Color32::from_rgb(0x6f, 0xd8, 0x5a),
    Color32::from_rgb(0x3f, 0xd0, 0xc9),
    Color32::from_rgb(0x5a, 0x9b, 0xff),
    Color32::from_rgb(0xb0, 0x7c, 0xff),
    Color32::from_rgb(0xff, 0x7c, 0xd0),
];

/// Returns the colour of a visibility layer.
pub fn colour_of_depth(depth: u32) -> Color32 {
    DEPTHS[depth as usize % DEPTHS.len()]
}

/// Draws the overlays.
pub fn drawing_ui(ui: &Ui, view: &PhotoView<'_>, pane: &PhotoPane, placed: &PlacedPhoto) {
    let (photo, seen) = (placed.photo, &placed.seen);
    let Some(session) = view.session else { return };
    let Some(version) = LayersVersion::new(session, photo) else { return };
    let picked = Picked::new(view.selection.main, session, photo);
    let drawing = PhotoDrawing {
        painter: ui.painter_at(seen.rect),
        seen,
        peeling: view.flat.peeling(session, photo, pane.hidden_layers),
    };
    if let Some(layers) = view.flat.loading.layers(&version) {
        if view.flat.switches.outlines {
            drawing.elements(&layers);
        }
        drawing.merges(&layers, &version.stack, &session.layers_to_merge(photo, view.running));
        let more = |shape: &PeelShape| view.selection.more_layers.contains(&(photo, shape.layer));
        for shape in layers.shapes.iter().filter(|shape| picked.has(shape) || more(shape)) {
            drawing.shape(shape, Stroke::new(2.5, SELECTED), Stroke::new(1.0, SELECTED.gamma_multiply(0.6)));
        }
        if let Some(shape) = pane.pointed.as_ref().and_then(|pointed| pointed.shape(&layers)) {
            drawing.shape(shape, Stroke::new(1.8, POINTED), Stroke::new(1.8, POINTED));
        }
    }
    drawing.rectangles(&version.stack, picked, view.flat.switches.rectangles);
    if let Some((face, mark)) = pane.mark
        && view.selection.main == Selection::Face(face)
    {
        drawing.cross(seen.at(mark));
    }
}

struct PhotoDrawing<'a> {
    painter: Painter,
    seen: &'a PlacedPicture,
    peeling: PeelOptions,
}

impl PhotoDrawing<'_> {
    /// Draws outlines from back to front, so that nearer ones are on top.
    fn elements(&self, layers: &PhotoLayers) {
        let left: Vec<&PeelShape> = layers.shapes.iter().filter(|shape| self.peeling.shows(shape)).collect();
        let deepest = left.iter().map(|shape| shape.depth).max().unwrap_or(0);
        for depth in (self.peeling.hidden_layers..=deepest).rev() {
            let stroke = Stroke::new(1.3, colour_of_depth(depth));
            left.iter()
                .filter(|shape| shape.depth == depth)
                .for_each(|shape| self.shape(shape, stroke, Stroke::NONE));
        }
    }

    /// Draws the outlines of layers that will be one, with a frame around each such layer, before they are built.
    fn merges(&self, layers: &PhotoLayers, stack: &Stack, merges: &[Vec<LayerIndex>]) {
        for merge in merges {
            for shape in layers.shapes.iter().filter(|shape| merge.contains(&shape.layer)) {
                self.shape(shape, Stroke::new(2.2, MERGED), Stroke::NONE);
            }
            let rects = merge.iter().map(|layer| self.seen.rect_of(stack.layer(*layer).needed_rect));
            let frame = rects.reduce(Rect::union).unwrap_or(Rect::NOTHING);
            self.painter.rect_stroke(frame, 0.0, Stroke::new(1.2, MERGED), StrokeKind::Outside);
            let names: Vec<&str> = merge.iter().map(|layer| stack.layer(*layer).name.as_str()).collect();
            self.label(frame, format!("One layer: {}", names.join(" + ")), MERGED);
        }
    }

    /// Writes a name into the visible upper left corner of a frame.
    fn label(&self, frame: Rect, name: String, colour: Color32) {
        let at = frame.intersect(self.seen.rect).left_top() + eframe::egui::vec2(4.0, 3.0);
        let text = self.painter.layout_no_wrap(name, FontId::proportional(12.0), colour);
        let back = Rect::from_min_size(at, text.size()).expand(2.0);
        self.painter.rect_filled(back, 2.0, Color32::from_black_alpha(150));
        self.painter.galley(at, text, colour);
    }

    fn shape(&self, shape: &PeelShape, outer: Stroke, inner: Stroke) {
        for edge in &shape.edges {
            let stroke = if edge.inner { inner } else { outer };
            let ends = edge.ends.map(|end| self.seen.at(end));
            if !stroke.is_empty() && Rect::from_two_pos(ends[0], ends[1]).intersects(self.seen.rect) {
                self.painter.line_segment(ends, stroke);
            }
        }
    }

    fn rectangles(&self, stack: &Stack, picked: Picked, all: bool) {
        for (index, layer) in stack.numbered_layers() {
            let selected = picked == Picked::Layer(index);
            if !selected && !all {
                continue;
            }
            let colour = if selected { SELECTED } else { colour_of_depth(layer.order).gamma_multiply(0.8) };
            let rect = self.seen.rect_of(layer.rect);
            let stroke = Stroke::new(if selected { 1.6 } else { 1.0 }, colour);
            self.painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Outside);
            if selected || (rect.width() > 80.0 && self.seen.rect.contains(rect.left_top())) {
                self.label(rect, layer.name.clone(), colour);
            }
        }
    }

    fn cross(&self, at: eframe::egui::Pos2) {
        let stroke = Stroke::new(2.0, SELECTED);
        self.painter.circle_stroke(at, 9.0, stroke);
        for by in [eframe::egui::vec2(14.0, 0.0), eframe::egui::vec2(0.0, 14.0)] {
            self.painter.line_segment([at - by, at + by], stroke);
        }
        let below = at + eframe::egui::vec2(0.0, 18.0);
        let font = FontId::proportional(12.0);
        self.painter.text(below, Align2::CENTER_TOP, "hidden here", font, SELECTED);
    }
}
