//! The colours that a brush paints, as the view shows them: one colour, or what the view shows beside the source.

use glam::DVec2;

use super::dabs::Dabs;
use super::grid::{ViewGrid, centre};
use super::texels::BrushedLayer;
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::raster::Image;
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_base::scene::FaceId;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_base::task::Task;
use quadratura_document::stroke::{BrushMode, Stroke};
use quadratura_layers::fill::push_pull::WeightedGrid;
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::twin::ReferenceRenderer;
use quadratura_view::Shot;

/// The largest factor by which the source is sampled more finely than the view's pixels, where texels are finer.
const FINEST: f64 = 8.0;

/// A view, and its exposure.
pub struct ViewLight<'a> {
    pub shot: &'a Shot,
    pub exposure: &'a ViewExposure,
}

/// Returns the colours for the texels of each layer, in linear light and in the view's exposure; `None` where the
/// source shows nothing.
///
/// # Errors
/// Returns the errors of reading layer textures.
pub fn colours(
    stroke: &Stroke,
    view: &ViewLight,
    dabs: &Dabs,
    grid: &ViewGrid,
    layers: &[BrushedLayer],
    renderer: &mut ReferenceRenderer,
    task: &Task,
) -> Result<Vec<Vec<Option<[f64; 3]>>>> {
    let (Some(source), true) = (stroke.source, stroke.brush.mode.has_source()) else {
        let colour = stroke.brush.colour.map(|sample| linear_of_srgb(f64::from(sample) / 255.0));
        return Ok(layers.iter().map(|layer| vec![Some(colour); layer.texels.len()]).collect());
    };
    let offset = DVec2::from(source) - DVec2::from(stroke.samples[0].at);
    let change = match stroke.brush.mode {
        BrushMode::Heal => Some(adaptation(view, dabs, grid, offset, renderer, task)?),
        _ => None,
    };
    let mut of_layers = Vec::with_capacity(layers.len());
    for layer in layers {
        let positions: Vec<DVec2> = layer.texels.iter().map(|texel| texel.in_view + offset).collect();
        let mut found = seen_at(view, &positions, layer.texels_per_px, renderer, task)?;
        if let Some(change) = change.as_ref().and_then(Option::as_ref) {
            for (colour, texel) in found.iter_mut().zip(&layer.texels) {
                *colour = colour.map(|colour| changed(colour, change, texel.in_view));
            }
        }
        of_layers.push(found);
    }
    Ok(of_layers)
}

/// Returns the linear colours that the view shows at positions, sampled as finely as the texels that they are for.
fn seen_at(
    view: &ViewLight,
    positions: &[DVec2],
    texels_per_px: f64,
    renderer: &mut ReferenceRenderer,
    task: &Task,
) -> Result<Vec<Option<[f64; 3]>>> {
    let finer = texels_per_px.clamp(1.0, FINEST);
    let camera = view.shot.camera;
    let scaled = |size: u32| (f64::from(size) * finer).ceil() as u32;
    let camera = Pinhole {
        width: scaled(camera.width),
        height: scaled(camera.height),
        fx: camera.fx * finer,
        fy: camera.fy * finer,
        cx: camera.cx * finer,
        cy: camera.cy * finer,
    };
    let (shot, picture) = (Shot { camera, ..view.shot.clone() }, camera.rect());
    let positions: Vec<DVec2> = positions.iter().map(|px| *px * finer).collect();
    let mut points = renderer.seen_points(&shot, &positions, task)?;
    for point in &mut points {
        *point = point.filter(|point| picture.contains(point.px.x.floor() as i32, point.px.y.floor() as i32));
    }
    let hit: Vec<_> = points.iter().flatten().copied().collect();
    let mut texels = renderer.probed_texels(&shot, &hit, view.exposure, task)?.into_iter();
    let colour =
        |point: &Option<_>| point.as_ref().and_then(|_| texels.next()?.shown).map(|shown| shown.colour);
    Ok(points.iter().map(colour).collect())
}

/// Computes the difference between the picture and the source at each pixel under the stroke, in sRGB: known along the
/// rim of the stroke, and interpolated within it by a membrane (Perez, Gangnet and Blake, *Poisson Image Editing*,
/// 2003: the source's gradients with the picture's colours along the rim). `None` where nothing is known along the rim.
///
/// # Errors
/// Returns the errors of reading layer textures.
fn adaptation(
    view: &ViewLight,
    dabs: &Dabs,
    grid: &ViewGrid,
    offset: DVec2,
    renderer: &mut ReferenceRenderer,
    task: &Task,
) -> Result<Option<Image<[f32; 3]>>> {
    let rect = grid.rect();
    let under = |x: i32, y: i32| grid.at(x, y).is_some_and(|(point, _)| dabs.effect(point.point) > 0.0);
    let inside = Image::from_fn(rect, |(x, y)| under(x, y));
    let faces: std::collections::BTreeSet<FaceId> =
        inside.held().filter_map(|(x, y)| Some(grid.at(x, y)?.0.hit.face)).collect();
    // Surfaces that the stroke does not touch say nothing about the colours around it.
    let is_rim = |(x, y): &(i32, i32)| {
        let beside = (-2..=2).any(|dy| (-2..=2).any(|dx| inside.holds(x + dx, y + dy)));
        beside
            && !inside.holds(*x, *y)
            && grid.at(*x, *y).is_some_and(|(point, _)| faces.contains(&point.hit.face))
    };
    let rim: Vec<(i32, i32)> = rect.pixels().filter(is_rim).collect();
    let places: Vec<DVec2> = rim.iter().map(|px| centre(*px)).collect();
    let sources: Vec<DVec2> = places.iter().map(|px| *px + offset).collect();
    let target = seen_at(view, &places, 1.0, renderer, task)?;
    let source = seen_at(view, &sources, 1.0, renderer, task)?;
    let mut known = WeightedGrid::new([rect.w as usize, rect.h as usize]);
    for ((px, target), source) in rim.iter().zip(target).zip(source) {
        let (Some(target), Some(source)) = (target, source) else { continue };
        let at = rect.offset(px.0, px.1);
        let encoded = |light: f64| srgb_from_linear(light.clamp(0.0, 1.0));
        known.values[at] = [0, 1, 2].map(|c| (encoded(target[c]) - encoded(source[c])) as f32);
        known.weights[at] = 1.0;
    }
    Ok(known.filled().map(|values| Image::new(rect, values)))
}

/// Adds the change at a position of the view to a linear colour.
fn changed(colour: [f64; 3], change: &Image<[f32; 3]>, px: DVec2) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut weights = 0.0;
    for (x, y, weight) in BilinearCorner::from_px(px).taps() {
        let Some(value) = change.get(x, y) else { continue };
        (0..3).for_each(|c| sum[c] += weight * f64::from(value[c]));
        weights += weight;
    }
    let change = |c: usize| if weights > 0.0 { sum[c] / weights } else { 0.0 };
    let encoded = |c: usize| srgb_from_linear(colour[c].clamp(0.0, 1.0)) + change(c);
    [0, 1, 2].map(|c| linear_of_srgb(encoded(c).clamp(0.0, 1.0)))
}
