//! The files of the current stacks as texels of sheets.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

use crate::document::Stack;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_layer, read_mask};
use crate::io::photo::read_photo;
use crate::io::stack_store::StackStore;
use crate::projection::pyramid::runs_where;
use crate::projection::sources::BESIDE;
use crate::projection::{SheetId, SheetPixels, Texels};
use crate::scene::{Photo, PhotoPixels};

/// Photos that are kept decoded: sheets are asked for photo by photo, by a few threads at a time.
const RECENT: usize = 4;

/// Where the texels of each sheet are. Sheets are counted as in [`crate::projection::Sources::sheets`]:
/// photo by photo, image layers as in the stack.
#[derive(Debug, Default)]
pub struct SheetFiles {
    files: Vec<SheetFile>,
    photos: Vec<Photo>,
    /// By index of the photo, the latest last.
    recent: Mutex<Vec<(usize, Arc<Decoded>)>>,
}

/// A photo, once it is asked for; `None` where it cannot be read.
type Decoded = OnceLock<Option<PhotoPixels>>;

#[derive(Debug, Clone)]
struct SheetFile {
    texels: PathBuf,
    needed: PathBuf,
    rect: PixelRect,
    needed_rect: PixelRect,
    photo: usize,
}

impl SheetFiles {
    /// The image layers of these stacks, in their order; photos without a stack have `None`. Files are
    /// read when they are asked for: where a build replaces a stack in the meantime they are gone, and the
    /// stacks have to be read again.
    pub fn new(store: &StackStore, photos: &[Photo], stacks: &[Option<Stack>]) -> Self {
        let stacks = stacks.iter().enumerate().filter_map(|(photo, stack)| Some((photo, stack.as_ref()?)));
        let files = stacks.flat_map(|(photo, stack)| {
            let folder = store.folder(&stack.photo.name);
            stack.image_layers.iter().map(move |layer| SheetFile {
                texels: folder.join(&layer.file),
                needed: folder.join(&layer.needed_file),
                rect: layer.rect,
                needed_rect: layer.needed_rect,
                photo,
            })
        });
        Self { files: files.collect(), photos: photos.to_vec(), recent: Mutex::default() }
    }

    /// How many sheets there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// There is no sheet.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

impl Texels for SheetFiles {
    fn sheet(&self, sheet: SheetId) -> Result<SheetPixels> {
        let file = self.files.get(sheet.0 as usize);
        let file = file.ok_or_else(|| Error::Request(format!("there is no image layer {}", sheet.0)))?;
        // What the photo shows beside the layer's outlines is of use, too.
        let rect = file.needed_rect.grown(1).intersection(&file.rect);
        if file.needed_rect.is_empty() || rect.is_empty() {
            return Ok(SheetPixels {
                rect,
                rgba: vec![0; 4 * rect.area() as usize],
                needed: vec![0; rect.area() as usize],
            });
        }
        let mut rgba = read_layer(&file.texels, file.rect, rect)?;
        let mut needed = read_mask(&file.needed, file.rect, rect)?;
        // Its colour there is a help, not a need: without the photo it is guessed.
        if let Some(photo) = self.photo(file.photo).get_or_init(|| decoded(&self.photos[file.photo])) {
            show_beside(&mut rgba, &mut needed, rect, photo);
        }
        Ok(SheetPixels { rect, rgba, needed })
    }
}

impl SheetFiles {
    /// The place of a photo among the recent ones.
    fn photo(&self, index: usize) -> Arc<Decoded> {
        let mut recent = self.recent.lock().expect("no holder of this lock panics");
        let place = recent.iter().position(|(photo, _)| *photo == index);
        let entry = place.map_or_else(|| (index, Arc::default()), |place| recent.remove(place));
        recent.push(entry.clone());
        if recent.len() > RECENT {
            recent.remove(0);
        }
        entry.1
    }
}

fn decoded(photo: &Photo) -> Option<PhotoPixels> {
    read_photo(&photo.file, photo.camera.width, photo.camera.height).ok()
}

/// Gives empty pixels beside full ones the photo's colour, and says so; their alpha stays 0.
fn show_beside(rgba: &mut [u8], needed: &mut [u8], rect: PixelRect, photo: &PhotoPixels) {
    let content = runs_where(rect, rgba.as_chunks::<4>().0, |texel| texel[3] != 0);
    let ring = content.grown(1).minus(&content);
    let kept = rect.intersection(&photo.rect());
    for (y, run) in ring.iter().filter(|(y, _)| (kept.y..kept.bottom()).contains(y)) {
        for x in run.start.max(kept.x)..run.end.min(kept.right()) {
            if photo.is_valid(x as u32, y as u32) {
                let [r, g, b, _] = photo.rgba16(x as u32, y as u32).map(|v| (v / 257) as u8);
                let at = (y - rect.y) as usize * rect.w as usize + (x - rect.x) as usize;
                rgba[4 * at..4 * at + 3].copy_from_slice(&[r, g, b]);
                needed[at] |= BESIDE;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Samples;

    #[test]
    fn empty_pixels_beside_full_ones_get_the_photos_colour_and_stay_empty() {
        let samples = Samples::U8((0..5 * 3 * 3).map(|i| i as u8).collect());
        let photo = PhotoPixels { width: 5, height: 3, channels: 3, samples, icc: None };
        let rect = PixelRect { x: 1, y: -1, w: 4, h: 4 };
        let mut rgba = vec![0u8; 4 * 16];
        // Column 1, row 1 of the rectangle: photo pixel (2, 0).
        rgba[4 * 5..4 * 6].copy_from_slice(&[7, 7, 7, 255]);
        let mut needed = vec![0; 16];
        show_beside(&mut rgba, &mut needed, rect, &photo);
        let texel = |x: usize, y: usize| &rgba[4 * (4 * y + x)..4 * (4 * y + x) + 4];
        assert_eq!(texel(1, 1), [7, 7, 7, 255]);
        assert_eq!(texel(0, 1), [3, 4, 5, 0]);
        assert_eq!(texel(2, 2), [24, 25, 26, 0]);
        assert_eq!((needed[4], needed[10], needed[5], needed[7]), (BESIDE, BESIDE, 0, 0));
        assert_eq!(texel(3, 1), [0; 4], "two pixels away");
        assert_eq!(texel(1, 0), [0; 4], "outside the photo");
    }
}
