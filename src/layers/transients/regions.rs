//! Connected regions in which a photo disagrees with the others.

use super::TransientOptions;
use crate::geometry::{PixelRect, Spans};

/// A region that probably shows a transient object.
#[derive(Debug, Clone, PartialEq)]
pub struct TransientRegion {
    /// The mask: the region with its margin, in pixels of the reduced photo.
    pub masked: Spans,
    /// The mean disagreement, as a natural logarithm.
    pub score: f32,
    /// The score times the square root of the number of pixels without the margin: large objects need not
    /// differ as much as small ones.
    pub weight: f32,
}

/// Finds the suggested regions of a photo of `width` columns, from the top. `disagreement` is the result of
/// [`super::disagreement()`].
pub fn transient_regions(
    disagreement: &[f32],
    width: usize,
    options: &TransientOptions,
) -> Vec<TransientRegion> {
    let smooth = smoothed(disagreement, width);
    let most = (disagreement.len() as f64 * options.most_share) as u64;
    let whole = PixelRect::of_size(width as u32, (disagreement.len() / width.max(1)) as u32);
    let mut taken = vec![false; disagreement.len()];
    let mut found = Vec::new();
    for start in 0..smooth.len() {
        if taken[start] || smooth[start].is_nan() || smooth[start] < options.weak {
            continue;
        }
        let pixels = connected(&smooth, width, start, options.weak, &mut taken);
        let strongest = pixels.iter().map(|&i| smooth[i]).fold(0.0, f32::max);
        let count = pixels.len() as u64;
        if strongest < options.strong || count < options.least_pixels || count > most {
            continue;
        }
        let score = pixels.iter().map(|&i| smooth[i]).sum::<f32>() / pixels.len() as f32;
        let weight = score * (pixels.len() as f32).sqrt();
        if score >= options.least_score && weight >= options.least_weight {
            found.push(TransientRegion {
                masked: spans(pixels, width, whole, options.margin),
                score,
                weight,
            });
        }
    }
    found
}

/// Smooths the known values: means over the known values of 3 x 3 pixels; NaN remains NaN.
fn smoothed(disagreement: &[f32], width: usize) -> Vec<f32> {
    let height = disagreement.len() / width.max(1);
    let mean = |x: usize, y: usize| {
        if disagreement[y * width + x].is_nan() {
            return f32::NAN;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for v in y.saturating_sub(1)..(y + 2).min(height) {
            for u in x.saturating_sub(1)..(x + 2).min(width) {
                let value = disagreement[v * width + u];
                if !value.is_nan() {
                    sum += value;
                    count += 1.0;
                }
            }
        }
        sum / count
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
}

/// Collects the pixels of at least `least` that are connected with `start`, across corners too.
fn connected(values: &[f32], width: usize, start: usize, least: f32, taken: &mut [bool]) -> Vec<usize> {
    let height = values.len() / width;
    let (mut found, mut next) = (Vec::new(), vec![start]);
    taken[start] = true;
    while let Some(at) = next.pop() {
        found.push(at);
        let (x, y) = (at % width, at / width);
        for v in y.saturating_sub(1)..(y + 2).min(height) {
            for u in x.saturating_sub(1)..(x + 2).min(width) {
                let neighbour = v * width + u;
                // The comparison is false for NaN.
                if !taken[neighbour] && values[neighbour] >= least {
                    taken[neighbour] = true;
                    next.push(neighbour);
                }
            }
        }
    }
    found
}

/// Converts pixels to a mask with the margin, in which holes and narrow gaps are closed.
fn spans(mut pixels: Vec<usize>, width: usize, whole: PixelRect, margin: i32) -> Spans {
    pixels.sort_unstable();
    let mut rest = pixels.iter().copied().peekable();
    let last = pixels.last().map_or(0, |at| at / width) as i32;
    let first = pixels.first().map_or(0, |at| at / width) as i32;
    let bare = Spans::from_rows(first..last + 1, |y, out| {
        while let Some(at) = rest.next_if(|at| (at / width) as i32 == y) {
            let x = (at % width) as i32;
            out.push(x..x + 1);
        }
    });
    // The mask is dilated by twice the margin and eroded by once: gaps close, and rims get their margin.
    let frame = whole.grown(4 * margin.max(1) as u32);
    let wide = bare.grown(2 * margin);
    let shrunk = wide.complement(frame).grown(margin).complement(frame);
    shrunk.intersection(&Spans::of_pixels(whole, |_, _| true))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options() -> TransientOptions {
        TransientOptions {
            least_pixels: 12,
            least_weight: 3.0,
            most_share: 0.5,
            margin: 1,
            ..TransientOptions::default()
        }
    }

    /// Builds values of 40 x 30 pixels.
    fn disagreement(value: impl Fn(i32, i32) -> f32) -> Vec<f32> {
        (0..30).flat_map(|y| (0..40).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect()
    }

    #[test]
    fn a_region_that_differs_is_found_with_its_margin_and_noise_is_not() {
        let is_foreign = |x: i32, y: i32| (10..18).contains(&x) && (5..20).contains(&y);
        let values = disagreement(|x, y| match (is_foreign(x, y), (x * 7 + y * 13) % 50) {
            (true, _) => 0.9,
            (false, 0) => 0.8,
            (false, _) => 0.02,
        });
        let found = transient_regions(&values, 40, &options());
        assert_eq!(found.len(), 1);
        let masked = &found[0].masked;
        assert!((4..21).all(|y| (9..19).all(|x| masked.holds(x, y))), "{:?}", masked.bounds());
        assert!(masked.count() < 14 * 21 && found[0].score > 0.6);
    }

    #[test]
    fn weak_small_and_huge_differences_are_no_suspects_and_the_unknown_is_none() {
        assert!(
            transient_regions(&disagreement(|x, _| if x < 9 { 0.4 } else { 0.0 }), 40, &options()).is_empty(),
            "weak"
        );
        let small = disagreement(|x, y| if x < 2 && y < 2 { 2.0 } else { 0.0 });
        assert!(transient_regions(&small, 40, &options()).is_empty(), "small");
        assert!(transient_regions(&disagreement(|_, _| 2.0), 40, &options()).is_empty(), "all of it");
        assert!(transient_regions(&disagreement(|_, _| f32::NAN), 40, &options()).is_empty());
    }

    #[test]
    fn holes_are_closed() {
        let values = disagreement(|x, y| match ((10..20).contains(&x) && (5..15).contains(&y), x == 14) {
            (true, true) => f32::NAN,
            (true, false) => 1.0,
            _ => 0.0,
        });
        let found = transient_regions(&values, 40, &options());
        assert_eq!(found.len(), 1, "both sides touch beyond the ends of what is not known");
        assert!((5..15).all(|y| found[0].masked.holds(14, y)));
    }
}
