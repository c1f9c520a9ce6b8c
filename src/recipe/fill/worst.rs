//! Which hidden parts a viewer would see most: where filling or painting by hand is worth it first.

use glam::DVec2;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::super::untextured::{FaceInStack, face_in_stack};
use super::lookouts::View;
use crate::document::Stack;
use crate::error::Result;
use crate::geometry::Pinhole;
use crate::projection::surface::Surface;
use crate::scene::{FaceId, Model, Site};
use crate::task::Task;

/// An image layer with hidden texels that views would show.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenLayer {
    /// The photo's place in the site.
    pub photo: usize,
    /// The layer's place in the stack.
    pub layer: usize,
    /// Covered texels that the photo does not show.
    pub hidden: u64,
    /// Those of them that are filled.
    pub filled: u64,
    /// Which share of the views' pixels shows a place that the layer covers and its photo does not show: hidden area
    /// times visibility.
    pub seen: f64,
    /// The place of the view that shows most of it.
    pub view: usize,
}

/// Rays along the longer side of a view: shares are known to about a third of a percent then.
const RAYS_ACROSS: u32 = 48;
/// A surface this much nearer than a place, as a share of its distance, hides it: coarse models' faces that meet are
/// off by less.
const NEARER: f64 = 1e-3;

/// The image layers of `stacks` (in the site's order) with hidden texels that are seen from `views`, by how much of
/// them is seen: the worst first, ties by photo and layer. Rays onto the model say what a view shows, and which of
/// that a photo does not. The result does not depend on the number of threads.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn worst_first(
    site: &Site,
    stacks: &[Option<&Stack>],
    views: &[View],
    task: &Task,
) -> Result<Vec<HiddenLayer>> {
    let surface = Surface::of(&site.model);
    let homes: Vec<Option<Homes>> =
        stacks.iter().map(|stack| stack.map(|stack| Homes::new(stack, &site.model))).collect();
    let count = |(place, view): (usize, &View)| {
        task.step("look for hidden parts", place as u64, views.len() as u64)?;
        Ok(seen_from(view, &Scene { site, surface: &surface, homes: &homes }))
    };
    let counted: Vec<Counted> = views.par_iter().enumerate().map(count).collect::<Result<_>>()?;
    let rays: u64 = counted.iter().map(|counted| counted.rays).sum();
    let mut seen: FxHashMap<(usize, usize), Seen> = FxHashMap::default();
    for (view, counted) in counted.into_iter().enumerate() {
        for (layer, count) in counted.hidden {
            seen.entry(layer).or_default().add(view, count);
        }
    }
    let layer = |((photo, layer), Seen { count, view, .. }): ((usize, usize), Seen)| {
        let it = &stacks[photo]?.image_layers[layer];
        let hidden = it.texels_used - it.texels_visible;
        let filled = it.fill.as_ref().map_or(0, |fill| fill.texels_filled);
        let seen = count as f64 / rays.max(1) as f64;
        (hidden > 0).then_some(HiddenLayer { photo, layer, hidden, filled, seen, view })
    };
    let mut layers: Vec<HiddenLayer> = seen.into_iter().filter_map(layer).collect();
    layers
        .sort_by(|a, b| b.seen.total_cmp(&a.seen).then_with(|| (a.photo, a.layer).cmp(&(b.photo, b.layer))));
    Ok(layers)
}

/// How much of a layer's hidden places all views see.
#[derive(Default)]
struct Seen {
    count: u64,
    /// The first of the views that see most of them, and how much that is.
    view: usize,
    most: u64,
}

impl Seen {
    fn add(&mut self, view: usize, count: u64) {
        self.count += count;
        if count > self.most {
            (self.view, self.most) = (view, count);
        }
    }
}

/// What one view sees.
struct Counted {
    rays: u64,
    /// Rays that meet a place hidden in a layer, by photo and layer.
    hidden: FxHashMap<(usize, usize), u64>,
}

struct Scene<'a> {
    site: &'a Site,
    surface: &'a Surface,
    homes: &'a [Option<Homes<'a>>],
}

fn seen_from(view: &View, scene: &Scene<'_>) -> Counted {
    let Pinhole { width, height, .. } = view.camera;
    let step = f64::from(width.max(height)) / f64::from(RAYS_ACROSS);
    let along = |side: u32| ((f64::from(side) / step).round() as u32).max(1);
    let mut counted = Counted { rays: 0, hidden: FxHashMap::default() };
    let origin = view.pose.center_in_world();
    for y in 0..along(height) {
        for x in 0..along(width) {
            let px = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * step;
            let direction = view.pose.rotation.transpose() * view.camera.ray_in_camera(px);
            counted.rays += 1;
            if let Some(hit) = scene.surface.nearest(origin, direction) {
                let point = origin + direction * hit.t;
                let hidden = (0..scene.homes.len()).filter_map(|photo| scene.hides(photo, hit.face, point));
                hidden.for_each(|layer| *counted.hidden.entry(layer).or_default() += 1);
            }
        }
    }
    counted
}

impl Scene<'_> {
    /// The layer of a photo that covers a place of a face that the photo does not show; none where it shows it, or
    /// has nothing of it.
    fn hides(&self, photo: usize, face: FaceId, point: glam::DVec3) -> Option<(usize, usize)> {
        let homes = self.homes[photo].as_ref()?;
        let it = &self.site.photos[photo];
        let px = it.camera.image_from_camera(it.pose.camera_from_world(point))?;
        let layer = homes.layer(face, px)?;
        let center = it.pose.center_in_world();
        let first = self.surface.nearest(center, point - center)?;
        (first.face != face && first.t < 1.0 - NEARER).then_some((photo, layer))
    }
}

/// Which layers of a stack hold which faces.
struct Homes<'a> {
    stack: &'a Stack,
    /// By face.
    layers: Vec<Vec<usize>>,
}

impl<'a> Homes<'a> {
    fn new(stack: &'a Stack, model: &Model) -> Self {
        let layers = |face: FaceId| {
            let it = model.face(face);
            match face_in_stack(stack, &model.object(it.object).name, it.index) {
                FaceInStack::Textured { image_layers, .. } => image_layers,
                _ => Vec::new(),
            }
        };
        Self { stack, layers: model.face_ids().map(layers).collect() }
    }

    /// The layer that holds a face at a pixel of the photo.
    fn layer(&self, face: FaceId, px: DVec2) -> Option<usize> {
        let at = px.floor().as_ivec2();
        self.layers[face.0 as usize].iter().copied().find(|layer| {
            let rect = self.stack.image_layers[*layer].needed_rect;
            (rect.x..rect.right()).contains(&at.x) && (rect.y..rect.bottom()).contains(&at.y)
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Pose;
    use crate::layers::{Options, SoftwareRasteriser, Wishes, sort_photo};
    use crate::recipe::assemble::assemble;
    use crate::recipe::fill::lookouts::views_of_photos;
    use crate::scene::Photo;
    use crate::scene::synthetic::closed_form;

    /// Two quads, the nearer one in front of a part of the other, and a second photo from where that part is seen.
    fn site() -> (Site, Vec<Stack>) {
        let scene = closed_form::two_quads();
        let mut site = scene.site();
        // Four units to the left: past the left edge of the nearer one.
        let aside = Pose { translation: scene.pose.translation + DVec3::X * 4.0, ..scene.pose };
        site.photos.push(Photo { name: "aside".into(), pose: aside, ..scene.photo() });
        let stack = |photo: &Photo| {
            let (options, task) = (Options::default(), Task::silent());
            let (rasteriser, wishes) = (SoftwareRasteriser, Wishes::default());
            let sorted =
                sort_photo(&site.model, &photo.camera, &photo.pose, &rasteriser, &options, &wishes, &task)
                    .unwrap();
            assemble(&site.model, photo, &sorted, &options, &wishes, "")
        };
        let stacks = site.photos.iter().map(stack).collect();
        (site, stacks)
    }

    #[test]
    fn what_another_view_shows_and_the_photo_does_not_comes_first() {
        let (site, stacks) = site();
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Some).collect();
        let found = worst_first(&site, &stacks, &views_of_photos(&site), &Task::silent()).unwrap();
        let worst = &found[0];
        let layer = &stacks[worst.photo].unwrap().image_layers[worst.layer];
        assert!(layer.name.contains("far") && worst.seen > 0.0 && worst.hidden > 0, "{found:?}");
        assert!(found.windows(2).all(|pair| pair[0].seen >= pair[1].seen));
        assert_eq!(worst.view, 1 - worst.photo, "what one photo hides the other one shows");
    }

    #[test]
    fn nobody_sees_what_is_hidden_from_where_the_photo_itself_was_taken() {
        let (site, stacks) = site();
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Some).collect();
        let own = &views_of_photos(&site)[..1];
        let found = worst_first(&site, &stacks, own, &Task::silent()).unwrap();
        assert!(found.iter().all(|layer| layer.photo != 0), "{found:?}");
        assert!(worst_first(&site, &[None, None], own, &Task::silent()).unwrap().is_empty());
    }
}
