//! Finding the mattes of a photo's see-through objects from how likely its pixels show them.

use glam::Vec3;
use rayon::prelude::*;

use super::compare::CANDIDATES;
use super::{ClosedForm, Known, Matte, closed_form, foreground};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::raster::box_filter::box_range;
use quadratura_base::task::Task;
use quadratura_projection::sources::LEAST_MATTE;
use quadratura_view::srgb::Srgb;

/// What is known of a photo's pixels at see-through objects, all for one rectangle in photo pixels.
pub struct Likely<'a> {
    /// The photo's colours, linear light, full range 1.
    pub colours: &'a Image<Vec3>,
    /// The see-through objects at a pixel, as in [`super::Evidence`].
    pub candidates: &'a Image<[u16; CANDIDATES]>,
    /// The logarithm of the odds that a pixel shows one of them, from its colour.
    pub log_odds: &'a Image<f32>,
    /// Whether it is known what is behind.
    pub is_predicted: &'a Image<bool>,
    /// The logarithm of the odds that each candidate is at a pixel, from the other photos' silhouettes.
    pub expected: &'a Image<[f32; CANDIDATES]>,
}

/// Options of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FindOptions {
    /// Options of the solution in the band.
    pub closed_form: ClosedForm,
    /// The weight of the other photos' silhouettes against the colours.
    pub silhouettes: f32,
    /// The logarithm of the odds from which on a pixel is decided; the others are solved.
    pub decided: f32,
    /// The logarithm of the odds from which on a pixel tells of those nearby.
    pub likely: f32,
}

impl Default for FindOptions {
    fn default() -> Self {
        let closed_form = ClosedForm { residual: 1e-3, flat: 1e-5, guess: 0.03, ..ClosedForm::default() };
        Self { closed_form, silhouettes: 1.3, decided: 2.0, likely: 1.5 }
    }
}

/// The logarithm of odds by which a farther object must be expected more than a nearer one to be the one that is shown.
const RATHER: f32 = 0.7;

/// The reach in pixels within which likely pixels tell of unlikely ones.
const NEARBY: usize = 8;

/// The share of likely pixels within that reach from which on a pixel is known where nothing was expected behind it.
const LEAST_LIKELY: f32 = 0.25;

/// Finds the mattes of the objects with these names. Objects that the photo does not show get none.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn find_mattes(
    likely: &Likely,
    names: &[&str],
    options: &FindOptions,
    task: &Task,
) -> Result<Vec<Matte>> {
    let found = JointMatte::new(likely, options, task)?;
    let rects = found.rects(names.len());
    let of_object = |((index, name), rect): ((u16, &&str), Option<PixelRect>)| {
        rect.map(|rect| found.matte(name, index, rect))
    };
    Ok((1..).zip(names).zip(rects).filter_map(of_object).collect())
}

/// The matte of all see-through objects together.
struct JointMatte<'a> {
    likely: &'a Likely<'a>,
    alpha: Image<f32>,
    /// The objects' own colours.
    own: Image<Vec3>,
    /// What is known of the matte.
    known: Vec<Known>,
}

impl<'a> JointMatte<'a> {
    fn new(likely: &'a Likely<'a>, options: &FindOptions, task: &Task) -> Result<Self> {
        let rect = likely.colours.rect();
        let odds = odds(likely, options);
        let means = mean(&odds, likely.colours.size(), 1);
        let beyond = |index: usize, least: f32| match (odds[index], means[index]) {
            _ if likely.candidates.pixels()[index][0] == 0 => Some(0.0),
            (own, mean) if own > least && mean > 0.67 * least => Some(1.0),
            (own, mean) if own < -least && mean < -0.67 * least => Some(0.0),
            _ => None,
        };
        let decided: Vec<Option<f32>> = (0..odds.len()).map(|index| beyond(index, options.decided)).collect();
        let likely_one = |index: usize| f32::from(u8::from(beyond(index, options.likely).is_some()));
        let share: Vec<f32> = (0..odds.len()).map(likely_one).collect();
        let share = mean(&share, likely.colours.size(), NEARBY);
        let known = |index: usize| match (likely.is_predicted.pixels()[index], decided[index]) {
            (false, _) if share[index] < LEAST_LIKELY => Known::Unknown,
            (_, Some(_)) => Known::Found,
            (_, None) => Known::Solved,
        };
        let known: Vec<Known> = (0..odds.len()).map(known).collect();
        let guess = Image::new(rect, odds.iter().map(|odds| 1.0 / (1.0 + (-odds).exp())).collect());
        let decided = Image::new(rect, decided);
        let solve = || closed_form(likely.colours, &decided, Some(&guess), &options.closed_form, task);
        let alpha = task.timed("solve mattes", solve)?;
        let own = task.timed("matte foreground", || foreground(likely.colours, &alpha).front);
        Ok(Self { likely, alpha, own, known })
    }

    /// Returns the rectangles in which the photo shows something of the surfaces of the first `count` objects; `None` where it
    /// shows nothing of one. All objects are looked at together, since there may be thousands.
    fn rects(&self, count: usize) -> Vec<Option<PixelRect>> {
        let mut rects: Vec<Option<PixelRect>> = vec![None; count];
        for (at, ((x, y), candidates)) in self.likely.candidates.iter().enumerate() {
            for index in candidates.iter().filter(|index| **index != 0) {
                if self.of_object(at, *index).1 != Known::NotShown {
                    let rect = &mut rects[usize::from(*index) - 1];
                    let pixel = PixelRect::of_pixel(x, y);
                    *rect = Some(rect.map_or(pixel, |rect| rect.union(&pixel)));
                }
            }
        }
        rects
    }

    /// Returns the matte of one object in its rectangle.
    fn matte(&self, name: &str, index: u16, rect: PixelRect) -> Matte {
        let Likely { colours, candidates, .. } = self.likely;
        let within = candidates.rect();
        let of_pixel = |at: (i32, i32)| self.of_object(within.offset(at.0, at.1), index);
        let known = Image::from_fn(rect, |at| of_pixel(at).1);
        let texels = Image::from_fn(rect, |(x, y)| {
            let at = within.offset(x, y);
            let (alpha, _) = self.of_object(at, index);
            let light = if alpha == 255 { colours.pixels()[at] } else { self.own.pixels()[at] };
            let [r, g, b] = light.to_array().map(|light| Srgb::tables().encoded(light));
            [r, g, b, alpha]
        });
        Matte { object: name.to_owned(), texels, known }
    }

    /// Returns the matte of an object at a pixel, and what is known of it.
    fn of_object(&self, at: usize, index: u16) -> (u8, Known) {
        let candidates = self.likely.candidates.pixels()[at];
        let Some(place) = candidates.iter().position(|candidate| *candidate == index) else {
            return (255, Known::NotShown);
        };
        let alpha = in_255ths(self.alpha.pixels()[at]);
        let owner = owner(candidates, self.likely.expected.pixels()[at]);
        match self.known[at] {
            // Nobody sees through the nearest one then.
            Known::NotShown | Known::Unknown if place == 0 => (255, Known::Unknown),
            Known::NotShown | Known::Unknown => (255, Known::NotShown),
            known if place < owner => (0, known),
            known if place == owner => (alpha, known),
            known if alpha == 0 => (0, known),
            _ => (255, Known::NotShown),
        }
    }
}

/// Returns which of the candidates a pixel shows if it shows one of them: the nearest, unless others see none there and one
/// behind it.
fn owner(candidates: [u16; CANDIDATES], expected: [f32; CANDIDATES]) -> usize {
    let others = (1..CANDIDATES).filter(|place| candidates[*place] != 0);
    let rather = others.filter(|place| expected[*place] > expected[0].min(0.0) + RATHER);
    let best = rather.max_by(|a, b| expected[*a].total_cmp(&expected[*b]));
    best.filter(|_| expected[0] < 0.0).unwrap_or(0)
}

/// Returns the logarithm of the odds that pixels show one of their candidates, from colour and silhouettes.
fn odds(likely: &Likely, options: &FindOptions) -> Vec<f32> {
    let odds = |index: usize| {
        let candidates = likely.candidates.pixels()[index];
        let expected = likely.expected.pixels()[index].into_iter().zip(candidates);
        let expected = expected.filter(|(_, candidate)| *candidate != 0).map(|(expected, _)| expected);
        let expected = expected.reduce(f32::max).unwrap_or(0.0);
        likely.log_odds.pixels()[index] + options.silhouettes * expected
    };
    (0..likely.log_odds.pixels().len()).into_par_iter().map(odds).collect()
}

/// Returns the means of the values within a reach, row by row.
fn mean(values: &[f32], [width, height]: [usize; 2], reach: usize) -> Vec<f32> {
    let along = |index: usize| {
        let (row, columns) = (index / width * width, box_range(index % width, width, reach));
        let count = columns.len() as f32;
        values[row + columns.start..row + columns.end].iter().sum::<f32>() / count
    };
    let rows: Vec<f32> = (0..values.len()).into_par_iter().map(along).collect();
    let across = |index: usize| {
        let lines = box_range(index / width, height, reach);
        let count = lines.len() as f32;
        lines.map(|y| rows[y * width + index % width]).sum::<f32>() / count
    };
    (0..values.len()).into_par_iter().map(across).collect()
}

/// Returns a matte in 255ths; close to its ends ([`LEAST_MATTE`]) it is 0 or 255.
fn in_255ths(alpha: f32) -> u8 {
    match alpha {
        alpha if alpha < LEAST_MATTE => 0,
        alpha if alpha > 1.0 - LEAST_MATTE => 255,
        alpha => (alpha * 255.0).round() as u8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x: 20, y: 10, w: 60, h: 40 };
    const LEAF: Vec3 = Vec3::new(0.05, 0.2, 0.03);
    const WALL: Vec3 = Vec3::new(0.6, 0.5, 0.4);

    /// A photo of a leaf with a soft edge: alpha of a disc of 12 pixels about the middle.
    fn leaf() -> (Image<Vec3>, Image<f32>) {
        let alpha = Image::from_fn(RECT, |(x, y)| {
            let far = ((x - 50) as f32).hypot((y - 30) as f32);
            ((14.0 - far) / 4.0).clamp(0.0, 1.0)
        });
        (alpha.map(|alpha| LEAF * *alpha + WALL * (1.0 - *alpha)), alpha)
    }

    fn found(
        odds: impl Fn(f32) -> f32,
        is_predicted: bool,
        candidates: [u16; CANDIDATES],
        expected: [f32; CANDIDATES],
    ) -> Vec<Matte> {
        let (colours, alpha) = leaf();
        let likely = Likely {
            colours: &colours,
            candidates: &Image::filled(RECT, candidates),
            log_odds: &alpha.map(|alpha| odds(*alpha)),
            is_predicted: &Image::filled(RECT, is_predicted),
            expected: &Image::filled(RECT, expected),
        };
        let options = FindOptions::default();
        find_mattes(&likely, &["oak", "elm"], &options, &Task::silent()).unwrap()
    }

    /// The odds where colours tell what is certain, and nothing in the band.
    fn certain(alpha: f32) -> f32 {
        match alpha {
            0.0 => -5.0,
            1.0 => 5.0,
            _ => 0.0,
        }
    }

    #[test]
    fn the_edge_of_a_leaf_is_found_with_the_leafs_own_colour() {
        let (colours, truth) = leaf();
        let mattes = found(certain, true, [1, 0, 0], [0.0; 3]);
        let [oak] = &mattes[..] else { panic!("one object is shown, {} mattes", mattes.len()) };
        assert_eq!((&oak.object[..], oak.texels.rect()), ("oak", RECT));
        let mut off = Vec::new();
        for ((at, texel), alpha) in oak.texels.iter().zip(truth.pixels()) {
            off.push((f32::from(texel[3]) / 255.0 - alpha).abs());
            let light = Vec3::from_array([0, 1, 2].map(|c| Srgb::tables().linear(texel[c])));
            if texel[3] > 90 {
                assert!((light - LEAF).abs().max_element() < 0.1, "{at:?}: {light} at alpha {}", texel[3]);
            }
            if texel[3] == 255 {
                let own = colours.get(at.0, at.1).unwrap().to_array();
                assert_eq!(texel[..3], own.map(|light| Srgb::tables().encoded(light)));
            }
        }
        let mean = off.iter().sum::<f32>() / off.len() as f32;
        // Guesses of one half in the band, with their weight of 0.03, leave a step of 8 bits; the colours of the edge are exact.
        assert!(mean < 0.02, "{mean}");
    }

    #[test]
    fn where_nothing_tells_the_matte_stays_solid_and_is_counted_and_silhouettes_tell_enough() {
        let [oak] = &found(|_| 0.0, false, [1, 0, 0], [0.0; 3])[..] else { panic!("one object is shown") };
        let shares = oak.shares();
        assert_eq!((shares.unknown, shares.pixels()), (RECT.area(), RECT.area()));
        assert!(oak.texels.pixels().iter().all(|texel| texel[3] == 255));
        let [oak] = &found(|_| 0.0, false, [1, 0, 0], [-3.0, 0.0, 0.0])[..] else { panic!("it is shown") };
        assert_eq!(oak.shares().clear, RECT.area());
    }

    #[test]
    fn of_two_objects_behind_each_other_the_one_is_shown_that_others_expect() {
        let mattes = found(certain, true, [1, 2, 0], [-2.0, 2.0, 0.0]);
        let [oak, elm] = &mattes[..] else { panic!("two objects are shown, {} mattes", mattes.len()) };
        assert_eq!(oak.shares().clear, RECT.area());
        assert!(elm.shares().solid > 200, "{:?}", elm.shares());
        let [oak, elm] = &found(certain, true, [1, 2, 0], [0.5, 0.0, 0.0])[..] else { panic!("two again") };
        assert!(oak.shares().solid > 200, "{:?}", oak.shares());
        // Where the nearer one is seen through, nothing of the farther one is there either.
        assert_eq!((elm.shares().solid, elm.shares().clear), (0, oak.shares().clear));
    }
}
