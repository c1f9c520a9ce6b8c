//! A picture in slices: bands of rows, one submission each, so that whoever shares the device waits for one band and
//! never for a whole picture. What bands have in common is found out once, for the whole.

use super::{Picture, Shot};

/// What a slice should take: a window that waits for it does not miss more than one frame.
const WANTED_S: f64 = 0.01;
/// A slice has no fewer pixels: cells and tables of one take as long as drawing so many on a processor.
const LEAST_PX: f64 = 131_072.0;
/// The first slice has so many rows that are taken for slow: nothing is known yet.
const FIRST_PER_PX_S: f64 = 1e-7;

/// A picture that is being drawn: whole when [`super::Renders::advance`] says so.
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
    /// Nothing is drawn yet. `factors` are what bands have in common: of every photo, what its linear colours are
    /// multiplied with.
    pub fn new(shot: &Shot, factors: Vec<[f32; 3]>) -> Self {
        let px = shot.camera.width as usize * shot.camera.height as usize;
        Self { shot: shot.clone(), factors, rgba: Vec::with_capacity(4 * px), per_px_s: FIRST_PER_PX_S }
    }

    /// Rows that are drawn.
    fn row(&self) -> u32 {
        (self.rgba.len() / (4 * self.shot.camera.width as usize)) as u32
    }

    /// The camera's next rows, as a shot of its own: whole rows of cells, so that each cell is that of the whole picture.
    pub fn band(&self, cell_px: u32) -> Shot {
        let (row, mut shot) = (self.row(), self.shot.clone());
        let px = (WANTED_S / self.per_px_s).max(LEAST_PX);
        let rows = ((px / f64::from(shot.camera.width)).ceil() as u32).next_multiple_of(cell_px);
        shot.camera.height = rows.clamp(1, self.shot.camera.height - row);
        shot.camera.cy -= f64::from(row);
        shot
    }

    /// Of every photo, what its linear colours are multiplied with.
    pub fn factors(&self) -> &[[f32; 3]] {
        &self.factors
    }

    /// Takes the next rows; whether the picture is whole.
    pub fn add(&mut self, band: &Picture) -> bool {
        self.rgba.extend_from_slice(&band.rgba);
        self.row() >= self.shot.camera.height
    }

    /// Takes it that drawing costs so many seconds a pixel.
    pub fn costs(&mut self, per_px_s: f64) {
        self.per_px_s = per_px_s;
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
