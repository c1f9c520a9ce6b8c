//! Change detection for the files of plants, such as pictures of leaves that are being painted, without reading them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::document::Trees;
use crate::document::trees::PlantSource;
use crate::io::plants::plant_stamp;
use crate::io::project::resolved;
use crate::io::stamp::Stamp;
use crate::recipe::site_stamp::own_folders;

/// The state of the files of a project's plants.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlantFiles(BTreeMap<String, Stamp>);

impl PlantFiles {
    /// Looks at the files of the species of the project in `folder`. Built-in species have none.
    pub fn new(folder: &Path, trees: &Trees) -> Self {
        let own = own_folders(folder);
        let stamp = |file: &String| plant_stamp(&resolved(folder, file), &own);
        let files = trees.species.values().filter_map(|species| match &species.from {
            PlantSource::File(file) => Some(file),
            PlantSource::Maple(_) | PlantSource::Oak(_) => None,
        });
        Self(files.map(|file| (file.clone(), stamp(file))).collect())
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
    use crate::document::trees::{Grown, TreeSpecies};

    #[test]
    fn a_plant_has_changed_when_its_file_or_a_picture_of_it_has_and_not_when_the_project_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        for name in ["plane.plant", "leaves/leaf.png", "project.json", "cache/plants/a.slabs", "paint/x.png"]
        {
            put(name, "x");
        }
        let species = |from| TreeSpecies { from, up: None, unit: None };
        let mut trees = Trees {
            species: [
                ("plane".to_owned(), species(PlantSource::File("plane.plant".into()))),
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
        for ours in ["project.json", "cache/plants/a.slabs", "paint/x.png", "notes.txt"] {
            put(ours, "changed");
        }
        assert!(changed(&trees).is_empty());
        put("leaves/leaf.png", "redder");
        assert_eq!(changed(&trees), ["plane.plant"]);
        // A plant that was not looked at before is no change.
        trees.species.insert("elm".into(), species(PlantSource::File("elm.glb".into())));
        put("elm.glb", "x");
        assert_eq!(changed(&trees), ["plane.plant"]);
        trees.species.remove("plane");
        assert!(changed(&trees).is_empty());
    }
}
