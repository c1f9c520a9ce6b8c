//! What a box in the camera's frame can cover of a picture.

use glam::{Vec2, Vec3, Vec3Swizzles};

/// Returns the lowest and the highest position at which a view with these focal lengths and this centre can show the box between two
/// corners, all in pixels: x, y and depth of the corners are in the camera's frame. `None` where the box reaches to the viewer or behind,
/// and where the nearer depth is no number. The pass *hidden* computes the same.
pub fn extent([low, high]: [Vec3; 2], [focal, center]: [Vec2; 2]) -> Option<[Vec2; 2]> {
    let (nearest, farthest) = (low.z, high.z);
    (nearest > 0.0).then(|| {
        let lowest = (low.xy() / nearest).min(low.xy() / farthest);
        let highest = (high.xy() / nearest).max(high.xy() / farthest);
        [focal * lowest + center, focal * highest + center]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_beside_the_axis_is_widest_where_it_is_near_and_one_behind_the_viewer_has_no_extent() {
        let lens = [Vec2::new(100.0, 200.0), Vec2::new(50.0, 40.0)];
        // x from 1 to 2, y from -1 to 1, 2 to 4 away.
        let corners = |nearest: f32| [Vec3::new(1.0, -1.0, nearest), Vec3::new(2.0, 1.0, 4.0)];
        assert_eq!(extent(corners(2.0), lens), Some([Vec2::new(75.0, -60.0), Vec2::new(150.0, 140.0)]));
        for nearest in [0.0, -1.0, f32::NAN] {
            assert_eq!(extent(corners(nearest), lens), None);
        }
    }
}
