//! The values with which the dialog for pictures and videos opens, and the views that it renders.

use std::path::Path;

use super::export::{Export, Rendering, free_name};
use crate::state::State;
use crate::state::notes::{Note, Weight};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_io::film;
use quadratura_sites::views::RequestedView;
use quadratura_views::render::PictureFormat;

impl State {
    /// Opens the dialog for a picture of the view.
    pub fn request_still(&mut self) {
        let [width, height] = self.space.size_px();
        // The default size is twice that of the view, with even sides, as video codecs need.
        let size = [width, height].map(|side| (2 * side).min(7680) & !1);
        self.request_export(Rendering::Picture, "view", size, true);
    }

    /// Opens the dialog for a video of the flight.
    pub fn request_film(&mut self) {
        let size = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.size));
        let Some(size) = size else { return };
        // Without ffmpeg, a video is an animated PNG, which few programs read: pictures are of more use then.
        let has_ffmpeg = film::check(Path::new("flight.mp4")).is_ok();
        let what = if has_ffmpeg { Rendering::Video } else { Rendering::Sequence };
        self.request_export(what, if has_ffmpeg { "flight.mp4" } else { "flight" }, size, has_ffmpeg);
    }

    fn request_export(&mut self, what: Rendering, name: &str, size: [u32; 2], has_ffmpeg: bool) {
        let Some(session) = &self.session else { return };
        let (project, folder) = (session.folder.clone(), "pictures".to_owned());
        let (name, format) = (name.to_owned(), PictureFormat::default());
        let export = Export { what, project, folder, name, format, size, has_ffmpeg };
        self.flights.export = Some(Export { name: free_name(&export), ..export });
    }

    /// Returns the views that an export renders; none where there is no project, and none with a note where the flight
    /// is not possible.
    pub fn views_of(&mut self, export: &Export) -> Option<Vec<RequestedView>> {
        let [width, height] = export.size;
        let view =
            |name: String, (camera, pose): (Pinhole, Pose)| RequestedView { name, camera, pose, photo: None };
        if export.what == Rendering::Picture {
            let here = (self.space.viewpoint.camera(width, height), self.space.viewpoint.pose);
            return Some(vec![view(export.name.clone(), here)]);
        }
        let session = self.session.as_ref()?;
        let mut path = session.opened.project.flight.clone()?;
        path.resize(export.size);
        match path.flight(session.scene_frame.up) {
            Ok(flight) => {
                let frames = flight.frames(path.fps).into_iter().zip(1..);
                Some(frames.map(|(camera, number)| view(export.frame(number), camera)).collect())
            }
            Err((place, found)) => {
                self.notify(Note::new(Weight::Problem, format!("the flight, {place}: {found}")));
                None
            }
        }
    }
}
