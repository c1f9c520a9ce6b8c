//! The surfaces whose filling the pixels of a part of a photo may change.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec3;

use super::donor::{PARALLEL, SAME_DEPTH};
use super::painted::LEVELS;
use super::silhouettes::INSIDE_PX;
use super::surfaces::{FillSurfaceId, FillSurfaces};
use crate::projected_model::{Item, ProjectedModel};
use crate::software::owners;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Model;
use quadratura_base::scene::impostor::Facing;
use quadratura_projection::Projector;

/// The distance in pixels from a sample within which pixels may change it: two texels of the coarsest level of detail,
/// and the distance within which an edge forbids to sample a photo at all.
const REACH_PX: u32 = (2 << (LEVELS - 1)) + INSIDE_PX as u32;

/// Returns the surfaces that a photo may show near some rectangles (photo pixels), so that a sample of them may depend
/// on the pixels within. `tolerance` is that of occlusion.
pub fn surfaces_near(
    projector: &Projector,
    rects: &[PixelRect],
    model: &Arc<Model>,
    surfaces: &FillSurfaces,
    tolerance: f32,
) -> BTreeSet<FillSurfaceId> {
    let facing = Facing::of_pose(&projector.pose);
    let model = model.facing(&facing);
    let view = ProjectedModel::new(&model, &projector.camera, &projector.pose);
    let owners = owners(&view, tolerance);
    let frame = projector.camera.rect();
    let mut near = BTreeSet::new();
    for rect in rects.iter().map(|rect| rect.grown(REACH_PX).intersection(&frame)) {
        let shown: BTreeSet<u32> =
            rect.pixels().filter_map(|(x, y)| owners[frame.offset(x, y)].checked_sub(1)).collect();
        let surface = |item: &Item| surfaces.id(item.face, item.triangle);
        for owner in shown.iter().map(|owner| &view.items[*owner as usize]) {
            let normal = |item: &Item| match model.impostor(item.face) {
                Some(impostor) => impostor.plane(&facing).normal,
                None => surfaces.get(surfaces.id(item.face, item.triangle)).plane.normal,
            };
            let level = view.items.iter().filter(|item| may_be_level(owner, item, rect, &normal));
            near.extend(level.chain([owner]).map(surface));
        }
    }
    near
}

/// Returns true when two items may lie in the same plane, as far as one pixel can tell, somewhere in a rectangle.
fn may_be_level(a: &Item, b: &Item, rect: PixelRect, normal: &impl Fn(&Item) -> DVec3) -> bool {
    if normal(a).dot(normal(b)).abs() < PARALLEL {
        return false;
    }
    // Inverse depths are linear in x and y, so that their differences are extreme at corners. Twice the tolerance
    // covers rounding.
    let corners = [rect.x, rect.right() - 1].into_iter().flat_map(|x| [(x, rect.y), (x, rect.bottom() - 1)]);
    let difference = |share: f32| {
        corners.clone().map(move |(x, y)| {
            let [a, b] = [a, b].map(|item| item.inverse_depth.at(x as u32, y as u32));
            a - b * (1.0 + share)
        })
    };
    let farther = difference(2.0 * SAME_DEPTH).all(|difference| difference > 0.0);
    let nearer = difference(-2.0 * SAME_DEPTH).all(|difference| difference < 0.0);
    !farther && !nearer
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;

    #[test]
    fn only_surfaces_that_the_photo_shows_there_are_near() {
        let scene = closed_form::two_quads();
        let surfaces = FillSurfaces::from_model(&scene.model);
        let photo = scene.photo();
        let projector = Projector { name: photo.name, camera: photo.camera, pose: photo.pose };
        let near = |rect| surfaces_near(&projector, &[rect], &scene.model, &surfaces, 1e-4);
        let frame = projector.camera.rect();
        assert!(near(PixelRect { x: -900, y: -900, w: 5, h: 5 }).is_empty());
        let all = near(frame);
        assert_eq!(all.len(), surfaces.len(), "the photo shows both");
        let each: Vec<usize> =
            frame.pixels().step_by(97).map(|(x, y)| near(PixelRect { x, y, w: 1, h: 1 }).len()).collect();
        assert!(each.contains(&1) && each.contains(&2), "{each:?}");
    }
}
