//! Drawing of trees in slices, between which it can be given up: hundreds of trees take a software adapter half a minute or more.

use wgpu::{CommandEncoder, PollType};

use crate::device::Gpu;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// Commands that are handed to the device in slices of a bounded cost. The device has done one before the next is handed over. What
/// costs less than one slice is waited for only where [`Self::hand_over`] is called.
pub struct Slices<'a> {
    gpu: &'a Gpu,
    task: &'a Task,
    /// The cost of a slice, in samples.
    most: f64,
    /// The cost of the commands in `encoder`.
    recorded: f64,
    /// The cost of the commands that the device has done.
    done: f64,
    encoder: CommandEncoder,
}

impl<'a> Slices<'a> {
    /// Begins without commands; a slice costs about `most` samples.
    pub fn new(gpu: &'a Gpu, task: &'a Task, most: f64) -> Self {
        let encoder = gpu.device.create_command_encoder(&Default::default());
        Self { gpu, task, most, recorded: 0.0, done: 0.0, encoder }
    }

    /// Returns the device.
    pub fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// Returns the cost of the commands that the device has done, in samples.
    pub fn done(&self) -> f64 {
        self.done
    }

    /// Returns the encoder of the current slice.
    pub fn encoder(&mut self) -> &mut CommandEncoder {
        &mut self.encoder
    }

    /// Returns what a slice costs, in samples.
    pub fn most(&self) -> f64 {
        self.most
    }

    /// Counts commands of this cost, and hands the slice over where it is full.
    ///
    /// # Errors
    /// Those of [`Self::hand_over`].
    pub fn count(&mut self, cost: f64) -> Result<()> {
        self.recorded += cost;
        if self.recorded < self.most { Ok(()) } else { self.hand_over() }
    }

    /// Hands the commands so far to the device and waits until it has done them.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the task was cancelled; [`Error::Gpu`] for a lost device.
    pub fn hand_over(&mut self) -> Result<()> {
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let full = std::mem::replace(&mut self.encoder, next);
        self.gpu.queue.submit([full.finish()]);
        let waited = self.gpu.device.poll(PollType::wait_indefinitely());
        waited.map_err(|error| Error::Gpu(format!("the device stopped while it drew trees: {error}")))?;
        self.done += std::mem::take(&mut self.recorded);
        self.task.check_cancelled()
    }

    /// Hands the rest to the device, without waiting for it.
    pub fn submit(self) {
        self.gpu.queue.submit([self.encoder.finish()]);
    }
}
