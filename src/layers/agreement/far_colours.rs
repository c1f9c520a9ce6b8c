//! What stands on the outlines of the model, such as the cross on a roof or the rim of the roof itself, is no
//! surroundings, although no face covers it: it is near, and other views would show it in the wrong place. Its colours
//! tell: they are none of those that the photos show far from all outlines, or none of those that the same photo shows around it
//! farther out.

use rayon::prelude::*;

use super::connected::connected;
use super::directions::{DirectionPhoto, DirectionPhotos};
use quadratura_base::error::Result;

/// The distance from outlines from which on surroundings are far from them, as a share of the longer side.
const FAR: f64 = 0.04;

/// The least number of pixels far from outlines, in all photos, that tell the colours of surroundings.
const LEAST_FAR: usize = 1000;

/// The cells of the histogram: brightness, red against blue, green against both.
const CELLS: [usize; 3] = [64, 96, 32];

/// The first value along each axis of the histogram, as a natural logarithm.
const FIRST: [f32; 3] = [-6.0, -3.0, -1.0];

/// The size of a cell along each axis, as a natural logarithm: brightness varies more than hue.
const CELL: [f32; 3] = [0.16, 0.08, 0.08];

/// The least light that enters a logarithm.
const BLACK: f32 = 0.004;

/// The share of the far pixels in a cell below which its colours are none of surroundings.
const LEAST_SHARE: f32 = 1e-5;

/// The distance from an outline, in reduced pixels, within which a thing stands on it.
const TOUCHES_PX: u16 = 2;

/// The distance by which what stands on outlines is extended, in reduced pixels: its edge is mixed with what is behind.
pub(super) const EDGE_PX: usize = 2;

/// The agreement of what stands on outlines: that of things that are contradicted as a whole.
pub(super) const STANDING: f32 = 0.01;

/// The width of the band along outlines, as a share of the longer side, in which surroundings are compared with those of the same
/// photo beyond it: models are wrong by less.
const BAND: f64 = 0.015;

/// How far around a pixel of the band it is compared with what is beyond, in widths of the band.
const AROUND: f64 = 2.0;

/// Every so many rows and columns are compared: a colour is compared with all colours at most two pixels away.
const STEP: i32 = 4;

/// The distance from all colours beyond the band, as a natural logarithm, from which on a pixel shows something else: photos agree
/// fully up to a quarter, and not at all from a half on.
const STRAYS: f32 = 0.35;

/// The mean agreement of what touches no outline below which others see the sky there, and the largest share of the photo that it may
/// have.
const CONTRADICTED: f32 = 0.75;
const LARGEST_FLOATING: f32 = 0.01;

/// The share of the pixels of a thing that others have to confirm for it to be far away.
const CONFIRMED: f32 = 0.5;

/// A histogram of the colours that photos show far from all outlines.
pub struct FarColours {
    /// The share of the pixels by cell, blurred.
    shares: Vec<f32>,
}

impl FarColours {
    /// Counts the colours of photos in the common exposure; `None` where too few pixels are far from outlines. Each photo
    /// counts the same.
    ///
    /// # Errors
    /// Those of reading photos back.
    pub fn new(photos: &dyn DirectionPhotos) -> Result<Option<Self>> {
        let numbers = (0..photos.count()).into_par_iter();
        let counts = numbers.map(|number| Ok(far_pixels(&*photos.photo(number)?).count()));
        let counts: Vec<usize> = counts.collect::<Result<_>>()?;
        if counts.iter().sum::<usize>() < LEAST_FAR {
            return Ok(None);
        }
        let with_any = counts.iter().filter(|count| **count > 0).count();
        let mut shares = vec![0.0; CELLS.iter().product()];
        for (number, count) in counts.into_iter().enumerate().filter(|(_, count)| *count > 0) {
            let photo = photos.photo(number)?;
            let share = 1.0 / (count as f32 * with_any as f32);
            let far: Vec<usize> = far_pixels(&photo).collect();
            let cells = far.into_par_iter().filter_map(|at| photo.exposed(at).map(cell));
            cells.collect::<Vec<usize>>().into_iter().for_each(|cell| shares[cell] += share);
        }
        let strides = [CELLS[1] * CELLS[2], CELLS[2], 1];
        for (stride, count) in strides.into_iter().zip(CELLS) {
            shares = blurred(&blurred(&shares, stride, count), stride, count);
        }
        Ok(Some(Self { shares }))
    }

    /// Returns whether a colour is one of those that photos show far from outlines.
    fn contains(&self, light: [f32; 3]) -> bool {
        self.shares[cell(light)] >= LEAST_SHARE
    }

    /// Returns what may stand on the outlines in a photo, as the indices of the pixels of things: things of unknown colours, and rims
    /// of other colours than the photo shows beyond them. Both are apart from each other, so that no rim joins a cross with a far
    /// tower behind the same roof.
    pub(super) fn standing_things(&self, photo: &DirectionPhoto) -> [Vec<Vec<usize>>; 2] {
        let size = [photo.camera.width as usize, photo.camera.height as usize];
        let is_unknown = |at: usize| photo.exposed(at).is_some_and(|light| !self.contains(light));
        let is_stray = |at: usize| photo.exposed(at).is_some() && strays(photo, at);
        let unknown: Vec<bool> = (0..photo.pixels()).into_par_iter().map(is_unknown).collect();
        let stray: Vec<bool> = (0..photo.pixels()).into_par_iter().map(is_stray).collect();
        [unknown, stray].map(|other| {
            let mut things = connected(&other, size, 1);
            things.retain(|thing| stands(photo, thing) || is_small(photo, thing));
            things
        })
    }
}

/// Returns the indices of the pixels of a photo that show surroundings far from all outlines.
fn far_pixels(photo: &DirectionPhoto) -> impl Iterator<Item = usize> {
    let far = (FAR * f64::from(photo.camera.width.max(photo.camera.height))) as u16;
    (0..photo.pixels()).filter(move |at| photo.inside_px(*at) > far)
}

/// Returns whether a thing with this agreement (of all pixels, row by row) stands on an outline, or seems to float above one.
pub(super) fn is_suspected(photo: &DirectionPhoto, thing: &[usize], values: &[f32]) -> bool {
    // A vane's pole is too thin to be seen: what stands on it seems to float.
    let mean = thing.iter().map(|at| values[*at]).sum::<f32>() / thing.len() as f32;
    stands(photo, thing) || (mean < CONTRADICTED && is_small(photo, thing))
}

fn stands(photo: &DirectionPhoto, thing: &[usize]) -> bool {
    thing.iter().any(|at| photo.inside_px(*at) <= TOUCHES_PX)
}

fn is_small(photo: &DirectionPhoto, thing: &[usize]) -> bool {
    thing.len() as f32 <= LARGEST_FLOATING * photo.pixels() as f32
}

/// Returns whether so many confirmed pixels of a thing are too few for it to be far away.
pub(super) fn is_near(confirmed: usize, pixels: usize) -> bool {
    confirmed as f32 <= CONFIRMED * pixels as f32
}

/// Returns whether a pixel beside an outline shows none of the colours that the photo shows around it beyond the band along
/// outlines: the rim of a cornice before clouds of its own colour that are elsewhere in the sky. Nothing strays where nothing is
/// beyond.
fn strays(photo: &DirectionPhoto, at: usize) -> bool {
    let [width, height] = [photo.camera.width as i32, photo.camera.height as i32];
    let band = BAND * f64::from(width.max(height));
    if f64::from(photo.inside_px(at)) > band {
        return false;
    }
    let (x, y) = (at as i32 % width, at as i32 / width);
    let reach = (AROUND * band) as i32;
    let along = |at: i32, side: i32| {
        (-reach..=reach)
            .step_by(STEP as usize)
            .map(move |by| at + by)
            .filter(move |at| (0..side).contains(at))
    };
    let beyond = along(y, height).flat_map(|y| along(x, width).map(move |x| (y * width + x) as usize));
    let mut beyond = beyond.filter(|at| f64::from(photo.inside_px(*at)) > band).peekable();
    beyond.peek().is_some() && beyond.all(|other| photo.distance(at, other) > STRAYS)
}

/// Returns the cell of the histogram with a colour (linear light); the outermost ones hold what lies beyond.
fn cell(light: [f32; 3]) -> usize {
    let [r, g, b] = light.map(|light| light.max(BLACK).ln());
    let axes = [(r + g + b) / 3.0, r - b, g - (r + b) / 2.0];
    (0..3).fold(0, |index, axis| {
        let step = ((axes[axis] - FIRST[axis]) / CELL[axis]).max(0.0) as usize;
        index * CELLS[axis] + step.min(CELLS[axis] - 1)
    })
}

/// Blurs values along an axis by a binomial filter of three taps. `stride` is the distance of neighbours, `count` their
/// number.
fn blurred(values: &[f32], stride: usize, count: usize) -> Vec<f32> {
    let value = |index: usize| {
        let along = index / stride % count;
        let before = if along > 0 { values[index - stride] } else { 0.0 };
        let after = if along + 1 < count { values[index + stride] } else { 0.0 };
        0.25 * before + 0.5 * values[index] + 0.25 * after
    };
    (0..values.len()).into_par_iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::suspects::Suspects;
    use glam::{DMat3, DVec3};
    use quadratura_base::geometry::{Pinhole, Pose};
    use std::sync::Arc;

    const CAMERA: Pinhole = Pinhole { width: 200, height: 120, fx: 150.0, fy: 150.0, cx: 100.0, cy: 60.0 };
    const SKY: [f32; 3] = [0.3, 0.4, 0.6];
    const WHITE: [f32; 3] = [0.8, 0.8, 0.8];
    const STONE: [f32; 3] = [0.5, 0.35, 0.2];

    /// A photo of a sky with a white cloud, from a place; below row 80 is the model, on which stands a pole of stone in these
    /// columns, and a thing of stone floats in the sky.
    fn photo(x: f64, pole: std::ops::Range<usize>) -> DirectionPhoto {
        let pose = Pose { rotation: DMat3::IDENTITY, translation: -DVec3::X * x };
        let light = (0..200 * 120).map(|at| {
            let (x, y) = (at % 200, at / 200);
            match (x, y) {
                (_, 80..) => None,
                (_, 50..) if pole.contains(&x) => Some(STONE),
                (150..160, 10..20) => Some(STONE),
                (20..90, 5..25) => Some(WHITE),
                _ => Some(SKY),
            }
        });
        DirectionPhoto::new(CAMERA, pose, light.collect())
    }

    /// The agreement of pixels at columns and rows of the first photo.
    fn lowered(photos: &[DirectionPhoto], scale: f64) -> impl Fn(usize, usize) -> f32 + use<> {
        let all: Vec<Arc<DirectionPhoto>> = photos.iter().cloned().map(Arc::new).collect();
        let mut values = vec![1.0; photos[0].pixels()];
        let far = FarColours::new(&all).unwrap().expect("most of the sky is far from the outline");
        let mut suspects = Suspects::standing(&photos[0], &far);
        photos[1..].iter().for_each(|other| suspects.ask(other, scale));
        suspects.lower(&photos[0], &mut values);
        move |x, y| values[200 * y + x]
    }

    #[test]
    fn what_stands_on_an_outline_loses_its_say_and_clouds_and_the_sky_keep_theirs() {
        // Few pixels of stone are far from outlines; those of the floating thing make stone a far colour, if there are enough.
        let without_thing = |x: f64, pole: std::ops::Range<usize>| {
            let made = photo(x, pole);
            let mut light: Vec<Option<[f32; 3]>> = (0..made.pixels()).map(|at| made.exposed(at)).collect();
            for at in (10..20).flat_map(|y| (150..160).map(move |x| 200 * y + x)) {
                light[at] = Some(SKY);
            }
            let pose = Pose { rotation: DMat3::IDENTITY, translation: -DVec3::X * x };
            DirectionPhoto::new(CAMERA, pose, light)
        };
        // The pole's foot is within reach of the outline, its tip is not: only what is near counts as unknown colours.
        let low = |x: f64, pole: std::ops::Range<usize>| {
            let mut made = without_thing(x, pole.clone());
            let light = (0..200 * 120).map(|at| match (at % 200, at / 200) {
                (x, 50..74) if pole.contains(&x) => Some(SKY),
                _ => made.exposed(at),
            });
            made = DirectionPhoto::new(CAMERA, made.pose, light.collect());
            made
        };
        let value = lowered(&[low(0.0, 60..66), low(1.0, 120..126), low(2.0, 180..186)], 1.0);
        assert_eq!(value(62, 76), STANDING);
        assert_eq!(
            (value(62, 72), value(67, 76)),
            (STANDING, STANDING),
            "its edge is mixed with what is behind"
        );
        assert_eq!((value(62, 69), value(75, 76), value(50, 10), value(122, 76)), (1.0, 1.0, 1.0, 1.0));
        // The same in the same direction from elsewhere is far away; from nearby that tells nothing.
        let value = lowered(&[low(0.0, 60..66), low(1.0, 60..66)], 1.0);
        assert_eq!(value(62, 76), 1.0);
        let value = lowered(&[low(0.0, 60..66), low(0.1, 60..66)], 1.0);
        assert_eq!(value(62, 76), STANDING);
    }

    #[test]
    fn a_rim_of_a_colour_that_is_elsewhere_in_the_sky_stands_on_the_outline_and_a_cloud_behind_it_does_not() {
        // A cornice of the cloud's own colour, two pixels high, and a cloud that goes on behind the model.
        let with_rim = |x: f64, rim: std::ops::Range<usize>| {
            let mut made = photo(x, 0..0);
            let light = (0..200 * 120).map(|at| match (at % 200, at / 200) {
                (column, 78..80) if rim.contains(&column) => Some(WHITE),
                (20..50, 40..80) => Some(WHITE),
                _ => made.exposed(at),
            });
            made = DirectionPhoto::new(CAMERA, made.pose, light.collect());
            made
        };
        let value = lowered(&[with_rim(0.0, 100..130), with_rim(0.1, 103..133)], 1.0);
        assert_eq!([value(101, 78), value(115, 79), value(128, 79)], [STANDING; 3]);
        assert_eq!([value(115, 75), value(35, 79), value(35, 50), value(160, 79)], [1.0; 4]);
        // The same in the same direction from elsewhere is far away.
        let value = lowered(&[with_rim(0.0, 100..130), with_rim(1.0, 100..130)], 1.0);
        assert_eq!(value(115, 79), 1.0);
    }

    #[test]
    fn colours_far_from_outlines_are_surroundings_and_too_few_tell_nothing() {
        let value = lowered(&[photo(0.0, 60..66)], 1.0);
        assert_eq!(value(62, 76), 1.0, "stone is in the sky, too");
        let small = (0..200 * 120).map(|at| (at < 200 * 4).then_some(SKY)).collect();
        let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        let small = Arc::new(DirectionPhoto::new(CAMERA, pose, small));
        assert!(FarColours::new(&vec![small]).unwrap().is_none());
    }
}
