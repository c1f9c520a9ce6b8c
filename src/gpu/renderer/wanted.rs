//! The texels that a view needs on the device: those of the surfaces that it shows, not of all that are in its frustum. In a street of
//! a town these are a hundredth.

use std::collections::BTreeMap;

use glam::DVec3;

use super::frame::StoredDepths;
use super::seen;
use super::{Prepared, Renderer, Shown};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceId;
use quadratura_base::task::Task;
use quadratura_projection::cells::{Cells, FaceCells};
use quadratura_projection::residency::TileRequest;
use quadratura_projection::{LayerTextureId, Sources, shown_face};
use quadratura_view::{Shot, TreeMethod};

/// Collects the texels that the cells may look up: one rectangle per layer texture and finest level. `is_shown` tells for each range
/// of [`Cells::ranges`] whether the view shows anything of it.
pub fn wants(cells: &Cells, is_shown: impl Fn(usize) -> bool, sources: &Sources) -> Vec<TileRequest> {
    let mut wanted: BTreeMap<(LayerTextureId, u32), PixelRect> = BTreeMap::new();
    let shown = cells.ranges.iter().enumerate().filter(|(i, _)| is_shown(*i)).map(|(_, range)| range);
    for candidate in shown.flat_map(|range| &cells.candidates[range.start as usize..range.end as usize]) {
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
    /// Returns the texels that a view needs. Where all layers of it are drawn, or all that its frustum may need is on the device, that is
    /// what it needs; otherwise its surfaces are drawn to find out which it shows.
    pub(super) fn wanted(
        &mut self,
        shot: &Shot,
        cells: &Cells,
        shown: Shown,
        task: &Task,
    ) -> Result<Vec<TileRequest>> {
        let of_frustum = self.without_skirts(shot, wants(cells, |_| true, &self.sources));
        if shown == Shown::All || self.store(shot).holds(&of_frustum) {
            return Ok(of_frustum);
        }
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
        let shown = shown_cells(cells, &drawn, shot.camera.width, nearest);
        Ok(self.without_skirts(shot, wants(cells, |i| shown[i], &self.sources)))
    }

    fn without_skirts(&self, shot: &Shot, mut wanted: Vec<TileRequest>) -> Vec<TileRequest> {
        if !self.skirts.are_in(shot) {
            wanted.retain(|want| !self.skirts.is_texture(want.layer_texture));
        }
        wanted
    }
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

/// Tells for each range of [`Cells::ranges`] whether a view of this `width` shows anything of it. `nearest` is the least depth of a
/// face that is blended over others, and `None` for opaque ones. Samples between the centres of pixels may show a face in the next
/// cell, so the neighbours of a face's cells count, too. Of the surroundings all cells do: outlines show them within faces.
fn shown_cells(
    cells: &Cells,
    drawn: &DrawnFaces,
    width: u32,
    nearest: impl Fn(FaceId) -> Option<f64>,
) -> Vec<bool> {
    let mut shown = vec![false; cells.ranges.len()];
    if let Some(around) = &cells.surroundings {
        shown[around.first as usize..].fill(true);
    }
    let mut last = (0, [0; 2]);
    for (row, y) in drawn.numbers.chunks_exact(width as usize).zip(0..) {
        for (&number, x) in row.iter().zip(0..) {
            let cell: [u32; 2] = [x / cells.side_px, y / cells.side_px];
            if std::mem::replace(&mut last, (number, cell)) == (number, cell) {
                continue;
            }
            let at = |face| cells.faces.binary_search_by_key(&face, |of| of.face).ok();
            if let Some(at) = shown_face(number).and_then(at) {
                let face = &cells.faces[at];
                cells_around(face, cell).for_each(|range| shown[range] = true);
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
                    cells_around(face, [x, y]).for_each(|range| shown[range] = true);
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
        let shown = shown_cells(&cells, &drawn, 10, |face| (face == FaceId(2)).then_some(4.0));
        let [first, third] = [[true, true, false, false], [false, false, true, true]];
        let expected = [first, [false; 4], third].concat();
        assert_eq!(shown, [&expected[..], &[true; 2]].concat());
        assert!(shown_cells(&cells, &drawn, 10, |_| Some(-1.0)).into_iter().all(|shown| shown));
    }
}
