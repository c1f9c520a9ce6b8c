//! The surroundings beyond the outlines of the model, without what stands on these in the reference photo: cornices, tiles, and
//! pixels that mix a face with what is behind it. They are near, and would stay behind in the sky when the viewpoint moves.

use rayon::prelude::*;

use super::nearest::nearest;
use crate::geometry::PixelRect;
use crate::projection::skirts::BAND;
use crate::projection::srgb::Srgb;

/// The distance from the outlines, in widths of the band in which skirts stand, at which the photo is itself again.
const BEYOND: f32 = 1.5;

/// The differences, in steps of 8 bits of the channel that differs most, up to which a pixel shows the same as the other photos,
/// and from which on it shows something else. Noise and clouds stay below the first one.
const SAME: f32 = 8.0;
const OTHER: f32 = 24.0;

/// Two pictures of the surroundings in the reference camera's frame, R, G, B in sRGB and alpha, and where faces are.
pub struct Beyond<'a> {
    /// The frame's width in pixels.
    pub width: usize,
    /// Where the reference photo is in the frame.
    pub photo: PixelRect,
    /// With the reference photo.
    pub with_photo: &'a [[u8; 4]],
    /// Without it.
    pub without: &'a [[u8; 4]],
    /// Whether the nearest surface of a pixel is a face.
    pub is_face: &'a [bool],
}

impl Beyond<'_> {
    /// Returns the surroundings: the reference photo's, but those without it near outlines where the two differ.
    pub fn cleaned(&self) -> Vec<[u8; 4]> {
        let Self { width, photo, with_photo, without, is_face } = *self;
        let band = (BAND * f64::from(photo.w.max(photo.h))).max(1.0) as f32;
        let nearest = nearest(is_face, width);
        let srgb = Srgb::tables();
        let pixel = |i: usize| {
            let (own, other) = (with_photo[i], without[i]);
            let is_own = photo.contains((i % width) as i32, (i / width) as i32);
            if !is_own || is_face[i] || other[3] == 0 {
                return own;
            }
            let apart = (0..3).map(|c| own[c].abs_diff(other[c])).max().map_or(0.0, f32::from);
            let near = ((BEYOND - nearest[i].distance_px() / band) / (BEYOND - 1.0)).clamp(0.0, 1.0);
            let share = near * smooth((apart - SAME) / (OTHER - SAME));
            let light = |c: usize| srgb.linear(own[c]) * (1.0 - share) + srgb.linear(other[c]) * share;
            let [r, g, b] = [0, 1, 2].map(|c| srgb.encoded(light(c)));
            [r, g, b, own[3]]
        };
        (0..with_photo.len()).into_par_iter().map(pixel).collect()
    }
}

/// Returns 0 up to 0, 1 from 1 on, and between them a curve without corners.
fn smooth(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_on_an_outline_goes_and_the_rest_of_the_photo_stays() {
        // A wall up to column 100 with a stone beside it, and a bird far from it.
        let (width, height) = (1000usize, 4usize);
        let (sky, stone, bird) = ([90, 130, 180, 255], [140, 120, 100, 255], [20, 20, 20, 255]);
        let of = |i: usize| match i % width {
            101..=105 => stone,
            500..=503 => bird,
            _ => sky,
        };
        let with_photo: Vec<[u8; 4]> = (0..width * height).map(of).collect();
        // The other photos have the same sky, a little brighter.
        let without = vec![[95, 135, 185, 255]; width * height];
        let is_face: Vec<bool> = (0..width * height).map(|i| i % width <= 100).collect();
        let photo = PixelRect::of_size(width as u32, height as u32);
        let beyond = Beyond { width, photo, with_photo: &with_photo, without: &without, is_face: &is_face };
        let cleaned = beyond.cleaned();
        for (i, pixel) in cleaned.iter().enumerate() {
            let expected = if with_photo[i] == stone { without[i] } else { with_photo[i] };
            assert_eq!(*pixel, expected, "column {}", i % width);
        }
        // A photo that is a part of the frame changes nothing outside of itself.
        let photo = PixelRect { x: 0, y: 0, w: 50, h: 4 };
        assert!(Beyond { photo, ..beyond }.cleaned() == with_photo);
    }
}
