//! What the builder does: it makes the layered depth images of photos, and keeps those that were used last.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::billboards::without_billboards;
use super::builder::Workbench;
use super::request::{BuiltImage, ImageRequest, LiveInputs, RequestStage};
use crate::kept::Kept;
use crate::{LdiSite, PhotosOptions, StackLdiOptions};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_ldi::Ldi;
use quadratura_ldi::splat::sums::LEVEL;

/// Makes what is requested until the builder is gone; finished images are kept within `memory` bytes. Those of stacks are
/// read from the project's cache where they are up to date there.
pub fn make_all(bench: &Workbench<ImageRequest, BuiltImage>, memory: u64) {
    let (mut kept, mut options) = (Kept::new(memory), StackLdiOptions::default());
    let mut next = bench.next();
    while let Some((request, task)) = next {
        let inputs = request.inputs.clone();
        next = match open(&inputs) {
            Ok(mut site) => {
                kept.keep_current(&site, &options);
                make_with(bench, &mut site, &mut kept, &mut options, (request, task))
            }
            Err(error) => {
                bench.finish(&task, Err(error));
                bench.next()
            }
        };
    }
}

/// Reads the stacks of a project; gains and relief are those that it is drawn with.
fn open(inputs: &LiveInputs) -> Result<LdiSite<'_>> {
    let mut site = LdiSite::open(&inputs.folder, &inputs.opened.project, &inputs.opened.site)?;
    site.set_estimates(inputs.gains.clone(), inputs.relief.clone(), &[]);
    Ok(site)
}

/// Makes what is requested of one state of the project; returns the first request of another one.
fn make_with(
    bench: &Workbench<ImageRequest, BuiltImage>,
    site: &mut LdiSite,
    kept: &mut Kept,
    options: &mut StackLdiOptions,
    first: (ImageRequest, Task),
) -> Option<(ImageRequest, Task)> {
    let inputs = first.0.inputs.clone();
    let mut next = Some(first);
    while let Some((request, task)) = next.take_if(|(request, _)| Arc::ptr_eq(&request.inputs, &inputs)) {
        if request.stack != *options {
            kept.clear();
            *options = request.stack;
        }
        let made = catch_unwind(AssertUnwindSafe(|| made(bench, site, kept, &request, &task)));
        let failed =
            || Error::Request("making a layered depth image failed; this is an error of the program".into());
        bench.finish(&task, made.unwrap_or_else(|_| Err(failed())));
        next = bench.next();
    }
    next
}

/// The least side of an image that is read coarsely, in pixels: it shows what is where, and is read in some milliseconds, so
/// that coarser levels would be there no sooner.
const COARSE_SIDE: u32 = 500;

/// Makes an image; drafts of it are a level of an image in the cache, then the stack of the reference photo.
fn made(
    bench: &Workbench<ImageRequest, BuiltImage>,
    site: &mut LdiSite,
    kept: &mut Kept,
    request: &ImageRequest,
    task: &Task,
) -> Result<BuiltImage> {
    let ImageRequest { photos, stack, peeled, .. } = request;
    let model = &request.inputs.opened.site.model;
    let built = |ldi: &Arc<Ldi>, photos: &[PhotoId], stage| BuiltImage {
        ldi: drawable(ldi, model, *peeled),
        photos: photos.to_vec(),
        stage,
    };
    let first = photos[0];
    if !kept.has_stack(first) {
        let coarse = |photo| Some((site.cached_coarsely(photo, stack, COARSE_SIDE, task)?, photo));
        if let Some((ldi, photo)) = photos.iter().copied().find_map(coarse) {
            bench.draft(task, built(&Arc::new(ldi), &[photo], RequestStage::Coarse));
        }
    }
    task.check_cancelled()?;
    // A photo that cannot be used is left out below.
    if let Ok(ldi) = kept.stack(site, first, stack, task) {
        bench.draft(task, built(&ldi, &[first], RequestStage::OnePhoto));
    }
    task.check_cancelled()?;
    let options = PhotosOptions { stack: *stack, hidden: true, ..PhotosOptions::default() };
    let whole = kept.photos(site, photos, request.halvings, &options, task)?;
    Ok(built(&whole, photos, RequestStage::Whole))
}

/// Returns an image as it is drawn: without layers that are hidden, and without what would be mixed with the surface before
/// it. Where no layer is hidden, it is without billboards that turn: the renderer draws them.
fn drawable(ldi: &Arc<Ldi>, model: &Model, peeled: u32) -> Arc<Ldi> {
    match peeled {
        0 => Arc::new(without_billboards(ldi.clone(), model).without_close(LEVEL)),
        _ => Arc::new(ldi.without_close(LEVEL).without_nearest(peeled)),
    }
}
