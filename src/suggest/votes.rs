//! Where on each plane photos see it: votes of all photos' labels on a raster of the plane.

use glam::{DVec2, DVec3};

use super::chart::{PlaneChart, closed, regions};
use super::label::{GIVEN, LabelCandidates, PhotoLabels, UNKNOWN, is_front};
use super::planes::PlaneKind;
use super::support::middle;
use super::view::WorkingPhoto;

/// The votes on a plane, one cell a pixel of a photo at the working size.
pub struct PlaneVotes {
    /// The raster.
    pub chart: PlaneChart,
    /// Photos that show the plane there; one that shows it smaller than a cell counts less.
    pub seen: Vec<f32>,
    /// Photos that show something behind it.
    pub passed: Vec<f32>,
}

/// A place is of the plane where more photos than this show it, ...
const LEAST_SEEN: f32 = 0.25;
/// ... and more than this share of those that see past it.
const LEAST_SHARE: f32 = 0.8;
/// What a photo counts at least that shows the plane, however small.
const LEAST_VOTE: f64 = 0.3;
/// A label is behind a place when it is farther by this share.
const BEHIND: f64 = 1.02;
/// A face in front of a camera hides everything, so that a camera which sees through counts this much.
const BLOCKED: f32 = 2.0;
/// The largest distance behind a plane at which a camera's place is cut out of it.
const CUT_BEHIND: f64 = 0.04;
/// Gaps that are closed, in cells: always, and where no photo sees through.
const CLOSED: [u16; 2] = [3, 12];
/// The smallest region, and the smallest hole, in cells.
const LEAST_CELLS: usize = 60;

/// Collects the votes of all photos on a plane; `None` where no photo is labelled with it.
pub fn votes(
    number: u16,
    candidates: &LabelCandidates,
    views: &[WorkingPhoto],
    labels: &[PhotoLabels],
) -> Option<PlaneVotes> {
    let plane = &candidates.planes[usize::from(number)];
    let shown = |(view, labels): (&WorkingPhoto, &PhotoLabels)| -> Vec<DVec3> {
        let (w, depth) = (view.size()[0], view.inverse_depth(&plane.plane));
        let own = labels.of.iter().enumerate().filter(|(_, label)| **label == number);
        own.map(|(at, _)| view.eye + view.ray(middle(at % w, at / w)) / depth.at(at % w, at / w)).collect()
    };
    let shown: Vec<DVec3> = views.iter().zip(labels).flat_map(shown).collect();
    if shown.is_empty() {
        return None;
    }
    let focal = views.iter().map(|view| view.camera().fx).fold(0.0, f64::max);
    let cell = candidates.supports[usize::from(number)].away / focal;
    let chart = PlaneChart::around(&plane.plane, candidates.up, shown.into_iter(), 16.0 * cell, cell);
    let mut votes = PlaneVotes { seen: vec![0.0; chart.count()], passed: vec![0.0; chart.count()], chart };
    for (view, labels) in views.iter().zip(labels) {
        votes.add(number, candidates, view, labels);
    }
    Some(votes)
}

impl PlaneVotes {
    fn add(&mut self, number: u16, candidates: &LabelCandidates, view: &WorkingPhoto, labels: &PhotoLabels) {
        let plane = candidates.planes[usize::from(number)].plane;
        let is_front = is_front(view, &plane);
        let depths: Vec<_> = candidates.planes.iter().map(|plane| view.inverse_depth(&plane.plane)).collect();
        let w = view.size()[0];
        for index in 0..self.chart.count() {
            let point = self.chart.middle(index);
            let Some((px, z)) = view.project(point) else { continue };
            let at = view.index(px);
            let label = labels.of[at];
            if label == number {
                let across = (view.eye - point).normalize().dot(plane.normal).abs();
                let pixels = (self.chart.cell * view.camera().fx / z).powi(2) * across;
                self.seen[index] += pixels.clamp(LEAST_VOTE, 1.0) as f32;
                continue;
            }
            // What the given model hides says nothing; what it is in front of, its own outlines say.
            if label == UNKNOWN || label == GIVEN {
                continue;
            }
            let inverse = depths.get(usize::from(label)).map_or(0.0, |depth| depth.at(at % w, at / w));
            if inverse * z * BEHIND < 1.0 {
                self.passed[index] += if is_front { 1.0 } else { BLOCKED };
            }
        }
    }

    /// Returns the cells that belong to the plane.
    pub fn mask(
        &self,
        kind: PlaneKind,
        views: &[WorkingPhoto],
        plane: &quadratura_base::geometry::Plane,
    ) -> Vec<bool> {
        let mut mask: Vec<bool> = self
            .seen
            .iter()
            .zip(&self.passed)
            .map(|(seen, passed)| *seen > LEAST_SEEN && *seen > LEAST_SHARE * passed)
            .collect();
        let mut free = vec![true; mask.len()];
        if kind != PlaneKind::Ground {
            self.cut_cameras(views, plane, &mut free);
        }
        for reach in CLOSED {
            let wide = closed(&mask, self.chart.size, reach);
            for (at, wide) in wide.into_iter().enumerate() {
                mask[at] |= wide && (reach == CLOSED[0] || self.passed[at] < LEAST_SEEN);
            }
        }
        mask.iter_mut().zip(free).for_each(|(own, free)| *own &= free);
        without_specks(&mask, self.chart.size)
    }

    /// Marks the places just in front of cameras that look through the plane from behind.
    fn cut_cameras(
        &self,
        views: &[WorkingPhoto],
        plane: &quadratura_base::geometry::Plane,
        free: &mut [bool],
    ) {
        for view in views {
            let behind = -plane.signed_distance(view.eye);
            let forward = view.pose.rotation.transpose() * DVec3::Z;
            if !(-1e-3..CUT_BEHIND).contains(&behind) || forward.dot(plane.normal) <= 0.0 {
                continue;
            }
            let foot = self.chart.place(view.eye);
            let radius = (1.5 * behind / self.chart.cell).max(3.0);
            for (at, free) in free.iter_mut().enumerate() {
                let cell =
                    DVec2::new((at % self.chart.size[0]) as f64, (at / self.chart.size[0]) as f64) + 0.5;
                *free &= cell.distance(foot) > radius;
            }
        }
    }
}

/// Removes small regions and fills small holes.
fn without_specks(mask: &[bool], size: [usize; 2]) -> Vec<bool> {
    let flip = |mask: &[bool]| -> Vec<bool> {
        let (number, sizes) = regions(mask, size);
        mask.iter().zip(number).map(|(own, region)| *own != (sizes[region as usize] < LEAST_CELLS)).collect()
    };
    // Holes first: what is left small then is no part of anything.
    let filled: Vec<bool> = flip(mask).into_iter().zip(mask).map(|(flipped, own)| flipped || *own).collect();
    flip(&filled).into_iter().zip(&filled).map(|(flipped, own)| flipped && *own).collect()
}
