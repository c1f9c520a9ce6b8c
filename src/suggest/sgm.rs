//! One label per pixel: semi-global matching (Hirschmüller, *Stereo Processing by Semiglobal Matching and Mutual Information*,
//! 2008) with a price for each change of label, which is lower where the photo has an edge.

/// The price of a change of label.
const CHANGE: f32 = 1.8;

/// The difference of grey at which an edge lowers the price to a third.
const EDGE: f32 = 12.0;

/// Returns the best label of each pixel. `costs` has all labels of the first pixel first.
pub fn best_labels(costs: &[f32], labels: usize, greys: &[f32], size: [usize; 2]) -> Vec<u16> {
    let mut sums = vec![0.0f32; costs.len()];
    for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)] {
        add_paths(costs, labels, greys, size, (dx, dy), &mut sums);
    }
    let best = |sums: &[f32]| (0..labels).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0) as u16;
    sums.chunks_exact(labels).map(best).collect()
}

/// Adds the costs of the best paths that come from one direction.
fn add_paths(
    costs: &[f32],
    labels: usize,
    greys: &[f32],
    [w, h]: [usize; 2],
    (dx, dy): (isize, isize),
    sums: &mut [f32],
) {
    // The paths of this row and of the one before, and the least cost of each.
    let mut rows = [vec![0.0f32; w * labels], vec![0.0f32; w * labels]];
    let mut least = [vec![0.0f32; w], vec![0.0f32; w]];
    for step in 0..h {
        let y = if dy < 0 { h - 1 - step } else { step };
        for column in 0..w {
            let x = if dx < 0 { w - 1 - column } else { column };
            let at = y * w + x;
            let before = (x.wrapping_add_signed(-dx), y.wrapping_add_signed(-dy));
            let own = &costs[at * labels..(at + 1) * labels];
            let [current, last] = &mut rows;
            let [least_here, least_last] = &mut least;
            if before.0 >= w || before.1 >= h {
                current[x * labels..(x + 1) * labels].copy_from_slice(own);
            } else {
                let edge = greys[at] - greys[before.1 * w + before.0];
                let price = CHANGE * (0.15 + 0.85 * (-edge.abs() / EDGE).exp());
                let cheapest = if dy == 0 { least_here[before.0] } else { least_last[before.0] };
                let (from, to) = if dy == 0 {
                    let (low, high) = (before.0.min(x), before.0.max(x));
                    let (left, right) = current.split_at_mut(high * labels);
                    let (left, right) = (&mut left[low * labels..(low + 1) * labels], &mut right[..labels]);
                    if before.0 < x { (&*left, right) } else { (&*right, left) }
                } else {
                    (
                        &last[before.0 * labels..(before.0 + 1) * labels],
                        &mut current[x * labels..(x + 1) * labels],
                    )
                };
                for ((to, from), own) in to.iter_mut().zip(from).zip(own) {
                    *to = own + from.min(cheapest + price) - cheapest;
                }
            }
            let here = &current[x * labels..(x + 1) * labels];
            least_here[x] = here.iter().copied().fold(f32::INFINITY, f32::min);
            sums[at * labels..(at + 1) * labels].iter_mut().zip(here).for_each(|(sum, path)| *sum += path);
        }
        if dy != 0 {
            rows.swap(0, 1);
            least.swap(0, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_that_is_slightly_cheaper_at_one_pixel_does_not_interrupt_the_other() {
        let size = [9, 7];
        let mut costs: Vec<f32> =
            (0..63).flat_map(|at| if at % 9 < 5 { [0.0, 1.0] } else { [1.0, 0.0] }).collect();
        costs[2 * (3 * 9 + 2)] = 1.0;
        costs[2 * (3 * 9 + 2) + 1] = 0.0;
        let labels = best_labels(&costs, 2, &[100.0; 63], size);
        assert!(labels.iter().enumerate().all(|(at, label)| (*label == 1) == (at % 9 >= 5)), "{labels:?}");
    }
}
