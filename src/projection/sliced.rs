//! Images drawn in slices, bands of rows with one submission each, so that other users of the device wait for one
//! band and never for a whole image. Data common to all bands is computed once, for the whole image.

use std::ops::Range;

use super::exposure::ViewExposure;
use super::{LinearPicture, Picture, Shot};

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
    /// sRGB and alpha of the rows drawn so far, where the image is not drawn in linear light.
    rgba: Vec<u8>,
    /// The rows drawn so far in linear light.
    linear: Vec<[f32; 4]>,
    /// The row behind the last one that is drawn.
    end: u32,
    /// The measured time per pixel, in seconds; `None` where all rows are drawn at once.
    per_px_s: Option<f64>,
}

impl Sliced {
    /// Creates an image without rows. `exposure` is common to all bands.
    pub fn new(shot: &Shot, exposure: ViewExposure) -> Self {
        let (end, per_px_s) = (shot.camera.height, Some(FIRST_PER_PX_S));
        Self { shot: shot.clone(), exposure, rgba: Vec::new(), linear: Vec::new(), end, per_px_s }
    }

    /// Creates an image of which some rows are drawn at once; all others stay empty.
    pub fn of_rows(shot: &Shot, exposure: ViewExposure, rows: Range<u32>) -> Self {
        let whole = Self::new(shot, exposure);
        let above = shot.camera.width as usize * rows.start as usize;
        let (rgba, linear) = if shot.linear { (0, above) } else { (4 * above, 0) };
        let (rgba, linear) = (vec![0; rgba], vec![[0.0; 4]; linear]);
        Self { rgba, linear, end: rows.end.min(whole.end), per_px_s: None, ..whole }
    }

    /// Returns the number of rows drawn so far.
    fn row(&self) -> u32 {
        let px = if self.shot.linear { self.linear.len() } else { self.rgba.len() / 4 };
        (px / self.shot.camera.width as usize) as u32
    }

    /// Returns the next rows as a view of its own: whole rows of cells, so that each cell is the same as in
    /// the whole image.
    pub fn band(&self, cell_px: u32) -> Shot {
        let (row, mut shot) = (self.row(), self.shot.clone());
        let left = self.end.saturating_sub(row).max(1);
        shot.camera.height = self.per_px_s.map_or(left, |per_px_s| {
            let px = (WANTED_S / per_px_s).max(LEAST_PX);
            let rows = ((px / f64::from(self.shot.camera.width)).ceil() as u32).next_multiple_of(cell_px);
            rows.clamp(1, left)
        });
        shot.camera.cy -= f64::from(row);
        shot
    }

    /// Returns the exposure of the whole image.
    pub fn exposure(&self) -> &ViewExposure {
        &self.exposure
    }

    /// Appends the next rows, or takes the whole image; returns whether it is complete.
    pub fn add(&mut self, band: &Picture) -> bool {
        if self.shot.linear {
            return self.add_linear(&LinearPicture::of(band));
        }
        if band.height == self.shot.camera.height {
            self.rgba.clear();
        }
        self.rgba.extend_from_slice(&band.rgba);
        self.row() >= self.end
    }

    /// As [`Self::add`], of an image in linear light.
    pub fn add_linear(&mut self, band: &LinearPicture) -> bool {
        if band.height == self.shot.camera.height {
            self.linear.clear();
        }
        self.linear.extend_from_slice(&band.rgba);
        self.row() >= self.end
    }

    /// Sets the measured time per pixel, in seconds.
    pub fn costs(&mut self, per_px_s: f64) {
        self.per_px_s = self.per_px_s.map(|_| per_px_s);
    }

    /// Returns the view that is drawn.
    pub fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the image, once it is complete.
    pub fn picture(mut self) -> Picture {
        if self.shot.linear {
            return self.linear_picture().picture();
        }
        let (width, height) = (self.shot.camera.width, self.shot.camera.height);
        self.rgba.resize(4 * width as usize * height as usize, 0);
        Picture { width, height, rgba: self.rgba }
    }

    /// Returns the image in linear light, without depths, once it is complete.
    pub fn linear_picture(mut self) -> LinearPicture {
        if !self.shot.linear {
            return LinearPicture::of(&self.picture());
        }
        let (width, height) = (self.shot.camera.width, self.shot.camera.height);
        self.linear.resize(width as usize * height as usize, [0.0; 4]);
        LinearPicture { width, height, rgba: self.linear, depths: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::{camera_is_world, centred};

    #[test]
    fn rows_are_drawn_at_once_where_they_are_in_the_image_and_the_others_stay_empty() {
        let shot = Shot::new(centred(4, 9, 5.0), camera_is_world());
        let mut sliced = Sliced::of_rows(&shot, ViewExposure::default(), 3..7);
        let band = sliced.band(16);
        assert_eq!((band.camera.height, band.camera.cy), (4, shot.camera.cy - 3.0));
        sliced.costs(1.0);
        assert!(sliced.add(&Picture { width: 4, height: 4, rgba: vec![7; 64] }));
        let picture = sliced.picture();
        let rows: Vec<u8> = picture.rgba.chunks(16).map(|row| row[0]).collect();
        assert_eq!(rows, [0, 0, 0, 7, 7, 7, 7, 0, 0]);
        let mut sliced = Sliced::of_rows(&shot, ViewExposure::default(), 3..7);
        assert!(sliced.add(&Picture { width: 4, height: 9, rgba: vec![7; 144] }));
        assert_eq!(sliced.picture().rgba, [7; 144], "a renderer without slices draws all");
    }

    #[test]
    fn rows_in_linear_light_are_joined_and_those_of_bytes_are_taken_as_light() {
        let shot = Shot { linear: true, ..Shot::new(centred(2, 3, 5.0), camera_is_world()) };
        let mut sliced = Sliced::new(&shot, ViewExposure::default());
        let row = |light: f32| LinearPicture { width: 2, height: 1, rgba: vec![[light; 4]; 2], depths: None };
        assert!(!sliced.add_linear(&row(2.5)));
        assert!(!sliced.add(&Picture { width: 2, height: 1, rgba: vec![255; 8] }));
        assert!(sliced.add_linear(&row(0.5)));
        let lights: Vec<f32> = sliced.linear_picture().rgba.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(lights, [2.5, 2.5, 1.0, 1.0, 0.5, 0.5]);
    }
}
