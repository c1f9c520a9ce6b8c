//! The resolution of pictures while the view moves.

use std::time::Duration;

use quadratura_view::{Quality, Shot};

/// The target time of a moving picture, in seconds: 20 a second look continuous.
const WANTED_S: f64 = 0.05;
/// The fixed time of a picture of any size, in seconds: cells, tables, reading back.
const FIXED_S: f64 = 0.008;
/// The resolutions of a moving picture, as shares of the view's sides. They are few, so that the device's buffers for a
/// size are reused.
const SCALES: [f64; 5] = [1.0, 0.75, 0.5, 0.375, 0.25];

/// The measured speed of pictures.
#[derive(Debug, Clone, Copy)]
pub struct DrawingPace {
    /// Seconds a pixel, beyond [`FIXED_S`].
    per_px_s: f64,
}

impl Default for DrawingPace {
    fn default() -> Self {
        // The initial value suits a software renderer, so that the first movement does not stall.
        Self { per_px_s: 1.5e-7 }
    }
}

impl DrawingPace {
    /// Learns from the time of a picture; only pictures of preview quality count.
    pub fn learn(&mut self, shot: &Shot, spent: Duration) {
        if shot.quality == Quality::Preview {
            let px = f64::from(shot.camera.width) * f64::from(shot.camera.height);
            let per_px_s = (spent.as_secs_f64() - FIXED_S).max(0.0) / px;
            // The average is smoothed, because loading tiles makes single pictures slow.
            self.per_px_s = 0.7 * self.per_px_s + 0.3 * per_px_s;
        }
    }

    /// Returns the highest resolution that is fast enough, or the lowest one.
    pub fn scale(&self, size_px: [u32; 2]) -> f64 {
        let px = f64::from(size_px[0]) * f64::from(size_px[1]);
        let quick = |scale: &f64| FIXED_S + self.per_px_s * px * scale * scale <= WANTED_S;
        SCALES.into_iter().find(quick).unwrap_or(SCALES[SCALES.len() - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::Pose;
    use quadratura_base::scene::synthetic::centred;

    #[test]
    fn pictures_become_smaller_when_they_are_slow_and_larger_when_they_are_quick() {
        let pose = Pose { rotation: glam::DMat3::IDENTITY, translation: glam::DVec3::ZERO };
        let shot = Shot { quality: Quality::Preview, ..Shot::new(centred(1000, 500, 500.0), pose) };
        let (mut slow, mut quick) = (DrawingPace::default(), DrawingPace::default());
        for _ in 0..30 {
            slow.learn(&shot, Duration::from_millis(300));
            quick.learn(&shot, Duration::from_millis(5));
        }
        assert_eq!(slow.scale([1000, 500]), 0.375, "0.14 of 292 ms, and 8");
        assert_eq!(slow.scale([8000, 4000]), 0.25, "the least there is");
        assert_eq!(quick.scale([8000, 4000]), 1.0);
    }
}
