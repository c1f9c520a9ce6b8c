//! What became of a stroke: which pixels of the view under it are paint now, and why the others are not.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;
use serde::Serialize;

use super::dabs::Dabs;
use super::grid::ViewGrid;
use super::texels::BrushedLayer;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_projection::twin::{ProbedPoint, ReferenceRenderer};

/// The effect of the brush from which a pixel counts: the soft rim of a stroke is hardly visible.
const COUNTS_FROM: f64 = 0.5;

/// What became of the pixels of the view under a stroke, as numbers of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct StrokeCoverage {
    /// All with a surface, at half effect of the brush or more.
    pub pixels: u64,
    /// Those that lie in a painted texel.
    pub painted: u64,
    /// Those whose texel was not painted, because it is so large that the stroke misses its centre.
    pub coarse: u64,
    /// Those at surfaces that are within the frame of a photo, which shows another surface there, or their other side.
    pub hidden: u64,
    /// Those at surfaces that are outside all photos.
    pub outside: u64,
}

/// Counts what becomes of the pixels under a stroke that paints these texels.
pub fn coverage(
    dabs: &Dabs,
    grid: &ViewGrid,
    layers: &[BrushedLayer],
    renderer: &ReferenceRenderer,
) -> StrokeCoverage {
    let texels = |layer: &BrushedLayer| {
        let photo = layer.photo;
        layer.texels.iter().map(move |texel| (photo, texel.x, texel.y)).collect::<Vec<_>>()
    };
    let painted: HashSet<(PhotoId, i32, i32)> = layers.iter().flat_map(texels).collect();
    let sources = renderer.sources();
    let texel_at = |photo: PhotoId, point: DVec3| {
        let seen = sources.photo(photo);
        let px = seen.camera.image_from_camera(seen.pose.camera_from_world(point))?.floor().as_ivec2();
        seen.camera.rect().contains(px.x, px.y).then_some((photo, px.x, px.y))
    };
    let photos = PhotoId::all(sources.photos.len());
    let mut found = StrokeCoverage::default();
    for (point, texel) in grid.seen().filter(|(point, _)| counts(dabs, point)) {
        found.pixels += 1;
        let at = |texture| texel_at(sources.layer_texture(texture).photo, point.point);
        let count = match texel.texture.map(at) {
            Some(Some(texel)) if painted.contains(&texel) => &mut found.painted,
            Some(_) => &mut found.coarse,
            None if photos.clone().any(|photo| texel_at(photo, point.point).is_some()) => &mut found.hidden,
            None => &mut found.outside,
        };
        *count += 1;
    }
    found
}

/// Returns the names of the objects under a stroke, that of most pixels of the view first.
pub fn objects_under(dabs: &Dabs, grid: &ViewGrid, model: &Model) -> Vec<String> {
    let mut pixels: BTreeMap<&str, u64> = BTreeMap::new();
    for point in grid.surface().filter(|point| counts(dabs, point)) {
        *pixels.entry(&model.object(model.face(point.hit.face).object).name).or_default() += 1;
    }
    let mut names: Vec<(&str, u64)> = pixels.into_iter().collect();
    names.sort_by_key(|(name, count)| (std::cmp::Reverse(*count), *name));
    names.into_iter().map(|(name, _)| name.to_owned()).collect()
}

fn counts(dabs: &Dabs, point: &ProbedPoint) -> bool {
    dabs.effect(point.point) >= COUNTS_FROM
}
