//! What the commands on layered depth images read: files of one image or several, and folders of pictures of layers.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_ldi::file::{LdiFile, read_ldi, read_ldi_set};
use quadratura_ldi::layers::{is_ldi_layers, read_ldi_layers};
use quadratura_ldi::{Arrangement, Ldi, LdiSet};

/// Reads the images of a file, or the image of a folder of layers.
///
/// # Errors
/// Those of [`read_ldi_set`] and [`read_ldi_layers`], [`Error::Input`] for another folder.
pub fn read_images(path: &Path, task: &Task) -> Result<LdiSet> {
    if path.is_dir() {
        let images = vec![read_folder(path, task)?];
        return Ok(LdiSet { arrangement: Arrangement::Single, images });
    }
    read_ldi_set(path, task)
}

/// Reads the image of a file of one, or of a folder of layers.
///
/// # Errors
/// As [`read_images`], and [`Error::Input`] for a file of several.
pub fn read_image(path: &Path, task: &Task) -> Result<Ldi> {
    if path.is_dir() { read_folder(path, task) } else { read_ldi(path, task) }
}

/// Reads the image of a folder of layers.
fn read_folder(folder: &Path, task: &Task) -> Result<Ldi> {
    if is_ldi_layers(folder) {
        return read_ldi_layers(folder, task);
    }
    let remedy = "give a file, or a folder that `quadratura ldi export --format layers` wrote; files of a project's photos \
                  are in its folder cache/ldi";
    Err(Error::input(folder, "", "it is another folder", remedy))
}

/// Reads what is left of the images of a file; images of which nothing is left are noted.
///
/// # Errors
/// Those of [`LdiFile::open`], and those of all images where nothing is left of any.
pub fn read_partly(path: &Path, task: &Task) -> Result<LdiSet> {
    let file = LdiFile::open(path)?;
    let (mut images, mut errors) = (Vec::new(), Vec::new());
    for index in 0..file.count() {
        match file.read_whole_rows(index, task) {
            Ok((ldi, rows)) => {
                images.push(ldi);
                if !rows.are_all() {
                    let (whole, height) = (rows.whole, rows.height);
                    let image = if file.count() > 1 { format!("image {index}: ") } else { String::new() };
                    task.note(format!(
                        "{}: {image}{whole} of {height} rows are whole and are shown",
                        path.display()
                    ));
                }
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => errors.push(error),
        }
    }
    if images.is_empty()
        && let Some(error) = Error::of_all(std::mem::take(&mut errors))
    {
        return Err(error);
    }
    errors.iter().for_each(|error| task.note(error.message()));
    file.check_images(&images)?;
    Ok(LdiSet { arrangement: file.arrangement, images })
}
