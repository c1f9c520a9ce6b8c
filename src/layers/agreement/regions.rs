//! Things with an outline that a photo shows and three or more others contradict: whole regions, joined across faces in
//! the image and closed, because half a car is worse than a car.

use super::{AgreementOptions, Votes};
use quadratura_base::geometry::{PixelRect, Spans};

/// The agreement throughout a region.
pub const OF_REGIONS: f32 = 0.01;

/// A region that other photos contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct ContradictedRegion {
    /// The region, closed and without holes, in pixels of the reduced photo.
    pub pixels: Spans,
    /// The mean distance from the colours of the other photos, as a natural logarithm.
    pub distance: f32,
}

impl ContradictedRegion {
    /// Lowers the agreement of the pixels of a reduced photo (row by row) to that of regions in this one, with a ramp of
    /// this width around it.
    pub fn lower(&self, values: &mut [f32], [width, height]: [u32; 2], ramp: f64) {
        let whole = PixelRect::of_size(width, height);
        let rings = ramp.ceil() as i32;
        let mut lower = |spans: &Spans, to: f32| {
            for (y, run) in spans.iter() {
                for x in run.clone() {
                    let at = whole.index(x, y);
                    at.into_iter().for_each(|at| values[at] = values[at].min(to));
                }
            }
        };
        let mut inside = self.pixels.clone();
        lower(&inside, OF_REGIONS);
        for ring in 1..=rings {
            let outside = self.pixels.grown(ring);
            let share = (f64::from(ring) / (ramp + 1.0)).min(1.0) as f32;
            lower(&outside.minus(&inside), OF_REGIONS + (1.0 - OF_REGIONS) * share);
            inside = outside;
        }
    }
}

/// Finds the contradicted regions of a reduced photo of `width` columns, from the top.
pub fn contradicted_regions(
    votes: &[Votes],
    width: usize,
    options: &AgreementOptions,
) -> Vec<ContradictedRegion> {
    let height = votes.len() / width.max(1);
    let whole = PixelRect::of_size(width as u32, height as u32);
    let vote = |x: i32, y: i32| &votes[y as usize * width + x as usize];
    let against = |vote: &Votes| vote.against >= options.least_against && vote.against > vote.own;
    let evidence = Spans::of_pixels(whole, |x, y| against(vote(x, y)));
    // Beside depth discontinuities nobody is asked, and a thing in front of one is not two things.
    let unknown = Spans::of_pixels(whole, |x, y| vote(x, y).are_none());
    let across = closed(&evidence, options.unknown_gap, whole).intersection(&unknown);
    let joined = closed(&evidence.union(&across), options.gap, whole);
    let most = (votes.len() as f64 * options.most_share) as u64;
    let mut found = Vec::new();
    for region in connected(&joined, whole) {
        let pixels = without_holes(&region);
        let known = pixels.intersection(&evidence);
        let (mut clear, mut distance) = (0u64, 0.0f64);
        for (y, x) in known.iter().flat_map(|(y, run)| run.clone().map(move |x| (y, x))) {
            let vote = vote(x, y);
            clear += u64::from(vote.against - vote.own >= options.clear_lead);
            distance += f64::from(vote.distance);
        }
        let count = pixels.count();
        let distance = (distance / known.count().max(1) as f64) as f32;
        let is_thing = (options.least_pixels..=most).contains(&count)
            && distance >= options.least_distance
            && 2 * clear >= known.count()
            && has_core(&pixels, options.core);
        if is_thing {
            found.push(ContradictedRegion { pixels, distance });
        }
    }
    found
}

/// Closes gaps of at most twice this width: grown and shrunk again.
pub fn closed(spans: &Spans, gap: i32, whole: PixelRect) -> Spans {
    if spans.is_empty() {
        return Spans::default();
    }
    let frame = spans.bounds().grown(2 * gap.max(1) as u32 + 1);
    let shrunk = spans.grown(gap).complement(frame).grown(gap).complement(frame);
    let columns = whole.x..whole.right();
    shrunk
        .union(spans)
        .intersection(&Spans::from_rows(whole.y..whole.bottom(), |_, out| out.push(columns.clone())))
}

/// Returns whether a square of this radius fits into the region somewhere.
fn has_core(pixels: &Spans, radius: i32) -> bool {
    let frame = pixels.bounds().grown(1);
    !pixels.minus(&pixels.complement(frame).grown(radius)).is_empty()
}

/// Returns the region with all that it encloses.
pub(super) fn without_holes(pixels: &Spans) -> Spans {
    let frame = pixels.bounds().grown(1);
    let outside = connected(&pixels.complement(frame), frame);
    let outer = outside.into_iter().find(|part| part.holds(frame.x, frame.y));
    outer.map_or_else(|| pixels.clone(), |outer| outer.complement(frame))
}

/// Divides spans into parts that are connected, across corners too, from the top.
pub(super) fn connected(spans: &Spans, whole: PixelRect) -> Vec<Spans> {
    let bounds = spans.bounds().intersection(&whole);
    let mut open = vec![false; bounds.area() as usize];
    for (y, run) in spans.iter() {
        run.clone().filter_map(|x| bounds.index(x, y)).for_each(|at| open[at] = true);
    }
    let mut parts = Vec::new();
    for start in 0..open.len() {
        if !open[start] {
            continue;
        }
        let width = bounds.w as usize;
        let (mut part, mut next) = (Vec::new(), vec![start]);
        open[start] = false;
        while let Some(at) = next.pop() {
            part.push(at);
            let (x, y) = (at % width, at / width);
            for v in y.saturating_sub(1)..(y + 2).min(bounds.h as usize) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    if std::mem::take(&mut open[v * width + u]) {
                        next.push(v * width + u);
                    }
                }
            }
        }
        part.sort_unstable();
        parts.push(spans_of(&part, bounds));
    }
    parts
}

/// Converts sorted indices within `bounds` to spans.
fn spans_of(part: &[usize], bounds: PixelRect) -> Spans {
    let width = bounds.w as usize;
    let row = |at: &usize| at / width;
    let (Some(first), Some(last)) = (part.first().map(row), part.last().map(row)) else {
        return Spans::default();
    };
    let mut rest = part.iter().peekable();
    Spans::from_rows(bounds.y + first as i32..bounds.y + last as i32 + 1, |y, out| {
        while let Some(at) = rest.next_if(|at| bounds.y + row(at) as i32 == y) {
            let x = bounds.x + (at % width) as i32;
            out.push(x..x + 1);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [60, 40];

    fn options() -> AgreementOptions {
        AgreementOptions { most_share: 0.5, core: 2, least_pixels: 60, ..AgreementOptions::default() }
    }

    /// Finds regions where `against` says how many votes there are against each pixel's own.
    fn found(against: impl Fn(i32, i32) -> f32) -> Vec<ContradictedRegion> {
        let pixels = (0..SIZE[1] as i32).flat_map(|y| (0..SIZE[0] as i32).map(move |x| (x, y)));
        let votes =
            pixels.map(|(x, y)| Votes { own: 1.0, against: against(x, y), distance: 0.9, expected: None });
        contradicted_regions(&votes.collect::<Vec<_>>(), SIZE[0] as usize, &options())
    }

    fn car(x: i32, y: i32) -> bool {
        (10..30).contains(&x) && (8..20).contains(&y)
    }

    #[test]
    fn a_thing_that_three_photos_contradict_is_taken_as_a_whole_across_its_gaps_and_holes() {
        // The windows agree by chance, and a stripe has no other photo.
        let regions = found(|x, y| match (car(x, y), (14..18).contains(&x) && (10..13).contains(&y)) {
            (true, false) if y != 16 => 3.0,
            _ => 0.0,
        });
        assert_eq!(regions.len(), 1);
        assert!((8..20).all(|y| (10..30).all(|x| regions[0].pixels.holds(x, y))));
        assert!(regions[0].pixels.count() <= 20 * 12 && (regions[0].distance - 0.9).abs() < 1e-6);
    }

    #[test]
    fn a_thing_in_front_of_an_edge_where_nobody_is_asked_is_one_thing() {
        // Twice the distance that is kept from depth discontinuities.
        let divided = |alone: bool| {
            let pixels = (0..SIZE[1] as i32).flat_map(|y| (0..SIZE[0] as i32).map(move |x| (x, y)));
            let votes = pixels.map(|(x, y)| match (car(x, y), (16..24).contains(&x)) {
                (_, true) if alone => Votes { own: 1.0, against: 0.0, distance: 0.0, expected: None },
                (true, false) => Votes { own: 1.0, against: 3.0, distance: 0.9, expected: None },
                _ => Votes { own: 3.0, against: 0.0, distance: 0.0, expected: None },
            });
            contradicted_regions(&votes.collect::<Vec<_>>(), SIZE[0] as usize, &options())
        };
        let [whole] = &divided(true)[..] else { panic!("two things") };
        assert_eq!(whole.pixels.bounds(), PixelRect::from_edges(10, 8, 30, 20));
        assert!(
            divided(false).iter().all(|part| part.pixels.bounds().w < 20),
            "what others confirm divides things"
        );
    }

    #[test]
    fn two_photos_are_too_few_and_strips_specks_and_everything_are_no_things() {
        assert!(found(|x, y| if car(x, y) { 2.0 } else { 0.0 }).is_empty(), "two photos");
        assert!(found(|_, y| if (10..13).contains(&y) { 9.0 } else { 0.0 }).is_empty(), "a strip");
        assert!(found(|x, y| if x < 5 && y < 5 { 9.0 } else { 0.0 }).is_empty(), "a speck");
        assert!(found(|_, _| 9.0).is_empty(), "everything");
        assert!(
            found(|x, y| if car(x, y) && x < 12 {
                9.0
            } else if car(x, y) {
                2.6
            } else {
                0.0
            })
            .len()
                == 1
        );
    }

    #[test]
    fn agreement_is_lowest_in_a_region_and_rises_around_it() {
        let region = &found(|x, y| if car(x, y) { 4.0 } else { 0.0 })[0];
        let mut values = vec![1.0; (SIZE[0] * SIZE[1]) as usize];
        region.lower(&mut values, SIZE, 3.0);
        let row: Vec<f32> = (25..36).map(|x| values[(15 * SIZE[0] + x) as usize]).collect();
        assert_eq!(row[..5], [OF_REGIONS; 5]);
        assert!(row[4..9].windows(2).all(|w| w[1] > w[0]) && row[8..] == [1.0; 3], "{row:?}");
    }
}
