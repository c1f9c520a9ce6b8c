//! Which photos give the colour of a surface point, and which of their colours is taken.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::MOST_CONFIDENCE;
use super::donor::Donor;
use super::surfaces::SurfaceId;
use crate::geometry::Plane;
use crate::projection::exposure::Optics;
use crate::projection::exposure::optics::radius2;
use crate::projection::weights::{Claim, angle_at, border, octaves_missing, pixels_per_unit};
use crate::projection::{Blend, Gains, PhotoId};

/// So many photos are asked for a point at most: from the sixth on they change the median no more, and some
/// of the best may be hidden there.
const MOST_GIVERS: usize = 12;

/// From so many colours on their median is meaningful.
const MEDIAN_FROM: usize = 4;

/// How far photos that show the same usually are apart, as a natural logarithm: a sixth.
const USUAL_SPREAD: f32 = 0.15;

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
}

/// The photos that may give at a place, by rising penalty. Those that show some probe come first.
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
        let (width, height) = (f64::from(donor.camera.width), f64::from(donor.camera.height));
        let inside = px.cmpge(DVec2::ZERO).all() && px.cmplt(DVec2::new(width, height)).all();
        inside.then_some((px, in_camera.z))
    };
    let (at, (px, depth)) = place.probes.iter().find_map(|point| Some((*point, seen(*point)?)))?;
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
        penalty: claim.penalty(&Blend::default()),
        level: donor.level_for(ratio),
        ratio: ratio.min(1.0) as f32,
        optics: gains.optics[photo.0 as usize],
        factor: gains.of_photo[photo.0 as usize].map(|gain| (-gain).exp() as f32),
    };
    Some((shows, giver))
}

/// One photo's colour.
#[derive(Clone, Copy, Default)]
struct Candidate {
    colour: [f32; 3],
    log: [f32; 3],
    giver: usize,
}

/// What the givers show of a point (in world coordinates, on the relief): of up to three the colour of the
/// least penalty, of more the median in log colour and the least penalty among those near it.
pub fn given(givers: &[Giver], point: DVec3, coarser: usize) -> Option<Given> {
    let mut candidates = [Candidate::default(); MOST_GIVERS];
    let mut count = 0;
    for (i, giver) in givers.iter().enumerate() {
        let donor = giver.donor;
        let px = donor.camera.image_from_camera(donor.pose.camera_from_world(point));
        if let Some(px) = px.filter(|px| donor.shows(giver.item, *px)) {
            let level = donor.level_for(f64::from(1u32 << (giver.level + coarser)));
            let seen =
                giver.optics.undone(donor.colour(px, level).map(f64::from), radius2(&donor.camera, px));
            let colour = [0, 1, 2].map(|c| seen[c] as f32 * giver.factor[c]);
            candidates[count] = Candidate { colour, log: colour.map(|c| c.max(BLACK).ln()), giver: i };
            count += 1;
        }
    }
    let candidates = &candidates[..count];
    let (chosen, agreement) = match count {
        0 => return None,
        1 => (0, AGREEMENT_ALONE),
        _ => chosen(candidates),
    };
    let giver = &givers[candidates[chosen].giver];
    let confidence = MOST_CONFIDENCE * agreement * giver.ratio;
    Some(Given { colour: candidates[chosen].colour, confidence, photo: giver.photo })
}

/// The place of the candidate that is taken, and how much the candidates agree, 0 to 1.
fn chosen(candidates: &[Candidate]) -> (usize, f32) {
    let median = [0, 1, 2].map(|c| {
        let mut values = [0.0; MOST_GIVERS];
        candidates.iter().zip(&mut values).for_each(|(candidate, value)| *value = candidate.log[c]);
        median(&mut values[..candidates.len()])
    });
    let mut distances = [0.0; MOST_GIVERS];
    for (candidate, distance) in candidates.iter().zip(&mut distances) {
        *distance = (0..3).map(|c| (candidate.log[c] - median[c]).abs()).sum::<f32>() / 3.0;
    }
    let mut sorted = distances;
    let spread = self::median(&mut sorted[..candidates.len()]);
    let agreement = 1.0 / (1.0 + (spread / USUAL_SPREAD).powi(2));
    if candidates.len() < MEDIAN_FROM {
        return (0, agreement);
    }
    // Half of them are as near as the spread; a usual one is near, too.
    let near = |place: &usize| distances[*place] <= spread.max(USUAL_SPREAD / 2.0);
    ((0..candidates.len()).find(near).unwrap_or(0), agreement)
}

/// The mean of the two in the middle where their number is even.
fn median(values: &mut [f32]) -> f32 {
    values.sort_unstable_by(f32::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(values: &[f32]) -> Vec<Candidate> {
        let candidate = |(giver, value): (usize, &f32)| {
            let colour = [*value; 3];
            Candidate { colour, log: colour.map(f32::ln), giver }
        };
        values.iter().enumerate().map(candidate).collect()
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
