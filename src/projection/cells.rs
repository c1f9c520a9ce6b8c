//! Shortlists of photos. The view's pixels are divided into square cells, and for every face in a cell this
//! lists the servers that may be among the k best (or be the (k+1)-th) at any of its points, by rising lower
//! bound of their penalty. Bounds are proven over a ball around the part of the face in the cell, so that a
//! shader that stops where the next lower bound exceeds its worst penalty has missed none.

mod blocks;
mod bounds;
pub mod depths;

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::blocks::CellBlock;
use self::bounds::{angles, angles_apart, borders, projected_ball};
use super::relief::LEAST_FACING;
use super::sources::{Server, Sources};
use super::surroundings::{self, SurroundingsCells};
use super::turned::{MIRRORED, PhotoOnFace};
use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::{Pinhole, PixelRect, Plane, Pose};
use quadratura_base::raster::robust::of_rank;
use quadratura_base::scene::{Face, FaceId, Model};
use quadratura_view::shot::{MOST_TAPS, Mode, Quality, Shot};
use quadratura_view::weights::{LEAST_ANGLE, OTHER_SIDE};

/// Sides of the blocks that are examined before single cells, in cells, from coarse to fine: a server that
/// cannot contribute in a block is not examined again in its cells.
const BLOCKS: [u32; 2] = [8, 2];

/// A source of lower bounds of confidence that needs no access to texels.
pub trait TexelBounds: Sync {
    /// Returns a lower bound of the confidence of a server's layer texture within `low_px..high_px` (photo pixels,
    /// including the reach of filters); 0 where none is known.
    fn least(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64;

    /// Returns a lower bound of the agreement of a server's layer texture within `low_px..high_px` (photo pixels), above
    /// 0; 1 where photos do not contradict each other.
    fn least_agreement(&self, _server: &Server, _low_px: DVec2, _high_px: DVec2) -> f64 {
        1.0
    }
}

/// A source of bounds that knows none.
#[derive(Debug, Clone, Copy)]
pub struct Unknown;

impl TexelBounds for Unknown {
    fn least(&self, _: &Server, _: DVec2, _: DVec2) -> f64 {
        0.0
    }
}

/// A server that may contribute in one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServerCandidate {
    /// The index of the server in [`Sources::servers`].
    pub server: u32,
    /// The lower bound of the penalty over all points of the cell, in radians; 0 for a pinned photo.
    pub least: f64,
    /// The photo pixels that lookups from the cell may reach, within the layer texture's rectangle.
    pub rect: PixelRect,
    /// The finest level that lookups may use: at most 2^-level texels per pixel.
    pub finest: u32,
}

/// The cells of one face: a rectangle of the view's cells in row order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceCells {
    /// The face.
    pub face: FaceId,
    /// Column and row of the first cell, in cells of the view.
    pub corner: [u32; 2],
    /// The number of columns and rows.
    pub size: [u32; 2],
    /// The index of the first cell in [`Cells::ranges`].
    pub first: u32,
}

/// The cells of a view with their candidates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cells {
    /// Side of a cell in pixels of the view.
    pub side_px: u32,
    /// The faces that the view may show, in model order.
    pub faces: Vec<FaceCells>,
    /// The range of every cell in `candidates`.
    pub ranges: Vec<Range<u32>>,
    /// The candidates, by cell, then by rising lower bound.
    pub candidates: Vec<ServerCandidate>,
    /// The cells of the surroundings; `None` where the view shows none.
    pub surroundings: Option<SurroundingsCells>,
    /// The depths of the nearest and the farthest visible point, in world units; 0 where none is visible.
    pub depths: [f64; 2],
}

/// The position of the near plane: at this share of the nearest visible depth, and at least this share of the
/// farthest depth. Depths are f32, whose exponent leaves ample room.
const NEAR: [f64; 2] = [0.5, 1e-9];

impl Cells {
    /// Returns the depth of a near plane that clips nothing visible, in world units.
    pub fn near(&self) -> f64 {
        let [nearest, farthest] = self.depths;
        (NEAR[0] * nearest).max(NEAR[1] * farthest).max(f64::from(f32::MIN_POSITIVE) * 1e6)
    }

    /// Returns the candidates of a face in the cell with this column and row of the view.
    pub fn of(&self, face: &FaceCells, column: u32, row: u32) -> &[ServerCandidate] {
        let (x, y) = (column.wrapping_sub(face.corner[0]), row.wrapping_sub(face.corner[1]));
        if x >= face.size[0] || y >= face.size[1] {
            return &[];
        }
        let range = &self.ranges[(face.first + y * face.size[0] + x) as usize];
        &self.candidates[range.start as usize..range.end as usize]
    }
}

/// Computes the cells of a view, with the model as the view sees it ([`Model::facing`]). `side_px` is a cell's side;
/// `heights` holds for each face the largest height of its relief in world units (0 for faces beyond the list), `leaning` the factor of each photo's penalties (1 beyond the
/// list).
pub fn cells(
    model: &Model,
    sources: &Sources,
    shot: &Shot,
    side_px: u32,
    heights: &[f64],
    leaning: &[f64],
    confidence: &impl TexelBounds,
) -> Cells {
    Finder { model, sources, shot, side_px, heights, leaning, confidence }.cells()
}

/// The cells of one face, before all faces' cells are joined.
struct CellsOfFace {
    face: FaceId,
    corner: [u32; 2],
    size: [u32; 2],
    depths: [f64; 2],
    lists: Vec<Vec<ServerCandidate>>,
}

/// What the candidates of cells are found with; the arguments of [`cells`].
#[derive(Debug)]
pub struct Finder<'a, C> {
    /// The model as the view sees it.
    pub model: &'a Model,
    /// The photos and their servers.
    pub sources: &'a Sources,
    /// The view.
    pub shot: &'a Shot,
    /// The side of a cell, in pixels of the view.
    pub side_px: u32,
    /// The largest height of each face's relief, in world units.
    pub heights: &'a [f64],
    /// The factor of each photo's penalties.
    pub leaning: &'a [f64],
    /// Bounds of confidence.
    pub confidence: &'a C,
}

/// The properties of a face that are common to all its cells.
struct FaceData<'a> {
    id: FaceId,
    face: &'a Face,
    billboard: bool,
    impostor: bool,
    /// True when the view sees the face from behind.
    back: bool,
    /// The largest height of the face's relief, in world units.
    height: f64,
    /// The distance of the viewpoint from the face's plane, in world units.
    clearance: f64,
    /// Column and row of the face's first cell, in cells of the view.
    corner: [u32; 2],
}

/// The candidates of a cell, by its column and row in the face.
struct FoundCell {
    x: u32,
    y: u32,
    list: Vec<ServerCandidate>,
}

/// The part of a face within a block of cells.
struct FacePatch {
    /// Corners of the part of the outline in the block, in the view's camera frame.
    polygon: Vec<DVec3>,
    /// The centre of a ball that contains the part: here in the view's camera frame, below in world
    /// coordinates.
    middle: DVec3,
    middle_in_world: DVec3,
    /// The ball's radius, in world units, including the movement by relief.
    radius: f64,
}

impl<C: TexelBounds> Finder<'_, C> {
    /// Computes the cells of the view.
    pub fn cells(&self) -> Cells {
        let found: Vec<CellsOfFace> = self
            .model
            .face_ids()
            .collect::<Vec<_>>()
            .into_par_iter()
            .filter_map(|face| self.face(face))
            .collect();
        let depths = found.iter().map(|f| f.depths).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let mut cells =
            Cells { side_px: self.side_px, depths: depths.unwrap_or_default(), ..Cells::default() };
        for face in found {
            let first = cells.ranges.len() as u32;
            cells.faces.push(FaceCells { face: face.face, corner: face.corner, size: face.size, first });
            for list in face.lists {
                let start = cells.candidates.len() as u32;
                cells.candidates.extend(list);
                cells.ranges.push(start..cells.candidates.len() as u32);
            }
        }
        let (columns, reach, lists) =
            surroundings::lists(self.sources, self.shot, self.side_px, self.leaning);
        let first = cells.ranges.len() as u32;
        cells.surroundings = (!lists.is_empty()).then_some(SurroundingsCells { first, columns, reach });
        for list in lists {
            let start = cells.candidates.len() as u32;
            cells.candidates.extend(list);
            cells.ranges.push(start..cells.candidates.len() as u32);
        }
        cells
    }

    fn face(&self, id: FaceId) -> Option<CellsOfFace> {
        let outline = self.outline(id);
        let camera = &self.shot.camera;
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        // A concave outline is only used for the extent that it spans.
        let polygon = clipped_to_box(&outline, camera, DVec2::ZERO, DVec2::new(width, height));
        let (low, high) = extent(&polygon, camera)?;
        let cell = |px: f64, limit: f64| (px.clamp(0.0, limit - 0.5) / f64::from(self.side_px)) as u32;
        let corner = [cell(low.x, width), cell(low.y, height)];
        let size = [cell(high.x, width) - corner[0] + 1, cell(high.y, height) - corner[1] + 1];
        let subject = self.subject(id, corner);
        let range = &self.sources.of_face[id.0 as usize];
        let all: Vec<u32> = range.clone().filter(|&s| self.may_serve(&subject, s)).collect();
        let mut lists = vec![Vec::new(); (size[0] * size[1]) as usize];
        let block =
            CellBlock { polygon: &polygon, servers: &all, cells: [0, 0, size[0], size[1]], steps: &BLOCKS };
        // A large face, such as the ground, has most of the cells, so that its blocks are examined beside each other.
        let of_blocks: Vec<Vec<FoundCell>> =
            block.parts().into_par_iter().map(|cells| self.cells_of(&subject, &block, cells)).collect();
        for FoundCell { x, y, list } in of_blocks.into_iter().flatten() {
            lists[(y * size[0] + x) as usize] = list;
        }
        let depths = polygon.iter().fold([f64::INFINITY, 0.0f64], |[a, b], p| [a.min(p.z), b.max(p.z)]);
        Some(CellsOfFace { face: id, corner, size, depths, lists })
    }

    /// Returns the outline of a face in the view's camera frame.
    fn outline(&self, id: FaceId) -> Vec<DVec3> {
        self.model.ring_points(id).map(|p| self.shot.pose.camera_from_world(p)).collect()
    }

    /// Returns what is common to the cells of a face, of which the first has this column and row.
    fn subject(&self, id: FaceId, corner: [u32; 2]) -> FaceData<'_> {
        let face = self.model.face(id);
        let object = self.model.object(face.object);
        FaceData {
            id,
            face,
            billboard: object.billboard,
            impostor: object.impostor.is_some(),
            back: face.plane.normal.dot(self.shot.viewpoint() - face.plane.point) < 0.0,
            height: self.heights.get(id.0 as usize).copied().unwrap_or(0.0),
            clearance: distance(&face.plane, self.shot.viewpoint()),
            corner,
        }
    }

    fn may_serve(&self, subject: &FaceData, server: u32) -> bool {
        let server = &self.sources.servers[server as usize];
        // The triangles of a face that is not planar may be seen from different sides.
        let side = server.back == subject.back || subject.billboard || !subject.face.planar;
        side && !self.shot.without.contains(&server.photo)
    }

    /// Returns the candidates of every single cell of a part of a block.
    fn cells_of(&self, subject: &FaceData, block: &CellBlock, cells: [u32; 4]) -> Vec<FoundCell> {
        let Some(patch) = self.patch(subject, self.clipped_to_cells(subject, block.polygon, cells)) else {
            return Vec::new();
        };
        let list = self.candidates(subject, &patch, block.servers);
        let Some((_, steps)) = block.steps.split_first() else {
            return vec![FoundCell { x: cells[0], y: cells[1], list }];
        };
        let servers: Vec<u32> = list.iter().map(|c| c.server).collect();
        let inner = CellBlock { polygon: &patch.polygon, servers: &servers, cells, steps };
        inner.parts().into_iter().flat_map(|cells| self.cells_of(subject, &inner, cells)).collect()
    }

    /// Clips a polygon to these cells.
    fn clipped_to_cells(
        &self,
        subject: &FaceData,
        polygon: &[DVec3],
        [x0, y0, x1, y1]: [u32; 4],
    ) -> Vec<DVec3> {
        let [column, row] = subject.corner;
        let px =
            |x: u32, y: u32| DVec2::new(f64::from(column + x), f64::from(row + y)) * f64::from(self.side_px);
        clipped_to_box(polygon, &self.shot.camera, px(x0, y0), px(x1, y1))
    }

    fn patch(&self, subject: &FaceData, polygon: Vec<DVec3>) -> Option<FacePatch> {
        if polygon.is_empty() {
            return None;
        }
        let (low, high) = polygon
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let middle = (low + high) / 2.0;
        let radius = polygon.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        // Relief moves a point along its ray, by height / cosine at most.
        let facing = (subject.clearance / (middle.length() + radius)).max(LEAST_FACING);
        let radius = radius + subject.height / facing;
        Some(FacePatch { middle_in_world: self.shot.pose.world_from_camera(middle), polygon, middle, radius })
    }

    /// Returns those of `servers` that may contribute in the patch, by rising lower bound of the penalty.
    fn candidates(&self, subject: &FaceData, patch: &FacePatch, servers: &[u32]) -> Vec<ServerCandidate> {
        let mut list = Vec::with_capacity(servers.len());
        let mut worst = Vec::with_capacity(servers.len());
        for &server in servers {
            if let Some((candidate, most)) = self.bounds(subject, patch, server) {
                list.push(candidate);
                worst.push(most);
            }
        }
        // The (k+1)-th smallest of the upper bounds; the threshold T is nowhere larger.
        let most = if self.shot.blend.mode == Mode::Best { 1 } else { self.shot.blend.photos.max(1) };
        if let Some(limit) = of_rank(&mut worst, most as usize) {
            list.retain(|c| c.least <= limit);
        }
        list.sort_by(|a, b| a.least.total_cmp(&b.least).then(a.server.cmp(&b.server)));
        list
    }

    /// Bounds one server in a patch: returns the candidate and the upper bound of its penalty; `None` where
    /// it textures no point of the patch.
    fn bounds(&self, subject: &FaceData, patch: &FacePatch, id: u32) -> Option<(ServerCandidate, f64)> {
        let server = &self.sources.servers[id as usize];
        let photo = self.sources.photo(server.photo);
        let blend = &self.shot.blend;
        let on_face = PhotoOnFace::new(self.model, subject.id, self.shot, photo, server);
        let (middle, radius, eye) = (patch.middle_in_world, patch.radius, self.shot.viewpoint());
        let angle = match subject.impostor {
            true => angles_apart(middle, radius, eye, on_face.seen_from(middle)),
            false => angles(middle, radius, eye, photo.pose.center_in_world()),
        };
        let density = self.octaves(subject, patch, &photo.camera, &on_face.pose);
        let footprint = self.footprint(patch, server, &photo.camera, &on_face.pose, density.start)?;
        let octaves = match blend.mode {
            Mode::Debevec => 0.0..0.0,
            Mode::Best | Mode::Lumigraph | Mode::Smooth => density.start.max(0.0)..density.end.max(0.0),
        };
        let other_side = subject.billboard && server.back != subject.back;
        let apart = match (other_side, subject.impostor) {
            (false, _) => 0.0,
            (true, true) => MIRRORED,
            (true, false) => OTHER_SIDE,
        };
        let sum = |angle: f64, octaves: f64, agreement: f64| {
            let contradicted = blend.transient_angle() * (1.0 - agreement) + LEAST_ANGLE;
            (angle + apart + blend.lambda * octaves) / agreement + contradicted
        };
        let trust = match blend.mode {
            Mode::Debevec if footprint.trust.start > 0.0 => 1.0..1.0,
            Mode::Debevec => 0.0..1.0,
            Mode::Best | Mode::Lumigraph | Mode::Smooth => footprint.trust,
        };
        let most = if footprint.whole {
            sum(angle.end, octaves.end, footprint.agreement) / trust.start
        } else {
            f64::INFINITY
        };
        let least = sum(angle.start, octaves.start, 1.0) / trust.end;
        // Anisotropic lookups use the shorter axis of the footprint, which is at most this much shorter than
        // the mean of both.
        let finer = if self.shot.quality.is_anisotropic() { MOST_TAPS.log2() / 2.0 } else { 0.0 };
        let finest = (-density.end - finer).max(0.0) as u32;
        let leaning = self.leaning.get(server.photo.index()).copied().unwrap_or(1.0);
        let (least, most) = (leaning * least, leaning * most);
        // A pinned photo comes before all others, and does not count among the k best.
        let (least, most) = if server.pinned { (0.0, f64::INFINITY) } else { (least, most) };
        Some((ServerCandidate { server: id, least, rect: footprint.rect, finest }, most))
    }

    /// Bounds the position of the patch in the photo; `None` outside of it. `octaves` is the lower bound of
    /// the octaves that it lacks.
    fn footprint(
        &self,
        patch: &FacePatch,
        server: &Server,
        camera: &Pinhole,
        pose: &Pose,
        octaves: f64,
    ) -> Option<PatchFootprint> {
        let middle = pose.camera_from_world(patch.middle_in_world);
        if middle.z + patch.radius <= 0.0 {
            return None;
        }
        let (low, high) = projected_ball(middle, patch.radius, camera);
        let rect = self.sources.layer_texture(server.layer_texture).rect;
        // The filter of a texel reaches half a texel further.
        let edge = DVec2::new(f64::from(rect.x), f64::from(rect.y)) - 1.0;
        let far_edge = DVec2::new(f64::from(rect.right()), f64::from(rect.bottom())) + 1.0;
        if high.cmplt(edge).any() || low.cmpgt(far_edge).any() {
            return None;
        }
        // The parts of a face with a ragged outline are hundreds of triangles, of which a cell shows few.
        if low.is_finite() && high.is_finite() && server.domain.is_apart(low, high) {
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
            // A filter of level l reaches 2^l texels, and the share of the next level twice as far.
            Quality::Preview if border.start > 0.0 => {
                let reach = 2.0 * (-octaves).max(0.0).ceil().exp2();
                self.confidence.least(server, low - reach, high + reach)
            }
            // Anisotropic footprints have no useful bound.
            _ => 0.0,
        };
        let agreement = match self.shot.blend.agreement && low.is_finite() && high.is_finite() {
            true => self.confidence.least_agreement(server, low, high),
            false => 1.0,
        };
        let whole = server.domain.is_whole() && middle.z > patch.radius;
        Some(PatchFootprint {
            trust: border.start * least..border.end,
            agreement,
            whole,
            rect: pixels.intersection(&rect),
        })
    }

    /// Bounds the octaves that the photo lacks; negative values are octaves to spare.
    fn octaves(&self, subject: &FaceData, patch: &FacePatch, camera: &Pinhole, pose: &Pose) -> Range<f64> {
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

/// The extent of a patch in a photo.
struct PatchFootprint {
    /// Bounds of border times confidence.
    trust: Range<f64>,
    /// A lower bound of the agreement.
    agreement: f64,
    /// True when the server textures the whole patch.
    whole: bool,
    /// The extent in photo pixels, within the layer texture.
    rect: PixelRect,
}

fn distance(plane: &Plane, point: DVec3) -> f64 {
    plane.normal.dot(point - plane.point).abs()
}

/// Returns the bounding box of a clipped polygon, in pixels; `None` where nothing is left.
fn extent(polygon: &[DVec3], camera: &Pinhole) -> Option<(DVec2, DVec2)> {
    let mut px = polygon.iter().filter_map(|p| camera.image_from_camera(*p)).filter(|p| p.is_finite());
    let first = px.next()?;
    Some(px.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
}

#[cfg(test)]
mod tests;
