//! The dialog for a picture of the view, or a video of the flight.

use std::path::{Path, PathBuf};

use quadratura_io::film::{EXTENSIONS, kind_of};
use quadratura_views::render::PictureFormat;

/// What is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rendering {
    /// A picture of the view.
    Picture,
    /// A video of the flight.
    Video,
    /// A folder with a picture of each frame of the flight.
    Sequence,
}

/// The options of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// What is rendered.
    pub what: Rendering,
    /// The project's folder.
    pub project: PathBuf,
    /// The folder as typed or chosen; relative paths start at the project folder.
    pub folder: String,
    /// The name of the video's file, of the picture without its extension, or of the sequence, as typed.
    pub name: String,
    /// The format of pictures.
    pub format: PictureFormat,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Whether ffmpeg is installed, which most videos need.
    pub has_ffmpeg: bool,
}

impl Export {
    /// Returns the path of the folder that files are written to; a sequence has a folder of its own.
    pub fn out(&self) -> PathBuf {
        let folder = self.project.join(self.folder.trim());
        if self.what == Rendering::Sequence { folder.join(self.name.trim()) } else { folder }
    }

    /// Returns the path of the file or folder that is made.
    pub fn file(&self) -> PathBuf {
        match self.what {
            Rendering::Picture => self.out().join(format!("{}.{}", self.name, self.format.extension())),
            Rendering::Video => self.out().join(&self.name),
            Rendering::Sequence => self.out(),
        }
    }

    /// Returns the name of a frame, counted from 1, without its extension.
    pub fn frame(&self, number: u32) -> String {
        format!("{}-{number:05}", self.name.trim())
    }

    /// Changes between a video and a sequence; the name is that of the flight in both.
    pub fn make(&mut self, what: Rendering) {
        let stem = Path::new(&self.name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.name = match what {
            Rendering::Video if self.what != what => format!("{stem}.{}", self.video_extension()),
            Rendering::Sequence if self.what == Rendering::Video => stem,
            _ => return,
        };
        self.what = what;
        self.name = free_name(self);
    }

    /// Returns the extension of videos that everybody can play, as far as they can be made here.
    fn video_extension(&self) -> &'static str {
        if self.has_ffmpeg { "mp4" } else { "apng" }
    }

    /// Returns the reason why nothing can be rendered with these options.
    pub fn problem(&self) -> Option<String> {
        if self.folder.trim().is_empty() || self.name.trim().is_empty() {
            return Some("Give a folder and a name.".into());
        }
        if self.what != Rendering::Video {
            return None;
        }
        match kind_of(Path::new(self.name.trim())) {
            Err(_) => Some(format!("A video's name ends with .{}.", EXTENSIONS.join(", ."))),
            Ok("apng") => None,
            Ok(kind) if !self.has_ffmpeg => {
                Some(format!("A .{kind} needs ffmpeg, which is not installed: end the name with .apng."))
            }
            Ok(_) => None,
        }
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

    fn export(what: Rendering, project: &Path, name: &str) -> Export {
        Export {
            what,
            project: project.to_path_buf(),
            folder: ".".into(),
            name: name.into(),
            format: PictureFormat::Png,
            size: [64, 64],
            has_ffmpeg: true,
        }
    }

    #[test]
    fn a_name_that_a_file_has_is_not_proposed_again() {
        let folder = tempfile::tempdir().unwrap();
        let still = export(Rendering::Picture, folder.path(), "view");
        let film = export(Rendering::Video, folder.path(), "flight.mp4");
        let names = || [&still, &film].map(free_name);
        assert_eq!(names(), ["view", "flight.mp4"]);
        for file in ["view.png", "view-2.png", "flight.mp4"] {
            std::fs::write(folder.path().join(file), "made").unwrap();
        }
        assert_eq!(names(), ["view-3", "flight-2.mp4"]);
        assert_eq!(free_name(&Export { format: PictureFormat::Exr, ..still }), "view", "of another format");
    }

    #[test]
    fn a_sequence_has_a_folder_of_its_own_and_the_name_of_the_video() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("flight")).unwrap();
        let mut film = export(Rendering::Video, folder.path(), "flight.mp4");
        film.make(Rendering::Sequence);
        assert_eq!((film.name.as_str(), film.frame(7).as_str()), ("flight-2", "flight-2-00007"));
        assert_eq!(film.out(), folder.path().join(".").join("flight-2"));
        film.make(Rendering::Video);
        assert_eq!(film.name, "flight-2.mp4");
    }

    #[test]
    fn without_ffmpeg_a_video_is_an_animated_png_and_others_say_why_not() {
        let mut film =
            Export { has_ffmpeg: false, ..export(Rendering::Sequence, Path::new("project"), "flight") };
        assert_eq!(film.problem(), None);
        film.make(Rendering::Video);
        assert_eq!((film.name.as_str(), film.problem()), ("flight.apng", None));
        film.name = "flight.mp4".into();
        assert!(film.problem().unwrap().contains("ffmpeg"));
        film.has_ffmpeg = true;
        assert_eq!(film.problem(), None);
        film.name = "flight.avi".into();
        assert!(film.problem().unwrap().contains(".webm"));
    }
}
