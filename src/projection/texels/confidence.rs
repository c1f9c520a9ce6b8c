//! The confidence of texels near the border of what a photo shows (`docs/method.md`, section 7): poses and
//! models are wrong by a pixel or two, and there the photo may show the neighbouring surface.

use quadratura_base::geometry::{PixelRect, Spans};

/// The ramp by which confidence falls off towards a border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConfidenceRamp {
    /// The width, in texels, over which confidence rises from 0 at the border to 1; at most 32.
    pub width_px: f32,
}

impl Default for ConfidenceRamp {
    fn default() -> Self {
        Self { width_px: 8.0 }
    }
}

impl ConfidenceRamp {
    /// Returns the number of texels inwards from the border in which confidence may be below 1.
    fn reach(&self) -> i32 {
        (self.width_px.clamp(0.0, 32.0) + 0.5).ceil() as i32
    }

    /// Returns the confidence of a texel whose centre is `distance` from the centre of the nearest texel
    /// beyond the border. It is never 0, because a surface that only this photo shows still has to be
    /// textured.
    fn value(&self, distance: f32) -> f32 {
        if self.width_px <= 0.0 { 1.0 } else { ((distance - 0.5) / self.width_px).clamp(1.0 / 255.0, 1.0) }
    }

    /// Calls `put(x, y, confidence)` for every texel of `content` whose confidence may be below 1, from the
    /// exact Euclidean distance to the nearest texel outside of the content: an occluded one, or one beyond
    /// the outline, where another surface or nothing follows.
    pub fn each(&self, content: &Spans, mut put: impl FnMut(i32, i32, f32)) {
        let reach = self.reach();
        let border = content.complement(content.bounds().grown(reach as u32 + 1));
        let near = content.intersection(&border.grown(reach));
        let values: Vec<f32> =
            (0..=far(reach)).map(|square| self.value(f32::from(square as u16).sqrt())).collect();
        let mut distances = RowDistances::new(&border, near.bounds(), reach);
        let mut least = Vec::new();
        for y in near.rows() {
            for run in near.row(y) {
                distances.least(y, run.start, run.len(), &mut least);
                for (x, &square) in run.clone().zip(&least) {
                    put(x, y, values[square as usize]);
                }
            }
        }
    }
}

/// Returns a squared distance that is beyond the reach.
fn far(reach: i32) -> i16 {
    ((reach + 1) * (reach + 1)) as i16
}

/// The squared distances along rows, for the rows around the current one.
struct RowDistances<'a> {
    border: &'a Spans,
    reach: i32,
    left: i32,
    width: usize,
    /// A ring buffer of `2 reach + 1` rows; row y is at `y mod (2 reach + 1)`.
    rows: Vec<i16>,
    /// The first row that is not in the buffer yet.
    next: i32,
}

impl<'a> RowDistances<'a> {
    fn new(border: &'a Spans, bounds: PixelRect, reach: i32) -> Self {
        let width = bounds.w as usize;
        let rows = vec![0; width * (2 * reach + 1) as usize];
        Self { border, reach, left: bounds.x, width, rows, next: i32::MIN }
    }

    /// Computes the least squared distance for `count` texels from column `x` of row `y`. Rows must not
    /// decrease.
    fn least(&mut self, y: i32, x: i32, count: usize, least: &mut Vec<i16>) {
        for row in self.next.max(y - self.reach)..=y + self.reach {
            self.fill(row);
        }
        self.next = self.next.max(y + self.reach + 1);
        least.clear();
        least.resize(count, far(self.reach));
        for dy in -self.reach..=self.reach {
            let at = self.index(y + dy) + (x - self.left) as usize;
            let down = (dy * dy) as i16;
            for (least, along) in least.iter_mut().zip(&self.rows[at..at + count]) {
                *least = (*least).min(along + down);
            }
        }
    }

    fn index(&self, y: i32) -> usize {
        y.rem_euclid(2 * self.reach + 1) as usize * self.width
    }

    /// Fills row y with the squared distance to the row's nearest border texel.
    fn fill(&mut self, y: i32) {
        let reach = self.reach;
        let left = self.left;
        let at = self.index(y);
        let row = &mut self.rows[at..at + self.width];
        row.fill(far(reach));
        let mut lower = |x: i32, away: i32| {
            let cell = usize::try_from(x - left).ok().and_then(|x| row.get_mut(x));
            cell.into_iter().for_each(|cell| *cell = (*cell).min((away * away) as i16));
        };
        for run in self.border.row(y) {
            (1..=reach).for_each(|away| lower(run.start - away, away));
            (1..=reach).for_each(|away| lower(run.end - 1 + away, away));
        }
        for run in self.border.row(y) {
            let within = |x: i32| ((x - left).max(0) as usize).min(row.len());
            let inside = within(run.start)..within(run.end);
            row[inside].fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn blob(rng: &mut Rng, side: i32) -> Spans {
        Spans::from_rows(0..side, |y, out| {
            let (a, b) = (rng.between(0.0, 12.0) as i32, rng.between(20.0, f64::from(side)) as i32);
            out.push(a..(a + b) / 2);
            if y % 9 != 0 {
                out.push((a + b) / 2 + (y % 2)..b);
            }
        })
    }

    fn holds(spans: &Spans, x: i32, y: i32) -> bool {
        spans.row(y).iter().any(|run| run.contains(&x))
    }

    #[test]
    fn confidence_is_the_exact_distance_to_the_border() {
        let mut rng = Rng::new(5);
        for case in 0..20 {
            let ramp = ConfidenceRamp { width_px: [8.0, 3.0][case % 2] };
            let content = blob(&mut rng, 40).minus(&blob(&mut rng, 14));
            let mut found = std::collections::HashMap::new();
            ramp.each(&content, |x, y, confidence| {
                assert!(found.insert((x, y), confidence).is_none(), "twice at {x}, {y}");
            });
            for y in -2..42 {
                for x in -2..42 {
                    let mut distance = f32::INFINITY;
                    for (bx, by) in (-12..52).flat_map(|by| (-12..52).map(move |bx| (bx, by))) {
                        if !holds(&content, bx, by) {
                            distance = distance.min(((bx - x) as f32).hypot((by - y) as f32));
                        }
                    }
                    let known = found.get(&(x, y)).copied().unwrap_or(1.0);
                    let expected = if holds(&content, x, y) { ramp.value(distance) } else { 1.0 };
                    assert!((known - expected).abs() < 1e-6, "case {case}: {known} at {x}, {y}: {expected}");
                }
            }
        }
    }

    #[test]
    fn a_border_of_no_width_trusts_everything() {
        let ramp = ConfidenceRamp { width_px: 0.0 };
        let content = Spans::from_rows(0..3, |_, out| out.push(0..3));
        ramp.each(&content, |x, y, confidence| assert_eq!(confidence, 1.0, "{x}, {y}"));
    }
}
