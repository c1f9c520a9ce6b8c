//! Aligns by cameras that two reconstructions, or a reconstruction and a survey, have in common.

use glam::DVec3;

use quadratura_base::geometry::Similarity;
use quadratura_base::scene::synthetic::Rng;

use super::horn::similarity;

/// The transform between two lists of camera centres.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreFit {
    /// From the first centre of each pair to the second.
    pub similarity: Similarity,
    /// How far each centre is from its partner then, in units of the second.
    pub residuals: Vec<f64>,
    /// The number of centres that agree.
    pub agreeing: usize,
}

/// The least number of centres in common: three define the transform, the fourth tests it.
pub const FEWEST: usize = 4;

/// Centres agree within this share of the extent of all of them.
const NEAR: f64 = 0.02;

/// Finds the similarity that brings most first centres near to their second ones. `None` for fewer than [`FEWEST`] that
/// agree, or where these lie on one line.
pub fn from_centres(pairs: &[(DVec3, DVec3)]) -> Option<CentreFit> {
    if pairs.len() < FEWEST {
        return None;
    }
    let middle = pairs.iter().map(|pair| pair.1).sum::<DVec3>() / pairs.len() as f64;
    let mut far: Vec<f64> = pairs.iter().map(|pair| pair.1.distance(middle)).collect();
    let near = NEAR * quadratura_base::raster::robust::upper_median(&mut far)?;
    let (mut rng, mut best): (_, (usize, Option<Similarity>)) = (Rng::new(3), (0, None));
    let off = |found: &Similarity, pair: &(DVec3, DVec3)| found.apply(pair.0).distance(pair.1);
    for _ in 0..500 {
        let mut one = || pairs[rng.whole(0, pairs.len() as u32 - 1) as usize];
        let Some(found) = similarity(&[one(), one(), one()]) else { continue };
        let count = pairs.iter().filter(|pair| off(&found, pair) <= near).count();
        if count > best.0 {
            best = (count, Some(found));
        }
    }
    let mut found = best.1?;
    for _ in 0..3 {
        let agreeing: Vec<_> = pairs.iter().filter(|pair| off(&found, pair) <= near).copied().collect();
        found = similarity(&agreeing)?;
    }
    let residuals: Vec<f64> = pairs.iter().map(|pair| off(&found, pair)).collect();
    let agreeing = residuals.iter().filter(|off| **off <= near).count();
    (agreeing >= FEWEST).then_some(CentreFit { similarity: found, residuals, agreeing })
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    #[test]
    fn a_centre_that_went_astray_is_left_out_and_three_are_too_few() {
        let right =
            Similarity { scale: 40.0, rotation: DMat3::from_rotation_y(1.0), translation: DVec3::splat(6e5) };
        let mut rng = Rng::new(5);
        let mut pairs: Vec<(DVec3, DVec3)> = (0..12)
            .map(|i| DVec3::new(f64::from(i), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)))
            .map(|centre| (centre, right.apply(centre)))
            .collect();
        pairs[4].1 += DVec3::splat(90.0);
        let found = from_centres(&pairs).unwrap();
        assert_eq!(found.agreeing, 11);
        assert!(found.residuals[4] > 100.0 && found.residuals[5] < 1e-6);
        assert_eq!(from_centres(&pairs[..3]), None);
        let line: Vec<_> = (0..9).map(|i| DVec3::X * f64::from(i)).map(|p| (p, right.apply(p))).collect();
        assert_eq!(from_centres(&line), None);
    }
}
