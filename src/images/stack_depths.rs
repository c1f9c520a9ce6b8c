//! The depth of the nearest surface at each pixel of a photo, by its stack.

use std::sync::Arc;

use super::covered_planes::CoveredPlanes;
use super::planes::SurfacePlanes;
use crate::paint::parts::camera_of;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Model;
use quadratura_document::Stack;

/// Returns the depths of the nearest surfaces of a stack along its camera's axis, in units of the world, by rows of the photo; infinite
/// where there is none. See-through surfaces count as the rectangle that they are cut from. `model` is that of the project.
pub fn nearest_depths(stack: &Stack, model: &Arc<Model>) -> Vec<f32> {
    let (camera, pose) = camera_of(&stack.photo, &stack.camera);
    let photo = camera.rect();
    // The planes are those of the outlines that the stack was made of, whatever became of the model.
    let mut planes = SurfacePlanes::new(model, camera, pose, false);
    let surfaces = stack.layer_indices().filter(|layer| !stack.is_of_surroundings(stack.layer(*layer)));
    let mut covered: Vec<CoveredPlanes> =
        surfaces.map(|layer| CoveredPlanes::of_layer(stack, layer, &mut planes)).collect();
    covered.push(CoveredPlanes::of_leftovers(stack, &mut planes));
    let (_, planes) = planes.finish();
    let mut inverse = vec![0.0f32; photo.area() as usize];
    for surface in covered.iter().flat_map(|of_layer| &of_layer.list) {
        let plane = &planes[surface.plane as usize];
        for (y, run) in surface.covered.iter() {
            for x in within(run.clone(), y, photo) {
                let nearest = &mut inverse[photo.offset(x, y)];
                *nearest = nearest.max(plane.at(x as u32, y as u32).unwrap_or(0.0));
            }
        }
    }
    inverse.into_iter().map(|inverse| 1.0 / inverse).collect()
}

/// Returns the part of a run of columns in row `y` that is in a rectangle.
fn within(run: std::ops::Range<i32>, y: i32, rect: PixelRect) -> std::ops::Range<i32> {
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
        let (project, opened) = tiny_stacks(folder.path()).unwrap();
        let stack = StackStore::new(&project).current("left.png").unwrap().unwrap();
        let depths = nearest_depths(&stack, &opened.site.model);
        assert_eq!(depths.len(), 64 * 48);
        // The box is around column 48 of row 24, and the wall is all of the photo.
        let [on_box, on_wall] = [(48, 24), (5, 5)].map(|(x, y)| depths[y * 64 + x]);
        assert!((on_box - 6.0).abs() < 1e-4 && (on_wall - 12.0).abs() < 1e-4, "{on_box} {on_wall}");
    }
}
