//! How bright sun and sky are, from blocks of photos and what they would be in known light.

use std::collections::BTreeSet;

use glam::{DMat2, DVec2, DVec3};

use quadratura_document::trees::LightStrength;
use quadratura_foliage::OutdoorLight;

/// A block of pixels of a photo on a tree. All is linear light, R, G, B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelBlock {
    /// The index of the photo.
    pub photo: usize,
    /// What the placed tree shows there in sunlight that a white surface reflects as 1.
    pub sun: DVec3,
    /// The same of skylight, with the ground that belongs to it ([`ground_of_sky`]).
    pub sky: DVec3,
    /// What the photo shows, in the photos' common exposure.
    pub light: DVec3,
}

/// The light that explains the blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// What sun, sky and ground give.
    pub strength: LightStrength,
    /// The photos that have blocks.
    pub photos: usize,
    /// The blocks that were used.
    pub blocks: usize,
    /// The root mean square of the difference between photo and tree in luminance, relative to the mean.
    pub residual: f64,
    /// True where sun and sky were told from each other; false where their ratio is the usual one.
    pub is_split: bool,
    /// How bright blocks are that were used.
    pub of_foliage: FoliageRatios,
}

/// How much brighter the sun is than the sky, in luminance, where nothing else is known.
const SUN_PER_SKY: f64 = 5.0;
/// How many blocks that is worth.
const PRIOR_BLOCKS: f64 = 100.0;
/// The number of photos from which on sun and sky are told from each other. The leaves of a tree and of its stand-in are not at the
/// same places: with few sides of them, what is lit by chance decides.
const LEAST_PHOTOS: usize = 4;
/// The factor by which a block may be brighter or darker than the median one. Foliage differs less; what differs more is sky or a
/// wall that shows between the real tree's leaves, or a stem in a gap of its stand-in.
const LARGEST_FACTOR: f64 = 4.0;

/// Returns the luminance of linear light.
pub fn luminance(light: DVec3) -> f64 {
    light.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns what the ground gives per channel where the sky gives 1: as on a clear day.
pub fn ground_of_sky() -> DVec3 {
    let day = OutdoorLight::day(DVec3::Z);
    day.ground.as_dvec3() / day.sky.as_dvec3()
}

/// Returns the usual light of the sky per channel where the sun gives 1: in the colours of a clear day.
pub fn sky_of_sun() -> DVec3 {
    let day = OutdoorLight::day(DVec3::Z);
    let (sun, sky) = (day.sun.as_dvec3(), day.sky.as_dvec3());
    sky / sun * (luminance(sun) / luminance(sky)) / SUN_PER_SKY
}

/// Returns the strength of a sun and a sky with the ground that belongs to it.
pub fn strength(sun: DVec3, sky: DVec3) -> LightStrength {
    LightStrength { sun: sun.to_array(), sky: sky.to_array(), ground: (ground_of_sky() * sky).to_array() }
}

/// Fits sun and sky to blocks; `None` where none is left that shows light.
pub fn fit(blocks: &[PixelBlock]) -> Option<Fit> {
    let usual = sky_of_sun();
    let of_foliage = FoliageRatios::of(blocks)?;
    let kept: Vec<PixelBlock> = blocks.iter().filter(|block| of_foliage.holds(block)).copied().collect();
    let photos = kept.iter().map(|block| block.photo).collect::<BTreeSet<_>>().len();
    let is_split = photos >= LEAST_PHOTOS;
    let (mut sun, mut sky) = (DVec3::ZERO, DVec3::ZERO);
    for channel in 0..3 {
        let rows: Vec<[f64; 3]> =
            kept.iter().map(|block| [block.sun[channel], block.sky[channel], block.light[channel]]).collect();
        let found = fit_channel(&rows, usual[channel], is_split);
        (sun[channel], sky[channel]) = (found.x, found.y);
    }
    let shown = |block: &PixelBlock| luminance(block.sun * sun + block.sky * sky);
    let count = kept.len() as f64;
    let mean = kept.iter().map(|block| luminance(block.light)).sum::<f64>() / count;
    let squares = kept.iter().map(|block| (luminance(block.light) - shown(block)).powi(2)).sum::<f64>();
    let residual = (squares / count).sqrt() / mean;
    Some(Fit { strength: strength(sun, sky), photos, blocks: kept.len(), residual, is_split, of_foliage })
}

/// How bright blocks are that show foliage, over what is drawn there in the usual light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoliageRatios {
    least: f64,
    most: f64,
}

impl FoliageRatios {
    /// Finds them around the median block; `None` where no block shows light.
    pub fn of(blocks: &[PixelBlock]) -> Option<Self> {
        let mut ratios: Vec<f64> =
            blocks.iter().map(ratio).filter(|ratio| *ratio > 0.0 && ratio.is_finite()).collect();
        ratios.sort_by(f64::total_cmp);
        let median = *ratios.get(ratios.len() / 2)?;
        Some(Self { least: median / LARGEST_FACTOR, most: median * LARGEST_FACTOR })
    }

    /// Returns whether a block may show foliage.
    pub fn holds(&self, block: &PixelBlock) -> bool {
        (self.least..=self.most).contains(&ratio(block))
    }
}

/// Returns how bright a block is over what is drawn there in the usual light.
fn ratio(block: &PixelBlock) -> f64 {
    luminance(block.light) / luminance(block.sun + sky_of_sun() * block.sky)
}

/// Returns sun and sky of a channel from rows of what sun and sky make and what the photo shows. The mean is always met. Where
/// they are split, both are the non-negative least squares with a prior: sun and sky in the usual ratio that meet the mean.
fn fit_channel(rows: &[[f64; 3]], usual: f64, is_split: bool) -> DVec2 {
    let mean = |value: &dyn Fn(&[f64; 3]) -> f64| rows.iter().map(value).sum::<f64>() / rows.len() as f64;
    let parts = DVec2::new(mean(&|row| row[0]), mean(&|row| row[1]));
    let light = mean(&|row| row[2]);
    let meeting = |found: DVec2| {
        let shown = found.dot(parts);
        if shown > 0.0 { found * (light / shown) } else { found }
    };
    let prior = meeting(DVec2::new(1.0, usual));
    if !is_split {
        return prior;
    }
    let (ss, sk, kk) =
        (mean(&|row| row[0] * row[0]), mean(&|row| row[0] * row[1]), mean(&|row| row[1] * row[1]));
    let right = DVec2::new(mean(&|row| row[0] * row[2]), mean(&|row| row[1] * row[2]));
    let weight = PRIOR_BLOCKS / rows.len() as f64;
    let squares = DMat2::from_cols(DVec2::new(ss * (1.0 + weight), sk), DVec2::new(sk, kk * (1.0 + weight)));
    let right = right + weight * DVec2::new(ss, kk) * prior;
    meeting(non_negative(&squares, right))
}

/// Returns the x >= 0 that minimises x . squares x / 2 - x . right.
fn non_negative(squares: &DMat2, right: DVec2) -> DVec2 {
    let alone = |axis: usize| {
        let own = squares.col(axis)[axis];
        let mut found = DVec2::ZERO;
        found[axis] = if own > 0.0 { (right[axis] / own).max(0.0) } else { 0.0 };
        found
    };
    let both = squares.inverse() * right;
    if both.is_finite() && both.min_element() >= 0.0 {
        return both;
    }
    let cost = |x: &DVec2| 0.5 * x.dot(*squares * *x) - x.dot(right);
    let [x, y] = [alone(0), alone(1)];
    if cost(&x) <= cost(&y) { x } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    /// Blocks of photos in a light; the tree in the photos has its leaves elsewhere, so that a share of each part is another
    /// block's.
    fn blocks(
        rng: &mut Rng,
        photos: usize,
        of_photo: usize,
        sun: DVec3,
        sky: DVec3,
        other: f64,
    ) -> Vec<PixelBlock> {
        let leaf = DVec3::new(0.06, 0.12, 0.03);
        let parts = |rng: &mut Rng, photo: usize| {
            // Some photos show the sunny side, some the other one.
            let lit = 0.2 + 0.6 * (photo as f64 * 2.4).sin().abs();
            [lit * rng.between(0.0, 2.0) * leaf, rng.between(0.3, 0.9) * leaf]
        };
        let mut made = Vec::new();
        for photo in 0..photos {
            for _ in 0..of_photo {
                let (own, real) = (parts(rng, photo), parts(rng, photo));
                let [s, k] = [0, 1].map(|part| (1.0 - other) * own[part] + other * real[part]);
                made.push(PixelBlock { photo, sun: own[0], sky: own[1], light: s * sun + k * sky });
            }
        }
        made
    }

    fn truth() -> (DVec3, DVec3) {
        (DVec3::new(2.4, 2.2, 1.9), DVec3::new(0.4, 0.55, 0.8))
    }

    fn mean_light(blocks: &[PixelBlock], sun: DVec3, sky: DVec3) -> DVec3 {
        blocks.iter().map(|block| block.sun * sun + block.sky * sky).sum::<DVec3>() / blocks.len() as f64
    }

    #[test]
    fn the_light_of_the_same_tree_is_found_where_photos_show_many_sides() {
        let (sun, sky) = truth();
        let found = fit(&blocks(&mut Rng::new(1), 6, 800, sun, sky, 0.0)).unwrap();
        let LightStrength { sun: s, sky: k, ground } = found.strength;
        assert_eq!((found.photos, found.is_split), (6, true));
        // 4,800 blocks against a prior of 100, which is off by some tens of per cent.
        for channel in 0..3 {
            assert!((s[channel] / sun[channel] - 1.0).abs() < 0.02, "{s:?}");
            assert!((k[channel] / sky[channel] - 1.0).abs() < 0.05, "{k:?}");
            assert!((ground[channel] / k[channel] - ground_of_sky()[channel]).abs() < 1e-12);
        }
        assert!(found.residual < 0.02, "{}", found.residual);
    }

    #[test]
    fn another_tree_of_its_kind_meets_the_mean_and_makes_the_sun_too_weak_by_what_is_elsewhere() {
        let (sun, sky) = truth();
        let blocks = blocks(&mut Rng::new(2), 8, 500, sun, sky, 0.5);
        let found = fit(&blocks).unwrap();
        let [s, k] = [found.strength.sun, found.strength.sky].map(DVec3::from_array);
        let photos = blocks.iter().map(|block| block.light).sum::<DVec3>() / blocks.len() as f64;
        let mean = mean_light(&blocks, s, k) / photos;
        assert!((mean - 1.0).abs().max_element() < 0.02, "{mean}");
        assert!((0.6..1.02).contains(&(s.y / sun.y)) && k.y > 0.9 * sky.y, "{s} {k}");
    }

    #[test]
    fn few_photos_give_the_mean_and_the_usual_ratio() {
        let (sun, sky) = truth();
        let blocks = blocks(&mut Rng::new(3), 1, 400, sun, sky, 1.0);
        let found = fit(&blocks).unwrap();
        assert!(!found.is_split);
        let [s, k] = [found.strength.sun, found.strength.sky].map(DVec3::from_array);
        assert!((luminance(s) / luminance(k) / SUN_PER_SKY - 1.0).abs() < 0.15, "{s} {k}");
        let photos = blocks.iter().map(|block| block.light).sum::<DVec3>() / blocks.len() as f64;
        assert!((mean_light(&blocks, s, k) / photos - 1.0).abs().max_element() < 0.02);
        assert!(k.z / k.x > s.z / s.x, "the sky is bluer");
    }

    #[test]
    fn sky_between_the_leaves_of_the_real_tree_hardly_counts() {
        let (sun, sky) = truth();
        let mut blocks = blocks(&mut Rng::new(4), 5, 400, sun, sky, 0.2);
        let clear = fit(&blocks).unwrap();
        // Ten times as bright as foliage is here.
        blocks.iter_mut().step_by(10).for_each(|block| block.light = DVec3::new(1.0, 1.4, 1.9));
        let with_sky = fit(&blocks).unwrap();
        let ratio = with_sky.strength.sun[1] / clear.strength.sun[1];
        // The mean of all blocks is nearly twice that of the clear ones.
        assert!((ratio - 1.0).abs() < 0.15 && with_sky.blocks < clear.blocks, "{ratio}");
    }

    #[test]
    fn no_light_is_negative_and_nothing_gives_nothing() {
        // All that the photos show is lit by the sky; the prior, 100 blocks of 5,000, says that there is a sun.
        let (sun, sky) = (DVec3::ZERO, DVec3::new(0.5, 0.6, 0.8));
        let found = fit(&blocks(&mut Rng::new(5), 5, 1000, sun, sky, 0.0)).unwrap();
        assert!(found.strength.sun.iter().all(|sun| (0.0..0.1).contains(sun)), "{:?}", found.strength);
        assert_eq!(fit(&[]), None);
        let black = PixelBlock { photo: 0, sun: DVec3::ZERO, sky: DVec3::ZERO, light: DVec3::ZERO };
        assert_eq!(fit(&[black; 9]), None);
    }
}
