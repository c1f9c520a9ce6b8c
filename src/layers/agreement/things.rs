//! What contradicted regions are: things that stand in front of what the others show, or other light on the same surfaces; and how far
//! the things go.
//!
//! Haze, glare, shadows and wet roofs change how bright a surface is. What is on it stays: where the others have a window the photo has
//! one, too. A thing covers it, and has an outline that the others do not show. A relief or a pane is shown by the others, too, a little
//! nearer or farther away (`parallax.rs`). A region is where other photos were asked; the thing
//! goes on beside it, where none was: beside the outlines of the model, on what too few others show, and into the surroundings. There its
//! own colours tell.

use glam::Vec3;
use rayon::prelude::*;

use super::parallax::shown_nearby;
use super::regions::{closed, connected, without_holes};
use super::{AgreementOptions, ContradictedRegion, ReducedPhoto, ReducedPhotos, Votes, contradicted_regions};
use crate::matte::{ColourModel, log_colour};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::PhotoId;

/// A thing that a photo alone shows, or light that it alone has.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Thing {
    /// The whole of it, without holes, in pixels of the reduced photo.
    pub pixels: Spans,
    /// The mean distance from the colours of the other photos, as a natural logarithm.
    pub distance: f32,
    /// How likely it is a thing, 0 to 1; see the module.
    pub likelihood: f32,
    /// Whether it is other light on what the others show, too: haze, glare, a shadow.
    pub is_light: bool,
}

/// The distance along rows and columns, in reduced pixels, over which structures are compared: more than photos are beside each other.
const STEP: i32 = 4;

/// The correlation of a photo's structures with those of the others above which it shows the same: half of the variance, and less.
const SAME_STRUCTURE: [f32; 2] = [0.3, 0.6];

/// The mean change of brightness over a step, as a natural logarithm, below which a surface has no structure.
const PLAIN: f32 = 0.04;

/// The deviation of the difference from the others, as a share of its mean, below which the light is another, and above which it is not.
const UNIFORM: [f32; 2] = [0.15, 0.4];

/// The distance of colours, as a natural logarithm, at which there is an outline: a quarter of the light.
const OUTLINE: f32 = 0.25;

/// The share of the boundary with an outline of the photo's own that things have; half of a thing stands before what has its colour.
const OUTLINED: [f32; 2] = [0.1, 0.5];

/// The lead of the votes against a region, on average, from which on it counts as contradicted, and fully.
const LEAD: [f32; 2] = [0.5, 2.0];

/// The correlation with other photos, at about the distance of the model, below which a region may be a thing, and from which on it is
/// a part of the site.
const SHOWN_NEARBY: [f32; 2] = [0.55, 0.8];

/// The likelihood from which on it is light.
const LIGHT: f32 = 0.6;

/// How many times as large a thing becomes at most where it goes on beside its region: more is a leak.
const MOST_GROWN: u64 = 8;

/// By how much more likely a colour has to be the thing's than that of what is around it, as a natural logarithm.
const CLEARLY: f32 = 0.7;

/// Returns what a reduced photo shows that the others contradict. `voters` are those that were asked ([`super::voters`]).
pub fn things(
    photos: &ReducedPhotos,
    id: PhotoId,
    voters: &[PhotoId],
    votes: &[Votes],
    options: &AgreementOptions,
) -> Vec<Thing> {
    let Some(photo) = &photos.photos[id.index()] else { return Vec::new() };
    let look = Look::new(photo, votes);
    let loose = AgreementOptions {
        // Two photos against one are enough for a suggestion; a person decides.
        least_against: 1.5,
        clear_lead: 0.4,
        core: options.core - 1,
        least_distance: 0.4,
        // Leaves right before the lens.
        most_share: 0.35,
        ..options.clone()
    };
    let regions = contradicted_regions(votes, look.size[0] as usize, &loose);
    let judged = |region: ContradictedRegion| {
        let mut thing = look.thing(region, options);
        let nearby = shown_nearby(photos, id, voters, &thing.pixels);
        thing.likelihood *= 1.0 - rising(nearby, SHOWN_NEARBY);
        thing
    };
    regions.into_par_iter().map(judged).collect()
}

/// A reduced photo with what others show in its place.
struct Look<'a> {
    photo: &'a ReducedPhoto,
    votes: &'a [Votes],
    size: [u32; 2],
    /// The log colour of each pixel, in the photo's own exposure.
    colours: Vec<Vec3>,
}

fn rising(value: f32, [from, to]: [f32; 2]) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn brightness(colour: Vec3) -> f32 {
    colour.element_sum() / 3.0
}

impl<'a> Look<'a> {
    fn new(photo: &'a ReducedPhoto, votes: &'a [Votes]) -> Self {
        let size = [photo.donor.camera.width, photo.donor.camera.height];
        let at = |i: usize| photo.donor.pixel(i as u32 % size[0], i as u32 / size[0]);
        let colours = (0..votes.len()).map(|i| log_colour(Vec3::from_array(at(i)))).collect();
        Self { photo, votes, size, colours }
    }

    fn whole(&self) -> PixelRect {
        PixelRect::of_size(self.size[0], self.size[1])
    }

    fn index(&self, x: i32, y: i32) -> Option<usize> {
        self.whole().index(x, y)
    }

    /// Judges a region, and finds the whole of the thing.
    fn thing(&self, region: ContradictedRegion, options: &AgreementOptions) -> Thing {
        let outlined = rising(self.outlined(&region.pixels), OUTLINED);
        let light = self.light(&region.pixels, outlined);
        let lead = rising(self.lead(&region.pixels), LEAD);
        let differs = rising(region.distance, [0.3, 0.7]);
        let likelihood =
            (1.0 - light) * (0.25 + 0.75 * outlined) * (0.4 + 0.6 * lead) * (0.5 + 0.5 * differs);
        let is_light = light >= LIGHT;
        let pixels = if is_light { region.pixels } else { self.grown(&region.pixels, options) };
        Thing { pixels, distance: region.distance, likelihood, is_light }
    }

    /// Returns how far a region has the structures that the others show in other light, 0 to 1. `outlined` says how far it has an outline
    /// of its own.
    fn light(&self, region: &Spans, outlined: f32) -> f32 {
        let known = |x: i32, y: i32| {
            let at = self.index(x, y).filter(|_| region.holds(x, y))?;
            Some((brightness(self.colours[at]), self.votes[at].expected?))
        };
        let (mut product, mut own, mut expected, mut steps) = (0.0, 0.0, 0.0, 0u32);
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0u32);
        for (x, y) in pixels(region) {
            let Some(here) = known(x, y) else { continue };
            let off = here.0 - here.1;
            (sum, squares, count) = (sum + off, squares + off * off, count + 1);
            for there in [known(x + STEP, y), known(x, y + STEP)].into_iter().flatten() {
                let [a, b] = [there.0 - here.0, there.1 - here.1];
                (product, own, expected) = (product + a * b, own + a * a, expected + b * b);
                steps += 1;
            }
        }
        if steps == 0 {
            return 0.0;
        }
        let per_step = |squares: f32| (squares / steps as f32).sqrt();
        let same = if per_step(expected) < PLAIN { 0.0 } else { product / (own * expected).sqrt().max(1e-6) };
        let mean = sum / count as f32;
        let deviation = (squares / count as f32 - mean * mean).max(0.0).sqrt();
        // Two plain surfaces have the same structure, none, where their difference is the same everywhere; with an outline of its own
        // one stands before the other.
        let is_plain = per_step(own).max(per_step(expected)) < 2.0 * PLAIN;
        let uniform = if is_plain { 1.0 - rising(deviation / mean.abs().max(1e-3), UNIFORM) } else { 0.0 };
        rising(same, SAME_STRUCTURE).max(uniform * self.same_hue(region) * (1.0 - outlined))
    }

    /// Returns whether a region differs from what is around it in brightness rather than hue, 0 to 1: light is rarely coloured.
    fn same_hue(&self, region: &Spans) -> f32 {
        let mean = |spans: &Spans| {
            let at = || pixels(spans).filter_map(|(x, y)| self.index(x, y));
            at().map(|at| self.colours[at]).sum::<Vec3>() / at().count().max(1) as f32
        };
        let around = region.grown(4).minus(&region.grown(1));
        let off = mean(region) - mean(&around);
        let hue = (off - Vec3::splat(brightness(off))).length();
        1.0 - rising(hue, [0.1, 0.3])
    }

    /// Returns the share of the boundary at which the photo has an outline that the others do not show.
    fn outlined(&self, region: &Spans) -> f32 {
        let inside = region.minus(&region.complement(region.bounds().grown(1)).grown(1));
        let rim = region.minus(&inside);
        let (mut outlines, mut all) = (0.0, 0.0);
        for (x, y) in pixels(&rim) {
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                if region.holds(x + dx, y + dy) {
                    continue;
                }
                let pair = (self.index(x - dx, y - dy), self.index(x + 3 * dx, y + 3 * dy));
                let (Some(within), Some(beyond)) = pair else { continue };
                all += 1.0;
                let own = self.colours[within].distance(self.colours[beyond]) / 3f32.sqrt();
                // What the others show inside goes over into what the photo shows outside.
                let theirs = self.votes[within]
                    .expected
                    .map_or(0.0, |expected| (expected - brightness(self.colours[beyond])).abs());
                outlines += f32::from(u8::from(own > OUTLINE && own > 1.5 * theirs));
            }
        }
        if all > 0.0 { outlines / all } else { 0.0 }
    }

    /// Returns the mean lead of the votes against a region where there are some.
    fn lead(&self, region: &Spans) -> f32 {
        let votes = pixels(region).filter_map(|(x, y)| self.index(x, y)).map(|at| self.votes[at]);
        let leads: Vec<f32> =
            votes.filter(|votes| votes.against > votes.own).map(|votes| votes.against - votes.own).collect();
        leads.iter().sum::<f32>() / leads.len().max(1) as f32
    }

    /// Returns the region with what goes on beside it where nobody confirms the photo, by colour.
    fn grown(&self, region: &Spans, options: &AgreementOptions) -> Spans {
        let bounds = region.bounds();
        let around = bounds.grown(bounds.w.max(bounds.h).max(24)).intersection(&self.whole());
        let is_confirmed =
            |at: usize| self.votes[at].own >= 1.8 && self.votes[at].own >= self.votes[at].against;
        let is_open = |x: i32, y: i32| !self.photo.donor.shows_any(x as u32, y as u32);
        let near = region.grown(options.unknown_gap + 3);
        let colour = |(x, y): (i32, i32)| Some(self.colours[self.index(x, y)?]);
        let own: Vec<Vec3> = pixels(region).filter_map(colour).collect();
        let outside = || around.pixels().filter(|(x, y)| !near.holds(*x, *y));
        // What is confirmed, and the surroundings farther away: they are what the thing stands before.
        let confirmed = outside().filter(|(x, y)| self.index(*x, *y).is_some_and(is_confirmed));
        let confirmed: Vec<Vec3> = confirmed.filter_map(colour).collect();
        let open: Vec<Vec3> = outside().filter(|(x, y)| is_open(*x, *y)).filter_map(colour).collect();
        let Some(of_thing) = ColourModel::fit(&own) else { return region.clone() };
        let behind = [ColourModel::fit(&confirmed), ColourModel::fit(&open)];
        if behind.iter().all(Option::is_none) {
            return region.clone();
        }
        let is_its = |x: i32, y: i32| {
            let Some(at) = self.index(x, y).filter(|at| !is_confirmed(*at)) else { return false };
            let colour = self.colours[at];
            let theirs = behind.iter().flatten().map(|model| model.log_density(colour));
            of_thing.log_density(colour) > theirs.fold(f32::NEG_INFINITY, f32::max) + CLEARLY
        };
        let candidates = Spans::of_pixels(around, is_its).union(region);
        let joined = closed(&candidates, 1, self.whole());
        let parts = connected(&joined, self.whole()).into_iter();
        let parts = parts.filter(|part| !part.intersection(region).is_empty());
        let grown = parts.fold(region.clone(), |all, part| all.union(&without_holes(&part)));
        if grown.count() > MOST_GROWN * region.count() { region.clone() } else { grown }
    }
}

/// Iterates over the pixels of spans: column and row.
fn pixels(spans: &Spans) -> impl Iterator<Item = (i32, i32)> {
    spans.iter().flat_map(|(y, run)| run.clone().map(move |x| (x, y)))
}
