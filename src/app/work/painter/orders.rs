//! Ordered pictures, which the painter draws between those of the view: with the same renderer, so that nothing is
//! loaded twice, and in slices, so that the view stays responsive.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use super::{Shared, failed};
use crate::error::{Error, Result};
use crate::projection::{Picture, Renders, Shot, Sliced};
use crate::recipe::preview::Preview;
use crate::task::Task;

/// An ordered picture that a job waits for.
pub struct Order {
    shot: Shot,
    task: Task,
    reply: Sender<Result<Picture>>,
}

/// The queue in which a job orders pictures of the painter, drawn in order.
#[derive(Clone)]
pub struct Orders(pub(super) Arc<Shared>);

impl Orders {
    /// Orders the picture of a shot and waits for it.
    ///
    /// # Errors
    /// The errors of [`crate::projection::Renders::picture`]; [`Error::Request`] when the 3D view ended in the
    /// meantime.
    pub fn picture(&self, shot: Shot, task: &Task) -> Result<Picture> {
        let (reply, receive) = channel();
        let mut slot = self.0.slot();
        if slot.ends {
            return Err(ended());
        }
        slot.orders.push_back(Order { shot, task: task.clone(), reply });
        self.0.wake.notify_one();
        drop(slot);
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
                let whole = self.sliced.take().map(Sliced::picture);
                let reply = ended.and_then(|_| whole.ok_or_else(failed));
                // The job may have been stopped.
                let _ = self.order.take().map(|order| order.reply.send(reply));
            }
        }
    }
}

/// Draws a slice; returns whether the picture is complete.
fn slice(order: &Order, sliced: &mut Option<Sliced>, preview: &mut Preview) -> Result<bool> {
    order.task.go_on()?;
    let sliced = match sliced {
        Some(sliced) => sliced,
        None => sliced.insert(preview.begin(&order.shot, &order.task)?),
    };
    preview.advance(sliced, &order.task)
}
