//! The dialog for a picture of the view, or a video of the flight.

use std::path::{Path, PathBuf};

/// The options of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// Whether a video of the flight is made rather than a picture of the view.
    pub film: bool,
    /// The project's folder.
    pub project: PathBuf,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// The name of the video's file, or of the picture without its extension, as typed.
    pub name: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Export {
    /// Returns the path of the folder.
    pub fn out(&self) -> PathBuf {
        self.project.join(self.folder.trim())
    }

    /// Returns the path of the file that is made.
    pub fn file(&self) -> PathBuf {
        let name = if self.film { self.name.clone() } else { format!("{}.png", self.name) };
        self.out().join(name)
    }
}

/// Returns the suggested name, with a number where the folder already has such a file.
pub fn free_name(export: &Export) -> String {
    let wanted = Path::new(&export.name);
    let stem = wanted.file_stem().unwrap_or_default().to_string_lossy();
    let ending = wanted.extension().map(|it| format!(".{}", it.to_string_lossy())).unwrap_or_default();
    let name = |number: u32| match number {
        1 => export.name.clone(),
        number => format!("{stem}-{number}{ending}"),
    };
    let of = |name: String| Export { name, ..export.clone() };
    let is_free = |name: &String| !of(name.clone()).file().exists();
    (1..).map(name).find(is_free).unwrap_or_else(|| export.name.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_a_file_has_is_not_proposed_again() {
        let folder = tempfile::tempdir().unwrap();
        let [still, film] = [(false, "view"), (true, "flight.mp4")].map(|(film, name)| Export {
            film,
            project: folder.path().to_path_buf(),
            folder: ".".into(),
            name: name.into(),
            size: [64, 64],
        });
        let names = || [&still, &film].map(free_name);
        assert_eq!(names(), ["view", "flight.mp4"]);
        for file in ["view.png", "view-2.png", "flight.mp4"] {
            std::fs::write(folder.path().join(file), "made").unwrap();
        }
        assert_eq!(names(), ["view-3", "flight-2.mp4"]);
    }
}
