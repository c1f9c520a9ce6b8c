//! Discovery of mask files beside the photos, by their usual names.

use std::collections::BTreeMap;
use std::path::Path;

use super::MaskEdit;
use super::undistorted::read_undistorted;
use crate::known_names::cameras_of;
use crate::named::index_of_photo;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Spans;
use quadratura_base::scene::Site;
use quadratura_base::scene::alike::difference;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::masks::MaskOrigin;
use quadratura_document::names::without_extension;
use quadratura_files::named_file::{NamedFile, NamedFiles};
use quadratura_import::cameras::CameraPhoto;
use quadratura_io::project::resolved;

/// The endings of mask files.
const ENDINGS: [&str; 3] = ["png", "tif", "tiff"];

/// Returns the possible names of a photo's mask, as paths from the photo folder: `0028.mask.png` and
/// `0028_mask.png` beside the photo, also after its full name; and, as COLMAP does it, in a folder `masks` in or
/// beside the photo folder, `masks/0028.jpg.png`. Each may be a TIFF, too.
pub fn mask_names(photo: &str) -> Vec<String> {
    let stem = without_extension(photo);
    let bases = [
        format!("{stem}.mask"),
        format!("{stem}_mask"),
        format!("{photo}.mask"),
        format!("{photo}_mask"),
        format!("masks/{photo}"),
        format!("../masks/{photo}"),
    ];
    bases.iter().flat_map(|base| ENDINGS.map(|ending| format!("{base}.{ending}"))).collect()
}

/// The mask files of photos.
#[derive(Debug, Default)]
pub struct MasksBeside {
    /// Those that were read.
    pub found: Vec<FoundMask>,
    /// Those that cannot be read, with the reason.
    pub unread: Vec<UnreadMask>,
    /// Names that several files could have.
    pub problems: Vec<Error>,
}

/// A mask file that cannot be read.
#[derive(Debug)]
pub struct UnreadMask {
    /// The photo's name.
    pub photo: String,
    /// The file, as a path from the photo folder.
    pub file: String,
    /// The problem with it.
    pub problem: Error,
}

impl UnreadMask {
    /// Returns the edit that records it, so that the photo is not used without its mask.
    pub fn edit(&self) -> MaskEdit {
        MaskEdit::Unread { photo: self.photo.clone(), from: MaskOrigin::File(self.file.clone()) }
    }
}

/// A mask file that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundMask {
    /// The photo's name.
    pub photo: String,
    /// The file, as a path from the photo folder.
    pub file: String,
    /// The masked pixels of the pinhole image.
    pub masked: Spans,
}

impl FoundMask {
    /// Returns the edit that adds the mask to the project.
    pub fn edit(self) -> MaskEdit {
        MaskEdit::Put { photo: self.photo, from: MaskOrigin::File(self.file), masked: self.masked }
    }
}

/// Returns all masks that are beside photos of the site, and the problems with others.
///
/// # Errors
/// Returns [`Error::Input`] and [`Error::Io`] when the cameras cannot be read, or [`Error::Cancelled`].
pub fn masks_beside(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<MasksBeside> {
    let root = resolved(folder, &project.photos);
    let (files, problems) = mask_files(&root, site, task);
    let mut beside = MasksBeside { problems, ..MasksBeside::default() };
    if files.is_empty() {
        return Ok(beside);
    }
    let cameras = cameras(folder, project, task)?;
    for (photo, file) in files {
        task.check_cancelled()?;
        let photo = photo.to_owned();
        match read_whole(&root.join(&file), &cameras[&photo]) {
            Ok(masked) => beside.found.push(FoundMask { photo, file, masked }),
            Err(problem) => beside.unread.push(UnreadMask { photo, file, problem }),
        }
    }
    Ok(beside)
}

/// Returns why a mask file, a path from the photo folder `root`, was not read.
pub fn why_unread(root: &Path, file: &str, photo: &CameraPhoto) -> String {
    match read_whole(&root.join(file), photo) {
        Ok(_) => format!("{file} could not be read when it was found; it can be now"),
        Err(problem) => problem.to_string(),
    }
}

/// A file that may be the mask of a photo.
struct MaskCandidate<'a> {
    photo: &'a str,
    file: String,
    /// How its name differs from the one that was looked for; empty where it does not.
    how: &'static str,
}

/// Finds the mask files of photos, as paths from the photo folder, and the names that several files could have.
fn mask_files<'a>(root: &Path, site: &'a Site, task: &Task) -> (Vec<(&'a str, String)>, Vec<Error>) {
    let mut named = NamedFiles::default();
    let (mut candidates, mut problems): (Vec<MaskCandidate>, Vec<Error>) = Default::default();
    for photo in &site.photos {
        let mut of_photo: BTreeMap<String, &'static str> = BTreeMap::new();
        for name in mask_names(&photo.name) {
            match named.find(root, &name) {
                NamedFile::Missing => {}
                NamedFile::Found(file) => {
                    let how = difference(&name, &file);
                    of_photo.entry(file).and_modify(|known| *known = shorter(known, how)).or_insert(how);
                }
                NamedFile::Several(files) => {
                    let found = format!(
                        "{} files could be {name}: their names differ in Unicode form or letter case",
                        files.len()
                    );
                    problems.push(Error::input(
                        root.join(&files[0]),
                        "",
                        found,
                        "keep one of them, or give it exactly this name",
                    ));
                }
            }
        }
        candidates.extend(of_photo.into_iter().map(|(file, how)| MaskCandidate {
            photo: &photo.name,
            file,
            how,
        }));
    }
    (settled(root, &mut named, candidates, task), problems)
}

fn shorter(one: &'static str, other: &'static str) -> &'static str {
    if one.is_empty() { one } else { other }
}

/// Decides which candidates are used. A file that is exactly the mask of one photo is not that of another one whose name is like it.
fn settled<'a>(
    root: &Path,
    named: &mut NamedFiles,
    candidates: Vec<MaskCandidate<'a>>,
    task: &Task,
) -> Vec<(&'a str, String)> {
    let mut photos: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for MaskCandidate { photo, file, how } in &candidates {
        photos.entry(file).or_default().push((photo, how));
    }
    let mut used = Vec::new();
    for MaskCandidate { photo, file, how } in &candidates {
        let others = || photos[file.as_str()].iter().filter(|(other, _)| other != photo);
        if let Some((other, _)) = others().find(|(_, other)| !how.is_empty() && other.is_empty()) {
            task.note(format!("{photo}: {file} is the mask of {other}, and is not used for this photo"));
            continue;
        }
        if !how.is_empty() {
            task.note(format!("{photo}: its mask was found {how}, as {file}"));
            if let Some((other, _)) = others().next() {
                task.note(format!(
                    "{photo}: {file} masks {other}, too, whose name is nearly the same; to mask one of the two, give the \
                     file exactly its name"
                ));
            }
        }
        let alike = named.look_alikes(root, file);
        for other in alike.iter().filter(|other| !photos.contains_key(other.as_str())) {
            task.note(format!(
                "{photo}: {other} has the name of its mask in another Unicode form; it is not used"
            ));
        }
        used.push((*photo, file.clone()));
    }
    used
}

/// Reads a file as the mask of one photo, whose name may be abbreviated.
///
/// # Errors
/// Returns [`Error::Request`] for a name that matches no photo; otherwise the errors of [`masks_beside`].
pub fn mask_of_file(
    folder: &Path,
    project: &Project,
    site: &Site,
    photo: &str,
    file: &Path,
    task: &Task,
) -> Result<FoundMask> {
    let photo = site.photo(index_of_photo(site, photo)?).name.clone();
    let cameras = cameras(folder, project, task)?;
    let masked = read_whole(file, &cameras[&photo])?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(FoundMask { photo, file: name, masked })
}

/// Reads the cameras by photo name; every photo of the site is among them.
fn cameras(folder: &Path, project: &Project, task: &Task) -> Result<BTreeMap<String, CameraPhoto>> {
    let cameras = cameras_of(folder, project, task)?;
    Ok(cameras.photos.into_iter().map(|photo| (photo.name.clone(), photo)).collect())
}

/// Reads a mask. One that covers the whole photo is rejected, because it is probably inverted.
fn read_whole(file: &Path, photo: &CameraPhoto) -> Result<Spans> {
    let masked = read_undistorted(file, photo)?;
    let all = u64::from(photo.camera.width) * u64::from(photo.camera.height);
    if photo.is_pinhole() && masked.count() == all {
        let remedy = "paint the area to be masked black and the rest white, or remove the file";
        return Err(Error::input(file, "", "it masks the whole photo", remedy));
    }
    Ok(masked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_a_mask_are_those_that_people_give_it() {
        let names = mask_names("nord/1.jpg");
        for name in ["nord/1.mask.png", "nord/1_mask.tif", "nord/1.jpg.mask.png", "masks/nord/1.jpg.png"] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
    }
}
