//! Log ratios of the photos' colours at the points that they share.

use glam::Vec2;
use quadratura_base::scene::PhotoId;
use rayon::prelude::*;

use super::patch::PatchColour;
use super::points::{PointPatch, SharedPoint};

/// The comparison of two photos at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// The first photo.
    pub a: PhotoId,
    /// The second photo.
    pub b: PhotoId,
    /// `ln(colour in a / colour in b)`, R, G, B: the difference of the two gains, and noise.
    pub log: [f32; 3],
    /// The weight of the comparison, in 0..1.
    pub weight: f32,
    /// Linear light in a and in b, the mean of the channels.
    pub light: [f32; 2],
    /// The position of the point in a and in b, in their pixels.
    pub at_px: [Vec2; 2],
}

/// Computes the ratios at all points, in their order. A point that n photos show gives at most n log2(n)
/// pairs: each photo is compared with those 1, 2, 4, ... positions further on in a cycle, which keeps chains
/// of comparisons short without comparing every pair.
pub fn pairwise_ratios(points: &[SharedPoint], colours: &[Vec<PatchColour>]) -> Vec<Ratio> {
    points.par_iter().zip(colours).flat_map_iter(|(point, colours)| ratios_at(point, colours)).collect()
}

fn ratios_at(point: &SharedPoint, colours: &[PatchColour]) -> Vec<Ratio> {
    let usable = point.patches.iter().zip(colours).filter_map(|(patch, colour)| {
        colour.filter(|colour| colour.usable).map(|colour| (patch, colour.mean))
    });
    let usable: Vec<(&PointPatch, [f64; 3])> = usable.collect();
    let pairs = pairs_of(usable.len());
    let compare = |(i, j): (usize, usize)| {
        let ((a, in_a), (b, in_b)) = (&usable[i], &usable[j]);
        let log = [0, 1, 2].map(|c| (in_a[c] / in_b[c]).ln() as f32);
        let light = [in_a, in_b].map(|mean| (mean.iter().sum::<f64>() / 3.0) as f32);
        let at_px = [a, b].map(|patch| patch.center_px.as_vec2());
        Ratio { a: a.photo, b: b.photo, log, weight: similarity(a, b) as f32, light, at_px }
    };
    pairs.into_iter().map(compare).filter(|ratio| ratio.weight > 0.0).collect()
}

/// Lists the pairs of n items in which each meets those 1, 2, 4, ... positions further on in a cycle; each
/// pair once.
fn pairs_of(n: usize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut apart = 1;
    while 2 * apart <= n {
        // Half way around, the pair of i and i + n/2 would be met twice; half of the starts are enough.
        let starts = if 2 * apart == n { apart } else { n };
        pairs.extend((0..starts).map(|i| (i, (i + apart) % n)));
        apart *= 2;
    }
    pairs
}

/// Computes the similarity of two photos' views of a point: the cosine between their rays (surfaces are not
/// perfectly diffuse), times the ratio of their resolutions (for equal ratios, patches of the same size in
/// pixels show the same piece of the surface).
fn similarity(a: &PointPatch, b: &PointPatch) -> f64 {
    let resolution = (a.px_per_unit / b.px_per_unit).min(b.px_per_unit / a.px_per_unit);
    a.towards_camera.dot(b.towards_camera).max(0.0) * resolution
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_photos_are_compared_each_with_each_and_many_with_some() {
        for n in 0..5 {
            let mut pairs: Vec<_> = pairs_of(n).into_iter().map(|(i, j)| (i.min(j), i.max(j))).collect();
            pairs.sort_unstable();
            let all: Vec<_> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
            assert_eq!(pairs, all, "{n} photos");
        }
        for n in 5..200 {
            let mut pairs: Vec<_> = pairs_of(n).into_iter().map(|(i, j)| (i.min(j), i.max(j))).collect();
            assert!(pairs.len() <= n * n.ilog2() as usize, "{n} photos: {} pairs", pairs.len());
            let count = pairs.len();
            pairs.sort_unstable();
            pairs.dedup();
            assert_eq!(pairs.len(), count, "{n} photos: a pair came twice");
        }
    }
}
