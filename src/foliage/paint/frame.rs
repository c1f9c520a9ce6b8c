//! Where the images of slabs of a sub-object are in its frame.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::bounds::Bounds;
use crate::directions::Directions;
use crate::images::{ImageCopy, depth_from_stored};

/// The six directions from which a sub-object is seen, in the order of [`Directions::Axes`].
pub const DIRECTION_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// Where six square images of slabs are, each seen along an axis of the sub-object's frame: *rotated* coordinates of a direction are
/// x right, y down, z away from the viewer, about the origin of that frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlabFrame {
    /// The middle of the sub-object's ball and box, in its frame.
    pub middle: [f64; 3],
    /// Half of the sides of its box.
    pub half: [f64; 3],
    /// The radius of its ball.
    pub radius: f64,
    /// The side of a texel.
    pub delta: f64,
    /// Columns and rows of an image.
    pub side: u32,
    /// The number of slabs of a direction.
    pub slabs: u8,
}

impl SlabFrame {
    /// Returns where the images of a sub-object with these bounds are, which was cut into `slabs`.
    pub fn of(bounds: &Bounds, copy: &ImageCopy, slabs: u8) -> Self {
        Self {
            middle: bounds.ball.middle.to_array(),
            half: (0.5 * (bounds.space.high - bounds.space.low)).max(DVec3::ZERO).to_array(),
            radius: bounds.ball.radius,
            delta: copy.delta,
            side: copy.side,
            slabs,
        }
    }

    /// Returns the map from the sub-object's frame to rotated coordinates.
    pub fn rotation(direction: usize) -> DMat3 {
        Directions::Axes.view_from_object(direction)
    }

    /// Returns the middle in rotated coordinates.
    fn rotated_middle(&self, direction: usize) -> DVec3 {
        Self::rotation(direction) * DVec3::from_array(self.middle)
    }

    /// Returns half of the sub-object's extent along a direction.
    fn half_depth(&self, direction: usize) -> f64 {
        Self::rotation(direction).row(2).abs().dot(DVec3::from_array(self.half))
    }

    /// Returns the upper left corner of the image, in rotated coordinates.
    pub fn corner(&self, direction: usize) -> [f64; 2] {
        let (middle, half) = (self.rotated_middle(direction), 0.5 * f64::from(self.side) * self.delta);
        [middle.x - half, middle.y - half]
    }

    /// Returns the far end of a slab, in rotated coordinates.
    pub fn far(&self, direction: usize, slab: usize) -> f64 {
        let half = self.half_depth(direction);
        let share = (slab + 1) as f64 / f64::from(self.slabs.max(1));
        self.rotated_middle(direction).z + half * (2.0 * share - 1.0)
    }

    /// Returns the depth of a sample about the middle from how it is stored.
    pub fn depth(&self, stored: u16) -> f64 {
        let [factor, offset] = depth_from_stored(self.radius);
        factor * f64::from(stored) + offset
    }

    /// Returns the slab of a depth about the middle.
    pub fn slab(&self, direction: usize, depth: f64) -> usize {
        let (half, slabs) = (self.half_depth(direction), f64::from(self.slabs.max(1)));
        let slab = if half > 0.0 { 0.5 * slabs * (depth / half + 1.0) } else { 0.0 };
        (slab.max(0.0) as usize).min(usize::from(self.slabs.max(1)) - 1)
    }

    /// Returns a point of the sub-object's frame from its place in the image, in texels from the upper left corner, and its depth
    /// about the middle.
    pub fn point(&self, direction: usize, [x, y]: [f64; 2], depth: f64) -> DVec3 {
        let corner = self.corner(direction);
        let z = self.rotated_middle(direction).z + depth;
        let rotated = DVec3::new(corner[0] + x * self.delta, corner[1] + y * self.delta, z);
        Self::rotation(direction).transpose() * rotated
    }

    /// Returns true where the numbers are those of some images.
    pub fn is_sound(&self) -> bool {
        let numbers = self.middle.iter().chain(&self.half).chain([&self.radius, &self.delta]);
        numbers.into_iter().all(|number| number.is_finite())
            && self.delta > 0.0
            && self.radius > 0.0
            && (1..=16_384).contains(&self.side)
            && self.slabs > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: SlabFrame = SlabFrame {
        middle: [1.0, 2.0, 3.0],
        half: [2.0, 1.0, 3.0],
        radius: 4.0,
        delta: 0.5,
        side: 18,
        slabs: 6,
    };

    #[test]
    fn a_point_of_an_image_has_its_place_again_in_rotated_coordinates() {
        for direction in 0..6 {
            let (place, depth) = ([3.25, 7.5], 0.75);
            let rotated = SlabFrame::rotation(direction) * FRAME.point(direction, place, depth);
            let corner = FRAME.corner(direction);
            assert!(((rotated.x - corner[0]) / FRAME.delta - place[0]).abs() < 1e-12);
            assert!(((rotated.y - corner[1]) / FRAME.delta - place[1]).abs() < 1e-12);
        }
        let middle = FRAME.point(0, [9.0, 9.0], 0.0);
        assert!(middle.abs_diff_eq(DVec3::from_array(FRAME.middle), 1e-12));
    }

    #[test]
    fn the_names_of_directions_are_towards_the_viewer() {
        let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        for (direction, axis) in axes.into_iter().enumerate() {
            let towards = -SlabFrame::rotation(direction).row(2);
            assert!(towards.abs_diff_eq(axis, 1e-12), "{}", DIRECTION_NAMES[direction]);
        }
    }

    #[test]
    fn depths_are_in_the_slab_before_whose_far_end_they_are() {
        for direction in 0..6 {
            let middle = FRAME.rotated_middle(direction).z;
            for slab in 0..6 {
                let far = FRAME.far(direction, slab) - middle;
                assert_eq!(FRAME.slab(direction, far - 1e-6), slab);
                assert_eq!(FRAME.slab(direction, far + 1e-6), (slab + 1).min(5));
            }
        }
    }
}
