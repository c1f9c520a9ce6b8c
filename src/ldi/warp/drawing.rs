//! The drawing of one band of a picture with each kind of splats.

use super::{BAND, Exposed, SplatKind, light_of_bytes};
use crate::splat::Canvas;
use crate::splat::over::OverCanvas;
use crate::splat::pixel::PixelCanvas;
use crate::splat::sums::{COLOUR, SumsCanvas};
use quadratura_base::scene::light::bytes_of_light_times;
use quadratura_base::task::Task;

/// What the bands of a picture share.
pub struct BandDrawing<'a> {
    images: &'a [Exposed<'a>],
    splat: SplatKind,
    width: u32,
    /// The linear light of stored values, by image: sums have the exposure of each.
    lights: Vec<[[f32; 256]; 3]>,
    /// Stored values at the picture's exposure by stored values, R, G, B; `None` where they stay.
    bytes: Option<[[u8; 256]; 3]>,
}

impl<'a> BandDrawing<'a> {
    /// Prepares the drawing of images one after the other on a picture that is so wide.
    pub fn new(images: &'a [Exposed], splat: SplatKind, width: u32) -> Self {
        let lights = images.iter().map(|image| *light_of_bytes(image.exposure)).collect();
        let exposure = images.first().map_or([0.0; 3], |image| image.exposure);
        let bytes = exposure.map(|gain| bytes_of_light_times(gain.exp()));
        Self { images, splat, width, lights, bytes: Some(bytes).filter(|_| exposure != [0.0; 3]) }
    }

    /// Draws a band of the picture, whose pixels are transparent black. `spare` keeps memory from band to band. Returns how many
    /// depth pixels are too near.
    pub fn draw<'b>(
        &'b self,
        band: u32,
        out: &mut [[u8; 4]],
        spare: &mut Option<SumsCanvas<'b, COLOUR>>,
        task: &Task,
    ) -> u64 {
        let rows = out.len() as u32 / self.width;
        match self.splat {
            SplatKind::Pixel => {
                task.timed("draw", || self.all_on(band, PixelCanvas::new(self.width, &mut *out)));
                self.expose(out);
                0
            }
            SplatKind::Over => {
                let canvas = task.timed("draw", || self.all_on(band, OverCanvas::new(self.width, rows)));
                task.timed("resolve", || canvas.write_colours(out));
                self.expose(out);
                canvas.too_near
            }
            SplatKind::Sums => {
                let mut canvas = task.timed("draw", || self.summed(band, rows, spare.take()));
                task.timed("resolve", || canvas.write_colours(out));
                spare.insert(canvas).too_near
            }
        }
    }

    /// Draws all images on a band's canvas.
    fn all_on<C: Canvas>(&self, band: u32, canvas: C) -> C {
        self.images.iter().fold(canvas, |canvas, image| image.plan.draw(band, canvas))
    }

    /// Sums up all images. Memory that was written to before is at hand, new memory is not.
    fn summed<'b>(
        &'b self,
        band: u32,
        rows: u32,
        spare: Option<SumsCanvas<'b, COLOUR>>,
    ) -> SumsCanvas<'b, COLOUR> {
        let empty = match spare {
            Some(canvas) => canvas.again(rows),
            // All bands but the last one are equally high.
            None => SumsCanvas::new(self.width, BAND, &self.lights[0]).again(rows),
        };
        let images = self.images.iter().zip(&self.lights);
        images.fold(empty, |canvas, (image, light)| image.plan.draw(band, canvas.lit(light)))
    }

    /// Brings stored values to the picture's exposure.
    fn expose(&self, out: &mut [[u8; 4]]) {
        let Some(bytes) = &self.bytes else { return };
        for [r, g, b, _] in out {
            *r = bytes[0][usize::from(*r)];
            *g = bytes[1][usize::from(*g)];
            *b = bytes[2][usize::from(*b)];
        }
    }
}
