//! Two pictures of a photo's stack: a contact sheet of its image layers, and the layers as sheets
//! that stand in front of their camera.
//!
//! ```text
//! cargo run --release --example contact_sheet -- PROJECT PHOTO sheet.jpg exploded.jpg
//! ```

mod canvas;
mod exploded;
mod lettering;
mod sheet;

use std::path::{Path, PathBuf};

use canvas::{Canvas, Ink, linear_from_srgb, scaled};
use quadratura::document::{ImageLayer, Stack};
use quadratura::geometry::PixelRect;
use quadratura::io::stack_store::StackStore;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// What is needed and hidden is hatched in this colour.
const NEEDED: Ink = Ink(0xf2_8c_38, 0.85);

/// An image layer with its pixels.
struct Layer {
    name: String,
    order: u32,
    /// Where in the photo the pixels lie.
    rect: PixelRect,
    pixels: Canvas,
    /// For each pixel: some surface needs it, and the photo does not show it.
    hidden: Vec<bool>,
}

impl Layer {
    /// The layer, cropped to what is needed.
    fn read(folder: &Path, layer: &ImageLayer) -> Fallible<Self> {
        let color = image::open(folder.join(&layer.file))?.to_rgba8();
        let needed = image::open(folder.join(&layer.needed_file))?.to_luma8();
        let rect = layer.needed_rect.intersection(&layer.rect);
        let (left, top) = ((rect.x - layer.rect.x) as u32, (rect.y - layer.rect.y) as u32);
        let mut pixels = Canvas::new(rect.w as usize, rect.h as usize);
        let mut hidden = vec![false; pixels.pixels.len()];
        for (i, pixel) in pixels.pixels.iter_mut().enumerate() {
            let (x, y) = (left + i as u32 % rect.w, top + i as u32 / rect.w);
            let [r, g, b, a] = color.get_pixel(x, y).0.map(|v| f32::from(v) / 255.0);
            *pixel = scaled([linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), 1.0], a);
            hidden[i] = needed.get_pixel(x, y).0[0] > 0 && a < 0.5;
        }
        Ok(Self { name: layer.name.clone(), order: layer.order, rect, pixels, hidden })
    }

    /// The pixels with stripes, `pitch` pixels apart, where they are needed and hidden. Stripes are
    /// laid in the photo's frame, so those of neighbouring layers meet.
    fn hatched(&self, pitch: usize) -> Canvas {
        let mut out = self.pixels.clone();
        let faint = Ink(NEEDED.0, 0.16).linear();
        for (i, pixel) in out.pixels.iter_mut().enumerate().filter(|(i, _)| self.hidden[*i]) {
            let x = i64::from(self.rect.x) + (i % out.width) as i64;
            let y = i64::from(self.rect.y) + (i / out.width) as i64;
            let in_stripe = (x + y).rem_euclid(pitch as i64) * 3 < pitch as i64;
            *pixel = canvas::over(if in_stripe { NEEDED.linear() } else { faint }, *pixel);
        }
        out
    }
}

fn main() -> Fallible<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [project, photo, sheet_file, exploded_file] = arguments.as_slice() else {
        return Err("usage: contact_sheet PROJECT PHOTO SHEET.jpg EXPLODED.jpg".into());
    };
    let store = StackStore::new(PathBuf::from(project));
    let stack = store.current(photo)?.ok_or("this photo has no stack; run: quadratura build PROJECT")?;
    let layers = read_layers(&store.folder(photo), &stack)?;
    sheet::draw(&layers).save(Path::new(sheet_file))?;
    let size = (stack.photo.width as usize, stack.photo.height as usize);
    exploded::draw(&layers, size).save(Path::new(exploded_file))?;
    Ok(())
}

fn read_layers(folder: &Path, stack: &Stack) -> Fallible<Vec<Layer>> {
    let seen = stack.image_layers.iter().filter(|layer| !layer.needed_rect.is_empty());
    seen.map(|layer| Layer::read(folder, layer)).collect()
}
