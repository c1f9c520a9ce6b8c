//! Comparison of what a photo shows with what is expected behind its see-through objects.

use glam::Vec3;
use rayon::prelude::*;

use super::colour_model::{ColourModel, log_colour};
use quadratura_base::raster::Image;
use quadratura_view::srgb::Srgb;

/// The largest number of see-through objects in front of each other that are told apart.
pub const CANDIDATES: usize = 3;

/// What is expected behind a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Linear light in the photo's own exposure, full range 1.
    pub light: Vec3,
    /// How sure that is, 0 to 1.
    pub sure: f32,
}

/// What a photo shows at see-through objects, all for one rectangle in photo pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The photo's colours, linear light, full range 1.
    pub colours: Image<Vec3>,
    /// What is expected behind all candidates; `None` where nobody knows.
    pub predicted: Image<Option<Predicted>>,
    /// The indices of the see-through objects plus one whose surfaces are at a pixel in front of all others, the nearest
    /// first, then 0; 0 first where the photo shows no such surface.
    pub candidates: Image<[u16; CANDIDATES]>,
    /// The photo's exposure relative to the common one (natural logarithms).
    pub gain: Vec3,
}

/// The reach in pixels of the box of predicted colours: predictions are off by as much.
const REACH: usize = 3;

/// The distance in sRGB steps (255 are the whole range) from the predicted colours at which a pixel may as well be as
/// predicted as not: twice the usual deviation between photos of the same surface.
const UNDECIDED: f32 = 22.0;

/// The distance by which that changes by a factor e in the odds.
const STEP: f32 = 8.0;

/// The largest logarithm of odds from the distance, and from the colours. Neighbours are not independent, and models are
/// never right at the ends.
const MOST_OF_DISTANCE: f32 = 4.0;
const MOST_OF_COLOURS: f32 = 3.0;

/// A difference of log densities counts half: colours of one thing are more varied than samples of it.
const COLOUR_WEIGHT: f32 = 0.5;

/// Where a pixel is not as predicted for certain, it counts less by this share that its colour is found elsewhere in the
/// background: a stem may have the colour of a wall.
const OTHER_COLOUR: f32 = 0.6;

/// The distance from which on a pixel is certainly not as predicted.
const CERTAINLY_OTHER: f32 = 60.0;

/// The distance up to which it certainly is.
const CERTAINLY_AS_PREDICTED: f32 = 8.0;

/// The confidence of a prediction from which samples are taken: less is a single photo from far away, or the dome.
const SURE_ENOUGH: f32 = 0.25;

/// The largest number of samples of a photo for a model of colours.
const MOST_SAMPLES: usize = 8000;

/// A photo compared with the prediction.
pub struct Compared {
    /// The distance in sRGB steps from the colours that are predicted around a pixel; `NaN` where nothing is.
    distance: Image<f32>,
    /// The colours of the background, in the common exposure.
    background: ColourModel,
}

/// A log colour, in the common exposure, that is likely the object's, and the logarithm of its density among those of the
/// background.
pub type ObjectSample = (Vec3, f32);

impl Compared {
    /// Compares a photo with the prediction; `None` where nothing is known of the background's colours.
    pub fn new(evidence: &Evidence) -> Option<Self> {
        let distance = distances(evidence);
        let mut samples = Vec::new();
        let all = evidence.candidates.pixels().iter().zip(distance.pixels());
        let pixels = evidence.colours.pixels().iter().zip(evidence.predicted.pixels());
        for ((candidates, distance), (colour, predicted)) in all.zip(pixels) {
            let is_beside = candidates[0] == 0;
            if is_beside || *distance < CERTAINLY_AS_PREDICTED {
                samples.push(evidence.common(*colour));
            }
            samples
                .extend(predicted.filter(|_| !is_beside).map(|predicted| evidence.common(predicted.light)));
        }
        Some(Self { distance, background: ColourModel::fit(&thinned(&samples))? })
    }

    /// Returns log colours that are likely the objects', because they are far from what is expected with confidence: by kind
    /// of object, of which there are `kinds`. `kind` is that of a see-through object by its index plus one.
    pub fn object_samples(
        &self,
        evidence: &Evidence,
        kinds: usize,
        kind: impl Fn(u16) -> Option<usize>,
    ) -> Vec<Vec<ObjectSample>> {
        let mut samples = vec![Vec::new(); kinds];
        let all = self.distance.pixels().iter().zip(evidence.predicted.pixels());
        let pixels = evidence.colours.pixels().iter().zip(evidence.candidates.pixels());
        for ((distance, predicted), (colour, candidates)) in all.zip(pixels) {
            let is_sure = || predicted.is_some_and(|predicted| predicted.sure >= SURE_ENOUGH);
            if *distance > CERTAINLY_OTHER
                && is_sure()
                && let Some(kind) = kind(candidates[0])
            {
                samples[kind].push(evidence.common(*colour));
            }
        }
        let sample = |colour: Vec3| (colour, self.background.log_density(colour));
        samples.iter().map(|samples| thinned(samples).into_iter().map(sample).collect()).collect()
    }

    /// Returns the logarithm of the odds that a pixel shows a see-through object; 0 beside them. `model` is that of the colours
    /// of an object by its index plus one: without one the distances alone tell.
    pub fn log_odds<'a>(
        &self,
        evidence: &Evidence,
        model: impl Fn(u16) -> Option<&'a ColourModel> + Sync,
    ) -> Image<f32> {
        let odds = |index: usize| {
            let nearest = evidence.candidates.pixels()[index][0];
            if nearest == 0 {
                return 0.0;
            }
            let object = model(nearest);
            let ratio = |light: Vec3| {
                let colour = evidence.common(light);
                object.map(|object| object.log_density(colour) - self.background.log_density(colour))
            };
            let most = MOST_OF_COLOURS / COLOUR_WEIGHT;
            let of_colour = ratio(evidence.colours.pixels()[index])
                .map_or(0.0, |ratio| COLOUR_WEIGHT * ratio.clamp(-most, most));
            let Some(predicted) = evidence.predicted.pixels()[index] else { return of_colour };
            let distance = (self.distance.pixels()[index] - UNDECIDED) / STEP;
            let mut of_distance = distance.clamp(-MOST_OF_DISTANCE, MOST_OF_DISTANCE);
            if of_distance < 0.0 {
                // To be as predicted proves nothing where the object's colour is expected behind it.
                of_distance /=
                    1.0 + ratio(predicted.light).map_or(0.0, |ratio| ratio.clamp(-20.0, 20.0).exp());
            }
            let is_other = of_distance > 0.0 && of_colour < 0.0;
            let sure = predicted.sure.clamp(0.0, 1.0);
            let of_colour = if is_other { (1.0 - OTHER_COLOUR * sure) * of_colour } else { of_colour };
            of_colour + of_distance * sure.sqrt()
        };
        let pixels = (0..self.distance.pixels().len()).into_par_iter().map(odds).collect();
        Image::new(self.distance.rect(), pixels)
    }
}

impl Evidence {
    /// Returns the log colour of light of this photo in the common exposure.
    fn common(&self, light: Vec3) -> Vec3 {
        log_colour(light * (-self.gain).map(f32::exp))
    }
}

/// Fits a model to what is likely the objects' in all photos, without what is likelier the background's; `None` where there
/// is too little.
pub fn object_model(samples: &[ObjectSample]) -> Option<ColourModel> {
    let first = ColourModel::fit(&samples.iter().map(|(colour, _)| *colour).collect::<Vec<_>>())?;
    let own = samples.iter().filter(|(colour, behind)| first.log_density(*colour) > *behind);
    ColourModel::fit(&own.map(|(colour, _)| *colour).collect::<Vec<_>>())
}

/// Returns every so many samples, [`MOST_SAMPLES`] at most.
fn thinned(samples: &[Vec3]) -> Vec<Vec3> {
    samples.iter().copied().step_by(samples.len().div_ceil(MOST_SAMPLES).max(1)).collect()
}

/// Returns how far pixels are from the box of the colours that are predicted around them.
fn distances(evidence: &Evidence) -> Image<f32> {
    let rect = evidence.colours.rect();
    let [width, height] = evidence.colours.size();
    let srgb = Srgb::tables();
    let encoded = |light: Vec3| light.map(|light| f32::from(srgb.encoded(light)));
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let single = |predicted: &Option<Predicted>| predicted.map_or(none, |it| [encoded(it.light); 2]);
    let joined = |a: [Vec3; 2], b: [Vec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let single: Vec<[Vec3; 2]> = evidence.predicted.pixels().par_iter().map(single).collect();
    let along = |index: usize| {
        let (x, row) = (index % width, index / width * width);
        let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
        single[row + columns.start..row + columns.end].iter().copied().fold(none, joined)
    };
    let rows: Vec<[Vec3; 2]> = (0..single.len()).into_par_iter().map(along).collect();
    let distance = |index: usize| {
        evidence.predicted.pixels()[index]?;
        let (x, y) = (index % width, index / width);
        let lines = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
        let [low, high] = lines.map(|y| rows[y * width + x]).fold(none, joined);
        let own = encoded(evidence.colours.pixels()[index]);
        Some((own - own.clamp(low, high)).length())
    };
    let pixels = (0..single.len()).into_par_iter().map(|i| distance(i).unwrap_or(f32::NAN)).collect();
    Image::new(rect, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::synthetic::Rng;

    const RECT: PixelRect = PixelRect { x: 0, y: 0, w: 120, h: 60 };

    /// A wall with bricks, moved to the right by this many pixels.
    fn wall(x: i32, y: i32, moved: i32) -> Vec3 {
        let is_joint = (x - moved).rem_euclid(15) == 0 || y.rem_euclid(9) == 0;
        if is_joint { Vec3::new(0.25, 0.2, 0.15) } else { Vec3::new(0.6, 0.5, 0.4) }
    }

    /// A tree on the right in front of the wall, which the others see two pixels off, but not in the upper half.
    fn evidence() -> Evidence {
        let mut rng = Rng::new(9);
        let mut shade = || Vec3::new(0.04, 0.15, 0.02) * rng.between(0.5, 1.5) as f32;
        let is_tree = |x: i32| x >= 80;
        let colours = Image::from_fn(RECT, |(x, y)| if is_tree(x) { shade() } else { wall(x, y, 0) });
        let predicted = |(x, y)| (y >= 30).then(|| Predicted { light: wall(x, y, 2), sure: 0.8 });
        let predicted = Image::from_fn(RECT, predicted);
        let candidates = Image::from_fn(RECT, |(x, _)| if x < 20 { [0; 3] } else { [1, 0, 0] });
        Evidence { colours, predicted, candidates, gain: Vec3::splat(0.1) }
    }

    #[test]
    fn what_others_show_behind_is_seen_through_and_colours_tell_where_no_other_photo_shows_it() {
        let evidence = evidence();
        let compared = Compared::new(&evidence).unwrap();
        let samples = compared.object_samples(&evidence, 2, |index| Some(usize::from(index)));
        assert!(samples[0].is_empty(), "beside the tree nothing is the object's");
        let model = object_model(&samples[1]).unwrap();
        let odds = compared.log_odds(&evidence, |_| Some(&model));
        for ((x, y), odds) in odds.iter() {
            match x {
                ..20 => assert_eq!(*odds, 0.0),
                20..80 => assert!(*odds < -1.5, "{odds} at {x}, {y}"),
                _ => assert!(*odds > 1.5, "{odds} at {x}, {y}"),
            }
        }
    }

    #[test]
    fn to_be_as_predicted_proves_nothing_where_the_objects_colour_is_expected_behind_it() {
        let mut evidence = evidence();
        let model = Compared::new(&evidence).unwrap();
        let model = object_model(&model.object_samples(&evidence, 1, |_| Some(0))[0]).unwrap();
        // Behind the tree stands a hedge of the same colour.
        for (predicted, colour) in evidence.predicted.pixels_mut().iter_mut().zip(evidence.colours.pixels()) {
            *predicted = predicted.map(|predicted| Predicted { light: *colour, ..predicted });
        }
        // The hedge is not among what is known of the background.
        let wall = Compared::new(&self::evidence()).unwrap().background;
        let compared = Compared { distance: distances(&evidence), background: wall };
        let odds = compared.log_odds(&evidence, |_| Some(&model));
        assert!(*odds.get(100, 45).unwrap() > 1.5 && *odds.get(50, 45).unwrap() < -1.5);
    }
}
