//! Images drawn in slices, bands of rows with one submission each, so that other users of the device wait for one
//! band and never for a whole image. Data common to all bands is computed once, for the whole image.

use super::exposure::ViewExposure;
use super::{Picture, Shot};

/// The time that a slice should take, in seconds: a window that waits for it misses at most one frame.
const WANTED_S: f64 = 0.01;
/// The least number of pixels of a slice; preparing the cells and tables of a slice takes as long as drawing
/// this many pixels on a CPU.
const LEAST_PX: f64 = 131_072.0;
/// The time per pixel assumed for the first slice, in seconds; a slow one, because nothing is known yet.
const FIRST_PER_PX_S: f64 = 1e-7;

/// An image that is being drawn; complete when [`super::Renders::advance`] returns true.
#[derive(Debug)]
pub struct Sliced {
    shot: Shot,
    /// The exposure of the whole image; bands of different exposure would be visible.
    exposure: ViewExposure,
    /// sRGB and alpha of the rows drawn so far.
    rgba: Vec<u8>,
    per_px_s: f64,
}

impl Sliced {
    /// Creates an image without rows. `exposure` is common to all bands.
    pub fn new(shot: &Shot, exposure: ViewExposure) -> Self {
        let px = shot.camera.width as usize * shot.camera.height as usize;
        Self { shot: shot.clone(), exposure, rgba: Vec::with_capacity(4 * px), per_px_s: FIRST_PER_PX_S }
    }

    /// Returns the number of rows drawn so far.
    fn row(&self) -> u32 {
        (self.rgba.len() / (4 * self.shot.camera.width as usize)) as u32
    }

    /// Returns the next rows as a view of its own: whole rows of cells, so that each cell is the same as in
    /// the whole image.
    pub fn band(&self, cell_px: u32) -> Shot {
        let (row, mut shot) = (self.row(), self.shot.clone());
        let px = (WANTED_S / self.per_px_s).max(LEAST_PX);
        let rows = ((px / f64::from(shot.camera.width)).ceil() as u32).next_multiple_of(cell_px);
        shot.camera.height = rows.clamp(1, self.shot.camera.height - row);
        shot.camera.cy -= f64::from(row);
        shot
    }

    /// Returns the exposure of the whole image.
    pub fn exposure(&self) -> &ViewExposure {
        &self.exposure
    }

    /// Appends the next rows; returns whether the image is complete.
    pub fn add(&mut self, band: &Picture) -> bool {
        self.rgba.extend_from_slice(&band.rgba);
        self.row() >= self.shot.camera.height
    }

    /// Sets the measured time per pixel, in seconds.
    pub fn costs(&mut self, per_px_s: f64) {
        self.per_px_s = per_px_s;
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
