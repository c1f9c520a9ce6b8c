//! Statistics of how the pixels of layers have changed, which tell what was done to all of them at once.

use serde::Serialize;

use quadratura_base::raster::in_8_bits;
use quadratura_document::paint::PaintColour;

/// The largest deviation from one curve, in steps of 8 bits, as a root mean square: rounding and noise of conversions
/// are less, other pictures much more.
const NEAR_CURVE: f64 = 4.0;
/// The share of the change, as a root mean square, that one curve leaves at most where it explains the change.
const UNEXPLAINED: f64 = 0.5;
/// The largest change, in steps of 8 bits, as a root mean square, that is called a little: noise, grain and slight filters.
const LITTLE: f64 = 12.0;
/// The share of the pixels that have to agree about what was done.
const NEARLY_ALL: f64 = 0.95;
/// The number of levels.
const LEVELS: usize = 256;

/// What was done to most pixels at once, as far as the pixels tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeKind {
    /// They were erased.
    Erased,
    /// Their opacity is another one, and their colours are as they were.
    Opacity,
    /// The colours have changed by one curve per channel.
    Curve,
    /// All of them have changed a little, and by no curve.
    Little,
    /// Anything else.
    Other,
}

impl ChangeKind {
    /// Returns the sentence that says what was found.
    pub fn found(self) -> &'static str {
        match self {
            Self::Erased => "they are erased",
            Self::Opacity => "their opacity is another one, and their colours are as they were",
            Self::Curve => {
                "the colours have changed by one curve, as by levels, gamma or another colour profile"
            }
            Self::Little => {
                "each has changed a little, as by noise, a blur, sharpening, lossy compression or another precision"
            }
            Self::Other => {
                "a filter on all layers, other colours, or another document of the same size do that"
            }
        }
    }
}

/// For each level of a channel before: the number, sum and sum of squares of the levels after.
#[derive(Debug, Clone, Default)]
pub struct Tones {
    /// Three channels of 256 levels, or empty.
    levels: Vec<[u64; 3]>,
    /// The number of pixels, of those that are erased, and of those of which only the opacity has changed.
    pixels: u64,
    erased: u64,
    only_opacity: u64,
}

impl Tones {
    /// Adds a pixel that was visible before; where it was erased it has no colour.
    pub fn add(&mut self, before: PaintColour, after: PaintColour) {
        self.pixels += 1;
        if after[3] == 0 {
            self.erased += 1;
            return;
        }
        self.only_opacity += u64::from(before[3] != after[3] && before[..3] == after[..3]);
        self.levels.resize(3 * LEVELS, [0; 3]);
        for channel in 0..3 {
            let level = &mut self.levels[channel * LEVELS + usize::from(in_8_bits(before[channel]))];
            let after = u64::from(in_8_bits(after[channel]));
            *level = [level[0] + 1, level[1] + after, level[2] + after * after];
        }
    }

    /// Returns the sum of both.
    pub fn with(mut self, other: &Self) -> Self {
        self.levels.resize(self.levels.len().max(other.levels.len()), [0; 3]);
        let pairs = self.levels.iter_mut().zip(&other.levels);
        pairs.for_each(|(sum, other)| (0..3).for_each(|i| sum[i] += other[i]));
        self.pixels += other.pixels;
        self.erased += other.erased;
        self.only_opacity += other.only_opacity;
        self
    }

    /// Returns what was done to the pixels.
    pub fn kind(&self) -> ChangeKind {
        let nearly_all = |count: u64| count as f64 > NEARLY_ALL * self.pixels as f64;
        if nearly_all(self.erased) {
            return ChangeKind::Erased;
        }
        if nearly_all(self.only_opacity) {
            return ChangeKind::Opacity;
        }
        let (change, scatter) = self.change_and_scatter();
        match () {
            () if scatter < NEAR_CURVE && scatter < UNEXPLAINED * change => ChangeKind::Curve,
            () if change < LITTLE && self.pixels > 0 => ChangeKind::Little,
            () => ChangeKind::Other,
        }
    }

    /// Returns how much the levels have changed, and how far they lie from one curve, both in steps of 8 bits as root mean
    /// squares.
    fn change_and_scatter(&self) -> (f64, f64) {
        let (mut count, mut changed, mut scattered) = (0.0, 0.0, 0.0);
        let levels = self.levels.iter().zip((0..LEVELS).cycle()).filter(|(level, _)| level[0] > 0);
        for (level, before) in levels {
            let ([number, sum, squares], before) = (level.map(|value| value as f64), before as f64);
            count += number;
            changed += squares - 2.0 * before * sum + before * before * number;
            scattered += squares - sum * sum / number;
        }
        let root = |squares: f64| (squares / f64::max(count, 1.0)).max(0.0).sqrt();
        (root(changed), root(scattered))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    /// The statistics of random pixels that an edit changes.
    fn tones(mut edit: impl FnMut([f64; 3]) -> [f64; 3]) -> Tones {
        let mut rng = Rng::new(3);
        let mut tones = Tones::default();
        for _ in 0..5000 {
            let before = [0; 3].map(|_: i32| rng.between(0.0, 255.0).floor());
            let colour = |rgb: [f64; 3]| {
                let [r, g, b] = rgb.map(|value| (257.0 * value.clamp(0.0, 255.0).round()) as u16);
                [r, g, b, u16::MAX]
            };
            tones.add(colour(before), colour(edit(before)));
        }
        tones
    }

    #[test]
    fn a_gamma_is_a_curve_and_a_saturation_or_another_picture_is_none() {
        assert_eq!(tones(|rgb| rgb.map(|value| 255.0 * (value / 255.0).powf(1.8))).kind(), ChangeKind::Curve);
        let gains = |[r, g, b]: [f64; 3]| [0.9 * r, g, 1.3 * b];
        assert_eq!(tones(gains).with(&tones(gains)).kind(), ChangeKind::Curve);
        assert_eq!(tones(|[r, g, b]| [g, b, r]).kind(), ChangeKind::Other);
        assert_eq!(tones(|[r, g, b]| [(r + g + b) / 3.0; 3]).kind(), ChangeKind::Other);
        assert_eq!(Tones::default().kind(), ChangeKind::Other);
    }

    #[test]
    fn noise_is_no_curve_however_faint_it_is_and_a_curve_with_noise_is_one() {
        for amplitude in [1.5, 4.0, 12.0] {
            let mut rng = Rng::new(11);
            let noisy = |rgb: [f64; 3]| rgb.map(|value| value + rng.between(-amplitude, amplitude));
            assert_eq!(tones(noisy).kind(), ChangeKind::Little, "{amplitude}");
        }
        let mut rng = Rng::new(12);
        let darker = |rgb: [f64; 3]| rgb.map(|value| 0.8 * value + rng.between(-2.0, 2.0));
        assert_eq!(tones(darker).kind(), ChangeKind::Curve);
    }

    #[test]
    fn another_opacity_and_erased_pixels_are_told_from_colours() {
        let kind = |after: &dyn Fn(PaintColour) -> PaintColour| {
            let mut tones = Tones::default();
            for i in 0..400u16 {
                let before = [40_503, 30_011, 52_711].map(|factor: u16| i.wrapping_mul(factor));
                let before = [before[0], before[1], before[2], u16::MAX];
                tones.add(before, after(before));
            }
            tones.kind()
        };
        assert_eq!(kind(&|[r, g, b, a]| [r, g, b, a / 2]), ChangeKind::Opacity);
        assert_eq!(kind(&|_| [u16::MAX, u16::MAX, u16::MAX, 0]), ChangeKind::Erased);
        assert_eq!(kind(&|[r, g, b, a]| [b, r, g, a / 2]), ChangeKind::Other);
    }
}
