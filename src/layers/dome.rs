//! The dome of a site (`docs/method.md`, section 7): the photos' surroundings in the common exposure, blended, and
//! what no photo shows, by push and pull on the sphere.

use glam::DVec3;
use rayon::prelude::*;

use super::agreement::directions::{DirectionPhoto, DirectionPhotos};
use quadratura_base::error::Result;
use quadratura_base::raster::robust::quantile;
use quadratura_base::task::Task;
use quadratura_projection::dome::{CubeMap, Dome, SIDES};
use quadratura_view::weights::border;

/// The distance from what is not surroundings, in reduced pixels, over which the weight of a photo rises: beside
/// outlines photos show what the model lacks.
const RAMP_PX: f32 = 8.0;

/// The difference from the mean, as a natural logarithm, at which a photo loses most of its weight.
pub const STRAY: f32 = 0.25;

/// The least light that enters a logarithm.
pub const BLACK: f32 = 0.01;

/// The least light of which a logarithm is continued: black in 8 bits, so that night continues as night.
const DARKEST: f32 = 1e-4;

/// The trust from which on a photo's colour spreads into unknown directions: less trusted ones lie beside outlines.
const SPREADS: f32 = 0.5;

/// The sine of the angle below the horizon from which on the unknown has the ground's colour: 30 degrees.
const BELOW: f64 = 0.5;

/// The sine of the angle below the horizon from which on what photos show of the ground is continued: the ground does not colour the
/// sky above it.
const GROUND: f64 = 0.15;

/// Every so many cells are looked at to find how the sky changes upwards.
const LOOKED_AT: usize = 7;

/// The least variance of the sines of elevations, below which little can be said of that; the steepest change, as a natural logarithm
/// over the whole sky; and how far it goes on beyond what photos show.
const LEAST_VARIANCE: f32 = 0.002;
const STEEPEST: f32 = 1.5;
const FARTHER: f32 = 0.3;

/// The side of the smallest cube of the pyramid but one.
const COARSEST: usize = 7;

/// What a dome is made of.
pub struct DomeContent<'a> {
    /// The photos that take part, each as far as others confirm it.
    pub photos: &'a dyn DirectionPhotos,
    /// The mean light of the ground, in the common exposure; `None` where no photo looks down.
    pub ground: Option<[f32; 3]>,
    /// The direction up.
    pub up: DVec3,
}

/// A colour with a weight, 0 unknown to 1 known.
type Weighted = ([f32; 3], f32);

/// A sum of colours with weights, and the largest trust in one of them.
#[derive(Debug, Clone, Copy, Default)]
struct LightSum {
    light: [f32; 3],
    weight: f32,
    known: f32,
}

impl LightSum {
    fn add(&mut self, light: [f32; 3], weight: f32, trust: f32) {
        (0..3).for_each(|c| self.light[c] += weight * light[c]);
        self.weight += weight;
        self.known = self.known.max(trust);
    }

    /// Returns the weighted mean as a sum of one; black where all weights are 0.
    fn mean(self) -> Self {
        let light = if self.weight > 0.0 { self.light.map(|sum| sum / self.weight) } else { self.light };
        Self { light, weight: 1.0, ..self }
    }
}

/// Makes the dome, with `side` pixels along a side of its cube; `None` where no photo shows any surroundings.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and those of reading photos back.
pub fn dome(content: &DomeContent, side: usize, task: &Task) -> Result<Option<Dome>> {
    task.check_cancelled()?;
    let blended = content.blended(side, task)?;
    if blended.values.iter().all(|(_, known)| *known <= 0.0) {
        return Ok(None);
    }
    task.check_cancelled()?;
    let known: Vec<f32> = blended.values.iter().map(|(_, known)| *known).collect();
    let spreading = known.iter().any(|known| *known > SPREADS);
    let spread = |known: f32| if spreading { (known - SPREADS).max(0.0) / (1.0 - SPREADS) } else { known };
    let values = blended.values.into_iter().map(|(light, known)| (light, spread(known))).collect();
    let mut filled = continued(CubeMap { side, values }, content.up);
    content.ground_below(&mut filled, &known);
    let values = filled.values.into_iter().zip(known).collect();
    Ok(Some(Dome::from_light(&CubeMap { side, values })))
}

impl DomeContent<'_> {
    /// Returns the photos' mean colour in all directions, and how well it is known. Photos that differ from the mean of all hardly
    /// count. The photos are read one after the other, twice.
    fn blended(&self, side: usize, task: &Task) -> Result<CubeMap<Weighted>> {
        let first = self.in_turn(side, task, |_, (_, trust)| trust * trust)?;
        let first: Vec<LightSum> = first.into_par_iter().map(LightSum::mean).collect();
        let robust = self.in_turn(side, task, |at, (light, trust)| {
            let apart = |c: usize| (light[c].max(BLACK) / first[at].light[c].max(BLACK)).ln().abs();
            let off = [0, 1, 2].map(apart).iter().sum::<f32>() / 3.0;
            trust * trust / (1.0 + (off / STRAY).powi(2)).powi(2)
        })?;
        let value = |sum: LightSum| match sum.known > 0.0 {
            true => (sum.mean().light, sum.known),
            false => ([0.0; 3], 0.0),
        };
        Ok(CubeMap { side, values: robust.into_par_iter().map(value).collect() })
    }

    /// Adds what the photos show in the direction of each cell, in the photos' order; `weight` is that of what one shows in a cell.
    fn in_turn(
        &self,
        side: usize,
        task: &Task,
        weight: impl Fn(usize, Weighted) -> f32 + Sync,
    ) -> Result<Vec<LightSum>> {
        let direction = CubeMap::<Weighted>::directions(side);
        let mut sums = vec![LightSum::default(); CubeMap::<Weighted>::cells(side)];
        for number in 0..self.photos.count() {
            task.check_cancelled()?;
            let photo = self.photos.photo(number)?;
            sums.par_iter_mut().enumerate().for_each(|(at, sum)| {
                if let Some((light, trust)) = shown(&photo, direction(at)) {
                    sum.add(light, weight(at, (light, trust)), trust);
                }
            });
        }
        Ok(sums)
    }

    /// Gives unknown directions below the horizon the ground's colour, the more the farther down.
    fn ground_below(&self, map: &mut CubeMap<[f32; 3]>, known: &[f32]) {
        let Some(ground) = self.ground else { return };
        let direction = CubeMap::<Weighted>::directions(map.side);
        map.values.par_iter_mut().zip(known).enumerate().for_each(|(at, (light, known))| {
            let below = (-direction(at).normalize().dot(self.up) / BELOW).clamp(0.0, 1.0) as f32;
            let share = below * below * (3.0 - 2.0 * below) * (1.0 - known);
            // By ratios: a bright ground begins as gradually below a night.
            let log = |light: f32| light.max(DARKEST).ln();
            *light = [0, 1, 2].map(|c| (log(light[c]) + (log(ground[c]) - log(light[c])) * share).exp());
        });
    }
}

/// Returns the light that a photo shows in a direction, and its trust there, 0 to 1; `None` where it shows no
/// surroundings.
fn shown(photo: &DirectionPhoto, direction: DVec3) -> Option<Weighted> {
    let px = photo.position(direction)?;
    let index = photo.index(px);
    let place = photo.place(index)?;
    let ramp = f32::from(photo.inside_px(index)) / RAMP_PX;
    let trust = border(&photo.camera, px) as f32 * ramp.min(1.0) * photo.agreement(place);
    let [width, height] = [photo.camera.width, photo.camera.height].map(|side| side as i32);
    let (base, share) = ((px - 0.5).floor(), px - 0.5 - (px - 0.5).floor());
    let taps = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
        let along = |step: i32, share: f64| if step > 0 { share } else { 1.0 - share };
        let at = |base: f64, step: i32, side: i32| (base as i32 + step).clamp(0, side - 1);
        let index = at(base.y, dy, height) * width + at(base.x, dx, width);
        (photo.exposed(index as usize), (along(dx, share.x) * along(dy, share.y)) as f32)
    });
    Some((mean(taps.iter().filter_map(|(light, weight)| Some(((*light)?, *weight)))), trust))
}

/// Returns the weighted mean of colours; black where all weights are 0.
fn mean(colours: impl Iterator<Item = Weighted>) -> [f32; 3] {
    let (mut sum, mut all) = ([0.0; 3], 0.0);
    for (light, weight) in colours {
        (0..3).for_each(|c| sum[c] += weight * light[c]);
        all += weight;
    }
    if all > 0.0 { sum.map(|sum| sum / all) } else { sum }
}

/// Returns a colour for every direction, those of weight 1 as they are: skies darken upwards, or brighten, and go on doing so beyond
/// what photos show; what differs from that is filled in.
fn continued(map: CubeMap<Weighted>, up: DVec3) -> CubeMap<[f32; 3]> {
    let gradient = SkyGradient::new(&map, up);
    let direction = CubeMap::<Weighted>::directions(map.side);
    let apart = |(at, (light, weight)): (usize, &Weighted)| {
        let expected = gradient.at(direction(at));
        ([0, 1, 2].map(|c| light[c].max(DARKEST).ln() - expected[c]), *weight)
    };
    let height = |at: usize| direction(at).normalize().dot(up);
    let is_known = |at: usize, weight: f32| height(at) > 0.0 && weight > 0.0;
    let has_sky = map.values.iter().enumerate().any(|(at, (_, weight))| is_known(at, *weight));
    // The one map of a site's size is gone before the other one is made.
    let sky = has_sky.then(|| {
        let above = |(at, value)| {
            let (log, weight) = apart((at, value));
            (log, if height(at) > 0.0 { weight } else { 0.0 })
        };
        filled(&CubeMap { side: map.side, values: map.values.par_iter().enumerate().map(above).collect() })
    });
    let values: Vec<Weighted> = map.values.par_iter().enumerate().map(apart).collect();
    let mut filled = filled(&CubeMap { side: map.side, values });
    if let Some(sky) = sky {
        filled.values.par_iter_mut().zip(&sky.values).zip(&map.values).enumerate().for_each(
            |(at, ((log, sky), (_, weight)))| {
                let below = (-height(at) / GROUND).clamp(0.0, 1.0) as f32;
                let share = (below * below * (3.0 - 2.0 * below)).max(*weight);
                *log = [0, 1, 2].map(|c| sky[c] + (log[c] - sky[c]) * share);
            },
        );
    }
    filled.values.par_iter_mut().zip(&map.values).enumerate().for_each(|(at, (log, (light, weight)))| {
        let expected = gradient.at(direction(at));
        let whole = [0, 1, 2].map(|c| (log[c] + expected[c]).exp());
        *log = if *weight >= 1.0 { *light } else { whole };
    });
    filled
}

/// How the sky changes upwards: the logarithm of light by the sine of the elevation.
struct SkyGradient {
    up: DVec3,
    slope: [f32; 3],
    /// The elevations, as sines, between which it changes.
    range: [f32; 2],
}

impl SkyGradient {
    /// Finds it in what photos show above the horizon.
    fn new(map: &CubeMap<Weighted>, up: DVec3) -> Self {
        let direction = CubeMap::<Weighted>::directions(map.side);
        let height = |at: usize| direction(at).normalize().dot(up) as f32;
        let known = map.values.iter().enumerate().step_by(LOOKED_AT).filter(|(_, (_, weight))| *weight > 0.0);
        let seen: Vec<(f32, [f32; 3], f32)> = known
            .map(|(at, (light, weight))| (height(at), light.map(|light| light.max(DARKEST).ln()), *weight))
            .filter(|(height, ..)| *height > 0.0)
            .collect();
        let mut heights: Vec<f32> = seen.iter().map(|(height, ..)| *height).collect();
        let mut end = |share: f64| quantile(&mut heights, share).unwrap_or(0.0);
        let range = [end(0.02), end(0.98) + FARTHER];
        let weighted = |value: &dyn Fn(f32, &[f32; 3]) -> f32| {
            let (sum, all) = seen.iter().fold((0.0, 0.0), |(sum, all), (height, log, weight)| {
                (sum + f64::from(weight * value(*height, log)), all + f64::from(*weight))
            });
            if all > 0.0 { (sum / all) as f32 } else { 0.0 }
        };
        let middle = weighted(&|height, _| height);
        let variance = weighted(&|height, _| (height - middle).powi(2));
        let slope = |c: usize| {
            let mean = weighted(&|_, log| log[c]);
            let covariance = weighted(&|height, log| (height - middle) * (log[c] - mean));
            (covariance / (variance + LEAST_VARIANCE)).clamp(-STEEPEST, STEEPEST)
        };
        Self { up, slope: [0, 1, 2].map(slope), range }
    }

    /// Returns the logarithm of light in a direction, up to a constant.
    fn at(&self, direction: DVec3) -> [f32; 3] {
        let height = direction.normalize().dot(self.up) as f32;
        let [low, high] = self.range;
        self.slope.map(|slope| slope * height.clamp(low, high.max(low)))
    }
}

/// Returns a colour for every direction, those of weight 1 as they are: averages are pulled up a pyramid of cubes
/// until they cover the sphere, and pushed down to the directions without a known value.
pub(super) fn filled(map: &CubeMap<Weighted>) -> CubeMap<[f32; 3]> {
    let above = match map.side {
        1 => {
            // Sides of which nothing is known have the mean of the others.
            let all = mean(map.values.iter().copied());
            CubeMap { side: 1, values: vec![all; SIDES] }
        }
        side => filled(&reduced(map, if side <= COARSEST { 1 } else { side / 2 })),
    };
    let direction = CubeMap::<Weighted>::directions(map.side);
    let value = |(at, (light, weight)): (usize, &Weighted)| {
        if *weight >= 1.0 {
            return *light;
        }
        let from = above.between(direction(at), |light| light);
        [0, 1, 2].map(|c| weight * light[c] + (1.0 - weight) * from[c])
    };
    CubeMap { side: map.side, values: map.values.par_iter().enumerate().map(value).collect() }
}

/// Returns the cube with fewer cells along a side: weighted means; weights add up, to 1 at most.
fn reduced(map: &CubeMap<Weighted>, side: usize) -> CubeMap<Weighted> {
    let (cells, step) = (map.side, map.side / side);
    let cell = |at: usize| {
        let (of_side, y, x) = (at / side / side, at / side % side, at % side);
        let corner = (of_side * cells + y * step) * cells + x * step;
        let below = (0..step).flat_map(|dy| (0..step).map(move |dx| map.values[corner + dy * cells + dx]));
        (mean(below.clone()), below.map(|(_, weight)| weight).sum::<f32>().min(1.0))
    };
    CubeMap { side, values: (0..SIDES * side * side).into_par_iter().map(cell).collect() }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec2};

    use super::*;
    use quadratura_base::geometry::{Pinhole, Pose};
    use std::sync::Arc;

    const CAMERA: Pinhole = Pinhole { width: 80, height: 80, fx: 40.0, fy: 40.0, cx: 40.0, cy: 40.0 };

    /// A photo that looks along a direction turned about y, in one colour; its lowest rows show a surface.
    fn photo(turn: f64, light: [f32; 3]) -> DirectionPhoto {
        let pose = Pose { rotation: DMat3::from_rotation_y(turn), translation: DVec3::ZERO };
        let shown = (0..80 * 80).map(|at| (at / 80 < 60).then_some(light));
        DirectionPhoto::new(CAMERA, pose, shown.collect())
    }

    fn made(photos: &[DirectionPhoto], ground: Option<[f32; 3]>) -> Option<Dome> {
        let photos: Vec<Arc<DirectionPhoto>> = photos.iter().cloned().map(Arc::new).collect();
        let content = DomeContent { photos: &photos, ground, up: DVec3::NEG_Y };
        dome(&content, 56, &Task::silent()).unwrap()
    }

    #[test]
    fn a_dome_shows_what_photos_show_and_something_between_them_everywhere_else() {
        let (red, blue) = ([0.5, 0.1, 0.1], [0.1, 0.1, 0.5]);
        let dome = made(&[photo(0.0, red), photo(std::f64::consts::PI, blue)], None).unwrap();
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 0.01);
        assert!(near(dome.light(DVec3::Z), red) && near(dome.light(DVec3::NEG_Z), blue));
        assert!(dome.known(DVec3::Z) > 0.99 && dome.known(DVec3::X) == 0.0);
        let [r, _, b] = dome.light(DVec3::X);
        assert!(r > 0.12 && b > 0.12, "beside both it has something of both: {r} {b}");
        // No step anywhere: along circles in several planes neighbouring directions differ little.
        for axis in [DVec3::X, DVec3::Y, DVec3::new(1.0, 2.0, 0.5).normalize()] {
            let across = axis.any_orthonormal_vector();
            let other = axis.cross(across);
            let lights: Vec<[f32; 3]> = (0..=720)
                .map(|i| f64::from(i) * std::f64::consts::TAU / 720.0)
                .map(|angle| dome.light(across * angle.cos() + other * angle.sin()))
                .collect();
            let step = lights.windows(2).flat_map(|w| [0, 1, 2].map(|c| (w[0][c] - w[1][c]).abs()));
            // A ramp over 5 % of 90 degrees has nine steps of half a degree for four tenths of light.
            assert!(step.fold(0.0, f32::max) < 0.15);
        }
    }

    #[test]
    fn a_black_sky_continues_black() {
        let dome = made(&[photo(0.0, [0.0; 3])], None).unwrap();
        // Half a step of 8 bits.
        assert!([DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z].iter().all(|d| dome.light(*d)[1] < 1.6e-4));
    }

    #[test]
    fn below_the_horizon_the_unknown_goes_over_to_the_ground() {
        let (sky, ground) = ([0.2, 0.3, 0.5], [0.3, 0.2, 0.1]);
        let dome = made(&[photo(0.0, sky)], Some(ground)).unwrap();
        let [r, _, b] = dome.light(DVec3::Y);
        assert!(r > 0.26 && b < 0.2, "straight down: {r} {b}");
        let [r, _, b] = dome.light(DVec3::NEG_Y);
        assert!(r < 0.25 && b > 0.4, "straight up: {r} {b}");
    }

    #[test]
    fn what_lies_below_the_horizon_does_not_colour_the_sky_above() {
        let (sky, ground) = ([0.4, 0.5, 0.7], [0.2, 0.1, 0.02]);
        let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        // The right half of the photo shows the ground alone: a house hides the sky.
        let shown = (0..80 * 80).map(|at| match (at / 80 >= 41, at % 80 >= 40) {
            (true, _) => Some(ground),
            (false, is_hidden) => (!is_hidden).then_some(sky),
        });
        let dome = made(&[DirectionPhoto::new(CAMERA, pose, shown.collect())], None).unwrap();
        for direction in
            [DVec3::new(0.5, -0.1, 1.0), DVec3::new(1.0, -0.2, 0.3), DVec3::new(1.0, -0.05, -1.0)]
        {
            let [r, _, b] = dome.light(direction);
            assert!((r / sky[0]).ln().abs() < 0.05 && (b / sky[2]).ln().abs() < 0.05, "{direction}: {r} {b}");
        }
        let [r, _, b] = dome.light(DVec3::new(0.5, 0.3, 1.0));
        assert!(r > 2.0 * b, "and below it the ground goes on: {r} {b}");
    }

    #[test]
    fn one_photo_that_differs_from_three_is_not_seen_and_nothing_makes_no_dome() {
        let sky = [0.4; 3];
        let mut photos: Vec<DirectionPhoto> = (0..3).map(|_| photo(0.0, sky)).collect();
        photos.push(photo(0.0, [0.02; 3]));
        let [r, ..] = made(&photos, None).unwrap().light(DVec3::Z);
        assert!((r - 0.4).abs() < 0.03, "{r}");
        let nothing = DirectionPhoto::new(CAMERA, photos[0].pose, vec![None; 80 * 80]);
        assert_eq!(made(&[nothing], None), None);
        assert_eq!(made(&[], None), None);
    }

    #[test]
    fn a_photo_has_less_weight_beside_outlines_and_at_its_border() {
        let photo = photo(0.0, [0.4; 3]);
        let trust = |x: f64, y: f64| {
            let ray = CAMERA.ray_in_camera(DVec2::new(x, y));
            shown(&photo, ray).map_or(0.0, |(_, trust)| trust)
        };
        assert_eq!(trust(40.0, 30.0), 1.0);
        assert!(trust(40.0, 58.5) < 0.3 && trust(0.3, 30.0) < 0.6 && trust(40.0, 70.0) == 0.0);
    }
}
