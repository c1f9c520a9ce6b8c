//! The views to be rendered: cameras of a file, photos of the project, or a flight.

use std::path::{Path, PathBuf};

use crate::named::index_of_photo;
use crate::open::Opened;
use crate::unknown_name::no_such;
use glam::DVec3;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{Photo, PhotoId, Site, up};
use quadratura_base::task::Task;
use quadratura_document::Bookmark;
use quadratura_document::camera_path::{CameraPath, PathFlaw};
use quadratura_document::names::{file_name_of_photo, picture_names};
use quadratura_import::cameras::{is_camera_file, read_cameras};
use quadratura_io::camera_path::{ReadPath, read_camera_path};
use quadratura_io::photo_list::read_photo_list;
use quadratura_projection::framing::{resized, scaled};
use quadratura_view::flight::Flight;
use quadratura_view::navigation::Viewpoint;

/// The time between two photos of a flight through photos, in seconds.
const SECONDS_A_LEG: f64 = 2.0;

/// The source of views.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ViewSource {
    /// All photos of the project.
    Photos,
    /// A file or folder: cameras of a format that is read here, a list of photos (`.txt`) or a camera path (`.json`).
    At(PathBuf),
    /// A flight through these photos of the project, in this order.
    Through(Vec<String>),
    /// The views of these names that are saved in the project; see [`Opened::views`].
    Saved(Vec<String>),
}

/// A request for views.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewRequest {
    /// The source of the views.
    pub source: ViewSource,
    /// The size of the pictures.
    pub size: Size,
    /// The frame rate of a flight in frames per second; `None` for that of its path.
    pub fps: Option<f64>,
}

/// The project's photos in their own size.
impl Default for ViewRequest {
    fn default() -> Self {
        Self { source: ViewSource::Photos, size: Size::Own, fps: None }
    }
}

/// The size of pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// The camera's own size.
    Own,
    /// This width and height in pixels ([`resized`]).
    Exactly(u32, u32),
    /// The camera's size, scaled by a factor.
    Scaled(f64),
}

impl Size {
    /// Returns `camera` with pictures of this size.
    pub fn resize(self, camera: &Pinhole) -> Pinhole {
        match self {
            Self::Own => *camera,
            Self::Exactly(width, height) => resized(camera, width, height),
            Self::Scaled(scale) => scaled(camera, scale),
        }
    }
}

/// A view to be rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct RequestedView {
    /// The name of the picture without extension, different for all views.
    pub name: String,
    /// The camera: size and K in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The photo of the project with this view, if any.
    pub photo: Option<PhotoId>,
}

/// The requested views.
#[derive(Debug, Default)]
pub struct RequestedViews {
    /// The views in the order of the file, or of time.
    pub list: Vec<RequestedView>,
    /// The camera path of a flight.
    pub path: Option<CameraPath>,
    /// The views that cannot be shown, with the reasons.
    pub problems: Vec<Error>,
}

/// Returns the requested views. A problem with one camera leaves out only that one.
///
/// # Errors
/// Returns [`Error::Input`] and [`Error::Io`] for what concerns all views, or [`Error::Request`] for photos of a
/// flight that do not exist.
pub fn views(site: &Site, asked: &ViewRequest, task: &Task) -> Result<RequestedViews> {
    let ViewRequest { size, fps, .. } = *asked;
    match &asked.source {
        ViewSource::Photos => Ok(of_photos(site, &site.photo_ids().collect::<Vec<_>>(), size)),
        ViewSource::Through(names) => through(site, names, size, fps),
        ViewSource::Saved(_) => {
            Err(Error::Request("saved views belong to a project, not to its site".into()))
        }
        ViewSource::At(path) => match ViewFormat::from_path(path) {
            ViewFormat::Cameras => of_cameras(path, size, task),
            ViewFormat::List => listed(site, path, size),
            ViewFormat::Path => of_path(path, up(&site.photos), size, fps),
        },
    }
}

/// Returns the frames of a camera path; `up` is up where the file says nothing.
fn of_path(path: &Path, up: DVec3, size: Size, fps: Option<f64>) -> Result<RequestedViews> {
    let ReadPath { path, flight, problems } = read_camera_path(path, up)?;
    Ok(RequestedViews { problems, ..of_flight(path, &flight, size, fps)? })
}

impl Opened {
    /// Returns the requested [`views`] of the opened site.
    ///
    /// # Errors
    /// Returns the errors of [`views`].
    pub fn views(&self, asked: &ViewRequest, task: &Task) -> Result<RequestedViews> {
        match &asked.source {
            ViewSource::Saved(names) => saved(&self.project.views, names, asked.size),
            _ => views(&self.site, asked, task),
        }
    }

    /// Returns the requested views, of which cameras and camera paths of files are in the site's frame, as exports write them.
    ///
    /// # Errors
    /// Returns [`Error::Request`] where the site has no frame, and the errors of [`views`].
    pub fn views_in_frame(&self, asked: &ViewRequest, task: &Task) -> Result<RequestedViews> {
        if self.project.frame.is_empty() {
            let found = "the site has no frame, so its cameras are those of the cameras' world";
            return Err(Error::Request(format!("{found}; `quadratura frame` sets one")));
        }
        let ViewSource::At(path) = &asked.source else { return self.views(asked, task) };
        let frame = self.project.frame.frame_from_world();
        let mut views = match ViewFormat::from_path(path) {
            ViewFormat::List => return self.views(asked, task),
            ViewFormat::Cameras => of_cameras(path, asked.size, task)?,
            ViewFormat::Path => of_path(path, frame.rotation * up(&self.site.photos), asked.size, asked.fps)?,
        };
        views.list.iter_mut().for_each(|view| view.pose = frame.pose_before(&view.pose));
        Ok(views)
    }
}

/// The size of pictures of saved views, which have none of their own, in pixels.
const SAVED_PX: (u32, u32) = (1920, 1080);

/// Returns the saved views of these names. Several may have one name: all of them are meant.
fn saved(views: &[Bookmark], names: &[String], size: Size) -> Result<RequestedViews> {
    let known = || views.iter().map(|view| view.name.as_str());
    let unknown = names.iter().filter(|name| known().all(|known| known != **name));
    let errors = unknown.map(|name| no_such("saved view", name, known(), None)).collect();
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    let chosen: Vec<&Bookmark> = views.iter().filter(|view| names.contains(&view.name)).collect();
    let (mut list, mut problems) = (Vec::new(), Vec::new());
    for view in chosen {
        if let Some(problem) = view.problem() {
            problems.push(Error::Request(problem));
            continue;
        }
        let name = free_name(&file_name_of_photo(&view.name), &list);
        let Viewpoint { pose, lens, .. } = view.viewpoint();
        let camera = size.resize(&lens.camera(SAVED_PX.0, SAVED_PX.1));
        list.push(RequestedView { name, camera, pose, photo: None });
    }
    Ok(RequestedViews { list, path: None, problems })
}

/// Returns `name`, or `name-2` and so on where views have it already.
fn free_name(name: &str, list: &[RequestedView]) -> String {
    let is_free = |name: &String| list.iter().all(|view| view.name != *name);
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(is_free).expect("there are more numbers than views")
}

/// The kind of a file or folder of views.
enum ViewFormat {
    Cameras,
    List,
    Path,
}

impl ViewFormat {
    /// Determines the kind: cameras by their content or by COLMAP's names, the others by their extension.
    fn from_path(path: &Path) -> Self {
        if is_camera_file(path) {
            return Self::Cameras;
        }
        match path.extension().unwrap_or_default().to_string_lossy().to_lowercase().as_str() {
            "json" if path.is_file() => Self::Path,
            "txt" if path.is_file() => Self::List,
            _ => Self::Cameras,
        }
    }
}

/// Returns the views of these photos.
fn of_photos(site: &Site, ids: &[PhotoId], size: Size) -> RequestedViews {
    let names: Vec<&str> = ids.iter().map(|&id| site.photo(id).name.as_str()).collect();
    let view = |(&id, name): (&PhotoId, String)| {
        let Photo { camera, pose, .. } = site.photo(id);
        RequestedView { name, camera: size.resize(camera), pose: *pose, photo: Some(id) }
    };
    let list = ids.iter().zip(picture_names(&names)).map(view).collect();
    RequestedViews { list, ..RequestedViews::default() }
}

/// Returns the views of the photos in a list file.
fn listed(site: &Site, file: &Path, size: Size) -> Result<RequestedViews> {
    let mut ids = Vec::new();
    let mut problems = Vec::new();
    for (line, name) in read_photo_list(file)? {
        match index_of_photo(site, &name) {
            Ok(id) if ids.contains(&id) => (),
            Ok(id) => ids.push(id),
            Err(error) => {
                let place = format!("{}, line {line}: ", file.display());
                problems.push(Error::missing(Message::from(place).and(&error)));
            }
        }
    }
    Ok(RequestedViews { problems, ..of_photos(site, &ids, size) })
}

/// Returns the views of a file of cameras. The pictures have no lens distortion, even if the cameras have.
fn of_cameras(path: &Path, size: Size, task: &Task) -> Result<RequestedViews> {
    let cameras = read_cameras(path, task)?;
    cameras.notes.iter().for_each(|note| task.note(note));
    let distorted = cameras.photos.iter().filter(|photo| !photo.lens.is_none()).count();
    if distorted > 0 {
        let (of, count) = (cameras.file.display(), cameras.photos.len());
        task.note(format!(
            "{of}: {distorted} of {count} cameras have lens distortion; their pictures are rendered without \
             it, at the same size and K"
        ));
    }
    let names: Vec<&str> = cameras.photos.iter().map(|photo| photo.name.as_str()).collect();
    let named = cameras.photos.iter().zip(picture_names(&names));
    let list = named
        .map(|(photo, name)| RequestedView {
            name,
            camera: size.resize(&photo.camera),
            pose: photo.pose,
            photo: None,
        })
        .collect();
    Ok(RequestedViews { list, path: None, problems: cameras.problems })
}

/// Returns the frames of a flight through photos.
fn through(site: &Site, names: &[String], size: Size, fps: Option<f64>) -> Result<RequestedViews> {
    let mut cameras = Vec::new();
    let mut errors = Vec::new();
    for name in names {
        match index_of_photo(site, name) {
            Ok(index) => cameras.push((site.photo(index).camera, site.photo(index).pose)),
            Err(error) => errors.push(error),
        }
    }
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    let Some((first, _)) = cameras.first() else {
        return Err(Error::Request("a flight needs at least one photo".into()));
    };
    let frame = size.resize(first);
    let path = CameraPath::through(&cameras, [frame.width, frame.height], SECONDS_A_LEG);
    let flight = path.flight(up(&site.photos)).map_err(refused)?;
    of_flight(path, &flight, Size::Own, fps)
}

/// Converts a camera path's problem to an error.
fn refused((place, found): PathFlaw) -> Error {
    Error::Request(format!("{place}: {found}"))
}

/// Returns the frames of a flight, numbered from 1.
fn of_flight(mut path: CameraPath, flight: &Flight, size: Size, fps: Option<f64>) -> Result<RequestedViews> {
    path.fps = fps.unwrap_or(path.fps);
    path.check_frame_count().map_err(refused)?;
    let frames = flight.frames(path.fps).into_iter().zip(1..);
    let view = |((camera, pose), number): ((Pinhole, Pose), u32)| RequestedView {
        name: format!("frame-{number:05}"),
        camera: size.resize(&camera),
        pose,
        photo: None,
    };
    Ok(RequestedViews { list: frames.map(view).collect(), path: Some(path), problems: Vec::new() })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::Model;
    use quadratura_base::scene::synthetic::{centred, look_at};

    fn site() -> Site {
        let photo = |(name, x): (&str, f64)| Photo {
            name: name.into(),
            camera: centred(64, 48, 50.0),
            pose: look_at(DVec3::new(x, -5.0, 1.0), DVec3::ZERO),
            file: "nowhere".into(),
            masks: Vec::new(),
            exposure: None,
        };
        let photos = [("a.jpg", -1.0), ("b.jpg", 0.0), ("c.jpg", 2.0)].map(photo).into();
        Site { photos, model: Arc::new(Model::default()) }
    }

    fn asked(source: ViewSource, size: Size) -> Result<RequestedViews> {
        views(&site(), &ViewRequest { source, size, fps: None }, &Task::silent())
    }

    fn file(name: &str, text: &str) -> (tempfile::TempDir, ViewSource) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        (folder, ViewSource::At(path))
    }

    fn names(views: &RequestedViews) -> Vec<&str> {
        views.list.iter().map(|view| view.name.as_str()).collect()
    }

    #[test]
    fn all_photos_are_views_named_without_extension() {
        let views = asked(ViewSource::Photos, Size::Scaled(0.5)).unwrap();
        assert_eq!(names(&views), ["a", "b", "c"]);
        assert_eq!(views.list[1].camera, centred(32, 24, 25.0));
        assert_eq!(views.list[1].pose, site().photos[1].pose);
    }

    #[test]
    fn a_list_of_photos_keeps_its_order_and_a_wrong_line_is_left_out() {
        let (_folder, source) = file("list.txt", "c\na.jpg\nz.jpg\nc.jpg\n");
        let views = asked(source, Size::Own).unwrap();
        assert_eq!(names(&views), ["c", "a"]);
        let message: Vec<_> = views.problems.iter().map(ToString::to_string).collect();
        assert!(
            message.len() == 1 && message[0].contains("line 3") && message[0].contains("z.jpg"),
            "{message:?}"
        );
    }

    #[test]
    fn cameras_with_distortion_are_rendered_without_and_a_bad_one_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("cameras.txt", "1 SIMPLE_RADIAL 64 48 50 32 24 -0.1\n2 PINHOLE 0 0 1 1 1 1\n");
        write("images.txt", "1 1 0 0 0 0 0 0 1 x/0001.jpg\n\n2 1 0 0 0 0 0 0 2 0002.jpg\n\n");
        let noted = Arc::new(std::sync::Mutex::new(Vec::new()));
        let sink = noted.clone();
        let task = Task::new(move |event| sink.lock().unwrap().push(format!("{event:?}")));
        let source = ViewSource::At(folder.path().to_path_buf());
        let asked = ViewRequest { source, size: Size::Exactly(128, 96), fps: None };
        let views = views(&site(), &asked, &task).unwrap();
        assert_eq!((names(&views), views.problems.len()), (vec!["x%2F0001"], 2));
        assert_eq!(views.list[0].camera, centred(128, 96, 100.0));
        assert!(
            noted.lock().unwrap().iter().any(|note| note.contains("1 of 1 cameras have lens distortion")),
            "{noted:?}"
        );
    }

    #[test]
    fn a_flight_through_photos_begins_and_ends_at_them_and_its_frames_are_numbered() {
        let photos = ["c", "a"].map(String::from).to_vec();
        let views = asked(ViewSource::Through(photos), Size::Exactly(32, 24)).unwrap();
        let path = views.path.as_ref().unwrap();
        assert_eq!((views.list.len(), path.keyframes.len(), path.size), (51, 2, [32, 24]));
        assert_eq!((names(&views)[0], names(&views)[50]), ("frame-00001", "frame-00051"));
        let center = |view: &RequestedView| view.pose.center_in_world();
        assert!(center(&views.list[0]).distance(DVec3::new(2.0, -5.0, 1.0)) < 1e-9);
        assert!(center(&views.list[50]).distance(DVec3::new(-1.0, -5.0, 1.0)) < 1e-9);
        assert!((views.list[25].camera.fx - 25.0).abs() < 1e-9);
        assert!(asked(ViewSource::Through(vec!["z".into()]), Size::Own).is_err());
    }

    #[test]
    fn a_camera_path_looks_up_as_the_photos_do_and_takes_another_size() {
        let keyframe = r#"{"t": 0, "position": [0, -5, 1], "look_at": [0, 0, 0], "fov": 60}"#;
        let text = format!(r#"{{"version": 1, "size": [64, 48], "keyframes": [{keyframe}]}}"#);
        let (_folder, source) = file("path.json", &text);
        let views = asked(source, Size::Exactly(32, 24)).unwrap();
        let expected = look_at(DVec3::new(0.0, -5.0, 1.0), DVec3::ZERO);
        let forward = |pose: &Pose| pose.rotation.transpose() * DVec3::Z;
        assert!(forward(&views.list[0].pose).distance(forward(&expected)) < 1e-9);
        // The photos' mean up direction differs slightly from the world's z.
        let right = views.list[0].pose.rotation.transpose() * DVec3::X;
        assert!(right.distance(DVec3::X) < 0.02, "{right}");
        assert_eq!((views.list.len(), views.list[0].camera.height), (1, 24));
    }

    #[test]
    fn frames_a_second_that_make_too_many_frames_are_refused_whoever_asks_for_them() {
        let at =
            |t: u32| format!(r#"{{"t": {t}, "position": [{t}, -5, 1], "look_at": [0, 0, 0], "fov": 60}}"#);
        let (first, last) = (at(0), at(40_000));
        let text =
            format!(r#"{{"version": 1, "size": [64, 48], "fps": 0.01, "keyframes": [{first}, {last}]}}"#);
        let (_folder, source) = file("path.json", &text);
        let asked = |fps| {
            views(&site(), &ViewRequest { source: source.clone(), size: Size::Own, fps }, &Task::silent())
        };
        assert_eq!(asked(None).unwrap().list.len(), 401);
        let message = asked(Some(240.0)).unwrap_err().to_string();
        assert!(message.contains("240 frames per second") && message.contains("100000 frames"), "{message}");
    }
}
