//! Thin things before the sky: vanes, antennas, wires and poles rise from roofs higher than the surroundings of outlines reach, and
//! are too thin for their colours to count. They are near, so that other views would show them in the wrong place, twice and pale.
//! What tells them is that they differ from the sky on both sides of them, and that nobody else shows such a thing in the same
//! direction.

use glam::DVec3;
use rayon::prelude::*;

use super::connected::{around, connected};
use super::directions::DirectionPhoto;

/// The distance at which the sky beside a pixel is looked at, in reduced pixels: things are thinner.
const BESIDE_PX: i32 = 8;

/// The least difference from the sky beside it, as a natural logarithm: in a reduced photo a vane is mixed with the sky, so that it
/// differs by little more than noise does; and the share of it that confirms a thing elsewhere.
const DIFFERS: f32 = 0.12;
const CONFIRMS: f32 = 0.5;

/// How far around a direction another photo is looked at, in reduced pixels.
const AROUND_PX: usize = 2;

/// The least number of pixels beside one that show surroundings, of eight.
const LEAST_BESIDE: usize = 6;

/// The distance from outlines within which things rise, as a share of the longer side, and the largest share of the photo that one
/// may have.
const NEAR: f32 = 0.1;
const LARGEST: f32 = 0.003;

/// The share of a thing's pixels that others have to confirm for it to be far away.
const CONFIRMED: f32 = 0.5;

/// The least light that enters a logarithm.
const BLACK: f32 = 0.004;

/// Returns the thin things in a photo's surroundings, as the indices of their pixels. They are near unless others confirm them.
pub(super) fn thin_things(photo: &DirectionPhoto) -> Vec<Vec<usize>> {
    let size = [photo.camera.width as usize, photo.camera.height as usize];
    let differs: Vec<bool> =
        (0..photo.pixels()).into_par_iter().map(|at| difference(photo, at) > DIFFERS).collect();
    let near = (NEAR * size[0].max(size[1]) as f32) as u16;
    let mut things = connected(&differs, size, AROUND_PX);
    things.retain(|thing| {
        let is_small = thing.len() as f32 <= LARGEST * differs.len() as f32;
        is_small && thing.iter().any(|at| photo.inside_px(*at) <= near)
    });
    things
}

/// Returns whether so many confirmed pixels of a thing are too few for it to be far away.
pub(super) fn is_near(confirmed: usize, pixels: usize) -> bool {
    (confirmed as f32) < CONFIRMED * pixels as f32
}

/// Returns by how much a pixel differs from the sky beside it, as a natural logarithm; 0 where too little of that is shown.
fn difference(photo: &DirectionPhoto, at: usize) -> f32 {
    let [width, height] = [photo.camera.width as i32, photo.camera.height as i32];
    let Some(own) = photo.exposed(at).map(brightness) else { return 0.0 };
    let (x, y) = (at as i32 % width, at as i32 / width);
    let ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
    let beside = ring.iter().filter_map(|(dx, dy)| {
        let (x, y) = (x + dx * BESIDE_PX, y + dy * BESIDE_PX);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        is_inside.then(|| photo.exposed((y * width + x) as usize)).flatten().map(brightness)
    });
    let mut beside: Vec<f32> = beside.collect();
    if beside.len() < LEAST_BESIDE {
        return 0.0;
    }
    beside.sort_by(f32::total_cmp);
    (own - beside[beside.len() / 2]).abs()
}

fn brightness(light: [f32; 3]) -> f32 {
    (light.iter().sum::<f32>() / 3.0).max(BLACK).ln()
}

/// Returns whether a photo shows something that differs from the sky in a direction (world).
pub(super) fn shows_something(other: &DirectionPhoto, direction: DVec3) -> bool {
    let Some(px) = other.position(direction) else { return false };
    let size = [other.camera.width as usize, other.camera.height as usize];
    around(size, other.index(px), AROUND_PX).any(|at| difference(other, at) > CONFIRMS * DIFFERS)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::agreement::far_colours::STANDING;
    use crate::agreement::suspects::Suspects;
    use quadratura_base::geometry::{Pinhole, Pose};

    const CAMERA: Pinhole = Pinhole { width: 200, height: 120, fx: 150.0, fy: 150.0, cx: 100.0, cy: 60.0 };

    /// A photo of a sky from a place, with a pole in a column above a roof.
    fn photo(x: f64, pole: usize) -> DirectionPhoto {
        let pose = Pose { rotation: DMat3::IDENTITY, translation: -DVec3::X * x };
        let light = (0..200 * 120).map(|at| {
            let (x, y) = (at % 200, at / 200);
            let is_pole = x == pole && (60..80).contains(&y);
            (y < 90).then_some(if is_pole { [0.4; 3] } else { [0.5; 3] })
        });
        DirectionPhoto::new(CAMERA, pose, light.collect())
    }

    fn lowered(pole: usize, other: &DirectionPhoto) -> Vec<f32> {
        let tested = photo(0.0, pole);
        let mut values = vec![1.0; tested.pixels()];
        let mut suspects = Suspects::find(&tested, None);
        suspects.ask(other, 1.0);
        suspects.lower(&tested, &mut values);
        values
    }

    #[test]
    fn a_pole_that_another_photo_shows_elsewhere_is_near_and_one_at_the_same_place_far_away() {
        let near = lowered(100, &photo(1.0, 120));
        assert_eq!(near[70 * 200 + 100], STANDING);
        assert_eq!((near[70 * 200 + 50], near[20 * 200 + 100]), (1.0, 1.0));
        assert!(lowered(100, &photo(1.0, 100)).iter().all(|value| *value == 1.0), "a far one");
        let beside = lowered(100, &photo(0.1, 120));
        assert!(beside.iter().all(|value| *value == 1.0), "photos from nearby alone tell nothing");
    }
}
