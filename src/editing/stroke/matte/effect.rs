//! The effect of a stroke of the matte brush on the pixels of its photo: full along its path, and fading out to its rim.

use glam::DVec2;

use crate::stroke::dabs::falloff;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::raster::Image;
use quadratura_document::stroke::{BrushMode, Stroke};

/// The effect of a stroke by pixel, 0 to 1.
pub struct StrokeEffect(Image<f32>);

impl StrokeEffect {
    /// Returns the effect of a stroke on the pixels of a picture. Its samples are joined by straight lines, along which the
    /// pressure changes evenly. Soft edges are solved, so the rim of a brush that solves is hard.
    pub fn new(stroke: &Stroke, within: PixelRect) -> Self {
        let brush = &stroke.brush;
        let hardness = if brush.mode == BrushMode::Solve { 1.0 } else { brush.hardness };
        let ends: Vec<(DVec2, f64)> = stroke
            .samples
            .iter()
            .map(|sample| (DVec2::from(sample.at), brush.radius * sample.pressure))
            .collect();
        let alone = [ends[0], ends[0]];
        let lines = || std::iter::once(&alone[..]).chain(ends.windows(2));
        let whole = lines().map(|line| bounds(line, within)).fold(PixelRect::EMPTY, |a, b| a.hull(&b));
        let mut effects = Image::filled(whole, 0.0);
        for line in lines() {
            for (x, y) in bounds(line, within).pixels() {
                let share = share_of_radius(line, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                if let Some(effect) = effects.get_mut(x, y) {
                    *effect = f32::max(*effect, falloff(share, hardness) as f32);
                }
            }
        }
        Self(effects)
    }

    /// Returns the effect on a pixel, which the opacity of the brush scales.
    pub fn at(&self, x: i32, y: i32) -> f32 {
        self.0.get(x, y).copied().unwrap_or(0.0)
    }

    /// Returns the pixels with an effect.
    pub fn pixels(&self) -> Spans {
        Spans::of_pixels(self.0.rect(), |x, y| self.at(x, y) > 0.0)
    }
}

/// Returns the pixels of a picture that the brush may reach between two positions with their radii.
fn bounds(line: &[(DVec2, f64)], within: PixelRect) -> PixelRect {
    let low = line.iter().map(|(at, radius)| *at - *radius).reduce(DVec2::min).unwrap_or_default().floor();
    let high = line.iter().map(|(at, radius)| *at + *radius).reduce(DVec2::max).unwrap_or_default().ceil();
    PixelRect::from_edges(low.x as i32, low.y as i32, high.x as i32, high.y as i32).intersection(&within)
}

/// Returns the distance of a point from a line, as a share of the radius that the brush has there.
fn share_of_radius(line: &[(DVec2, f64)], point: DVec2) -> f64 {
    let ((from, first), (to, last)) = (line[0], line[1]);
    let along = to - from;
    // Both ends may be the same.
    let place = ((point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(from + place * along) / (first + place * (last - first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_document::stroke::{Brush, STROKE_VERSION, StrokeSample, StrokeView};

    fn effect(mode: BrushMode, hardness: f64, samples: &[([f64; 2], f64)]) -> StrokeEffect {
        let photo = closed_form::two_quads().photo();
        let brush = Brush { mode, radius: 10.0, hardness, opacity: 1.0, colour: [0; 3] };
        let samples = samples.iter().map(|(at, pressure)| StrokeSample { at: *at, pressure: *pressure });
        let stroke = Stroke {
            version: STROKE_VERSION,
            view: StrokeView::new(&photo.camera, &photo.pose),
            brush,
            source: None,
            layer: None,
            samples: samples.collect(),
        };
        StrokeEffect::new(&stroke, PixelRect::of_size(100, 80))
    }

    #[test]
    fn the_effect_is_full_within_the_hardness_and_fades_out_to_the_radius() {
        let soft = effect(BrushMode::SeeThrough, 0.5, &[([20.5, 40.5], 1.0), ([60.5, 40.5], 1.0)]);
        let across: Vec<f32> = (0..=10).map(|off| soft.at(40, 40 + off)).collect();
        assert!(across[..=5].iter().all(|effect| *effect == 1.0), "{across:?}");
        assert!(across[5..].windows(2).all(|pair| pair[0] > pair[1]), "{across:?}");
        // Half-way between the full effect and none.
        assert!((soft.at(40, 47) + soft.at(40, 48) - 1.0).abs() < 1e-6, "{across:?}");
        assert_eq!((across[10], soft.at(40, 90), soft.at(8, 40)), (0.0, 0.0, 0.0));
        assert!(soft.pixels().holds(40, 49) && !soft.pixels().holds(40, 50));
    }

    #[test]
    fn a_brush_that_solves_has_a_hard_rim_and_pressure_scales_the_radius() {
        let solve = effect(BrushMode::Solve, 0.0, &[([20.5, 40.5], 1.0), ([60.5, 40.5], 0.5)]);
        assert!(solve.pixels().iter().all(|(y, run)| run.clone().all(|x| solve.at(x, y) == 1.0)));
        let reach = |x: i32| (0..20).take_while(|off| solve.at(x, 40 + off) > 0.0).count();
        assert_eq!([reach(20), reach(40), reach(60)], [10, 8, 5]);
        let one = effect(BrushMode::Solid, 1.0, &[([-4.0, -4.0], 1.0)]);
        assert!(!one.pixels().is_empty() && one.at(0, 0) == 1.0, "what is outside of the photo is cut off");
    }
}
