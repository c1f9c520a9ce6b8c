//! The votes of photos at the surface points that one photo shows.
//!
//! With `a` votes that agree with the photo, its own included, and `c` votes in the largest set of votes that agree with
//! each other and not with it, its agreement falls smoothly from 1 where `c <= a` to [`LEAST`] where `c >= a + 2`. Ties
//! change nothing, so one photo alone never overrules another.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::reduced_photo::{ReducedPhoto, ReducedPhotos};
use crate::fill::FillSurfaceId;
use quadratura_base::error::Result;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_projection::exposure::LightGroups;
use quadratura_view::weights::pixels_per_unit;

/// The largest number of photos that a photo is compared with, the nearest ones.
pub const MOST_VOTES: usize = 24;

/// The least agreement of a pixel by votes.
pub const LEAST: f32 = 0.1;

/// The lead of the votes against a pixel from which on its agreement is least.
const CLEAR_LEAD: f32 = 2.0;

/// The distance of two colours, as a natural logarithm, up to which their photos agree fully: a quarter of the light.
const SAME: f32 = 0.25;

/// The distance of two colours from which on their photos do not agree at all.
const DIFFERENT: f32 = 0.5;

/// Returns how far two photos agree whose colours are this far apart, 0 to 1.
pub(super) fn agrees(distance: f32) -> f32 {
    1.0 - smoothstep((distance - SAME) / (DIFFERENT - SAME))
}

fn smoothstep(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The votes at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Votes {
    /// Votes that agree with the pixel, its own included.
    pub own: f32,
    /// Votes of the largest set that agree with each other and not with the pixel; an upper bound of it where that is at
    /// most `own`.
    pub against: f32,
    /// The mean distance from the colours of the photos that do not agree, as a natural logarithm.
    pub distance: f32,
    /// The brightness that these photos show, as a natural logarithm in the common exposure; `None` where most agree.
    pub expected: Option<f32>,
}

impl Votes {
    /// No votes but its own.
    const ALONE: Self = Self { own: 1.0, against: 0.0, distance: 0.0, expected: None };

    /// Returns true where no other photo was asked.
    pub fn are_none(&self) -> bool {
        *self == Self::ALONE
    }

    /// Returns the agreement, [`LEAST`] to 1.
    pub fn agreement(&self) -> f32 {
        1.0 - (1.0 - LEAST) * smoothstep((self.against - self.own) / CLEAR_LEAD)
    }
}

/// Returns the share of the pixels with other votes than their own that have about as many votes against them as for
/// them, 0 to 1; 0 where no pixel has.
pub fn undecided_share(votes: &[Votes]) -> f64 {
    let voted = votes.iter().filter(|votes| votes.own + votes.against > 1.5).count();
    let is_undecided = |votes: &&Votes| votes.against >= 0.5 && (votes.own - votes.against).abs() <= 0.5;
    votes.iter().filter(is_undecided).count() as f64 / voted.max(1) as f64
}

/// Returns the photos that are asked about a photo: those of its group of light first, each nearest first. `eyes` are the photos'
/// centres in the site's order; the photos `left_out` have no vote.
pub fn voters(eyes: &[DVec3], photo: PhotoId, left_out: &[PhotoId], groups: &LightGroups) -> Vec<PhotoId> {
    let here = eyes[photo.index()];
    let others = PhotoId::all(eyes.len()).filter(|id| *id != photo && !left_out.contains(id));
    let rank = |id: PhotoId| (groups.of(id) != groups.of(photo), eyes[id.index()].distance(here));
    let mut others: Vec<(PhotoId, (bool, f64))> = others.map(|id| (id, rank(id))).collect();
    others.sort_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    others.truncate(MOST_VOTES);
    others.into_iter().map(|(id, _)| id).collect()
}

/// Counts the votes of `voters` at each pixel of a reduced photo, row by row; its own alone where no other photo shows the point.
/// `photo` is an index in the site's order.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn votes(photos: &ReducedPhotos, photo: PhotoId, voters: &[PhotoId], task: &Task) -> Result<Vec<Votes>> {
    let Some(tested) = &photos.photos[photo.index()] else { return Ok(Vec::new()) };
    let same_light = |id: PhotoId| photos.groups.of(id) == photos.groups.of(photo);
    let other = |id: &PhotoId| {
        Some(Other { photo: photos.photos[id.index()].as_ref()?, same_light: same_light(*id) })
    };
    let others: Vec<Other> = voters.iter().filter_map(other).collect();
    let poll = Poll { photos, tested, others };
    let (width, height) = (tested.donor.camera.width, tested.donor.camera.height);
    let row = |y: u32| {
        task.check_cancelled()?;
        Ok((0..width).map(|x| poll.pixel(x, y).unwrap_or(Votes::ALONE)).collect::<Vec<_>>())
    };
    let rows: Vec<Vec<Votes>> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
    Ok(rows.concat())
}

struct Poll<'a> {
    photos: &'a ReducedPhotos<'a>,
    tested: &'a ReducedPhoto,
    others: Vec<Other<'a>>,
}

/// A photo that is asked.
struct Other<'a> {
    photo: &'a ReducedPhoto,
    /// Whether it is of the same group of light. A photo of another group counts only where its gain fits, that is, where it
    /// agrees: if it does not, the light may differ.
    same_light: bool,
}

/// What a photo shows at the point.
#[derive(Clone, Copy)]
struct PointVoter<'a> {
    photo: &'a ReducedPhoto,
    px: DVec2,
    /// Reduced pixels per unit of the surface, as a logarithm to base 2.
    detail: f64,
}

impl PointVoter<'_> {
    /// Returns the distance of this photo's colour from those of another around the point, at the coarser of their
    /// footprints.
    fn distance(&self, other: &PointVoter) -> f32 {
        let finer = (self.detail - other.detail).round();
        let (own, others) = (finer.max(0.0) as usize, (-finer).max(0.0) as usize);
        other.photo.tints.distance(self.photo.tints.tint(self.px, own), other.px, others)
    }
}

impl PointVoter<'_> {
    /// Returns the brightness that the photo shows, at the footprint of another where that is coarser.
    fn brightness(&self, other: &PointVoter) -> Option<f32> {
        self.photo.tints.brightness(self.px, (self.detail - other.detail).round().max(0.0) as usize)
    }
}

impl Poll<'_> {
    fn pixel(&self, x: u32, y: u32) -> Option<Votes> {
        let (id, point) = self.photos.visible_point(self.tested, x, y)?;
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let own = self.voter(self.tested, id, point, px);
        let mut voters: [Option<PointVoter>; MOST_VOTES] = [None; MOST_VOTES];
        let mut weights = [0.0f32; MOST_VOTES];
        let mut count = 0;
        let (mut agreeing, mut apart) = (1.0, 0.0);
        let mut distance = 0.0;
        for &Other { photo, same_light } in &self.others {
            let Some(px) = self.photos.seen(photo, id, point) else { continue };
            let voter = self.voter(photo, id, point, px);
            let away = own.distance(&voter);
            let agrees = agrees(away);
            agreeing += agrees;
            if agrees < 1.0 && same_light {
                voters[count] = Some(voter);
                weights[count] = 1.0 - agrees;
                apart += 1.0 - agrees;
                distance += (1.0 - agrees) * away;
                count += 1;
            }
        }
        // The sum of all is the most that any set of them can be.
        if apart <= agreeing {
            return Some(Votes { own: agreeing, against: apart, ..Votes::ALONE });
        }
        let voters: Vec<PointVoter> = voters[..count].iter().flatten().copied().collect();
        let against = largest_set(&mutual_agreement(&voters), &weights[..count]);
        let shown = voters
            .iter()
            .zip(&weights)
            .filter_map(|(voter, weight)| Some((voter.brightness(&own)?, *weight)));
        let (sum, all) =
            shown.fold((0.0, 0.0), |(sum, all), (shown, weight)| (sum + weight * shown, all + weight));
        let expected = (all > 0.0).then(|| sum / all);
        Some(Votes { own: agreeing, against, distance: distance / apart, expected })
    }

    fn voter<'a>(
        &self,
        photo: &'a ReducedPhoto,
        id: FillSurfaceId,
        point: DVec3,
        px: DVec2,
    ) -> PointVoter<'a> {
        let plane = &self.photos.surfaces.get(id).plane;
        let eye = photo.donor.pose.center_in_world();
        let depth = photo.donor.pose.camera_from_world(point).z;
        let detail = pixels_per_unit(&photo.donor.camera, plane, eye, depth).log2();
        PointVoter { photo, px, detail }
    }
}

/// Returns how far each two voters agree with each other, row by row: as far as the less agreeing of both.
fn mutual_agreement(voters: &[PointVoter]) -> Vec<f32> {
    let count = voters.len();
    let mut mutual = vec![1.0f32; count * count];
    for i in 0..count {
        for k in 0..i {
            let apart = voters[i].distance(&voters[k]).max(voters[k].distance(&voters[i]));
            mutual[i * count + k] = agrees(apart);
            mutual[k * count + i] = agrees(apart);
        }
    }
    mutual
}

/// Returns the weight of the heaviest set of voters that agree with each other, found by adding to each voter in turn
/// the one that agrees best with all of the set. `mutual` is the result of [`mutual_agreement`].
pub(super) fn largest_set(mutual: &[f32], weights: &[f32]) -> f32 {
    let count = weights.len();
    let mut most = 0.0f32;
    for first in 0..count {
        let mut least = mutual[first * count..(first + 1) * count].to_vec();
        let mut open: Vec<usize> = (0..count).filter(|&k| k != first).collect();
        let mut sum = weights[first];
        let value = |least: &[f32], k: usize| least[k] * weights[k];
        while let Some(place) =
            (0..open.len()).max_by(|&a, &b| value(&least, open[a]).total_cmp(&value(&least, open[b])))
        {
            let next = open.swap_remove(place);
            if value(&least, next) <= 0.0 {
                break;
            }
            sum += value(&least, next);
            least.iter_mut().zip(&mutual[next * count..]).for_each(|(least, with)| *least = least.min(*with));
        }
        most = most.max(sum);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn votes(own: f32, against: f32) -> f32 {
        Votes { own, against, distance: 1.0, expected: None }.agreement()
    }

    #[test]
    fn a_tie_changes_nothing_and_two_votes_more_decide() {
        assert_eq!([votes(1.0, 0.0), votes(1.0, 1.0), votes(3.0, 3.0)], [1.0; 3]);
        assert!((votes(1.0, 3.0) - LEAST).abs() < 1e-6 && (votes(2.0, 9.0) - LEAST).abs() < 1e-6);
        let rising: Vec<f32> = (0..=20).map(|i| votes(1.0, 1.0 + 0.1 * i as f32)).collect();
        assert!(rising.windows(2).all(|w| w[1] < w[0] && w[0] - w[1] < 0.08), "smoothly: {rising:?}");
    }

    #[test]
    fn as_many_votes_against_as_for_leave_a_pixel_undecided() {
        let votes = [[1.0, 1.0], [3.0, 3.0], [1.0, 0.0], [3.0, 0.0], [1.0, 3.0]];
        let votes = votes.map(|[own, against]| Votes { own, against, distance: 1.0, expected: None });
        assert_eq!(undecided_share(&votes), 0.5);
        assert_eq!((undecided_share(&votes[2..3]), undecided_share(&[])), (0.0, 0.0));
    }

    #[test]
    fn photos_that_contradict_each_other_do_not_add_up() {
        // Three that agree, and two others that agree with nobody.
        let agree = |i: usize, k: usize| if i == k || (i < 3 && k < 3) { 1.0 } else { 0.0 };
        let mutual: Vec<f32> = (0..25).map(|at| agree(at / 5, at % 5)).collect();
        assert_eq!(largest_set(&mutual, &[1.0; 5]), 3.0);
        assert_eq!(largest_set(&mutual, &[0.2, 0.2, 0.2, 1.0, 0.9]), 1.0);
        // In a chain each agrees with its neighbours only.
        let chain: Vec<f32> =
            (0..25).map(|at: usize| if (at / 5).abs_diff(at % 5) <= 1 { 1.0 } else { 0.0 }).collect();
        assert_eq!(largest_set(&chain, &[1.0; 5]), 2.0);
        assert_eq!(largest_set(&[], &[]), 0.0);
    }
}
