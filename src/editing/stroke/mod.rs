//! A stroke of the brush in a view of the model: its paint goes into the image layers of the photos with most weight
//! there, as a change of the paint book that is undone like an import (see `docs/method.md`).

mod colours;
pub mod coverage;
mod dabs;
mod grid;
mod matte;
mod strokes;
#[cfg(test)]
mod tests;
mod texels;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use self::colours::{ViewLight, colours};
use self::coverage::{StrokeCoverage, coverage, objects_under};
use self::dabs::Dabs;
use self::grid::ViewGrid;
use self::strokes::{Eraser, StrokedPlace, own_surfaces};
use self::texels::{BrushedLayer, TexelSearch};
use crate::import::elsewhere::PaintElsewhere;
use crate::import::session::{PaintMade, PaintSession, PaintedPlace, view_id};
use crate::import::settle::SurfacePaint;
use crate::import::share::by_surface;
use quadratura_base::error::{Error, Result};
use quadratura_base::raster::in_8_bits;
use quadratura_base::raster::over::straight;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::{PaintBook, PaintPatch, PaintedView, brush_document};
use quadratura_document::stack::StackPhoto;
use quadratura_document::stroke::{BrushMode, Stroke};
use quadratura_document::{Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::read_project;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Depth;
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::twin::{PhotoPosition, ProbedPoint, ProbedTexel, ReferenceRenderer};
use quadratura_stacks::layer_pixels::layer_pixels;
use quadratura_stacks::paint::parts::camera_of;
use quadratura_stacks::paint::{PhotoPaint, parts_of_layer};
use quadratura_view::Shot;
use quadratura_views::preview::{PreviewOptions, open_reference};
use quadratura_views::render::Appearance;

/// The stage that is reported.
pub const STAGE: &str = "stroke";

/// Options of [`apply`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StrokeOptions {
    /// Whether the stroke is only simulated and reported.
    pub dry_run: bool,
    /// Whether the paint stays in its photos: it is not projected to other ones.
    pub only_here: bool,
    /// As [`PreviewOptions::without_stack_notes`].
    pub without_stack_notes: bool,
}

/// The result of a stroke.
#[derive(Debug, Default)]
pub struct StrokeReport {
    /// The number of its import; `None` when it changed nothing.
    pub number: Option<u32>,
    /// The number of pixels whose paint changed.
    pub changed: u64,
    /// The image layers that were painted on.
    pub layers: Vec<StrokedLayer>,
    /// The number of pixels of the view under the stroke with a surface that no photo covers.
    pub uncovered: u64,
    /// What became of the pixels of the view under the stroke; nothing for one that erases.
    pub coverage: StrokeCoverage,
    /// The objects under the stroke, that of most pixels of the view first.
    pub objects: Vec<String>,
    /// The number of texels that were not painted, because the view shows nothing at the source.
    pub without_source: u64,
    /// The paint of other photos that differs at the same places, which these photos keep.
    pub elsewhere: Vec<PaintElsewhere>,
    /// Whether its paint is only seen in the photos that it was painted on.
    pub only_here: bool,
    /// The project's paint as it is now.
    pub book: Arc<PaintBook>,
}

/// An image layer that a stroke painted on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct StrokedLayer {
    /// The photo's name.
    pub photo: String,
    /// The layer's token.
    pub layer: String,
    /// The number of pixels whose paint changed.
    pub changed: u64,
}

/// Applies a stroke to the project in `folder`, as one import that can be undone. It covers texels of surfaces that the
/// view shows; each belongs to the photo with the largest weight there. The caller holds the project's lock, unless it
/// is a dry run.
///
/// # Errors
/// Returns [`Error::Request`] for a stroke that cannot be applied or does not touch the model, and when no photo has a
/// stack; [`Error::Input`] and [`Error::Io`] for files of stacks and paint; [`Error::Cancelled`]. The project's paint
/// is then unchanged.
pub fn apply(
    folder: &Path,
    project: &Project,
    site: &Site,
    stroke: &Stroke,
    look: &Appearance,
    options: StrokeOptions,
    task: &Task,
) -> Result<StrokeReport> {
    if let Some((place, found)) = stroke.problem() {
        return Err(Error::Request(format!("the stroke cannot be applied: {place}: {found}")));
    }
    if stroke.brush.mode.is_of_matte() {
        return matte::apply_to_mattes(folder, project, site, stroke, options, task);
    }
    let preview = PreviewOptions {
        relief: !look.flat,
        without_stack_notes: options.without_stack_notes,
        ..PreviewOptions::default()
    };
    let mut renderer = open_reference(folder, project, site, &preview, task)?;
    let shot = shot_of(stroke, look);
    let dabs = Dabs::along(stroke, &shot, &mut renderer, task)?
        .ok_or_else(|| Error::Request("the stroke does not touch the model".into()))?;
    let grid = ViewGrid::new(&shot, &dabs, &mut renderer, task)?;
    let recorded = Recorded {
        session: PaintSession::begin(folder, read_project(folder)?.fill)?,
        report: StrokeReport::default(),
    };
    let mut brushing = Brushing { site, stroke, shot, dabs, grid, renderer, recorded };
    match stroke.brush.mode {
        BrushMode::Erase => brushing.erase(false)?,
        _ => brushing.paint(task)?,
    }
    brushing.recorded.report.objects =
        objects_under(&brushing.dabs, &brushing.grid, brushing.renderer.model());
    brushing.recorded.finish(stroke.brush.mode, options, task)
}

/// Returns the view of a stroke.
fn shot_of(stroke: &Stroke, look: &Appearance) -> Shot {
    let view = &stroke.view;
    let photo = StackPhoto { name: String::new(), width: view.width, height: view.height };
    let (camera, pose) = camera_of(&photo, &view.camera);
    look.shot(camera, pose)
}

/// A stroke in progress.
struct Brushing<'a> {
    site: &'a Site,
    stroke: &'a Stroke,
    shot: Shot,
    dabs: Dabs,
    grid: ViewGrid,
    renderer: ReferenceRenderer,
    recorded: Recorded<'a>,
}

/// The paint of a stroke in progress, and its report.
struct Recorded<'a> {
    session: PaintSession<'a>,
    report: StrokeReport,
}

impl Brushing<'_> {
    /// Paints texels with the brush's colours.
    fn paint(&mut self, task: &Task) -> Result<()> {
        let Self { shot, dabs, grid, renderer, .. } = self;
        let exposure = renderer.view_exposure(shot);
        let view = ViewLight { shot, exposure: &exposure };
        let reached = |point: &ProbedPoint| dabs.reaches(point.point);
        task.timed("weigh photos", || grid.look(shot, &exposure, renderer, reached, task))?;
        let is_bare = |(point, texel): &(&ProbedPoint, &ProbedTexel)| {
            texel.texture.is_none() && dabs.effect(point.point) > 0.0
        };
        self.recorded.report.uncovered = grid.seen().filter(is_bare).count() as u64;
        let stacks = stacks(self.recorded.session.project(), self.site, grid, renderer)?;
        let layers = TexelSearch { renderer, shot, dabs, grid, stacks: &stacks }.layers();
        self.recorded.report.coverage = coverage(dabs, grid, &layers, renderer);
        let colours =
            task.timed("find colours", || colours(self.stroke, &view, dabs, grid, &layers, renderer, task))?;
        let before = self.recorded.session.before().clone();
        for (layer, colours) in layers.iter().zip(colours) {
            task.check_cancelled()?;
            let stack = &stacks[&layer.photo];
            let patch = self.patch(&exposure, stack, layer, &colours, &before)?;
            self.add(stack, layer, &patch)?;
        }
        // Where texels had to be left out, the paint below them in other photos is still needed.
        if self.recorded.report.without_source == 0 { self.erase(true) } else { Ok(()) }
    }

    /// Returns the new colours of a layer's texels, mixed with what the layer shows now.
    fn patch(
        &mut self,
        exposure: &ViewExposure,
        stack: &Stack,
        layer: &BrushedLayer,
        colours: &[Option<[f64; 3]>],
        before: &PaintBook,
    ) -> Result<PaintPatch> {
        let project = self.recorded.session.project();
        let paint = PhotoPaint::new(before, PaintStore::new(project), stack);
        let folder = StackStore::new(project).folder(&stack.photo.name);
        let (present, rect) =
            (layer_pixels(stack, &folder, &paint, layer.layer)?, stack.layer(layer.layer).rect);
        let mut painted = Vec::with_capacity(layer.texels.len());
        for (texel, colour) in layer.texels.iter().zip(colours) {
            let Some(colour) = colour else {
                self.recorded.report.without_source += 1;
                continue;
            };
            let px = grid::centre((texel.x, texel.y));
            let position = PhotoPosition { photo: layer.photo, face: texel.face, px };
            let light = self.renderer.colour_in_photo(&self.shot, exposure, position, *colour, texel.in_view);
            let [r, g, b] =
                light.map(|light| sample(srgb_from_linear(light.clamp(0.0, 1.0)), present.depth()));
            let share = sample(texel.effect * self.stroke.brush.opacity, Depth::Sixteen);
            let below = present.rgba16((texel.x - rect.x) as u32, (texel.y - rect.y) as u32);
            let mut mixed = below;
            straight(&mut mixed, &[r, g, b, share]);
            if present.depth() == Depth::Eight {
                mixed = mixed.map(|sample| u16::from(in_8_bits(sample)) * 257);
            }
            if mixed != below && mixed[3] > 0 {
                painted.push((texel.x, texel.y, mixed));
            }
        }
        Ok(PaintPatch::of_pixels(&painted))
    }

    /// Adds paint on a layer to the paint of earlier strokes there.
    fn add(&mut self, stack: &Stack, layer: &BrushedLayer, patch: &PaintPatch) -> Result<()> {
        let view = PaintedView { photo: stack.photo.clone(), camera: stack.camera.clone() };
        let place = StrokedPlace {
            document: brush_document(&view_id(&view)),
            view,
            layer: stack.layer(layer.layer).id.clone(),
        };
        let parts = parts_of_layer(stack, layer.layer);
        let surfaces = own_surfaces(&self.recorded.session, &place.document, &place.layer)?;
        self.recorded.add(&place, surfaces, by_surface(patch, &parts))
    }

    /// Removes paint of earlier strokes; with `only_others` that of photos other than the one painted on. These photos
    /// would keep their own paint, so that the new stroke would not be on top seen from their side.
    fn erase(&mut self, only_others: bool) -> Result<()> {
        let eraser = Eraser {
            site: self.site,
            renderer: &self.renderer,
            shot: &self.shot,
            dabs: &self.dabs,
            grid: &self.grid,
            only_others,
        };
        for (place, surfaces) in eraser.left(&self.recorded.session)? {
            self.recorded.settle(&place, surfaces)?;
        }
        Ok(())
    }
}

impl Recorded<'_> {
    /// Adds paint to that of earlier strokes on the same layer.
    fn add(
        &mut self,
        place: &StrokedPlace,
        mut surfaces: Vec<SurfacePaint>,
        added: Vec<SurfacePaint>,
    ) -> Result<()> {
        let face = |paint: &SurfacePaint| (paint.object.clone(), paint.face, paint.triangle, paint.beyond);
        for paint in added {
            match surfaces.iter_mut().find(|surface| face(surface) == face(&paint)) {
                Some(surface) => surface.patch = surface.patch.under(&paint.patch),
                None => surfaces.push(paint),
            }
        }
        self.settle(place, surfaces)
    }

    /// Takes all strokes on a layer into the paint book.
    fn settle(&mut self, place: &StrokedPlace, surfaces: Vec<SurfacePaint>) -> Result<()> {
        let StrokedPlace { view, layer, document } = place;
        let known: BTreeSet<String> = self.session.book().files().into_iter().map(str::to_owned).collect();
        let settled =
            self.session.settle(&PaintedPlace { view, layer, document, known: &known }, surfaces)?;
        self.session.note_view(view);
        if settled.changed > 0 {
            let photo = view.photo.name.clone();
            self.report.layers.push(StrokedLayer { photo, layer: layer.clone(), changed: settled.changed });
        }
        Ok(())
    }

    /// Writes the stroke, unless it is a dry run or changes nothing.
    fn finish(self, mode: BrushMode, options: StrokeOptions, task: &Task) -> Result<StrokeReport> {
        let Self { session, mut report } = self;
        report.only_here = options.only_here;
        report.changed = report.layers.iter().map(|layer| layer.changed).sum();
        if report.changed > 0 {
            report.number = Some(session.number());
            report.elsewhere = session.elsewhere(options.only_here)?;
        }
        if report.number.is_none() || options.dry_run {
            report.book = Arc::new(session.before().clone());
            return Ok(report);
        }
        let made = PaintMade {
            photos: report.layers.iter().map(|layer| layer.photo.clone()).collect(),
            pixels: report.changed,
            brush: Some(mode),
            ..PaintMade::default()
        };
        // A stroke that was undone meanwhile is not written.
        task.check_cancelled()?;
        let committed = task.timed("write paint", || session.commit(made, options.only_here))?;
        report.book = Arc::new(committed.book);
        Ok(report)
    }
}

/// Returns the stacks of the photos whose layer textures the view shows under the stroke.
fn stacks(
    folder: &Path,
    site: &Site,
    grid: &ViewGrid,
    renderer: &ReferenceRenderer,
) -> Result<BTreeMap<PhotoId, Stack>> {
    let sources = renderer.sources();
    let textures = grid.seen().filter_map(|(_, texel)| texel.texture);
    let photos: BTreeSet<PhotoId> = textures.map(|texture| sources.layer_texture(texture).photo).collect();
    let store = StackStore::new(folder);
    let mut stacks = BTreeMap::new();
    for photo in photos {
        if let Some(stack) = store.current(&site.photo(photo).name)? {
            stacks.insert(photo, stack);
        }
    }
    Ok(stacks)
}

/// Returns a share of 0 to 1 as a sample in 16 bits; with 8 bits it is one of their 256 values.
fn sample(share: f64, depth: Depth) -> u16 {
    match depth {
        Depth::Eight => (share * 255.0).round() as u16 * 257,
        Depth::Sixteen => (share * 65535.0).round() as u16,
    }
}
