//! Ranking of hidden parts by how much a viewer would see of them, to fill or paint the most visible first.

use glam::DVec2;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::viewpoints::{RankedViewpoint, ViewpointIndex};
use crate::untextured::{FaceInStack, face_in_stack};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::{FaceId, Model, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_layers::LayerIndex;
use quadratura_projection::model_surface::ModelSurface;

/// An image layer with hidden texels that views would show.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenLayer {
    /// The index of the photo in the site.
    pub photo: PhotoId,
    /// The index of the layer in the stack.
    pub layer: LayerIndex,
    /// The number of covered texels that the photo does not show.
    pub hidden: u64,
    /// The number of hidden texels that are filled.
    pub filled: u64,
    /// The share of all views' pixels that show a point which the layer covers and its photo does not show: hidden
    /// area times visibility.
    pub seen: f64,
    /// The index of the view that shows most of it.
    pub view: ViewpointIndex,
}

/// The number of rays along the longer side of a view; shares are then accurate to about a third of a percent.
const RAYS_ACROSS: u32 = 48;
/// The relative distance by which a surface has to be nearer than a point to hide it; adjoining faces of coarse
/// models overlap by less.
const NEARER: f64 = 1e-3;

/// Returns the image layers of `stacks` (in the site's order) with hidden texels that are seen from `views`, sorted
/// by how much of them is seen, the most visible first; ties by photo and layer. Ray casts on the model determine
/// what a view shows, and which of that a photo does not show. The result does not depend on the number of threads.
///
/// # Errors
/// Returns [`quadratura_base::Error::Cancelled`] when the task was cancelled.
pub fn hidden_layers_by_visibility(
    site: &Site,
    stacks: &[Option<&Stack>],
    views: &[RankedViewpoint],
    task: &Task,
) -> Result<Vec<HiddenLayer>> {
    let surface = ModelSurface::from_model(&site.model);
    let layers_of: Vec<Option<LayersOfFaces>> =
        stacks.iter().map(|stack| stack.map(|stack| LayersOfFaces::new(stack, &site.model))).collect();
    let count = |(index, view): (usize, &RankedViewpoint)| {
        task.step("find occluded areas", index as u64, views.len() as u64)?;
        Ok(seen_from(view, &RayScene { site, surface: &surface, layers_of: &layers_of }))
    };
    let counted: Vec<ViewCount> = views.par_iter().enumerate().map(count).collect::<Result<_>>()?;
    let rays: u64 = counted.iter().map(|counted| counted.rays).sum();
    let mut seen: FxHashMap<(PhotoId, LayerIndex), HitCount> = FxHashMap::default();
    for (view, counted) in (0..).map(ViewpointIndex).zip(counted) {
        for (layer, count) in counted.hidden {
            seen.entry(layer).or_default().add(view, count);
        }
    }
    let layer = |((photo, layer), HitCount { count, view, .. }): ((PhotoId, LayerIndex), HitCount)| {
        let it = stacks[photo.index()]?.layer(layer);
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

/// A count of the rays of all views that hit hidden points of a layer.
#[derive(Default)]
struct HitCount {
    count: u64,
    /// The first of the views that see most of them.
    view: ViewpointIndex,
    /// The number of rays of that view.
    most: u64,
}

impl HitCount {
    fn add(&mut self, view: ViewpointIndex, count: u64) {
        self.count += count;
        if count > self.most {
            (self.view, self.most) = (view, count);
        }
    }
}

/// The rays of one view, counted by what they hit.
struct ViewCount {
    rays: u64,
    /// The number of rays that hit a point hidden in a layer, by photo and layer.
    hidden: FxHashMap<(PhotoId, LayerIndex), u64>,
}

/// The site and the stacks' layers, for ray casts.
struct RayScene<'a> {
    site: &'a Site,
    surface: &'a ModelSurface,
    layers_of: &'a [Option<LayersOfFaces<'a>>],
}

/// Casts a grid of rays from a view.
fn seen_from(view: &RankedViewpoint, scene: &RayScene<'_>) -> ViewCount {
    let Pinhole { width, height, .. } = view.camera;
    let step = f64::from(width.max(height)) / f64::from(RAYS_ACROSS);
    let along = |side: u32| ((f64::from(side) / step).round() as u32).max(1);
    let mut counted = ViewCount { rays: 0, hidden: FxHashMap::default() };
    let origin = view.pose.center_in_world();
    for y in 0..along(height) {
        for x in 0..along(width) {
            let px = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * step;
            let direction = view.pose.rotation.transpose() * view.camera.ray_in_camera(px);
            counted.rays += 1;
            if let Some(hit) = scene.surface.nearest(origin, direction) {
                let point = origin + direction * hit.t;
                let hidden = PhotoId::all(scene.layers_of.len())
                    .filter_map(|photo| scene.hides(photo, hit.face, point));
                hidden.for_each(|layer| *counted.hidden.entry(layer).or_default() += 1);
            }
        }
    }
    counted
}

impl RayScene<'_> {
    /// Returns the layer of a photo that covers a point of a face which the photo does not show; `None` where it
    /// shows the point, or does not contain the face.
    fn hides(&self, photo: PhotoId, face: FaceId, point: glam::DVec3) -> Option<(PhotoId, LayerIndex)> {
        let layers_of = self.layers_of[photo.index()].as_ref()?;
        let it = self.site.photo(photo);
        let px = it.camera.image_from_camera(it.pose.camera_from_world(point))?;
        let layer = layers_of.layer(face, px)?;
        let center = it.pose.center_in_world();
        let first = self.surface.nearest(center, point - center)?;
        (first.face != face && first.t < 1.0 - NEARER).then_some((photo, layer))
    }
}

/// The layers of a stack by the faces they contain.
struct LayersOfFaces<'a> {
    stack: &'a Stack,
    /// The indices of layers, by face.
    layers: Vec<Vec<LayerIndex>>,
}

impl<'a> LayersOfFaces<'a> {
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

    /// Returns the layer that contains a face at a pixel of the photo.
    fn layer(&self, face: FaceId, px: DVec2) -> Option<LayerIndex> {
        let at = px.floor().as_ivec2();
        let holds = |layer: &LayerIndex| self.stack.layer(*layer).needed_rect.contains(at.x, at.y);
        self.layers[face.0 as usize].iter().copied().find(holds)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::assemble::assemble;
    use crate::fill::viewpoints::views_of_photos;
    use quadratura_base::geometry::Pose;
    use quadratura_base::scene::Photo;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_layers::{LayerConstraints, Options, SoftwareRasteriser, sort_photo};

    /// Makes two quads, the nearer one in front of a part of the other, and a second photo from where that part is
    /// visible.
    fn site() -> (Site, Vec<Stack>) {
        let scene = closed_form::two_quads();
        let mut site = scene.site();
        // Four units to the left, past the left edge of the nearer quad.
        let aside = Pose { translation: scene.pose.translation + DVec3::X * 4.0, ..scene.pose };
        site.photos.push(Photo { name: "aside".into(), pose: aside, ..scene.photo() });
        let stack = |photo: &Photo| {
            let (options, task) = (Options::default(), Task::silent());
            let (rasteriser, constraints) = (SoftwareRasteriser, LayerConstraints::default());
            let sorted = sort_photo(
                &site.model,
                &photo.camera,
                &photo.pose,
                &rasteriser,
                &options,
                &constraints,
                &task,
            )
            .unwrap();
            assemble(&site.model, photo, &sorted, &options, &constraints, "")
        };
        let stacks = site.photos.iter().map(stack).collect();
        (site, stacks)
    }

    #[test]
    fn what_another_view_shows_and_the_photo_does_not_comes_first() {
        let (site, stacks) = site();
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Some).collect();
        let found =
            hidden_layers_by_visibility(&site, &stacks, &views_of_photos(&site), &Task::silent()).unwrap();
        let worst = &found[0];
        let layer = stacks[worst.photo.index()].unwrap().layer(worst.layer);
        assert!(layer.name.contains("far") && worst.seen > 0.0 && worst.hidden > 0, "{found:?}");
        assert!(found.windows(2).all(|pair| pair[0].seen >= pair[1].seen));
        assert_eq!(worst.view.0, 1 - worst.photo.index(), "what one photo hides the other one shows");
    }

    #[test]
    fn nobody_sees_what_is_hidden_from_where_the_photo_itself_was_taken() {
        let (site, stacks) = site();
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Some).collect();
        let own = &views_of_photos(&site)[..1];
        let found = hidden_layers_by_visibility(&site, &stacks, own, &Task::silent()).unwrap();
        assert!(found.iter().all(|layer| layer.photo != PhotoId(0)), "{found:?}");
        assert!(hidden_layers_by_visibility(&site, &[None, None], own, &Task::silent()).unwrap().is_empty());
    }
}
