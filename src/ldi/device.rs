//! Devices that draw views of layered depth images in the place of the processor.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use super::{Ldi, WarpOptions};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_view::{Picture, Shot};

/// A device that draws views of layered depth images.
pub trait WarpDevice: Debug + Send + Sync {
    /// Prepares the device.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when it cannot draw them.
    fn warper(&self) -> Result<Box<dyn DeviceWarper>>;
}

/// Draws on a device.
pub trait DeviceWarper: Send {
    /// Uploads an image, with all its levels.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device has not enough memory.
    fn upload(&self, ldi: Arc<Ldi>) -> Result<UploadedLdi>;

    /// Makes a view of an image that this warper uploaded.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot draw a picture of this size, or is lost;
    /// [`quadratura_base::Error::Request`] for what only the processor draws, and for an image of another device;
    /// [`quadratura_base::Error::Cancelled`].
    fn picture(
        &mut self,
        image: &UploadedLdi,
        shot: &Shot,
        options: &WarpOptions,
        task: &Task,
    ) -> Result<Picture>;
}

/// An image on a device, as that device keeps it.
pub type UploadedLdi = Box<dyn Any + Send>;
