//! `exports/pixels/`: the pixels of image layers as they were exported, named by their content, so that paint is
//! told from what was there before, even after the stack was built anew or deleted. A layer without paint is a
//! hard link to the stack's own file: it takes no room while that stack is there.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::atomic::write_atomically;
use super::hash::{hash_bytes, hash_file};
use super::inbox::link_or_copy;
use super::layered::Raster;
use super::layered::png::{read_rgba, write_rgba};
use crate::document::export_record::Baseline;
use crate::error::{Error, Result};

/// The folder of the pixels.
#[derive(Debug, Clone)]
pub struct Baselines {
    folder: PathBuf,
}

impl Baselines {
    /// Beside the records in `exports`; the folder need not exist yet.
    pub fn new(exports: &Path) -> Self {
        Self { folder: exports.join("pixels") }
    }

    /// Keeps a file with this BLAKE3. Returns its name here.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn keep_file(&self, file: &Path, hash: &str) -> Result<String> {
        let name = format!("{hash}.png");
        let target = self.folder.join(&name);
        if !self.has(&name) {
            self.make_folder()?;
            let _ = fs::remove_file(&target);
            link_or_copy(file, &target).map_err(Error::io(&target, "keep the exported pixels there"))?;
        }
        Ok(name)
    }

    /// Keeps pixels. Returns the file's name.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn keep_pixels(&self, raster: &Raster) -> Result<String> {
        let mut bytes = Vec::new();
        write_rgba(&mut bytes, raster, None).map_err(Error::io(&self.folder, "encode pixels for it"))?;
        self.keep_bytes(&bytes, "png")
    }

    /// Keeps the bytes of a file with this extension. Returns its name.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn keep_bytes(&self, bytes: &[u8], extension: &str) -> Result<String> {
        let name = format!("{}.{extension}", hash_bytes(bytes));
        if !self.has(&name) {
            self.make_folder()?;
            write_atomically(self.folder.join(&name), bytes)?;
        }
        Ok(name)
    }

    /// The pixels of a layer as they were exported; none when they are no longer kept, or somebody changed the
    /// file.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Input`] when the file is there and cannot be read.
    pub fn pixels(&self, baseline: &Baseline) -> Result<Option<Raster>> {
        if !self.has(&baseline.file) {
            return Ok(None);
        }
        read_rgba(&self.folder.join(&baseline.file), baseline.rect.w, baseline.rect.h).map(Some)
    }

    /// The bytes of a file that was kept; none as with [`Self::pixels`].
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn bytes(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let file = self.folder.join(name);
        if !self.has(name) {
            return Ok(None);
        }
        fs::read(&file).map(Some).map_err(Error::io(&file, "read it"))
    }

    /// Removes what none of `names` names.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn retain(&self, names: &BTreeSet<String>) -> Result<()> {
        if !self.folder.is_dir() {
            return Ok(());
        }
        super::atomic::remove_leftovers(&self.folder)?;
        for entry in fs::read_dir(&self.folder).map_err(Error::io(&self.folder, "read the folder"))? {
            let path = entry.map_err(Error::io(&self.folder, "read the folder"))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if is_name(&name) && !names.contains(&name) {
                fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
            }
        }
        Ok(())
    }

    /// A file of this name is there, and as it was.
    fn has(&self, name: &str) -> bool {
        let hash = name.split('.').next().unwrap_or_default();
        is_name(name) && hash_file(self.folder.join(name)).is_ok_and(|found| found == hash)
    }

    fn make_folder(&self) -> Result<()> {
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))
    }
}

/// The name of a file that is kept here: a hash, and an extension.
fn is_name(name: &str) -> bool {
    let hash = name.split('.').next().unwrap_or_default();
    hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()) && name.matches('.').count() == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::PixelRect;
    use crate::io::layered::Depth;

    fn baseline(file: String) -> Baseline {
        Baseline { file, rect: PixelRect { x: 5, y: 6, w: 3, h: 2 } }
    }

    #[test]
    fn pixels_outlive_the_stack_that_they_were_linked_from() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let raster = Raster::blank(3, 2, Depth::Eight);
        let file = folder.path().join("stack.png");
        write_rgba(fs::File::create(&file).unwrap(), &raster, None).unwrap();
        let linked = baseline(kept.keep_file(&file, &hash_file(&file).unwrap()).unwrap());
        assert_eq!(kept.keep_pixels(&raster).unwrap(), linked.file, "the same content is there once");
        fs::remove_file(&file).unwrap();
        assert_eq!(kept.pixels(&linked).unwrap(), Some(raster));
    }

    #[test]
    fn a_file_that_somebody_changed_is_no_baseline_and_the_next_export_puts_it_right() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let raster = Raster::blank(3, 2, Depth::Sixteen);
        let kept_as = baseline(kept.keep_pixels(&raster).unwrap());
        fs::write(folder.path().join("pixels").join(&kept_as.file), "other").unwrap();
        assert_eq!(kept.pixels(&kept_as).unwrap(), None);
        kept.keep_pixels(&raster).unwrap();
        assert_eq!(kept.pixels(&kept_as).unwrap(), Some(raster));
    }

    #[test]
    fn what_no_record_names_is_removed_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let names = [b"one", b"two"].map(|bytes| kept.keep_bytes(bytes, "icc").unwrap());
        let theirs = folder.path().join("pixels/mine.png");
        fs::write(&theirs, "theirs").unwrap();
        kept.retain(&BTreeSet::from([names[0].clone()])).unwrap();
        assert_eq!(kept.bytes(&names[0]).unwrap().as_deref(), Some(&b"one"[..]));
        assert!(kept.bytes(&names[1]).unwrap().is_none() && theirs.is_file());
    }
}
