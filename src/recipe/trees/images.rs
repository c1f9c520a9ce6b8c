//! The images of a plant: read where they were made before, else made and kept.

use std::path::Path;

use crate::error::{Error, Result};
use crate::foliage::{BakeOptions, Plant, PlantImages, bake};
use crate::io::plant_images::{plant_hash, read_plant_images, write_plant_images};
use crate::task::Task;

/// Returns the images of a plant. With a folder, those that it holds of this plant and these options are read; others are replaced
/// by what is made. Damaged ones are noted and made again.
///
/// # Errors
/// [`Error::Io`] where they cannot be kept; [`Error::Cancelled`].
pub fn plant_images(
    plant: &Plant,
    folder: Option<&Path>,
    options: &BakeOptions,
    task: &Task,
) -> Result<PlantImages> {
    let Some(folder) = folder else { return task.timed("bake", || bake(plant, options, task)) };
    let inputs = plant_hash(plant);
    let sub_objects = plant.objects.len();
    match task.timed("read images", || read_plant_images(folder, sub_objects, options, &inputs)) {
        Ok(Some(images)) => return Ok(images),
        Ok(None) => {}
        Err(error @ Error::Input { .. }) => task.note(error.message()),
        Err(error) => return Err(error),
    }
    let images = task.timed("bake", || bake(plant, options, task))?;
    task.timed("write images", || write_plant_images(folder, &images, options, &inputs))?;
    Ok(images)
}
