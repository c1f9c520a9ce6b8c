//! Pictures of a file about which an import asks: all of its image layers as they were exported, and as they are in it.

use std::path::Path;

use super::compare::PlacedRaster;
use super::file::identified;
use super::gather::gathered;
use super::identify::sorted;
use super::originals::ExportedPixels;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_io::baselines::Baselines;
use quadratura_io::exports::ExportStore;
use quadratura_io::paint_store::PaintStore;
use quadratura_layered_files::{Depth, Raster};
use quadratura_view::Picture;

/// Returns pictures of at most `longest` pixels in width and height of a layered file's image layers, as they were
/// exported and as they are in the file. Layers that cannot be read are missing in them.
///
/// # Errors
/// Returns the errors of reading the file and the exported pixels, or [`quadratura_base::Error::Cancelled`].
pub fn before_and_after(project: &Path, file: &Path, longest: u32, task: &Task) -> Result<[Picture; 2]> {
    let exports = project.join("exports");
    let (records, _) = ExportStore::new(&exports).read_all()?;
    let (document, record) = identified(file, &records, task)?;
    let (kept, book) = (Baselines::new(&exports), PaintStore::new(project).read()?);
    let originals = ExportedPixels { kept: &kept, project, book: &book };
    let mut before = SmallCanvas::new((record.photo.width, record.photo.height), longest);
    let mut after = SmallCanvas::new((document.width, document.height), longest);
    // The record has the nearest layer first.
    for (index, layers) in sorted(&document, record).image_layers.iter().rev() {
        task.check_cancelled()?;
        let exported = &record.layers[index.0];
        if let Some(pixels) = originals.pixels(record, exported)? {
            before.lay_over(PlacedRaster { rect: exported.baseline.rect, pixels: &pixels });
        }
        if let Ok(found) = gathered(layers) {
            after.lay_over(PlacedRaster { rect: found.rect, pixels: &found.pixels });
        }
    }
    Ok([before.picture(), after.picture()])
}

/// A canvas at a smaller scale, of the nearest pixels.
struct SmallCanvas {
    pixels: Raster,
    /// The number of pixels of the canvas per pixel here.
    step: f64,
}

impl SmallCanvas {
    fn new((width, height): (u32, u32), longest: u32) -> Self {
        let step = (f64::from(width.max(height)) / f64::from(longest)).max(1.0);
        let side = |side: u32| ((f64::from(side) / step).round() as u32).max(1);
        Self { pixels: Raster::blank(side(width), side(height), Depth::Eight), step }
    }

    fn lay_over(&mut self, layer: PlacedRaster) {
        for (x, y) in PixelRect::of_size(self.pixels.width(), self.pixels.height()).pixels() {
            let on_canvas = |place: i32| ((f64::from(place) + 0.5) * self.step) as i32;
            let colour = layer.at(on_canvas(x), on_canvas(y));
            if colour[3] > u16::MAX / 2 {
                self.pixels.set_rgba16(x as u32, y as u32, colour);
            }
        }
    }

    fn picture(self) -> Picture {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        Picture { width, height, rgba: self.pixels.samples().big_endian().into_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_canvas_shows_the_nearest_layer_at_its_place() {
        let mut canvas = SmallCanvas::new((40, 20), 10);
        let mut layer = Raster::blank(20, 20, Depth::Eight);
        PixelRect::of_size(20, 20)
            .pixels()
            .for_each(|(x, y)| layer.set_rgba16(x as u32, y as u32, [65535; 4]));
        canvas.lay_over(PlacedRaster { rect: PixelRect { x: 20, y: 0, w: 20, h: 20 }, pixels: &layer });
        let picture = canvas.picture();
        assert_eq!((picture.width, picture.height), (10, 5));
        let alphas: Vec<u8> = picture.rgba[..40].iter().skip(3).step_by(4).copied().collect();
        assert_eq!(alphas, [0, 0, 0, 0, 0, 255, 255, 255, 255, 255]);
    }
}
