//! Photo names for formats that refer to photos by the paths of their files.

use std::path::{Path, PathBuf};

use crate::photo::{EXTENSIONS, is_picture_ending};

/// A photo given by its path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PhotoPath {
    /// The photo's name: its path below the deepest folder that holds all photos.
    pub name: String,
    /// The possible places of its file, the likeliest first.
    pub files: Vec<PathBuf>,
}

/// The meaning of a path without the ending of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Without {
    /// A `.png`, as in NeRF's scenes.
    Png,
    /// The image with any ending.
    Any,
}

/// Converts a list of paths to photos, in the same order. Paths are absolute or relative to one of `folders`, with `/`
/// or `\`. The names are the same for absolute and relative paths.
pub(super) fn photo_paths(paths: &[&str], folders: &[PathBuf], without: Without) -> Vec<PhotoPath> {
    let first = folders.first().map(|folder| absolute(folder)).unwrap_or_default();
    let whole: Vec<Vec<String>> =
        paths.iter().map(|path| parts(&with_ending(path, without), &first)).collect();
    let folder_of = |parts: &[String]| parts.len().saturating_sub(1);
    let mut shared = whole.first().map_or(&[][..], |parts| &parts[..folder_of(parts)]);
    for parts in &whole {
        let same = shared.iter().zip(&parts[..folder_of(parts)]).take_while(|(a, b)| a == b).count();
        shared = &shared[..same];
    }
    let named = paths.iter().zip(&whole).map(|(path, parts)| PhotoPath {
        name: parts[shared.len()..].join("/"),
        files: files(path, folders),
    });
    named.collect()
}

/// Lists the possible files of a path: with its own ending, or with each ending of images.
fn files(path: &str, folders: &[PathBuf]) -> Vec<PathBuf> {
    let path = path.trim().replace('\\', "/");
    let endings = EXTENSIONS.map(|extension| format!("{path}.{extension}"));
    let spelled: Vec<String> = if has_ending(&path) { vec![path] } else { endings.into() };
    folders.iter().flat_map(|folder| spelled.iter().map(move |path| folder.join(path))).collect()
}

fn has_ending(path: &str) -> bool {
    let ending = path.rsplit('/').next().unwrap_or(path).rsplit_once('.').map_or("", |(_, ending)| ending);
    is_picture_ending(ending)
}

fn with_ending(path: &str, without: Without) -> String {
    let path = path.trim();
    if path.is_empty() || without == Without::Any || has_ending(path) {
        path.to_owned()
    } else {
        format!("{path}.png")
    }
}

fn absolute(folder: &Path) -> Vec<String> {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    parts(&whole.to_string_lossy(), &[])
}

/// Splits a path into its parts, without `.` and `..`. The parts of a relative path follow those of the folder `from`.
fn parts(path: &str, from: &[String]) -> Vec<String> {
    let path = path.replace('\\', "/");
    let has_drive = path.as_bytes().get(1) == Some(&b':');
    let mut parts = if path.starts_with('/') || has_drive { Vec::new() } else { from.to_vec() };
    for part in path.split('/') {
        match part {
            "" | "." => (),
            ".." => drop(parts.pop()),
            part => parts.push(part.to_owned()),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(paths: &[&str]) -> Vec<String> {
        photo_paths(paths, &["/site/nerf".into()], Without::Png).into_iter().map(|photo| photo.name).collect()
    }

    #[test]
    fn photos_are_named_from_the_deepest_folder_that_holds_them_all() {
        assert_eq!(names(&["images/a.jpg", "./images/b.JPG"]), ["a.jpg", "b.JPG"]);
        assert_eq!(names(&["left/1.jpg", "right/1.jpg"]), ["left/1.jpg", "right/1.jpg"]);
        assert_eq!(names(&["../photos/x/1.jpg", "/site/photos/2.jpg"]), ["x/1.jpg", "2.jpg"]);
        assert_eq!(names(&["C:\\shots\\1.jpg", "C:\\shots\\nord\\2.jpg"]), ["1.jpg", "nord/2.jpg"]);
        assert_eq!(names(&["deep/er/one.webp"]), ["one.webp"]);
        assert_eq!(names(&["train/r_0", "train/r_1.5"]), ["r_0.png", "r_1.5.png"]);
        assert!(names(&[]).is_empty());
    }

    #[test]
    fn a_path_never_leads_above_the_root() {
        assert_eq!(names(&["../../../../a.jpg", "../../b/c.jpg"]), ["a.jpg", "b/c.jpg"]);
    }

    #[test]
    fn a_label_without_ending_keeps_its_name() {
        let photos = photo_paths(&["DSC_0001", "DSC.0002"], &["/site".into()], Without::Any);
        assert_eq!([&photos[0].name, &photos[1].name], ["DSC_0001", "DSC.0002"]);
    }

    #[test]
    fn a_name_without_ending_may_be_any_image() {
        let photos = photo_paths(&["train/r_0"], &["/site".into(), "/".into()], Without::Png);
        assert_eq!(photos[0].files.len(), 2 * EXTENSIONS.len());
        assert_eq!(photos[0].files[2], Path::new("/site/train/r_0.png"));
    }
}
