//! The sample project: a small invented square, contained in the program, to try everything with.

use std::fs;
use std::path::{Path, PathBuf};

use crate::create::{NewProject, create_project};
use crate::discover::first_folder;
use crate::open::Opened;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::atomic::{create_folder_with, write_atomically};
use quadratura_io::project::PROJECT_FILE;
use quadratura_io::project::check_is_empty;

/// The folder of the project, in that of the sample.
const PROJECT: &str = "project";
/// The name of a folder for the sample.
const NAME: &str = "quadratura-sample";

/// Lists files of `projects/piazza` with their bytes.
macro_rules! files {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_bytes!(concat!("../../projects/piazza/", $path)))),*]
    };
}

/// The files of the sample's site: their paths below its folder, and their bytes.
const FILES: [(&str, &[u8]); 14] = files![
    "flight.json",
    "photos/01_church.jpg",
    "photos/02_from_southwest.jpg",
    "photos/03_from_southeast.jpg",
    "photos/04_arcade.jpg",
    "photos/05_from_the_steps.jpg",
    "photos/06_under_the_loggia.jpg",
    "photos/07_under_the_arcade.jpg",
    "photos/08_portrait.jpg",
    "photos/09_from_a_roof.jpg",
    "piazza.obj",
    "sparse/cameras.txt",
    "sparse/images.txt",
    "sparse/points3D.txt",
];

/// Returns the folder of the sample's project, for the folder of the sample.
pub fn project_of_sample(folder: &Path) -> PathBuf {
    folder.join(PROJECT)
}

/// Returns whether the project of a sample is in `folder` already.
pub fn has_sample(folder: &Path) -> bool {
    project_of_sample(folder).join(PROJECT_FILE).is_file()
}

/// Returns a folder for the sample below `home`: one where it is already, else one that is new or empty.
pub fn suggested_folder(home: &Path) -> PathBuf {
    first_folder(home, NAME, |folder| has_sample(folder) || check_is_empty(folder).is_ok())
}

/// Returns the folder for a sample that was asked for in `chosen`: the folder itself where it is empty or has the
/// sample, else one below it.
pub fn folder_in(chosen: &Path) -> PathBuf {
    match has_sample(chosen) || check_is_empty(chosen).is_ok() {
        true => chosen.to_path_buf(),
        false => suggested_folder(chosen),
    }
}

/// Writes the sample's site into `folder`, which has to be new or empty, and creates its project in `project` below it. On
/// failure `folder` is left as it was.
///
/// # Errors
/// Returns [`Error::Request`] when the folder is not empty; [`Error::Io`] when a file cannot be written; the errors of
/// [`create_project`].
pub fn create_sample(folder: &Path, task: &Task) -> Result<Opened> {
    check_is_empty(folder)?;
    create_folder_with(folder, |site| {
        for (path, bytes) in FILES {
            task.check_cancelled()?;
            let path = site.join(path);
            let within = path.parent().unwrap_or(site);
            fs::create_dir_all(within).map_err(Error::io(within, "create the folder"))?;
            write_atomically(&path, bytes)?;
        }
        let new = NewProject {
            photos: site.join("photos"),
            cameras: site.join("sparse"),
            model: site.join("piazza.obj"),
            ..NewProject::default()
        };
        create_project(&project_of_sample(site), &new, task)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::open;

    #[test]
    fn the_sample_is_a_project_that_opens() {
        let folder = tempfile::tempdir().unwrap();
        let sample = folder.path().join("new").join("sample");
        assert!(!has_sample(&sample));
        create_sample(&sample, &Task::silent()).unwrap();
        assert!(has_sample(&sample));
        let opened = open(&project_of_sample(&sample), &Task::silent()).unwrap();
        assert_eq!((opened.site.photos.len(), opened.site.model.objects.len()), (9, 77));
        assert!(opened.problems.errors.is_empty(), "{:?}", opened.problems);
        let beside = fs::read_dir(sample.parent().unwrap()).unwrap().count();
        assert_eq!(beside, 1, "nothing else is left");
    }

    #[test]
    fn a_sample_that_is_there_is_found_again_and_other_folders_are_left_alone() {
        let home = tempfile::tempdir().unwrap();
        let first = suggested_folder(home.path());
        create_sample(&first, &Task::silent()).unwrap();
        assert_eq!(suggested_folder(home.path()), first);
        fs::remove_file(project_of_sample(&first).join(PROJECT_FILE)).unwrap();
        assert_ne!(suggested_folder(home.path()), first);
        assert_eq!(folder_in(&first), first.join(NAME));
        let empty = home.path().join("empty");
        assert_eq!(folder_in(&empty), empty);
    }

    #[test]
    fn a_folder_with_something_in_it_is_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("mine.txt"), "mine").unwrap();
        let error = create_sample(folder.path(), &Task::silent()).err().unwrap().to_string();
        assert!(error.contains("mine.txt"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_empty_folder_is_used_and_a_stopped_attempt_leaves_it_empty() {
        let folder = tempfile::tempdir().unwrap();
        let sample = folder.path().join("sample");
        fs::create_dir(&sample).unwrap();
        let task = Task::silent();
        task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(matches!(create_sample(&sample, &task), Err(Error::Cancelled)));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        create_sample(&sample, &Task::silent()).unwrap();
        assert!(has_sample(&sample));
    }
}
