//! How open a plant's crown is to its surroundings: at points of a grid, the share of directions in which nothing of the plant
//! is before them, and that share in each direction (Meyer, Neyret & Poulin 2001 keep *visibility cubes* likewise). Sky and ground
//! light a point as far as it is open to them, the sun as far as it is open in its direction.

use std::f64::consts::FRAC_PI_8;
use std::ops::{AddAssign, Mul};

use glam::{DAffine3, DVec2, DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::bounds::BoundingBox;
use super::depths::{Depths, Square};
use super::directions::{ANGLES, DIRECTIONS, Serving, serving, towards_viewer};
use super::plant::Plant;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The number of cells along the longest side of a plant's box: smaller than a twig's length, larger than a leaf.
const CELLS: u32 = 32;
/// The side of the views in pixels of 4 x 4 sub-pixels each: a cell is four of them wide.
const SIDE_PX: u32 = 128;

/// The openness of a plant, in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Openness {
    /// The corner of the grid with the smallest coordinates.
    low: DVec3,
    /// The side of a cell.
    cell: f64,
    /// The number of cells along x, y, z.
    size: [u32; 3],
    /// For each cell, x fastest, then y: the mean over all directions, and the vector by which it differs with the normal
    /// ([`Openness::at`]), x, y and z; 127 is 1, and 127 of a vector is 1/2.
    values: Vec<[i8; 4]>,
    /// For each cell: how open it is in each of the 22 directions ([`ANGLES`]); 255 is wholly.
    open: Vec<[u8; DIRECTIONS]>,
}

/// A view of the plant from a direction and its opposite.
struct OppositeViews {
    /// The indices of the direction and its opposite.
    indices: [usize; 2],
    /// Towards the first viewer, of length 1.
    direction: DVec3,
    /// The share of all directions that each of the two stands for.
    weight: f64,
    square: Square,
    depths: Vec<Depths>,
}

impl Openness {
    /// Finds how open a plant is from views from 22 directions (Max 1996), which are pairs of opposite ones.
    ///
    /// # Errors
    /// Those of [`super::draw`].
    pub fn bake(plant: &Plant, task: &Task) -> Result<Self> {
        let pairs = pairs().map(|(indices, weight)| {
            let direction = towards_viewer(indices[0]);
            let square = Square::around(&plant.whole().bounds.ball, direction, SIDE_PX);
            let depths = square.depths(plant, &DAffine3::IDENTITY, task)?;
            Ok(OppositeViews { indices, direction, weight, square, depths })
        });
        let pairs: Vec<OppositeViews> = pairs.collect::<Result<_>>()?;
        let (low, cell, size) = grid(&plant.whole().bounds.space);
        let [columns, rows, slices] = size;
        let places: Vec<[u32; 3]> = (0..slices)
            .flat_map(|z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])))
            .collect();
        let cells = places.par_iter().map(|place| in_cell(&pairs, low, cell, *place));
        let (values, open) = cells.unzip();
        Ok(Self { low, cell, size, values, open })
    }

    /// Makes what was found before of its parts; `None` where their numbers do not agree, and for cells without size.
    pub fn of(
        low: DVec3,
        cell: f64,
        size: [u32; 3],
        values: Vec<[i8; 4]>,
        open: Vec<[u8; DIRECTIONS]>,
    ) -> Option<Self> {
        let cells = size.iter().try_fold(1usize, |all, count| all.checked_mul(*count as usize))?;
        let is_sound = low.is_finite() && cell.is_finite() && cell > 0.0 && cells > 0;
        (is_sound && values.len() == cells && open.len() == cells).then_some(Self {
            low,
            cell,
            size,
            values,
            open,
        })
    }

    /// Returns the share, 0 to 1, of what comes from a direction, of any length but 0, that reaches a point.
    pub fn towards(&self, point: DVec3, direction: DVec3) -> f32 {
        self.towards_served(point, &serving(direction))
    }

    /// [`Self::towards`] a direction around which these directions are.
    pub fn towards_served(&self, point: DVec3, serving: &[Serving]) -> f32 {
        let of_cell = |cell: usize| -> f32 {
            let open = &self.open[cell];
            serving.iter().map(|of| of.weight as f32 * f32::from(open[of.direction]) / 255.0).sum()
        };
        self.between(point, of_cell).clamp(0.0, 1.0)
    }

    /// Returns the share, 0 to 1, of what sky and ground give that reaches a point of a surface with this normal of length 1:
    /// the directions to which it is open, weighed by the cosine of their angle to the normal. With V 1 in directions to which
    /// the point is open and 0 in others, it is the mean of V plus twice the mean of V d, d the direction, times the normal, up
    /// to terms of the second order.
    pub fn at(&self, point: DVec3, normal: DVec3) -> f32 {
        let of_cell = |cell: usize| Vec4::from_array(self.values[cell].map(|value| f32::from(value) / 127.0));
        let found = self.between(point, of_cell);
        let vector = Vec3::new(found.y, found.z, found.w);
        (found.x + 0.5 * vector.dot(normal.as_vec3())).clamp(0.0, 1.0)
    }

    /// Interpolates between the middles of cells; beyond the grid it goes on as at its border.
    fn between<T: Copy + Default + AddAssign + Mul<f32, Output = T>>(
        &self,
        point: DVec3,
        of_cell: impl Fn(usize) -> T,
    ) -> T {
        let at = ((point - self.low) / self.cell - 0.5).max(DVec3::ZERO);
        let size = self.size.map(|count| count as usize);
        let at = at.min(DVec3::from_array(self.size.map(|count| f64::from(count - 1))));
        let first = at.floor();
        let share = (at - first).as_vec3();
        let first = first.as_u64vec3();
        let low = [first.x as usize, first.y as usize, first.z as usize];
        let mut sum = T::default();
        for corner in 0..8 {
            let high = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [x, y, z] = [0, 1, 2].map(|axis| (low[axis] + high[axis]).min(size[axis] - 1));
            let weight = |axis: usize| if high[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            sum += of_cell((z * size[1] + y) * size[0] + x) * (weight(0) * weight(1) * weight(2));
        }
        sum
    }

    /// Returns the space of the grid.
    pub fn space(&self) -> BoundingBox {
        let size = self.cell * DVec3::from_array(self.size.map(f64::from));
        BoundingBox { low: self.low, high: self.low + size }
    }

    /// Returns the grid: its corner with the smallest coordinates, the side of a cell, and the number of cells along x, y, z.
    pub fn grid(&self) -> (DVec3, f64, [u32; 3]) {
        (self.low, self.cell, self.size)
    }

    /// Returns the values of the cells, x fastest, then y: the mean over all directions, where 127 is 1, and the vector that
    /// the normal multiplies ([`Self::at`]), where 127 is 1/2.
    pub fn values(&self) -> &[[i8; 4]] {
        &self.values
    }

    /// Returns how open the cells are in each of the 22 directions ([`ANGLES`]), 255 wholly, in the same order.
    pub fn open(&self) -> &[[u8; DIRECTIONS]] {
        &self.open
    }
}

/// Returns one of each pair of opposite directions, and the share of the sphere that each stands for: the poles' caps, and equal
/// parts of the belts in between.
fn pairs() -> impl Iterator<Item = ([usize; 2], f64)> {
    let (inner, outer) = (FRAC_PI_8.sin(), (3.0 * FRAC_PI_8).sin());
    ANGLES.into_iter().enumerate().filter_map(move |(direction, (latitude, longitude))| {
        let weight = match latitude {
            90 => 0.5 * (1.0 - outer),
            45 => 0.5 * (outer - inner) / 6.0,
            0 if longitude < 180 => inner / 8.0,
            _ => return None,
        };
        let away = -towards_viewer(direction);
        let opposite = (0..DIRECTIONS).find(|other| towards_viewer(*other).dot(away) > 0.999);
        Some(([direction, opposite.expect("directions are pairs")], weight))
    })
}

fn grid(space: &BoundingBox) -> (DVec3, f64, [u32; 3]) {
    let size = space.high - space.low;
    let cell = (size.max_element() / f64::from(CELLS)).max(f64::MIN_POSITIVE);
    let count = (size / cell).ceil().as_uvec3().clamp(glam::UVec3::ONE, glam::UVec3::splat(CELLS));
    // The grid is a little larger than the box, about its middle.
    let low = 0.5 * (space.low + space.high) - 0.5 * cell * count.as_dvec3();
    (low, cell, count.to_array())
}

/// Returns the value of a cell: the mean over points in it.
fn in_cell(pairs: &[OppositeViews], low: DVec3, cell: f64, place: [u32; 3]) -> ([i8; 4], [u8; DIRECTIONS]) {
    const POINTS: usize = 8;
    let (mut mean, mut vector, mut open) = (0.0, DVec3::ZERO, [0.0; DIRECTIONS]);
    for corner in 0..POINTS {
        let half = DVec3::new((corner & 1) as f64, (corner >> 1 & 1) as f64, (corner >> 2) as f64);
        let point = low + cell * (DVec3::from_array(place.map(f64::from)) + 0.25 + 0.5 * half);
        for pair in pairs {
            let [towards, away] = pair.open(point, 0.5 * cell);
            mean += pair.weight * (towards + away);
            vector += pair.weight * (towards - away) * pair.direction;
            let [first, second] = pair.indices;
            open[first] += towards;
            open[second] += away;
        }
    }
    let byte = |value: f64| (127.0 * value / POINTS as f64).round().clamp(-127.0, 127.0) as i8;
    let Vec3 { x, y, z } = (4.0 * vector).as_vec3();
    let open = open.map(|share| (255.0 * share / POINTS as f64).round() as u8);
    ([byte(mean), byte(x.into()), byte(y.into()), byte(z.into())], open)
}

impl OppositeViews {
    /// Returns the shares of the sub-pixels at a point in which nothing is before it by more than `bias`, towards the first
    /// viewer and towards the second.
    fn open(&self, point: DVec3, bias: f64) -> [f64; 2] {
        let at = self.square.view_from_frame.transform_point3(point);
        let (px, nearness) = self.square.projection().image_from_view(at);
        let side = f64::from(self.square.side);
        if px.cmplt(DVec2::ZERO).any() || px.cmpge(DVec2::splat(side)).any() {
            return [1.0; 2];
        }
        let found = &self.depths[px.y as usize * self.square.side as usize + px.x as usize];
        let (near, far) = ((nearness + bias) as f32, (nearness - bias) as f32);
        let share = |count: usize| count as f64 / 16.0;
        [
            share(found.nearest.iter().filter(|nearest| **nearest <= near).count()),
            share(found.farthest.iter().filter(|farthest| **farthest >= far).count()),
        ]
    }
}
