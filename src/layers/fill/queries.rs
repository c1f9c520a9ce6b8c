//! Queries of one photo to the donor photos for the colours that it lacks, in small blocks of pixels that
//! query the same donors.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::{CELL_LEVEL, RegionCells};
use super::donor::Donor;
use super::photo::FillContext;
use super::plate::{RectifiedTexture, SurfaceSide};
use super::ranked_donors::{
    ColourQuery, DonatedColour, OfferedPaint, RankedDonor, given, offered, ranked_donors,
};
use super::region::{HiddenSpan, Region};
use super::surfaces::{FillSurface, FillSurfaceId};
use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::task::Task;
use quadratura_view::optics::squared_radius;
use quadratura_view::srgb::Srgb;
use quadratura_view::weights::pixels_per_unit;

/// The largest angle, in radians, between the directions from which a billboard is seen by the photo and by
/// its donors: ten degrees. The background seen through foliage shifts with the direction.
const BILLBOARD_ANGLE: f64 = 0.17;

/// Side in pixels of a block that queries the same donors.
const BLOCK: u32 = 32;

/// A distance in pixels by which relief displaces a point in another photo at most, apart from rare
/// exceptions.
const RELIEF_REACH_PX: u32 = 16;

/// The photo that is filled, and its donors.
pub(super) struct Asking<'a> {
    /// The data shared by all photos.
    pub context: &'a FillContext<'a>,
    /// The photo that is filled.
    pub photo: PhotoId,
    /// The photo that is filled, as a donor.
    pub own: &'a Donor,
    /// The donor photos.
    pub donors: &'a [(PhotoId, Arc<Donor>)],
}

/// The index of a row's first texel in its region, and the answer to each texel's query.
type QueryRow<T> = (usize, Vec<Option<T>>);

/// The pixels of one region within one block.
struct QueryBlock<'a> {
    region: usize,
    corner: [u32; 2],
    spans: Vec<&'a HiddenSpan>,
}

impl Asking<'_> {
    /// Returns the surface of a region and the side of it that the photo sees; `None` when the photo does not
    /// see it.
    pub fn side(&self, region: &Region) -> Option<SurfaceSide> {
        let item = self.own.item(region.surface)?;
        Some(SurfaceSide { id: region.surface, back: self.own.seen(item).back })
    }

    /// Answers the query of each pixel of the regions; `answer` gets the query's block and the pixel's
    /// centre.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn ask<T: Copy + Send>(
        &self,
        regions: &[Region],
        answer: &(dyn Fn(&Query, DVec2) -> Option<T> + Sync),
        task: &Task,
    ) -> Result<Vec<Vec<Option<T>>>> {
        let blocks: Vec<QueryBlock> =
            regions.iter().enumerate().flat_map(|(index, region)| blocks(index, region)).collect();
        let ask = |block: &QueryBlock| {
            task.check_cancelled()?;
            Ok((block.region, self.ask_block(&regions[block.region], block, answer)))
        };
        let found: Vec<(usize, Vec<QueryRow<T>>)> = blocks.par_iter().map(ask).collect::<Result<_>>()?;
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
        block: &QueryBlock,
        answer: &dyn Fn(&Query, DVec2) -> Option<T>,
    ) -> Vec<QueryRow<T>> {
        let Some(query) = Query::new(self, region, block.corner) else { return Vec::new() };
        let mut rows = Vec::new();
        for hidden in &block.spans {
            let x0 = hidden.span.x0.max(block.corner[0]);
            let x1 = hidden.span.x1.min(block.corner[0] + BLOCK);
            let row = (x0..x1).map(|x| answer(&query, centre(x, hidden.span.y))).collect();
            rows.push(((hidden.first + x0 - hidden.span.x0) as usize, row));
        }
        rows
    }

    /// Compares the photo's pixels around a region with the filling that would take their place. Returns per
    /// cell its index and the difference in log colour; cells for which `leave_out` is true are skipped.
    pub fn all_differences(
        &self,
        region: &Region,
        item: u32,
        cells: &RegionCells,
        plate: Option<&RectifiedTexture>,
        leave_out: &dyn Fn(usize) -> bool,
    ) -> Vec<(usize, [f32; 3])> {
        let mut by_block: BTreeMap<[u32; 2], Vec<(usize, DVec2)>> = BTreeMap::new();
        let is_backdrop = self.context.surfaces.get(region.surface).backdrop;
        let shows = |px: DVec2| match is_backdrop {
            true => self.own.shows_clearly(item, px),
            false => self.own.shows(item, px),
        };
        let visible = cells.near().filter(|(index, px)| !leave_out(*index) && shows(*px));
        for (index, px) in visible {
            let corner = [px.x, px.y].map(|at| at as u32 / BLOCK * BLOCK);
            by_block.entry(corner).or_default().push((index, px));
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
        plate: Option<&RectifiedTexture>,
    ) -> Vec<(usize, [f32; 3])> {
        let query = Query::new(self, region, corner);
        let difference = |&(index, px): &(usize, DVec2)| {
            let given =
                query.as_ref().and_then(|query| query.given(px, CELL_LEVEL)).map(|given| given.colour);
            let filling = given.or_else(|| Some(plate?.colour(self.met(region, px))))?;
            let own_colour = self.own.colour(px, CELL_LEVEL.min(self.own.level_for(f64::INFINITY)));
            let gain = self.context.gains.of_photo[self.photo.index()].map(|gain| gain as f32);
            let (log, falloff) = (|value: f32| value.max(1e-3).ln(), self.log_falloff(px) as f32);
            Some((index, [0, 1, 2].map(|c| log(own_colour[c]) - gain[c] - falloff - log(filling[c]))))
        };
        cells.iter().filter_map(difference).collect()
    }

    /// Returns the factor per channel that takes colours from the common exposure to the photo's own at a position.
    pub fn factor(&self, px: DVec2) -> [f32; 3] {
        let falloff = self.log_falloff(px);
        self.context.gains.of_photo[self.photo.index()].map(|gain| (gain + falloff).exp() as f32)
    }

    /// Returns the logarithm by which the photo's lens darkens a position.
    fn log_falloff(&self, px: DVec2) -> f64 {
        let optics = &self.context.gains.optics[self.photo.index()];
        optics.log_light(squared_radius(&self.own.camera, px))
    }

    /// Returns the rectangle of the whole photo.
    pub fn frame(&self) -> PixelRect {
        self.own.camera.rect()
    }

    /// Returns the point, in world coordinates, of a region's true surface (with relief) that is seen at a
    /// photo position in pixels.
    pub fn met(&self, region: &Region, px: DVec2) -> DVec3 {
        self.on_surface(region.surface, self.context.surfaces.get(region.surface), px)
    }

    fn on_surface(&self, id: FillSurfaceId, surface: &FillSurface, px: DVec2) -> DVec3 {
        let pose = self.own.item(id).map_or(self.own.pose, |item| self.own.pose_on(item));
        let eye = pose.center_in_world();
        let ray = pose.rotation.transpose() * self.own.camera.ray_in_camera(px);
        let plane = &surface.plane;
        let on_plane = eye - ray * (plane.signed_distance(eye) / plane.normal.dot(ray));
        self.context.met(surface, eye, on_plane)
    }

    /// Encodes linear light as samples of the photo (8 bits are scaled to the full range of 16).
    pub fn stored(&self, linear: [f32; 3]) -> [u16; 3] {
        let srgb = Srgb::tables();
        linear.map(|light| match self.own.bits {
            16 => (srgb_from_linear(f64::from(light).clamp(0.0, 1.0)) * 65535.0).round() as u16,
            _ => u16::from(srgb.encoded(light)) * 257,
        })
    }
}

/// Returns the centre of a pixel.
pub(super) fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// Groups a region's spans by the blocks that they touch.
fn blocks(index: usize, region: &Region) -> Vec<QueryBlock<'_>> {
    let mut found: BTreeMap<[u32; 2], Vec<&HiddenSpan>> = BTreeMap::new();
    for hidden in &region.spans {
        let row = hidden.span.y / BLOCK * BLOCK;
        for column in hidden.span.x0 / BLOCK..=(hidden.span.x1 - 1) / BLOCK {
            found.entry([row, column * BLOCK]).or_default().push(hidden);
        }
    }
    let block = |([y, x], spans): ([u32; 2], Vec<_>)| QueryBlock { region: index, corner: [x, y], spans };
    found.into_iter().map(block).collect()
}

/// A query for points of one block: the donors ranked for it.
pub(super) struct Query<'a> {
    asking: &'a Asking<'a>,
    id: FillSurfaceId,
    surface: &'a FillSurface,
    /// The pose from which the photo sees the surface.
    pose: Pose,
    ranked_donors: Vec<RankedDonor<'a>>,
    /// True when some donor may have paint in the block.
    painted: bool,
}

impl<'a> Query<'a> {
    /// Ranks the donors for a block; returns `None` where no donor may know anything.
    fn new(asking: &'a Asking<'a>, region: &Region, [x, y]: [u32; 2]) -> Option<Self> {
        let SurfaceSide { id, back } = asking.side(region)?;
        let surface = asking.context.surfaces.get(id);
        let own = asking.own;
        let item = own.item(id)?;
        let pose = own.pose_on(item);
        let eye = pose.center_in_world();
        let (low, high) = (0.5, f64::from(BLOCK) - 0.5);
        let middle = f64::from(BLOCK) / 2.0;
        let offsets = [(middle, middle), (low, low), (high, low), (low, high), (high, high)];
        let probes = offsets
            .map(|(dx, dy)| asking.on_surface(id, surface, DVec2::new(f64::from(x) + dx, f64::from(y) + dy)));
        let depth = pose.camera_from_world(probes[0]).z;
        // The block's middle may lie beyond the horizon of the plane, where no point of it is met.
        let depth = if depth > 0.0 { depth } else { pose.camera_from_world(surface.outline[0]).z.abs() };
        let density = pixels_per_unit(&own.camera, &surface.plane, eye, depth.max(f64::MIN_POSITIVE));
        let most_angle = if surface.billboard { BILLBOARD_ANGLE } else { std::f64::consts::PI };
        let (plane, clearly) = (surface.plane, surface.backdrop);
        let viewpoint = own.seen_from(item, probes[0]);
        let probes = &probes;
        let spot = ColourQuery { surface: id, plane, back, viewpoint, most_angle, density, probes, clearly };
        let ranked_donors = ranked_donors(asking.donors, asking.context.gains, &spot);
        let painted = ranked_donors.iter().any(|ranked_donor| may_have_paint(ranked_donor, probes));
        (!ranked_donors.is_empty()).then_some(Self { asking, id, surface, pose, ranked_donors, painted })
    }

    /// Returns the point that the photo sees at a position in pixels.
    fn point(&self, px: DVec2) -> DVec3 {
        self.asking.on_surface(self.id, self.surface, px)
    }

    /// Returns the donors' colour for the point that the photo sees at a position in pixels.
    pub fn given(&self, px: DVec2, coarser: usize) -> Option<DonatedColour> {
        given(&self.ranked_donors, self.point(px), coarser)
    }

    /// Returns the paint that the donors have there.
    pub fn offered(&self, px: DVec2) -> Option<OfferedPaint> {
        if !self.painted {
            return None;
        }
        let Asking { context, own, .. } = self.asking;
        let (plane, point) = (&self.surface.plane, self.point(px));
        let (eye, depth) = (self.pose.center_in_world(), self.pose.camera_from_world(point).z);
        let density = pixels_per_unit(&own.camera, plane, eye, depth);
        let serving = &context.serving[self.surface.face.0 as usize];
        offered(&self.ranked_donors, serving, plane, point, density)
    }
}

/// Returns true when a donor has paint within the quadrangle of a block's probes, or when one of these lies
/// behind its camera.
fn may_have_paint(ranked_donor: &RankedDonor, probes: &[DVec3]) -> bool {
    let Some(paint) = ranked_donor.paint() else { return false };
    let found: Vec<DVec2> = probes.iter().filter_map(|point| ranked_donor.image_from_world(*point)).collect();
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
