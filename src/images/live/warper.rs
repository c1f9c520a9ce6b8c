//! Where the pixels of layered depth images are moved: on the GPU as long as that works, or on the processor.

use std::sync::Arc;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_ldi::device::{DeviceWarper, UploadedLdi, WarpDevice};
use quadratura_ldi::{Ldi, WarpOptions, warp};
use quadratura_view::{Picture, Shot};

/// Where views are drawn from layered depth images.
#[derive(Debug, Clone)]
pub enum WarpOn {
    /// On the processor.
    Processor,
    /// On a device, as long as that works, then on the processor.
    Device(Arc<dyn WarpDevice>),
}

/// An image that is drawn, with its depth pixels on the device from its first picture there on.
pub(super) struct OnDevice {
    /// The image.
    pub ldi: Arc<Ldi>,
    uploaded: Option<UploadedLdi>,
}

impl OnDevice {
    /// Takes an image, of which nothing is on a device yet.
    pub fn new(ldi: Arc<Ldi>) -> Self {
        Self { ldi, uploaded: None }
    }

    /// Returns whether its depth pixels are on a device.
    #[cfg(test)]
    pub fn is_uploaded(&self) -> bool {
        self.uploaded.is_some()
    }
}

/// Draws layered depth images.
pub(super) struct Warper {
    /// The device; none where the processor draws.
    on: WarpOn,
    /// The warp on the device, from the first picture on.
    prepared: Option<Box<dyn DeviceWarper>>,
}

impl Warper {
    /// Draws there; the device is prepared for the first picture.
    pub fn new(on: WarpOn) -> Self {
        Self { on, prepared: None }
    }

    /// Draws a view of an image. Where the device cannot, because it is lost or too small, this is noted, and this view and all
    /// later ones are drawn by the processor.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn picture(
        &mut self,
        image: &mut OnDevice,
        shot: &Shot,
        options: &WarpOptions,
        task: &Task,
    ) -> Result<Picture> {
        if let WarpOn::Device(device) = &self.on {
            match on_device(&**device, &mut self.prepared, image, shot, options, task) {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Ok(picture) => return Ok(picture),
                Err(error) => self.leave_device(&error, task),
            }
        }
        image.uploaded = None;
        Ok(warp(&image.ldi, shot, options, task)?.picture)
    }

    fn leave_device(&mut self, error: &Error, task: &Task) {
        (self.on, self.prepared) = (WarpOn::Processor, None);
        task.note(format!(
            "the graphics device cannot draw layered depth images; the processor draws them from now on: {error}"
        ));
    }
}

fn on_device(
    device: &dyn WarpDevice,
    prepared: &mut Option<Box<dyn DeviceWarper>>,
    image: &mut OnDevice,
    shot: &Shot,
    options: &WarpOptions,
    task: &Task,
) -> Result<Picture> {
    let warper = match prepared {
        Some(warper) => warper,
        None => prepared.insert(device.warper()?),
    };
    let uploaded = match &mut image.uploaded {
        Some(uploaded) => uploaded,
        None => image.uploaded.insert(warper.upload(image.ldi.clone())?),
    };
    warper.picture(uploaded, shot, options, task)
}
