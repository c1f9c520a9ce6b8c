//! The masks of a project on disk: authored images that are never changed.
//!
//! ```text
//! masks/<photo>/suggested-9c1f….png
//! ```
//!
//! A file's name holds a hash of its content. `project.json` names the masks in use: an edit writes new files
//! first and then replaces `project.json`. Files that are no longer named are removed only on request, never
//! by an edit, because undoing the edit needs them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::mask_file::{mask_png, read_mask};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Spans;
use quadratura_document::names::file_name_of_photo;
use quadratura_files::atomic::{remove_leftovers, write_atomically};
use quadratura_files::hash::{hash_bytes, hash_file};

/// Number of hexadecimal digits of the hash in a file's name.
const DIGITS: usize = 12;

/// Maximum length of the readable part of a file's name in bytes, so that the whole stays below the 255 of
/// file systems.
const LONGEST_READABLE: usize = 120;

/// The store of a project's masks. Writers must hold the project's lock.
#[derive(Debug, Clone)]
pub struct MaskStore {
    folder: PathBuf,
}

impl MaskStore {
    /// Returns the store of the project in the folder `project`.
    pub fn new(project: &Path) -> Self {
        Self { folder: project.join("masks") }
    }

    /// Returns the path of a file that `project.json` names.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Reads the masked pixels of a file, which must have the size `size` in pixels.
    ///
    /// # Errors
    /// As [`read_mask`].
    pub fn read(&self, file: &str, size: [u32; 2]) -> Result<Spans> {
        read_mask(&self.path(file), size)
    }

    /// Finds the newest usable mask file from the same maker for a photo, other than `file`, which it can
    /// replace. Returns its name, the number of masked pixels, and when it was written. `stem` is the
    /// beginning of the maker's file names.
    pub fn older(
        &self,
        photo: &str,
        stem: &str,
        file: &str,
        size: [u32; 2],
    ) -> Option<(String, u64, SystemTime)> {
        let folder = self.folder.join(file_name_of_photo(photo));
        let prefix = format!("{}-", readable(stem));
        let candidate = |path: PathBuf| {
            let name = path.file_name()?.to_str()?.to_owned();
            let rest = name.strip_prefix(&prefix)?.strip_suffix(".png")?;
            let candidate = format!("{}/{name}", file_name_of_photo(photo));
            let written = fs::metadata(&path).and_then(|data| data.modified()).ok()?;
            (rest.len() == DIGITS && candidate != file).then_some((written, candidate))
        };
        let mut found: Vec<_> = entries(&folder).ok()?.into_iter().filter_map(candidate).collect();
        found.sort();
        found.into_iter().rev().find_map(|(written, file)| {
            let is_whole = is_ours(&self.path(&file)).unwrap_or(false);
            let pixels = self.read(&file, size).ok().filter(|_| is_whole)?;
            Some((file, pixels.count(), written))
        })
    }

    /// Stores a mask of a photo of size `size` (pixels). Returns the file's name as `project.json` refers to
    /// it, which begins with `stem`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn add(&self, photo: &str, stem: &str, masked: &Spans, size: [u32; 2]) -> Result<String> {
        let folder = self.folder.join(file_name_of_photo(photo));
        let bytes = mask_png(masked, size).map_err(Error::io(&folder, "encode a mask for it"))?;
        let hash = &hash_bytes(&bytes)[..DIGITS];
        let file = format!("{}/{}-{hash}.png", file_name_of_photo(photo), readable(stem));
        let target = self.folder.join(&file);
        if !(target.is_file() && hash_file(&target)?.starts_with(hash)) {
            fs::create_dir_all(&folder).map_err(Error::io(&folder, "create the folder"))?;
            write_atomically(&target, &bytes)?;
        }
        Ok(file)
    }

    /// Removes the files that this program wrote and that are not in `named`, and then empty folders.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn tidy(&self, named: &BTreeSet<String>) -> Result<()> {
        if !self.folder.is_dir() {
            return Ok(());
        }
        for photo in entries(&self.folder)?.iter().filter(|path| path.is_dir()) {
            remove_leftovers(photo)?;
            for file in entries(photo)? {
                let below =
                    file.strip_prefix(&self.folder).unwrap_or(&file).to_string_lossy().replace('\\', "/");
                if !named.contains(&below) && is_ours(&file)? {
                    fs::remove_file(&file).map_err(Error::io(&file, "remove it"))?;
                }
            }
            remove_if_empty(photo)?;
        }
        remove_if_empty(&self.folder)
    }
}

fn readable(stem: &str) -> String {
    let replaced = |c: char| if c.is_control() || "/\\:*?\"<>|".contains(c) { '_' } else { c };
    let mut name: String = stem.strip_suffix(".png").unwrap_or(stem).chars().map(replaced).collect();
    while name.len() > LONGEST_READABLE {
        name.pop();
    }
    name
}

/// Returns whether this program wrote the file unchanged: its name holds the hash of its content.
fn is_ours(file: &Path) -> Result<bool> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let hash = name.strip_suffix(".png").and_then(|stem| stem.rsplit_once('-')).map(|(_, hash)| hash);
    let Some(hash) = hash.filter(|hash| hash.len() == DIGITS) else { return Ok(false) };
    Ok(file.is_file() && hash_file(file)?.starts_with(hash))
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))?;
    let paths = entries.map(|entry| Ok(entry.map_err(Error::io(folder, "read the folder"))?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

fn remove_if_empty(folder: &Path) -> Result<()> {
    if entries(folder)?.is_empty() {
        fs::remove_dir(folder).map_err(Error::io(folder, "remove the empty folder"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;

    fn mask(pixels: u32) -> Spans {
        Spans::of_pixels(PixelRect::of_size(pixels, 1), |_, _| true)
    }

    #[test]
    fn masks_come_back_whatever_photos_and_makers_are_called() {
        let project = tempfile::tempdir().unwrap();
        let store = MaskStore::new(project.path());
        for (photo, stem) in
            [("a.jpg", "drawn"), ("nord/tür 1.jpg", "a/b:c*"), ("..", "é".repeat(200).as_str())]
        {
            let file = store.add(photo, stem, &mask(5), [9, 4]).unwrap();
            let found = store.read(&file, [9, 4]).unwrap();
            assert!(found.minus(&mask(5)).is_empty() && found.count() == 5, "{file}");
            assert_eq!(store.add(photo, stem, &mask(5), [9, 4]).unwrap(), file, "the same is the same file");
        }
    }

    #[test]
    fn for_a_file_that_is_gone_there_is_the_newest_whole_one_of_the_same_maker() {
        let project = tempfile::tempdir().unwrap();
        let store = MaskStore::new(project.path());
        let mut files = Vec::new();
        for (pixels, seconds) in [(2, 10), (3, 20), (4, 30)] {
            let file = store.add("a.jpg", "drawn", &mask(pixels), [9, 4]).unwrap();
            let made = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
            fs::File::options().append(true).open(store.path(&file)).unwrap().set_modified(made).unwrap();
            files.push(file);
        }
        store.add("a.jpg", "suggested", &mask(5), [9, 4]).unwrap();
        let older =
            |file: &str| store.older("a.jpg", "drawn", file, [9, 4]).map(|(file, pixels, _)| (file, pixels));
        assert_eq!(older(&files[2]), Some((files[1].clone(), 3)));
        fs::write(store.path(&files[1]), "cut").unwrap();
        assert_eq!(older(&files[2]), Some((files[0].clone(), 2)));
        assert_eq!(store.older("a.jpg", "drawn", &files[2], [8, 4]), None, "of another size");
        assert_eq!(store.older("b.jpg", "drawn", &files[2], [9, 4]), None);
    }

    #[test]
    fn unnamed_masks_are_removed_and_files_of_others_are_not() {
        let project = tempfile::tempdir().unwrap();
        let store = MaskStore::new(project.path());
        let kept = store.add("a.jpg", "drawn", &mask(2), [9, 4]).unwrap();
        let gone = store.add("a.jpg", "drawn", &mask(3), [9, 4]).unwrap();
        let alone = store.add("b.jpg", "drawn", &mask(3), [9, 4]).unwrap();
        let theirs = project.path().join("masks/a.jpg/mine-0123456789ab.png");
        fs::write(&theirs, "not ours").unwrap();
        store.tidy(&BTreeSet::from([kept.clone()])).unwrap();
        assert!(store.path(&kept).is_file() && theirs.is_file());
        assert!(!store.path(&gone).exists() && !store.path(&alone).parent().unwrap().exists());
        fs::remove_file(&theirs).unwrap();
        store.tidy(&BTreeSet::new()).unwrap();
        assert!(!project.path().join("masks").exists());
    }
}
