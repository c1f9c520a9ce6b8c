//! The values with which the dialog for pictures and videos opens, and the views that it renders.

use super::export::{Export, free_name};
use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::geometry::{Pinhole, Pose};
use crate::recipe::views::RequestedView;

impl State {
    /// Opens the dialog for a picture of the view.
    pub fn ask_still(&mut self) {
        let [width, height] = self.space.size_px();
        // The default size is twice that of the view, with even sides, as video codecs need.
        let size = [width, height].map(|side| (2 * side).min(7680) & !1);
        self.ask_export(false, "view", size);
    }

    /// Opens the dialog for a video of the flight.
    pub fn ask_film(&mut self) {
        let size = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.size));
        let Some(size) = size else { return };
        self.ask_export(true, "flight.mp4", size);
    }

    fn ask_export(&mut self, film: bool, name: &str, size: [u32; 2]) {
        let Some(session) = &self.session else { return };
        let (project, folder) = (session.folder.clone(), "pictures".to_owned());
        let export = Export { film, project, folder, name: name.to_owned(), size };
        self.flights.export = Some(Export { name: free_name(&export), ..export });
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
