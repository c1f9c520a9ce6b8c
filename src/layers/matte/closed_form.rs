//! Closed-form matting: A. Levin, D. Lischinski, Y. Weiss, *A Closed-Form Solution to Natural Image Matting*, IEEE
//! Transactions on Pattern Analysis and Machine Intelligence 30, 2008.
//!
//! In every window of 3 x 3 pixels alpha is nearly an affine function of the colour. The sum over all windows of the
//! squared distance from the best such function is a quadratic form of alpha; its minimum with alpha given outside of the
//! band is found by conjugate gradients. The form is never written down as a matrix: for some alpha, the best function of
//! each window follows from 3 x 3 sums, and what it leaves over is the derivative.

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::raster::Image;
use crate::task::Task;

/// Options of the solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedForm {
    /// The variance of linear light below which a window counts as flat, of one channel.
    pub flat: f32,
    /// The residual at which the solution ends, as a share of the first.
    pub residual: f64,
    /// The largest number of steps.
    pub steps: usize,
}

impl Default for ClosedForm {
    fn default() -> Self {
        // The published 1e-7 for a sum over nine pixels; a residual of 1e-4 leaves alpha within a half step of 8 bits.
        Self { flat: 1e-7, residual: 1e-4, steps: 2000 }
    }
}

/// Solves alpha in a band. `colours` is in linear light, 0 to 1; `known` has alpha, 0 to 1, outside of the band and `None`
/// within, for the same rectangle. Returns alpha everywhere, 0 to 1; without a known pixel it is 1.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn closed_form(
    colours: &Image<Vec3>,
    known: &Image<Option<f32>>,
    options: &ClosedForm,
    task: &Task,
) -> Result<Image<f32>> {
    assert_eq!(colours.rect(), known.rect(), "both are of one rectangle");
    let mut alpha = known.map(|alpha| alpha.unwrap_or(1.0));
    if known.pixels().iter().all(Option::is_none) || known.pixels().iter().all(Option::is_some) {
        return Ok(alpha);
    }
    let system = System::new(colours, known, options.flat);
    let mut solution: Vec<f64> = system.start(known);
    let given = alpha.pixels().iter().zip(known.pixels());
    let given: Vec<f64> =
        given.map(|(alpha, known)| if known.is_some() { f64::from(*alpha) } else { 0.0 }).collect();
    // L alpha = 0 in the band: the known part goes to the right.
    let right: Vec<f64> = system.gathered(&system.applied(&given)).into_iter().map(|value| -value).collect();
    system.solve(&right, &mut solution, options, task)?;
    for (index, value) in system.unknown.iter().zip(&solution) {
        alpha.pixels_mut()[*index as usize] = value.clamp(0.0, 1.0) as f32;
    }
    Ok(alpha)
}

/// A window of 3 x 3 pixels that touches the band.
struct Window {
    /// The index of its middle.
    middle: u32,
    /// The mean colour.
    mean: Vec3,
    /// The inverse of the covariance of its colours.
    inverse: Mat3,
}

/// The quadratic form on the pixels of a picture, as far as it concerns the band.
struct System {
    colours: Vec<Vec3>,
    width: usize,
    windows: Vec<Window>,
    /// The pixels of the band.
    unknown: Vec<u32>,
    /// The diagonal of the form, in the order of `unknown`.
    diagonal: Vec<f64>,
}

impl System {
    fn new(colours: &Image<Vec3>, known: &Image<Option<f32>>, flat: f32) -> Self {
        let [width, height] = colours.size();
        let is_unknown = |index: usize| known.pixels()[index].is_none();
        let unknown: Vec<u32> =
            (0..width * height).filter(|index| is_unknown(*index)).map(|i| i as u32).collect();
        let inner = |index: &usize| {
            let (x, y) = (index % width, index / width);
            x > 0 && y > 0 && x + 1 < width && y + 1 < height
        };
        let touches = |index: &usize| around(*index, width).into_iter().any(is_unknown);
        let middles: Vec<usize> = (0..width * height).filter(inner).filter(touches).collect();
        let pixels = colours.pixels();
        let windows =
            middles.into_par_iter().map(|middle| Window::new(pixels, middle, width, flat)).collect();
        let mut system = Self { colours: pixels.to_vec(), width, windows, unknown, diagonal: Vec::new() };
        system.diagonal = system.diagonal();
        system
    }

    /// Returns a first guess in the band: the nearest known values along the rows and columns, by distance.
    fn start(&self, known: &Image<Option<f32>>) -> Vec<f64> {
        let [width, height] = known.size();
        let at = |x: usize, y: usize| known.pixels()[y * width + x];
        let guess = |index: &u32| {
            let (x, y) = (*index as usize % width, *index as usize / width);
            let found = [
                (0..x).rev().find_map(|i| Some((x - i, at(i, y)?))),
                (x + 1..width).find_map(|i| Some((i - x, at(i, y)?))),
                (0..y).rev().find_map(|j| Some((y - j, at(x, j)?))),
                (y + 1..height).find_map(|j| Some((j - y, at(x, j)?))),
            ];
            let weighted =
                found.into_iter().flatten().map(|(far, alpha)| (1.0 / far as f64, f64::from(alpha)));
            let (weights, sum) =
                weighted.fold((0.0, 0.0), |(w, s), (weight, alpha)| (w + weight, s + weight * alpha));
            if weights > 0.0 { sum / weights } else { 0.5 }
        };
        self.unknown.par_iter().map(guess).collect()
    }

    /// Applies the form to values at all pixels.
    fn applied(&self, values: &[f64]) -> Vec<f64> {
        // Bands of windows are summed apart, so that the sum does not depend on the number of threads.
        const BAND: usize = 4096;
        let of_band = |windows: &[Window]| -> Vec<(u32, f64)> {
            let mut left = Vec::with_capacity(9 * windows.len());
            for window in windows {
                let indices = around(window.middle as usize, self.width);
                let mean: f64 = indices.iter().map(|i| values[*i]).sum::<f64>() / 9.0;
                let with_colour = |i: &usize| (self.colours[*i] - window.mean) * (values[*i] - mean) as f32;
                let slope = window.inverse * (indices.iter().map(with_colour).sum::<Vec3>() / 9.0);
                left.extend(indices.iter().map(|&i| {
                    let best = mean + f64::from(slope.dot(self.colours[i] - window.mean));
                    (i as u32, values[i] - best)
                }));
            }
            left
        };
        let bands: Vec<Vec<(u32, f64)>> = self.windows.par_chunks(BAND).map(of_band).collect();
        let mut sum = vec![0.0; values.len()];
        bands.into_iter().flatten().for_each(|(index, left)| sum[index as usize] += left);
        sum
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut all = vec![0.0; self.colours.len()];
        for window in &self.windows {
            for index in around(window.middle as usize, self.width) {
                let off = self.colours[index] - window.mean;
                all[index] += 1.0 - f64::from(1.0 + off.dot(window.inverse * off)) / 9.0;
            }
        }
        self.gathered(&all).into_iter().map(|value| value.max(1e-9)).collect()
    }

    /// Returns the values in the band.
    fn gathered(&self, values: &[f64]) -> Vec<f64> {
        self.unknown.iter().map(|index| values[*index as usize]).collect()
    }

    /// Applies the form to values in the band, with 0 elsewhere.
    fn applied_in_band(&self, values: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.colours.len()];
        self.unknown.iter().zip(values).for_each(|(index, value)| all[*index as usize] = *value);
        self.gathered(&self.applied(&all))
    }

    /// Solves the form for a right side by conjugate gradients, preconditioned by the diagonal, from `solution` on.
    fn solve(&self, right: &[f64], solution: &mut [f64], options: &ClosedForm, task: &Task) -> Result<()> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |residual: &[f64]| -> Vec<f64> {
            residual.iter().zip(&self.diagonal).map(|(value, diagonal)| value / diagonal).collect()
        };
        let applied = self.applied_in_band(solution);
        let mut residual: Vec<f64> =
            right.iter().zip(&applied).map(|(right, applied)| right - applied).collect();
        let mut direction = scaled(&residual);
        let mut norm = dot(&residual, &direction);
        let enough = norm * options.residual * options.residual;
        for _ in 0..options.steps {
            if norm <= enough.max(f64::MIN_POSITIVE) {
                break;
            }
            task.go_on()?;
            let applied = self.applied_in_band(&direction);
            let along = dot(&direction, &applied);
            if along <= 0.0 {
                break;
            }
            let step = norm / along;
            solution.iter_mut().zip(&direction).for_each(|(value, direction)| *value += step * direction);
            residual.iter_mut().zip(&applied).for_each(|(value, applied)| *value -= step * applied);
            let next = scaled(&residual);
            let after = dot(&residual, &next);
            let share = after / norm;
            direction.iter_mut().zip(&next).for_each(|(value, next)| *value = next + share * *value);
            norm = after;
        }
        Ok(())
    }
}

impl Window {
    fn new(colours: &[Vec3], middle: usize, width: usize, flat: f32) -> Self {
        let indices = around(middle, width);
        let mean = indices.iter().map(|i| colours[*i]).sum::<Vec3>() / 9.0;
        let square = |i: &usize| {
            let off = colours[*i] - mean;
            Mat3::from_cols(off * off.x, off * off.y, off * off.z)
        };
        let covariance =
            indices.iter().map(square).fold(Mat3::ZERO, |sum, square| sum + square) * (1.0 / 9.0);
        let inverse = (covariance + Mat3::from_diagonal(Vec3::splat(flat / 9.0))).inverse();
        Self { middle: middle as u32, mean, inverse }
    }
}

/// Returns the nine pixels around an inner one, by index.
fn around(middle: usize, width: usize) -> [usize; 9] {
    std::array::from_fn(|k| middle + k / 3 * width + k % 3 - width - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::PixelRect;
    use crate::scene::synthetic::Rng;

    /// A soft edge between two surfaces whose colours vary along a line each: the model of the method holds.
    fn edge(width: u32, height: u32) -> (Image<Vec3>, Image<f32>) {
        let rect = PixelRect::of_size(width, height);
        let truth = Image::from_fn(rect, |(x, y)| {
            let across = f64::from(x) + 4.0 * (f64::from(y) / 7.0).sin() - f64::from(width) / 2.0;
            (0.5 + across / 12.0).clamp(0.0, 1.0) as f32
        });
        let colours = Image::from_fn(rect, |(x, y)| {
            let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
            let (front, back) = (Vec3::new(0.1 + 0.1 * v, 0.4, 0.1), Vec3::new(0.8, 0.5 + 0.2 * u, 0.4));
            let alpha = *truth.get(x, y).unwrap();
            front * alpha + back * (1.0 - alpha)
        });
        (colours, truth)
    }

    #[test]
    fn a_soft_edge_between_plain_colours_is_found_to_a_step_of_8_bits() {
        let (colours, truth) = edge(64, 48);
        let known = truth.map(|alpha| (*alpha <= 0.0 || *alpha >= 1.0).then_some(*alpha));
        let found = closed_form(&colours, &known, &ClosedForm::default(), &Task::silent()).unwrap();
        let off = found.pixels().iter().zip(truth.pixels()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1.5 / 255.0, "{off}");
        assert!(known.pixels().iter().filter(|known| known.is_none()).count() > 300);
    }

    #[test]
    fn noise_of_two_steps_moves_the_matte_by_little() {
        let (mut colours, truth) = edge(64, 48);
        let mut rng = Rng::new(3);
        let mut noise = || rng.between(-2.0, 2.0) as f32 / 255.0;
        colours.pixels_mut().iter_mut().for_each(|colour| *colour += Vec3::new(noise(), noise(), noise()));
        let known = truth.map(|alpha| (*alpha <= 0.0 || *alpha >= 1.0).then_some(*alpha));
        let options = ClosedForm { flat: 1e-5, ..ClosedForm::default() };
        let found = closed_form(&colours, &known, &options, &Task::silent()).unwrap();
        let band = known.pixels().iter().zip(found.pixels().iter().zip(truth.pixels()));
        let off: Vec<f32> =
            band.filter(|(known, _)| known.is_none()).map(|(_, (a, b))| (a - b).abs()).collect();
        let mean = off.iter().sum::<f32>() / off.len() as f32;
        assert!(mean < 0.03, "{mean}");
    }

    #[test]
    fn what_is_known_stays_and_where_nothing_is_known_all_is_solid() {
        let (colours, truth) = edge(16, 16);
        let all = truth.map(|alpha| Some(*alpha));
        let task = Task::silent();
        assert_eq!(closed_form(&colours, &all, &ClosedForm::default(), &task).unwrap(), truth);
        let none = truth.map(|_| None);
        let solid = closed_form(&colours, &none, &ClosedForm::default(), &task).unwrap();
        assert!(solid.pixels().iter().all(|alpha| *alpha == 1.0));
    }
}
