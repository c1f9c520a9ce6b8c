//! Matches the photos of the cameras to files in the photo folder.

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use super::is_photo;
use super::kind::{is_photo_ending, is_picture_ending};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::alike::{self, composed, extension_folded, folded};
use quadratura_base::task::Task;

/// Sub-folders are searched down to this depth; links between folders may form circles.
const DEEPEST: usize = 16;

/// The image files of a folder and its sub-folders.
#[derive(Debug)]
pub struct PhotoFolder {
    root: PathBuf,
    /// Paths below `root`, with `/`: first those of photos, sorted, then all others, sorted.
    files: Vec<String>,
    /// The number of files that have the ending of a photo.
    photos: usize,
}

/// The result of matching one photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Match {
    /// The index of the file, and how its name differs from the photo's (empty if it does not).
    File(usize, &'static str),
    /// The index of a file of this name, or of this name and another ending, whose content is no photo that is read.
    NotRead(usize),
    /// No file matches.
    Missing,
    /// Several files match equally well, or several photos match this file.
    Ambiguous {
        /// Indices of the files.
        files: Vec<usize>,
        /// Number of photos that match these files.
        photos: usize,
    },
}

impl Match {
    /// Returns the index of the only file.
    pub fn file(&self) -> Option<usize> {
        match self {
            Self::File(file, _) => Some(*file),
            _ => None,
        }
    }
}

/// A way in which names may differ, and a function that maps such names to the same text. All but the first take names in
/// composed Unicode form, and `\` for `/`.
type Rule = (&'static str, fn(&str) -> String);

/// The ways in which a file's name may differ from the photo's, from the smallest difference to the largest.
const RULES: [Rule; 10] = [
    ("", |name| name.to_owned()),
    (FORM, |name| composed(name).into_owned()),
    ("in another letter case", |name| extension_folded(name).into_owned()),
    ("in another letter case", |name| folded(name).into_owned()),
    ("in another folder", |name| base(&composed(name)).to_owned()),
    ("in another folder and letter case", |name| base(&folded(name)).to_owned()),
    ("in another image format", |name| stem(&composed(name)).to_owned()),
    ("in another image format and letter case", |name| stem(&folded(name)).to_owned()),
    ("in another folder and image format", |name| stem(base(&composed(name))).to_owned()),
    ("in another folder, image format and letter case", |name| stem(base(&folded(name))).to_owned()),
];

/// The rule of names that look the same; [`alike::difference`] says what differs.
const FORM: &str = "under another Unicode form";

fn base(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// Returns the name without the extension of an image format, read or not; other endings are kept.
fn stem(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((stem, extension)) if is_picture_ending(extension) => stem,
        _ => name,
    }
}

fn has_no_ending(name: &str) -> bool {
    stem(name) == name
}

/// Returns how a file's name differs from that of a photo which says nothing of the image format.
fn without_ending(difference: &'static str) -> &'static str {
    match difference {
        "in another image format" => "",
        "in another image format and letter case" => "in another letter case",
        "in another folder and image format" => "in another folder",
        "in another folder, image format and letter case" => "in another folder and letter case",
        other => other,
    }
}

fn is_photo_name(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, extension)| is_photo_ending(extension))
}

impl PhotoFolder {
    /// Lists the image files below `root`; hidden files and folders are skipped.
    ///
    /// # Errors
    /// [`Error::Input`] when `root` is not a folder; [`Error::Io`]; [`Error::Cancelled`].
    pub fn scan(root: &Path, task: &Task) -> Result<Self> {
        if !root.is_dir() {
            return Err(Error::input(root, "", "this folder does not exist", "check the path to the photos"));
        }
        let mut files = Vec::new();
        enter(root, "", 0, &mut files, task)?;
        Ok(Self::of(root.to_path_buf(), files))
    }

    fn of(root: PathBuf, mut files: Vec<String>) -> Self {
        files.sort_unstable_by(|a, b| (!is_photo_name(a), a).cmp(&(!is_photo_name(b), b)));
        let photos = files.iter().take_while(|file| is_photo_name(file)).count();
        Self { root, files, photos }
    }

    /// Returns the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the path of the file with index `file`.
    pub fn path(&self, file: usize) -> PathBuf {
        self.root.join(&self.files[file])
    }

    /// Returns the file with index `file` as a path relative to the folder, with `/`.
    pub fn name(&self, file: usize) -> &str {
        &self.files[file]
    }

    /// Returns the number of image files.
    pub fn len(&self) -> usize {
        self.photos
    }

    /// Returns whether there is no image file.
    pub fn is_empty(&self) -> bool {
        self.photos == 0
    }

    /// Finds a file for each of `names`, in their order. No file is used for two photos: a file whose name
    /// equals a photo's is not considered for another photo.
    pub fn find(&self, names: &[&str]) -> Vec<Match> {
        let mut found = vec![Match::Missing; names.len()];
        let mut taken = vec![false; self.files.len()];
        self.find_named(names, &mut found, &mut taken);
        for (difference, key) in RULES {
            let mut photos: FxHashMap<String, Vec<usize>> = FxHashMap::default();
            for (photo, name) in names.iter().enumerate().filter(|&(i, _)| found[i] == Match::Missing) {
                photos.entry(key(name)).or_default().push(photo);
            }
            let mut files: FxHashMap<String, Vec<usize>> = FxHashMap::default();
            let photos_there = self.files[..self.photos].iter().enumerate();
            for (file, name) in photos_there.filter(|&(i, _)| !taken[i]) {
                files.entry(key(name)).or_default().push(file);
            }
            for (key, photos) in photos {
                match (photos.as_slice(), files.get(&key).map(Vec::as_slice)) {
                    (_, None) => (),
                    (&[photo], Some(&[file])) => {
                        let how = match difference {
                            FORM => alike::difference(names[photo], &self.files[file]),
                            other if has_no_ending(names[photo]) => without_ending(other),
                            other => other,
                        };
                        found[photo] = Match::File(file, how);
                        taken[file] = true;
                    }
                    (_, Some(files)) => {
                        let ambiguous = Match::Ambiguous { files: files.to_vec(), photos: photos.len() };
                        photos.iter().for_each(|&photo| found[photo] = ambiguous.clone());
                    }
                }
            }
        }
        self.find_others(names, &mut found, &mut taken);
        found
    }

    /// Finds photos of exactly these names that have the ending of none.
    fn find_named(&self, names: &[&str], found: &mut [Match], taken: &mut [bool]) {
        for (name, found) in names.iter().zip(found) {
            if let Ok(at) = self.files[self.photos..].binary_search_by(|file| file.as_str().cmp(name))
                && is_photo(&self.path(self.photos + at))
            {
                taken[self.photos + at] = true;
                *found = Match::File(self.photos + at, "");
            }
        }
    }

    /// Finds files for photos that have none yet among those that have not the ending of a photo: of the same name, or with
    /// the ending of another picture.
    fn find_others(&self, names: &[&str], found: &mut [Match], taken: &mut [bool]) {
        let others = self.photos..self.files.len();
        for (difference, key) in RULES {
            if !found.contains(&Match::Missing) {
                return;
            }
            let may_be =
                |file: &usize| difference.is_empty() || stem(&self.files[*file]) != self.files[*file];
            let files = others.clone().filter(may_be).rev();
            let files: FxHashMap<String, usize> = files.map(|file| (key(&self.files[file]), file)).collect();
            for (name, found) in names.iter().zip(&mut *found).filter(|(_, found)| **found == Match::Missing)
            {
                match files.get(&key(name)) {
                    Some(&file) if !is_photo(&self.path(file)) => *found = Match::NotRead(file),
                    Some(&file) if !std::mem::replace(&mut taken[file], true) => {
                        *found = Match::File(file, difference);
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Lists the files below a folder; hidden files and folders are skipped.
fn enter(root: &Path, below: &str, depth: usize, files: &mut Vec<String>, task: &Task) -> Result<()> {
    task.check_cancelled()?;
    let folder = root.join(below);
    for entry in std::fs::read_dir(&folder).map_err(Error::io(&folder, "read the folder"))? {
        let entry = entry.map_err(Error::io(&folder, "read the folder"))?;
        // The cameras' names are UTF-8, so a file whose name is not cannot match.
        let Ok(name) = entry.file_name().into_string() else { continue };
        if name.starts_with('.') {
            continue;
        }
        let path = if below.is_empty() { name } else { format!("{below}/{name}") };
        let Ok(metadata) = std::fs::metadata(entry.path()) else { continue };
        if metadata.is_dir() && depth < DEEPEST {
            enter(root, &path, depth + 1, files, task)?;
        } else if metadata.is_file() {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> PhotoFolder {
        PhotoFolder::of(PathBuf::new(), files.iter().map(|&f| f.to_owned()).collect())
    }

    fn found<'a>(folder: &'a PhotoFolder, name: &str) -> (&'a str, &'static str) {
        match folder.find(&[name])[0] {
            Match::File(file, how) => (folder.name(file), how),
            _ => ("", "not found"),
        }
    }

    #[test]
    fn the_exact_path_wins_over_all_that_is_alike() {
        let folder = folder(&["a/1.jpg", "b/1.jpg", "1.jpg", "1.JPG", "1.png"]);
        for name in ["a/1.jpg", "b/1.jpg", "1.jpg", "1.JPG", "1.png"] {
            assert_eq!(found(&folder, name), (name, ""));
        }
    }

    #[test]
    fn another_case_of_the_ending_goes_before_another_case_of_the_name() {
        let folder = folder(&["A.jpg", "a.JPG"]);
        assert_eq!(found(&folder, "a.jpg"), ("a.JPG", "in another letter case"));
        assert_eq!(found(&folder, "A.JPG"), ("A.jpg", "in another letter case"));
    }

    #[test]
    fn a_file_may_differ_in_case_folder_and_format() {
        let folder = folder(&["x/IMG_1.JPG", "x/img_2.tif"]);
        assert_eq!(found(&folder, "x/img_1.jpg"), ("x/IMG_1.JPG", "in another letter case"));
        assert_eq!(found(&folder, "IMG_1.JPG"), ("x/IMG_1.JPG", "in another folder"));
        assert_eq!(found(&folder, "x/img_2.jpg"), ("x/img_2.tif", "in another image format"));
        assert_eq!(found(&folder, "y/img_2.jpg"), ("x/img_2.tif", "in another folder and image format"));
        assert_eq!(
            found(&folder, "IMG_2.webp"),
            ("x/img_2.tif", "in another folder, image format and letter case")
        );
        assert_eq!(found(&folder, "img_3.jpg"), ("", "not found"));
    }

    #[test]
    fn a_name_is_found_under_another_unicode_form_and_the_exact_one_goes_first() {
        let (composed, decomposed) = ("b/pont_\u{f1}.jpg", "b/pont_n\u{303}.jpg");
        assert_eq!(found(&folder(&[decomposed]), composed), (decomposed, "under another Unicode form"));
        assert_eq!(found(&folder(&[composed]), decomposed), (composed, "under another Unicode form"));
        let both = folder(&[composed, decomposed]);
        assert_eq!(found(&both, composed), (composed, ""));
        assert_eq!(found(&both, decomposed), (decomposed, ""));
        let upper = folder(&["x/PONT_N\u{303}.JPG"]);
        assert_eq!(
            found(&upper, "pont_\u{f1}.jpg"),
            ("x/PONT_N\u{303}.JPG", "in another folder and letter case")
        );
        // A third spelling of a letter with two accents fits both files equally.
        let several = folder(&["\u{1ed9}.jpg", "o\u{302}\u{323}.jpg"]);
        assert_eq!(several.find(&["\u{f4}\u{323}.jpg"]), [Match::Ambiguous { files: vec![0, 1], photos: 1 }]);
    }

    #[test]
    fn several_files_that_fit_equally_well_are_reported_and_none_is_taken() {
        let folder = folder(&["a/1.jpg", "b/1.jpg", "c/1.png"]);
        assert_eq!(folder.find(&["1.jpg"]), [Match::Ambiguous { files: vec![0, 1], photos: 1 }]);
        assert_eq!(found(&folder, "1.png"), ("c/1.png", "in another folder"));
    }

    #[test]
    fn a_file_that_is_one_photo_is_not_taken_for_another() {
        let folder = folder(&["a/1.jpg"]);
        assert_eq!(folder.find(&["b/1.jpg", "a/1.jpg"]), [Match::Missing, Match::File(0, "")]);
    }

    #[test]
    fn one_file_that_two_photos_claim_goes_to_neither() {
        let folder = folder(&["1.jpg"]);
        let both = Match::Ambiguous { files: vec![0], photos: 2 };
        assert_eq!(folder.find(&["a/1.jpg", "b/1.jpg"]), [both.clone(), both]);
    }

    #[test]
    fn a_dot_in_a_name_is_not_taken_for_an_extension() {
        assert_eq!(stem("a.b/photo.v2"), "a.b/photo.v2");
        assert_eq!(stem("photo.v2.jpeg"), "photo.v2");
    }

    #[test]
    fn a_photo_is_found_by_its_content_and_what_is_no_photo_is_told_from_what_is_missing() {
        let root = tempfile::tempdir().unwrap();
        let (jpeg, heic) = (b"\xFF\xD8\xFF\xE0\0\x10", b"\0\0\0\x18ftypheic\0\0\0\0heicmif1");
        let files: [(&str, &[u8]); 9] = [
            ("1.HEIC", jpeg),
            ("2.HEIC", heic),
            ("3.HEIC", heic),
            ("3.jpg", jpeg),
            ("shot4", jpeg),
            ("shot4.png", jpeg),
            ("far/5.dng", b"II*\0\x08\0\0\0"),
            ("6.txt", b"six"),
            ("8.gif", b"GIF89a"),
        ];
        std::fs::create_dir(root.path().join("far")).unwrap();
        for (file, content) in files {
            std::fs::write(root.path().join(file), content).unwrap();
        }
        let folder = PhotoFolder::scan(root.path(), &Task::silent()).unwrap();
        let names = ["1.HEIC", "2.HEIC", "3.HEIC", "shot4", "5.DNG", "6.txt", "6.jpg", "7.heic", "8.jpg"];
        let found = folder.find(&names).into_iter().map(|found| match found {
            Match::File(file, difference) => format!("{} {difference}", folder.name(file)),
            Match::NotRead(file) => format!("{} is not read", folder.name(file)),
            other => format!("{other:?}"),
        });
        assert_eq!(
            found.collect::<Vec<_>>(),
            [
                "1.HEIC ",
                "2.HEIC is not read",
                "3.jpg in another image format",
                "shot4 ",
                "far/5.dng is not read",
                "6.txt is not read",
                "Missing",
                "Missing",
                "8.gif is not read",
            ]
        );
        assert_eq!(folder.len(), 2, "photos by their endings");
    }

    #[test]
    fn only_image_files_are_listed_with_their_sub_folders() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("b/c")).unwrap();
        for file in ["b/c/1.JPG", "a.png", "notes.txt", ".hidden.jpg"] {
            std::fs::write(root.path().join(file), "").unwrap();
        }
        let folder = PhotoFolder::scan(root.path(), &Task::silent()).unwrap();
        assert_eq!(folder.files, ["a.png", "b/c/1.JPG", "notes.txt"]);
        assert_eq!((folder.len(), folder.is_empty()), (2, false));
        assert!(PhotoFolder::scan(&root.path().join("a.png"), &Task::silent()).is_err());
    }
}
