//! Hatching over hidden areas, and the checkerboard behind transparent ones.

use eframe::egui::{
    Align2, Color32, ColorImage, Context, FontId, Painter, Rect, Stroke, TextureHandle, TextureOptions, Vec2,
    pos2, vec2,
};

use super::placement::PlacedPicture;
use quadratura_projection::hatching::{PixelMask, stripes};

/// The smallest distance between stripes, in points.
const PITCH: f64 = 8.0;
/// The side of a square of the checkerboard, in points.
const FIELD: f32 = 9.0;
/// Where it is said that nothing is hidden, from the lower left corner.
const NOTHING_AT: Vec2 = vec2(8.0, -8.0);
/// The colour of hidden areas.
pub const HIDDEN: Color32 = Color32::from_rgb(0xf2, 0x8c, 0x38);

/// Draws stripes over a mask; says so where nothing of it is left to be hatched.
pub fn hatch(painter: &Painter, seen: &PlacedPicture, mask: &PixelMask) {
    if !mask.pixels().contains(&true) {
        let (at, font) = (seen.rect.left_bottom() + NOTHING_AT, FontId::proportional(12.0));
        painter.text(at, Align2::LEFT_BOTTOM, "Hatching: nothing is hidden here", font, HIDDEN);
        return;
    }
    // The pitch is a power of two, so that stripes keep their positions from one zoom level to the next.
    let pitch_px = (PITCH / seen.scale).max(1.0).log2().ceil().exp2() as u32;
    let stroke = Stroke::new(1.2, HIDDEN);
    for [from, to] in stripes(mask, seen.window(mask.rect()), pitch_px) {
        painter.line_segment([seen.at(from), seen.at(to)], stroke);
    }
}

/// The checkerboard behind transparent areas. Its texture is made when it is first drawn.
#[derive(Default)]
pub struct Checkerboard {
    texture: Option<TextureHandle>,
}

impl Checkerboard {
    /// Draws the checkerboard over `rect`; the pattern is fixed to the screen.
    pub fn draw(&mut self, painter: &Painter, rect: Rect) {
        let texture = self.texture.get_or_insert_with(|| fields(painter.ctx()));
        let uv = |position: eframe::egui::Pos2| pos2(position.x / (2.0 * FIELD), position.y / (2.0 * FIELD));
        painter.image(texture.id(), rect, Rect::from_min_max(uv(rect.min), uv(rect.max)), Color32::WHITE);
    }
}

fn fields(context: &Context) -> TextureHandle {
    let (dark, light) = (Color32::from_gray(52), Color32::from_gray(66));
    let image = ColorImage::new([2, 2], vec![dark, light, light, dark]);
    context.load_texture("checkerboard", image, TextureOptions::NEAREST_REPEAT)
}
