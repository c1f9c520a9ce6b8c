//! The dialog for a picture of the view, or a video of the flight.

use std::path::{Path, PathBuf};

use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::geometry::{Pinhole, Pose};
use crate::recipe::views::RequestedView;

/// The options of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// Whether a video of the flight is made rather than a picture of the view.
    pub film: bool,
    /// The folder, as typed.
    pub folder: String,
    /// The name of the video's file, or of the picture without its extension, as typed.
    pub name: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Export {
    /// Returns the path of the file that is made.
    pub fn file(&self) -> PathBuf {
        let name = if self.film { self.name.clone() } else { format!("{}.png", self.name) };
        Path::new(&self.folder).join(name)
    }
}

/// Returns the suggested name, with a number where the folder already has such a file.
fn free_name(folder: &Path, export: &Export) -> String {
    let wanted = Path::new(&export.name);
    let stem = wanted.file_stem().unwrap_or_default().to_string_lossy();
    let ending = wanted.extension().map(|it| format!(".{}", it.to_string_lossy())).unwrap_or_default();
    let name = |number: u32| match number {
        1 => export.name.clone(),
        number => format!("{stem}-{number}{ending}"),
    };
    let of = |name: String| Export { folder: folder.display().to_string(), name, ..export.clone() };
    let is_free = |name: &String| !of(name.clone()).file().exists();
    (1..).map(name).find(is_free).unwrap_or_else(|| export.name.clone())
}

impl State {
    /// Opens the dialog for a picture of the view.
    pub fn ask_still(&mut self) {
        let [width, height] = self.space.size_px();
        // The default size is twice that of the view, with even sides, as video codecs need.
        let size = [width, height].map(|side| (2 * side).min(7680) & !1);
        self.ask_export(Export { film: false, folder: String::new(), name: "view".into(), size });
    }

    /// Opens the dialog for a video of the flight.
    pub fn ask_film(&mut self) {
        let size = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.size));
        let Some(size) = size else { return };
        self.ask_export(Export { film: true, folder: String::new(), name: "flight.mp4".into(), size });
    }

    fn ask_export(&mut self, export: Export) {
        let Some(session) = &self.session else { return };
        let folder = session.folder.join("pictures");
        let name = free_name(&folder, &export);
        self.flights.export = Some(Export { folder: folder.display().to_string(), name, ..export });
    }

    /// Returns the views that an export renders; none where there is no project, and none with a note where the flight
    /// is not possible.
    pub fn views_of(&mut self, export: &Export) -> Option<Vec<RequestedView>> {
        let [width, height] = export.size;
        let view =
            |name: String, (camera, pose): (Pinhole, Pose)| RequestedView { name, camera, pose, photo: None };
        if !export.film {
            let here = (self.space.viewpoint.camera(width, height), self.space.viewpoint.pose);
            return Some(vec![view(export.name.clone(), here)]);
        }
        let session = self.session.as_ref()?;
        let mut path = session.opened.project.flight.clone()?;
        path.resize(export.size);
        match path.flight(session.scene_frame.up) {
            Ok(flight) => {
                let frames = flight.frames(path.fps).into_iter().zip(1..);
                Some(frames.map(|(camera, number)| view(format!("frame-{number:05}"), camera)).collect())
            }
            Err((place, found)) => {
                self.tell(Note::new(Weight::Problem, format!("the flight, {place}: {found}")));
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_a_file_has_is_not_proposed_again() {
        let folder = tempfile::tempdir().unwrap();
        let [still, film] = [(false, "view"), (true, "flight.mp4")].map(|(film, name)| Export {
            film,
            folder: String::new(),
            name: name.into(),
            size: [64, 64],
        });
        let names = || [&still, &film].map(|export| free_name(folder.path(), export));
        assert_eq!(names(), ["view", "flight.mp4"]);
        for file in ["view.png", "view-2.png", "flight.mp4"] {
            std::fs::write(folder.path().join(file), "made").unwrap();
        }
        assert_eq!(names(), ["view-3", "flight-2.mp4"]);
    }
}
