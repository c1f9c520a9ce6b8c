//! The files to which layered depth images of a project are written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_files::free_path::{FreePath, free_path};
use quadratura_files::writable::check_beside;
use quadratura_ldi::file::LdiFile;
use quadratura_ldi::{Arrangement, Ldi, LdiKind};

/// Returns the file of a photo's layered depth image in the cache of the project in `folder`.
pub fn cached_file(folder: &Path, photo: &str) -> PathBuf {
    folder.join("cache/ldi").join(format!("{}.ldi", file_name_of_photo(photo)))
}

/// Refuses to write where no file can be, before the work and not after it.
///
/// # Errors
/// [`Error::Request`]; those of [`check_beside`].
pub(super) fn check_out(out: &Path) -> Result<()> {
    if out.exists() && !out.is_file() {
        let found = format!("{} is no plain file; give --out the name of a file", out.display());
        return Err(Error::Request(found));
    }
    check_beside(out)
}

/// Returns the first name that is free or belongs to a whole layered depth image of the same photo, camera and options, and
/// the files that are kept for that reason: `NAME.ldi`, `NAME-2.ldi` and so on.
pub(super) fn free_file(out: &Path, new: &Ldi, task: &Task) -> Result<(PathBuf, Vec<PathBuf>)> {
    free_file_of(out, Arrangement::Single, &[Identity::of(new)], task)
}

/// Returns the same for several images in one file.
pub(super) fn free_file_of(
    out: &Path,
    arrangement: Arrangement,
    images: &[Identity],
    task: &Task,
) -> Result<(PathBuf, Vec<PathBuf>)> {
    check_out(out)?;
    let is_older = |path: &Path| holds(path, arrangement, images, task).unwrap_or(false);
    let FreePath { path, spared } = free_path(out, is_older);
    Ok((path, spared))
}

/// Returns whether a file is whole and holds older versions of some images, and nothing else.
fn holds(path: &Path, arrangement: Arrangement, images: &[Identity], task: &Task) -> Result<bool> {
    let file = LdiFile::open(path)?;
    if file.arrangement != arrangement || file.count() != images.len() {
        return Ok(false);
    }
    file.check()?;
    for (index, image) in images.iter().enumerate() {
        if Identity::of(&file.read(index, task)?) != *image {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What an image has in common with older versions of it: photo, camera and options.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Identity {
    camera: Pinhole,
    pose: Pose,
    kind: LdiKind,
    sources: Vec<String>,
    options: BTreeMap<String, String>,
}

impl Identity {
    /// Returns that of an image.
    pub fn of(ldi: &Ldi) -> Self {
        let Ldi { camera, pose, kind, ref sources, ref report, .. } = *ldi;
        Self { camera, pose, kind, sources: sources.clone(), options: report.options.clone() }
    }
}
