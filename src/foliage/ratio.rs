//! Ratio images: how much brighter and how differently coloured photos show a tree than it is drawn. Near the viewpoint of a photo the
//! drawn tree is multiplied by that of the photo, cell by cell, so that it has the light and shade of the real one and keeps its own
//! leaves (after the ratio images of faces in Liu, Shan & Zhang 2001, *Expressive Expression Mapping with Ratio Images*).

use glam::{DVec2, DVec3, Vec3};

use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_view::Blend;
use quadratura_view::weights::{LEAST_ANGLE, angle_at, weights};

/// The number of cells of a ratio image, across and down.
pub const RATIO_CELLS: usize = 16;
/// The largest number of ratio images that a view blends on a tree.
pub const MOST_RATIOS: usize = 4;
/// The penalty of a photo, its angle to the view over its confidence, from which on it has no weight, in radians.
const WIDEST: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// The penalty of the nearest photo up to which the photos have their whole weight.
const WHOLE: f64 = 0.5 * WIDEST;
/// The number of blocks that show as much as is drawn which are added to those of photos, so that few blocks have little weight.
const NEUTRAL_BLOCKS: f64 = 20.0;

/// What a photo shows of a tree over what is drawn of it there in the estimated light. Ratios are of linear light, R, G, B, as natural
/// logarithms.
#[derive(Debug, Clone, PartialEq)]
pub struct RatioImage {
    /// The photo.
    pub photo: PhotoId,
    /// Its camera.
    pub camera: Pinhole,
    /// Its pose.
    pub pose: Pose,
    /// The part of the photo that the cells divide, in its pixels.
    pub rect: PixelRect,
    /// The ratio in each cell, row by row: `RATIO_CELLS * RATIO_CELLS` of them.
    pub logs: Vec<Vec3>,
    /// The ratio of all blocks together.
    pub mean: Vec3,
    /// The number of blocks of the photo that the ratios are from.
    pub blocks: f64,
    /// Their share in all blocks that were compared, above 0 to 1: the others show no foliage, so the real tree has another shape.
    pub share: f64,
}

/// The ratio images of a tree in a view.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RatiosInView {
    /// Those that count, at most [`MOST_RATIOS`].
    pub images: Vec<RatioInView>,
    /// What is added to all logarithms: the tree's mean ratio, as far as the images do not count.
    pub rest: Vec3,
}

/// A ratio image in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatioInView {
    /// Its index among those of the tree.
    pub index: usize,
    /// How much it counts; all together up to 1.
    pub weight: f64,
}

impl RatiosInView {
    /// Finds those that count for a tree with its middle there, seen from `eye` (both in the world), without those of some photos: the
    /// nearest in angle, with the weights of photos on surfaces ([`weights`]), which fade out together towards [`WIDEST`]. From
    /// elsewhere the tree has its mean ratio.
    pub fn new(ratios: &[RatioImage], middle: DVec3, eye: DVec3, without: &[PhotoId]) -> Self {
        let counts = |ratio: &RatioImage| !without.contains(&ratio.photo);
        let mean = mean(ratios.iter().filter(|ratio| counts(ratio)));
        let penalty = |ratio: &RatioImage| match counts(ratio) {
            true => (angle_at(middle, eye, ratio.pose.center_in_world()) + LEAST_ANGLE) / ratio.confidence(),
            false => f64::INFINITY,
        };
        let mut penalties: Vec<f64> = ratios.iter().map(penalty).collect();
        let nearest = penalties.iter().copied().fold(f64::INFINITY, f64::min);
        let of_all = ((WIDEST - nearest) / (WIDEST - WHOLE)).clamp(0.0, 1.0);
        // Weights reach 0 at the penalty that comes after the last one that counts: at WIDEST at the latest.
        penalties.extend([WIDEST; MOST_RATIOS + 1]);
        let blend = Blend { photos: MOST_RATIOS as u32, ..Blend::default() };
        let weights = weights(&penalties, &blend).into_iter().zip(ratios).enumerate();
        let in_view = weights.map(|(index, (weight, ratio))| RatioInView {
            index,
            weight: of_all * weight * ratio.confidence(),
        });
        let images: Vec<RatioInView> = in_view.filter(|ratio| ratio.weight > 0.0).collect();
        let left = 1.0 - images.iter().map(|ratio| ratio.weight).sum::<f64>();
        Self { images, rest: left as f32 * mean }
    }

    /// Returns the factor on the light of a point in the world.
    pub fn factor_at(&self, ratios: &[RatioImage], point: DVec3) -> Vec3 {
        let of_image =
            |RatioInView { index, weight }: &RatioInView| *weight as f32 * ratios[*index].log_at(point);
        (self.rest + self.images.iter().map(of_image).sum::<Vec3>()).exp()
    }
}

/// Returns the mean ratio of a tree in some photos.
fn mean<'a>(ratios: impl Iterator<Item = &'a RatioImage>) -> Vec3 {
    let (sum, blocks) = ratios.fold((Vec3::ZERO, NEUTRAL_BLOCKS), |(sum, blocks), ratio| {
        let weight = ratio.blocks * ratio.share;
        (sum + weight as f32 * ratio.mean, blocks + weight)
    });
    sum / blocks as f32
}

impl RatioImage {
    /// Returns the confidence in the photo, above 0 to 1.
    fn confidence(&self) -> f64 {
        self.share * self.blocks / (self.blocks + NEUTRAL_BLOCKS)
    }

    /// Returns what maps a point in the world to cells, where the first one is from (0, 0) to (1, 1): `[x, y, w]`, each a direction and
    /// an offset, so that the point is in the cell at (x/w, y/w).
    pub fn cells_from_world(&self) -> [(DVec3, f64); 3] {
        let Pinhole { fx, fy, cx, cy, .. } = self.camera;
        let PixelRect { x, y, w, h } = self.rect;
        let rows = self.pose.rotation.transpose();
        let at = self.pose.translation;
        let row = |(focal, centre): (f64, f64), (first, size): (i32, u32), (axis, at_axis): (DVec3, f64)| {
            let scale = RATIO_CELLS as f64 / f64::from(size);
            let from_first = centre - f64::from(first);
            (scale * (focal * axis + from_first * rows.z_axis), scale * (focal * at_axis + from_first * at.z))
        };
        let (across, down) = ((rows.x_axis, at.x), (rows.y_axis, at.y));
        [row((fx, cx), (x, w), across), row((fy, cy), (y, h), down), (rows.z_axis, at.z)]
    }

    /// Returns the ratio at a point in the world, as a logarithm: between the middles of cells it is interpolated, and beyond those at
    /// the border all is as there.
    fn log_at(&self, point: DVec3) -> Vec3 {
        let [x, y, w] = self.cells_from_world().map(|(along, offset)| along.dot(point) + offset);
        let last = (RATIO_CELLS - 1) as f64;
        let at = (DVec2::new(x, y) / w.max(1e-30) - 0.5).clamp(DVec2::ZERO, DVec2::splat(last));
        let low = at.floor().min(DVec2::splat(last - 1.0));
        let share = (at - low).as_vec2();
        let cell = |x: usize, y: usize| self.logs[(low.y as usize + y) * RATIO_CELLS + low.x as usize + x];
        let row = |y: usize| cell(0, y).lerp(cell(1, y), share.x);
        row(0).lerp(row(1), share.y)
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    /// The ratio image of a photo that looks at the origin from there: `log` in its left half and nothing in the right one.
    pub fn half(photo: u32, eye: DVec3, log: Vec3) -> RatioImage {
        let of_cell = |cell: usize| if cell % RATIO_CELLS < RATIO_CELLS / 2 { log } else { Vec3::ZERO };
        RatioImage {
            photo: PhotoId(photo),
            camera: centred(320, 320, 400.0),
            pose: look_at(eye, DVec3::ZERO),
            rect: PixelRect { x: 80, y: 80, w: 160, h: 160 },
            logs: (0..RATIO_CELLS * RATIO_CELLS).map(of_cell).collect(),
            mean: 0.5 * log,
            blocks: 380.0,
            share: 1.0,
        }
    }

    /// A viewpoint at this angle to the side of -y, in degrees.
    fn from_side(degrees: f64) -> DVec3 {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        10.0 * DVec3::new(sine, -cosine, 0.0)
    }

    fn at(ratios: &[RatioImage], degrees: f64, without: &[PhotoId]) -> RatiosInView {
        RatiosInView::new(ratios, DVec3::ZERO, from_side(degrees), without)
    }

    #[test]
    fn a_point_has_the_ratio_of_the_cell_that_it_falls_into() {
        let ratio = half(0, from_side(0.0), Vec3::new(0.8, 0.4, -0.2));
        // 160 pixels at a focal length of 400 are 4 units wide at a distance of 10; seen from -y, +x is right.
        let [x, y, w] = ratio.cells_from_world();
        let cell = |point: DVec3| {
            let [x, y, w] = [x, y, w].map(|(along, offset)| along.dot(point) + offset);
            DVec2::new(x / w, y / w)
        };
        assert!(cell(DVec3::ZERO).abs_diff_eq(DVec2::splat(8.0), 1e-9));
        assert!(cell(DVec3::new(-2.0, 0.0, 2.0)).abs_diff_eq(DVec2::ZERO, 1e-9));
        assert!(cell(DVec3::new(-4.0, 10.0, 4.0)).abs_diff_eq(DVec2::ZERO, 1e-9), "along the photo's ray");
        for (x, share) in [(-99.0, 1.0), (-1.0, 1.0), (0.0, 0.5), (1.0, 0.0), (99.0, 0.0)] {
            let log = ratio.log_at(DVec3::new(x, 0.3, 0.7));
            assert!(log.abs_diff_eq(share * ratio.logs[0], 1e-3), "at {x}: {log}");
        }
        // Behind the photo's camera there is some cell, too.
        assert!(ratio.log_at(DVec3::new(0.0, -30.0, 0.0)).is_finite());
    }

    #[test]
    fn near_its_viewpoint_a_photo_decides_and_from_elsewhere_the_tree_has_its_mean_ratio() {
        let ratios = [half(0, from_side(0.0), Vec3::ONE)];
        let left = DVec3::new(-1.0, 0.0, 0.0);
        let log = |degrees: f64| at(&ratios, degrees, &[]).factor_at(&ratios, left).x.ln();
        // 380 blocks and 20 neutral ones.
        let (confidence, mean) = (0.95, 0.5 * 0.95);
        let close = |found: f32, expected: f32| (found - expected).abs() < 1e-4;
        assert!(close(log(0.0), confidence + (1.0 - confidence) * mean), "{}", log(0.0));
        assert!(close(log(14.0), log(0.0)) && close(log(-14.0), log(0.0)));
        assert!(close(log(40.0), mean), "{}", log(40.0));
        // Nothing jumps on the way.
        let steps = (0..400).map(|i| (log(0.1 * f64::from(i)) - log(0.1 * f64::from(i + 1))).abs());
        assert!(steps.fold(0.0, f32::max) < 0.005);
        assert_eq!(at(&ratios, 0.0, &[PhotoId(0)]), RatiosInView::default(), "it does not predict itself");
        assert_eq!(at(&[], 0.0, &[]), RatiosInView::default());
    }

    #[test]
    fn the_nearest_photos_count_and_none_comes_or_goes_at_once() {
        let ratios: Vec<RatioImage> =
            (0..9).map(|i| half(i, from_side(6.0 * f64::from(i)), Vec3::splat(0.1 * i as f32))).collect();
        let weights = |degrees: f64| {
            let mut all = [0.0; 9];
            for RatioInView { index, weight } in at(&ratios, degrees, &[]).images {
                all[index] = weight;
            }
            all
        };
        let mut before = weights(0.0);
        for i in 1..480 {
            let now = weights(0.1 * f64::from(i));
            let sum: f64 = now.iter().sum();
            assert!(now.iter().filter(|weight| **weight > 0.0).count() <= MOST_RATIOS);
            assert!((sum - 0.95).abs() < 1e-9, "{sum}");
            let step = before.iter().zip(now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Next to its own viewpoint a photo gives way to others within a degree.
            assert!(step < 0.1, "{step} at {i}");
            before = now;
        }
        assert!(weights(24.0)[4] > 0.94, "{:?}", weights(24.0));
    }

    #[test]
    fn a_photo_that_shows_little_foliage_counts_less_than_a_farther_one_that_shows_much() {
        let doubtful = RatioImage { blocks: 20.0, share: 0.25, ..half(0, from_side(4.0), Vec3::splat(2.0)) };
        let ratios = [doubtful, half(1, from_side(20.0), Vec3::splat(0.1))];
        let RatiosInView { images, .. } = at(&ratios, 0.0, &[]);
        assert!(images.iter().all(|ratio| ratio.index == 1), "{images:?}");
    }
}
