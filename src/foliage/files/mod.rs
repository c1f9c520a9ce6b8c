//! Reads plants: files of the keyword format (`.plant`) and of glTF (`.gltf`, `.glb`), and files (`.json`) and names of
//! species that are grown. [`images`] are the pictures that are made of them, [`list`] where trees stand.

mod gltf;
pub mod images;
mod keyword;
mod leaf_names;
pub mod list;
mod maps;
mod notes;
mod pictures;
mod remedies;
mod species;
mod stamp;
mod statements;
mod tokens;

#[cfg(test)]
mod mutated;
#[cfg(test)]
mod tests;

use std::path::Path;

use self::gltf::read_gltf;
use self::keyword::read_keyword;
pub use self::species::built_in_plant;
use self::species::{built_in, grown, read_species};
pub use self::stamp::plant_stamp;
use crate::Plant;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::guarded::guarded;

/// Reads or grows a plant: a `.plant`, `.gltf` or `.glb` file, a species (`.json`), or `maple` or `oak` where no file has
/// that name. A seed replaces that of the species. What is left out is noted.
///
/// # Errors
/// [`Error::Input`] with file and line, JSON path or names for what is no plant; [`Error::Io`]; [`Error::Request`] for a
/// seed of a plant that is not grown.
pub fn read_plant(path: &Path, seed: Option<u64>, task: &Task) -> Result<Plant> {
    guarded(path, remedies::CORRECT, || decoded(path, seed, task))
}

fn decoded(path: &Path, seed: Option<u64>, task: &Task) -> Result<Plant> {
    if let Some(species) = built_in(path).filter(|_| !path.exists()) {
        return grown(path, species?, seed);
    }
    match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
        Some("json") => grown(path, read_species(path)?, seed),
        None | Some("plant" | "gltf" | "glb") if seed.is_some() => Err(Error::Request(
            "--seed has no effect on a plant of a file, which is not grown; leave it out".into(),
        )),
        None | Some("plant") => read_keyword(path, task),
        Some("gltf" | "glb") => read_gltf(path, task),
        Some(other) => {
            let found = format!(
                "a file called .{other}, expected a plant: .plant, .gltf or .glb, or a species: .json"
            );
            Err(Error::input(path, "", found, "give such a file, or one of the names maple and oak"))
        }
    }
}
