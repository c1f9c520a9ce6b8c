//! Missing parts of a project: which ones are not where `project.json` says, where they might be now, and storing
//! their new places. Callers of the functions that write hold the project's lock.

use std::fs::File;
use std::path::{Component, Path, PathBuf};

use crate::discover::{SitePart, SiteParts};
use crate::open::OpeningProblems;
use quadratura_base::error::{Error, Result};
use quadratura_document::Project;
use quadratura_files::atomic::write_atomically_with;
use quadratura_import::cameras::check_exists;
use quadratura_io::project::{read_project, relative_to, write_project};

/// Returns the absolute, normalised paths of a project's parts according to `project.json`, whether they exist or
/// not.
pub fn parts_of(folder: &Path, project: &Project) -> SiteParts {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let resolve = |path: &str| {
        let path = folder.join(path);
        path.canonicalize().unwrap_or_else(|_| without_detours(&path))
    };
    SiteParts {
        photos: resolve(&project.photos),
        cameras: resolve(&project.cameras),
        model: resolve(&project.model),
    }
}

/// Resolves `.` and `..` in a path without looking at the disk.
fn without_detours(path: &Path) -> PathBuf {
    let mut straight = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => drop(straight.pop()),
            Component::CurDir => (),
            other => straight.push(other),
        }
    }
    straight
}

/// Returns the parts that do not exist.
pub fn gone(parts: &SiteParts) -> Vec<SitePart> {
    SitePart::ALL.into_iter().filter(|part| !parts.path(*part).exists()).collect()
}

/// Returns the names of photos that the cameras refer to and that are not in the photo folder.
pub fn missing_photos(problems: &OpeningProblems, parts: &SiteParts) -> Vec<String> {
    let missing = |error: &Error| match error {
        Error::Input { file, .. } if !file.exists() => {
            let file = without_detours(file);
            Some(file.strip_prefix(&parts.photos).ok()?.to_string_lossy().replace('\\', "/"))
        }
        _ => None,
    };
    problems.errors.iter().filter_map(missing).collect()
}

/// Guesses where something that was at `gone` may be now: moved as other parts were (`moved`, from and to), or in a
/// folder above the project under the end of its old path. `is_there` tests whether a path exists.
pub fn guess(
    gone: &Path,
    moved: &[(PathBuf, PathBuf)],
    project: &Path,
    is_there: impl Fn(&Path) -> bool,
) -> Option<PathBuf> {
    let like_others = moved.iter().flat_map(|(from, to)| candidates_near(gone, from, to));
    let parts: Vec<Component> =
        gone.components().filter(|part| matches!(part, Component::Normal(_))).collect();
    // A longer common end of the path is more likely the same thing; among equal ones, nearer folders come first.
    let ends = (0..parts.len()).map(|start| parts[start..].iter().collect::<PathBuf>());
    let above = ends.flat_map(|end| project.ancestors().take(ANCESTORS).map(move |folder| folder.join(&end)));
    like_others.chain(above).find(|path| is_there(path))
}

/// The number of folders that are searched: the project's own, and those above it.
const ANCESTORS: usize = 4;

/// Returns where `gone` is if it moved together with something that moved from `from` to `to`, the likeliest place
/// first.
fn candidates_near(gone: &Path, from: &Path, to: &Path) -> Vec<PathBuf> {
    let (mut from, mut to) = (from.to_path_buf(), to.to_path_buf());
    let mut candidates = Vec::new();
    while let (Some(was), Some(is)) = (from.file_name(), to.file_name()) {
        let same = was == is;
        // The moved item may have been renamed; the folders around it moved all the same.
        if !(from.pop() && to.pop()) {
            break;
        }
        candidates.extend(gone.strip_prefix(&from).ok().map(|below| to.join(below)));
        if !same {
            break;
        }
    }
    candidates
}

/// Returns the project with the parts' present paths and without any other change.
///
/// # Errors
/// Returns [`Error::Io`] and [`Error::Input`] where parts do not exist, all of them together.
pub fn relinked(project: &Project, folder: &Path, parts: &SiteParts) -> Result<Project> {
    let mut project = project.clone();
    let mut errors = Vec::new();
    for part in SitePart::ALL {
        let written = match part {
            SitePart::Photos => &mut project.photos,
            SitePart::Cameras => &mut project.cameras,
            SitePart::Model => &mut project.model,
        };
        let exists = if part == SitePart::Cameras { check_exists(parts.path(part)) } else { Ok(()) };
        match exists.and_then(|()| relative_to(folder, parts.path(part))) {
            Ok(path) => *written = path,
            Err(error) => errors.push(error),
        }
    }
    Error::of_all(errors).map_or(Ok(project), Err)
}

/// Stores the parts' present paths in `project.json` and changes nothing else.
///
/// # Errors
/// Returns the errors of [`relinked`], and of reading and writing the project. The file is unchanged then.
pub fn relink(folder: &Path, parts: &SiteParts) -> Result<()> {
    write_project(folder, &relinked(&read_project(folder)?, folder, parts)?)
}

/// Copies `file` into the photo folder, as the photo that the cameras call `name`. Existing files are not
/// overwritten.
///
/// # Errors
/// Returns [`Error::Input`] when the file exists already, or [`Error::Io`].
pub fn bring_photo(photos: &Path, name: &str, file: &Path) -> Result<()> {
    let target = photos.join(name);
    if target.exists() {
        let remedy = "if the other file is the right one, move this one away first";
        return Err(Error::input(target, "", "a photo of this name already exists", remedy));
    }
    let mut source = File::open(file).map_err(Error::io(file, "open it"))?;
    if let Some(folder) = target.parent() {
        std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    }
    write_atomically_with(&target, |out| std::io::copy(&mut source, out).map(|_| ()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guessed(gone: &str, moved: &[(&str, &str)], project: &str, there: &[&str]) -> Option<String> {
        let moved: Vec<_> = moved.iter().map(|(from, to)| (from.into(), to.into())).collect();
        let found = guess(Path::new(gone), &moved, Path::new(project), |path| {
            there.iter().any(|there| Path::new(there) == path)
        });
        found.map(|path| path.to_str().unwrap().replace('\\', "/"))
    }

    #[test]
    fn what_stood_beside_something_that_moved_is_looked_for_beside_its_new_place() {
        let moved = [("/a/site/images", "/b/old/site/images")];
        let there = ["/b/old/site/sparse"];
        assert_eq!(guessed("/a/site/sparse", &moved, "/p", &there), Some(there[0].into()));
        let renamed = [("/a/site/images", "/b/photos")];
        assert_eq!(guessed("/a/site/sparse", &renamed, "/p", &["/b/sparse"]), Some("/b/sparse".into()));
        assert_eq!(guessed("/a/site/sparse", &renamed, "/p", &["/b/other"]), None);
    }

    #[test]
    fn without_a_hint_the_folders_around_the_project_are_looked_into() {
        let there = ["/new/castle/images", "/new/images"];
        assert_eq!(guessed("/old/castle/images", &[], "/new/projects/p", &there), Some(there[0].into()));
        assert_eq!(guessed("/old/castle/images", &[], "/new/projects/p", &there[1..]), Some(there[1].into()));
        assert_eq!(guessed("/old/images", &[], "/a/b/c/d/e/f", &["/a/images"]), None, "too far away");
    }

    fn project(folder: &Path) -> PathBuf {
        for below in ["project", "site/images", "site/sparse"] {
            std::fs::create_dir_all(folder.join(below)).unwrap();
        }
        std::fs::write(folder.join("site/house.obj"), "").unwrap();
        let text = r#"{"version": 1, "photos": "../old/images", "cameras": "../site/sparse", "model": "../old/house.obj",
            "options": {"margin": 7}}"#;
        std::fs::write(folder.join("project/project.json"), text).unwrap();
        folder.join("project")
    }

    #[test]
    fn parts_that_are_gone_are_named_and_relinked_without_touching_anything_else() {
        let folder = tempfile::tempdir().unwrap();
        let project = project(folder.path());
        let mut parts = parts_of(&project, &read_project(&project).unwrap());
        assert_eq!(gone(&parts), [SitePart::Photos, SitePart::Model]);
        assert!(parts.photos.ends_with("old/images") && !parts.photos.to_str().unwrap().contains(".."));

        parts.photos = folder.path().join("site/images");
        let before = std::fs::read(project.join("project.json")).unwrap();
        let refused = relink(&project, &parts).unwrap_err().to_string();
        assert!(refused.contains("house.obj"), "{refused}");
        assert_eq!(std::fs::read(project.join("project.json")).unwrap(), before);

        parts.model = folder.path().join("site/house.obj");
        relink(&project, &parts).unwrap();
        let now = read_project(&project).unwrap();
        assert_eq!(
            [now.photos, now.cameras, now.model],
            ["../site/images", "../site/sparse", "../site/house.obj"]
        );
        assert_eq!(now.options.margin, 7);
    }

    #[test]
    fn a_photo_is_brought_under_the_name_that_the_cameras_give_and_never_over_another() {
        let folder = tempfile::tempdir().unwrap();
        let (photos, file) = (folder.path().join("photos"), folder.path().join("IMG 1.jpg"));
        std::fs::write(&file, "pixels").unwrap();
        bring_photo(&photos, "north/0001.jpg", &file).unwrap();
        assert_eq!(std::fs::read(photos.join("north/0001.jpg")).unwrap(), b"pixels");
        let refused = bring_photo(&photos, "north/0001.jpg", &file).unwrap_err().to_string();
        assert!(refused.contains("already"), "{refused}");
    }
}
