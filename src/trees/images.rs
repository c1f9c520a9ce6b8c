//! The images of a plant: read where they were made before, else made and kept.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::PlantParts;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::task::Task;
use quadratura_foliage::files::images::{
    images_hash, is_made_of, plant_hash, read_openness, read_plant_images, write_openness, write_plant_images,
};
use quadratura_foliage::{BakeOptions, Openness, Plant, PlantImages, bake};

/// Returns the images of a plant, and whether they were made now. With a folder, those that it holds of this plant and these options
/// are read; others are replaced by what is made. What cannot be read is noted and made again.
///
/// # Errors
/// [`Error::Io`] where they cannot be kept; [`Error::Cancelled`].
pub fn plant_images(
    plant: &Plant,
    folder: Option<&Path>,
    options: &BakeOptions,
    task: &Task,
) -> Result<(PlantImages, bool)> {
    let Some(folder) = folder else { return Ok((task.timed("bake", || bake(plant, options, task))?, true)) };
    if let Some(images) = read_or_noted(plant, folder, options, task)? {
        return Ok((images, false));
    }
    let images = task.timed("bake", || bake(plant, options, task))?;
    keep(plant, folder, &images, options, task)?;
    Ok((images, true))
}

/// Reads the images of a plant from a folder; `None` where it has none, and, with a note, where they cannot be read.
fn read_or_noted(
    plant: &Plant,
    folder: &Path,
    options: &BakeOptions,
    task: &Task,
) -> Result<Option<PlantImages>> {
    let inputs = images_hash(plant);
    match task.timed("read images", || read_plant_images(folder, plant.objects.len(), options, &inputs)) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(error) => {
            task.note(Message::from("the images of a plant are made again: ").and(error.message()));
            Ok(None)
        }
        found => found,
    }
}

fn keep(
    plant: &Plant,
    folder: &Path,
    images: &PlantImages,
    options: &BakeOptions,
    task: &Task,
) -> Result<u64> {
    task.timed("write images", || write_plant_images(folder, images, options, &images_hash(plant)))
}

/// The folder of a project in which the images of its species are, each in a folder of its own.
const PLANTS: &str = "cache/plants";
/// The number of letters of a plant's hash that name its folder.
const LETTERS: usize = 16;

/// Returns the folder of a project that is for the images of a plant.
fn folder_of(project: &Path, plant: &Plant) -> PathBuf {
    project.join(PLANTS).join(&plant_hash(plant)[..LETTERS])
}

/// Returns the images of a plant of a project, and whether they were made now; `None` where the cache has none and none are to be made,
/// and where no sub-object has so many polygons that images save something. What cannot be read or kept is noted.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn species_images(
    project: &Path,
    plant: &Plant,
    parts: PlantParts,
    task: &Task,
) -> Result<Option<(PlantImages, bool)>> {
    species_images_with(project, plant, parts, &BakeOptions::SLABS, task)
}

/// Returns the images of a plant of a project as [`species_images`] does; what is made is made with options that differ from the usual ones
/// in nothing but whether images are made from parts.
///
/// # Errors
/// As [`species_images`].
pub fn species_images_with(
    project: &Path,
    plant: &Plant,
    parts: PlantParts,
    options: &BakeOptions,
    task: &Task,
) -> Result<Option<(PlantImages, bool)>> {
    if parts < PlantParts::CachedImages {
        return Ok(None);
    }
    let folder = folder_of(project, plant);
    let found = read_or_noted(plant, &folder, options, task)?.map(|images| (images, false));
    let images = match found {
        None if parts == PlantParts::Images => {
            let images = task.timed("bake", || bake(plant, options, task))?;
            if let Err(error) = keep(plant, &folder, &images, options, task) {
                task.note(Message::from("the images of a plant cannot be kept: ").and(error.message()));
            }
            Some((images, true))
        }
        found => found,
    };
    Ok(images.filter(|(images, _)| images.objects.iter().any(Option::is_some)))
}

/// Returns whether a project's cache has the images of a plant.
pub fn has_images(project: &Path, plant: &Plant) -> bool {
    is_made_of(&folder_of(project, plant), plant.objects.len(), &BakeOptions::SLABS, &images_hash(plant))
}

/// Returns how open the crown of a plant of a project is: as the cache says, or found now and kept there. A cache that cannot be read
/// or written is noted.
///
/// # Errors
/// Those of [`Openness::bake`].
pub fn species_openness(project: &Path, plant: &Plant, task: &Task) -> Result<Openness> {
    let (file, inputs) = (folder_of(project, plant).with_extension("openness"), plant_hash(plant));
    match read_openness(&file, &inputs) {
        Ok(Some(openness)) => return Ok(openness),
        Ok(None) => {}
        Err(error) => task.note(error.message()),
    }
    let quiet = Task::silent().with_stop_flag(task.stop_flag());
    let openness = task.timed("openness", || Openness::bake(plant, &quiet))?;
    let folder = project.join(PLANTS);
    let kept = fs::create_dir_all(&folder)
        .map_err(Error::io(&folder, "create the folder"))
        .and_then(|()| write_openness(&file, &openness, &inputs));
    if let Err(error) = kept {
        task.note(Message::from("how open crowns are cannot be cached: ").and(error.message()));
    }
    Ok(openness)
}

/// Returns the size in bytes of the files of a plant's images in a project's cache; 0 where there are none.
pub fn size_on_disk(project: &Path, plant: &Plant) -> u64 {
    let files = fs::read_dir(folder_of(project, plant)).into_iter().flatten().flatten();
    files.filter_map(|file| file.metadata().ok()).map(|file| file.len()).sum()
}

/// Removes the images of a plant from a project's cache; returns whether there were any.
///
/// # Errors
/// [`Error::Io`].
pub fn remove_images(project: &Path, plant: &Plant) -> Result<bool> {
    remove(&folder_of(project, plant))
}

/// Removes the images of other plants from a project's cache: of species that are gone, or whose plants have changed. Nothing is removed
/// that has no name of a plant's images. Returns how many plants these were.
///
/// # Errors
/// [`Error::Io`].
pub fn remove_other_images<'a>(project: &Path, plants: impl Iterator<Item = &'a Plant>) -> Result<usize> {
    let kept: BTreeSet<PathBuf> = plants.map(|plant| folder_of(project, plant)).collect();
    let folder = project.join(PLANTS);
    if !folder.exists() {
        return Ok(0);
    }
    let listed = fs::read_dir(&folder).map_err(Error::io(&folder, "list the folder"))?;
    let others = listed.filter_map(|entry| Some(entry.ok()?.path()));
    let others = others.filter(|path| is_of_plant(path) && !kept.contains(&path.with_extension("")));
    others.map(|path| remove(&path).map(usize::from)).sum()
}

/// Returns whether a file or folder has the name of a plant's images, or of its openness.
fn is_of_plant(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let hash = name.strip_suffix(".openness").unwrap_or(name);
    hash.len() == LETTERS && hash.bytes().all(|letter| letter.is_ascii_hexdigit())
}

/// Removes a folder of images, or the file of openness beside one; returns whether it was such a folder.
fn remove(path: &Path) -> Result<bool> {
    if path.is_dir() {
        return fs::remove_dir_all(path).map(|()| true).map_err(Error::io(path, "remove the folder"));
    }
    if path.exists() {
        fs::remove_file(path).map_err(Error::io(path, "remove it"))?;
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_foliage::files::read_plant;

    #[test]
    fn images_of_a_project_are_made_once_found_again_and_removed_with_their_plant() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path();
        let bush = quadratura_foliage::synthetic::bushy();
        let other = read_plant(Path::new("oak"), Some(2), &Task::silent()).unwrap();
        let images =
            |parts| species_images(project, &bush, parts, &Task::silent()).unwrap().map(|(images, _)| images);
        assert!(images(PlantParts::CachedImages).is_none() && !has_images(project, &bush));
        let made = images(PlantParts::Images).unwrap();
        let openness = species_openness(project, &bush, &Task::silent()).unwrap();
        assert!(species_openness(project, &bush, &Task::silent()).unwrap() == openness);
        assert!(images(PlantParts::CachedImages) == Some(made) && has_images(project, &bush));
        assert!(images(PlantParts::Openness).is_none() && !has_images(project, &other));
        // A file that is gone is made again, and what others keep there stays.
        let folder = folder_of(project, &bush);
        let lost = fs::read_dir(&folder).unwrap().flatten().map(|file| file.path());
        fs::remove_file(lost.into_iter().find(|file| file.extension().is_some_and(|it| it == "mb")).unwrap())
            .unwrap();
        assert!(images(PlantParts::CachedImages).is_none() && images(PlantParts::Images).is_some());
        assert!(images(PlantParts::CachedImages).is_some());
        fs::create_dir(project.join(PLANTS).join("notes")).unwrap();
        assert_eq!(remove_other_images(project, [&bush].into_iter()).unwrap(), 0);
        assert_eq!(remove_other_images(project, [&other].into_iter()).unwrap(), 1);
        assert!(!has_images(project, &bush) && !remove_images(project, &bush).unwrap());
        let left: Vec<_> =
            fs::read_dir(project.join(PLANTS)).unwrap().flatten().map(|it| it.file_name()).collect();
        assert_eq!(left, ["notes"], "openness is removed, too");
    }
}
