//! Missing parts of a project, and where they may be now.

use std::path::{Path, PathBuf};

use super::place::PathField;
use quadratura_sites::discover::{SitePart, SiteParts};
use quadratura_sites::relink::guess;

/// The missing parts of a project, and their possible new paths.
#[derive(Debug, Clone)]
pub struct Relinking {
    /// The folder of the project.
    pub folder: PathBuf,
    /// The paths of its parts before.
    pub was: SiteParts,
    /// The paths in the order of [`SitePart::ALL`]; a part that is not missing has its current path.
    pub places: [PathField; 3],
    /// The parts that are missing.
    pub asked: Vec<SitePart>,
    /// The parts whose new paths were guessed and not confirmed.
    pub guessed: Vec<SitePart>,
    /// The photos that are missing in the photos' folder.
    pub photos: Vec<String>,
    /// The errors of what was tried.
    pub errors: Vec<String>,
}

impl Relinking {
    /// Makes the dialog for missing parts: the project cannot be opened.
    pub fn of_parts(folder: PathBuf, was: SiteParts, gone: &[SitePart]) -> Self {
        let mut relinking = Self::new(folder, was, gone.to_vec(), Vec::new());
        relinking.guess_others(&[]);
        relinking
    }

    /// Makes the dialog for single missing photos of an open project.
    pub fn of_photos(folder: PathBuf, was: SiteParts, photos: Vec<String>) -> Self {
        Self::new(folder, was, vec![SitePart::Photos], photos)
    }

    fn new(folder: PathBuf, was: SiteParts, asked: Vec<SitePart>, photos: Vec<String>) -> Self {
        let place = |part: SitePart| {
            let mut place = PathField { searched: true, ..PathField::default() };
            if !asked.contains(&part) || !photos.is_empty() {
                place.set(was.path(part));
            }
            place
        };
        let places = SitePart::ALL.map(place);
        Self { folder, was, places, asked, guessed: Vec::new(), photos, errors: Vec::new() }
    }

    /// Returns the new paths of the parts.
    pub fn parts(&self) -> SiteParts {
        let [photos, cameras, model] = [0, 1, 2].map(|part: usize| self.places[part].path());
        SiteParts { photos, cameras, model }
    }

    /// Sets the new path of a part; the others are guessed from it.
    pub fn found(&mut self, part: SitePart, path: &Path) {
        self.places[part as usize].set(path);
        self.settled(part);
    }

    /// Takes a path that was typed; the others are guessed from it.
    pub fn settled(&mut self, part: SitePart) {
        self.guessed.retain(|other| *other != part);
        let moved = (self.was.path(part).to_path_buf(), self.places[part as usize].path());
        if moved.0 != moved.1 && moved.1.exists() {
            self.guess_others(&[moved]);
        }
    }

    /// Guesses the paths of parts that the user has not located.
    fn guess_others(&mut self, moved: &[(PathBuf, PathBuf)]) {
        let project = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        for part in self.asked.clone() {
            let place = &mut self.places[part as usize];
            if !place.typed.is_empty() && !self.guessed.contains(&part) {
                continue;
            }
            if let Some(path) = guess(self.was.path(part), moved, &project, Path::exists) {
                place.set(&path);
                self.guessed.retain(|other| *other != part);
                self.guessed.push(part);
            }
        }
    }
}
