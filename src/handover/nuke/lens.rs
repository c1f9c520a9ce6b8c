//! The knobs of a camera of Nuke whose film is a rectangle of a photo.

use quadratura_base::geometry::{Pinhole, PixelRect};

use crate::camera::FILM_WIDTH_MM;

/// A camera's lens as Nuke has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NukeLens {
    /// The focal length in millimetres.
    pub focal: f64,
    /// The width of the film in millimetres.
    pub haperture: f64,
    /// Its height.
    pub vaperture: f64,
    /// How far the film is moved, in half widths of it, to the right and up.
    pub win_translate: [f64; 2],
    /// The width of a pixel by its height.
    pub pixel_aspect: f64,
}

/// Returns the lens of a rectangle of a photo. With s mm for the photo's width W and a = fx / fy: focal = fx s / W, the film is s w / W wide and
/// s a h / W high, and moved by 2 (w/2 - (cx - x)) / w and 2 ((cy - y) - h/2) a / w, in half widths of the film both. The signs are those of
/// Foundry's own `snap3d.py`.
pub fn nuke_lens(camera: &Pinhole, rect: PixelRect) -> NukeLens {
    let [x, y, w, h] = [f64::from(rect.x), f64::from(rect.y), f64::from(rect.w), f64::from(rect.h)];
    let (per_pixel, aspect) = (FILM_WIDTH_MM / f64::from(camera.width), camera.fx / camera.fy);
    NukeLens {
        focal: camera.fx * per_pixel,
        haperture: w * per_pixel,
        vaperture: h * aspect * per_pixel,
        win_translate: [(w - 2.0 * (camera.cx - x)) / w, (2.0 * (camera.cy - y) - h) * aspect / w],
        pixel_aspect: 1.0 / aspect,
    }
}
