//! A photo that asks others what it does not know: place by place, in small blocks that ask the same photos.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::{CELL_LEVEL, Cells};
use super::donor::Donor;
use super::givers::{Given, Giver, Offered, Place, given, givers, offered};
use super::photo::Ground;
use super::plate::{Plate, Side};
use super::region::{HiddenSpan, Region};
use super::surfaces::Surface;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::projection::PhotoId;
use crate::projection::srgb::Srgb;
use crate::projection::weights::pixels_per_unit;
use crate::scene::light::srgb_of_linear;
use crate::task::Task;

/// A billboard is filled from photos that see it from nearly the same direction, ten degrees or less: what is
/// seen through leaves moves behind them.
const BILLBOARD_ANGLE: f64 = 0.17;

/// Side of a block of pixels that asks the same photos.
const BLOCK: u32 = 32;

/// Relief moves a point by so many pixels of another photo, or hardly more.
const RELIEF_REACH_PX: u32 = 16;

/// The photo that asks, and those that it asks.
pub(super) struct Asking<'a> {
    pub ground: &'a Ground<'a>,
    pub photo: PhotoId,
    pub own: &'a Donor,
    pub donors: &'a [(PhotoId, Arc<Donor>)],
}

/// The place of a row's first texel in its region, and what is answered to each.
type Row<T> = (usize, Vec<Option<T>>);

/// Pixels of one region within one block.
struct Block<'a> {
    region: usize,
    corner: [u32; 2],
    spans: Vec<&'a HiddenSpan>,
}

impl Asking<'_> {
    /// The surface of a region and which side of it the photo sees.
    pub fn side(&self, region: &Region) -> Option<Side> {
        let item = self.own.item(region.surface)?;
        Some((region.surface, self.own.seen(item).back))
    }

    /// What is answered to each pixel of the regions.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn ask<T: Copy + Send>(
        &self,
        regions: &[Region],
        answer: &(dyn Fn(&Asker, DVec2) -> Option<T> + Sync),
        task: &Task,
    ) -> Result<Vec<Vec<Option<T>>>> {
        let blocks: Vec<Block> =
            regions.iter().enumerate().flat_map(|(index, region)| blocks(index, region)).collect();
        let ask = |block: &Block| {
            task.go_on()?;
            Ok((block.region, self.ask_block(&regions[block.region], block, answer)))
        };
        let found: Vec<(usize, Vec<Row<T>>)> = blocks.par_iter().map(ask).collect::<Result<_>>()?;
        let mut texels: Vec<Vec<Option<T>>> = regions.iter().map(|r| vec![None; r.texels()]).collect();
        for (region, rows) in found {
            for (first, row) in rows {
                texels[region][first..first + row.len()].copy_from_slice(&row);
            }
        }
        Ok(texels)
    }

    fn ask_block<T: Copy>(
        &self,
        region: &Region,
        block: &Block,
        answer: &dyn Fn(&Asker, DVec2) -> Option<T>,
    ) -> Vec<Row<T>> {
        let Some(asker) = Asker::new(self, region, block.corner) else { return Vec::new() };
        let mut rows = Vec::new();
        for hidden in &block.spans {
            let x0 = hidden.span.x0.max(block.corner[0]);
            let x1 = hidden.span.x1.min(block.corner[0] + BLOCK);
            let row = (x0..x1).map(|x| answer(&asker, centre(x, hidden.span.y))).collect();
            rows.push(((hidden.first + x0 - hidden.span.x0) as usize, row));
        }
        rows
    }

    /// Compares what the photo shows around a region with what would fill it there; cells that `leave_out` wants
    /// have no say.
    pub fn all_differences(
        &self,
        region: &Region,
        item: u32,
        cells: &Cells,
        plate: Option<&Plate>,
        leave_out: &dyn Fn(usize) -> bool,
    ) -> Vec<(usize, [f32; 3])> {
        let mut by_block: BTreeMap<[u32; 2], Vec<(usize, DVec2)>> = BTreeMap::new();
        let shown = cells.near().filter(|(place, px)| !leave_out(*place) && self.own.shows(item, *px));
        for (place, px) in shown {
            let corner = [px.x, px.y].map(|at| at as u32 / BLOCK * BLOCK);
            by_block.entry(corner).or_default().push((place, px));
        }
        by_block
            .into_par_iter()
            .flat_map_iter(|(corner, cells)| self.differences(region, corner, &cells, plate))
            .collect()
    }

    fn differences(
        &self,
        region: &Region,
        corner: [u32; 2],
        cells: &[(usize, DVec2)],
        plate: Option<&Plate>,
    ) -> Vec<(usize, [f32; 3])> {
        let asker = Asker::new(self, region, corner);
        let difference = |&(place, px): &(usize, DVec2)| {
            let given =
                asker.as_ref().and_then(|asker| asker.given(px, CELL_LEVEL)).map(|given| given.colour);
            let filling = given.or_else(|| Some(plate?.colour(self.met(region, px))))?;
            let shown = self.own.colour(px, CELL_LEVEL.min(self.own.level_for(f64::INFINITY)));
            let gain = self.ground.gains.of_photo[self.photo.0 as usize].map(|gain| gain as f32);
            let log = |value: f32| value.max(1e-3).ln();
            Some((place, [0, 1, 2].map(|c| log(shown[c]) - gain[c] - log(filling[c]))))
        };
        cells.iter().filter_map(difference).collect()
    }

    /// What takes colours from the common exposure to the photo's own.
    pub fn factor(&self) -> [f32; 3] {
        self.ground.gains.of_photo[self.photo.0 as usize].map(|gain| gain.exp() as f32)
    }

    /// All of the photo.
    pub fn frame(&self) -> PixelRect {
        self.own.camera.rect()
    }

    /// The point of a region's true surface that is seen at a photo position.
    pub fn met(&self, region: &Region, px: DVec2) -> DVec3 {
        self.on_surface(self.ground.surfaces.get(region.surface), px)
    }

    fn on_surface(&self, surface: &Surface, px: DVec2) -> DVec3 {
        let eye = self.own.pose.center_in_world();
        let ray = self.own.pose.rotation.transpose() * self.own.camera.ray_in_camera(px);
        let plane = &surface.plane;
        let on_plane = eye - ray * (plane.signed_distance(eye) / plane.normal.dot(ray));
        self.ground.met(surface, eye, on_plane)
    }

    /// Linear light as the photo's own samples.
    pub fn stored(&self, linear: [f32; 3]) -> [u16; 3] {
        let srgb = Srgb::tables();
        linear.map(|light| match self.own.bits {
            16 => (srgb_of_linear(f64::from(light).clamp(0.0, 1.0)) * 65535.0).round() as u16,
            _ => u16::from(srgb.encoded(light)) * 257,
        })
    }
}

/// The middle of a pixel.
pub(super) fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The blocks that a region's spans touch.
fn blocks(index: usize, region: &Region) -> Vec<Block<'_>> {
    let mut found: BTreeMap<[u32; 2], Vec<&HiddenSpan>> = BTreeMap::new();
    for hidden in &region.spans {
        let row = hidden.span.y / BLOCK * BLOCK;
        for column in hidden.span.x0 / BLOCK..=(hidden.span.x1 - 1) / BLOCK {
            found.entry([row, column * BLOCK]).or_default().push(hidden);
        }
    }
    let block = |([y, x], spans): ([u32; 2], Vec<_>)| Block { region: index, corner: [x, y], spans };
    found.into_iter().map(block).collect()
}

/// The photos that may give in a block, asked point by point.
pub(super) struct Asker<'a> {
    asking: &'a Asking<'a>,
    surface: &'a Surface,
    givers: Vec<Giver<'a>>,
    /// Some paint may lie in the block.
    painted: bool,
}

impl<'a> Asker<'a> {
    /// None where no photo may give anything.
    fn new(asking: &'a Asking<'a>, region: &Region, [x, y]: [u32; 2]) -> Option<Self> {
        let (id, back) = asking.side(region)?;
        let surface = asking.ground.surfaces.get(id);
        let (own, eye) = (asking.own, asking.own.pose.center_in_world());
        let (low, high) = (0.5, f64::from(BLOCK) - 0.5);
        let middle = f64::from(BLOCK) / 2.0;
        let offsets = [(middle, middle), (low, low), (high, low), (low, high), (high, high)];
        let probes = offsets
            .map(|(dx, dy)| asking.on_surface(surface, DVec2::new(f64::from(x) + dx, f64::from(y) + dy)));
        let depth = own.pose.camera_from_world(probes[0]).z;
        // Behind the horizon of the plane: the block's middle meets it nowhere.
        let depth = if depth > 0.0 { depth } else { own.pose.camera_from_world(surface.outline[0]).z.abs() };
        let density = pixels_per_unit(&own.camera, &surface.plane, eye, depth.max(f64::MIN_POSITIVE));
        let most_angle = if surface.billboard { BILLBOARD_ANGLE } else { std::f64::consts::PI };
        let plane = surface.plane;
        let place = Place { surface: id, plane, back, viewpoint: eye, most_angle, density, probes: &probes };
        let givers = givers(asking.donors, asking.ground.gains, &place);
        let painted = givers.iter().any(|giver| may_have_paint(giver, &probes));
        (!givers.is_empty()).then_some(Self { asking, surface, givers, painted })
    }

    /// What the others say of what the photo has at a position.
    pub fn given(&self, px: DVec2, coarser: usize) -> Option<Given> {
        given(&self.givers, self.asking.on_surface(self.surface, px), coarser)
    }

    /// What they have painted there.
    pub fn offered(&self, px: DVec2) -> Option<Offered> {
        if !self.painted {
            return None;
        }
        offered(&self.givers, self.asking.on_surface(self.surface, px))
    }
}

/// Whether a giver has paint within the quadrangle of a block's probes; true where one of them is behind it.
fn may_have_paint(giver: &Giver, probes: &[DVec3]) -> bool {
    let Some(paint) = giver.paint() else { return false };
    let found: Vec<DVec2> = probes.iter().filter_map(|point| giver.finds(*point)).collect();
    if found.len() < probes.len() {
        return true;
    }
    let low = found.iter().copied().reduce(DVec2::min).unwrap_or_default();
    let high = found.iter().copied().reduce(DVec2::max).unwrap_or_default();
    let rect = paint.rect().grown(RELIEF_REACH_PX);
    let (left, top) = (f64::from(rect.x), f64::from(rect.y));
    let (right, bottom) = (f64::from(rect.right()), f64::from(rect.bottom()));
    low.x <= right && high.x >= left && low.y <= bottom && high.y >= top
}
