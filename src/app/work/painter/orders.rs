//! Pictures to keep, drawn by the painter between those of the view: by the same renderer, so that nothing is read and
//! held a second time, and in slices, so that the view goes on answering.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use super::{Shared, failed};
use crate::error::{Error, Result};
use crate::projection::{Picture, Renders, Shot, Sliced};
use crate::recipe::preview::Preview;
use crate::task::Task;

/// A picture that somebody waits for.
pub struct Order {
    shot: Shot,
    task: Task,
    reply: Sender<Result<Picture>>,
}

/// Where a job orders pictures of the painter; drawn one after the other, in the order of their being ordered.
#[derive(Clone)]
pub struct Orders(pub(super) Arc<Shared>);

impl Orders {
    /// The picture of a shot; waits for it.
    ///
    /// # Errors
    /// Those of [`crate::projection::Renders::picture`]; [`Error::Request`] when the 3D view ended meanwhile.
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
        "the 3D view, which draws it, was started anew meanwhile, because layers changed or it was asked to; make it again"
            .into(),
    )
}

/// The order that is being drawn.
#[derive(Default)]
pub struct Bench {
    order: Option<Order>,
    sliced: Option<Sliced>,
}

impl Bench {
    /// Nothing is begun.
    pub fn is_free(&self) -> bool {
        self.order.is_none()
    }

    /// Takes the next order up, if none is begun.
    pub fn take(&mut self, orders: &mut VecDeque<Order>) {
        if self.is_free() {
            self.order = orders.pop_front();
        }
    }

    /// What is drawn of the order that is begun is of another state of the project: it is drawn from its beginning.
    pub fn begin_anew(&mut self) {
        self.sliced = None;
    }

    /// Draws one slice of what was ordered; whoever ordered gets the picture when it is whole, or why there is none.
    pub fn work(&mut self, preview: &mut Preview) {
        let Some(order) = &self.order else { return };
        let sliced = &mut self.sliced;
        let drawn = catch_unwind(AssertUnwindSafe(|| slice(order, sliced, preview)));
        match drawn.unwrap_or_else(|_| Err(failed())) {
            Ok(false) => (),
            ended => {
                let whole = self.sliced.take().map(Sliced::picture);
                let reply = ended.and_then(|_| whole.ok_or_else(failed));
                // Whoever ordered may have been stopped.
                let _ = self.order.take().map(|order| order.reply.send(reply));
            }
        }
    }
}

/// Whether the picture is whole.
fn slice(order: &Order, sliced: &mut Option<Sliced>, preview: &mut Preview) -> Result<bool> {
    order.task.go_on()?;
    let sliced = match sliced {
        Some(sliced) => sliced,
        None => sliced.insert(preview.begin(&order.shot, &order.task)?),
    };
    preview.advance(sliced, &order.task)
}
