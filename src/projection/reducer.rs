//! Reducing an image row by row: a finer image arrives from the top, and rows of the wanted size come out as soon as they
//! are complete, so that the finer image never is in memory as a whole.
//!
//! The filter is Lanczos with three lobes, as wide as a pixel of the result, on the values that are stored in sRGB, times alpha.
//! That is how photos are reduced in other programs, and how a score reduces the photos that it compares with
//! (`io::reference`). docs/quality.md has what other filters give.

use std::collections::VecDeque;

use rayon::prelude::*;

use quadratura_base::scene::resample::lanczos3;

/// The number of lobes of the filter to either side.
const LOBES: f64 = 3.0;

/// A pixel: three values in sRGB times alpha, and alpha.
pub type Values = [f32; 4];

/// The weights of consecutive pixels of the finer image in one pixel of the result, along one side.
#[derive(Debug, Clone, PartialEq)]
struct Taps {
    first: usize,
    weights: Vec<f32>,
}

/// Reduces an image of `from` pixels to `to` pixels along both sides, which may be as many.
#[derive(Debug)]
pub struct Reducer {
    columns: Vec<Taps>,
    rows: Vec<Taps>,
    /// The rows that are still needed, reduced across, and the number of the first of them.
    waiting: VecDeque<Vec<Values>>,
    first_waiting: usize,
    /// The number of rows that came out.
    done: usize,
}

impl Reducer {
    /// Prepares reducing; `from` and `to` are width and height in pixels, above 0.
    pub fn new(from: [u32; 2], to: [u32; 2]) -> Self {
        let [columns, rows] = [0, 1].map(|side| taps(from[side] as usize, to[side] as usize));
        Self { columns, rows, waiting: VecDeque::new(), first_waiting: 0, done: 0 }
    }

    /// Takes the next rows of the finer image, and returns the rows that are complete now, from the top.
    pub fn add(&mut self, width: usize, rows: &[Values]) -> Vec<Vec<Values>> {
        let across = |row: &[Values]| -> Vec<Values> {
            self.columns.iter().map(|taps| sum(taps, |at| row[at])).collect()
        };
        let reduced: Vec<Vec<Values>> = rows.par_chunks_exact(width).map(across).collect();
        self.waiting.extend(reduced);
        let known = self.first_waiting + self.waiting.len();
        let complete =
            self.rows[self.done..].iter().take_while(|taps| taps.first + taps.weights.len() <= known);
        let complete: Vec<&Taps> = complete.collect();
        let down = |taps: &&Taps| -> Vec<Values> {
            let column = |x: usize| sum(taps, |at| self.waiting[at - self.first_waiting][x]);
            (0..self.columns.len()).map(column).collect()
        };
        let out: Vec<Vec<Values>> = complete.par_iter().map(down).collect();
        self.done += out.len();
        let needed = self.rows.get(self.done).map_or(known, |taps| taps.first);
        self.waiting.drain(..needed - self.first_waiting);
        self.first_waiting = needed;
        out
    }
}

fn sum(taps: &Taps, value: impl Fn(usize) -> Values) -> Values {
    let mut sum = [0.0; 4];
    for (weight, at) in taps.weights.iter().zip(taps.first..) {
        let value = value(at);
        (0..4).for_each(|c| sum[c] += weight * value[c]);
    }
    sum
}

/// Returns the taps of each of `to` pixels along a side of `from` finer pixels.
fn taps(from: usize, to: usize) -> Vec<Taps> {
    let per_px = from as f64 / to as f64;
    let of_pixel = |pixel: usize| {
        let middle = (pixel as f64 + 0.5) * per_px;
        let reach = LOBES * per_px;
        let first = (middle - reach).floor().max(0.0) as usize;
        let end = ((middle + reach).ceil() as usize).min(from);
        let weights: Vec<f64> = (first..end).map(|at| weight((at as f64 + 0.5 - middle) / per_px)).collect();
        let all: f64 = weights.iter().sum();
        Taps { first, weights: weights.iter().map(|weight| (weight / all) as f32).collect() }
    };
    (0..to).map(of_pixel).collect()
}

fn weight(distance: f64) -> f64 {
    if distance.abs() < LOBES { lanczos3(distance) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use image::imageops::{FilterType, resize};
    use image::{ImageBuffer, Rgba};

    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn reduced(from: [u32; 2], to: [u32; 2], pixels: &[Values], at_once: usize) -> Vec<Values> {
        let mut reducer = Reducer::new(from, to);
        let width = from[0] as usize;
        pixels.chunks(width * at_once).flat_map(|rows| reducer.add(width, rows)).flatten().collect()
    }

    #[test]
    fn it_is_the_filter_by_which_photos_are_reduced_however_many_rows_come_at_once() {
        let mut rng = Rng::new(3);
        let (from, to) = ([37, 50], [12, 9]);
        let pixels: Vec<Values> =
            (0..37 * 50).map(|_| std::array::from_fn(|_| rng.between(0.0, 1.0) as f32)).collect();
        let picture: ImageBuffer<Rgba<f32>, Vec<f32>> =
            ImageBuffer::from_raw(37, 50, pixels.concat()).unwrap();
        let expected = resize(&picture, 12, 9, FilterType::Lanczos3);
        for at_once in [1, 7, 50] {
            let found = reduced(from, to, &pixels, at_once);
            assert_eq!(found.len(), 12 * 9);
            for (found, expected) in found.iter().zip(expected.pixels()) {
                // The other filter limits its values to the range of colours, and both round.
                let differs =
                    |c: usize| (found[c].clamp(0.0, 1.0) - expected[c].clamp(0.0, 1.0)).abs() > 1e-4;
                assert!(!(0..4).any(differs), "{found:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn an_image_of_the_wanted_size_stays_as_it_is() {
        let pixels: Vec<Values> = (0..15).map(|at| [at as f32, 1.0, 0.5, 1.0]).collect();
        for (found, expected) in reduced([5, 3], [5, 3], &pixels, 2).iter().zip(&pixels) {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}, {expected:?}");
        }
    }
}
