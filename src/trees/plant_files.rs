//! Change detection for the files of plants, such as pictures of leaves that are being painted, without reading them.

use std::collections::BTreeMap;
use std::path::Path;

use quadratura_document::Trees;
use quadratura_document::trees::PlantSource;
use quadratura_files::stamp::Stamp;
use quadratura_foliage::files::plant_stamp;
use quadratura_io::project::resolved;

/// The state of the files of a project's plants.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlantFiles(BTreeMap<String, Stamp>);

impl PlantFiles {
    /// Looks at the files of the species of the project in `folder`. Built-in species have none. Where the project is in the folder of
    /// a plant, or below it, folders below that are left out: others write there, too.
    pub fn new(folder: &Path, trees: &Trees) -> Self {
        let project = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        let stamp = |file: &String| {
            let file = resolved(folder, file);
            let around = file.parent().and_then(|parent| parent.canonicalize().ok());
            plant_stamp(&file, around.is_some_and(|around| project.starts_with(around)))
        };
        let files = trees.species.values().filter_map(|species| match &species.from {
            PlantSource::File(file) => Some(file),
            PlantSource::Maple(_) | PlantSource::Oak(_) => None,
        });
        Self(files.map(|file| (file.clone(), stamp(file))).collect())
    }

    /// Adds what is known now; what is not there now stays known.
    pub fn update(&mut self, now: Self) {
        self.0.extend(now.0);
    }

    /// Returns the plants, by the file in `project.json`, that were there before and whose files are others now.
    pub fn changed<'a>(&self, now: &'a Self) -> Vec<&'a str> {
        let is_other =
            |(file, stamp): &(&String, &Stamp)| self.0.get(*file).is_some_and(|before| before != *stamp);
        now.0.iter().filter(is_other).map(|(file, _)| file.as_str()).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use quadratura_document::trees::{Grown, TreeSpecies};

    #[test]
    fn a_plant_has_changed_when_its_file_or_a_picture_of_it_has_and_not_when_the_project_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        for name in
            ["plants/plane.plant", "plants/leaves/leaf.png", "project.json", "oak.plant", "layers/a.png"]
        {
            put(name, "x");
        }
        let species = |from| TreeSpecies { from, up: None, unit: None };
        let mut trees = Trees {
            species: [
                ("plane".to_owned(), species(PlantSource::File("plants/plane.plant".into()))),
                ("oak".to_owned(), species(PlantSource::File("oak.plant".into()))),
                ("maple".to_owned(), species(PlantSource::Maple(Grown::default()))),
            ]
            .into(),
            ..Trees::default()
        };
        let before = PlantFiles::new(folder.path(), &trees);
        let changed = |trees: &Trees| {
            let now = PlantFiles::new(folder.path(), trees);
            before.changed(&now).into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        for other in ["project.json", "layers/a.png", "plants/notes.txt"] {
            put(other, "changed");
        }
        assert!(changed(&trees).is_empty());
        put("plants/leaves/leaf.png", "redder");
        assert_eq!(changed(&trees), ["plants/plane.plant"]);
        put("oak.plant", "another");
        assert_eq!(changed(&trees), ["oak.plant", "plants/plane.plant"]);
        // A plant that was not looked at before is no change.
        trees.species.insert("elm".into(), species(PlantSource::File("plants/elm.glb".into())));
        put("plants/elm.glb", "x");
        trees.species.remove("oak");
        assert_eq!(changed(&trees), ["plants/plane.plant"]);
        // A species that is taken away and comes back is known as it was.
        let mut known = before.clone();
        known.update(PlantFiles::new(folder.path(), &Trees::default()));
        assert_eq!(known, before);
    }
}
