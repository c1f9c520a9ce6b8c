//! One run of the passes over a view: the items that are drawn, on the device.

use wgpu::{BindGroup, Buffer};

use super::device::Gpu;
use super::drawing::Triangles;
use super::frame::{self, PhotoRows};
use super::pairs::HALF_BITS;
use super::rasteriser::GpuRasteriser;
use quadratura_base::error::{Error, Result};
use quadratura_layers::ProjectedModel;

/// The items of a view that are drawn, with their triangles, on the device.
#[derive(Debug)]
pub struct DrawnItems<'a> {
    /// The view.
    pub view: &'a ProjectedModel,
    /// The relative depth tolerance.
    pub tolerance: f32,
    /// The items, rising. Their index in this list is their number in pass *pairs*.
    pub items: Vec<u32>,
    /// The triangles of the items.
    pub triangles: Triangles,
    planes: Buffer,
}

impl<'a> DrawnItems<'a> {
    /// Prepares all items, without numbers.
    pub fn of_all(gpu: &Gpu, view: &'a ProjectedModel, tolerance: f32) -> Self {
        let planes = frame::planes(gpu, view, |_| 0);
        Self {
            view,
            tolerance,
            items: Vec::new(),
            triangles: Triangles::from_gpu(gpu, view, |_| true),
            planes,
        }
    }

    /// Prepares some items, rising, numbered in this order.
    ///
    /// # Errors
    /// [`Error::Request`] when there are more items than pass *pairs* can number.
    pub fn some_items(gpu: &Gpu, view: &'a ProjectedModel, tolerance: f32, items: Vec<u32>) -> Result<Self> {
        if items.len() > 1 << HALF_BITS {
            return Err(Error::Request(format!(
                "one photo shows {} faces, at most {} can be sorted; simplify the model",
                items.len(),
                1 << HALF_BITS
            )));
        }
        let mut numbers = vec![u32::MAX; view.items.len()];
        for (number, &item) in (0..).zip(&items) {
            numbers[item as usize] = number;
        }
        let triangles = Triangles::from_gpu(gpu, view, |item| numbers[item as usize] != u32::MAX);
        let planes = frame::planes(gpu, view, |item| numbers[item]);
        Ok(Self { view, tolerance, items, triangles, planes })
    }
}

impl GpuRasteriser {
    /// Builds bind group 0 for some rows of a run.
    pub(super) fn share(&self, run: &DrawnItems, frame: &PhotoRows) -> BindGroup {
        frame.bind(&self.gpu, &self.frame, run.view, run.tolerance, &run.planes)
    }
}
