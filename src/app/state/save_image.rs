//! The dialog that saves a photo as a layered depth image, or as a page that shows it.

use std::path::PathBuf;

use quadratura_base::scene::PhotoId;

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFormat {
    /// A file with the layered depth image.
    Ldi,
    /// A folder with a page for browsers.
    Page,
}

/// The photos of a layered depth image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageSource {
    /// The photo's layers.
    Stack,
    /// All that the photos of the site know.
    Site,
}

impl ImageSource {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::Stack, Self::Site];

    /// Returns the name for display.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stack => "The layers of this photo",
            Self::Site => "The whole site as all photos show it, with the sky behind",
        }
    }
}

/// The options of the dialog.
#[derive(Debug, Clone, PartialEq)]
pub struct SaveImage {
    /// What is written.
    pub format: ImageFormat,
    /// The project's folder.
    pub project: PathBuf,
    /// The photo.
    pub photo: PhotoId,
    /// Its name.
    pub name: String,
    /// The photos of the image.
    pub source: ImageSource,
    /// The file or folder as typed or chosen; relative paths start at the project folder.
    pub path: String,
    /// Whether occluded areas are not filled, so that views from aside have holes.
    pub is_unfilled: bool,
}

impl SaveImage {
    /// Returns the path of the file or folder.
    pub fn out(&self) -> PathBuf {
        let path = self.project.join(self.path.trim());
        match self.format {
            ImageFormat::Ldi if path.extension().is_none() => path.with_extension("ldi"),
            _ => path,
        }
    }

    /// Returns the reason why nothing can be saved.
    pub fn problem(&self) -> Option<&'static str> {
        let out = self.out();
        match self.format {
            _ if self.path.trim().is_empty() => Some("Choose where to save it."),
            ImageFormat::Ldi if out.is_dir() => Some("This is a folder: add the name of a file."),
            ImageFormat::Page if out.is_file() => Some("This is a file: a page is a folder."),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn dialog(format: ImageFormat, project: &Path, path: &str) -> SaveImage {
        SaveImage {
            format,
            project: project.to_owned(),
            photo: PhotoId::new(0),
            name: "a.jpg".into(),
            source: ImageSource::Stack,
            path: path.into(),
            is_unfilled: false,
        }
    }

    #[test]
    fn a_file_gets_its_ending_and_a_page_is_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path();
        std::fs::write(project.join("file"), "x").unwrap();
        std::fs::create_dir(project.join("folder.ldi")).unwrap();
        let of = |format, path| dialog(format, project, path);
        assert_eq!(of(ImageFormat::Ldi, " a ").out(), project.join("a.ldi"));
        assert_eq!(of(ImageFormat::Ldi, "a.b").out(), project.join("a.b"));
        assert_eq!(of(ImageFormat::Page, "a").out(), project.join("a"));
        let problem = |format, path| of(format, path).problem();
        assert_eq!(problem(ImageFormat::Ldi, "a"), None);
        assert!(problem(ImageFormat::Ldi, "  ").is_some());
        assert!(problem(ImageFormat::Ldi, "folder.ldi").is_some_and(|it| it.contains("folder")));
        assert!(problem(ImageFormat::Page, "file").is_some_and(|it| it.contains("file")));
    }
}
