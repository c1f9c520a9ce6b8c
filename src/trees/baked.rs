//! Makes the images of the species of a project.

use std::path::Path;

use serde::Serialize;

use super::PlantParts;
use super::images::{remove_images, remove_other_images, size_on_disk, species_images_with};
use super::paint::species_plant;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::task::Task;
use quadratura_document::Trees;
use quadratura_foliage::{BakeOptions, Plant, PlantImages};
use quadratura_sites::unknown_name::no_such;

/// The images of a species.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct BakedSpecies {
    /// The name.
    pub species: String,
    /// The number of sub-objects that have images.
    pub sub_objects: usize,
    /// The number of samples of all images.
    pub samples: u64,
    /// The size of their files in bytes.
    pub bytes: u64,
    /// Whether they were made now.
    pub is_new: bool,
    /// Whether any of them was made from images of parts, see [`BakeOptions::from_parts`].
    pub from_parts: bool,
}

/// How [`baked`] makes images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BakeRequest {
    /// Whether those that are up to date are made anew, too.
    pub force: bool,
    /// Whether images are made from those of parts, see [`BakeOptions::from_parts`].
    pub from_parts: bool,
}

/// Makes the images of the species of some names, of all where none are given, and keeps them in the project's cache. Those that are
/// there, however they were made, are left alone unless the request says otherwise; images of plants that no species has any more are removed. Returns also why
/// plants have none.
///
/// # Errors
/// [`Error::Missing`] for a name that no species has; [`Error::Io`]; [`Error::Cancelled`].
pub fn baked(
    folder: &Path,
    trees: &Trees,
    names: &[String],
    request: BakeRequest,
    task: &Task,
) -> Result<(Vec<BakedSpecies>, Vec<Message>)> {
    if let Some(unknown) = names.iter().find(|name| !trees.species.contains_key(*name)) {
        return Err(no_such("species", unknown, trees.species.keys().map(String::as_str), None));
    }
    let (mut made, mut problems, mut plants) = (Vec::new(), Vec::new(), Vec::new());
    for (name, species) in &trees.species {
        match species_plant(folder, name, species, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => problems
                .push(Message::from(format!("the species {name:?} has no images: ")).and(error.message())),
            Ok(plant) => plants.push((name, plant)),
        }
    }
    for (name, plant) in plants.iter().filter(|(name, _)| names.is_empty() || names.contains(name)) {
        made.push(one(folder, name, plant, request, task)?);
    }
    if problems.is_empty() {
        remove_other_images(folder, plants.iter().map(|(_, plant)| plant))?;
    }
    Ok((made, problems))
}

fn one(folder: &Path, name: &str, plant: &Plant, request: BakeRequest, task: &Task) -> Result<BakedSpecies> {
    if request.force {
        remove_images(folder, plant)?;
    }
    let options = BakeOptions { from_parts: request.from_parts, ..BakeOptions::SLABS };
    let images = species_images_with(folder, plant, PlantParts::Images, &options, task)?;
    let (PlantImages { objects, from_parts, .. }, is_new) = images.unwrap_or_default();
    let views = objects.iter().flatten().flat_map(|of| &of.copies).flat_map(|copy| &copy.views);
    Ok(BakedSpecies {
        species: name.to_owned(),
        sub_objects: objects.iter().flatten().count(),
        samples: views.map(|view| view.samples.len() as u64).sum(),
        bytes: size_on_disk(folder, plant),
        is_new,
        from_parts,
    })
}
