//! Plates: surfaces rectified to their own plane, with the parts that no photo shows synthesised once for all
//! photos.
//!
//! A plate is an image in the plane of the surface, in the common exposure, with its rows along the
//! prevailing direction of the outline's edges. In this plane windows have one size and courses of stone run
//! straight, which suits the synthesis; and what is synthesised here looks the same from every viewpoint.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::donor::Donor;
use super::exemplar::{Cell, ExemplarImage, invent};
use super::photo::FillContext;
use super::ranked_donors::{ColourQuery, given, ranked_donors};
use super::surfaces::{FillSurface, FillSurfaceId};
use super::{FillOrigin, Invent};
use quadratura_base::error::Result;
use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::raster::bilinear::Clamped;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_view::weights::pixels_per_unit;

/// The largest number of cells of a plate; larger surfaces get larger cells. Synthesised texture needs no
/// finer ones, and synthesising half a million cells takes about a second.
const MOST_CELLS: f64 = (1 << 19) as f64;

/// The largest number of photos that a plate is made from: those with paint on the surface, then those of the
/// highest resolution on it.
const MOST_PHOTOS: usize = 16;

/// The most bytes of all cached plates, whatever the memory.
const MOST_KEPT: u64 = 768 << 20;
/// The bytes of a cell of a plate.
const CELL: u64 = size_of::<[u16; 3]>() as u64;

/// Side in cells of a block that queries the same photos.
const BLOCK: usize = 32;

/// The largest square root of linear light that is stored: light of four times full range, because photos are
/// brought to a common exposure.
const MOST_ROOT: f32 = 2.0;

/// A surface rectified to its own plane.
#[derive(Debug, Clone, PartialEq)]
pub struct RectifiedTexture {
    frame: PlaneFrame,
    low: DVec2,
    cell: f64,
    size: [usize; 2],
    /// Square roots of linear light in units of [`MOST_ROOT`] / 65535, row by row.
    roots: Vec<[u16; 3]>,
    /// The method by which the unknown cells were filled.
    pub origin: FillOrigin,
}

impl RectifiedTexture {
    /// Interpolates the colour at a world point projected onto the plane: linear light in the common
    /// exposure, full range 1.
    pub fn colour(&self, point_in_world: DVec3) -> [f32; 3] {
        let at = (self.frame.flat(point_in_world) - self.low) / self.cell;
        let between = Clamped::new(at, self.size);
        [0, 1, 2].map(|c| {
            let root =
                between.mix(|x, y| f32::from(self.roots[y * self.size[0] + x][c])) * (MOST_ROOT / 65535.0);
            root * root
        })
    }
}

/// A surface and the side of it that is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SurfaceSide {
    /// The surface.
    pub id: FillSurfaceId,
    /// True for its back.
    pub back: bool,
}

/// A cache of the plates made so far.
#[derive(Debug)]
pub struct RectifiedTextures {
    memory: u64,
    /// The number of requests so far.
    requests: u64,
    /// Plates, each with the number of the last request for it.
    made: BTreeMap<SurfaceSide, (u64, Option<Arc<RectifiedTexture>>)>,
}

impl RectifiedTextures {
    /// Makes an empty cache. Beyond `memory` bytes it drops the plates that were not asked for longest; they are made again on request,
    /// with the same result.
    pub fn new(memory: u64) -> Self {
        Self { memory: memory.min(MOST_KEPT), requests: 0, made: BTreeMap::new() }
    }

    /// Makes the plates of those `sides` that are not in the cache.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn make(&mut self, context: &FillContext, mut sides: Vec<SurfaceSide>, task: &Task) -> Result<()> {
        self.requests += 1;
        sides.sort_unstable();
        sides.dedup();
        for side in &sides {
            if let Some((request, _)) = self.made.get_mut(side) {
                *request = self.requests;
            }
        }
        self.drop_oldest();
        sides.retain(|side| !self.made.contains_key(side));
        let make = |side: &SurfaceSide| {
            task.check_cancelled()?;
            Ok((*side, (self.requests, plate(context, *side)?.map(Arc::new))))
        };
        let made: Vec<_> = sides.par_iter().map(make).collect::<Result<_>>()?;
        self.made.extend(made);
        Ok(())
    }

    /// Drops what was asked for before, the oldest first, until the rest keeps to the memory.
    fn drop_oldest(&mut self) {
        let bytes = |plate: &Option<Arc<RectifiedTexture>>| {
            CELL * plate.as_ref().map_or(0, |plate| plate.roots.len() as u64)
        };
        let mut all: u64 = self.made.values().map(|(_, plate)| bytes(plate)).sum();
        let mut old: Vec<(u64, SurfaceSide)> =
            self.made.iter().map(|(side, (request, _))| (*request, *side)).collect();
        old.retain(|(request, _)| *request < self.requests);
        old.sort_unstable();
        for (_, side) in old {
            if all <= self.memory {
                break;
            }
            all -= self.made.remove(&side).map_or(0, |(_, plate)| bytes(&plate));
        }
    }

    /// Returns the plate of a side; `None` where it was not made, or where no photo shows any of the surface.
    pub fn get(&self, side: SurfaceSide) -> Option<&Arc<RectifiedTexture>> {
        self.made.get(&side)?.1.as_ref()
    }
}

/// Returns the photos that the plates of a surface are made from, rising.
pub(super) fn photos_of_plate(context: &FillContext, surface: &FillSurface) -> Vec<PhotoId> {
    PlateLayout::of_surface(context, surface).map_or_else(Vec::new, |layout| layout.photos)
}

fn plate(context: &FillContext, side: SurfaceSide) -> Result<Option<RectifiedTexture>> {
    let surface = context.surfaces.get(side.id);
    let Some(layout) = PlateLayout::of_surface(context, surface) else { return Ok(None) };
    let donors = context.donors(&layout.photos)?;
    let mut canvas = layout.canvas(surface);
    layout.gather(&mut canvas, context, &donors, side, true);
    if canvas.is_too_little() {
        layout.gather(&mut canvas, context, &donors, side, false);
    }
    if canvas.cells.iter().all(|cell| *cell != Cell::Known) {
        return Ok(None);
    }
    // The seed is the surface's own id, so that the plate is the same whatever else is filled.
    let by_example = context.options.invent == Invent::Exemplar && invent(&mut canvas, u64::from(side.id.0));
    let Some(colours) = canvas.diffused() else { return Ok(None) };
    let stored = |value: f32| (value / MOST_ROOT * 65535.0).round().clamp(0.0, 65535.0) as u16;
    let roots = colours.into_iter().map(|colour| colour.map(stored)).collect();
    let origin = if by_example { FillOrigin::Exemplar } else { FillOrigin::Diffused };
    let PlateLayout { frame, low, cell, size, .. } = layout;
    Ok(Some(RectifiedTexture { frame, low, cell, size, roots, origin }))
}

/// The position and resolution of a plate in its plane, and the photos that it is made from.
struct PlateLayout {
    frame: PlaneFrame,
    low: DVec2,
    cell: f64,
    size: [usize; 2],
    photos: Vec<PhotoId>,
}

impl PlateLayout {
    /// Lays out the part of a surface that lies within the frames of the photos that show it, in cells as
    /// fine as the best photo's pixels. Returns `None` where no photo shows any of it.
    fn of_surface(context: &FillContext, surface: &FillSurface) -> Option<Self> {
        let frame = along_edges(surface);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut densities: Vec<(f64, PhotoId)> = Vec::new();
        for &photo in &context.serving[surface.face.0 as usize] {
            let projector = &context.photos[photo.index()];
            let (camera, pose) = (&projector.camera, &projector.pose);
            let in_camera: Vec<DVec3> = surface.outline.iter().map(|p| pose.camera_from_world(*p)).collect();
            let frame_px = DVec2::new(f64::from(camera.width), f64::from(camera.height));
            let clipped = clipped_to_box(&in_camera, camera, DVec2::ZERO, frame_px);
            if clipped.is_empty() {
                continue;
            }
            for point in &clipped {
                let flat = frame.flat(pose.world_from_camera(*point));
                (low, high) = (low.min(flat), high.max(flat));
            }
            let nearest = clipped.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            let middle = clipped.iter().map(|p| p.z).sum::<f64>() / clipped.len() as f64;
            let depth = middle.max(nearest).max(f64::MIN_POSITIVE);
            densities.push((pixels_per_unit(camera, &surface.plane, pose.center_in_world(), depth), photo));
        }
        densities.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let best = densities.first().filter(|best| best.0 > 0.0 && extent.is_finite())?.0;
        let cell =
            (1.0 / best).max((extent.x * extent.y / MOST_CELLS).sqrt()).max(extent.max_element() / 4096.0);
        let size = [extent.x, extent.y].map(|side| (side / cell).ceil().max(1.0) as usize);
        let painters = &context.painters[surface.face.0 as usize];
        densities.sort_by_key(|(_, photo)| !painters.contains(photo));
        let most = MOST_PHOTOS.min(context.source.at_once());
        let mut photos: Vec<PhotoId> = densities.into_iter().take(most).map(|(_, id)| id).collect();
        photos.sort_unstable();
        Some(Self { frame, low, cell, size, photos })
    }

    fn flat(&self, x: usize, y: usize) -> DVec2 {
        self.low + (DVec2::new(x as f64, y as f64) + 0.5) * self.cell
    }

    /// Builds a canvas in which the cells within the outline are unknown and all others outside.
    fn canvas(&self, surface: &FillSurface) -> ExemplarImage {
        let ring: Vec<DVec2> = surface.outline.iter().map(|p| self.frame.flat(*p)).collect();
        let mut canvas = ExemplarImage::new(self.size);
        let width = self.size[0];
        canvas.cells.par_chunks_mut(width).enumerate().for_each(|(row, cells)| {
            for pair in crossings(&ring, self.flat(0, row).y).chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|x| ((x - self.low.x) / self.cell - 0.5).ceil());
                let [from, to] = [from, to].map(|x| (x.max(0.0) as usize).min(width));
                cells[from..to.max(from)].fill(Cell::Unknown);
            }
        });
        canvas
    }

    /// Sets unknown cells within the outline to the colours that the photos have there; only to those clear of the outlines of nearer
    /// surfaces where `clearly` is true.
    fn gather(
        &self,
        canvas: &mut ExemplarImage,
        context: &FillContext,
        donors: &[(PhotoId, Arc<Donor>)],
        side: SurfaceSide,
        clearly: bool,
    ) {
        let [width, height] = self.size;
        let columns = width.div_ceil(BLOCK);
        let blocks: Vec<(usize, usize)> = (0..columns * height.div_ceil(BLOCK))
            .map(|i| (i % columns * BLOCK, i / columns * BLOCK))
            .filter(|&(x, y)| {
                let mut rows = y..(y + BLOCK).min(height);
                rows.any(|y| canvas.cells[y * width..][x..(x + BLOCK).min(width)].contains(&Cell::Unknown))
            })
            .collect();
        let cells = &canvas.cells;
        let found: Vec<Vec<(usize, [f32; 3])>> = blocks
            .par_iter()
            .map(|block| self.gather_block(cells, context, donors, side, clearly, *block))
            .collect();
        for (index, colour) in found.into_iter().flatten() {
            (canvas.cells[index], canvas.colours[index]) = (Cell::Known, colour);
        }
    }

    /// Returns the known cells of one block: their indices, and the square roots of their colours.
    fn gather_block(
        &self,
        cells: &[Cell],
        context: &FillContext,
        donors: &[(PhotoId, Arc<Donor>)],
        SurfaceSide { id, back }: SurfaceSide,
        clearly: bool,
        (x0, y0): (usize, usize),
    ) -> Vec<(usize, [f32; 3])> {
        let [width, height] = self.size;
        let surface = context.surfaces.get(id);
        let (x1, y1) = ((x0 + BLOCK).min(width), (y0 + BLOCK).min(height));
        let point = |x: usize, y: usize| context.point_on_relief(surface, self.frame.raised(self.flat(x, y)));
        let [middle_x, middle_y] = [(x0 + x1) / 2, (y0 + y1) / 2];
        let probes = [(middle_x, middle_y), (x0, y0), (x1 - 1, y0), (x0, y1 - 1), (x1 - 1, y1 - 1)]
            .map(|(x, y)| point(x, y));
        let outwards = if back { -surface.plane.normal } else { surface.plane.normal };
        // The viewpoint is far away and straight on, so that the photo that sees the surface most frontally
        // is preferred.
        let viewpoint = probes[0] + outwards * (self.cell * 1e6);
        let density = 1.0 / self.cell;
        let most_angle = std::f64::consts::PI;
        let (plane, probes) = (surface.plane, &probes);
        let spot = ColourQuery { surface: id, plane, back, viewpoint, most_angle, density, probes, clearly };
        let ranked_donors = ranked_donors(donors, context.gains, &spot);
        if ranked_donors.is_empty() {
            return Vec::new();
        }
        let inner = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
        let inner = inner.filter(|&(x, y)| cells[y * width + x] == Cell::Unknown);
        let known = inner.filter_map(|(x, y)| {
            let given = given(&ranked_donors, point(x, y), 0)?;
            Some((y * width + x, given.colour.map(|c| c.max(0.0).sqrt())))
        });
        known.collect()
    }
}

/// Returns the abscissas at which a row crosses a ring, in rising order.
fn crossings(ring: &[DVec2], y: f64) -> Vec<f64> {
    let edges = (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]));
    let crossed = edges.filter(|(a, b)| (a.y <= y) != (b.y <= y));
    let mut crossings: Vec<f64> = crossed.map(|(a, b)| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)).collect();
    crossings.sort_by(f64::total_cmp);
    crossings
}

/// Returns a frame of the plane with one axis along the prevailing direction of the outline's edges, where
/// edges at right angles to each other count for the same direction: facades repeat along their edges.
fn along_edges(surface: &FillSurface) -> PlaneFrame {
    let frame = PlaneFrame::from_plane(&surface.plane);
    let ring: Vec<DVec2> = surface.outline.iter().map(|p| frame.flat(*p)).collect();
    let edges = (0..ring.len()).map(|i| ring[(i + 1) % ring.len()] - ring[i]);
    // The angles are multiplied by four, so that edges at right angles to each other agree (mean of
    // directions).
    let sum = edges
        .filter(|edge| edge.length() > 0.0)
        .fold(DVec2::ZERO, |sum, edge| sum + DVec2::from_angle(4.0 * edge.to_angle()) * edge.length());
    let angle = if sum.length() > 0.0 { sum.to_angle() / 4.0 } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    PlaneFrame { u: frame.u * cos + frame.v * sin, v: frame.v * cos - frame.u * sin, ..frame }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::Plane;
    use quadratura_base::scene::FaceId;

    #[test]
    fn a_leaning_rectangle_is_laid_along_its_edges() {
        let (u, v) = (DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.8, 0.6, 0.0));
        let outline = vec![DVec3::ZERO, u * 4.0, u * 4.0 + v, v];
        let plane = Plane { normal: DVec3::Z, point: DVec3::ZERO };
        let frame = along_edges(&FillSurface {
            face: FaceId(0),
            triangle: None,
            plane,
            outline,
            billboard: false,
            backdrop: false,
        });
        assert!(frame.u.dot(u).abs() > 1.0 - 1e-12 || frame.u.dot(v).abs() > 1.0 - 1e-12);
        assert!((frame.u.cross(frame.v) - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn the_plates_that_were_not_asked_for_longest_are_dropped() {
        let plane = Plane { normal: DVec3::Z, point: DVec3::ZERO };
        let plate = RectifiedTexture {
            frame: PlaneFrame::from_plane(&plane),
            low: DVec2::ZERO,
            cell: 1.0,
            size: [10, 1],
            roots: vec![[0; 3]; 10],
            origin: FillOrigin::Exemplar,
        };
        let side = |id: u32| SurfaceSide { id: FillSurfaceId(id), back: false };
        let mut plates = RectifiedTextures::new(3 * 10 * CELL);
        plates.requests = 9;
        let asked_for = [4, 9, 2, 7, 9];
        plates.made = (0..).map(side).zip(asked_for.map(|at| (at, Some(Arc::new(plate.clone()))))).collect();
        plates.drop_oldest();
        assert_eq!(
            [0, 1, 2, 3, 4].map(|id| plates.get(side(id)).is_some()),
            [false, true, false, true, true]
        );
        plates.memory = 0;
        plates.drop_oldest();
        assert_eq!(plates.made.len(), 2, "what the present photo needs stays");
    }

    #[test]
    fn a_row_enters_and_leaves_a_ring_with_a_bridged_hole_twice() {
        let ring = [
            (0.0, 0.0),
            (9.0, 0.0),
            (9.0, 9.0),
            (0.0, 9.0),
            (0.0, 0.0),
            (3.0, 3.0),
            (3.0, 6.0),
            (6.0, 6.0),
            (6.0, 3.0),
            (3.0, 3.0),
        ]
        .map(|(x, y)| DVec2::new(x, y));
        assert_eq!(crossings(&ring, 4.5), [0.0, 3.0, 6.0, 9.0]);
    }
}
