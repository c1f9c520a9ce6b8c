//! The texels that a view needs on the device: those of the surfaces that it shows, not of all that are in its frustum. In a street of
//! a town these are a hundredth.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::bounds::{LikelyBounds, StoredBounds};
use super::frame::StoredDepths;
use super::seen;
use super::{DrawnSurfaces, Prepared, Renderer};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_projection::cells::depths::ShownDepths;
use quadratura_projection::cells::{Cells, FaceCells, ServerCandidate, TexelBounds};
use quadratura_projection::residency::TileRequest;
use quadratura_projection::{LayerTextureId, Sources, shown_face};
use quadratura_view::{Shot, TreeMethod};

/// Collects the texels that candidates may look up: one rectangle per layer texture and finest level.
fn wants<'a>(
    candidates: impl IntoIterator<Item = &'a ServerCandidate>,
    sources: &Sources,
) -> Vec<TileRequest> {
    let mut wanted: BTreeMap<(LayerTextureId, u32), PixelRect> = BTreeMap::new();
    for candidate in candidates {
        let layer_texture = sources.servers[candidate.server as usize].layer_texture;
        let rect = wanted.entry((layer_texture, candidate.finest)).or_insert(candidate.rect);
        *rect = rect.union(&candidate.rect);
    }
    let want = |((layer_texture, finest), rect): ((LayerTextureId, u32), PixelRect)| {
        let corner = sources.layer_texture(layer_texture).rect;
        // The next level, which contributes to the lookup, has a filter twice as wide.
        let rect = PixelRect { x: rect.x - corner.x, y: rect.y - corner.y, ..rect };
        TileRequest { layer_texture, finest, rect: rect.grown(2 << finest) }
    };
    wanted.into_iter().map(want).collect()
}

impl Renderer {
    /// Loads the texels that a view needs, and returns its cells, and whether memory did not hold all of them. Where all layers of it are drawn, or all that its frustum may need is on
    /// the device, that is what it needs; otherwise its surfaces are drawn to find out which it shows, and at which depths.
    ///
    /// How far a photo is trusted is known when its layer was decoded; until then any photo may be needed, as all others might be
    /// untrusted there. So the photos that are needed if all are trusted are loaded first, and then those that may be needed still.
    pub(super) fn load_shown(
        &mut self,
        shot: &Shot,
        mut cells: Cells,
        leaning: &[f64],
        shown: DrawnSurfaces,
        task: &Task,
    ) -> Result<(Cells, bool)> {
        let of_frustum = self.without_skirts(shot, wants(&cells.candidates, &self.sources));
        if shown == DrawnSurfaces::All || self.store(shot).holds(&of_frustum) {
            let is_short = self.load(shot, &of_frustum, shown, task)?;
            return Ok((cells, is_short));
        }
        let depths = self.shown_depths(shot, &cells, task)?;
        let wanted = self.wanted(shot, &cells, &depths, leaning, &self.stored_bounds(shot));
        if self.store(shot).has_decoded(&wanted) {
            let is_short = self.load(shot, &wanted, shown, task)?;
            return Ok((cells, is_short));
        }
        let likely = self.wanted(shot, &cells, &depths, leaning, &LikelyBounds(self.stored_bounds(shot)));
        if self.load(shot, &likely, shown, task)? && shown == DrawnSurfaces::NearestIfTheyFit {
            return Ok((cells, true));
        }
        let known =
            task.timed("cells", || self.cells(shot, cells.side_px, leaning, &self.stored_bounds(shot)));
        cells = Cells { depths: cells.depths, ..known };
        let wanted = self.wanted(shot, &cells, &depths, leaning, &self.stored_bounds(shot));
        let is_short = self.load(shot, &wanted, shown, task)?;
        Ok((cells, is_short))
    }

    /// Loads these texels of a view; returns whether memory does not hold all of them.
    fn load(
        &mut self,
        shot: &Shot,
        wanted: &[TileRequest],
        shown: DrawnSurfaces,
        task: &Task,
    ) -> Result<bool> {
        let store = self.store_mut(shot);
        let loaded = task.timed("tiles", || match shown {
            DrawnSurfaces::NearestIfTheyFit => store.load_if_it_fits(wanted, task),
            DrawnSurfaces::Nearest | DrawnSurfaces::All => store.load(wanted, task),
        });
        Ok(loaded?.left_out > 0)
    }

    /// Returns for each range of [`Cells::ranges`] at which depths the view shows something of it.
    fn shown_depths(&mut self, shot: &Shot, cells: &Cells, task: &Task) -> Result<Vec<ShownDepths>> {
        // Trees hide surfaces only in part.
        let bare = Shot { trees: TreeMethod::None, ..seen::of_seen(shot) };
        let opaque = Prepared { opaque_alone: true, ..Prepared::default() };
        let drawn = self.drawn_faces(&bare, opaque, task, |target, gpu, depths| {
            Ok(DrawnFaces { numbers: target.faces(gpu)?, stored: target.depth_buffer(gpu)?, depths })
        })?;
        let blended = |face| self.skirts.holds(face) || self.surfaces.is_see_through(face);
        let nearest = |face| {
            let depth = |corner: DVec3| shot.depth_of(corner);
            blended(face).then(|| self.model.ring_points(face).map(depth).fold(f64::INFINITY, f64::min))
        };
        let depths = |face, run| depths_of_run(&self.model, shot, face, run, cells.depths[1]);
        Ok(shown_cells(cells, &drawn, shot.camera.width, nearest, depths))
    }

    /// Returns the texels that the cells may look up at these depths.
    fn wanted(
        &self,
        shot: &Shot,
        cells: &Cells,
        depths: &[ShownDepths],
        leaning: &[f64],
        bounds: &impl TexelBounds,
    ) -> Vec<TileRequest> {
        let finder = self.finder(shot, cells.side_px, leaning, bounds);
        let of_cell = |face: &FaceCells, cell: u32| {
            let at = [face.corner[0] + cell % face.size[0], face.corner[1] + cell / face.size[0]];
            finder.at_depths(cells, face, at, depths[(face.first + cell) as usize])
        };
        let of_face = |face: &FaceCells| -> Vec<ServerCandidate> {
            (0..face.size[0] * face.size[1]).flat_map(|cell| of_cell(face, cell)).collect()
        };
        let of_faces: Vec<Vec<ServerCandidate>> = cells.faces.par_iter().map(of_face).collect();
        let around = cells.surroundings.iter().flat_map(|around| &cells.ranges[around.first as usize..]);
        let around = around.flat_map(|range| &cells.candidates[range.start as usize..range.end as usize]);
        self.without_skirts(shot, wants(of_faces.iter().flatten().chain(around), &self.sources))
    }

    fn stored_bounds(&self, shot: &Shot) -> StoredBounds<'_> {
        StoredBounds { tiles: self.store(shot), agreement: &self.agreement.agreement }
    }

    fn without_skirts(&self, shot: &Shot, mut wanted: Vec<TileRequest>) -> Vec<TileRequest> {
        if !self.skirts.are_in(shot) {
            wanted.retain(|want| !self.skirts.is_texture(want.layer_texture));
        }
        wanted
    }
}

/// Pixels of a row that show one face: the row, and the first and the last column.
type PixelRun = (u32, [u32; 2]);

/// Returns the depths that a face may have at the pixels of a run and within a pixel of them. They follow from its plane; relief is up to
/// the cells.
fn depths_of_run(
    model: &Model,
    shot: &Shot,
    face: FaceId,
    (row, columns): PixelRun,
    farthest: f64,
) -> ShownDepths {
    let subject = model.face(face);
    let distance = subject.plane.signed_distance(shot.viewpoint());
    if shot.parallel.is_some() || !subject.planar || model.impostor(face).is_some() || distance == 0.0 {
        return ShownDepths::ALL;
    }
    let normal_in_camera = shot.pose.rotation * subject.plane.normal;
    // The inverse depth of a plane is an affine function of the pixel, so that its extremes are at the corners.
    let inverse =
        |x: f64, y: f64| -normal_in_camera.dot(shot.camera.ray_in_camera(DVec2::new(x, y))) / distance;
    let beside = |px: u32| [f64::from(px) - 0.5, f64::from(px) + 1.5];
    let (low, high) = (beside(columns[0])[0], beside(columns[1])[1]);
    let corners = beside(row).into_iter().flat_map(|y| [inverse(low, y), inverse(high, y)]);
    let range = corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], c| [a.min(c), b.max(c)]);
    ShownDepths::between_inverse(range, farthest)
}

/// The opaque faces of a view, pixel by pixel, row by row from the top.
struct DrawnFaces {
    /// 1 + the index of the face; 0 where there is none.
    numbers: Vec<u32>,
    /// The depth buffer.
    stored: Vec<f32>,
    /// How it stores depths.
    depths: StoredDepths,
}

/// Returns for each range of [`Cells::ranges`] at which depths a view of this `width` shows something of it. `nearest` is the least
/// depth of a face that is blended over others, and `None` for opaque ones; `depths` are those of a face at a run of pixels. Samples
/// between the centres of pixels may show a face in the next cell, so the neighbours of a face's cells count, too. Of the surroundings
/// all cells do: outlines show them within faces.
fn shown_cells(
    cells: &Cells,
    drawn: &DrawnFaces,
    width: u32,
    nearest: impl Fn(FaceId) -> Option<f64>,
    depths: impl Fn(FaceId, PixelRun) -> ShownDepths,
) -> Vec<ShownDepths> {
    let mut shown = vec![ShownDepths::default(); cells.ranges.len()];
    if let Some(around) = &cells.surroundings {
        shown[around.first as usize..].fill(ShownDepths::ALL);
    }
    for (row, y) in drawn.numbers.chunks_exact(width as usize).zip(0..) {
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            let (first, end) = (x, x + run.len() as u32);
            x = end;
            let at = |face| cells.faces.binary_search_by_key(&face, |of| of.face).ok();
            let Some(face) = shown_face(run[0]).and_then(at).map(|at| &cells.faces[at]) else { continue };
            for column in first / cells.side_px..end.div_ceil(cells.side_px) {
                let from = first.max(column * cells.side_px);
                let to = end.min((column + 1) * cells.side_px) - 1;
                let of_run = depths(face.face, (y, [from, to]));
                let cell = [column, y / cells.side_px];
                cells_around(face, cell).for_each(|range| shown[range].add(of_run));
            }
        }
    }
    let columns = width.div_ceil(cells.side_px);
    let farthest = least_of_cells(&drawn.stored, width, cells.side_px);
    for (face, depth) in cells.faces.iter().filter_map(|face| Some((face, nearest(face.face)?))) {
        // A face that reaches behind the viewpoint hides from nothing. A depth buffer is exact to about 1e-6.
        let stored = (1.000_01 * drawn.depths.stored(depth)) as f32;
        for y in face.corner[1]..face.corner[1] + face.size[1] {
            for x in face.corner[0]..face.corner[0] + face.size[0] {
                if farthest.get((y * columns + x) as usize).is_none_or(|least| stored >= *least) {
                    cells_around(face, [x, y]).for_each(|range| shown[range] = ShownDepths::ALL);
                }
            }
        }
    }
    shown
}

/// Returns the ranges of a face in a cell of the view and in its neighbours.
fn cells_around(face: &FaceCells, cell: [u32; 2]) -> impl Iterator<Item = usize> {
    let near = |axis: usize| {
        let from = face.corner[axis];
        let first = cell[axis].saturating_sub(1).max(from) - from;
        first..(cell[axis] + 2).min(from + face.size[axis]).saturating_sub(from)
    };
    let (columns, first, of_row) = (near(0), face.first, face.size[0]);
    near(1).flat_map(move |row| columns.clone().map(move |column| (first + row * of_row + column) as usize))
}

/// Returns the least value in each cell of a picture with `width` values a row.
fn least_of_cells(values: &[f32], width: u32, side_px: u32) -> Vec<f32> {
    let columns = width.div_ceil(side_px) as usize;
    let of_rows = |rows: &[f32]| {
        let mut least = vec![f32::INFINITY; columns];
        for row in rows.chunks_exact(width as usize) {
            for (value, cell) in row.chunks(side_px as usize).zip(&mut least) {
                *cell = value.iter().fold(*cell, |a, b| a.min(*b));
            }
        }
        least
    };
    values.chunks((width * side_px) as usize).flat_map(of_rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_projection::surroundings::{Reach, SurroundingsCells};

    #[test]
    fn a_face_is_shown_in_the_cells_with_its_pixels_and_beside_them_and_a_blended_one_where_nothing_is_in_front()
     {
        let of =
            |face: u32, first: u32| FaceCells { face: FaceId(face), corner: [1, 0], size: [4, 1], first };
        let cells = Cells {
            side_px: 2,
            faces: vec![of(0, 0), of(1, 4), of(2, 8)],
            ranges: vec![0..0; 14],
            surroundings: Some(SurroundingsCells { first: 12, columns: 1, reach: Reach(f64::INFINITY) }),
            ..Cells::default()
        };
        // Five cells in a row; the second shows the first face in one pixel. The third face is blended over others, at a depth of 4:
        // the first four cells are nearer, and the last one is farther.
        let mut drawn = DrawnFaces {
            numbers: vec![0; 20],
            stored: vec![1.0 / 3.0; 20],
            depths: StoredDepths::Perspective { near: 1.0 },
        };
        drawn.numbers[13] = 1;
        drawn.stored[9] = 1.0 / 5.0;
        let near = |_, (row, _): PixelRun| ShownDepths::between_inverse([0.3 + f64::from(row), 2.0], 4.0);
        let shown = shown_cells(&cells, &drawn, 10, |face| (face == FaceId(2)).then_some(4.0), near);
        let (all, none) = (ShownDepths::ALL, ShownDepths::default());
        let first = ShownDepths::between_inverse([1.3, 2.0], 4.0);
        let [first, third] = [[first, first, none, none], [none, none, all, all]];
        let expected = [first, [none; 4], third].concat();
        assert_eq!(shown, [&expected[..], &[all; 2]].concat());
        let blended = shown_cells(&cells, &drawn, 10, |_| Some(-1.0), near);
        assert!(blended.into_iter().all(|shown| shown == all));
    }
}
