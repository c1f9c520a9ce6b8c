//! How groups of light are found.
//!
//! Between two photos of one round, ratios of colours are the same at all common points, but for noise: that is their
//! gain. Between two rounds, shadows lie elsewhere, and no gain explains the ratios. Photos whose ratios scatter little are
//! joined (agglomerative clustering by average linkage, Sokal & Michener 1958); a division into two is believed only when
//! the ratios scatter clearly more between its parts than within, and when each photo is predicted clearly better by photos
//! of its own part. One group is the normal case.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::groups::{LEAST_SAY, LightGroups};
use super::patch::PatchColour;
use super::points::{PointPatch, SharedPoint, penalties_of};
use super::ratios::Ratio;
use super::solve::solve_in_groups;
use crate::Projector;
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::PhotoId;
use quadratura_view::Blend;
use quadratura_view::weights::weights;

/// The fewest comparisons from which the scatter of two photos' ratios is known.
const FEWEST_RATIOS: u32 = 12;
/// The residual, as a natural logarithm, above which a ratio counts no more: something moved, or the model is wrong.
const LARGEST: f64 = 1.0;
/// The factor by which ratios scatter more between groups than within from which on a division is tried.
const APART: f64 = 1.4;
/// The share by which errors of prediction have to fall for a division to be believed.
const CLEAR_SHARE: f64 = 0.15;
/// The largest number of photos that are predicted to test a division.
const MOST_PREDICTED: usize = 48;
/// The number of divisions that are tried, the most distant ones.
const MOST_TRIED: usize = 4;
/// The largest number of groups: a site with more is one whose photos have nothing in common.
const MOST_GROUPS: usize = 8;
/// What speaks for groups of light. All figures are mean absolute logarithms that no gain explains.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GroupSupport {
    /// The scatter of ratios between photos of one group.
    pub within: f64,
    /// The scatter of ratios between photos of different groups; of the most distant parts where there is one group.
    pub between: f64,
    /// The share by which errors of prediction fall where photos of the own group come first, below 0 where they rise: of all
    /// points, or twice that of the part that gains least, whichever is smaller; of the last division. `None` where no
    /// division was tried.
    pub lead: Option<f64>,
}

/// What groups are found from.
pub(super) struct GroupingEvidence<'a> {
    pub photos: &'a [Projector],
    pub points: &'a [SharedPoint],
    pub colours: &'a [Vec<PatchColour>],
    pub ratios: &'a [Ratio],
}

/// A grouping that is tried, with the gains that are estimated within its groups.
struct Trial<'a> {
    of_photo: &'a [u32],
    gains: Vec<[f64; 3]>,
}

impl GroupingEvidence<'_> {
    /// Finds the groups, and what speaks for them.
    pub fn groups(&self) -> (LightGroups, GroupSupport) {
        let distances = Distances::new(self);
        let mut of_photo = vec![0u32; self.photos.len()];
        let mut support = distances.support(&of_photo);
        let mut open: Vec<u32> = vec![0];
        let mut count = 1u32;
        while let Some(group) = open.pop() {
            if count as usize >= MOST_GROUPS {
                break;
            }
            let members: Vec<usize> = (0..of_photo.len()).filter(|photo| of_photo[*photo] == group).collect();
            let Some((divided, found)) = self.divided(&distances, &of_photo, &members, count) else {
                continue;
            };
            if found.lead.is_some_and(|lead| lead >= CLEAR_SHARE) {
                of_photo = divided;
                open.extend([group, count]);
                count += 1;
                support = GroupSupport { lead: found.lead, ..distances.support(&of_photo) };
            } else if count == 1 {
                support = found;
            }
        }
        (LightGroups::new(&of_photo), support)
    }

    /// Divides the members of a group in two, the second of which gets the number `next`; returns the groups of all photos,
    /// and what speaks for the division. `None` where nothing can be divided.
    fn divided(
        &self,
        distances: &Distances,
        of_photo: &[u32],
        members: &[usize],
        next: u32,
    ) -> Option<(Vec<u32>, GroupSupport)> {
        let mut best: Option<(Vec<u32>, GroupSupport)> = None;
        for part in distances.parts(members) {
            let mut divided = of_photo.to_vec();
            part.iter().for_each(|photo| divided[*photo] = next);
            let inner: Vec<u32> = members.iter().map(|photo| divided[*photo]).collect();
            let mut support = distances.among(members).support(&inner);
            if support.between >= APART * support.within {
                support.lead = self.lead(of_photo, &divided, members);
            }
            let rank = |support: &GroupSupport| support.lead.unwrap_or(f64::NEG_INFINITY);
            if best.as_ref().is_none_or(|(_, best)| rank(&support) > rank(best)) {
                best = Some((divided, support));
            }
        }
        best
    }

    /// Returns the share by which errors of prediction of these photos fall with other groups, or twice that of one group's
    /// photos where that is less: all have to gain. `None` where nothing can be predicted.
    fn lead(&self, before: &[u32], after: &[u32], members: &[usize]) -> Option<f64> {
        let stride = members.len().div_ceil(MOST_PREDICTED).max(1);
        let trials = [before, after].map(|of_photo| {
            let fit = solve_in_groups(self.photos.len(), self.ratios, &LightGroups::new(of_photo));
            Trial { of_photo, gains: fit.of_photo }
        });
        let errors: Vec<(usize, [f64; 2])> = members
            .par_iter()
            .step_by(stride)
            .filter_map(|photo| Some((*photo, self.errors(PhotoId::new(*photo), &trials)?)))
            .collect();
        let lead = |errors: &mut dyn Iterator<Item = [f64; 2]>| {
            let (sum, count) = errors.fold(([0.0; 2], 0), |(sum, count), error| {
                ([sum[0] + error[0], sum[1] + error[1]], count + 1)
            });
            (count > 0 && sum[0] > 0.0).then(|| 1.0 - sum[1] / sum[0])
        };
        let all = lead(&mut errors.iter().map(|(_, errors)| *errors))?;
        let mut groups: Vec<u32> = members.iter().map(|photo| after[*photo]).collect();
        groups.sort_unstable();
        groups.dedup();
        let of_group = groups.iter().map(|group| {
            let members = errors.iter().filter(|(photo, _)| after[*photo] == *group);
            lead(&mut members.map(|(_, errors)| *errors)).unwrap_or(0.0)
        });
        Some(of_group.fold(all, |least, lead| least.min(2.0 * lead)))
    }

    /// Returns the mean error with which a photo's colours at its own points are predicted by other photos, with each of two
    /// groupings; `None` where it shares too few points.
    fn errors(&self, photo: PhotoId, trials: &[Trial; 2]) -> Option<[f64; 2]> {
        let mut residuals: [Vec<[f64; 3]>; 2] = Default::default();
        let points = self.points.iter().zip(self.colours).filter(|(point, _)| point.own == photo);
        for (point, colours) in points {
            let Some(predicted) = self.predicted(point, colours, trials) else { continue };
            residuals.iter_mut().zip(predicted).for_each(|(list, error)| list.push(error));
        }
        if residuals[0].len() < FEWEST_RATIOS as usize {
            return None;
        }
        Some(residuals.map(|residuals| scatter(&residuals)))
    }

    /// Returns the logarithm of predicted over true light at a point of a photo's own grid, with each grouping; `None` where
    /// nobody else of its group in the second one shows the point, from which nothing can be learned.
    fn predicted(
        &self,
        point: &SharedPoint,
        colours: &[PatchColour],
        trials: &[Trial; 2],
    ) -> Option<[[f64; 3]; 2]> {
        let measured = point.patches.iter().zip(colours);
        let usable = measured.filter_map(|(patch, colour)| Some((patch, colour.filter(|c| c.usable)?.mean)));
        let usable: Vec<(&PointPatch, [f64; 3])> = usable.collect();
        let (own, truth) = *usable.iter().find(|(patch, _)| patch.photo == point.own)?;
        let others: Vec<_> = usable.iter().filter(|(patch, _)| patch.photo != point.own).collect();
        let own_group = trials[1].of_photo[point.own.index()];
        if !others.iter().any(|(patch, _)| trials[1].of_photo[patch.photo.index()] == own_group) {
            return None;
        }
        let blend = Blend::default();
        let penalties = penalties_of(self.photos, own, others.iter().map(|(patch, _)| *patch), &blend);
        let light = |trial: &Trial| {
            let factor = |patch: &PointPatch| {
                let same = trial.of_photo[patch.photo.index()] == trial.of_photo[point.own.index()];
                if same { 1.0 } else { 1.0 / LEAST_SAY }
            };
            let leaned: Vec<f64> =
                penalties.iter().zip(&others).map(|(penalty, (patch, _))| penalty * factor(patch)).collect();
            let shares = weights(&leaned, &blend);
            let sum = |c: usize| {
                let parts = shares.iter().zip(&others);
                parts
                    .map(|(share, (patch, mean))| {
                        share * mean[c] * (-trial.gains[patch.photo.index()][c]).exp()
                    })
                    .sum::<f64>()
            };
            let all: f64 = shares.iter().sum();
            (all > 0.0).then(|| [0, 1, 2].map(|c| (sum(c) / truth[c]).ln()))
        };
        Some([light(&trials[0])?, light(&trials[1])?])
    }
}

/// Returns the mean absolute deviation from the median, of all channels, limited to [`LARGEST`].
fn scatter(residuals: &[[f64; 3]]) -> f64 {
    let of_channel = |c: usize| {
        let middle = upper_median(&mut residuals.iter().map(|r| r[c]).collect::<Vec<_>>()).unwrap_or(0.0);
        residuals.iter().map(|r| (r[c] - middle).abs().min(LARGEST)).sum::<f64>()
    };
    (0..3).map(of_channel).sum::<f64>() / (3 * residuals.len()).max(1) as f64
}

/// How much ratios scatter for each two photos that are compared often enough.
struct Distances {
    count: usize,
    /// The scatter, row by row.
    between: Vec<Option<f64>>,
}

impl Distances {
    fn new(evidence: &GroupingEvidence) -> Self {
        let count = evidence.photos.len();
        let mut of_pair: Vec<Vec<[f64; 3]>> = vec![Vec::new(); count * count];
        for ratio in evidence.ratios {
            let [a, b] = [ratio.a, ratio.b].map(|photo| photo.index());
            let sign = if a < b { 1.0 } else { -1.0 };
            of_pair[a.min(b) * count + a.max(b)].push(ratio.log.map(|log| sign * f64::from(log)));
        }
        let mut between = vec![None; count * count];
        for (at, residuals) in of_pair.iter().enumerate() {
            if residuals.len() >= FEWEST_RATIOS as usize {
                let (a, b) = (at / count, at % count);
                between[a * count + b] = Some(scatter(residuals));
                between[b * count + a] = between[a * count + b];
            }
        }
        Self { count, between }
    }

    fn of(&self, a: usize, b: usize) -> Option<f64> {
        self.between[a * self.count + b]
    }

    /// Returns the distances among some photos, numbered anew.
    fn among(&self, members: &[usize]) -> Self {
        let between = members.iter().flat_map(|a| members.iter().map(|b| self.of(*a, *b)));
        Self { count: members.len(), between: between.collect() }
    }

    /// Returns the mean distances within and between groups; 0 where there are none.
    fn support(&self, of_photo: &[u32]) -> GroupSupport {
        let (mut sums, mut counts) = ([0.0; 2], [0u32; 2]);
        for a in 0..self.count {
            for b in 0..a {
                let Some(distance) = self.of(a, b) else { continue };
                let at = usize::from(of_photo[a] != of_photo[b]);
                sums[at] += distance;
                counts[at] += 1;
            }
        }
        let mean = |at: usize| sums[at] / f64::from(counts[at].max(1));
        GroupSupport { within: mean(0), between: mean(1), lead: None }
    }

    /// Returns the parts of some photos that may be groups of their own, each of two photos or more with as many left, the
    /// most distant first.
    fn parts(&self, members: &[usize]) -> Vec<Vec<usize>> {
        let mut clusters: Vec<Vec<usize>> = members.iter().map(|photo| vec![*photo]).collect();
        let n = clusters.len();
        let mut sum: Vec<f64> = vec![0.0; n * n];
        let mut count: Vec<u32> = vec![0; n * n];
        for (i, a) in members.iter().enumerate() {
            for (k, b) in members.iter().enumerate() {
                if let Some(distance) = self.of(*a, *b).filter(|_| i != k) {
                    (sum[i * n + k], count[i * n + k]) = (distance, 1);
                }
            }
        }
        let mut tried: Vec<(f64, Vec<usize>)> = Vec::new();
        let mut open: Vec<usize> = (0..n).collect();
        loop {
            let pairs =
                open.iter().enumerate().flat_map(|(at, i)| open[at + 1..].iter().map(move |k| (*i, *k)));
            let known = pairs.filter(|(i, k)| count[i * n + k] > 0);
            let mean = |(i, k): (usize, usize)| sum[i * n + k] / f64::from(count[i * n + k]);
            let Some((i, k)) = known.min_by(|a, b| mean(*a).total_cmp(&mean(*b)).then(a.cmp(b))) else {
                break;
            };
            if clusters[i].len() >= 2 && clusters[k].len() >= 2 {
                let smaller = if clusters[k].len() <= clusters[i].len() { k } else { i };
                tried.push((mean((i, k)), clusters[smaller].clone()));
            }
            let joined = std::mem::take(&mut clusters[k]);
            clusters[i].extend(joined);
            open.retain(|other| *other != k);
            for other in open.iter().copied().filter(|other| *other != i) {
                let (from, to) = (k * n + other, i * n + other);
                sum[to] += sum[from];
                count[to] += count[from];
                (sum[other * n + i], count[other * n + i]) = (sum[to], count[to]);
            }
        }
        tried.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        tried.truncate(MOST_TRIED);
        let settled = tried.into_iter().filter_map(|(_, part)| self.settled(members, part));
        let mut parts: Vec<Vec<usize>> = settled.collect();
        parts.dedup();
        parts
    }

    /// Moves each photo to the nearer of a part and the rest until nothing moves; `None` where less than two are left in one.
    fn settled(&self, members: &[usize], part: Vec<usize>) -> Option<Vec<usize>> {
        const MOST_ROUNDS: usize = 8;
        let mut inside: Vec<bool> = members.iter().map(|photo| part.contains(photo)).collect();
        for _ in 0..MOST_ROUNDS {
            let mean = |at: usize, side: bool| {
                let others = (0..members.len()).filter(|k| *k != at && inside[*k] == side);
                let known = others.filter_map(|k| self.of(members[at], members[k]));
                let (sum, count) = known.fold((0.0, 0u32), |(sum, count), d| (sum + d, count + 1));
                (count > 0).then(|| sum / f64::from(count))
            };
            let next: Vec<bool> = (0..members.len())
                .map(|at| match (mean(at, true), mean(at, false)) {
                    (Some(to_part), Some(to_rest)) => to_part < to_rest,
                    (Some(_), None) => true,
                    (None, Some(_)) => false,
                    (None, None) => inside[at],
                })
                .collect();
            if next == inside {
                break;
            }
            inside = next;
        }
        let part: Vec<usize> =
            members.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(photo, _)| *photo).collect();
        (part.len() >= 2 && members.len() - part.len() >= 2).then_some(part)
    }
}
