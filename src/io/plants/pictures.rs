//! The files beside a plant's file: other sub-objects and pictures, none of them outside of its folder.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::tokens::quoted;
use crate::error::{Error, Result};
use crate::foliage::Pixels;
use crate::io::photo::{picture_size, read_photo};
use crate::scene::PhotoPixels;

/// The largest side of a picture in pixels.
pub const LONGEST_SIDE: u32 = 16_384;

/// The folder of a plant.
pub struct Folder {
    path: PathBuf,
    /// The same without links.
    itself: PathBuf,
    pictures: FxHashMap<PathBuf, Arc<Pixels>>,
}

impl Folder {
    /// Opens the folder of a file.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn of(file: &Path) -> Result<Self> {
        let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
        let path = parent.unwrap_or(Path::new(".")).to_path_buf();
        let itself = path.canonicalize().map_err(Error::io(&path, "find the folder"))?;
        Ok(Self { path, itself, pictures: FxHashMap::default() })
    }

    /// Returns the file of a name in or below the folder, by its text and after resolving links; `None` for others. The
    /// file need not exist.
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        let is_plain = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if name.is_empty() || name.contains(['\\', ':', '\0']) || !Path::new(name).components().all(is_plain)
        {
            return None;
        }
        let file = self.path.join(name);
        match file.canonicalize() {
            Ok(itself) if !itself.starts_with(&self.itself) => None,
            _ => Some(file),
        }
    }

    /// Reads a picture once.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Input`] about the picture.
    pub fn picture(&mut self, file: &Path) -> Result<Arc<Pixels>> {
        if let Some(known) = self.pictures.get(file) {
            return Ok(known.clone());
        }
        let [width, height] = picture_size(file)?;
        if width > LONGEST_SIDE || height > LONGEST_SIDE {
            let found = format!(
                "{width} x {height} pixels, but pictures of plants have at most {LONGEST_SIDE} a side"
            );
            return Err(Error::input(file, "", found, "make it smaller"));
        }
        let photo = read_photo(file, width, height)?;
        let pixels = Arc::new(pixels_of(&photo));
        self.pictures.insert(file.to_path_buf(), pixels.clone());
        Ok(pixels)
    }

    /// Reads the picture of a name in or below the folder.
    ///
    /// # Errors
    /// What was found, where the name is foreign or has no file; otherwise the errors about the picture.
    pub fn named_picture(&mut self, name: &str) -> Result<Arc<Pixels>, PictureFault> {
        let file = self.file(name);
        let foreign = || format!("the picture {} is outside of the plant's folder", quoted(name));
        let file = file.ok_or_else(|| PictureFault::Name(foreign()))?;
        if !file.is_file() {
            let found = format!("there is no picture {} in the plant's folder", quoted(name));
            return Err(PictureFault::Name(found));
        }
        self.picture(&file).map_err(PictureFault::File)
    }
}

/// Why a picture cannot be used.
pub enum PictureFault {
    /// Its name is wrong, as this says.
    Name(String),
    /// The file itself is.
    File(Error),
}

/// Returns a picture in 8 bits.
pub fn pixels_of(photo: &PhotoPixels) -> Pixels {
    let (width, height) = (photo.width, photo.height);
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgba = places.map(|(x, y)| photo.rgba16(x, y).map(|sample| (sample / 257) as u8)).collect();
    Pixels::new(width, height, rgba)
}
