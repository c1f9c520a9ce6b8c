//! Resampling of a distorted photo to its pinhole image, done once at import.
//!
//! The filter is Lanczos with three lobes, which preserves detail best; everything later is cut from these pixels.
//! It works on stored values, not on linear light: scales stay near one, so hardly anything is averaged, and the
//! kernel's overshoot is equally visible beside dark and bright edges. Where the pinhole image is smaller than the
//! photo (pincushion lenses, near the border), it is only slightly smaller, so the kernel is not widened.

use std::f64::consts::PI;

use glam::DVec2;
use rayon::prelude::*;

use super::{PhotoPixels, Samples};
use crate::error::Result;
use crate::geometry::Undistortion;
use crate::raster::Sample;
use crate::task::Task;

/// Computes the pinhole image of `photo` as RGBA, in the photo's depth and colour space. Alpha is full where the
/// photo has valid pixels; elsewhere the whole pixel is zero. A position on a pixel's centre gets exactly that
/// pixel's value.
///
/// # Errors
/// Returns [`crate::Error::Cancelled`] on request.
pub fn undistorted(photo: &PhotoPixels, undistortion: &Undistortion, task: &Task) -> Result<PhotoPixels> {
    debug_assert_eq!((photo.width, photo.height), (undistortion.photo.width, undistortion.photo.height));
    let samples = match &photo.samples {
        Samples::U8(samples) => Samples::U8(resample(samples, photo, undistortion, task)?),
        Samples::U16(samples) => Samples::U16(resample(samples, photo, undistortion, task)?),
    };
    let (width, height) = (undistortion.pinhole.width, undistortion.pinhole.height);
    Ok(PhotoPixels { width, height, channels: 4, samples, icc: photo.icc.clone() })
}

/// Chooses the number of channels at compile time.
fn resample<T: Sample>(
    samples: &[T],
    photo: &PhotoPixels,
    undistortion: &Undistortion,
    task: &Task,
) -> Result<Vec<T>> {
    let (width, height) = (photo.width as usize, photo.height as usize);
    if photo.has_alpha() {
        resample_from(&SampledPhoto::<T, 4> { samples, width, height }, undistortion, task)
    } else {
        resample_from(&SampledPhoto::<T, 3> { samples, width, height }, undistortion, task)
    }
}

/// Resamples row by row, in parallel.
fn resample_from<T: Sample, const CHANNELS: usize>(
    source: &SampledPhoto<'_, T, CHANNELS>,
    undistortion: &Undistortion,
    task: &Task,
) -> Result<Vec<T>> {
    let (width, height) = (undistortion.pinhole.width as usize, undistortion.pinhole.height as usize);
    let kernel = Kernel::lanczos3();
    let mut pixels = vec![T::default(); width * height * 4];
    pixels.par_chunks_exact_mut(width * 4).enumerate().try_for_each(|(y, row)| {
        task.check_cancelled()?;
        for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let Some(at) = undistortion.photo_from_pinhole(center) else { continue };
            if let Some([r, g, b]) = source.at(at, &kernel) {
                *pixel = [T::nearest(r), T::nearest(g), T::nearest(b), T::FULL];
            }
        }
        Ok(())
    })?;
    Ok(pixels)
}

/// A photo's samples with the photo's size.
struct SampledPhoto<'a, T, const CHANNELS: usize> {
    samples: &'a [T],
    width: usize,
    height: usize,
}

impl<T: Sample, const CHANNELS: usize> SampledPhoto<'_, T, CHANNELS> {
    /// Returns the colour at a position in pixels within the photo; `None` where one of the four nearest pixels is
    /// invalid.
    #[inline]
    fn at(&self, position: DVec2, kernel: &Kernel) -> Option<[f32; 3]> {
        let (left, across) = kernel.taps(position.x);
        let (top, down) = kernel.taps(position.y);
        let columns = [0, 1, 2, 3, 4, 5].map(|i| inside(left + i, self.width) * CHANNELS);
        let rows = [0, 1, 2, 3, 4, 5].map(|i| inside(top + i, self.height) * self.width * CHANNELS);
        if CHANNELS == 3 {
            return Some(self.opaque(columns, across, rows, down));
        }
        let nearest = [(2, 2), (3, 2), (2, 3), (3, 3)];
        let valid = nearest.iter().all(|&(x, y)| self.is_valid(rows[y] + columns[x]));
        valid.then(|| self.masked(columns, across, rows, down))
    }

    /// Interpolates an image without alpha, where the weights add up to one.
    #[inline]
    fn opaque(&self, columns: [usize; 6], across: &[f32; 6], rows: [usize; 6], down: &[f32; 6]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (row, weight_down) in rows.into_iter().zip(down) {
            let mut line = [0.0; 3];
            for (column, weight_across) in columns.into_iter().zip(across) {
                let pixel = &self.samples[row + column..row + column + 3];
                for (line, sample) in line.iter_mut().zip(pixel) {
                    *line += weight_across * sample.value();
                }
            }
            for (sum, line) in sum.iter_mut().zip(line) {
                *sum += weight_down * line;
            }
        }
        sum
    }

    /// Interpolates an image with alpha: invalid pixels have no weight, and the others' weights are normalised.
    fn masked(&self, columns: [usize; 6], across: &[f32; 6], rows: [usize; 6], down: &[f32; 6]) -> [f32; 3] {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (row, weight_down) in rows.into_iter().zip(down) {
            for (column, weight_across) in columns.into_iter().zip(across) {
                if self.is_valid(row + column) {
                    let weight = weight_across * weight_down;
                    total += weight;
                    for (channel, sum) in sum.iter_mut().enumerate() {
                        *sum += weight * self.samples[row + column + channel].value();
                    }
                }
            }
        }
        sum.map(|sum| sum / total)
    }

    fn is_valid(&self, pixel: usize) -> bool {
        self.samples[pixel + 3] == T::FULL
    }
}

/// Clamps an index, so that the photo's border is repeated outside of it.
#[inline]
fn inside(index: i32, size: usize) -> usize {
    index.clamp(0, size as i32 - 1) as usize
}

/// A table of the weights of six neighbours, for positions between two pixel centres in steps of 1/1024. The error
/// is at most 1/8 of a level beside an edge from black to white.
struct Kernel {
    weights: Vec<[f32; 6]>,
}

impl Kernel {
    const PHASES: usize = 1024;

    fn lanczos3() -> Self {
        let weights = (0..=Self::PHASES).map(|phase| weights(phase as f64 / Self::PHASES as f64));
        Self { weights: weights.collect() }
    }

    /// Returns the index of the first of the six neighbours of a position in pixels, and their weights.
    #[inline]
    fn taps(&self, position: f64) -> (i32, &[f32; 6]) {
        let from_center = position - 0.5;
        let floor = from_center.floor();
        let phase = ((from_center - floor) * Self::PHASES as f64 + 0.5) as usize;
        (floor as i32 - 2, &self.weights[phase])
    }
}

/// Returns the weights of the neighbours at -2..=3 for a position `fraction` after neighbour 0.
///
/// Lanczos weights neither add up to one nor have their centre of mass at the position: they would shift the image
/// by up to a hundredth of a pixel, back and forth. A window times `a + b * distance` is added so that both hold,
/// which keeps constant colours and ramps exact.
fn weights(fraction: f64) -> [f32; 6] {
    let distances = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|tap| tap - fraction);
    let raw = distances.map(lanczos3);
    let window = distances.map(|distance| 1.0 + (PI * distance / 3.0).cos());
    let moment = |weights: &[f64; 6], power: i32| -> f64 {
        weights.iter().zip(distances).map(|(weight, distance)| weight * distance.powi(power)).sum()
    };
    let wanting = [1.0 - moment(&raw, 0), -moment(&raw, 1)];
    let [m0, m1, m2] = [0, 1, 2].map(|power| moment(&window, power));
    let determinant = m0 * m2 - m1 * m1;
    let a = (m2 * wanting[0] - m1 * wanting[1]) / determinant;
    let b = (m0 * wanting[1] - m1 * wanting[0]) / determinant;
    std::array::from_fn(|i| (raw[i] + window[i] * (a + b * distances[i])) as f32)
}

/// Evaluates the Lanczos kernel with three lobes; distances are below 3.
pub fn lanczos3(distance: f64) -> f64 {
    // Exactly zero at whole distances, so that a position on a pixel's centre gives that pixel.
    if distance.fract() == 0.0 {
        return if distance == 0.0 { 1.0 } else { 0.0 };
    }
    let (x, third) = (PI * distance, PI * distance / 3.0);
    x.sin() / x * third.sin() / third
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::geometry::lens::EVERY_KIND;
    use crate::geometry::{Lens, Pinhole, RangedLens};

    const PHOTO: Pinhole = Pinhole { width: 200, height: 160, fx: 170.0, fy: 172.0, cx: 104.0, cy: 77.0 };

    /// A smooth pattern over ray directions: waves of at least 18 pixels at the centre.
    fn pattern(ray: DVec2) -> [f64; 3] {
        let wave = |phase: f64| 0.5 + 0.4 * phase.sin();
        [wave(60.0 * ray.x), wave(50.0 * ray.y), wave(30.0 * (ray.x + ray.y))]
    }

    fn ray(camera: &Pinhole, x: u32, y: u32) -> DVec2 {
        camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).truncate()
    }

    /// The pattern photographed through a lens, by the lens's inverse.
    fn photographed(lens: &Lens) -> PhotoPixels {
        let range = RangedLens::new(*lens);
        let (width, height) = (PHOTO.width, PHOTO.height);
        let colors = (0..width * height).flat_map(|i| {
            let ray = range.undistort(ray(&PHOTO, i % width, i / width));
            ray.map_or([0.5; 3], pattern).map(|color| (color * 65535.0).round() as u16)
        });
        let samples = Samples::U16(colors.collect());
        PhotoPixels { width, height, channels: 3, samples, icc: Some(vec![1, 2]) }
    }

    /// The difference from the pattern seen through the pinhole, at each pixel that has all its neighbours: the
    /// position in blocks of 40 pixels, the ray, and the errors of red and green.
    fn errors(lens: &Lens) -> Vec<([u32; 2], DVec2, [f64; 2])> {
        let undistortion = Undistortion::new(&PHOTO, *lens).unwrap();
        let image = undistorted(&photographed(lens), &undistortion, &Task::silent()).unwrap();
        let mut errors = Vec::new();
        for (x, y) in (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y))) {
            let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(at) = undistortion.photo_from_pinhole(center) else { continue };
            if at.x.min(at.y) > 3.0 && at.x < 197.0 && at.y < 157.0 {
                let ray = ray(&undistortion.pinhole, x, y);
                let (seen, expected) = (image.rgba16(x, y), pattern(ray));
                let off = |channel: usize| f64::from(seen[channel]) / 65535.0 - expected[channel];
                errors.push(([x / 40, y / 40], ray, [off(0), off(1)]));
            }
        }
        errors
    }

    #[test]
    fn a_pattern_photographed_through_any_lens_becomes_the_pattern_seen_through_the_pinhole() {
        for lens in EVERY_KIND {
            let errors = errors(&lens);
            let off: Vec<f64> = errors.iter().flat_map(|(_, _, off)| *off).collect();
            let rms = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
            let worst = off.iter().fold(0.0f64, |worst, off| worst.max(off.abs()));
            // The kernel itself passes such waves with an amplitude that is half a percent off.
            assert!(
                off.len() > 50_000 && rms < 0.4 * 0.005 && worst < 0.4 * 0.012,
                "{lens:?}: {rms} {worst}"
            );
        }
    }

    #[test]
    fn positions_are_exact_to_a_hundredth_of_a_pixel_everywhere() {
        for lens in EVERY_KIND {
            // Least squares: which shift in x and y explains the errors of a block?
            let mut blocks: BTreeMap<[u32; 2], [[f64; 2]; 2]> = BTreeMap::new();
            for (block, ray, off) in errors(&lens) {
                let slope = [24.0 / PHOTO.fx * (60.0 * ray.x).cos(), 20.0 / PHOTO.fy * (50.0 * ray.y).cos()];
                let sums = blocks.entry(block).or_default();
                for axis in 0..2 {
                    sums[axis][0] += slope[axis] * off[axis];
                    sums[axis][1] += slope[axis] * slope[axis];
                }
            }
            // Blocks at the border with only a few pixels are not significant.
            for (block, sums) in blocks.iter().filter(|(_, sums)| sums[0][1].min(sums[1][1]) > 1.0) {
                let shift = sums.map(|[product, square]| product / square);
                assert!(shift[0].hypot(shift[1]) < 0.01, "{lens:?}, block {block:?}: {shift:?} pixels");
            }
        }
    }

    #[test]
    fn steady_colours_and_ramps_pass_exactly() {
        for weights in &Kernel::lanczos3().weights {
            let sum: f32 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-6);
        }
        for phase in [0.0, 0.25, 0.4, 0.9, 1.0] {
            let center: f32 = weights(phase).iter().zip(-2..=3).map(|(w, tap)| w * tap as f32).sum();
            assert!((f64::from(center) - phase).abs() < 1e-6, "{center} is not {phase}");
        }
        assert_eq!(weights(0.0), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_lens_that_does_nothing_gives_the_photo_bit_for_bit() {
        let photo = photographed(&Lens::None);
        let undistortion = Undistortion::new(&PHOTO, Lens::None).unwrap();
        let image = undistorted(&photo, &undistortion, &Task::silent()).unwrap();
        assert_eq!(image.icc, photo.icc);
        for (x, y) in [(0, 0), (199, 159), (100, 3), (7, 150)] {
            assert_eq!(image.rgba16(x, y), photo.rgba16(x, y));
        }
    }

    #[test]
    fn outside_the_photo_alpha_is_zero_and_inside_it_is_full() {
        let barrel = Lens::Brown { k: [-0.15, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let undistortion = Undistortion::new(&PHOTO, barrel).unwrap();
        let image = undistorted(&photographed(&barrel), &undistortion, &Task::silent()).unwrap();
        for y in 0..image.height {
            for x in 0..image.width {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let inside = undistortion.photo_from_pinhole(at).is_some();
                assert_eq!(image.is_valid(x, y), inside, "{x} {y}");
                assert!(inside || image.rgba16(x, y) == [0; 4]);
            }
        }
    }

    #[test]
    fn what_is_not_valid_in_the_photo_neither_shows_nor_bleeds() {
        let lens = Lens::Division { k: -0.1 };
        let (width, height) = (PHOTO.width, PHOTO.height);
        // The left half is white and invalid, the right half grey.
        let pixel = |x: u32| if x < width / 2 { [255, 255, 255, 0] } else { [100, 100, 100, 255] };
        let samples = (0..height).flat_map(|_| (0..width).flat_map(pixel)).collect();
        let photo = PhotoPixels { width, height, channels: 4, samples: Samples::U8(samples), icc: None };
        let undistortion = Undistortion::new(&PHOTO, lens).unwrap();
        let image = undistorted(&photo, &undistortion, &Task::silent()).unwrap();
        let Samples::U8(samples) = &image.samples else { panic!() };
        let kinds: std::collections::BTreeSet<_> = samples.chunks_exact(4).collect();
        assert_eq!(kinds.into_iter().collect::<Vec<_>>(), [&[0, 0, 0, 0][..], &[100, 100, 100, 255]]);
    }

    #[test]
    fn a_request_to_stop_is_heard() {
        let undistortion = Undistortion::new(&PHOTO, Lens::Division { k: -0.1 }).unwrap();
        let task = Task::silent();
        task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(undistorted(&photographed(&Lens::None), &undistortion, &task).is_err());
    }
}
