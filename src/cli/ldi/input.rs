//! What the commands on layered depth images read: files of one image or several.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_ldi::file::{LdiFile, read_ldi, read_ldi_set};
use quadratura_ldi::{Ldi, LdiSet};

/// Reads the images of a file.
///
/// # Errors
/// Those of [`read_ldi_set`], and [`Error::Input`] for a folder.
pub fn read_images(path: &Path, task: &Task) -> Result<LdiSet> {
    check_file(path)?;
    read_ldi_set(path, task)
}

/// Reads the image of a file of one.
///
/// # Errors
/// Those of [`read_ldi`], and [`Error::Input`] for a folder.
pub fn read_image(path: &Path, task: &Task) -> Result<Ldi> {
    check_file(path)?;
    read_ldi(path, task)
}

fn check_file(path: &Path) -> Result<()> {
    if path.is_dir() {
        let remedy = "give a file; those of a project's photos are in its folder cache/ldi";
        return Err(Error::input(path, "", "it is a folder", remedy));
    }
    Ok(())
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
