//! Reads species, from files and by name, and grows them.

use std::path::Path;

use super::remedies::{CORRECT, NUMBER};
use crate::{Plant, Species, grow};
use quadratura_base::error::{Error, Result};
use quadratura_files::json::{parse_json, read_json};

/// The largest file of a species in bytes.
const LARGEST: u64 = 1 << 20;

/// The species that are known by name.
const BUILT_IN: [(&str, &str); 2] = [
    ("maple", include_str!("../../../examples/maple.json")),
    ("oak", include_str!("../../../examples/oak.json")),
];

/// Returns the species of a name, if there is one.
pub fn built_in(name: &Path) -> Option<Result<Species>> {
    let (_, text) = BUILT_IN.iter().find(|(known, _)| name.as_os_str() == *known)?;
    Some(parse_json(name, text.as_bytes(), CORRECT))
}

/// Grows a built-in species, with another seed if one is given.
///
/// # Errors
/// [`Error::Missing`] for another name.
pub fn built_in_plant(name: &str, seed: Option<u64>) -> Result<Plant> {
    let path = Path::new(name);
    let species = built_in(path).unwrap_or_else(|| {
        let names = BUILT_IN.map(|(name, _)| name).join(", ");
        Err(Error::missing(format!("there is no species {name:?}; there are {names}")))
    })?;
    grown(path, species, seed)
}

/// Reads a species.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with line and column.
pub fn read_species(file: &Path) -> Result<Species> {
    read_json(file, LARGEST, CORRECT)
}

/// Grows a species, with another seed if one is given.
///
/// # Errors
/// [`Error::Input`] with the JSON path of a number out of its range, and for a plant beyond a limit.
pub fn grown(file: &Path, mut species: Species, seed: Option<u64>) -> Result<Plant> {
    species.check().map_err(|(place, found)| Error::input(file, place, found, NUMBER))?;
    species.seed = seed.unwrap_or(species.seed);
    grow(&species)
        .map_err(|flaw| Error::input(file, "", flaw.to_string(), "give fewer children, or coarser limbs"))
}
