//! Drawing of an image in slices, bands of rows with one submission each, so that other users of the device
//! wait for one band and never for a whole image. Data common to all bands is computed once, for the whole
//! image.

use std::time::Instant;

use super::Renderer;
use super::target;
use crate::error::Result;
use crate::projection::{Picture, Shot};
use crate::task::Task;

/// The time that a slice should take, in seconds: a window that waits for it misses at most one frame.
const WANTED_S: f64 = 0.01;
/// The least number of pixels of a slice; preparing the cells and tables of a slice takes as long as drawing
/// this many pixels on a CPU.
const LEAST_PX: f64 = 131_072.0;
/// The time per pixel assumed for the first slice, in seconds; a slow one, because nothing is known yet.
const FIRST_PER_PX_S: f64 = 1e-7;

/// An image that is being drawn; complete when [`Renderer::advance`] returns true.
#[derive(Debug)]
pub struct Sliced {
    shot: Shot,
    /// The exposure factors of the whole image per photo; bands of different exposure would be visible.
    factors: Vec<[f32; 3]>,
    /// sRGB and alpha of the rows drawn so far.
    rgba: Vec<u8>,
    per_px_s: f64,
}

impl Sliced {
    /// Returns the number of rows drawn so far.
    fn row(&self) -> u32 {
        (self.rgba.len() / (4 * self.shot.camera.width as usize)) as u32
    }

    /// Returns the next rows as a view of its own: whole rows of cells, so that each cell is the same as in
    /// the whole image.
    fn band(&self, cell_px: u32) -> Shot {
        let (row, mut shot) = (self.row(), self.shot.clone());
        let px = (WANTED_S / self.per_px_s).max(LEAST_PX);
        let rows = ((px / f64::from(shot.camera.width)).ceil() as u32).next_multiple_of(cell_px);
        shot.camera.height = rows.clamp(1, self.shot.camera.height - row);
        shot.camera.cy -= f64::from(row);
        shot
    }

    /// Returns the view that is drawn.
    pub fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the image, once it is complete.
    pub fn picture(self) -> Picture {
        Picture { width: self.shot.camera.width, height: self.shot.camera.height, rgba: self.rgba }
    }
}

impl Renderer {
    /// Begins an image.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device cannot draw images of this size.
    pub fn begin(&self, shot: &Shot) -> Result<Sliced> {
        target::judge(&self.gpu, shot)?;
        let factors = self.factors(shot, &self.cells(shot, self.cell_px(shot), self.store(shot)));
        let px = shot.camera.width as usize * shot.camera.height as usize;
        let rgba = Vec::with_capacity(4 * px);
        Ok(Sliced { shot: shot.clone(), factors, rgba, per_px_s: FIRST_PER_PX_S })
    }

    /// Draws the next slice; returns whether the image is complete.
    ///
    /// # Errors
    /// The errors of [`crate::projection::Renders::picture`].
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
