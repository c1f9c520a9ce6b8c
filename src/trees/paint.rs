//! Paint of species: [`species_plant`] is the plant with all of its paint, [`listed_paint`] says what there is of it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use super::plant_of;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::task::Task;
use quadratura_document::tree_paint::{TreeCoat, TreePaintBook};
use quadratura_document::trees::TreeSpecies;
use quadratura_foliage::{PaintField, PaintedPlant, PaintedSlab, Plant, painted};
use quadratura_io::tree_paint::TreePaintStore;

/// Reads or grows the plant of the species of a name, with its paint. Paint that cannot be read is noted, and the plant is without
/// it.
///
/// # Errors
/// Those of [`plant_of`].
pub fn species_plant(folder: &Path, name: &str, species: &TreeSpecies, task: &Task) -> Result<Plant> {
    species_plants(folder, name, species, task).map(|plants| plants.plant)
}

/// The plant of a species.
pub struct SpeciesPlants {
    /// The plant with its paint.
    pub plant: Plant,
    /// The plant without it; `None` where nothing is painted.
    pub unpainted: Option<Plant>,
}

/// [`species_plant`] with the plant as it is without paint.
///
/// # Errors
/// Those of [`plant_of`].
pub fn species_plants(
    folder: &Path,
    name: &str,
    species: &TreeSpecies,
    task: &Task,
) -> Result<SpeciesPlants> {
    let plant = plant_of(folder, species, task)?;
    let store = TreePaintStore::new(folder);
    let book = match store.read() {
        Ok(book) => book,
        Err(error) => {
            let what = format!("the species {name:?} is shown without its paint: ");
            task.note(Message::from(what).and(error.message()));
            return Ok(SpeciesPlants { plant, unpainted: None });
        }
    };
    let fields = fields(&store, &book, name, &plant, task);
    if fields.is_empty() {
        return Ok(SpeciesPlants { plant, unpainted: None });
    }
    let PaintedPlant { plant: with_paint, unpainted } =
        task.timed("paint plant", || painted(&plant, plant.root, &fields));
    if unpainted > 0 {
        task.note(format!(
            "the paint of the species {name:?} reaches more polygons of instances than a plant may have of their own; {unpainted} \
             keep their colours; paint a part that is used often (`--part`) instead of the whole plant"
        ));
    }
    Ok(SpeciesPlants { plant: with_paint, unpainted: Some(plant) })
}

/// Returns what tells one state of the paint of a species from another, without reading its points.
pub fn paint_state(folder: &Path, name: &str) -> Vec<String> {
    let state = |coat: &TreeCoat| format!("{} {} {:?}", coat.file, coat.import, coat.part);
    match TreePaintStore::new(folder).read() {
        Ok(book) => book.coats.iter().filter(|coat| coat.species == name).map(state).collect(),
        Err(error) => vec![error.to_string()],
    }
}

/// The paint of a species, as it is listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct ListedPaint {
    /// The number of painted layers.
    pub layers: usize,
    /// The number of texels of the plant that are painted in them.
    pub texels: u64,
    /// Of these, the number of erased ones.
    pub erased: u64,
    /// The number of painted texels where the plant has nothing.
    pub beside: u64,
}

/// Returns the paint of each species that has some, also of those that the project does not have any more.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when the book cannot be read.
pub fn listed_paint(folder: &Path) -> Result<BTreeMap<String, ListedPaint>> {
    let mut listed: BTreeMap<String, ListedPaint> = BTreeMap::new();
    for coat in TreePaintStore::new(folder).read()?.coats {
        let of = listed.entry(coat.species).or_default();
        of.layers += 1;
        of.texels += coat.texels;
        of.erased += coat.erased;
        of.beside += coat.beside;
    }
    Ok(listed)
}

/// Returns the paint of a species by sub-object. What cannot be read, or has no place, is noted.
pub fn fields(
    store: &TreePaintStore,
    book: &TreePaintBook,
    name: &str,
    plant: &Plant,
    task: &Task,
) -> BTreeMap<usize, Arc<PaintField>> {
    let mut fields = BTreeMap::new();
    for (part, documents) in book.of_species(name) {
        let object = match part_of(plant, part) {
            Ok(object) => object,
            Err(found) => {
                task.note(format!("paint of the species {name:?} is kept and not shown: {found}"));
                continue;
            }
        };
        let documents = documents.iter().map(|coats| slabs(store, coats, name, task)).collect();
        let field = PaintField::new(documents);
        if !field.is_empty() {
            fields.insert(object, Arc::new(field));
        }
    }
    fields
}

/// Reads the coats of a document.
pub fn slabs(store: &TreePaintStore, coats: &[&TreeCoat], species: &str, task: &Task) -> Vec<PaintedSlab> {
    let read = |coat: &&TreeCoat| {
        let noted = |error: Error| {
            let what = format!("{} texels of paint of the species {species:?} are not shown: ", coat.texels);
            task.note(Message::from(what).and(error.message()));
        };
        store.coat(&coat.file).map_err(noted).ok()
    };
    coats.iter().filter_map(read).collect()
}

/// Returns the sub-object of a name; that of the whole plant for none.
///
/// # Errors
/// Why there is none.
pub fn part_of(plant: &Plant, part: Option<&str>) -> Result<usize, String> {
    let Some(name) = part else { return Ok(plant.root) };
    let named: Vec<usize> =
        (0..plant.objects.len()).filter(|index| plant.objects[*index].name == name).collect();
    match named[..] {
        [object] => Ok(object),
        [] => {
            let mut names: Vec<&str> = plant.objects.iter().map(|object| &object.name[..]).collect();
            names.sort_unstable();
            names.dedup();
            names.truncate(20);
            Err(format!("the plant has no part {name:?}; it has {}", names.join(", ")))
        }
        _ => Err(format!(
            "{} parts of the plant are called {name:?}; give them names of their own in its file",
            named.len()
        )),
    }
}
