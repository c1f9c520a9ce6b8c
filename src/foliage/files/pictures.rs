//! The files beside a plant's file: other sub-objects and pictures, none of them outside of its folder.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::tokens::quoted;
use crate::Pixels;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoPixels;
use quadratura_base::scene::alike::difference;
use quadratura_files::named_file::{NamedFile, NamedFiles};
use quadratura_files::text::decoded;
use quadratura_import::photo::{picture_size, read_photo};

/// The largest side of a picture in pixels.
pub const LONGEST_SIDE: u32 = 16_384;

/// The folder of a plant.
pub struct Folder {
    path: PathBuf,
    /// The same without links.
    itself: PathBuf,
    pictures: FxHashMap<PathBuf, Arc<Pixels>>,
    named: NamedFiles,
    /// What is told once about names and texts, in order.
    notes: BTreeSet<String>,
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
        Ok(Self {
            path,
            itself,
            pictures: FxHashMap::default(),
            named: NamedFiles::default(),
            notes: BTreeSet::new(),
        })
    }

    /// Returns the file of a name in or below the folder, by its text and after resolving links; `None` for others. The
    /// file need not exist. One that is spelled differently on the disk is noted.
    pub fn file(&mut self, name: &str) -> Option<PathBuf> {
        let is_plain = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        let plain = name.replace('\\', "/");
        if plain.is_empty() || plain.contains([':', '\0']) || !Path::new(&plain).components().all(is_plain) {
            return None;
        }
        let file = match self.named.find(&self.path, &plain) {
            NamedFile::Missing => self.path.join(plain),
            NamedFile::Found(found) => {
                if found != plain {
                    let how = difference(&plain, &found);
                    self.notes
                        .insert(format!("{}: {name} was found {how}", self.path.join(&found).display()));
                }
                self.path.join(found)
            }
            NamedFile::Several(files) => {
                let folder = self.path.display();
                self.notes.insert(format!("{folder}: several files could be {name}: {}", files.join(", ")));
                self.path.join(plain)
            }
        };
        match file.canonicalize() {
            Ok(itself) if !itself.starts_with(&self.itself) => None,
            _ => Some(file),
        }
    }

    /// Returns the text of a file that was read. One that is not UTF-8 is noted.
    ///
    /// # Errors
    /// [`Error::Input`] for text in UTF-16.
    pub fn decoded(&mut self, file: &Path, bytes: &[u8]) -> Result<String> {
        let (text, guess) =
            decoded(bytes).map_err(|(found, remedy)| Error::input(file, "", found, remedy))?;
        if let Some(guess) = guess {
            let (file, guess) = (file.display(), guess.name());
            self.notes.insert(format!("{file}: it is not UTF-8; it is read as {guess}, which is a guess"));
        }
        Ok(text.into_owned())
    }

    /// Returns what is told about names and texts.
    pub fn notes(&self) -> &BTreeSet<String> {
        &self.notes
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
