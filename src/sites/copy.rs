//! Copies of projects: all files but caches, with the decisions as they are now, and with paths that are right in the new
//! place.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::trees::PlantSource;
use quadratura_files::atomic::create_folder_with;
use quadratura_files::lock::LOCK_FILE;
use quadratura_io::project::{PROJECT_FILE, UNSAVED_FILE, below, check_is_empty, relative_to, write_project};

/// The entries of a project's folder that a copy does not have: what is made anew, and what belongs to the open project.
const LEFT_OUT: [&str; 4] = ["cache", LOCK_FILE, UNSAVED_FILE, PROJECT_FILE];

/// What was copied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CopiedProject {
    /// The number of files.
    pub files: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// Copies the project in `folder` to the new or empty folder `to`, with the decisions of `project`. Photos, cameras, model and
/// plants outside of the project's folder are not copied: the copy refers to the same files. The caller sees to it that
/// nothing is written to the project meanwhile. On failure `to` is left as it was.
///
/// # Errors
/// [`Error::Request`] where `to` is not empty, or is in `folder`; [`Error::Io`]; [`Error::Cancelled`].
pub fn copy_project(folder: &Path, project: &Project, to: &Path, task: &Task) -> Result<CopiedProject> {
    check_is_empty(to)?;
    let folder = folder.canonicalize().map_err(Error::io(folder, "find it"))?;
    let was_there = to.exists();
    fs::create_dir_all(to).map_err(Error::io(to, "create the folder"))?;
    let copied = copy_into(&folder, project, to, task);
    if copied.is_err() && !was_there {
        // It is empty, or somebody else has used it since.
        let _ = fs::remove_dir(to);
    }
    copied
}

fn copy_into(folder: &Path, project: &Project, to: &Path, task: &Task) -> Result<CopiedProject> {
    let place = to.canonicalize().map_err(Error::io(to, "find it"))?;
    if place.starts_with(folder) {
        let (to, folder) = (to.display(), folder.display());
        return Err(Error::Request(format!(
            "{to}: this folder is in the project {folder}; choose a folder outside of it"
        )));
    }
    let project = moved(folder, project, &place);
    let files = files_of(folder)?;
    let mut copied = CopiedProject::default();
    create_folder_with(&place, |new| {
        for (done, file) in (0u64..).zip(&files) {
            task.step("copy files", done, files.len() as u64)?;
            copied.bytes += copy_file(&folder.join(file), &new.join(file))?;
            copied.files += 1;
        }
        write_project(new, &project)
    })?;
    Ok(copied)
}

/// Returns the project with its paths as they are from `to`; what is in `folder` is in the same place of the copy.
fn moved(folder: &Path, project: &Project, to: &Path) -> Project {
    let mut project = project.clone();
    let species = project.trees.species.values_mut().filter_map(|species| match &mut species.from {
        PlantSource::File(file) => Some(file),
        PlantSource::Maple(_) | PlantSource::Oak(_) => None,
    });
    let picture = project.surroundings.as_mut().map(|surroundings| &mut surroundings.picture);
    let parts = [&mut project.photos, &mut project.cameras, &mut project.model];
    for path in parts.into_iter().chain(species).chain(picture) {
        let target = below(folder, path);
        let target = target.canonicalize().unwrap_or(target);
        let inside = target.strip_prefix(folder).ok().and_then(Path::to_str);
        *path = match inside {
            Some("") => ".".into(),
            Some(inside) => inside.replace(std::path::MAIN_SEPARATOR, "/"),
            // What is missing now is missing in the copy, too, under a path that says where it was.
            None => relative_to(to, &target).unwrap_or_else(|_| target.to_string_lossy().into_owned()),
        };
    }
    project
}

/// Lists the files to copy, relative to `folder`, in the order of their names. Linked folders are left out: paths through
/// them lead out of the project.
fn files_of(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(below) = folders.pop() {
        let here = folder.join(&below);
        for entry in fs::read_dir(&here).map_err(Error::io(&here, "read the folder"))? {
            let entry = entry.map_err(Error::io(&here, "read the folder"))?;
            let name = entry.file_name();
            let is_left_out = below.as_os_str().is_empty() && LEFT_OUT.iter().any(|other| name == *other);
            let Ok(kind) = entry.file_type() else { continue };
            let path = below.join(name);
            match kind.is_dir() {
                _ if is_left_out => (),
                true => folders.push(path),
                false if entry.path().is_file() => files.push(path),
                false => (),
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Copies a file with its time, by which layers know whether it has changed; returns its size.
fn copy_file(from: &Path, to: &Path) -> Result<u64> {
    let within = to.parent().expect("a file of a project is in a folder");
    fs::create_dir_all(within).map_err(Error::io(within, "create the folder"))?;
    let bytes = fs::copy(from, to).map_err(Error::io(from, "copy it"))?;
    let copy = File::options().append(true).open(to).map_err(Error::io(to, "open it"))?;
    // A file system without times has none to keep.
    let _ = from.metadata().and_then(|data| data.modified()).and_then(|changed| copy.set_modified(changed));
    copy.sync_all().map_err(Error::io(to, "write it to disk"))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::open;
    use crate::sample::{create_sample, project_of_sample};
    use quadratura_io::project::read_project;

    /// Returns the project of a sample in `folder`, with a file of each kind.
    fn sample(folder: &Path) -> PathBuf {
        create_sample(&folder.join("sample"), &Task::silent()).unwrap();
        let project = project_of_sample(&folder.join("sample"));
        for (file, text) in [("paint/a.bin", "paint"), ("cache/b.bin", "made anew"), (UNSAVED_FILE, "{}")] {
            fs::create_dir_all(project.join(file).parent().unwrap()).unwrap();
            fs::write(project.join(file), text).unwrap();
        }
        project
    }

    #[test]
    fn a_copy_has_the_paint_and_the_present_decisions_and_opens_at_another_depth() {
        let folder = tempfile::tempdir().unwrap();
        let from = sample(folder.path());
        let mut project = read_project(&from).unwrap();
        project.objects_off.insert("bench".into());
        let to = folder.path().join("elsewhere/deeper/copy");
        let copied = copy_project(&from, &project, &to, &Task::silent()).unwrap();
        assert!(copied.files >= 1 && copied.bytes >= 5, "{copied:?}");
        assert_eq!(fs::read_to_string(to.join("paint/a.bin")).unwrap(), "paint");
        assert!(!to.join("cache").exists() && !to.join(UNSAVED_FILE).exists());
        let time = |folder: &Path| folder.join("paint/a.bin").metadata().unwrap().modified().unwrap();
        assert_eq!(time(&from), time(&to));
        let opened = open(&to, &Task::silent()).unwrap();
        assert_eq!((opened.site.photos.len(), opened.problems.errors.len()), (9, 0));
        assert!(opened.project.objects_off.contains("bench"));
        assert!(!read_project(&from).unwrap().objects_off.contains("bench"), "the first one is as it was");
    }

    #[test]
    fn what_is_in_the_projects_folder_is_copied_and_found_in_the_copy() {
        let folder = tempfile::tempdir().unwrap();
        let from = sample(folder.path());
        fs::rename(folder.path().join("sample/photos"), from.join("my photos")).unwrap();
        let absolute = from.join("my photos").to_str().unwrap().to_owned();
        let project = Project { photos: absolute, ..read_project(&from).unwrap() };
        let to = folder.path().join("copy");
        copy_project(&from, &project, &to, &Task::silent()).unwrap();
        assert_eq!(read_project(&to).unwrap().photos, "my photos");
        assert_eq!(open(&to, &Task::silent()).unwrap().site.photos.len(), 9);
    }

    #[test]
    fn a_copy_into_itself_or_over_something_is_refused_and_a_stopped_one_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let from = sample(folder.path());
        let project = read_project(&from).unwrap();
        let copy = |to: &Path, task: &Task| copy_project(&from, &project, to, task).unwrap_err();
        let inside = from.join("copies/one");
        assert!(copy(&inside, &Task::silent()).to_string().contains("outside of it"));
        assert!(!inside.exists());
        assert!(copy(&folder.path().join("sample"), &Task::silent()).to_string().contains("not empty"));
        let task = Task::silent();
        task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        let to = folder.path().join("stopped");
        assert!(matches!(copy(&to, &task), Error::Cancelled));
        assert!(!to.exists());
    }
}
