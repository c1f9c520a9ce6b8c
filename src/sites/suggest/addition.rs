//! Suggested objects become part of the model's file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::obj::{NamedRings, appended, obj_of_model};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::model_change::ModelChange;
use quadratura_files::atomic::write_atomically;
use quadratura_files::free_path::free_path;
use quadratura_files::hash::hash_bytes;
use quadratura_import::models::read_model;
use quadratura_io::project::{relative_to, resolved};

/// An object to be added to the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Addition {
    /// The name; a number is appended where the model has it already.
    pub name: String,
    /// The outlines of its faces, in the cameras' world.
    pub rings: Vec<Vec<DVec3>>,
}

/// Where additions were written.
#[derive(Debug, Clone, PartialEq)]
pub enum Added {
    /// Into the model's file.
    Written(ModelChange),
    /// Into a copy of the model as OBJ, because files of its format are not written. The project has to name it.
    Copied {
        /// The copy.
        file: PathBuf,
        /// Its path, as the project stores it.
        model: String,
    },
    /// Into a file of their own, because another program has changed the model's file since it was read.
    Beside(PathBuf),
}

/// Returns the hash of the content of a project's model file.
///
/// # Errors
/// [`Error::Io`].
pub fn model_hash(folder: &Path, project: &Project) -> Result<String> {
    Ok(hash_bytes(&content(&resolved(folder, &project.model))?))
}

fn content(file: &Path) -> Result<Vec<u8>> {
    std::fs::read(file).map_err(Error::io(file, "read it"))
}

/// Adds objects to the model of the project in `folder`. `known` is the hash of the model's file as the additions were made for it: a file
/// that has changed since is left as it is.
///
/// # Errors
/// [`Error::Io`]; the errors of reading a model that has to be copied; [`Error::Cancelled`].
pub fn add_to_model(
    folder: &Path,
    project: &Project,
    known: &str,
    additions: &[Addition],
    task: &Task,
) -> Result<Added> {
    let file = resolved(folder, &project.model);
    let before = content(&file)?;
    let (model, _) = read_model(&file, task)?;
    let present: BTreeSet<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
    let added = in_file(additions, &present, &project.world_from_model.inverse());
    if hash_bytes(&before) != known {
        let beside = free_path(&folder.join("suggested.obj"), |_| false).path;
        write_atomically(&beside, &appended(&[], &added))?;
        return Ok(Added::Beside(beside));
    }
    if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
        let after = Arc::new(appended(&before, &added));
        let change = ModelChange { file, before: Arc::new(before), after };
        write_atomically(&change.file, &change.after)?;
        return Ok(Added::Written(change));
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let copy = free_path(&folder.join(format!("{stem}-completed.obj")), |_| false).path;
    write_atomically(&copy, &appended(obj_of_model(&model).as_bytes(), &added))?;
    let model = relative_to(folder, &copy)?;
    Ok(Added::Copied { file: copy, model })
}

/// Writes a change of the model's file; false where the file holds something else than what the change begins with, and stays.
///
/// # Errors
/// [`Error::Io`].
pub fn write_model_change(change: &ModelChange) -> Result<bool> {
    if content(&change.file)? != *change.before {
        return Ok(false);
    }
    write_atomically(&change.file, &change.after)?;
    Ok(true)
}

/// Returns the additions in the file's coordinates, with names that the model does not have.
fn in_file(additions: &[Addition], present: &BTreeSet<&str>, to_file: &Similarity) -> Vec<NamedRings> {
    let mut taken: BTreeSet<String> = present.iter().map(|name| (*name).to_owned()).collect();
    let named = |addition: &Addition| {
        let name = free_name(&addition.name, &taken);
        taken.insert(name.clone());
        let ring = |ring: &Vec<DVec3>| ring.iter().map(|corner| to_file.apply(*corner)).collect();
        NamedRings { name, rings: addition.rings.iter().map(ring).collect() }
    };
    additions.iter().map(named).collect()
}

/// Returns a name that can stand in one line and is not taken: `wall_3` becomes the first free one of `wall_1`, `wall_2` and so on.
pub fn free_name(name: &str, taken: &BTreeSet<String>) -> String {
    let line: String = name.chars().map(|it| if it.is_control() { ' ' } else { it }).collect();
    let name = if line.trim().is_empty() { "object_1" } else { line.trim() };
    if !taken.contains(name) {
        return name.to_owned();
    }
    let (base, ending) = name.strip_suffix(".billboard").map_or((name, ""), |base| (base, ".billboard"));
    let base = base.trim_end_matches(|it: char| it.is_ascii_digit()).trim_end_matches('_');
    let numbered = |number: usize| format!("{base}_{number}{ending}");
    (1..).map(numbered).find(|name| !taken.contains(name)).expect("numbers do not end")
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str =
        "# drawn\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\no wall_1\nusemtl ivy billboard\nf 1 2 3 4\n# end";

    struct Site {
        folder: tempfile::TempDir,
        project: Project,
    }

    impl Site {
        fn new(name: &str, content: &[u8]) -> Self {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join(name), content).unwrap();
            let world_from_model = Similarity { scale: 2.0, ..Similarity::IDENTITY };
            Self { folder, project: Project { model: name.into(), world_from_model, ..Project::default() } }
        }

        fn add(&self, known: &str) -> Added {
            let ring = vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::new(2.0, 4.0, 0.0), DVec3::Y * 4.0];
            let addition = Addition { name: "wall_1".into(), rings: vec![ring] };
            add_to_model(self.folder.path(), &self.project, known, &[addition], &Task::silent()).unwrap()
        }

        fn hash(&self) -> String {
            model_hash(self.folder.path(), &self.project).unwrap()
        }
    }

    #[test]
    fn an_obj_gets_the_objects_at_its_end_and_back_again() {
        let site = Site::new("m.obj", MODEL.as_bytes());
        let Added::Written(change) = site.add(&site.hash()) else { panic!("it is an OBJ") };
        let text = std::fs::read_to_string(&change.file).unwrap();
        assert!(text.starts_with(MODEL), "what was drawn stays as it is: {text}");
        let (model, _) = read_model(&change.file, &Task::silent()).unwrap();
        let names: Vec<&str> = model.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!((names, model.faces.len()), (vec!["wall_1", "wall_2"], 2));
        assert!(model.objects[0].billboard && !model.objects[1].billboard, "the material ends");
        let last = model.ring_points(model.objects[1].faces[0]).nth(2).unwrap();
        assert_eq!(last, DVec3::new(1.0, 2.0, 0.0), "in the file's coordinates");
        assert!(write_model_change(&change.reversed()).unwrap());
        assert_eq!(std::fs::read_to_string(&change.file).unwrap(), MODEL);
        assert!(write_model_change(&change).unwrap());
        std::fs::write(&change.file, "edited").unwrap();
        assert!(!write_model_change(&change.reversed()).unwrap(), "another program has changed it");
        assert_eq!(std::fs::read_to_string(&change.file).unwrap(), "edited");
    }

    #[test]
    fn a_file_that_has_changed_is_left_alone_and_nothing_is_lost() {
        let site = Site::new("m.obj", MODEL.as_bytes());
        let known = site.hash();
        let other = MODEL.replace("wall_1", "gate");
        std::fs::write(site.folder.path().join("m.obj"), &other).unwrap();
        let beside = |added| match added {
            Added::Beside(file) => file.file_name().unwrap().to_string_lossy().into_owned(),
            other => panic!("{other:?}"),
        };
        assert_eq!(beside(site.add(&known)), "suggested.obj");
        assert_eq!(beside(site.add(&known)), "suggested-2.obj", "the first one is not overwritten");
        assert_eq!(std::fs::read_to_string(site.folder.path().join("m.obj")).unwrap(), other);
        let (model, _) = read_model(&site.folder.path().join("suggested.obj"), &Task::silent()).unwrap();
        assert_eq!((model.objects[0].name.as_str(), model.faces.len()), ("wall_1", 1));
    }

    #[test]
    fn names_are_free_and_stand_in_one_line() {
        let taken = ["wall_1", "wall_2", "tree_1.billboard"].map(str::to_owned).into_iter().collect();
        let name = |name: &str| free_name(name, &taken);
        assert_eq!(
            [name("wall_1"), name("roof"), name("a\nb"), name(" ")],
            ["wall_3", "roof", "a b", "object_1"]
        );
        assert_eq!(name("tree_1.billboard"), "tree_2.billboard");
    }
}
