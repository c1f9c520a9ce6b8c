//! The depth of the nearest surface at each pixel of a photo, by its stack.

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::paint::parts::{camera_of, points};
use crate::paint::parts_of_layer;
use quadratura_base::geometry::PixelRect;
use quadratura_base::geometry::polygon::newell_normal;
use quadratura_document::Stack;

/// Returns the depths of the nearest surfaces of a stack along its camera's axis, in units of the world, by rows of the photo; infinite
/// where no image layer has one. See-through surfaces count as the rectangle that they are cut from.
pub fn nearest_depths(stack: &Stack) -> Vec<f32> {
    let (camera, pose) = camera_of(&stack.photo, &stack.camera);
    let photo = camera.rect();
    let mut depths = vec![f32::INFINITY; photo.area() as usize];
    for layer in stack.layer_indices() {
        let parts = parts_of_layer(stack, layer);
        // Surroundings have no face, and are infinitely far away.
        for part in parts.list.iter().filter(|part| part.face.is_some()) {
            let outline = if part.outline.is_empty() { part.own_outline() } else { part.outline };
            let in_camera: Vec<DVec3> =
                points(outline).into_iter().map(|point| pose.camera_from_world(point)).collect();
            let normal = newell_normal(&in_camera);
            let offset = normal.dot(in_camera.iter().sum::<DVec3>() / in_camera.len().max(1) as f64);
            for (y, run) in parts.covered(part).iter() {
                for x in within(run.clone(), y, photo) {
                    let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let depth = (offset / normal.dot(camera.ray_in_camera(centre))) as f32;
                    let nearest = &mut depths[photo.offset(x, y)];
                    if depth > 0.0 && depth < *nearest {
                        *nearest = depth;
                    }
                }
            }
        }
    }
    depths
}

/// Returns the part of a run of columns in row `y` that is in a rectangle.
fn within(run: Range<i32>, y: i32, rect: PixelRect) -> Range<i32> {
    if !(rect.y..rect.bottom()).contains(&y) {
        return 0..0;
    }
    run.start.max(rect.x)..run.end.min(rect.right())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tiny_site::tiny_stacks;
    use quadratura_io::stack_store::StackStore;

    #[test]
    fn a_box_is_before_its_wall() {
        let folder = tempfile::tempdir().unwrap();
        let (project, _) = tiny_stacks(folder.path()).unwrap();
        let stack = StackStore::new(&project).current("left.png").unwrap().unwrap();
        let depths = nearest_depths(&stack);
        assert_eq!(depths.len(), 64 * 48);
        // The box is around column 48 of row 24, and the wall is all of the photo.
        let [on_box, on_wall] = [(48, 24), (5, 5)].map(|(x, y)| depths[y * 64 + x]);
        assert!((on_box - 6.0).abs() < 1e-5 && (on_wall - 12.0).abs() < 1e-5, "{on_box} {on_wall}");
    }
}
