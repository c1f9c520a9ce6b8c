//! Which photos give the colour of a surface point, and which of their colours is taken.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::donor::Donor;
use super::painted::{Paint, Word};
use super::surfaces::SurfaceId;
use super::{MOST_CONFIDENCE, Origin};
use crate::geometry::Plane;
use crate::projection::exposure::Optics;
use crate::projection::exposure::optics::radius2;
use crate::projection::weights::{Claim, angle_at, border, octaves_missing, pixels_per_unit};
use crate::projection::{Blend, Gains, PhotoId};
use crate::raster::robust;

/// So many photos are asked for a point at most: from the sixth on they change the median no more, and some
/// of the best may be hidden there.
const MOST_GIVERS: usize = 12;

/// From so many colours on their median is meaningful.
const MEDIAN_FROM: usize = 4;

/// How far photos that show the same usually are apart, as a natural logarithm: a sixth.
const USUAL_SPREAD: f32 = 0.15;

/// Two paints whose colours are further apart than this, as a natural logarithm, are not of one picture: twice
/// what photos that show the same usually are.
const DISSENT: f32 = 2.0 * USUAL_SPREAD;

/// What is shown by one photo alone agrees with nothing: as much as two that are a usual spread apart.
const AGREEMENT_ALONE: f32 = 0.5;

/// The blackest that a colour's logarithm tells apart: below, noise decides.
const BLACK: f32 = 2e-3;

/// Where colours are asked for: a small neighbourhood on a surface.
pub struct Place<'a> {
    /// The surface.
    pub surface: SurfaceId,
    /// Its plane, in world coordinates.
    pub plane: Plane,
    /// Its back is asked for.
    pub back: bool,
    /// From where it is looked at; its penalty is the angle between the rays (see `projection::weights`).
    pub viewpoint: DVec3,
    /// Photos whose ray leans more against the viewpoint's give nothing, in radians.
    pub most_angle: f64,
    /// Pixels along a world unit that are wanted.
    pub density: f64,
    /// Points of the neighbourhood, its middle first.
    pub probes: &'a [DVec3],
}

/// A photo that may give at a place.
pub struct Giver<'a> {
    photo: PhotoId,
    donor: &'a Donor,
    item: u32,
    paint: Option<&'a Paint>,
    penalty: f64,
    level: usize,
    /// Its pixels along one that is wanted, 1 at most.
    ratio: f32,
    /// Takes its colours to the common exposure.
    factor: [f32; 3],
    /// What is undone before: what its own camera does to the photo that is filled, the seam takes up.
    optics: Optics,
}

/// The colour of a surface point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Linear light in the common exposure.
    pub colour: [f32; 3],
    /// 0 to [`MOST_CONFIDENCE`].
    pub confidence: f32,
    /// Which photo's it is.
    pub photo: PhotoId,
    /// Somebody painted it there.
    pub painted: bool,
}

impl Given {
    /// Where it comes from.
    pub fn origin(&self) -> Origin {
        if self.painted { Origin::Painted(self.photo) } else { Origin::Photo(self.photo) }
    }
}

/// Paint that is offered to a place of another photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offered {
    /// The paint of the least penalty.
    pub given: Given,
    /// Another photo's paint at the same place has clearly another colour.
    pub dissent: Option<PhotoId>,
}

/// The photos that may give at a place, by rising penalty. Those that show some probe, or have paint on the
/// surface, come first.
pub fn givers<'a>(donors: &'a [(PhotoId, Arc<Donor>)], gains: &Gains, place: &Place) -> Vec<Giver<'a>> {
    let mut found: Vec<(bool, Giver)> =
        donors.iter().filter_map(|(photo, donor)| giver(*photo, donor, gains, place)).collect();
    found.sort_by(|a, b| (b.0.cmp(&a.0)).then(a.1.penalty.total_cmp(&b.1.penalty)));
    found.truncate(MOST_GIVERS);
    let mut givers: Vec<Giver> = found.into_iter().map(|(_, giver)| giver).collect();
    givers.sort_by(|a, b| a.penalty.total_cmp(&b.penalty));
    givers
}

fn giver<'a>(photo: PhotoId, donor: &'a Donor, gains: &Gains, place: &Place) -> Option<(bool, Giver<'a>)> {
    let item = donor.item(place.surface)?;
    if donor.seen(item).back != place.back {
        return None;
    }
    let seen = |point: DVec3| {
        let in_camera = donor.pose.camera_from_world(point);
        let px = donor.camera.image_from_camera(in_camera)?;
        donor.camera.rect().contains_position(px).then_some((px, in_camera.z))
    };
    let (at, (px, depth)) = place.probes.iter().find_map(|point| Some((*point, seen(*point)?)))?;
    let paint = donor.paint(item);
    let shows = place.probes.iter().filter_map(|point| seen(*point)).any(|(px, _)| donor.shows(item, px));
    let eye = donor.pose.center_in_world();
    let density = pixels_per_unit(&donor.camera, &place.plane, eye, depth);
    let angle = angle_at(at, place.viewpoint, eye);
    if angle > place.most_angle {
        return None;
    }
    let claim = Claim {
        angle,
        octaves: octaves_missing(place.density, density),
        border: border(&donor.camera, px).max(f64::EPSILON),
        confidence: 1.0,
    };
    let ratio = density / place.density;
    let giver = Giver {
        photo,
        donor,
        item,
        paint,
        penalty: claim.penalty(&Blend::default()),
        level: donor.level_for(ratio),
        ratio: ratio.min(1.0) as f32,
        optics: gains.optics[photo.0 as usize],
        factor: gains.of_photo[photo.0 as usize].map(|gain| (-gain).exp() as f32),
    };
    Some((shows || paint.is_some(), giver))
}

impl Giver<'_> {
    /// Where a point (in world coordinates, on the relief) is in its photo.
    pub fn finds(&self, point: DVec3) -> Option<DVec2> {
        self.donor.camera.image_from_camera(self.donor.pose.camera_from_world(point))
    }

    /// The paint that it has on the surface.
    pub fn paint(&self) -> Option<&Paint> {
        self.paint
    }

    /// What it says of a point: paint before what the photo shows.
    fn says(&self, index: usize, point: DVec3, coarser: usize) -> Option<Candidate> {
        let px = self.finds(point)?;
        let level = self.donor.level_for(f64::from(1u32 << (self.level + coarser)));
        let (colour, painted) = match self.paint.map_or(Word::None, |paint| paint.at(px, level)) {
            Word::Silence => return None,
            Word::Colour(colour) => (colour, true),
            Word::None if self.donor.shows(self.item, px) => (self.donor.colour(px, level), false),
            Word::None => return None,
        };
        let seen = self.optics.undone(colour.map(f64::from), radius2(&self.donor.camera, px));
        let colour = [0, 1, 2].map(|c| seen[c] as f32 * self.factor[c]);
        Some(Candidate { colour, log: colour.map(|c| c.max(BLACK).ln()), giver: index, painted })
    }

    fn gives(&self, candidate: &Candidate, agreement: f32) -> Given {
        let confidence = MOST_CONFIDENCE * agreement * self.ratio;
        let Candidate { colour, painted, .. } = *candidate;
        Given { colour, confidence, photo: self.photo, painted }
    }
}

/// One photo's colour.
#[derive(Clone, Copy, Default)]
struct Candidate {
    colour: [f32; 3],
    log: [f32; 3],
    giver: usize,
    painted: bool,
}

/// What the givers say of a point (in world coordinates, on the relief): paint, where somebody painted, because a
/// hand is not outvoted; of up to three photos the colour of the least penalty; of more the median in log colour and
/// the least penalty among those near it.
pub fn given(givers: &[Giver], point: DVec3, coarser: usize) -> Option<Given> {
    let mut candidates = [Candidate::default(); MOST_GIVERS];
    let mut count = 0;
    for (i, giver) in givers.iter().enumerate() {
        if let Some(candidate) = giver.says(i, point, coarser) {
            candidates[count] = candidate;
            count += 1;
        }
    }
    let candidates = &candidates[..count];
    let (chosen, agreement) = match (candidates.iter().position(|c| c.painted), count) {
        (Some(painted), _) => (painted, 1.0),
        (None, 0) => return None,
        (None, 1) => (0, AGREEMENT_ALONE),
        _ => chosen(candidates),
    };
    Some(givers[candidates[chosen].giver].gives(&candidates[chosen], agreement))
}

/// The paint that the givers have of a point: that of the least penalty, and whether another one contradicts it.
pub fn offered(givers: &[Giver], point: DVec3) -> Option<Offered> {
    let with_paint = givers.iter().enumerate().filter(|(_, giver)| giver.paint.is_some());
    let mut says = with_paint.filter_map(|(i, giver)| giver.says(i, point, 0)).filter(|c| c.painted);
    let first = says.next()?;
    let dissent = says.find(|other| contradict(other.colour, first.colour));
    Some(Offered {
        given: givers[first.giver].gives(&first, 1.0),
        dissent: dissent.map(|other| givers[other.giver].photo),
    })
}

/// Two paints of one place (linear light in the common exposure) are of different pictures.
pub fn contradict(a: [f32; 3], b: [f32; 3]) -> bool {
    let off = |c: usize| (a[c].max(BLACK) / b[c].max(BLACK)).ln().abs();
    (off(0) + off(1) + off(2)) / 3.0 > DISSENT
}

/// The place of the candidate that is taken, and how much the candidates agree, 0 to 1.
fn chosen(candidates: &[Candidate]) -> (usize, f32) {
    const COUNTED: &str = "two candidates at least are chosen from";
    let median = [0, 1, 2].map(|c| {
        let mut values = [0.0; MOST_GIVERS];
        candidates.iter().zip(&mut values).for_each(|(candidate, value)| *value = candidate.log[c]);
        robust::median(&mut values[..candidates.len()]).expect(COUNTED)
    });
    let mut distances = [0.0; MOST_GIVERS];
    for (candidate, distance) in candidates.iter().zip(&mut distances) {
        *distance = (0..3).map(|c| (candidate.log[c] - median[c]).abs()).sum::<f32>() / 3.0;
    }
    let mut sorted = distances;
    let spread = robust::median(&mut sorted[..candidates.len()]).expect(COUNTED);
    let agreement = 1.0 / (1.0 + (spread / USUAL_SPREAD).powi(2));
    if candidates.len() < MEDIAN_FROM {
        return (0, agreement);
    }
    // Half of them are as near as the spread; a usual one is near, too.
    let near = |place: &usize| distances[*place] <= spread.max(USUAL_SPREAD / 2.0);
    ((0..candidates.len()).find(near).unwrap_or(0), agreement)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(values: &[f32]) -> Vec<Candidate> {
        let candidate = |(giver, value): (usize, &f32)| {
            let colour = [*value; 3];
            Candidate { colour, log: colour.map(f32::ln), giver, painted: false }
        };
        values.iter().enumerate().map(candidate).collect()
    }

    #[test]
    fn paints_contradict_where_their_colours_are_clearly_others_and_not_by_a_shade() {
        assert!(contradict([0.5, 0.1, 0.1], [0.1, 0.1, 0.5]));
        assert!(!contradict([0.5, 0.5, 0.5], [0.45, 0.5, 0.55]));
        assert!(!contradict([0.0; 3], [0.002; 3]), "black is black");
    }

    #[test]
    fn of_up_to_three_the_least_penalty_is_taken_whatever_the_others_show() {
        assert_eq!(chosen(&candidates(&[0.9, 0.2, 0.21])).0, 0);
    }

    #[test]
    fn of_more_a_stray_colour_is_passed_over_even_by_the_nearest_photo() {
        let (place, agreement) = chosen(&candidates(&[0.02, 0.2, 0.21, 0.2, 0.19]));
        assert_eq!(place, 1);
        assert!(agreement > 0.9);
        assert!(chosen(&candidates(&[0.02, 0.2, 0.5, 0.9])).1 < 0.2, "they do not agree");
    }
}
