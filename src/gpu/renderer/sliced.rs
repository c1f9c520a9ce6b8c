//! Drawing of an image in slices on the device; [`Sliced`] holds what is drawn so far.

use std::time::Instant;

use super::Renderer;
use super::target::{self, Target};
use crate::error::Result;
use crate::projection::exposure::visible_shares;
use crate::projection::{Shot, Sliced};
use crate::task::Task;

impl Renderer {
    pub(super) fn begun(&mut self, shot: &Shot) -> Result<Sliced> {
        target::judge(&self.gpu, shot)?;
        self.face(shot);
        let exposure = self.exposure(shot, || {
            let cells = self.cells(shot, self.cell_px(shot), &[], self.store(shot));
            visible_shares(shot, &self.model, &self.sources, &self.surface, &cells)
        });
        Ok(Sliced::new(shot, exposure))
    }

    pub(super) fn advanced(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        let side_px = self.cell_px(sliced.shot());
        let (start, band) = (Instant::now(), sliced.band(side_px));
        let shots = (&band, sliced.shot());
        let is_complete = if band.linear {
            let drawn = self.drawn(shots, side_px, Some(sliced.exposure()), Target::linear_picture, task)?;
            sliced.add_linear(&drawn)
        } else {
            let drawn = self.drawn(shots, side_px, Some(sliced.exposure()), Target::picture, task)?;
            sliced.add(&drawn)
        };
        let px = f64::from(band.camera.width) * f64::from(band.camera.height);
        sliced.costs(start.elapsed().as_secs_f64() / px);
        Ok(is_complete)
    }
}
