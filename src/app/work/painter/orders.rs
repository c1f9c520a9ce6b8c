//! Ordered pictures, which the painter draws between those of the view: with the same renderer, so that nothing is
//! loaded twice, and in slices, so that the view stays responsive.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use super::{PainterQueue, failed};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_projection::{Renders, Sliced};
use quadratura_view::{LinearPicture, Shot};
use quadratura_views::preview::Preview;
use quadratura_views::render::DrawnPicture;

/// An ordered picture that a job waits for.
pub struct Order {
    shot: Shot,
    task: Task,
    reply: Sender<Result<DrawnPicture>>,
}

/// The queue in which a job orders pictures of the painter, drawn in order.
#[derive(Clone)]
pub struct Orders(pub(super) Arc<PainterQueue>);

impl Orders {
    /// Orders the picture of a shot and waits for it; a shot in linear light comes with its depths.
    ///
    /// # Errors
    /// The errors of [`quadratura_projection::Renders::picture`]; [`Error::Request`] when the 3D view ended in the
    /// meantime.
    pub fn picture(&self, shot: Shot, task: &Task) -> Result<DrawnPicture> {
        let (reply, receive) = channel();
        let mut state = self.0.state();
        if state.ends {
            return Err(ended());
        }
        state.orders.push_back(Order { shot, task: task.clone(), reply });
        self.0.wake.notify_one();
        drop(state);
        receive.recv().unwrap_or_else(|_| Err(ended()))
    }
}

fn ended() -> Error {
    Error::Request(
        "the 3D view was restarted during rendering, because layers changed or a restart was requested; render again"
            .into(),
    )
}

/// The order that is being drawn.
#[derive(Default)]
pub struct OrderInProgress {
    order: Option<Order>,
    sliced: Option<Sliced>,
}

impl OrderInProgress {
    /// Returns whether no order is being drawn.
    pub fn is_free(&self) -> bool {
        self.order.is_none()
    }

    /// Takes the next order, if none is being drawn.
    pub fn take(&mut self, orders: &mut VecDeque<Order>) {
        if self.is_free() {
            self.order = orders.pop_front();
        }
    }

    /// Restarts the current order, because the project has changed since it began.
    pub fn begin_anew(&mut self) {
        self.sliced = None;
    }

    /// Draws one slice of the order; the job gets the picture when it is complete, or its error.
    pub fn work(&mut self, preview: &mut Preview) {
        let Some(order) = &self.order else { return };
        let sliced = &mut self.sliced;
        let drawn = catch_unwind(AssertUnwindSafe(|| slice(order, sliced, preview)));
        match drawn.unwrap_or_else(|_| Err(failed())) {
            Ok(false) => (),
            ended => {
                let sliced = self.sliced.take();
                let finish = || finished(order, sliced.ok_or_else(failed)?, preview);
                let finish = || catch_unwind(AssertUnwindSafe(finish)).unwrap_or_else(|_| Err(failed()));
                let reply = ended.and_then(|_| finish());
                // The job may have been stopped.
                let _ = self.order.take().map(|order| order.reply.send(reply));
            }
        }
    }
}

/// Returns a picture that is complete.
fn finished(order: &Order, sliced: Sliced, preview: &mut Preview) -> Result<DrawnPicture> {
    if !order.shot.linear {
        return Ok(sliced.picture().into());
    }
    let depths = preview.depths(&order.shot, &order.task)?;
    Ok(LinearPicture { depths, ..sliced.linear_picture() }.into())
}

/// Draws a slice; returns whether the picture is complete.
fn slice(order: &Order, sliced: &mut Option<Sliced>, preview: &mut Preview) -> Result<bool> {
    order.task.check_cancelled()?;
    let sliced = match sliced {
        Some(sliced) => sliced,
        None => sliced.insert(preview.begin(&order.shot, &order.task)?),
    };
    preview.advance(sliced, &order.task)
}
