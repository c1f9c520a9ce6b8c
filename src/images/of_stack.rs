//! The layered depth image of a stack: every element already lies in the photo's own camera, so that nothing is warped and
//! nothing resampled.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::cover::{Cover, FoundPixel, LeftoverPixels, OnRelief};
use super::covered_planes::CoveredPlanes;
use super::figures::named;
use super::options::StackLdiOptions;
use super::planes::SurfacePlanes;
use super::standing::Standing;
use super::texels::LayerTexels;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::{Model, Photo};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::paint::PaintBook;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_io::unmasked::read_unmasked;
use quadratura_ldi::finish::{SampleCounts, Unfinished};
use quadratura_ldi::layout::LONGEST_SIDE;
use quadratura_ldi::{Ldi, LdiKind};
use quadratura_projection::relief::Relief;
use quadratura_stacks::paint::PhotoPaint;
use quadratura_stacks::paint::parts::camera_of;
use quadratura_view::agreement::AgreementGrid;

/// What the layered depth image of a photo is made of.
pub struct StackSource<'a> {
    /// The store of the stacks.
    pub store: &'a StackStore,
    /// The photo.
    pub photo: &'a Photo,
    /// Its stack.
    pub stack: &'a Stack,
    /// Whether the stack was made of `model`.
    pub current: bool,
    /// The model in world coordinates.
    pub model: &'a Arc<Model>,
    /// The project's paint.
    pub book: &'a PaintBook,
    /// The relative tolerance within which surfaces are level.
    pub tolerance: f32,
    /// The relief; `None` where surfaces stay flat.
    pub relief: Option<Arc<Relief>>,
    /// How far the photo's surroundings are confirmed to be far away, of all of the photo; `None` where they are not shown.
    pub agreement: Option<AgreementGrid>,
    /// The photo's gain: see [`Ldi::gain`].
    pub gain: [f64; 3],
    /// See [`Ldi::inputs`].
    pub inputs: String,
}

/// Makes the layered depth image of a photo's stack.
///
/// # Errors
/// [`Error::Request`] for a photo that is too large, the errors of reading the stack's files and paint, or
/// [`Error::Cancelled`].
pub fn ldi_of_stack(source: &StackSource, options: &StackLdiOptions, task: &Task) -> Result<Ldi> {
    let StackSource { stack, photo, .. } = *source;
    let (camera, pose) = camera_of(&stack.photo, &stack.camera);
    if camera.width.max(camera.height) > LONGEST_SIDE {
        return Err(Error::Request(format!(
            "{} has {} x {} pixels; sides of a layered depth image have at most {LONGEST_SIDE}",
            photo.name, camera.width, camera.height
        )));
    }
    let cover = task.timed("read layers", || cover_of(source, options, task))?;
    let (mut rows, mut counts) = task.timed("cover", || rows(&cover, &camera, task))?;
    if let Some(agreement) = &source.agreement {
        let (width, photo) = (camera.width as usize, camera.rect());
        let standing = Standing { width, photo, agreement, filled: options.filled };
        counts.samples += task.timed("outlines", || standing.moved(&mut rows));
    }
    let named = task.timed("cover", || named(&cover.planes, rows));
    counts.unknown_surfaces = named.unknown;
    let unfinished = Unfinished {
        kind: LdiKind::Stack,
        inputs: source.inputs.clone(),
        camera,
        pose,
        photo_rect: Some(camera.rect()),
        gain: source.gain,
        surfaces: named.surfaces,
        sources: vec![photo.name.clone()],
        rows: named.rows,
        counts,
        options: options.described(LdiKind::Stack),
    };
    unfinished.finish(task)
}

/// Reads the layers of a stack and arranges its surfaces.
fn cover_of(source: &StackSource, options: &StackLdiOptions, task: &Task) -> Result<Cover> {
    let StackSource { store, photo, stack, model, .. } = *source;
    let folder = store.folder(&stack.photo.name);
    let paint = PhotoPaint::new(source.book, PaintStore::new(store.project()), stack);
    paint.damaged().iter().for_each(|problem| task.note(problem.clone()));
    let shown = |layer: &_| options.surroundings || !stack.is_of_surroundings(stack.layer(*layer));
    let layers: Vec<_> = stack.layer_indices().filter(shown).collect();
    let read = |layer: &_| {
        task.check_cancelled()?;
        LayerTexels::read(&folder, stack, &paint, *layer, options.filled)
    };
    let texels = layers.par_iter().map(read).collect::<Result<Vec<_>>>()?;
    let (camera, pose) = camera_of(&stack.photo, &stack.camera);
    let mut planes = SurfacePlanes::new(model, camera, pose, source.current);
    let surfaces: Vec<_> =
        layers.iter().map(|&layer| CoveredPlanes::of_layer(stack, layer, &mut planes)).collect();
    let leftovers = leftovers(photo, stack, options, &mut planes)?;
    let (model, planes) = planes.finish();
    let relief = source.relief.clone().map(|relief| OnRelief { camera, pose, model, relief });
    let layers = surfaces.into_iter().zip(texels).collect();
    Ok(Cover { layers, leftovers, planes, tolerance: source.tolerance, relief })
}

/// Reads the photo's pixels that show only faces in no image layer.
fn leftovers(
    photo: &Photo,
    stack: &Stack,
    options: &StackLdiOptions,
    planes: &mut SurfacePlanes,
) -> Result<LeftoverPixels> {
    let surfaces = CoveredPlanes::of_leftovers(stack, planes);
    let mut columns: Vec<Vec<Range<u32>>> = vec![Vec::new(); stack.photo.height as usize];
    for &[y, x0, x1] in &stack.leftovers {
        let columns = columns.get_mut(y as usize);
        columns.into_iter().for_each(|row| row.push(x0.min(stack.photo.width)..x1.min(stack.photo.width)));
    }
    let shows_surroundings = stack.surroundings_left_over && options.surroundings;
    let surroundings = shows_surroundings.then(|| planes.surroundings());
    let photo = match stack.leftovers.is_empty() {
        true => None,
        false => Some(read_unmasked(photo)?),
    };
    Ok(LeftoverPixels { surfaces, columns, photo, surroundings })
}

/// Walks over all rows.
fn rows(cover: &Cover, camera: &Pinhole, task: &Task) -> Result<(Vec<Vec<FoundPixel>>, SampleCounts)> {
    let row = |y: u32| task.check_cancelled().map(|()| cover.row(y));
    let rows: Vec<(Vec<FoundPixel>, SampleCounts)> =
        (0..camera.height).into_par_iter().map(row).collect::<Result<_>>()?;
    let mut counts = SampleCounts::default();
    rows.iter().for_each(|(_, of_row)| counts += *of_row);
    Ok((rows.into_iter().map(|(row, _)| row).collect(), counts))
}
