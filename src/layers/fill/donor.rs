//! Donor photos: their colours at several levels of detail, and the surface that each pixel shows.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::painted::{LEVELS, Paint, PaintSample, PaintedSurface};
use super::silhouettes::{CLEAR, INSIDE, mark_clear, mark_inside};
use super::surfaces::{FillSurfaceId, FillSurfaces};
use crate::projected_model::{Item, ProjectedModel};
use crate::software::owners;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Plane, Pose};
use quadratura_base::raster::bilinear::Clamped;
use quadratura_base::raster::halving::{OddSide, halved};
use quadratura_base::raster::{Image, in_8_bits};
use quadratura_base::scene::impostor::{Facing, Turn};
use quadratura_base::scene::{Model, PhotoId, PhotoPixels};
use quadratura_projection::Projector;
use quadratura_view::agreement::PhotoAgreement;
use quadratura_view::srgb::Srgb;

/// A source of donor photos: files, or images made by a test.
pub trait Donors: Sync {
    /// Returns the photo as a donor to other photos; `None` where it cannot be read.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    fn donor(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>>;

    /// Returns the photo with all of its own paint, also with paint that other photos must not see; `None` where
    /// it cannot be read.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    fn own(&self, photo: PhotoId) -> Result<Option<Arc<Donor>>> {
        self.donor(photo)
    }

    /// Returns the number of donors that fit into memory at the same time; two at least.
    fn at_once(&self) -> usize;
}

/// The relative difference of depths below which two surfaces count as one at a pixel, such as windows in
/// their wall. It is the tolerance by which `projection::relief` recognises the same surface.
pub(super) const SAME_DEPTH: f32 = 5e-4;

/// The cosine of 2.5 degrees; planes that enclose a smaller angle count as parallel.
pub(super) const PARALLEL: f64 = 0.999;

/// What a photo gives.
#[derive(Clone, Copy)]
pub struct DonorContent<'a> {
    /// The photo's pixels.
    pub pixels: &'a PhotoPixels,
    /// The paint on it, which replaces its pixels.
    pub painted: &'a [PaintedSurface],
    /// The agreement of other photos, which takes out what they contradict; `None` to leave it in.
    pub agreement: Option<&'a PhotoAgreement>,
}

/// A photo prepared for sampling.
pub struct Donor {
    /// Image size and intrinsics in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// Bits per sample of the photo's file, 8 or 16. The donor itself keeps 8.
    pub bits: u8,
    /// The photo's ICC colour profile.
    pub icc: Option<Vec<u8>>,
    view: ProjectedModel,
    planes: Vec<Plane>,
    /// The item in `view` of each surface, or [`NOWHERE`].
    item_of: Vec<u32>,
    /// Per pixel, the index of the item that owns it plus one (0 for none), [`INSIDE`] and [`CLEAR`].
    owners: Vec<u32>,
    levels: Vec<DonorLevel>,
    /// The paint on each item.
    paint: BTreeMap<u32, Paint>,
    /// How impostors, by item, are turned from where [`FillSurfaces`] have them towards the photo.
    turned: BTreeMap<u32, Turn>,
}

const NOWHERE: u32 = u32::MAX;

/// One level of detail: sRGB with 8 bits.
type DonorLevel = Image<[u8; 3]>;

impl Donor {
    /// Prepares a photo from its content and the model in world coordinates. `tolerance` is that of occlusion.
    pub fn new(
        projector: &Projector,
        content: &DonorContent,
        model: &Arc<Model>,
        surfaces: &FillSurfaces,
        tolerance: f32,
    ) -> Self {
        let DonorContent { pixels, painted, agreement } = *content;
        let DonorView { camera, pose, view, item_of, planes, turned } =
            DonorView::new(projector, model, surfaces);
        let owners = owners(&view, tolerance);
        let bits = pixels.bits();
        let icc = pixels.icc.clone();
        let paint = BTreeMap::new();
        let levels = vec![finest(pixels)];
        let mut donor =
            Self { camera, pose, bits, icc, view, planes, item_of, owners, levels, paint, turned };
        remove_invalid(&mut donor.owners, pixels);
        donor.take_paint(painted);
        let mut valid = valid(pixels);
        if let Some(agreement) = agreement {
            donor.remove_outvoted(agreement, &mut valid);
        }
        mark_inside(&mut donor.owners, &donor.view);
        let item_is_backdrop: Vec<bool> = donor
            .view
            .items
            .iter()
            .map(|item| surfaces.get(surfaces.id(item.face, item.triangle)).backdrop)
            .collect();
        mark_clear(&mut donor.owners, &donor.view, &item_is_backdrop);
        donor.add_levels(valid);
        donor
    }

    /// Prepares the paint on a photo alone: it shows nothing, so that only its paint can be sampled.
    pub fn of_paint(
        projector: &Projector,
        painted: &[PaintedSurface],
        model: &Arc<Model>,
        surfaces: &FillSurfaces,
    ) -> Self {
        let DonorView { camera, pose, view, item_of, planes, turned } =
            DonorView::new(projector, model, surfaces);
        let owners = vec![0; camera.width as usize * camera.height as usize];
        // As many levels as the photo has, because their number decides which one of the paint is sampled.
        let least = camera.width.min(camera.height).max(1);
        let levels = (0..LEVELS).filter(|level| *level == 0 || least >> (level - 1) > 1);
        let levels = levels.map(|_| DonorLevel::new(PixelRect::of_size(0, 0), Vec::new())).collect();
        let (bits, icc, paint) = (8, None, BTreeMap::new());
        let mut donor =
            Self { camera, pose, bits, icc, view, planes, item_of, owners, levels, paint, turned };
        donor.take_paint(painted);
        donor
    }

    /// Returns the pose from which points of an item's surface, where [`FillSurfaces`] have it, are seen where the photo shows
    /// them.
    pub fn pose_on(&self, item: u32) -> Pose {
        self.turned.get(&item).map_or(self.pose, |turn| turn.before(&self.pose))
    }

    /// Returns a point in the direction from which the photo sees a point of an item's surface, where [`FillSurfaces`] have
    /// it.
    pub fn seen_from(&self, item: u32, point: DVec3) -> DVec3 {
        let centre = self.pose.center_in_world();
        self.turned.get(&item).map_or(centre, |turn| point + centre - turn.apply(point))
    }

    /// Applies paint: colours replace the photo's where it shows their surface; where paint was erased, the
    /// photo shows nothing any more.
    fn take_paint(&mut self, painted: &[PaintedSurface]) {
        let (width, height) = (self.camera.width, self.camera.height);
        for painted in painted {
            let Some(item) = self.item(painted.surface) else { continue };
            for (x, y, colour) in painted.within(width, height) {
                if !self.shows_plane_at(item, x, y) {
                    continue;
                }
                let at = y as usize * width as usize + x as usize;
                match colour {
                    Some(colour) => self.levels[0].pixels_mut()[at] = colour,
                    None => self.owners[at] = 0,
                }
            }
            self.paint.insert(item, Paint::from_painted(painted));
        }
    }

    /// Removes what other photos contradict, but for paint: it is treated like a mask. `valid` has the validity of each
    /// pixel, row by row; `None` where all are valid.
    fn remove_outvoted(&mut self, agreement: &PhotoAgreement, valid: &mut Option<Vec<bool>>) {
        let size = [self.camera.width, self.camera.height];
        for (rect, face) in agreement.outvoted(size) {
            for (x, y) in rect.pixels().map(|(x, y)| (x as u32, y as u32)) {
                let shown = self.owner(x, y).filter(|item| self.seen(*item).face == face);
                let Some(item) = shown else { continue };
                if self.painted(item, x, y) != PaintSample::None {
                    continue;
                }
                let at = y as usize * size[0] as usize + x as usize;
                self.owners[at] = 0;
                valid.get_or_insert_with(|| vec![true; self.owners.len()])[at] = false;
            }
        }
    }

    fn add_levels(&mut self, mut valid: Option<Vec<bool>>) {
        // Masked pixels that were painted over have a known colour.
        let painted = |(valid, owner): (&mut bool, &u32)| *valid |= *owner != 0;
        valid.iter_mut().flatten().zip(&self.owners).for_each(painted);
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

    /// Returns the paint on an item's surface.
    pub fn paint(&self, item: u32) -> Option<&Paint> {
        self.paint.get(&item)
    }

    /// Returns the paint at a pixel's centre on an item's surface, at full detail.
    pub fn painted(&self, item: u32, x: u32, y: u32) -> PaintSample {
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.paint(item).map_or(PaintSample::None, |paint| paint.at(centre, 0))
    }

    /// Returns the model as the photo sees it.
    pub fn view(&self) -> &ProjectedModel {
        &self.view
    }

    /// Returns the item of a surface; `None` where the surface cannot cover pixels of this photo.
    pub fn item(&self, surface: FillSurfaceId) -> Option<u32> {
        Some(self.item_of[surface.0 as usize]).filter(|item| *item != NOWHERE)
    }

    /// Returns the item with this index.
    pub fn seen(&self, item: u32) -> &Item {
        &self.view.items[item as usize]
    }

    /// Returns true when the photo shows the item's plane at a position in pixels, at least four pixels from
    /// the next depth discontinuity.
    pub fn shows(&self, item: u32, px: DVec2) -> bool {
        if !self.camera.rect().contains_position(px) {
            return false;
        }
        let (x, y) = (px.x as u32, px.y as u32);
        self.entry(x, y) & INSIDE != 0 && self.shows_plane_at(item, x, y)
    }

    /// As [`Donor::shows`], but not behind the outlines of nearer surfaces, where what the model lacks of these overhangs
    /// ([`super::silhouettes`]).
    pub fn shows_clearly(&self, item: u32, px: DVec2) -> bool {
        self.shows(item, px) && self.entry(px.x as u32, px.y as u32) & CLEAR != 0
    }

    fn entry(&self, x: u32, y: u32) -> u32 {
        self.owners[y as usize * self.camera.width as usize + x as usize]
    }

    /// Returns the item that a pixel shows; `None` where it shows nothing of the model, is invalid, or was
    /// erased.
    pub fn owner(&self, x: u32, y: u32) -> Option<u32> {
        (self.entry(x, y) & !(INSIDE | CLEAR)).checked_sub(1)
    }

    /// Returns true when the photo shows any surface of the model at a pixel.
    pub fn shows_any(&self, x: u32, y: u32) -> bool {
        self.owner(x, y).is_some()
    }

    /// Returns true when the photo shows the item's plane at a pixel, even next to a depth discontinuity.
    pub fn shows_plane_at(&self, item: u32, x: u32, y: u32) -> bool {
        self.owner(x, y).is_some_and(|owner| owner == item || self.is_level(owner, item, x, y))
    }

    /// Returns true when two items lie in the same plane as far as one pixel can tell.
    fn is_level(&self, a: u32, b: u32, x: u32, y: u32) -> bool {
        let depth = |item: u32| self.view.items[item as usize].inverse_depth.at(x, y);
        let normal = |item: u32| self.planes[item as usize].normal;
        (depth(a) / depth(b) - 1.0).abs() <= SAME_DEPTH && normal(a).dot(normal(b)).abs() >= PARALLEL
    }

    /// Returns the level of detail at which `ratio` of the photo's pixels correspond to one pixel wanted.
    pub fn level_for(&self, ratio: f64) -> usize {
        (ratio.max(1.0).log2().round() as usize).min(self.levels.len() - 1)
    }

    /// Returns the colour of a pixel: linear light, full range 1.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        let at = y as usize * self.camera.width as usize + x as usize;
        self.levels[0].pixels()[at].map(|value| Srgb::tables().linear(value))
    }

    /// Interpolates the colour at a position in pixels between four texels of a level: linear light, full
    /// range 1.
    pub fn colour(&self, px: DVec2, level: usize) -> [f32; 3] {
        let (size, rgb) = (self.levels[level].size(), self.levels[level].pixels());
        let srgb = Srgb::tables();
        let between = Clamped::new(px * (1.0 / f64::from(1u32 << level)), size);
        [0, 1, 2].map(|c| between.mix(|x, y| srgb.linear(rgb[y * size[0] + x][c])))
    }

    /// Estimates the memory of a donor with this camera, in bytes.
    pub fn bytes_of(camera: &Pinhole) -> u64 {
        // The owner, the colours, and a third of the colours once more for the coarser levels.
        u64::from(camera.width) * u64::from(camera.height) * (4 + 3 + 1)
    }

    /// Returns the memory that the donor uses, in bytes.
    pub fn bytes(&self) -> u64 {
        let levels: u64 = self.levels.iter().map(|level| 3 * level.pixels().len() as u64).sum();
        let model = self.view.bytes() + (size_of_val(&self.planes[..]) + 4 * self.item_of.len()) as u64;
        4 * self.owners.len() as u64 + levels + model + self.paint.values().map(Paint::bytes).sum::<u64>()
    }
}

/// The surfaces of a model as a photo sees them.
struct DonorView {
    camera: Pinhole,
    pose: Pose,
    view: ProjectedModel,
    item_of: Vec<u32>,
    planes: Vec<Plane>,
    turned: BTreeMap<u32, Turn>,
}

impl DonorView {
    fn new(projector: &Projector, model: &Arc<Model>, surfaces: &FillSurfaces) -> Self {
        let Projector { camera, pose, .. } = projector;
        let facing = Facing::of_pose(pose);
        let model = model.facing(&facing);
        let view = ProjectedModel::new(&model, camera, pose);
        let mut item_of = vec![NOWHERE; surfaces.len()];
        let mut planes = Vec::with_capacity(view.items.len());
        let mut turned = BTreeMap::new();
        for (i, item) in (0..).zip(&view.items) {
            let surface = surfaces.id(item.face, item.triangle);
            item_of[surface.0 as usize] = i;
            let impostor = model.impostor(item.face);
            planes.push(impostor.map_or(surfaces.get(surface).plane, |impostor| impostor.plane(&facing)));
            turned.extend(impostor.map(|impostor| (i, impostor.turn(&impostor.at_rest(), &facing))));
        }
        Self { camera: *camera, pose: *pose, view, item_of, planes, turned }
    }
}

/// Removes the owners of invalid pixels.
fn remove_invalid(owners: &mut [u32], pixels: &PhotoPixels) {
    if !pixels.has_alpha() {
        return;
    }
    for (i, owner) in (0..).zip(owners) {
        if !pixels.is_valid(i % pixels.width, i / pixels.width) {
            *owner = 0;
        }
    }
}

fn finest(pixels: &PhotoPixels) -> DonorLevel {
    let rgb = |x: u32, y: u32| {
        let [r, g, b, _] = pixels.rgba16(x, y);
        [r, g, b].map(in_8_bits)
    };
    let row = |y: u32| (0..pixels.width).map(move |x| rgb(x, y));
    let rgb = (0..pixels.height).into_par_iter().flat_map_iter(row).collect();
    DonorLevel::new(pixels.rect(), rgb)
}

/// Returns the validity of each pixel, row by row; `None` where all pixels are valid.
fn valid(pixels: &PhotoPixels) -> Option<Vec<bool>> {
    let row = |y: u32| (0..pixels.width).map(move |x| pixels.is_valid(x, y));
    pixels.has_alpha().then(|| (0..pixels.height).into_par_iter().flat_map_iter(row).collect())
}

/// Halves a validity mask: a texel is valid where one of its four pixels is.
fn halved_valid(valid: &[bool], size: [usize; 2]) -> Vec<bool> {
    halved(size, OddSide::Dropped, |four| four.iter().any(|at| valid[*at]))
}

/// Halves a level: each texel is the mean, in linear light, of the valid ones of two by two texels, so that
/// masked pixels do not tinge their surroundings. An odd last row or column is dropped.
fn half(level: &DonorLevel, valid: Option<&[bool]>) -> DonorLevel {
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
