//! Closed-form matting: A. Levin, D. Lischinski, Y. Weiss, *A Closed-Form Solution to Natural Image Matting*, IEEE
//! Transactions on Pattern Analysis and Machine Intelligence 30, 2008.
//!
//! In every window of 3 x 3 pixels alpha is nearly an affine function of the colour. The sum over all windows of the
//! squared distance from the best such function is a quadratic form of alpha; its minimum with alpha given outside of the
//! band is found by conjugate gradients. A row of the form has 5 x 5 factors, because a pixel is in nine windows.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::raster::Image;
use quadratura_base::task::Task;

/// Options of the solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedForm {
    /// The variance of linear light below which a window counts as flat, of one channel.
    pub flat: f32,
    /// The residual at which the solution ends, as a share of the first.
    pub residual: f64,
    /// The largest number of steps.
    pub steps: usize,
    /// The weight of the guess at a pixel, against about 1 for each of the nine windows that hold it.
    pub guess: f64,
}

impl Default for ClosedForm {
    fn default() -> Self {
        // The published 1e-7 for a sum over nine pixels; a residual of 1e-4 leaves alpha within a half step of 8 bits.
        Self { flat: 1e-7, residual: 1e-4, steps: 2000, guess: 0.01 }
    }
}

/// Solves alpha in a band. `colours` is in linear light, 0 to 1; `known` has alpha, 0 to 1, outside of the band and `None`
/// within, for the same rectangle. `guess` is what alpha in the band is drawn to, 0 to 1. Returns alpha everywhere, 0 to 1;
/// without a known pixel it is 1.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn closed_form(
    colours: &Image<Vec3>,
    known: &Image<Option<f32>>,
    guess: Option<&Image<f32>>,
    options: &ClosedForm,
    task: &Task,
) -> Result<Image<f32>> {
    assert_eq!(colours.rect(), known.rect(), "both are of one rectangle");
    let mut alpha = known.map(|alpha| alpha.unwrap_or(1.0));
    if known.pixels().iter().all(Option::is_none) || known.pixels().iter().all(Option::is_some) {
        return Ok(alpha);
    }
    let weight = guess.map_or(0.0, |_| options.guess);
    let system = System::new(colours, known, options.flat, weight);
    let given: Vec<f64> = known.pixels().iter().map(|alpha| f64::from(alpha.unwrap_or(0.0))).collect();
    let guessed = |index: &u32| guess.map_or(0.0, |guess| f64::from(guess.pixels()[*index as usize]));
    // (L + weight) alpha = weight guess in the band: the known part of L alpha goes to the right.
    let known_part = system.applied(&given).into_iter().zip(&system.unknown);
    let right: Vec<f64> = known_part.map(|(value, index)| weight * guessed(index) - value).collect();
    let mut solution: Vec<f64> = match guess {
        Some(_) => system.unknown.iter().map(guessed).collect(),
        None => system.start(known),
    };
    system.solve(&right, &mut solution, weight, options, given.len(), task)?;
    for (index, value) in system.unknown.iter().zip(&solution) {
        alpha.pixels_mut()[*index as usize] = value.clamp(0.0, 1.0) as f32;
    }
    Ok(alpha)
}

/// The mean colour of a window of 3 x 3 pixels, and the inverse of the covariance of its colours: in f64, because colours of
/// two surfaces lie on a line, and the covariance is nearly singular.
#[derive(Clone, Copy)]
struct WindowStatistics {
    mean: DVec3,
    inverse: DMat3,
}

/// The number of pixels that share a window with a pixel: 5 x 5.
const REACHED: usize = 25;

/// The quadratic form on the pixels of a picture, as far as it concerns the band.
struct System {
    width: usize,
    /// The pixels of the band.
    unknown: Vec<u32>,
    /// The rows of the form: per pixel of the band, the factors of the 5 x 5 pixels around it.
    rows: Vec<[f32; REACHED]>,
    /// The diagonal of the form, with the weights of the guess.
    diagonal: Vec<f64>,
}

impl System {
    fn new(colours: &Image<Vec3>, known: &Image<Option<f32>>, flat: f32, weight: f64) -> Self {
        let [width, height] = colours.size();
        let is_unknown = |index: usize| known.pixels()[index].is_none();
        let unknown: Vec<u32> =
            (0..width * height).filter(|index| is_unknown(*index)).map(|i| i as u32).collect();
        let is_inner = |index: usize| {
            let (x, y) = (index % width, index / width);
            x > 0 && y > 0 && x + 1 < width && y + 1 < height
        };
        let pixels = colours.pixels();
        let window = |index: usize| {
            let touches = is_inner(index) && around(index, width).into_iter().any(is_unknown);
            touches.then(|| WindowStatistics::new(pixels, index, width, flat))
        };
        let windows: Vec<Option<WindowStatistics>> = (0..pixels.len()).into_par_iter().map(window).collect();
        let row = |index: &u32| row(*index as usize, pixels, &windows, [width, height]);
        let rows: Vec<[f32; REACHED]> = unknown.par_iter().map(row).collect();
        let diagonal = rows.iter().map(|row| (f64::from(row[REACHED / 2]) + weight).max(1e-9)).collect();
        Self { width, unknown, rows, diagonal }
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

    /// Applies the form, without the weights of the guess, to values at all pixels; returns the result in the band.
    fn applied(&self, values: &[f64]) -> Vec<f64> {
        let apply = |(index, row): (&u32, &[f32; REACHED])| {
            let index = *index as usize;
            let mut sum = 0.0;
            for (dy, factors) in row.as_chunks::<5>().0.iter().enumerate() {
                // Factors of pixels outside of the picture are 0.
                let first = (index + dy * self.width) as isize - 2 * self.width as isize - 2;
                for (dx, factor) in factors.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                    sum += f64::from(*factor) * values[(first + dx as isize) as usize];
                }
            }
            sum
        };
        self.unknown.par_iter().zip(&self.rows).map(apply).collect()
    }

    /// Solves the form for a right side by conjugate gradients, preconditioned by the diagonal, from `solution` on.
    /// `weight` is that of the guess.
    fn solve(
        &self,
        right: &[f64],
        solution: &mut [f64],
        weight: f64,
        options: &ClosedForm,
        pixels: usize,
        task: &Task,
    ) -> Result<()> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |residual: &[f64]| -> Vec<f64> {
            residual.iter().zip(&self.diagonal).map(|(value, diagonal)| value / diagonal).collect()
        };
        let mut all = vec![0.0; pixels];
        let mut apply = |values: &[f64]| {
            self.unknown.iter().zip(values).for_each(|(index, value)| all[*index as usize] = *value);
            let mut applied = self.applied(&all);
            applied.iter_mut().zip(values).for_each(|(applied, value)| *applied += weight * value);
            applied
        };
        let applied = apply(solution);
        let mut residual: Vec<f64> =
            right.iter().zip(&applied).map(|(right, applied)| right - applied).collect();
        let mut direction = scaled(&residual);
        let mut norm = dot(&residual, &direction);
        let enough = norm * options.residual * options.residual;
        for _ in 0..options.steps {
            if norm <= enough.max(f64::MIN_POSITIVE) {
                break;
            }
            task.check_cancelled()?;
            let applied = apply(&direction);
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

/// Returns the row of the form of a pixel: the sum over the windows that hold it.
fn row(
    index: usize,
    colours: &[Vec3],
    windows: &[Option<WindowStatistics>],
    [width, height]: [usize; 2],
) -> [f32; REACHED] {
    let mut row = [0.0f64; REACHED];
    let (x, y) = (index % width, index / width);
    for wy in y.saturating_sub(1)..(y + 2).min(height) {
        for wx in x.saturating_sub(1)..(x + 2).min(width) {
            let middle = wy * width + wx;
            let Some(window) = windows[middle] else { continue };
            let along = window.inverse * (colours[index].as_dvec3() - window.mean);
            for (k, other) in around(middle, width).into_iter().enumerate() {
                let (dx, dy) = (wx + k % 3 + 1 - x, wy + k / 3 + 1 - y);
                row[dy * 5 + dx] -= (1.0 + along.dot(colours[other].as_dvec3() - window.mean)) / 9.0;
            }
            row[REACHED / 2] += 1.0;
        }
    }
    row.map(|factor| factor as f32)
}

impl WindowStatistics {
    fn new(colours: &[Vec3], middle: usize, width: usize, flat: f32) -> Self {
        let indices = around(middle, width);
        let mean = indices.iter().map(|i| colours[*i].as_dvec3()).sum::<DVec3>() / 9.0;
        let square = |i: &usize| {
            let off = colours[*i].as_dvec3() - mean;
            DMat3::from_cols(off * off.x, off * off.y, off * off.z)
        };
        let covariance =
            indices.iter().map(square).fold(DMat3::ZERO, |sum, square| sum + square) * (1.0 / 9.0);
        let inverse = (covariance + DMat3::from_diagonal(DVec3::splat(f64::from(flat) / 9.0))).inverse();
        Self { mean, inverse }
    }
}

/// Returns the nine pixels around an inner one, by index.
fn around(middle: usize, width: usize) -> [usize; 9] {
    std::array::from_fn(|k| middle + k / 3 * width + k % 3 - width - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::synthetic::Rng;

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
    fn a_soft_edge_between_smooth_colours_is_found_to_four_steps_of_8_bits() {
        let (colours, truth) = edge(64, 48);
        let known = truth.map(|alpha| (*alpha <= 0.0 || *alpha >= 1.0).then_some(*alpha));
        let found = closed_form(&colours, &known, None, &ClosedForm::default(), &Task::silent()).unwrap();
        let off = found.pixels().iter().zip(truth.pixels()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // The same form, written down as a matrix and solved densely, is off by 3.2 steps: the colours are not quite lines.
        assert!(off < 4.0 / 255.0, "{off}");
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
        let found = closed_form(&colours, &known, None, &options, &Task::silent()).unwrap();
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
        assert_eq!(closed_form(&colours, &all, None, &ClosedForm::default(), &task).unwrap(), truth);
        let none = truth.map(|_| None);
        let solid = closed_form(&colours, &none, None, &ClosedForm::default(), &task).unwrap();
        assert!(solid.pixels().iter().all(|alpha| *alpha == 1.0));
    }
}
