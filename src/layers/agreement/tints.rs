//! Colours of a reduced photo, prepared for comparison, at several levels of detail.

use glam::DVec2;
use rayon::prelude::*;

use super::shown::ShownPixels;

/// The least value of linear light that enters a logarithm, white being 1; below it, noise and haze decide.
const BLACK: f32 = 0.01;

/// The weight of a difference of hue relative to one of brightness: shadows change brightness more than hue.
const HUE: f32 = 2.0;

/// Steps of a stored component per natural logarithm.
const STEPS: f32 = 2048.0;

/// The component that says that a pixel shows no surface.
const NONE: i16 = i16::MIN;

/// The radius, in pixels of a level, within which colours count as shown at a point: it covers errors of the model that
/// remain after relief.
const REACH: usize = 2;

/// The number of levels: photos up to sixteen times as far away are compared.
pub(super) const LEVELS: usize = 5;

/// A colour prepared for comparison: the logarithm of the brightness, and those of red and of blue over green, each
/// weighted, in 2048ths.
pub type Tint = [i16; 3];

/// The levels of detail of a photo, each half the last.
#[derive(Clone)]
pub struct TintLevels(Vec<TintLevel>);

/// One level of detail.
#[derive(Clone)]
struct TintLevel {
    size: [usize; 2],
    /// The pixels within whose reach something is shown; what follows is kept of these alone.
    near: ShownPixels,
    tints: Vec<Tint>,
    /// The least and the largest components within the reach of each pixel.
    low: Vec<Tint>,
    high: Vec<Tint>,
}

impl TintLevels {
    /// Makes the levels from linear light (full range 1) of each pixel, row by row; `None` where it shows no surface.
    pub fn new(size: [usize; 2], mut light: Vec<Option<[f32; 3]>>) -> Self {
        let mut size = size;
        let mut levels = vec![TintLevel::new(size, &light)];
        while levels.len() < LEVELS && size.iter().all(|side| *side > 1) {
            (size, light) = half(size, &light);
            levels.push(TintLevel::new(size, &light));
        }
        Self(levels)
    }

    /// Returns the colour at a position in pixels of the reduced photo, at a level of detail.
    pub fn tint(&self, px: DVec2, level: usize) -> Tint {
        let (level, at) = self.place(px, level);
        level.near.place(at).map_or([NONE; 3], |place| level.tints[place])
    }

    /// Returns the brightness at a position, as a natural logarithm; `None` where no surface is shown.
    pub fn brightness(&self, px: DVec2, level: usize) -> Option<f32> {
        let [brightness, ..] = self.tint(px, level);
        (brightness != NONE).then(|| f32::from(brightness) / STEPS)
    }

    /// Returns the distance of a colour, as a natural logarithm, from the bounding box of the colours around a position;
    /// 0 where one of both shows no surface.
    pub fn distance(&self, tint: Tint, px: DVec2, level: usize) -> f32 {
        let (level, at) = self.place(px, level);
        let Some(place) = level.near.place(at).filter(|_| tint[0] != NONE) else { return 0.0 };
        let (low, high) = (level.low[place], level.high[place]);
        let beyond = |c: usize| {
            let [tint, low, high] = [tint[c], low[c], high[c]].map(i32::from);
            (low - tint).max(tint - high).max(0) as f32 / STEPS
        };
        [0, 1, 2].map(|c| beyond(c) * beyond(c)).iter().sum::<f32>().sqrt()
    }

    fn place(&self, px: DVec2, level: usize) -> (&TintLevel, usize) {
        let level = level.min(self.0.len() - 1);
        let px = px / f64::from(1u32 << level);
        let level = &self.0[level];
        let [width, height] = level.size;
        (level, (px.y as usize).min(height - 1) * width + (px.x as usize).min(width - 1))
    }
}

impl TintLevel {
    fn new(size: [usize; 2], light: &[Option<[f32; 3]>]) -> Self {
        let tints: Vec<Tint> = light.par_iter().map(|light| light.map_or([NONE; 3], tint_of)).collect();
        let low = extremes(size, &tints, |a, b| a.min(b));
        let high = extremes(size, &tints, |a, b| a.max(b));
        let near = ShownPixels::new(low.iter().map(|low| low[0] != NONE));
        let kept = |of_all: Vec<Tint>| near.iter().map(|at| of_all[at]).collect();
        let [tints, low, high] = [tints, low, high].map(kept);
        Self { size, near, tints, low, high }
    }
}

/// Returns the extreme components within the reach of each pixel: along rows, then along columns.
fn extremes([width, height]: [usize; 2], tints: &[Tint], pick: fn(i16, i16) -> i16) -> Vec<Tint> {
    let join = |a: Tint, b: Tint| match (a[0] == NONE, b[0] == NONE) {
        (_, true) => a,
        (true, _) => b,
        _ => [0, 1, 2].map(|c| pick(a[c], b[c])),
    };
    let range = |at: usize, side: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(side);
    let along = |y: usize| {
        let row = &tints[y * width..(y + 1) * width];
        (0..width).map(|x| row[range(x, width)].iter().copied().fold([NONE; 3], join)).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<Tint>> = (0..height).into_par_iter().map(along).collect();
    let down = |y: usize| {
        let rows = &rows[range(y, height)];
        (0..width).map(|x| rows.iter().map(|row| row[x]).fold([NONE; 3], join)).collect::<Vec<_>>()
    };
    (0..height).into_par_iter().flat_map_iter(down).collect()
}

/// Halves light: the mean of the pixels that show a surface. Odd sides round up.
fn half([width, height]: [usize; 2], light: &[Option<[f32; 3]>]) -> ([usize; 2], Vec<Option<[f32; 3]>>) {
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let mean = |at: usize| {
        let (x, y) = (2 * (at % size[0]), 2 * (at / size[0]));
        let pixels = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let shown = pixels.into_iter().filter(|(x, y)| *x < width && *y < height);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for light in shown.filter_map(|(x, y)| light[y * width + x]) {
            (0..3).for_each(|c| sum[c] += light[c]);
            count += 1.0;
        }
        (count > 0.0).then(|| sum.map(|sum| sum / count))
    };
    (size, (0..size[0] * size[1]).into_par_iter().map(mean).collect())
}

/// Converts linear light, full range 1.
fn tint_of(light: [f32; 3]) -> Tint {
    let [r, g, b] = light.map(|light| light.max(BLACK).ln());
    let stored = |value: f32| (value * STEPS).round().clamp(f32::from(NONE + 1), f32::from(i16::MAX)) as i16;
    [(r + g + b) / 3.0, HUE * (r - g), HUE * (b - g)].map(stored)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes levels of 8 x 8 pixels of one colour, but for the pixel 2, 2.
    fn spot(ground: f32, spot: [f32; 3]) -> TintLevels {
        let light = |at: usize| Some(if at == 18 { spot } else { [ground; 3] });
        TintLevels::new([8, 8], (0..64).map(light).collect())
    }

    #[test]
    fn half_the_light_is_a_logarithm_away_and_another_hue_counts_more() {
        let apart = |a: [f32; 3], b: [f32; 3]| {
            let tint = tint_of(a);
            TintLevels::new([1, 1], vec![Some(b)]).distance(tint, DVec2::splat(0.5), 0)
        };
        // A step of a 2048th.
        assert!((apart([0.4; 3], [0.2; 3]) - 2.0_f32.ln()).abs() < 1e-3);
        assert!(apart([0.4, 0.2, 0.2], [0.2; 3]) > apart([0.4; 3], [0.2; 3]));
        assert!(apart([0.001; 3], [0.009; 3]) == 0.0, "both are black");
    }

    #[test]
    fn a_colour_two_pixels_away_is_shown_and_three_pixels_away_is_not() {
        let levels = spot(0.1, [0.9, 0.1, 0.1]);
        let red = tint_of([0.9, 0.1, 0.1]);
        assert_eq!(levels.distance(red, DVec2::new(4.5, 4.5), 0), 0.0);
        assert!(levels.distance(red, DVec2::new(5.5, 4.5), 0) > 1.0);
        assert_eq!(
            levels.distance(tint_of([0.1; 3]), DVec2::new(2.5, 2.5), 0),
            0.0,
            "its neighbours show it"
        );
        assert_ne!(levels.tint(DVec2::new(2.5, 2.5), 0), levels.tint(DVec2::new(2.5, 2.5), 3));
    }

    #[test]
    fn what_shows_no_surface_contradicts_nothing() {
        let levels = TintLevels::new([2, 2], vec![None; 4]);
        assert_eq!(levels.distance(tint_of([0.5; 3]), DVec2::ONE, 0), 0.0);
        assert_eq!(spot(0.2, [0.2; 3]).distance([NONE; 3], DVec2::ONE, 0), 0.0);
    }
}
