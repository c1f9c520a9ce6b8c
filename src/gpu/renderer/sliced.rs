//! A picture in slices: bands of rows, one submission each, so that whoever shares the device waits for one band and
//! never for a whole picture. What bands have in common is found out once, for the whole.

use std::time::Instant;

use super::Renderer;
use super::target;
use crate::error::Result;
use crate::projection::{Picture, Shot};
use crate::task::Task;

/// What a slice should take: a window that waits for it does not miss more than one frame.
const WANTED_S: f64 = 0.01;
/// A slice has no fewer pixels: cells and tables of one take as long as drawing so many on a processor.
const LEAST_PX: f64 = 131_072.0;
/// The first slice has so many rows that are taken for slow: nothing is known yet.
const FIRST_PER_PX_S: f64 = 1e-7;

/// A picture that is being drawn: whole when [`Renderer::advance`] says so.
#[derive(Debug)]
pub struct Sliced {
    shot: Shot,
    /// Of the whole picture, by photo: bands of different exposure would show.
    factors: Vec<[f32; 3]>,
    /// sRGB and alpha of the rows that are drawn.
    rgba: Vec<u8>,
    per_px_s: f64,
}

impl Sliced {
    /// Rows that are drawn.
    fn row(&self) -> u32 {
        (self.rgba.len() / (4 * self.shot.camera.width as usize)) as u32
    }

    /// The camera's next rows, as a shot of its own: whole rows of cells, so that each cell is that of the whole picture.
    fn band(&self, cell_px: u32) -> Shot {
        let (row, mut shot) = (self.row(), self.shot.clone());
        let px = (WANTED_S / self.per_px_s).max(LEAST_PX);
        let rows = ((px / f64::from(shot.camera.width)).ceil() as u32).next_multiple_of(cell_px);
        shot.camera.height = rows.clamp(1, self.shot.camera.height - row);
        shot.camera.cy -= f64::from(row);
        shot
    }

    /// What it is a picture of.
    pub fn shot(&self) -> &Shot {
        &self.shot
    }

    /// The picture, once it is whole.
    pub fn picture(self) -> Picture {
        Picture { width: self.shot.camera.width, height: self.shot.camera.height, rgba: self.rgba }
    }
}

impl Renderer {
    /// Begins a picture.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device cannot draw pictures of this size.
    pub fn begin(&self, shot: &Shot) -> Result<Sliced> {
        target::judge(&self.gpu, shot)?;
        let factors = self.factors(shot, &self.cells(shot, self.cell_px(shot), self.store(shot)));
        let px = shot.camera.width as usize * shot.camera.height as usize;
        let rgba = Vec::with_capacity(4 * px);
        Ok(Sliced { shot: shot.clone(), factors, rgba, per_px_s: FIRST_PER_PX_S })
    }

    /// Draws the next slice; whether the picture is whole.
    ///
    /// # Errors
    /// Those of [`crate::projection::Renders::picture`].
    pub fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        let side_px = self.cell_px(&sliced.shot);
        let (start, band) = (Instant::now(), sliced.band(side_px));
        let drawn = self.drawn(&band, side_px, Some(&sliced.factors), task)?;
        let px = f64::from(band.camera.width) * f64::from(band.camera.height);
        sliced.per_px_s = start.elapsed().as_secs_f64() / px;
        sliced.rgba.extend_from_slice(&drawn.rgba);
        Ok(sliced.row() == sliced.shot.camera.height)
    }
}
