//! The matte brush: strokes in a photo's own view that say where one sees through a see-through layer, where it is solid,
//! and where that is to be solved from the colours. What they write is paint on the layer, whose alpha is its matte, as
//! an image editor would leave it: nothing derived overwrites it.

mod effect;
mod refused;

use std::path::Path;

use glam::Vec3;

use self::effect::StrokeEffect;
use self::refused::nothing_under;
use super::strokes::own_surfaces;
use super::{Recorded, StrokeOptions, StrokeReport, StrokedPlace, sample};
use crate::import::session::{PaintSession, view_id};
use crate::import::share::by_surface;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::raster::over::straight;
use quadratura_base::raster::{Image, in_8_bits};
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_base::scene::{PhotoId, PhotoPixels, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::{ERASED, PaintColour, PaintPatch, PaintedView, brush_document};
use quadratura_document::stack::StackPhoto;
use quadratura_document::stroke::{BrushMode, Stroke};
use quadratura_document::{Project, Stack};
use quadratura_io::layer_reader::{read_layer, read_mask};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::read_project;
use quadratura_io::stack_store::StackStore;
use quadratura_io::unmasked::read_unmasked;
use quadratura_layered_files::{Depth, Raster};
use quadratura_layers::LayerIndex;
use quadratura_layers::matte::{FindOptions, closed_form, foreground};
use quadratura_projection::sources::LEAST_MATTE;
use quadratura_stacks::layer_pixels::layer_pixels;
use quadratura_stacks::paint::parts::camera_of;
use quadratura_stacks::paint::{PhotoPaint, parts_of_layer};

/// How far around a stroke mattes are taken as known when what is under it is solved.
const AROUND_PX: u32 = 24;

/// Applies a stroke of the matte brush. Its paint stays in its photo: other photos have mattes of their own.
///
/// # Errors
/// Returns [`Error::Request`] where the view is no photo's own, or no layer with a matte is under the brush; [`Error::Missing`]
/// without a stack; and the errors of reading and writing paint.
pub(super) fn apply_to_mattes(
    folder: &Path,
    project: &Project,
    site: &Site,
    stroke: &Stroke,
    options: StrokeOptions,
    task: &Task,
) -> Result<StrokeReport> {
    let photo = site.photo(photo_of(site, stroke)?);
    let store = StackStore::new(folder);
    let stack = store.current(&photo.name)?.ok_or_else(|| {
        Error::missing((format!("{} has no stack yet; ", photo.name), Remedy::Build, " builds it"))
    })?;
    let pixels = task.timed("read photo", || read_unmasked(photo))?;
    let session = PaintSession::begin(folder, read_project(folder)?.fill)?;
    let before = session.before().clone();
    let mut recorded = Recorded { session, report: StrokeReport::default() };
    let paint = PhotoPaint::new(&before, PaintStore::new(folder), &stack);
    let effect = StrokeEffect::new(stroke, PixelRect::of_size(stack.photo.width, stack.photo.height));
    let layers = under(stroke, &effect, &stack, &store.folder(&photo.name), &paint)?;
    if layers.is_empty() {
        return Err(nothing_under(stroke, &effect.pixels(), &stack, project, site));
    }
    let view = PaintedView { photo: stack.photo.clone(), camera: stack.camera.clone() };
    for layer in layers {
        task.check_cancelled()?;
        let painted = layer.painted(stroke, &effect, &pixels, task)?;
        recorded.report.coverage.pixels += painted.len() as u64;
        recorded.report.coverage.painted += painted.len() as u64;
        let place = StrokedPlace {
            document: brush_document(&view_id(&view)),
            view: view.clone(),
            layer: stack.layer(layer.index).id.clone(),
        };
        let parts = parts_of_layer(&stack, layer.index);
        let surfaces = own_surfaces(&recorded.session, &place.document, &place.layer)?;
        let shares = by_surface(&PaintPatch::of_pixels(&painted), &parts);
        let objects = &mut recorded.report.objects;
        for share in &shares {
            if !objects.contains(&share.object) {
                objects.push(share.object.clone());
            }
        }
        recorded.add(&place, surfaces, shares)?;
    }
    recorded.finish(stroke.brush.mode, StrokeOptions { only_here: true, ..options }, task)
}

/// Returns the photo whose own view a stroke is in.
fn photo_of(site: &Site, stroke: &Stroke) -> Result<PhotoId> {
    let view = &stroke.view;
    let size = StackPhoto { name: String::new(), width: view.width, height: view.height };
    let camera = camera_of(&size, &view.camera);
    let is_own = |id: &PhotoId| {
        let photo = site.photo(*id);
        (photo.camera, photo.pose) == camera
    };
    site.photo_ids().find(is_own).ok_or_else(|| {
        Error::Request(
            "the matte brush works in a photo's own view; `view` of the stroke has another size or camera than every photo of \
             the project"
                .into(),
        )
    })
}

/// An image layer with a matte, and its pixels under the brush.
struct MatteLayer {
    index: LayerIndex,
    rect: PixelRect,
    brushed: Spans,
    /// What the layer shows now.
    present: Raster,
    /// The part of the layer that was read, and whether the photo shows the layer there.
    shown: Image<bool>,
}

/// Returns the layers with mattes under a stroke: at each pixel the nearest one that covers it.
fn under(
    stroke: &Stroke,
    effect: &StrokeEffect,
    stack: &Stack,
    folder: &Path,
    paint: &PhotoPaint,
) -> Result<Vec<MatteLayer>> {
    let mut left = effect.pixels();
    let has_matte = |index: &LayerIndex| {
        let layer = stack.layer(*index);
        let is_meant = stroke.layer.as_ref().is_none_or(|id| *id == layer.id);
        is_meant && layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some())
    };
    let mut found = Vec::new();
    for index in stack.layer_indices().filter(has_matte) {
        let layer = stack.layer(index);
        let part = layer.needed_rect.intersection(&layer.rect);
        if part.intersection(&left.bounds()).is_empty() {
            continue;
        }
        let needed = Image::new(part, read_mask(&folder.join(&layer.needed_file), layer.rect, part)?);
        let brushed = Spans::of_pixels(part, |x, y| {
            left.holds(x, y) && needed.get(x, y).is_some_and(|needed| *needed != 0)
        });
        if brushed.is_empty() {
            continue;
        }
        left = left.minus(&brushed);
        let texels = read_layer(&folder.join(&layer.file), layer.rect, part)?;
        let shown = texels.as_chunks::<4>().0.iter().map(|texel| texel[3] != 0).collect();
        let present = layer_pixels(stack, folder, paint, index)?;
        found.push(MatteLayer { index, rect: layer.rect, brushed, present, shown: Image::new(part, shown) });
    }
    Ok(found)
}

impl MatteLayer {
    /// Returns the colours that a stroke gives the pixels under it.
    fn painted(
        &self,
        stroke: &Stroke,
        effect: &StrokeEffect,
        pixels: &PhotoPixels,
        task: &Task,
    ) -> Result<Vec<(i32, i32, PaintColour)>> {
        let mode = stroke.brush.mode;
        if mode == BrushMode::Solve {
            return self.solved(pixels, task);
        }
        let brushed = self.brushed.iter().flat_map(|(y, run)| run.clone().map(move |x| (x, y)));
        let painted = brushed.filter_map(|(x, y)| {
            let effect = effect.at(x, y) * stroke.brush.opacity as f32;
            let now = self.now(x, y);
            let colour = match mode {
                BrushMode::SeeThrough => thinned(now, effect, self.present.depth()),
                _ => thickened(now, self.solid(pixels, x, y)?, effect, self.present.depth()),
            };
            // Where the stroke is at its full effect, what is there already is kept, whatever is found later.
            (effect == 1.0 || colour != shown(now)).then_some((x, y, colour))
        });
        Ok(painted.collect())
    }

    fn is_shown(&self, x: i32, y: i32) -> bool {
        self.shown.get(x, y).is_some_and(|shown| *shown)
    }

    /// Returns what the layer shows now.
    fn now(&self, x: i32, y: i32) -> PaintColour {
        self.present.rgba16((x - self.rect.x) as u32, (y - self.rect.y) as u32)
    }

    /// Returns the opaque colour of a pixel: the photo's where it shows the surface, else the one that it has now, if any.
    fn solid(&self, pixels: &PhotoPixels, x: i32, y: i32) -> Option<PaintColour> {
        let [r, g, b, alpha] = match self.is_shown(x, y) {
            true => pixels.rgba16(x as u32, y as u32),
            false => self.now(x, y),
        };
        (alpha > 0).then_some([r, g, b, u16::MAX])
    }

    /// Solves the matte under the brush from the photo's colours, with all that is around it as known, and the surface's own
    /// colours from the matte. Pixels at which the photo does not show the surface stay as they are.
    fn solved(&self, pixels: &PhotoPixels, task: &Task) -> Result<Vec<(i32, i32, PaintColour)>> {
        let rect = self.brushed.bounds().grown(AROUND_PX).intersection(&pixels.rect());
        let colours = Image::from_fn(rect, |(x, y)| {
            let [r, g, b, _] = pixels.rgba16(x as u32, y as u32);
            Vec3::from_array([r, g, b].map(|value| linear_of_srgb(f64::from(value) / 65535.0) as f32))
        });
        let is_asked = |x: i32, y: i32| self.brushed.holds(x, y) && self.is_shown(x, y);
        let known = Image::from_fn(rect, |(x, y)| match (is_asked(x, y), self.is_shown(x, y)) {
            (true, _) => None,
            (false, true) => Some(f32::from(self.now(x, y)[3]) / 65535.0),
            // The photo shows something else here.
            (false, false) => Some(0.0),
        });
        let has = |side: fn(f32) -> bool| known.pixels().iter().flatten().any(|alpha| side(*alpha));
        if !(has(|alpha| alpha > 0.5) && has(|alpha| alpha <= 0.5)) {
            return Err(Error::Request(format!(
                "the matte under the brush cannot be solved: within {AROUND_PX} pixels around the stroke nothing is {}; mark \
                 some of it first",
                if has(|alpha| alpha > 0.5) { "see-through" } else { "solid" }
            )));
        }
        let options = FindOptions::default().closed_form;
        let alpha = task.timed("solve mattes", || closed_form(&colours, &known, None, &options, task))?;
        let own = foreground(&colours, &alpha).front;
        let depth = if pixels.bits() == 16 { Depth::Sixteen } else { Depth::Eight };
        let mut painted = Vec::new();
        for ((x, y), alpha) in alpha.iter().filter(|((x, y), _)| is_asked(*x, *y)) {
            let [r, g, b, _] = pixels.rgba16(x as u32, y as u32);
            let colour = match *alpha {
                alpha if alpha < LEAST_MATTE => ERASED,
                alpha if alpha > 1.0 - LEAST_MATTE => [r, g, b, u16::MAX],
                alpha => {
                    let light = own.get(x, y).copied().unwrap_or_default().to_array();
                    let encoded = |light: f32| srgb_from_linear(f64::from(light).clamp(0.0, 1.0));
                    let [r, g, b] = light.map(|light| sample(encoded(light), depth));
                    [r, g, b, sample(f64::from(alpha), depth)]
                }
            };
            painted.push((x, y, colour));
        }
        Ok(painted)
    }
}

/// Returns a pixel of a see-through layer that less is there of, by a share of 0 to 1.
fn thinned([r, g, b, alpha]: PaintColour, share: f32, depth: Depth) -> PaintColour {
    match f32::from(alpha) / 65535.0 * (1.0 - share) {
        left if left < LEAST_MATTE => ERASED,
        left => [r, g, b, sample(f64::from(left), depth)],
    }
}

/// Returns a pixel of a see-through layer that more is there of: its opaque colour, mixed with what it shows now.
fn thickened(now: PaintColour, [r, g, b, _]: PaintColour, share: f32, depth: Depth) -> PaintColour {
    let mut mixed = now;
    straight(&mut mixed, &[r, g, b, sample(f64::from(share), Depth::Sixteen)]);
    if depth == Depth::Eight {
        mixed = mixed.map(|sample| u16::from(in_8_bits(sample)) * 257);
    }
    match f32::from(mixed[3]) / 65535.0 {
        alpha if alpha < LEAST_MATTE => shown(now),
        alpha if alpha > 1.0 - LEAST_MATTE => [r, g, b, u16::MAX],
        _ => mixed,
    }
}

/// Returns the paint that leaves a pixel as it is.
fn shown(now: PaintColour) -> PaintColour {
    if now[3] == 0 { ERASED } else { now }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soft_rims_leave_mattes_between_and_none_within_a_thirty_second_of_their_ends() {
        let leaf = [40 * 257, 90 * 257, 20 * 257, u16::MAX];
        let alpha = |colour: PaintColour| f32::from(colour[3]) / 65535.0;
        for depth in [Depth::Eight, Depth::Sixteen] {
            let half = thinned(leaf, 0.5, depth);
            // Half of 8 bits is off by at most half a step of 255.
            assert!((alpha(half) - 0.5).abs() < 0.003 && half[..3] == leaf[..3], "{half:?}");
            assert_eq!((thinned(leaf, 0.98, depth), thinned(leaf, 0.0, depth)), (ERASED, leaf));
            let wall = [200 * 257, 190 * 257, 180 * 257, u16::MAX];
            assert_eq!(thickened([0; 4], wall, 0.02, depth), ERASED, "too little to be there");
            let rim = thickened([0; 4], wall, 0.25, depth);
            assert!((alpha(rim) - 0.25).abs() < 0.003 && rim[0].abs_diff(wall[0]) <= 257, "{rim:?}");
            let more = thickened(half, wall, 0.5, depth);
            assert!((alpha(more) - 0.75).abs() < 0.006 && more[0] > half[0] && more[0] < wall[0], "{more:?}");
            assert_eq!((thickened(half, wall, 0.98, depth), thickened(half, wall, 1.0, depth)), (wall, wall));
            assert_eq!(thickened(half, wall, 0.0, depth), half, "no effect");
        }
    }
}
