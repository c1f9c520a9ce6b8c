//! Where a visitor is kept: the places from which photos show nearly all that there is to see, well enough.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::labels::ByteLabels;
use super::plane::PhotoCells;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_projection::Server;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::site_parts::SiteParts;
use quadratura_view::weights::{angle_at, border};

/// The cells across the longer side of the region's extent.
const ACROSS: f64 = 24.0;
/// How far beyond the cameras places are tried, as a share of the diagonal around them.
const BEYOND: f64 = 0.35;
/// The heights that are tried, in those of a usual camera over the ground.
const HEIGHTS: [f64; 6] = [0.6, 0.8, 1.0, 1.5, 2.5, 4.0];
/// The largest penalty of a photo that shows a point well enough.
pub const WELL: f64 = 0.6;
/// Photos look one way, and show what is behind them in other photos at most. A place is good enough where they show a half of what they
/// show from a usual camera.
const OF_USUAL: f64 = 0.5;
/// The directions that are looked into from a place: around, and up and down.
const AROUND: u32 = 16;
const TILTS: [f64; 4] = [-0.5, -0.15, 0.15, 0.5];

/// The places, on a grid in plan.
#[derive(Debug, Clone, Serialize)]
pub struct DescribedRegion {
    /// The horizontal directions of columns and rows.
    pub axes: [[f64; 3]; 2],
    /// The corner of the first cell along both, and the side of a cell.
    pub corner: [f64; 2],
    /// See [`Self::corner`].
    pub cell: f64,
    /// The number of columns and rows.
    pub size: [usize; 2],
    /// The lowest and highest place of each cell along up, row by row; `None` where there is none.
    pub heights: Vec<Option<[f64; 2]>>,
    /// The usual height of a camera over the ground.
    pub eye: f64,
}

/// What the search needs of a photo: labels and confidence at half of its size.
pub struct PhotoMap {
    size: [usize; 2],
    labels: Vec<u8>,
    trust: Vec<u8>,
}

impl PhotoMap {
    /// Takes every second label along both sides, and the halved confidence.
    pub fn new(labels: &[u8], trust: Vec<u8>, size: [u32; 2]) -> Self {
        let [width, height] = size.map(|side| side as usize);
        let rows = (0..height).step_by(2);
        let labels = rows.flat_map(|y| (0..width).step_by(2).map(move |x| labels[y * width + x])).collect();
        Self { size: [width.div_ceil(2), height.div_ceil(2)], labels, trust }
    }

    /// Returns the confidence at a position in the photo (pixels), where it shows one of these labels.
    fn at(&self, px: DVec2, labels: &[u8]) -> Option<f64> {
        let [x, y] = [px.x / 2.0, px.y / 2.0];
        let inside = x >= 0.0 && y >= 0.0 && x < self.size[0] as f64 && y < self.size[1] as f64;
        let at = inside.then(|| y as usize * self.size[0] + x as usize)?;
        labels.contains(&self.labels[at]).then(|| f64::from(self.trust[at]) / 255.0)
    }
}

/// Returns the plane of confidence that [`PhotoMap::new`] takes.
pub fn half_trust(trust: &[u8], size: [u32; 2]) -> Vec<u8> {
    PhotoCells::halves(size).means(trust, |_| true)
}

/// A point of the model that is seen from a place.
pub struct VisiblePoint {
    /// The point, in world coordinates.
    pub point: DVec3,
    face: FaceId,
    /// Whether its back is seen.
    back: bool,
}

impl VisiblePoint {
    /// Returns what may show the point.
    pub fn servers<'a>(&self, parts: &'a SiteParts) -> impl Iterator<Item = &'a Server> {
        let back = self.back;
        parts.skirts.sources.servers_of(self.face).iter().filter(move |server| server.back == back)
    }
}

/// Returns what is seen of the model from a place, in directions all around.
pub fn seen_from(parts: &SiteParts, surface: &ModelSurface, up: DVec3, place: DVec3) -> Vec<VisiblePoint> {
    let (a, b) = up.any_orthonormal_pair();
    let directions = (0..AROUND).flat_map(|turn| {
        let angle = f64::from(turn) / f64::from(AROUND) * std::f64::consts::TAU;
        TILTS.map(|tilt| a * angle.cos() + b * angle.sin() + up * tilt)
    });
    let seen = |direction: DVec3| {
        let hit = surface.nearest(place, direction)?;
        let point = place + direction * hit.t;
        let normal = parts.skirts.model.face(hit.face).plane.normal;
        Some(VisiblePoint { point, face: hit.face, back: normal.dot(place - point) < 0.0 })
    };
    directions.filter_map(seen).collect()
}

/// The search.
pub struct SafeSearch<'a> {
    /// All that the site's pictures are made of.
    pub parts: &'a SiteParts,
    /// The surface of the model.
    pub surface: &'a ModelSurface,
    /// The published photos, with what is needed of them.
    pub photos: &'a [(PhotoId, &'a Pinhole, PhotoMap, ByteLabels)],
    /// The direction that is up.
    pub up: DVec3,
    /// The point of the world that is zero on the page.
    pub origin: DVec3,
}

impl SafeSearch<'_> {
    /// Returns the region; `None` where no camera stands above a surface, or no place is good enough.
    pub fn region(&self) -> Option<DescribedRegion> {
        let sources = &self.parts.skirts.sources;
        let centres: Vec<DVec3> =
            self.photos.iter().map(|(id, ..)| sources.photo(*id).pose.center_in_world()).collect();
        let mut over: Vec<f64> = centres.iter().filter_map(|centre| self.over_ground(*centre)).collect();
        over.sort_by(f64::total_cmp);
        let eye = *over.get(over.len() / 2)?;
        let (a, b) = self.up.any_orthonormal_pair();
        let plan = |point: DVec3| DVec2::new(point.dot(a), point.dot(b));
        let places = || centres.iter().map(|centre| plan(*centre - self.origin));
        let (low, high) = (places().reduce(DVec2::min)?, places().reduce(DVec2::max)?);
        let beyond = (BEYOND * low.distance(high)).max(eye);
        let (low, high) = (low - beyond, high + beyond);
        let cell = (high - low).max_element() / ACROSS;
        let size = [high.x - low.x, high.y - low.y].map(|side| (side / cell).ceil() as usize);
        let top = centres.iter().map(|centre| centre.dot(self.up)).fold(f64::NEG_INFINITY, f64::max);
        let mut usual: Vec<f64> = centres.iter().map(|centre| self.shown_well(*centre)).collect();
        usual.sort_by(f64::total_cmp);
        let least = (OF_USUAL * usual[usual.len() / 2]).max(f64::MIN_POSITIVE);
        let heights = (0..size[0] * size[1]).into_par_iter().map(|at| {
            let at = low + DVec2::new((at % size[0]) as f64 + 0.5, (at / size[0]) as f64 + 0.5) * cell;
            let flat = self.origin - self.up * self.origin.dot(self.up) + a * at.x + b * at.y;
            self.heights(flat, top, eye, least)
        });
        let heights: Vec<Option<[f64; 2]>> = heights.collect();
        heights.iter().any(Option::is_some).then(|| DescribedRegion {
            axes: [a.to_array(), b.to_array()],
            corner: low.to_array(),
            cell,
            size,
            heights,
            eye,
        })
    }

    fn over_ground(&self, point: DVec3) -> Option<f64> {
        self.surface.nearest(point, -self.up).map(|hit| hit.t)
    }

    /// Returns the range of good heights over a place in plan, relative to the page's origin; from the ground below the highest camera.
    fn heights(&self, flat: DVec3, top: f64, eye: f64, least: f64) -> Option<[f64; 2]> {
        let above = flat + self.up * (top + eye);
        let ground = above - self.up * self.over_ground(above)?;
        let is_good = |height: &&f64| self.shown_well(ground + self.up * (**height * eye)) >= least;
        let good: Vec<f64> = HEIGHTS.iter().filter(is_good).copied().collect();
        let from = (ground - self.origin).dot(self.up);
        Some([from + good.first()? * eye, from + good.last()? * eye])
    }

    /// Returns the share of what is seen from a place, in all directions, that photos show well enough.
    fn shown_well(&self, place: DVec3) -> f64 {
        let seen = seen_from(self.parts, self.surface, self.up, place);
        let is_well = |seen: &&VisiblePoint| {
            let mut servers = seen.servers(self.parts);
            servers
                .any(|server| self.penalty(server, seen.point, place).is_some_and(|penalty| penalty < WELL))
        };
        // Where hardly anything is seen there is nothing to walk to.
        let well = seen.iter().filter(is_well).count();
        if seen.len() >= AROUND as usize { well as f64 / seen.len() as f64 } else { 0.0 }
    }

    fn penalty(&self, server: &Server, point: DVec3, place: DVec3) -> Option<f64> {
        let (_, camera, map, labels) = self.photos.iter().find(|(id, ..)| *id == server.photo)?;
        let pose = &self.parts.skirts.sources.photo(server.photo).pose;
        let px = camera.image_from_camera(pose.camera_from_world(point))?;
        let trust = map.at(px, labels.of_layer.get(&server.layer_texture)?)?;
        let confidence = trust * border(camera, px);
        (confidence > 0.0).then(|| angle_at(point, place, pose.center_in_world()) / confidence)
    }
}
