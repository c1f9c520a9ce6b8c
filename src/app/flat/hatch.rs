//! Hatching over what is hidden, and the checkerboard below what is transparent.

use eframe::egui::{
    Color32, ColorImage, Context, Painter, Rect, Stroke, TextureHandle, TextureOptions, pos2,
};

use super::placement::Seen;
use crate::projection::hatching::{Mask, stripes};

/// Between stripes, in points at least.
const PITCH: f64 = 8.0;
/// A field of the checkerboard, in points.
const FIELD: f32 = 9.0;
/// What is hidden.
pub const HIDDEN: Color32 = Color32::from_rgb(0xf2, 0x8c, 0x38);

/// Draws stripes over a mask.
pub fn hatch(painter: &Painter, seen: &Seen, mask: &Mask) {
    // Powers of two, so that stripes stay where they are from one size to the next.
    let pitch_px = (PITCH / seen.scale).max(1.0).log2().ceil().exp2() as u32;
    let stroke = Stroke::new(1.2, HIDDEN);
    for [from, to] in stripes(mask, seen.window(mask.rect()), pitch_px) {
        painter.line_segment([seen.at(from), seen.at(to)], stroke);
    }
}

/// The checkerboard, once it was drawn.
#[derive(Default)]
pub struct Checkerboard {
    texture: Option<TextureHandle>,
}

impl Checkerboard {
    /// Draws it over `rect`, the same place of it always at the same place of the screen.
    pub fn draw(&mut self, painter: &Painter, rect: Rect) {
        let texture = self.texture.get_or_insert_with(|| fields(painter.ctx()));
        let uv = |place: eframe::egui::Pos2| pos2(place.x / (2.0 * FIELD), place.y / (2.0 * FIELD));
        painter.image(texture.id(), rect, Rect::from_min_max(uv(rect.min), uv(rect.max)), Color32::WHITE);
    }
}

fn fields(context: &Context) -> TextureHandle {
    let (dark, light) = (Color32::from_gray(52), Color32::from_gray(66));
    let image = ColorImage::new([2, 2], vec![dark, light, light, dark]);
    context.load_texture("checkerboard", image, TextureOptions::NEAREST_REPEAT)
}
