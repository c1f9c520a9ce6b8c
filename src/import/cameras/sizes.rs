//! Sizes of photos, for formats that do not state them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::photo_paths::PhotoPath;
use crate::photo::{Match, PhotoFolder, picture_size};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::named_file::NamedFiles;
use quadratura_files::text::Objection;

/// The source of sizes.
#[derive(Debug, Clone, Copy)]
pub(super) enum SizeSource<'a> {
    /// The photo's file at the path given in the cameras' file.
    Named,
    /// The file in this folder that import will match with the photo.
    Folder(&'a Path),
    /// No source: only names and points are needed.
    Unneeded,
}

impl SizeSource<'_> {
    /// Returns whether sizes of photos are those of their files.
    pub fn are_known(&self) -> bool {
        !matches!(self, Self::Unneeded)
    }

    /// Reads width and height of each photo in pixels, as stored in its file.
    ///
    /// # Errors
    /// Returns an error when the folder cannot be read, or [`Error::Cancelled`]. The problem of a single photo is in
    /// its place in the list.
    pub fn read(&self, photos: &[PhotoPath], task: &Task) -> Result<Vec<Result<[u64; 2], Objection>>> {
        let looked_up = match self {
            Self::Folder(folder) => in_folder(folder, photos, task)?,
            Self::Named | Self::Unneeded => Vec::new(),
        };
        let mut named = NamedFiles::default();
        let mut sizes = Vec::with_capacity(photos.len());
        for (index, photo) in photos.iter().enumerate() {
            task.step("read sizes", index as u64, photos.len() as u64)?;
            sizes.push(match self {
                Self::Unneeded => Ok(ANY),
                Self::Named => match photo.files.iter().find_map(|file| named.path(file)) {
                    Some(file) => size_of(&file),
                    None => Err((format!("{UNKNOWN}, and its file is not there"), PUT_THERE)),
                },
                Self::Folder(_) => looked_up[index].clone().and_then(|file| size_of(&file)),
            });
        }
        Ok(sizes)
    }
}

/// Finds the file of each photo in the way of import.
fn in_folder(folder: &Path, photos: &[PhotoPath], task: &Task) -> Result<Vec<Result<PathBuf, Objection>>> {
    let files = PhotoFolder::scan(folder, task)?;
    // A photo that is listed twice has one file all the same; the second is refused later.
    let names: BTreeSet<&str> = photos.iter().map(|photo| photo.name.as_str()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    let file = |found: Match| match found {
        // Reading the size of what is no photo says what it is instead.
        Match::File(file, _) | Match::NotRead(file) => Ok(files.path(file)),
        Match::Missing => {
            Err((format!("{UNKNOWN}, and there is no such photo in {}", folder.display()), GIVE))
        }
        Match::Ambiguous { .. } => Err((format!("{UNKNOWN}, and several files could be the photo"), NAME)),
    };
    let found: BTreeMap<&str, Result<PathBuf, Objection>> =
        names.iter().copied().zip(files.find(&names).into_iter().map(file)).collect();
    Ok(photos.iter().map(|photo| found[photo.name.as_str()].clone()).collect())
}

/// A size for which the focal length of any photo is plausible.
const ANY: [u64; 2] = [1000, 1000];
const UNKNOWN: &str = "the cameras' file does not state the photo's size";
const PUT_THERE: &str = "put the photo where the cameras' file names it";
const GIVE: &str = "put it there, or give the folder of the photos";

const SAVE: &str = "copy the photo again, or save it anew in an image editor";
const NAME: &str = "give the files the paths that the cameras' file names";

fn size_of(file: &Path) -> Result<[u64; 2], Objection> {
    match picture_size(file) {
        Ok(size) => Ok(size.map(u64::from)),
        Err(Error::Input { found, .. }) => Err((format!("{UNKNOWN}, and {}: {found}", file.display()), SAVE)),
        Err(error) => Err((format!("{UNKNOWN}, and {error}"), SAVE)),
    }
}
