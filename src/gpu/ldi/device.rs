//! Windows draw layered depth images on a device through [`WarpDevice`].

use std::sync::Arc;

use super::{GpuLdi, GpuWarp};
use crate::Gpu;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_ldi::device::{DeviceWarper, UploadedLdi, WarpDevice};
use quadratura_ldi::{Ldi, WarpOptions};
use quadratura_view::{Picture, Shot};

impl WarpDevice for Gpu {
    fn warper(&self) -> Result<Box<dyn DeviceWarper>> {
        Ok(Box::new(GpuWarp::new(self)?))
    }
}

impl DeviceWarper for GpuWarp {
    fn upload(&self, ldi: Arc<Ldi>) -> Result<UploadedLdi> {
        Ok(Box::new(Self::upload(self, ldi)?))
    }

    fn picture(
        &mut self,
        image: &UploadedLdi,
        shot: &Shot,
        options: &WarpOptions,
        task: &Task,
    ) -> Result<Picture> {
        let other = || Error::Request("the layered depth image is not on this device".into());
        let image = image.downcast_ref::<GpuLdi>().ok_or_else(other)?;
        Ok(Self::picture(self, image, shot, options, task)?.picture)
    }
}
