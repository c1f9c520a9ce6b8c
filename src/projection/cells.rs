//! Which photos can matter where: the view's pixels in square cells, and for every face in a cell the
//! servers that may be among the k best (or be the (k+1)-th) at any of its points, by rising least
//! penalty. Bounds are proven over a ball around what the cell shows of the face, so that a shader that
//! stops where the next least penalty exceeds its worst has left out none.

mod bounds;

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::bounds::{angles, borders, projected_ball};
use super::relief::LEAST_FACING;
use super::shot::{MOST_TAPS, Mode, Quality, Shot};
use super::sources::{Projector, Server, Sources};
use super::weights::{LEAST_ANGLE, OTHER_SIDE};
use crate::geometry::clip::clipped_to_box;
use crate::geometry::{Pinhole, PixelRect, Plane, Pose};
use crate::scene::{Face, FaceId, Model};

/// Sides of the blocks that are looked at before a cell, in cells, from coarse to fine: a server that
/// cannot matter in a block is not asked again in its cells.
const BLOCKS: [u32; 2] = [8, 2];

/// What is known of confidence without looking at texels.
pub trait Confidence: Sync {
    /// A lower bound of the confidence of a server's sheet within `low_px..high_px` (photo pixels, what a
    /// filter reaches included); 0 where nothing is known.
    fn least(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64;
}

/// Nothing is known.
#[derive(Debug, Clone, Copy)]
pub struct Unknown;

impl Confidence for Unknown {
    fn least(&self, _: &Server, _: DVec2, _: DVec2) -> f64 {
        0.0
    }
}

/// One server in one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Its place in [`Sources::servers`].
    pub server: u32,
    /// No point of the cell has a smaller penalty, in radians; 0 for a pinned photo.
    pub least: f64,
    /// Photo pixels that the cell may look up there, within the sheet's rectangle.
    pub rect: PixelRect,
    /// The finest level that it may look up: texels of 2^-level per pixel at most.
    pub finest: u32,
}

/// The cells of one face: a rectangle of the view's cells in row order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceCells {
    /// The face.
    pub face: FaceId,
    /// Column and row of the first cell, in cells.
    pub corner: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
    /// Of its first cell, in [`Cells::ranges`].
    pub first: u32,
}

/// All cells of a view.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cells {
    /// Side of a cell in pixels of the view.
    pub side_px: u32,
    /// The faces that the view may show, in model order.
    pub faces: Vec<FaceCells>,
    /// For every cell its range in `candidates`.
    pub ranges: Vec<Range<u32>>,
    /// By cell, then rising least penalty.
    pub candidates: Vec<Candidate>,
    /// Depths of the nearest and the farthest point that the view shows; 0 where it shows none.
    pub depths: [f64; 2],
}

/// The near plane is nearer than anything seen by this share, and by this share of the farthest depth
/// not nearer: depths are f32, whose exponent has room.
const NEAR: [f64; 2] = [0.5, 1e-9];

impl Cells {
    /// A near plane's depth that cuts nothing off, in world units.
    pub fn near(&self) -> f64 {
        let [nearest, farthest] = self.depths;
        (NEAR[0] * nearest).max(NEAR[1] * farthest).max(f64::from(f32::MIN_POSITIVE) * 1e6)
    }

    /// The candidates of a face in the cell with this column and row.
    pub fn of(&self, face: &FaceCells, column: u32, row: u32) -> &[Candidate] {
        let (x, y) = (column.wrapping_sub(face.corner[0]), row.wrapping_sub(face.corner[1]));
        if x >= face.size[0] || y >= face.size[1] {
            return &[];
        }
        let range = &self.ranges[(face.first + y * face.size[0] + x) as usize];
        &self.candidates[range.start as usize..range.end as usize]
    }
}

/// The cells of a shot. `side_px` is a cell's side; `heights` says by face how far, in world units, its
/// relief stands off its plane at most (faces beyond the list: not at all).
pub fn cells(
    model: &Model,
    sources: &Sources,
    shot: &Shot,
    side_px: u32,
    heights: &[f64],
    confidence: &impl Confidence,
) -> Cells {
    let finder = Finder { model, sources, shot, side: f64::from(side_px), heights, confidence };
    let found: Vec<Found> =
        model.face_ids().collect::<Vec<_>>().into_par_iter().filter_map(|face| finder.face(face)).collect();
    let depths = found.iter().map(|f| f.depths).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let mut cells = Cells { side_px, depths: depths.unwrap_or_default(), ..Cells::default() };
    for face in found {
        let first = cells.ranges.len() as u32;
        cells.faces.push(FaceCells { face: face.face, corner: face.corner, size: face.size, first });
        for list in face.lists {
            let start = cells.candidates.len() as u32;
            cells.candidates.extend(list);
            cells.ranges.push(start..cells.candidates.len() as u32);
        }
    }
    cells
}

/// The cells of one face, before they are put together.
struct Found {
    face: FaceId,
    corner: [u32; 2],
    size: [u32; 2],
    depths: [f64; 2],
    lists: Vec<Vec<Candidate>>,
}

struct Finder<'a, C> {
    model: &'a Model,
    sources: &'a Sources,
    shot: &'a Shot,
    side: f64,
    heights: &'a [f64],
    confidence: &'a C,
}

/// What a face is to all its cells.
struct Subject<'a> {
    face: &'a Face,
    billboard: bool,
    /// The view sees it from behind.
    back: bool,
    /// Its relief's largest height.
    height: f64,
    /// Distance of the viewpoint from its plane.
    clearance: f64,
    /// Column and row of its first cell, in the view's cells.
    corner: [u32; 2],
}

/// A rectangle of a face's cells, to be looked at block by block.
struct Block<'a> {
    /// What it shows of the face, in the view's camera frame.
    polygon: &'a [DVec3],
    /// Those that may matter in it.
    servers: &'a [u32],
    /// From column and row to column and row, in the face's cells.
    cells: [u32; 4],
    /// Sides of the blocks in it, in cells, from coarse to fine; none: single cells.
    steps: &'a [u32],
}

/// What a block of cells shows of a face.
struct Patch {
    /// Corners of the part of the outline that the block shows, in the view's camera frame.
    polygon: Vec<DVec3>,
    /// Middle of a ball that holds it, in the view's camera frame and in the world.
    middle: DVec3,
    middle_in_world: DVec3,
    /// The ball's radius, with what the relief adds.
    radius: f64,
}

impl<C: Confidence> Finder<'_, C> {
    fn face(&self, id: FaceId) -> Option<Found> {
        let face = self.model.face(id);
        let outline: Vec<DVec3> =
            self.model.ring_points(id).map(|p| self.shot.pose.camera_from_world(p)).collect();
        let camera = &self.shot.camera;
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        // Of a concave outline all that is used is what it spans.
        let polygon = clipped_to_box(&outline, camera, DVec2::ZERO, DVec2::new(width, height));
        let (low, high) = extent(&polygon, camera)?;
        let cell = |px: f64, limit: f64| (px.clamp(0.0, limit - 0.5) / self.side) as u32;
        let corner = [cell(low.x, width), cell(low.y, height)];
        let size = [cell(high.x, width) - corner[0] + 1, cell(high.y, height) - corner[1] + 1];
        let object = self.model.object(face.object);
        let back = face.plane.normal.dot(self.shot.viewpoint() - face.plane.point) < 0.0;
        let subject = Subject {
            face,
            billboard: object.billboard,
            back,
            height: self.heights.get(id.0 as usize).copied().unwrap_or(0.0),
            clearance: distance(&face.plane, self.shot.viewpoint()),
            corner,
        };
        let range = &self.sources.of_face[id.0 as usize];
        let all: Vec<u32> = range.clone().filter(|&s| self.may_serve(&subject, s)).collect();
        let mut lists = vec![Vec::new(); (size[0] * size[1]) as usize];
        let block =
            Block { polygon: &polygon, servers: &all, cells: [0, 0, size[0], size[1]], steps: &BLOCKS };
        self.descend(&subject, &block, &mut |x, y, list| lists[(y * size[0] + x) as usize] = list);
        let depths = polygon.iter().fold([f64::INFINITY, 0.0f64], |[a, b], p| [a.min(p.z), b.max(p.z)]);
        Some(Found { face: id, corner, size, depths, lists })
    }

    fn may_serve(&self, subject: &Subject, server: u32) -> bool {
        let server = &self.sources.servers[server as usize];
        // The triangles of a face that is not planar have sides of their own.
        let side = server.back == subject.back || subject.billboard || !subject.face.planar;
        side && !self.shot.without.contains(&server.photo)
    }

    /// Gives `put` the candidates of every single cell of a block, at its column and row in the face.
    fn descend(&self, subject: &Subject, block: &Block, put: &mut impl FnMut(u32, u32, Vec<Candidate>)) {
        let [x0, y0, x1, y1] = block.cells;
        let step = block.steps.first().copied().unwrap_or(1);
        for y in (y0..y1).step_by(step as usize) {
            for x in (x0..x1).step_by(step as usize) {
                let cells = [x, y, (x + step).min(x1), (y + step).min(y1)];
                let Some(patch) = self.patch(subject, self.shown_of(subject, block.polygon, cells)) else {
                    continue;
                };
                let list = self.candidates(subject, &patch, block.servers);
                if block.steps.is_empty() {
                    put(x, y, list);
                    continue;
                }
                let servers: Vec<u32> = list.iter().map(|c| c.server).collect();
                let steps = &block.steps[1..];
                let inner = Block { polygon: &patch.polygon, servers: &servers, cells, steps };
                self.descend(subject, &inner, put);
            }
        }
    }

    /// The part of a polygon that these cells show.
    fn shown_of(&self, subject: &Subject, polygon: &[DVec3], [x0, y0, x1, y1]: [u32; 4]) -> Vec<DVec3> {
        let [column, row] = subject.corner;
        let px = |x: u32, y: u32| DVec2::new(f64::from(column + x), f64::from(row + y)) * self.side;
        clipped_to_box(polygon, &self.shot.camera, px(x0, y0), px(x1, y1))
    }

    fn patch(&self, subject: &Subject, polygon: Vec<DVec3>) -> Option<Patch> {
        if polygon.is_empty() {
            return None;
        }
        let (low, high) = polygon
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let middle = (low + high) / 2.0;
        let radius = polygon.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        // The relief moves a point along its ray, by height / cosine at most.
        let facing = (subject.clearance / (middle.length() + radius)).max(LEAST_FACING);
        let radius = radius + subject.height / facing;
        Some(Patch { middle_in_world: self.shot.pose.world_from_camera(middle), polygon, middle, radius })
    }

    /// Those of `servers` that may matter in the patch, by rising least penalty.
    fn candidates(&self, subject: &Subject, patch: &Patch, servers: &[u32]) -> Vec<Candidate> {
        let mut list = Vec::with_capacity(servers.len());
        let mut worst = Vec::with_capacity(servers.len());
        for &server in servers {
            if let Some((candidate, most)) = self.bounds(subject, patch, server) {
                list.push(candidate);
                worst.push(most);
            }
        }
        // The (k+1)-th smallest of the upper bounds: T is nowhere larger.
        let most = if self.shot.blend.mode == Mode::Best { 1 } else { self.shot.blend.photos.max(1) };
        if worst.len() > most as usize {
            let (_, limit, _) = worst.select_nth_unstable_by(most as usize, f64::total_cmp);
            let limit = *limit;
            list.retain(|c| c.least <= limit);
        }
        list.sort_by(|a, b| a.least.total_cmp(&b.least).then(a.server.cmp(&b.server)));
        list
    }

    /// One server in a patch, with the upper bound of its penalty; `None` where it serves no point of it.
    fn bounds(&self, subject: &Subject, patch: &Patch, id: u32) -> Option<(Candidate, f64)> {
        let server = &self.sources.servers[id as usize];
        let photo = self.sources.photo(server.photo);
        let blend = &self.shot.blend;
        let angle =
            angles(patch.middle_in_world, patch.radius, self.shot.viewpoint(), photo.pose.center_in_world());
        let density = self.octaves(subject, patch, &photo.camera, &photo.pose);
        let seen = self.footprint(patch, server, photo, density.start)?;
        let octaves = match blend.mode {
            Mode::Debevec => 0.0..0.0,
            Mode::Best | Mode::Lumigraph | Mode::Smooth => density.start.max(0.0)..density.end.max(0.0),
        };
        let other_side = subject.billboard && server.back != subject.back;
        let apart = if other_side { OTHER_SIDE } else { 0.0 };
        let sum = |angle: f64, octaves: f64| angle + apart + blend.lambda * octaves + LEAST_ANGLE;
        let trust = match blend.mode {
            Mode::Debevec if seen.trust.start > 0.0 => 1.0..1.0,
            Mode::Debevec => 0.0..1.0,
            Mode::Best | Mode::Lumigraph | Mode::Smooth => seen.trust,
        };
        let most = if seen.whole { sum(angle.end, octaves.end) / trust.start } else { f64::INFINITY };
        let least = sum(angle.start, octaves.start) / trust.end;
        // Anisotropic lookups take the shorter axis of the footprint: at most so much finer than the
        // mean of the two.
        let finer = if self.shot.quality == Quality::Final { MOST_TAPS.log2() / 2.0 } else { 0.0 };
        let finest = (-density.end - finer).max(0.0) as u32;
        // A pinned photo comes before all others, and takes no one's place.
        let (least, most) = if server.pinned { (0.0, f64::INFINITY) } else { (least, most) };
        Some((Candidate { server: id, least, rect: seen.rect, finest }, most))
    }

    /// Where the photo has the patch, if at all; `octaves`: the least that it lacks.
    fn footprint(
        &self,
        patch: &Patch,
        server: &Server,
        photo: &Projector,
        octaves: f64,
    ) -> Option<Footprint> {
        let Projector { camera, pose, .. } = photo;
        let middle = pose.camera_from_world(patch.middle_in_world);
        if middle.z + patch.radius <= 0.0 {
            return None;
        }
        let (low, high) = projected_ball(middle, patch.radius, camera);
        let rect = self.sources.sheet(server.sheet).rect;
        // A texel's filter reaches half a texel further.
        let edge = DVec2::new(f64::from(rect.x), f64::from(rect.y)) - 1.0;
        let far_edge = DVec2::new(f64::from(rect.right()), f64::from(rect.bottom())) + 1.0;
        if high.cmplt(edge).any() || low.cmpgt(far_edge).any() {
            return None;
        }
        let pixels = PixelRect::from_edges(
            low.x.max(edge.x) as i32 - 1,
            low.y.max(edge.y) as i32 - 1,
            high.x.min(far_edge.x) as i32 + 2,
            high.y.min(far_edge.y) as i32 + 2,
        );
        let border = borders(camera, low, high);
        if border.end <= 0.0 {
            return None;
        }
        let least = match self.shot.quality {
            // A filter of level l reaches 2^l texels, a share of the level above twice that.
            Quality::Preview if border.start > 0.0 => {
                let reach = 2.0 * (-octaves).max(0.0).ceil().exp2();
                self.confidence.least(server, low - reach, high + reach)
            }
            // Anisotropic footprints have no bound that is worth anything.
            _ => 0.0,
        };
        let whole = server.domain.is_whole() && middle.z > patch.radius;
        Some(Footprint { trust: border.start * least..border.end, whole, rect: pixels.intersection(&rect) })
    }

    /// Bounds of the octaves that the photo lacks; below 0, of those that it has to spare.
    fn octaves(&self, subject: &Subject, patch: &Patch, camera: &Pinhole, pose: &Pose) -> Range<f64> {
        let photo_depth = pose.camera_from_world(patch.middle_in_world).z;
        let depths = (photo_depth - patch.radius, photo_depth + patch.radius);
        let view_depths = (patch.middle.z - patch.radius, patch.middle.z + patch.radius);
        if !subject.face.planar || depths.0 <= 0.0 || view_depths.0 <= 0.0 {
            return f64::NEG_INFINITY..f64::INFINITY;
        }
        let density = |camera: &Pinhole, height: f64, depth: f64| {
            (camera.fx * camera.fy * height / (depth * depth * depth)).sqrt()
        };
        let plane = &subject.face.plane;
        let (view, photo) = (&self.shot.camera, self.shot.viewpoint());
        let (in_view, in_photo) = (distance(plane, photo), distance(plane, pose.center_in_world()));
        let octaves = |of_view: f64, of_photo: f64| {
            (density(view, in_view, of_view) / density(camera, in_photo, of_photo)).log2()
        };
        octaves(view_depths.1, depths.0)..octaves(view_depths.0, depths.1)
    }
}

/// Where a photo has a patch.
struct Footprint {
    /// Bounds of border times confidence.
    trust: Range<f64>,
    /// The server serves all of it.
    whole: bool,
    /// In photo pixels, within the sheet.
    rect: PixelRect,
}

fn distance(plane: &Plane, point: DVec3) -> f64 {
    plane.normal.dot(point - plane.point).abs()
}

/// The box of a clipped polygon, in pixels; `None` where nothing is left.
fn extent(polygon: &[DVec3], camera: &Pinhole) -> Option<(DVec2, DVec2)> {
    let mut px = polygon.iter().filter_map(|p| camera.image_from_camera(*p)).filter(|p| p.is_finite());
    let first = px.next()?;
    Some(px.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
}

#[cfg(test)]
mod tests;
