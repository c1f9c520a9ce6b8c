//! A plain sky in the place of what photos show around the model: clear or hazy, by the formulas of Preetham, Shirley and Smits (*A
//! Practical Analytic Model for Daylight*, 1999), or overcast, which has no sun and is the brighter the higher (Moon and Spencer,
//! *Illumination from a Non-Uniform Sky*, 1942). The place of the sun and the turbidity of the air, or the clouds, are those that
//! explain best what photos show of the sky; brightness and white balance are theirs.

use glam::DVec3;
use rayon::prelude::*;

use quadratura_projection::dome::{CubeMap, Dome};

/// The least height above the horizon, as a sine, from which on photos show the sky: below are hills and houses.
const ABOVE: f64 = 0.05;

/// The sine of the angle below the horizon at which the ground has its own colour.
const BELOW: f64 = 0.2;

/// The number of directions that are looked at, at most and at least, to find the sun.
const MOST_SEEN: usize = 1500;
const LEAST_SEEN: usize = 20;

/// The elevations and azimuths of the sun that are tried, in degrees, and the turbidities of the air: 2 is clear, 10 is haze.
const ELEVATIONS: [f64; 8] = [5.0, 12.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
const AZIMUTH_STEP: usize = 15;
const TURBIDITIES: [f64; 6] = [2.0, 2.5, 3.5, 5.0, 7.0, 10.0];

/// The brightness of the zenith of overcast skies that are tried, as a multiple of the horizon's less 1: even ones, and the standard's.
const OVERCAST: [f64; 3] = [0.0, 1.0, 2.0];

/// The share of the error of an overcast sky below which a clear one is believed, which fits better in any case, having more unknowns.
const CLEARLY: f64 = 0.8;

/// How far a channel of a clear sky may be from the model's white balance, as a natural logarithm, and the largest saturation.
const UNBALANCED: f64 = 0.05;
const MOST_SATURATED: f64 = 1.3;

/// The least light that enters a logarithm: black in 8 bits.
const DARKEST: f32 = 1e-4;

/// The sun that is taken where photos show no sky: its elevation in degrees, behind the cameras, and the turbidity.
const USUAL: (f64, f64) = (40.0, 3.0);

/// The mean light of the sky, in the common exposure, where photos show none.
const USUAL_LIGHT: f64 = 0.5;

/// What a sky is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SkyKind {
    /// Without clouds.
    Clear {
        /// The direction towards the sun (world, length 1).
        towards_sun: DVec3,
        /// The turbidity of the air: 2 is clear, 10 is haze.
        turbidity: f64,
    },
    /// Covered with clouds.
    Overcast {
        /// The brightness of the zenith as a multiple of the horizon's, less 1.
        brighter: f64,
    },
}

/// The light of a sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// What it is like.
    pub kind: SkyKind,
    /// Whether photos tell it; else it is a usual one.
    pub is_estimated: bool,
    up: DVec3,
    /// The factors from the model's light to the photos', R, G, B, as natural logarithms.
    scale: [f64; 3],
    /// The photos' saturation as a share of the model's: cameras show skies paler.
    saturation: f64,
}

impl Daylight {
    /// Finds the daylight that explains what a dome made of photos shows above the horizon. `up` is the direction up, and `forwards`
    /// that in which the cameras look; both have length 1.
    pub fn estimated(seen: Option<&Dome>, up: DVec3, forwards: DVec3) -> Self {
        let samples = seen.map(|dome| samples(dome, up)).unwrap_or_default();
        let east = (forwards - up * forwards.dot(up)).try_normalize().unwrap_or(up.any_orthonormal_vector());
        let north = up.cross(east);
        let sun = |elevation: f64, azimuth: f64| {
            let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
            (east * azimuth.cos() + north * azimuth.sin()) * elevation.cos() + up * elevation.sin()
        };
        let (elevation, turbidity) = USUAL;
        let usual = |scale| {
            let kind = SkyKind::Clear { towards_sun: sun(elevation, 180.0), turbidity };
            Self { kind, is_estimated: false, up, scale, saturation: 1.0 }
        };
        if samples.len() < LEAST_SEEN {
            let plain = usual([0.0; 3]);
            let of_zenith = plain.light(up).iter().sum::<f64>() / 3.0;
            return usual([(USUAL_LIGHT / of_zenith.max(f64::MIN_POSITIVE)).ln(); 3]);
        }
        let azimuths = (0..360).step_by(AZIMUTH_STEP).map(|azimuth| azimuth as f64);
        let clear = azimuths
            .flat_map(|azimuth| ELEVATIONS.map(|elevation| sun(elevation, azimuth)))
            .flat_map(|towards_sun| TURBIDITIES.map(|turbidity| SkyKind::Clear { towards_sun, turbidity }));
        let best = |kinds: Vec<SkyKind>| {
            let fit = |kind| {
                Self { kind, is_estimated: true, up, scale: [0.0; 3], saturation: 1.0 }.fitted(&samples)
            };
            let fits: Vec<(f64, Self)> = kinds.into_par_iter().map(fit).collect();
            // Of equals the first is taken, whatever the number of threads.
            fits.into_iter().reduce(|best, other| if other.0 < best.0 { other } else { best })
        };
        let overcast = OVERCAST.map(|brighter| SkyKind::Overcast { brighter }).to_vec();
        let found = best(clear.collect()).into_iter().zip(best(overcast)).next();
        found.map_or_else(
            || usual([0.0; 3]),
            |((of_clear, clear), (of_overcast, overcast))| {
                if of_clear < CLEARLY * of_overcast { clear } else { overcast }
            },
        )
    }

    /// Returns the elevation of a sun above the horizon, in radians.
    pub fn elevation(&self, towards_sun: DVec3) -> f64 {
        towards_sun.dot(self.up).clamp(-1.0, 1.0).asin()
    }

    /// Returns the mean squared error of the logarithms, and the daylight with the brightness, saturation and white balance for which it
    /// is least. White balance is held near that of photos, since the colours of a clear sky lie on a line: any other balance would
    /// tinge what photos do not show, such as the horizon.
    fn fitted(self, samples: &[(DVec3, [f32; 3])]) -> (f64, Self) {
        let most = match self.kind {
            SkyKind::Clear { .. } => UNBALANCED,
            SkyKind::Overcast { .. } => f64::INFINITY,
        };
        let count = samples.len() as f64;
        let pairs: Vec<(Tone, Tone)> = samples
            .iter()
            .map(|(direction, light)| {
                (Tone::of(light.map(|light| f64::from(light.max(DARKEST)))), Tone::of(self.light(*direction)))
            })
            .collect();
        let brightness =
            pairs.iter().map(|(seen, model)| seen.brightness - model.brightness).sum::<f64>() / count;
        let products = |of: fn(&[f64; 3], &[f64; 3], usize) -> f64| {
            pairs
                .iter()
                .flat_map(|(seen, model)| (0..3).map(move |c| of(&seen.colour, &model.colour, c)))
                .sum::<f64>()
        };
        let squares = products(|_, model, c| model[c] * model[c]);
        let along = products(|seen, model, c| seen[c] * model[c]);
        let saturation = if squares > 0.0 { (along / squares).clamp(0.0, MOST_SATURATED) } else { 1.0 };
        let balance = [0, 1, 2].map(|c| {
            let apart = |(seen, model): &(Tone, Tone)| seen.colour[c] - saturation * model.colour[c];
            let apart = pairs.iter().map(apart).sum::<f64>();
            (apart / count).clamp(-most, most)
        });
        let error = |(seen, model): &(Tone, Tone)| {
            let brighter = seen.brightness - model.brightness - brightness;
            let apart = |c: usize| brighter + seen.colour[c] - saturation * model.colour[c] - balance[c];
            (0..3).map(|c| apart(c).powi(2)).sum::<f64>()
        };
        let scale = balance.map(|balance| brightness + balance);
        (pairs.iter().map(error).sum::<f64>() / count, Self { scale, saturation, ..self })
    }

    /// Returns the light in a direction (world) above the horizon, linear R, G, B, in the common exposure.
    pub fn light(&self, direction: DVec3) -> [f64; 3] {
        let direction = direction.normalize();
        let height = direction.dot(self.up).clamp(1e-3, 1.0);
        let (towards_sun, t) = match self.kind {
            SkyKind::Clear { towards_sun, turbidity } => (towards_sun, turbidity),
            SkyKind::Overcast { brighter } => {
                return self.scale.map(|scale| (1.0 + brighter * height) * scale.exp());
            }
        };
        let zenith = height.acos();
        let from_sun = direction.dot(towards_sun).clamp(-1.0, 1.0).acos();
        let sun = towards_sun.dot(self.up).clamp(0.0, 1.0).acos();
        let [luminance, x, y] = [0, 1, 2].map(|c| {
            let k = COEFFICIENTS[c].map(|[slope, offset]| slope * t + offset);
            let perez = |zenith: f64, from_sun: f64| {
                (1.0 + k[0] * (k[1] / zenith.cos()).exp())
                    * (1.0 + k[2] * (k[3] * from_sun).exp() + k[4] * from_sun.cos().powi(2))
            };
            at_zenith(c, t, sun) * perez(zenith, from_sun) / perez(0.0, sun)
        });
        let (luminance, y) = (luminance.max(1e-6), y.max(1e-3));
        let (big_x, big_z) = (x / y * luminance, (1.0 - x - y) / y * luminance);
        let to_rgb = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
        let rgb = to_rgb.map(|[a, b, c]| a * big_x + b * luminance + c * big_z);
        // Saturated blues lie outside of what screens show.
        let Tone { brightness, colour } = Tone::of(rgb.map(|light| light.max(0.01 * luminance)));
        [0, 1, 2].map(|c| (brightness + self.saturation * colour[c] + self.scale[c]).exp())
    }

    /// Makes the dome of this sky; below the level horizon it goes over to the ground's light.
    pub fn dome(&self, ground: Option<[f32; 3]>, side: usize) -> Dome {
        let value = |direction: DVec3| {
            let height = direction.normalize().dot(self.up);
            let above = direction - self.up * direction.dot(self.up).min(0.0);
            let sky = self.light(above.try_normalize().unwrap_or(self.up)).map(|light| light as f32);
            let below = (-height / BELOW).clamp(0.0, 1.0) as f32;
            let share = below * below * (3.0 - 2.0 * below);
            let ground = ground.unwrap_or(sky);
            ([0, 1, 2].map(|c| sky[c] + (ground[c] - sky[c]) * share), 1.0)
        };
        Dome::from_light(&CubeMap::from_directions(side, value))
    }
}

/// Light in logarithms: its mean, and how its channels differ from that.
struct Tone {
    brightness: f64,
    colour: [f64; 3],
}

impl Tone {
    fn of(light: [f64; 3]) -> Self {
        let logs = light.map(|light| light.max(f64::MIN_POSITIVE).ln());
        let brightness = logs.iter().sum::<f64>() / 3.0;
        Self { brightness, colour: logs.map(|log| log - brightness) }
    }
}

/// The coefficients A to E of Perez's formula, each by turbidity: slope and offset; for luminance and the chromaticities x and y.
const COEFFICIENTS: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

/// The chromaticities of the zenith: the factors of T^2, T and 1, each a cubic of the sun's angle from the zenith.
const ZENITH: [[[f64; 4]; 3]; 2] = [
    [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ],
    [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ],
];

/// Returns the luminance (c = 0) or a chromaticity of the zenith for a turbidity, with the sun at this angle from it.
fn at_zenith(c: usize, t: f64, sun: f64) -> f64 {
    if c == 0 {
        let chi = (4.0 / 9.0 - t / 120.0) * (std::f64::consts::PI - 2.0 * sun);
        return (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
    }
    let cubic = |[a, b, c, d]: [f64; 4]| ((a * sun + b) * sun + c) * sun + d;
    let [squared, linear, constant] = ZENITH[c - 1].map(cubic);
    squared * t * t + linear * t + constant
}

/// Returns directions in which photos show the sky, and their light.
fn samples(dome: &Dome, up: DVec3) -> Vec<(DVec3, [f32; 3])> {
    let side = 28;
    let sampler = dome.sampler();
    let direction = CubeMap::<f32>::directions(side);
    let all = (0..CubeMap::<f32>::cells(side)).map(|at| direction(at).normalize());
    let known = all.filter(|direction| direction.dot(up) > ABOVE).filter_map(|direction| {
        let [r, g, b, known] = sampler.at(direction);
        (known > 0.5).then_some((direction, [r, g, b]))
    });
    let known: Vec<_> = known.collect();
    let step = known.len().div_ceil(MOST_SEEN).max(1);
    known.into_iter().step_by(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(elevation: f64, turbidity: f64) -> Daylight {
        let sun = DVec3::new(-elevation.to_radians().cos(), 0.0, elevation.to_radians().sin());
        let kind = SkyKind::Clear { towards_sun: sun, turbidity };
        Daylight { kind, is_estimated: true, up: DVec3::Z, scale: [-3.0; 3], saturation: 1.0 }
    }

    fn sun_of(sky: &Daylight) -> DVec3 {
        match sky.kind {
            SkyKind::Clear { towards_sun, .. } => towards_sun,
            SkyKind::Overcast { .. } => panic!("{sky:?}"),
        }
    }

    #[test]
    fn a_clear_sky_is_blue_above_and_bright_around_the_sun_and_haze_is_white() {
        let clear = sky(40.0, 2.5);
        let [r, _, b] = clear.light(DVec3::Z);
        assert!(b > 2.0 * r, "{r} {b}");
        let towards = clear.light(sun_of(&clear));
        assert!(towards[1] > 3.0 * clear.light(DVec3::new(0.7, 0.0, 0.7))[1]);
        let hue = |light: [f64; 3]| light[2] / light[0];
        assert!(hue(sky(40.0, 10.0).light(DVec3::Z)) < hue([r, 0.0, b]));
        for elevation in ELEVATIONS {
            for turbidity in TURBIDITIES {
                let sky = sky(elevation, turbidity);
                for z in [0.0, 0.2, 0.9] {
                    let light = sky.light(DVec3::new(0.3, 0.4, z));
                    assert!(
                        light.iter().all(|light| light.is_finite() && *light > 0.0),
                        "{elevation} {turbidity} {z}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_sun_and_the_air_of_a_sky_are_found_from_a_part_of_it() {
        let truth = sky(30.0, 3.5);
        let value = |direction: DVec3| {
            let light = truth.light(direction).map(|light| light as f32);
            // Photos show a third of it.
            (light, if direction.y > 0.3 * direction.length() { 1.0 } else { 0.0 })
        };
        let seen = Dome::from_light(&CubeMap::from_directions(56, value));
        let found = Daylight::estimated(Some(&seen), DVec3::Z, DVec3::Y);
        assert!(found.is_estimated && sun_of(&found).angle_between(sun_of(&truth)) < 0.2, "{found:?}");
        let dome = found.dome(None, 56);
        let (expected, [r, g, b]) = (truth.light(DVec3::Z), dome.light(DVec3::Z));
        assert!([r, g, b].iter().zip(expected).all(|(a, b)| (f64::from(*a) / b).ln().abs() < 0.2));
    }

    #[test]
    fn the_horizon_below_a_pale_sky_has_no_tinge() {
        let truth = Daylight { saturation: 0.5, ..sky(70.0, 2.5) };
        let value = |direction: DVec3| {
            let is_seen = (0.3..0.7).contains(&(direction.z / direction.length()));
            (truth.light(direction).map(|light| light as f32), if is_seen { 1.0 } else { 0.0 })
        };
        let seen = Dome::from_light(&CubeMap::from_directions(56, value));
        let [r, g, b] = Daylight::estimated(Some(&seen), DVec3::Z, DVec3::Y).light(DVec3::Y);
        let (low, high) = (r.min(g).min(b), r.max(g).max(b));
        // A tenth of light is 8 of 255 in sRGB here.
        assert!(high < 1.1 * low, "{r} {g} {b}");
    }

    #[test]
    fn an_even_sky_is_overcast_and_a_black_one_black() {
        for light in [0.4f32, 0.0] {
            let seen = Dome::from_light(&CubeMap::from_directions(56, |_| ([light; 3], 1.0)));
            let found = Daylight::estimated(Some(&seen), DVec3::Z, DVec3::Y);
            assert_eq!(found.kind, SkyKind::Overcast { brighter: 0.0 });
            // Half a step of 8 bits, in linear light at this brightness.
            assert!((found.light(DVec3::Z)[1] - f64::from(light)).abs() < 4e-3, "{found:?}");
        }
    }

    #[test]
    fn the_zenith_has_light_whichever_way_is_up() {
        for seed in 0..50 {
            let angle = f64::from(seed);
            let up = DVec3::new(angle.sin(), angle.cos(), (2.0 * angle).sin()).normalize();
            let usual = Daylight::estimated(None, up, up.any_orthonormal_vector());
            let mean = usual.light(up).iter().sum::<f64>() / 3.0;
            assert!((mean - USUAL_LIGHT).abs() < 1e-6, "{up} {mean}");
        }
    }

    #[test]
    fn without_any_sky_there_is_a_usual_one_over_the_grounds_colour() {
        let usual = Daylight::estimated(None, DVec3::Z, DVec3::Y);
        assert!(!usual.is_estimated && sun_of(&usual).dot(DVec3::Y) < 0.0 && sun_of(&usual).z > 0.5);
        let dome = usual.dome(Some([0.1, 0.2, 0.1]), 56);
        let [r, g, _] = dome.light(DVec3::NEG_Z);
        assert!((r - 0.1).abs() < 0.01 && (g - 0.2).abs() < 0.01);
        let mean = dome.light(DVec3::Z).iter().sum::<f32>() / 3.0;
        assert!((mean - 0.5).abs() < 0.05, "{mean}");
    }
}
