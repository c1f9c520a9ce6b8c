//! Two pictures of a photo's stack: a contact sheet of its image layers, and the layers as sheets
//! that stand in front of their camera.
//!
//! ```text
//! cargo run --release --example contact_sheet -- PROJECT PHOTO sheet.jpg exploded.jpg
//! ```

mod lettering;
mod sheet;

use std::path::{Path, PathBuf};

use quadratura::stack::StackStore;
use quadratura::task::Task;
use quadratura::testing::editing::exploded::premultiplied::PremultipliedPicture;
use quadratura::testing::editing::exploded::{draw, read_layers};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Of the exploded view.
const SIZE: (usize, usize) = (1800, 920);

fn main() -> Fallible<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [project, photo, sheet_file, exploded_file] = arguments.as_slice() else {
        return Err("usage: contact_sheet PROJECT PHOTO SHEET.jpg EXPLODED.jpg".into());
    };
    let store = StackStore::new(PathBuf::from(project));
    let stack = store.current(photo)?.ok_or("this photo has no stack; run: quadratura build PROJECT")?;
    let layers = read_layers(&store.folder(photo), &stack, &Task::silent())?;
    save(&sheet::draw(&layers), Path::new(sheet_file))?;
    let size = (stack.photo.width as usize, stack.photo.height as usize);
    save(&draw(&layers, size, SIZE), Path::new(exploded_file))
}

/// Writes JPEG or PNG, by the name's ending.
fn save(canvas: &PremultipliedPicture, path: &Path) -> Fallible<()> {
    let picture = image::RgbImage::from_raw(canvas.width as u32, canvas.height as u32, canvas.rgb())
        .expect("three bytes for each pixel");
    if path.extension().is_some_and(|e| e == "jpg" || e == "jpeg") {
        let file = std::io::BufWriter::new(std::fs::File::create(path)?);
        picture.write_with_encoder(image::codecs::jpeg::JpegEncoder::new_with_quality(file, 88))?;
    } else {
        picture.save(path)?;
    }
    Ok(())
}
