//! A photo that gives: its colours at several levels of detail, and what it shows where.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use super::painted::{LEVELS, Paint, PaintedSurface, Word};
use super::surfaces::{SurfaceId, Surfaces};
use crate::error::Result;
use crate::geometry::{Pinhole, Plane, Pose};
use crate::layers::software::owners;
use crate::layers::view::{Item, View};
use crate::projection::srgb::Srgb;
use crate::projection::{PhotoId, Projector};
use crate::raster::bilinear::Clamped;
use crate::raster::halving::{OddSide, halved};
use crate::raster::{Image, in_8_bits};
use crate::scene::{Model, PhotoPixels};

/// Where the photos come from: files, or a test's own.
pub trait Donors: Sync {
    /// The photo, ready to give; none where it cannot be read.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    fn donor(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>>;

    /// So many may be held at the same time: as many as memory allows, two at least.
    fn at_once(&self) -> usize;
}

/// A photo gives nothing nearer to another depth than so many pixels: models are wrong by a few, and what
/// lies behind an edge must not be taken for what lies before it.
const INSIDE_PX: usize = 4;

/// Two surfaces whose depths differ by less than this share are one at a pixel: windows in their wall. What
/// `projection::relief` calls the same surface.
const SAME_DEPTH: f32 = 5e-4;

/// Planes that lean against each other by less than 2.5 degrees are parallel (cosine).
const PARALLEL: f64 = 0.999;

/// Neighbouring pixels have the same depth up to this share of it, beside what slopes explain.
const JUMP: f32 = 3e-3;

/// The pixel lies [`INSIDE_PX`] inside of what the photo shows of its surface.
const INSIDE: u32 = 1 << 31;

/// A photo, ready to give.
pub struct Donor {
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
    /// Bits of a sample in its file: 8 or 16. Here all have 8.
    pub bits: u8,
    /// Its colour profile.
    pub icc: Option<Vec<u8>>,
    view: View,
    planes: Vec<Plane>,
    /// For each surface its item in `view`, or [`NOWHERE`].
    item_of: Vec<u32>,
    /// Per pixel the item that owns it plus one, 0 for none, and [`INSIDE`].
    shown: Vec<u32>,
    levels: Vec<Level>,
    /// By item.
    paint: BTreeMap<u32, Paint>,
}

const NOWHERE: u32 = u32::MAX;

/// One level of detail: sRGB, 8 bits.
type Level = Image<[u8; 3]>;

impl Donor {
    /// Of a photo with its pixels and what was painted on it, and the model in world coordinates; `tolerance`
    /// is that of occlusion. What is painted over is as if the photo had never shown anything else.
    pub fn new(
        projector: &Projector,
        pixels: &PhotoPixels,
        painted: &[PaintedSurface],
        model: &Model,
        surfaces: &Surfaces,
        tolerance: f32,
    ) -> Self {
        let Projector { camera, pose, .. } = projector;
        let view = View::new(model, camera, pose);
        let mut item_of = vec![NOWHERE; surfaces.len()];
        let mut planes = Vec::with_capacity(view.items.len());
        for (i, item) in (0..).zip(&view.items) {
            let surface = surfaces.id(item.face, item.triangle);
            item_of[surface.0 as usize] = i;
            planes.push(surfaces.get(surface).plane);
        }
        let shown = owners(&view, tolerance);
        let (bits, icc, paint) = (pixels.bits(), pixels.icc.clone(), BTreeMap::new());
        let levels = vec![finest(pixels)];
        let mut donor =
            Self { camera: *camera, pose: *pose, bits, icc, view, planes, item_of, shown, levels, paint };
        remove_invalid(&mut donor.shown, pixels);
        donor.take_paint(painted);
        mark_inside(&mut donor.shown, &donor.view);
        donor.add_levels(valid(pixels));
        donor
    }

    /// Colours take the place of the photo's where it shows their surface; what was painted away is shown no more.
    fn take_paint(&mut self, painted: &[PaintedSurface]) {
        let (width, height) = (self.camera.width, self.camera.height);
        for painted in painted {
            let Some(item) = self.item(painted.surface) else { continue };
            for (x, y, colour) in painted.within(width, height) {
                if !self.owns(item, x, y) {
                    continue;
                }
                let at = y as usize * width as usize + x as usize;
                match colour {
                    Some(colour) => self.levels[0].pixels_mut()[at] = colour,
                    None => self.shown[at] = 0,
                }
            }
            self.paint.insert(item, Paint::of(painted));
        }
    }

    fn add_levels(&mut self, mut valid: Option<Vec<bool>>) {
        // What is masked and painted over is known.
        let painted = |(valid, shown): (&mut bool, &u32)| *valid |= *shown != 0;
        valid.iter_mut().flatten().zip(&self.shown).for_each(painted);
        while self.levels.len() < LEVELS {
            let last = &self.levels[self.levels.len() - 1];
            if last.size().iter().any(|side| *side <= 1) {
                break;
            }
            let next = half(last, valid.as_deref());
            valid = valid.map(|valid| halved_valid(&valid, last.size()));
            self.levels.push(next);
        }
    }

    /// The paint on an item's surface.
    pub fn paint(&self, item: u32) -> Option<&Paint> {
        self.paint.get(&item)
    }

    /// What was painted at a pixel's middle on an item's surface, at full detail.
    pub fn painted(&self, item: u32, x: u32, y: u32) -> Word {
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.paint(item).map_or(Word::None, |paint| paint.at(centre, 0))
    }

    /// The model as the photo sees it.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The item of a surface, if that may cover pixels of this photo.
    pub fn item(&self, surface: SurfaceId) -> Option<u32> {
        Some(self.item_of[surface.0 as usize]).filter(|item| *item != NOWHERE)
    }

    /// The item with this index.
    pub fn seen(&self, item: u32) -> &Item {
        &self.view.items[item as usize]
    }

    /// Whether the photo shows the item's plane at a position, well inside of what it shows of it.
    pub fn shows(&self, item: u32, px: DVec2) -> bool {
        if !self.camera.rect().contains_position(px) {
            return false;
        }
        let (x, y) = (px.x as u32, px.y as u32);
        let shown = self.shown[y as usize * self.camera.width as usize + x as usize];
        shown & INSIDE != 0 && self.owns(item, x, y)
    }

    /// The item that a pixel shows, if it shows anything of the model.
    pub fn owner(&self, x: u32, y: u32) -> Option<u32> {
        (self.shown[y as usize * self.camera.width as usize + x as usize] & !INSIDE).checked_sub(1)
    }

    /// Whether the photo shows anything of the model at a pixel.
    pub fn shows_any(&self, x: u32, y: u32) -> bool {
        self.owner(x, y).is_some()
    }

    /// Whether the photo shows the item's plane at a pixel, be it at its border.
    pub fn owns(&self, item: u32, x: u32, y: u32) -> bool {
        self.owner(x, y).is_some_and(|owner| owner == item || self.is_level(owner, item, x, y))
    }

    /// Two items have one plane as far as a pixel can tell.
    fn is_level(&self, a: u32, b: u32, x: u32, y: u32) -> bool {
        let depth = |item: u32| self.view.items[item as usize].inverse_depth.at(x, y);
        let normal = |item: u32| self.planes[item as usize].normal;
        (depth(a) / depth(b) - 1.0).abs() <= SAME_DEPTH && normal(a).dot(normal(b)).abs() >= PARALLEL
    }

    /// The level of detail at which `ratio` of the photo's pixels lie along one that is asked for.
    pub fn level_for(&self, ratio: f64) -> usize {
        (ratio.max(1.0).log2().round() as usize).min(self.levels.len() - 1)
    }

    /// The colour of a pixel: linear light, full range 1.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let at = y as usize * self.camera.width as usize + x as usize;
        self.levels[0].pixels()[at].map(|value| Srgb::tables().linear(value))
    }

    /// The colour at a position, between four pixels of a level: linear light, full range 1.
    pub fn colour(&self, px: DVec2, level: usize) -> [f32; 3] {
        let (size, rgb) = (self.levels[level].size(), self.levels[level].pixels());
        let srgb = Srgb::tables();
        let between = Clamped::of(px * (1.0 / f64::from(1u32 << level)), size);
        [0, 1, 2].map(|c| between.mix(|x, y| srgb.linear(rgb[y * size[0] + x][c])))
    }

    /// About how many bytes one of a camera takes.
    pub fn bytes_of(camera: &Pinhole) -> u64 {
        // Owner, colours, and a third of those once more for the coarser levels.
        u64::from(camera.width) * u64::from(camera.height) * (4 + 3 + 1)
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        let levels: u64 = self.levels.iter().map(|level| 3 * level.pixels().len() as u64).sum();
        4 * self.shown.len() as u64 + levels + self.paint.values().map(Paint::bytes).sum::<u64>()
    }
}

/// Where the photo is not valid it shows nothing.
fn remove_invalid(shown: &mut [u32], pixels: &PhotoPixels) {
    if !pixels.has_alpha() {
        return;
    }
    for (i, shown) in (0..).zip(shown) {
        if !pixels.is_valid(i % pixels.width, i / pixels.width) {
            *shown = 0;
        }
    }
}

/// Marks the pixels that have no other depth within [`INSIDE_PX`] pixels along rows and columns.
fn mark_inside(shown: &mut [u32], view: &View) {
    let (width, height) = (view.width as usize, view.height as usize);
    let owners = &*shown;
    let differs = |x: usize, y: usize| {
        let jump_to = |x1: usize, y1: usize| {
            let inside = x1 < width && y1 < height;
            inside && is_jump(view, [owners[y * width + x], owners[y1 * width + x1]], [x, y], [x1, y1])
        };
        jump_to(x + 1, y)
            || jump_to(x, y + 1)
            || jump_to(x.wrapping_sub(1), y)
            || jump_to(x, y.wrapping_sub(1))
    };
    let mut jumps = vec![0u8; width * height];
    jumps.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, jump)| *jump = differs(x, y).into());
    });
    let wide: Vec<u8> = jumps.par_chunks(width).flat_map_iter(grown_along).collect();
    shown.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let rows = y.saturating_sub(INSIDE_PX)..(y + INSIDE_PX + 1).min(height);
        for (x, shown) in row.iter_mut().enumerate() {
            if *shown != 0 && rows.clone().all(|y| wide[y * width + x] == 0) {
                *shown |= INSIDE;
            }
        }
    });
}

/// A row with every mark grown to both sides.
fn grown_along(row: &[u8]) -> Vec<u8> {
    let mut grown = vec![0u8; row.len()];
    for (x, _) in row.iter().enumerate().filter(|(_, mark)| **mark != 0) {
        grown[x.saturating_sub(INSIDE_PX)..(x + INSIDE_PX + 1).min(row.len())].fill(1);
    }
    grown
}

/// Whether the depth jumps between two neighbours: neither plane explains the other's depth.
fn is_jump(view: &View, owners: [u32; 2], a: [usize; 2], b: [usize; 2]) -> bool {
    if owners[0] == owners[1] {
        return false;
    }
    if owners.contains(&0) {
        return true;
    }
    let [i, j] = owners.map(|owner| view.items[owner as usize - 1].inverse_depth);
    let off = |p: [usize; 2]| {
        let (x, y) = (p[0] as u32, p[1] as u32);
        let (di, dj) = (i.at(x, y), j.at(x, y));
        let slopes = i.a.abs() + i.b.abs() + j.a.abs() + j.b.abs();
        (di - dj).abs() - slopes - JUMP * di.abs().max(dj.abs())
    };
    off(a).min(off(b)) > 0.0
}

fn finest(pixels: &PhotoPixels) -> Level {
    let rgb = |x: u32, y: u32| {
        let [r, g, b, _] = pixels.rgba16(x, y);
        [r, g, b].map(in_8_bits)
    };
    let row = |y: u32| (0..pixels.width).map(move |x| rgb(x, y));
    let rgb = (0..pixels.height).into_par_iter().flat_map_iter(row).collect();
    Level::new(pixels.rect(), rgb)
}

/// Which pixels are valid, row by row; none where all are.
fn valid(pixels: &PhotoPixels) -> Option<Vec<bool>> {
    let row = |y: u32| (0..pixels.width).map(move |x| pixels.is_valid(x, y));
    pixels.has_alpha().then(|| (0..pixels.height).into_par_iter().flat_map_iter(row).collect())
}

/// A texel is valid where one of its four is.
fn halved_valid(valid: &[bool], size: [usize; 2]) -> Vec<bool> {
    halved(size, OddSide::Dropped, |four| four.iter().any(|at| valid[*at]))
}

/// Means of those of two by two that are valid, in linear light, lest what is masked tinges what is beside it; an
/// odd last row or column is dropped.
fn half(level: &Level, valid: Option<&[bool]>) -> Level {
    let srgb = Srgb::tables();
    let mean = |four: &[usize]| {
        let four: [usize; 4] = std::array::from_fn(|i| four[i]);
        let weights = four.map(|at| f32::from(u8::from(valid.is_none_or(|valid| valid[at]))));
        let total: f32 = weights.iter().sum();
        let weights = if total > 0.0 { weights.map(|weight| weight / total) } else { [0.25; 4] };
        [0, 1, 2].map(|c| {
            let light = four.map(|at| srgb.linear(level.pixels()[at][c]));
            srgb.encoded((0..4).map(|i| weights[i] * light[i]).sum())
        })
    };
    level.halved(OddSide::Dropped, mean)
}
