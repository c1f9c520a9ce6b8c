//! Shadows of plants: how near to the sun the nearest surface is in each sub-pixel of a parallel view from the sun (Williams,
//! *Casting Curved Shadows on Curved Surfaces*, 1978).

use glam::{DAffine3, DVec3};

use super::bounds::Ball;
use super::depths::Square;
use super::plant::Plant;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The side of a view from the sun in pixels, of 4 x 4 sub-pixels each: of a tree of average size a pixel is a fifth of a
/// leaf, which so has a shadow of its own.
const SIDE_PX: u32 = 512;

/// What casts a shadow.
#[derive(Debug, Clone, Copy)]
pub struct Caster<'a> {
    /// The plant.
    pub plant: &'a Plant,
    /// The map from the plant's frame to that of the shadow.
    pub frame_from_plant: DAffine3,
}

/// The shadow that plants cast on what is in a ball, in one frame: that of a plant, or the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Shadow {
    square: Square,
    /// How near to the sun the nearest surface is, 16 sub-pixels a pixel, row by row; lower than everything where nothing is.
    nearest: Vec<[f32; 16]>,
}

impl Shadow {
    /// Draws what casts shadows on a ball from the direction to the sun, of length 1.
    ///
    /// # Errors
    /// Those of [`super::draw`].
    pub fn cast(casters: &[Caster<'_>], ball: &Ball, towards_sun: DVec3, task: &Task) -> Result<Self> {
        let square = Square::around(ball, towards_sun, SIDE_PX);
        let mut nearest = vec![[f32::NEG_INFINITY; 16]; (SIDE_PX * SIDE_PX) as usize];
        for Caster { plant, frame_from_plant } in casters {
            if plant.whole().counts.triangles == 0 {
                continue;
            }
            let depths = square.depths(plant, frame_from_plant, task)?;
            for (kept, found) in nearest.iter_mut().zip(&depths) {
                (0..16).for_each(|bit| kept[bit] = kept[bit].max(found.nearest[bit]));
            }
        }
        Ok(Self { square, nearest })
    }

    /// Returns the map from the shadow's frame to the sun's: x right, y down, z away from the sun.
    pub(super) fn sun_from_frame(&self) -> DAffine3 {
        self.square.view_from_frame
    }

    /// Returns the share of the sun's light, 0 to 1, that reaches a point in the sun's frame ([`Self::sun_from_frame`]) of a
    /// surface; `facing` is the cosine of the angle between its normal and the direction to the sun, of either side.
    ///
    /// A sub-pixel is in shadow where something is nearer to the sun than the point by more than a bias, which follows the
    /// slope of the surface, so that it casts no shadow on itself; the shares of pixels are interpolated.
    pub fn lit(&self, point_in_sun: DVec3, facing: f64) -> f32 {
        let (px, nearness) = self.square.projection().image_from_view(point_in_sun);
        let limit = (nearness + bias(facing) / self.square.scale) as f32;
        let at = px - 0.5;
        let first = at.floor();
        let share = (at - first).as_vec2();
        let (x, y) = (first.x as i64, first.y as i64);
        let above = self.open(x, y, limit) * (1.0 - share.x) + self.open(x + 1, y, limit) * share.x;
        let below = self.open(x, y + 1, limit) * (1.0 - share.x) + self.open(x + 1, y + 1, limit) * share.x;
        above * (1.0 - share.y) + below * share.y
    }

    /// Returns the share of a pixel's sub-pixels in which nothing is nearer than `limit`; beyond the view nothing is.
    fn open(&self, x: i64, y: i64, limit: f32) -> f32 {
        let side = i64::from(self.square.side);
        if !(0..side).contains(&x) || !(0..side).contains(&y) {
            return 1.0;
        }
        let nearest = &self.nearest[(y * side + x) as usize];
        nearest.iter().filter(|nearest| **nearest <= limit).count() as f32 / 16.0
    }
}

/// Returns by how much a surface must be nearer to the sun to cast a shadow, in pixels of the sun's view: over the interpolation,
/// which reaches one and a half pixels, the depth of a surface changes by its slope.
fn bias(facing: f64) -> f64 {
    const LARGEST: f64 = 6.0;
    let cosine = facing.abs().clamp(1e-6, 1.0);
    let slope = (1.0 - cosine * cosine).sqrt() / cosine;
    (0.5 + 1.5 * slope).min(LARGEST)
}
