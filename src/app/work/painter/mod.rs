//! The painter draws novel views on a thread and device of its own: the window stays responsive however long a picture
//! takes, and a lost device loses no unsaved work. Only the newest request of the view is drawn; ordered pictures are
//! drawn between requests.

mod images;
mod orders;

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use glam::DVec3;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

pub use self::orders::Orders;

use self::images::PainterImages;
use self::orders::{Order, OrderInProgress};
use super::waker::Waker;
use crate::state::space::picture::{PaintedPicture, PictureRequest};
use crate::state::trees::ShownTrees;
use quadratura_base::error::{Error, Result};
use quadratura_base::raster::over::on_opaque;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::paint::PaintBook;
use quadratura_gpu::Gpu;
use quadratura_images::live::WarpOn;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::{Gains, Renders, shown_face};
use quadratura_sites::open::Opened;
use quadratura_stacks::projected_paint::ProjectedPaint;
use quadratura_stacks::surroundings::SiteSurroundings;
use quadratura_view::Picture;
use quadratura_views::preview::Preview;

/// A change that later pictures show; the renderer is not made again for it.
pub enum PreviewChange {
    /// The current paint of the photos with these names.
    Paint(Vec<String>, Arc<PaintBook>),
    /// Paint on these photos that their files do not contain yet.
    Projected(Vec<PhotoId>, Vec<ProjectedPaint>),
    /// Stacks with other fillings, in the site's order; image layers are the same.
    Fillings(Vec<Option<Arc<Stack>>>),
    /// The gains of the photos.
    Gains(Box<Gains>),
    /// The surroundings, compared and blended with the present gains and paint.
    Surroundings(Box<SiteSurroundings>),
    /// The decisions about photos and faces, for the same model and stacks.
    Decisions(Arc<Opened>),
    /// The files of plants, which are read again when the trees are shown next.
    Plants,
    /// The trees of the project.
    Trees(ShownTrees),
}

/// The work that waits for the painter, and what it is doing.
#[derive(Default)]
struct QueueState {
    request: Option<PictureRequest>,
    /// The changes to apply, oldest first.
    changes: Vec<PreviewChange>,
    /// Whether changes are being applied.
    changing: bool,
    /// The ordered pictures, oldest first.
    orders: VecDeque<Order>,
    /// Whether the last picture would be another one now, because a layered depth image is there.
    again: bool,
    /// The flag that stops the current picture, and whether it yields to a newer one.
    drawing: Option<(Arc<AtomicBool>, bool)>,
    ends: bool,
}

/// The queue that the window and jobs fill, and the thread of the painter empties.
#[derive(Default)]
struct PainterQueue {
    state: Mutex<QueueState>,
    wake: Condvar,
}

impl PainterQueue {
    fn state(&self) -> MutexGuard<'_, QueueState> {
        // A thread that panicked while drawing did not hold this lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The handle of the thread that draws.
pub struct Painter {
    queue: Arc<PainterQueue>,
    receive: Receiver<Result<PaintedPicture>>,
    /// The adapter's name, kind, interface and driver.
    pub adapter: String,
    /// The surface that rays intersect, as it is drawn.
    pub surface: Arc<ModelSurface>,
    /// Whether a request is not drawn yet.
    pending: bool,
    thread: Option<JoinHandle<()>>,
}

/// Returns where layered depth images are drawn faster: on the device, unless it is a software renderer, for which sums by atomic
/// operations take longer than they take the processor.
fn warps_on(gpu: &Gpu) -> WarpOn {
    if gpu.is_software() { WarpOn::Processor } else { WarpOn::Device(Arc::new(gpu.clone())) }
}

impl Painter {
    /// Moves `preview` to a new thread, with the folder of its project; layered depth images are drawn on the same `gpu` where that
    /// is faster than the processor. The window is woken for every picture. Notes of drawing go to `task`.
    ///
    /// # Errors
    /// [`Error::Request`] when the system cannot start a thread.
    pub fn new(
        preview: Preview,
        folder: PathBuf,
        opened: Arc<Opened>,
        gpu: &Gpu,
        task: Task,
        waker: Waker,
    ) -> Result<Self> {
        let queue = Arc::<PainterQueue>::default();
        let (send, receive) = channel();
        let (theirs, surface) = (queue.clone(), preview.surface());
        let (bench, last) = Default::default();
        let images = PainterImages::new(folder, opened, theirs.clone(), warps_on(gpu));
        let adapter = gpu.adapter_summary();
        // Threads of its own: all others are those of jobs in the background, which have a lower priority.
        let pool = ThreadPoolBuilder::new().thread_name(|_| "painter".into()).build();
        let pool = pool.map_err(|error| {
            Error::Request(format!("the system cannot start the threads of the 3D view: {error}"))
        })?;
        let draw = move || {
            pool.install(move || {
                PainterThread { preview, images, task, send, waker, bench, last }.run(&theirs)
            });
        };
        let started = std::thread::Builder::new().name("painter".into()).spawn(draw);
        let thread = started.map_err(|error| {
            Error::Request(format!("the system cannot start a thread for the 3D view: {error}"))
        })?;
        Ok(Self { queue, receive, adapter, surface, pending: false, thread: Some(thread) })
    }

    /// Returns the queue in which jobs order pictures.
    pub fn orders(&self) -> Orders {
        Orders(self.queue.clone())
    }

    /// Requests a picture, which replaces all earlier requests.
    pub fn request(&mut self, request: PictureRequest) {
        let mut state = self.queue.state();
        if let Some((stop, true)) = &state.drawing {
            stop.store(true, Ordering::Relaxed);
        }
        state.request = Some(request);
        self.pending = true;
        self.queue.wake.notify_one();
    }

    /// Applies a change to all pictures requested from now on.
    pub fn change(&mut self, change: PreviewChange) {
        let mut state = self.queue.state();
        // Only the latest change of gains, of surroundings, of decisions, and of trees, counts.
        match change {
            PreviewChange::Gains(_) => {
                state.changes.retain(|other| !matches!(other, PreviewChange::Gains(_)))
            }
            PreviewChange::Decisions(_) => {
                state.changes.retain(|other| !matches!(other, PreviewChange::Decisions(_)))
            }
            PreviewChange::Fillings(_) => {
                state.changes.retain(|other| !matches!(other, PreviewChange::Fillings(_)))
            }
            PreviewChange::Surroundings(_) => {
                state.changes.retain(|other| !matches!(other, PreviewChange::Surroundings(_)));
            }
            PreviewChange::Trees(_) => {
                state.changes.retain(|other| !matches!(other, PreviewChange::Trees(_)))
            }
            PreviewChange::Paint(..) | PreviewChange::Projected(..) | PreviewChange::Plants => (),
        }
        state.changes.push(change);
        self.queue.wake.notify_one();
    }

    /// Returns whether a request is not answered yet.
    pub fn is_busy(&self) -> bool {
        self.pending
    }

    /// Returns whether all changes are applied.
    pub fn is_settled(&self) -> bool {
        let state = self.queue.state();
        state.changes.is_empty() && !state.changing
    }

    /// Receives the newest picture, or its error.
    pub fn receive(&mut self) -> Option<Result<PaintedPicture>> {
        let newest = self.receive.try_iter().last()?;
        let state = self.queue.state();
        self.pending = state.request.is_some();
        Some(newest)
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        let mut state = self.queue.state();
        state.ends = true;
        // The waiting jobs get an error, because no painter is left.
        state.orders.clear();
        if let Some((stop, _)) = &state.drawing {
            stop.store(true, Ordering::Relaxed);
        }
        drop(state);
        self.queue.wake.notify_one();
        // The driver must not be in use when the program ends.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread of the painter has, from picture to picture.
struct PainterThread {
    preview: Preview,
    images: PainterImages,
    task: Task,
    send: Sender<Result<PaintedPicture>>,
    waker: Waker,
    bench: OrderInProgress,
    /// The last request, where it was for a picture from layered depth images: it is drawn again when there are others.
    last: Option<PictureRequest>,
}

impl PainterThread {
    fn run(mut self, queue: &PainterQueue) {
        while let Some(PainterWork { changes, request }) = next(queue, &mut self.bench, self.last.as_ref()) {
            if !changes.is_empty() {
                // A picture shows one state of the project.
                self.bench.begin_anew();
                self.images.changed();
            }
            let changed = changes.into_iter().try_for_each(|change| self.change(change));
            queue.state().changing = false;
            match request {
                Some((request, stop)) => {
                    self.last = request.from.options().map(|_| request.clone());
                    let done = changed.and_then(|()| self.guarded(request, stop));
                    queue.state().drawing = None;
                    // A picture that was dropped is followed by the one it was dropped for.
                    if !matches!(done, Err(Error::Cancelled)) {
                        self.notify(done);
                    }
                }
                None => changed.err().into_iter().for_each(|error| self.notify(Err(error))),
            }
            // Requests and orders alternate, so that neither waits for the other to finish.
            self.bench.work(&mut self.preview);
        }
    }

    fn notify(&self, done: Result<PaintedPicture>) {
        // The window may be gone.
        let _ = self.send.send(done);
        self.waker.wake();
    }

    /// Applies a change. Unreadable paint is reported and pictures stay as they were; only faults of the device end the
    /// painter.
    fn change(&mut self, change: PreviewChange) -> Result<()> {
        let what = match change {
            PreviewChange::Gains(_) => "exposures",
            PreviewChange::Decisions(_) => "decisions",
            PreviewChange::Paint(..) | PreviewChange::Projected(..) => "painted layers",
            PreviewChange::Fillings(_) => "fillings",
            PreviewChange::Surroundings(_) => "surroundings",
            PreviewChange::Trees(_) | PreviewChange::Plants => "trees",
        };
        let changed = match change {
            PreviewChange::Gains(gains) => self.preview.set_gains(*gains),
            PreviewChange::Paint(photos, book) => {
                let (preview, task) = (&mut self.preview, &self.task);
                let renew = || preview.reload_paint(&photos, &book, task).map(drop);
                catch_unwind(AssertUnwindSafe(renew)).unwrap_or_else(|_| Err(failed()))
            }
            PreviewChange::Projected(photos, paint) => {
                let (preview, task) = (&mut self.preview, &self.task);
                let show = || preview.show_projected(&photos, paint, task).map(drop);
                catch_unwind(AssertUnwindSafe(show)).unwrap_or_else(|_| Err(failed()))
            }
            PreviewChange::Fillings(stacks) => {
                let (preview, task) = (&mut self.preview, &self.task);
                // Where image layers are others, another painter is being made of them.
                let refill = || preview.refill(&stacks, task).map(drop);
                catch_unwind(AssertUnwindSafe(refill)).unwrap_or_else(|_| Err(failed()))
            }
            PreviewChange::Surroundings(surroundings) => {
                let (preview, task) = (&mut self.preview, &self.task);
                let renew = || preview.set_surroundings(*surroundings, task);
                catch_unwind(AssertUnwindSafe(renew)).unwrap_or_else(|_| Err(failed()))
            }
            PreviewChange::Decisions(opened) => {
                self.images.opened = opened.clone();
                let redecide = || self.preview.redecide(&opened.site, &opened.project.decisions);
                catch_unwind(AssertUnwindSafe(redecide)).unwrap_or_else(|_| Err(failed()))
            }
            PreviewChange::Plants => {
                self.preview.forget_plants();
                Ok(())
            }
            PreviewChange::Trees(ShownTrees { project, hidden, estimate, .. }) => {
                let (preview, task) = (&mut self.preview, &self.task);
                let plant = || preview.set_trees(&project.trees, &hidden, estimate, task);
                catch_unwind(AssertUnwindSafe(plant)).unwrap_or_else(|_| Err(failed()))
            }
        };
        match changed {
            Err(Error::Gpu(said)) => Err(Error::Gpu(said)),
            Err(error) => {
                self.task.note(format!("the 3D view shows the previous {what}: {error}"));
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    fn guarded(&mut self, request: PictureRequest, stop: Arc<AtomicBool>) -> Result<PaintedPicture> {
        let task = self.task.with_stop_flag(stop);
        catch_unwind(AssertUnwindSafe(|| self.draw(request, &task))).unwrap_or_else(|_| Err(failed()))
    }

    fn draw(&mut self, request: PictureRequest, task: &Task) -> Result<PaintedPicture> {
        let start = Instant::now();
        let (picture, images) = self.images.drawn(&mut self.preview, &request, task)?;
        let (image, faces) = match picture {
            Some(picture) => (composed(&picture, &[], &[], request.background), Vec::new()),
            None => {
                let picture = self.preview.picture(&request.shot, task)?;
                let faces = self.preview.seen_faces(&request.shot, task)?;
                let shades = shades(&self.images.opened.site.model, request.shot.viewpoint());
                (composed(&picture, &faces, &shades, request.background), faces)
            }
        };
        let (surface, spent) = (self.preview.surface(), start.elapsed());
        Ok(PaintedPicture { request, image, faces, surface, spent, images })
    }
}

fn failed() -> Error {
    Error::Gpu("drawing the 3D view failed; `Restart 3D view` restarts it".into())
}

/// The next work: changes, then a picture with the flag that stops it, then a slice of the order on the bench.
struct PainterWork {
    changes: Vec<PreviewChange>,
    request: Option<(PictureRequest, Arc<AtomicBool>)>,
}

/// Waits for work; none when the painter is gone. Puts an order on the bench where that is free. Where nothing is requested
/// and the `last` picture would be another one now, it is drawn again.
fn next(
    queue: &PainterQueue,
    bench: &mut OrderInProgress,
    last: Option<&PictureRequest>,
) -> Option<PainterWork> {
    let is_free = bench.is_free();
    let waiting = |state: &mut QueueState| {
        let nothing = state.request.is_none() && state.changes.is_empty() && state.orders.is_empty();
        is_free && nothing && !state.again && !state.ends
    };
    let mut state = queue.wake.wait_while(queue.state(), waiting).unwrap_or_else(PoisonError::into_inner);
    if state.ends {
        return None;
    }
    bench.take(&mut state.orders);
    let changes = std::mem::take(&mut state.changes);
    state.changing = !changes.is_empty();
    let again = std::mem::take(&mut state.again);
    let stop = Arc::<AtomicBool>::default();
    let request = state.request.take();
    // A picture that is drawn again gives way to any other.
    let yields = request.as_ref().is_none_or(|request| request.yields);
    let request = request.or_else(|| last.filter(|_| again).cloned());
    state.drawing = request.as_ref().map(|_| (stop.clone(), yields));
    Some(PainterWork { changes, request: request.map(|request| (request, stop)) })
}

/// Computes the grey of each untextured face: lighter the more it turns to the viewpoint.
fn shades(model: &Model, viewpoint: DVec3) -> Vec<u8> {
    let shade = |face: &quadratura_base::scene::Face| {
        let towards = (viewpoint - face.plane.point).normalize_or_zero();
        (80.0 + 90.0 * face.plane.normal.dot(towards).abs()) as u8
    };
    model.faces.iter().map(shade).collect()
}

/// The pixels that one thread composites without a pause: less work is not worth a thread.
const PIXELS_AT_ONCE: usize = 1 << 15;

/// Composites the picture over shaded faces over the background; the result is opaque. Without `faces`, nothing is shaded.
fn composed(picture: &Picture, faces: &[u32], shades: &[u8], background: [u8; 3]) -> Picture {
    let pixel = |(index, rgba): (usize, &[u8; 4])| {
        if rgba[3] == u8::MAX {
            return *rgba;
        }
        let below = match faces.get(index).copied().and_then(shown_face) {
            Some(face) => [shades.get(face.0 as usize).copied().unwrap_or_default(); 3],
            None => background,
        };
        let [r, g, b] = [0, 1, 2].map(|c| on_opaque(rgba[c], rgba[3], below[c]));
        [r, g, b, u8::MAX]
    };
    let pixels = picture.rgba.as_chunks::<4>().0.par_iter().enumerate().with_min_len(PIXELS_AT_ONCE);
    let pixels: Vec<[u8; 4]> = pixels.map(pixel).collect();
    Picture { width: picture.width, height: picture.height, rgba: pixels.into_flattened() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_lies_over_shaded_faces_over_the_background() {
        let rgba = vec![9, 8, 7, 255, 0, 0, 0, 0, 0, 0, 0, 0];
        let picture = Picture { width: 3, height: 1, rgba };
        let image = composed(&picture, &[1, 1, 0], &[100], [1, 2, 3]);
        assert_eq!(image.rgba.as_chunks().0, [[9, 8, 7, 255], [100, 100, 100, 255], [1, 2, 3, 255]]);
        assert_eq!((image.width, image.height), (3, 1));
    }
}
