//! Ranking of the donor photos for a surface point, and the choice among their colours.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::donor::Donor;
use super::painted::{Paint, PaintSample};
use super::surfaces::FillSurfaceId;
use super::{FillOrigin, MOST_CONFIDENCE};
use quadratura_base::geometry::{Plane, Pose};
use quadratura_base::raster::robust;
use quadratura_base::scene::PhotoId;
use quadratura_projection::Gains;
use quadratura_view::Blend;
use quadratura_view::optics::Optics;
use quadratura_view::optics::squared_radius;
use quadratura_view::weights::{Claim, angle_at, border, octaves_missing, pixels_per_unit};

/// The largest number of photos that are sampled for a point. From the sixth on, further photos hardly change
/// the median; the rest is a reserve because some of the best may be occluded at the point.
const MOST_DONORS: usize = 12;

/// The least number of colours for which their median is meaningful.
const MEDIAN_FROM: usize = 4;

/// The usual deviation between photos that show the same surface, as a natural logarithm: about a sixth.
const USUAL_DEVIATION: f32 = 0.15;

/// The difference, as a natural logarithm, beyond which two paints are not of the same picture: twice the
/// usual deviation between photos that show the same surface.
const DISSENT: f32 = 2.0 * USUAL_DEVIATION;

/// The agreement assumed for a colour from a single photo: as much as that of several photos with the usual
/// deviation.
pub(super) const AGREEMENT_ALONE: f32 = 0.5;

/// The least resolution of paint that replaces pixels of a photo, as a share of the photo's own at the point. At one
/// half each painted pixel takes the place of two by two pixels, one octave, as between two levels of a mipmap, which
/// bilinear interpolation still bridges; coarser paint would be a visibly blurred patch and lose what the photo shows.
const LEAST_DETAIL: f64 = 0.5;

/// The least value of linear light that enters a logarithm; below it, noise decides.
pub(super) const BLACK: f32 = 2e-3;

/// A query for colours: a small neighbourhood on a surface.
pub struct ColourQuery<'a> {
    /// The surface.
    pub surface: FillSurfaceId,
    /// The plane of the surface, in world coordinates.
    pub plane: Plane,
    /// True when the back of the surface is queried.
    pub back: bool,
    /// The viewpoint in world coordinates. Penalties contain the angle between the rays to it and to the
    /// photo's camera (see `view::weights`).
    pub viewpoint: DVec3,
    /// The largest angle between the ray of a photo and that of the viewpoint, in radians; photos beyond it
    /// are not sampled.
    pub most_angle: f64,
    /// The resolution wanted, in pixels per world unit.
    pub density: f64,
    /// Points of the neighbourhood in world coordinates, its middle first.
    pub probes: &'a [DVec3],
    /// Whether pixels close behind the outlines of nearer surfaces give nothing.
    pub clearly: bool,
}

/// A donor photo ranked for a small neighbourhood on a surface.
pub struct RankedDonor<'a> {
    photo: PhotoId,
    donor: &'a Donor,
    item: u32,
    /// Whether pixels close behind the outlines of nearer surfaces give nothing.
    clearly: bool,
    /// The pose from which the photo sees the surface.
    pose: Pose,
    paint: Option<&'a Paint>,
    penalty: f64,
    level: usize,
    /// The photo's resolution over that wanted, 1 at most.
    ratio: f32,
    /// The factor per channel that takes the photo's colours to the common exposure.
    factor: [f32; 3],
    /// The optics of the donor, undone before the factor is applied.
    optics: Optics,
}

/// A colour of a surface point taken from another photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DonatedColour {
    /// Linear light in the common exposure.
    pub colour: [f32; 3],
    /// The confidence, 0 to [`MOST_CONFIDENCE`].
    pub confidence: f32,
    /// The photo that the colour is from.
    pub photo: PhotoId,
    /// True when the colour is paint on that photo.
    pub painted: bool,
}

impl DonatedColour {
    /// Returns the source of the colour.
    pub fn origin(&self) -> FillOrigin {
        if self.painted { FillOrigin::Painted(self.photo) } else { FillOrigin::Photo(self.photo) }
    }
}

/// The paint of other photos at a point that a photo shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OfferedPaint {
    /// Paint that could be propagated.
    Fine(PaintOffer),
    /// Paint of this photo, which is too coarse to replace the pixels that are there.
    Coarse(PhotoId),
}

impl OfferedPaint {
    /// Returns the paint that could be propagated.
    pub fn fine(&self) -> Option<&PaintOffer> {
        match self {
            Self::Fine(offer) => Some(offer),
            Self::Coarse(_) => None,
        }
    }

    /// Returns the photo that was painted on.
    pub fn from(&self) -> PhotoId {
        match self {
            Self::Fine(offer) => offer.given.photo,
            Self::Coarse(photo) => *photo,
        }
    }
}

/// An offer of paint: the paint of other photos that could be propagated to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaintOffer {
    /// The paint of the least penalty.
    pub given: DonatedColour,
    /// Another photo whose paint at the same point has clearly another colour.
    pub dissent: Option<PhotoId>,
}

/// Ranks the donor photos for a neighbourhood, by rising penalty. Photos that show one of the probes or have
/// paint on the surface are preferred when there are too many.
pub fn ranked_donors<'a>(
    donors: &'a [(PhotoId, Arc<Donor>)],
    gains: &Gains,
    spot: &ColourQuery,
) -> Vec<RankedDonor<'a>> {
    let mut found: Vec<(bool, RankedDonor)> =
        donors.iter().filter_map(|(photo, donor)| rank_donor(*photo, donor, gains, spot)).collect();
    found.sort_by(|a, b| (b.0.cmp(&a.0)).then(a.1.penalty.total_cmp(&b.1.penalty)));
    found.truncate(MOST_DONORS);
    let mut ranked_donors: Vec<RankedDonor> = found.into_iter().map(|(_, ranked)| ranked).collect();
    ranked_donors.sort_by(|a, b| a.penalty.total_cmp(&b.penalty));
    ranked_donors
}

fn rank_donor<'a>(
    photo: PhotoId,
    donor: &'a Donor,
    gains: &Gains,
    spot: &ColourQuery,
) -> Option<(bool, RankedDonor<'a>)> {
    let item = donor.item(spot.surface)?;
    if donor.seen(item).back != spot.back {
        return None;
    }
    let pose = donor.pose_on(item);
    let project = |point: DVec3| {
        let in_camera = pose.camera_from_world(point);
        let px = donor.camera.image_from_camera(in_camera)?;
        donor.camera.rect().contains_position(px).then_some((px, in_camera.z))
    };
    let (point_seen, (px, depth)) = spot.probes.iter().find_map(|point| Some((*point, project(*point)?)))?;
    let paint = donor.paint(item);
    let shows = spot.probes.iter().filter_map(|point| project(*point)).any(|(px, _)| donor.shows(item, px));
    let density = pixels_per_unit(&donor.camera, &spot.plane, pose.center_in_world(), depth);
    let angle = angle_at(point_seen, spot.viewpoint, donor.seen_from(item, point_seen));
    if angle > spot.most_angle {
        return None;
    }
    let claim = Claim {
        angle,
        octaves: octaves_missing(spot.density, density),
        border: border(&donor.camera, px).max(f64::EPSILON),
        confidence: 1.0,
        agreement: 1.0,
    };
    let ratio = density / spot.density;
    let ranked = RankedDonor {
        photo,
        donor,
        item,
        clearly: spot.clearly,
        pose,
        paint,
        penalty: claim.penalty(&Blend::default()),
        level: donor.level_for(ratio),
        ratio: ratio.min(1.0) as f32,
        optics: gains.optics[photo.index()],
        factor: gains.of_photo[photo.index()].map(|gain| (-gain).exp() as f32),
    };
    Some((shows || paint.is_some(), ranked))
}

impl RankedDonor<'_> {
    /// Projects a point (world coordinates, on the relief) to pixel coordinates of the photo; `None` behind
    /// the camera.
    pub fn image_from_world(&self, point: DVec3) -> Option<DVec2> {
        self.donor.camera.image_from_camera(self.pose.camera_from_world(point))
    }

    /// Returns the photo's paint on the surface.
    pub fn paint(&self) -> Option<&Paint> {
        self.paint
    }

    /// Returns the photo's pixels per world unit at a point of a plane.
    fn density(&self, plane: &Plane, point: DVec3) -> f64 {
        let pose = &self.pose;
        pixels_per_unit(&self.donor.camera, plane, pose.center_in_world(), pose.camera_from_world(point).z)
    }

    /// Returns whether the photo shows the surface at a position.
    fn shows(&self, px: DVec2) -> bool {
        match self.clearly {
            true => self.donor.shows_clearly(self.item, px),
            false => self.donor.shows(self.item, px),
        }
    }

    /// Samples the photo at a point: paint before the photo's own pixels. Returns `None` where the paint was
    /// erased or the photo does not show the surface.
    fn sample(&self, index: usize, point: DVec3, coarser: usize) -> Option<DonorColour> {
        let px = self.image_from_world(point)?;
        let level = self.donor.level_for(f64::from(1u32 << (self.level + coarser)));
        let (colour, painted) = match self.paint.map_or(PaintSample::None, |paint| paint.at(px, level)) {
            PaintSample::Silence => return None,
            PaintSample::Colour(colour) => (colour, true),
            PaintSample::None if self.shows(px) => (self.donor.colour(px, level), false),
            PaintSample::None => return None,
        };
        let seen = self.optics.undone(colour.map(f64::from), squared_radius(&self.donor.camera, px));
        let colour = [0, 1, 2].map(|c| seen[c] as f32 * self.factor[c]);
        Some(DonorColour { colour, log: colour.map(|c| c.max(BLACK).ln()), donor_index: index, painted })
    }

    fn given_colour(&self, candidate: &DonorColour, agreement: f32) -> DonatedColour {
        let confidence = MOST_CONFIDENCE * agreement * self.ratio;
        let DonorColour { colour, painted, .. } = *candidate;
        DonatedColour { colour, confidence, photo: self.photo, painted }
    }
}

/// The colour of one photo at a point, and its logarithm.
#[derive(Clone, Copy, Default)]
pub(super) struct DonorColour {
    pub colour: [f32; 3],
    pub log: [f32; 3],
    pub donor_index: usize,
    pub painted: bool,
}

/// Chooses a colour for a point (world coordinates, on the relief) among the donors' samples. Paint wins
/// wherever there is any, because it is deliberate and must not be outvoted. Of up to three samples the one
/// of the least penalty is taken; of more, the one of the least penalty among those near the median in log
/// colour.
pub fn given(ranked_donors: &[RankedDonor], point: DVec3, coarser: usize) -> Option<DonatedColour> {
    let mut candidates = [DonorColour::default(); MOST_DONORS];
    let mut count = 0;
    for (i, ranked) in ranked_donors.iter().enumerate() {
        if let Some(candidate) = ranked.sample(i, point, coarser) {
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
    Some(ranked_donors[candidates[chosen].donor_index].given_colour(&candidates[chosen], agreement))
}

/// Returns the paint of the least penalty that is fine enough among the paint of donors at a point of a plane, and
/// whether another donor's paint contradicts it. `density` is that of the photo at the point, in pixels per world unit,
/// and `serving` are the photos that texture the surface, rising; paint of others is not offered.
pub fn offered(
    ranked_donors: &[RankedDonor],
    serving: &[PhotoId],
    plane: &Plane,
    point: DVec3,
    density: f64,
) -> Option<OfferedPaint> {
    let serves =
        |ranked: &RankedDonor| ranked.paint.is_some() && serving.binary_search(&ranked.photo).is_ok();
    let with_paint = ranked_donors.iter().enumerate().filter(|(_, ranked)| serves(ranked));
    let samples = with_paint.filter_map(|(i, ranked)| ranked.sample(i, point, 0)).filter(|c| c.painted);
    let is_fine = |sample: &DonorColour| {
        ranked_donors[sample.donor_index].density(plane, point) >= LEAST_DETAIL * density
    };
    let mut coarse = samples.clone();
    let Some(first) = samples.clone().find(is_fine) else {
        return coarse.next().map(|sample| OfferedPaint::Coarse(ranked_donors[sample.donor_index].photo));
    };
    let mut others = samples.filter(|other| other.donor_index != first.donor_index);
    let dissent = others.find(|other| paints_differ(other.colour, first.colour));
    Some(OfferedPaint::Fine(PaintOffer {
        given: ranked_donors[first.donor_index].given_colour(&first, 1.0),
        dissent: dissent.map(|other| ranked_donors[other.donor_index].photo),
    }))
}

/// Returns true when two paints of one point (linear light in the common exposure) are of different pictures.
pub fn paints_differ(a: [f32; 3], b: [f32; 3]) -> bool {
    let off = |c: usize| (a[c].max(BLACK) / b[c].max(BLACK)).ln().abs();
    (off(0) + off(1) + off(2)) / 3.0 > DISSENT
}

/// Returns the index of the chosen candidate, and how far the candidates agree, 0 to 1. Candidates come by rising penalty; those
/// behind the first [`MOST_DONORS`] are not heard: many photos may show the same sky.
pub(super) fn chosen(candidates: &[DonorColour]) -> (usize, f32) {
    const COUNTED: &str = "two candidates at least are chosen from";
    let candidates = &candidates[..candidates.len().min(MOST_DONORS)];
    let median = [0, 1, 2].map(|c| {
        let mut values = [0.0; MOST_DONORS];
        candidates.iter().zip(&mut values).for_each(|(candidate, value)| *value = candidate.log[c]);
        robust::median(&mut values[..candidates.len()]).expect(COUNTED)
    });
    let mut distances = [0.0; MOST_DONORS];
    for (candidate, distance) in candidates.iter().zip(&mut distances) {
        *distance = (0..3).map(|c| (candidate.log[c] - median[c]).abs()).sum::<f32>() / 3.0;
    }
    let mut sorted = distances;
    let deviation = robust::median(&mut sorted[..candidates.len()]).expect(COUNTED);
    let agreement = 1.0 / (1.0 + (deviation / USUAL_DEVIATION).powi(2));
    if candidates.len() < MEDIAN_FROM {
        return (0, agreement);
    }
    // Half of the candidates are within the deviation; a candidate within half the usual deviation counts as
    // near, too.
    let near = |index: &usize| distances[*index] <= deviation.max(USUAL_DEVIATION / 2.0);
    ((0..candidates.len()).find(near).unwrap_or(0), agreement)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(values: &[f32]) -> Vec<DonorColour> {
        let candidate = |(donor_index, value): (usize, &f32)| {
            let colour = [*value; 3];
            DonorColour { colour, log: colour.map(f32::ln), donor_index, painted: false }
        };
        values.iter().enumerate().map(candidate).collect()
    }

    #[test]
    fn paints_contradict_where_their_colours_are_clearly_others_and_not_by_a_shade() {
        assert!(paints_differ([0.5, 0.1, 0.1], [0.1, 0.1, 0.5]));
        assert!(!paints_differ([0.5, 0.5, 0.5], [0.45, 0.5, 0.55]));
        assert!(!paints_differ([0.0; 3], [0.002; 3]), "black is black");
    }

    #[test]
    fn of_up_to_three_the_least_penalty_is_taken_whatever_the_others_show() {
        assert_eq!(chosen(&candidates(&[0.9, 0.2, 0.21])).0, 0);
    }

    #[test]
    fn of_more_a_stray_colour_is_passed_over_even_by_the_nearest_photo() {
        let (index, agreement) = chosen(&candidates(&[0.02, 0.2, 0.21, 0.2, 0.19]));
        assert_eq!(index, 1);
        assert!(agreement > 0.9);
        assert!(chosen(&candidates(&[0.02, 0.2, 0.5, 0.9])).1 < 0.2, "they do not agree");
    }

    #[test]
    fn of_very_many_the_best_alone_are_heard() {
        let mut colours = [0.2; 3 * MOST_DONORS];
        colours[0] = 0.02;
        colours[MOST_DONORS..].fill(0.02);
        let (index, agreement) = chosen(&candidates(&colours));
        assert_eq!(index, 1);
        assert!(agreement > 0.9);
    }
}
