//! The command `render`: pictures of views, and videos of flights.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use serde::Serialize;

use crate::picture_file::write;
pub use crate::picture_file::{DrawnPicture, PictureFormat};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_io::film::{Film, VideoFormat};
use quadratura_io::picture_png::{WrittenPicture, make_folder};
use quadratura_sites::legend_picture::draw_legend;
use quadratura_sites::views::RequestedView;
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::legend::Legend;
use quadratura_view::{Blend, DisplayMode, Exposure, Picture, Quality, Shot, TreeMethod, Unseen};

/// The stage that is reported for drawing one view.
pub const STAGE_DRAW: &str = "picture";
/// The stage that is reported for writing one picture.
pub const STAGE_WRITE: &str = "write picture";
/// The stage that is reported for all views together.
pub const STAGE: &str = "render";

/// The number of pictures that may wait for being written while drawing continues.
const WAITING: usize = 2;

/// The appearance of views: everything in a [`Shot`] except the camera.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Appearance {
    /// The method by which photos are blended.
    pub blend: Blend,
    /// The quality of texture filtering.
    pub quality: Quality,
    /// The quantity that is displayed.
    pub display: DisplayMode,
    /// The exposure of the pictures.
    pub exposure: Exposure,
    /// Whether surfaces are flat, without the depth detail estimated from the photos.
    pub flat: bool,
    /// Whether back faces, which no photo textures, are left out.
    pub without_backs: bool,
    /// The photos that are not used.
    pub without: Vec<PhotoId>,
    /// The faces that are left out.
    pub hidden: HiddenFaces,
    /// How trees are drawn.
    pub trees: TreeMethod,
    /// Whether nothing is drawn where no surface is, instead of the photos' surroundings.
    pub without_surroundings: bool,
    /// Whether pictures are drawn as finely as the photos show what is in them, and reduced.
    pub supersampled: bool,
    /// What is drawn where no photo shows what is there.
    pub unseen: Unseen,
}

impl Appearance {
    /// Returns the faces that rays skip, as pictures do.
    pub fn culling(&self) -> quadratura_view::hidden::Culling<'_> {
        quadratura_view::hidden::Culling { backs: !self.without_backs, hidden: &self.hidden }
    }

    /// Returns the shot of a camera.
    pub fn shot(&self, camera: Pinhole, pose: Pose) -> Shot {
        Shot {
            blend: self.blend,
            quality: self.quality,
            display: self.display,
            exposure: self.exposure,
            relief: !self.flat,
            backs: !self.without_backs,
            without: self.without.clone(),
            hidden: self.hidden.clone(),
            trees: self.trees,
            surroundings: !self.without_surroundings,
            // Colours of legends are not mixed more than they must be.
            unseen: self.unseen,
            supersampled: self.supersampled && self.display == DisplayMode::Colour,
            ..Shot::new(camera, pose)
        }
    }
}

/// A function that draws the picture of a view, in linear light where the format of the pictures asks for that.
pub type Draw<'a> = dyn FnMut(&RequestedView, &Task) -> Result<DrawnPicture> + 'a;

/// Options of [`render`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderOptions {
    /// The folder for the pictures, which is created if necessary.
    pub out: PathBuf,
    /// The format of the pictures.
    pub format: PictureFormat,
    /// The options of a video of all views; `None` for no video.
    pub film: Option<VideoOptions>,
    /// Whether only the video is written and no pictures. It has no effect without a video.
    pub film_alone: bool,
    /// The legend that is drawn into each picture of 8 bits a channel.
    pub legend: Option<Legend>,
    /// Whether each picture has two of the view's size side by side, for the left eye and the right one.
    pub stereo: bool,
    /// Whether pixels that show nothing, which have alpha 0, keep the grey of legends. Otherwise they are black, which is
    /// what viewers show that ignore alpha.
    pub grey: bool,
}

/// Options of a video.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoOptions {
    /// The video file; its extension determines the format.
    pub file: PathBuf,
    /// The frame rate in frames per second.
    pub fps: f64,
    /// The sRGB colour behind untextured pixels.
    pub background: [u8; 3],
}

/// 25 frames per second over black; the file has to be given.
impl Default for VideoOptions {
    fn default() -> Self {
        Self { file: PathBuf::new(), fps: 25.0, background: [0; 3] }
    }
}

/// The result for one view.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderedView {
    /// The name of the view.
    pub view: String,
    /// The picture's file.
    pub path: PathBuf,
    /// Files that were not overwritten, because they were made or changed by hand.
    pub spared: Vec<PathBuf>,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The share of the picture that is textured, 0..=1.
    pub textured: f64,
}

/// The results for all views, in their order.
#[derive(Debug, Default)]
pub struct RenderReport {
    /// The pictures that were written.
    pub done: Vec<RenderedView>,
    /// The views that failed, with the reason.
    pub failed: Vec<(String, Error)>,
    /// The video, if one was requested and could be made.
    pub film: Option<PathBuf>,
}

/// Draws the views one after the other and writes them as pictures (alpha is the textured share of a pixel), as a video, or
/// both. An error in one view is in [`RenderReport::failed`] and does not stop the others.
///
/// # Errors
/// Returns [`Error::Request`] for a video of pictures of different sizes or of a format that cannot be made,
/// [`Error::Io`] when the folder cannot be created, or [`Error::Cancelled`].
pub fn render(
    views: &[RequestedView],
    draw: &mut Draw,
    options: &RenderOptions,
    task: &Task,
) -> Result<RenderReport> {
    let film = options.film.as_ref().map(|film| started(film, views, options.stereo)).transpose()?;
    if !options.only_film() {
        make_folder(&options.out)?;
    }
    let writer = PictureWriter { options, film, report: RenderReport::default(), task };
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(WAITING);
        let written = scope.spawn(move || writer.run(&receiver));
        let drawn = draw_all(views, draw, &sender, task);
        drop(sender);
        let report = written.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        drawn.and(report)
    })
}

impl RenderOptions {
    fn only_film(&self) -> bool {
        self.film_alone && self.film.is_some()
    }
}

/// A view with its picture, or why there is none.
type DrawnView<'a> = (&'a RequestedView, Result<DrawnPicture>);

/// Draws all views and sends the pictures to the writer.
fn draw_all<'a>(
    views: &'a [RequestedView],
    draw: &mut Draw,
    sender: &SyncSender<DrawnView<'a>>,
    task: &Task,
) -> Result<()> {
    for (done, view) in (0..).zip(views) {
        task.step(STAGE, done, views.len() as u64)?;
        let of_view = task.with_subject(&view.name);
        let picture = of_view.timed(STAGE_DRAW, || draw(view, &of_view));
        if let Err(Error::Cancelled) = picture {
            return Err(Error::Cancelled);
        }
        // The writer has stopped and reports the reason itself.
        if sender.send((view, picture)).is_err() {
            break;
        }
    }
    task.step(STAGE, views.len() as u64, views.len() as u64)
}

/// Starts a video for views of equal size; with `stereo` its frames have two side by side.
fn started(film: &VideoOptions, views: &[RequestedView], stereo: bool) -> Result<Film> {
    let size = |view: &RequestedView| (view.camera.width, view.camera.height);
    let Some((width, height)) = views.first().map(size) else {
        return Err(Error::Request("there are no frames for a video".into()));
    };
    if let Some(other) = views.iter().find(|view| size(view) != (width, height)) {
        let (w, h) = size(other);
        return Err(Error::Request(format!(
            "a video has one size, but {} is {width} x {height} and {} is {w} x {h}; give --size",
            views[0].name, other.name
        )));
    }
    make_folder(film.file.parent().unwrap_or(&film.file))?;
    let width = if stereo { 2 * width } else { width };
    Film::create(&film.file, VideoFormat { width, height, fps: film.fps, frames: views.len() as u32 })
}

/// The thread that writes the drawn pictures.
struct PictureWriter<'a> {
    options: &'a RenderOptions,
    /// The video in progress; `None` after it failed.
    film: Option<Film>,
    report: RenderReport,
    task: &'a Task,
}

impl PictureWriter<'_> {
    /// Writes all pictures that arrive.
    fn run(mut self, pictures: &Receiver<DrawnView>) -> Result<RenderReport> {
        while let Ok((view, picture)) = pictures.recv() {
            self.task.check_cancelled()?;
            let written = picture.and_then(|mut picture| {
                let textured = picture.textured();
                if let (Some(legend), DrawnPicture::Bytes(picture)) = (&self.options.legend, &mut picture) {
                    draw_legend(picture, legend);
                }
                if self.film.is_some() {
                    self.project(&picture.clone().into_bytes());
                }
                if !self.options.grey {
                    picture.blacken();
                }
                let write = || -> Result<RenderedView> {
                    let (size, placed) = write(&self.options.out, &view.name, self.options.format, picture)?;
                    let WrittenPicture { path, spared } = placed;
                    let (view, [width, height]) = (view.name.clone(), size);
                    Ok(RenderedView { view, path, spared, width, height, textured })
                };
                let wanted = !self.options.only_film();
                wanted.then(|| self.task.with_subject(&view.name).timed(STAGE_WRITE, write)).transpose()
            });
            match written {
                Ok(None) => (),
                Ok(Some(rendered)) => {
                    note_spared(&rendered, &self.task.with_subject(&view.name));
                    self.report.done.push(rendered);
                }
                Err(error) => self.report.failed.push((view.name.clone(), error)),
            }
        }
        self.finish()
    }

    /// Adds a picture to the video.
    fn project(&mut self, picture: &Picture) {
        let (Some(film), Some(options)) = (&mut self.film, &self.options.film) else { return };
        if let Err(error) = film.add(&picture.over(options.background)) {
            self.report.failed.push(("film".into(), error));
            self.film = None;
        }
    }

    /// Finishes the video, or discards it if frames are missing.
    fn finish(mut self) -> Result<RenderReport> {
        self.task.check_cancelled()?;
        if let (Some(film), Some(options)) = (self.film.take(), &self.options.film) {
            let whole = self.report.failed.is_empty();
            match if whole { film.finish() } else { Err(unfinished(&options.file)) } {
                Ok(()) => self.report.film = Some(options.file.clone()),
                Err(error) => self.report.failed.push(("film".into(), error)),
            }
        }
        Ok(self.report)
    }
}

/// Makes the error for a video with missing frames.
fn unfinished(file: &Path) -> Error {
    Error::Request(format!("{}: not written, because frames of it are missing", file.display()))
}

/// Notes files that were not overwritten.
fn note_spared(rendered: &RenderedView, task: &Task) {
    for file in &rendered.spared {
        let (old, new) = (file.display(), rendered.path.display());
        task.note(format!("{old} was changed by another program and is kept; this picture is {new}"));
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use quadratura_base::scene::synthetic::centred;
    use quadratura_view::LinearPicture;

    /// Returns each view in one grey level, which counts the views; the `broken`th cannot be drawn.
    fn shades(broken: Option<u8>) -> impl FnMut(&RequestedView, &Task) -> Result<DrawnPicture> {
        let mut drawn = 0;
        move |view, _| {
            drawn += 1;
            if broken == Some(drawn) {
                return Err(Error::Gpu("out of memory".into()));
            }
            let (width, height) = (view.camera.width, view.camera.height);
            let pixel = [drawn, drawn, drawn, 51];
            Ok(Picture { width, height, rgba: pixel.repeat((width * height) as usize) }.into())
        }
    }

    fn view(name: &str, width: u32) -> RequestedView {
        let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        RequestedView { name: name.into(), camera: centred(width, 6, 7.0), pose, photo: None }
    }

    fn rendered(
        views: &[RequestedView],
        broken: Option<u8>,
        film: bool,
    ) -> (tempfile::TempDir, Result<RenderReport>) {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let file = folder.path().join("films/film.apng");
        let film = film.then_some(VideoOptions { file, fps: 5.0, background: [100; 3] });
        let options = RenderOptions { out, film, ..RenderOptions::default() };
        let report = render(views, &mut shades(broken), &options, &Task::silent());
        (folder, report)
    }

    #[test]
    fn every_view_becomes_a_picture_and_all_of_them_a_film() {
        let (folder, report) = rendered(&[view("a", 8), view("b", 8)], None, true);
        let report = report.unwrap();
        assert_eq!(report.done.iter().map(|done| done.view.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        assert!((report.done[0].textured - 0.2).abs() < 1e-12);
        let second = image::open(folder.path().join("out/b.png")).unwrap().to_rgba8();
        assert_eq!((second.dimensions(), second.get_pixel(0, 0).0), ((8, 6), [2, 2, 2, 51]));
        assert_eq!(report.film, Some(folder.path().join("films/film.apng")));
        let first = image::open(report.film.unwrap()).unwrap().to_rgb8();
        assert_eq!(first.get_pixel(0, 0).0, [80; 3], "a fifth of 1 over four fifths of 100");
    }

    #[test]
    fn pictures_are_written_in_each_format_and_a_film_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let views = [view("a", 8)];
        let mut draw = |_: &RequestedView, _: &Task| {
            let rgba = vec![[0.5, 0.25, 4.0, 1.0]; 48];
            Ok(LinearPicture { width: 8, height: 6, rgba, depths: Some(vec![3.0; 48]) }.into())
        };
        for (format, file) in
            [(PictureFormat::Png, "a.png"), (PictureFormat::Png16, "a.png"), (PictureFormat::Exr, "a.exr")]
        {
            let out = folder.path().join(format!("{format:?}"));
            let film = Some(VideoOptions { file: out.join("film.apng"), fps: 5.0, background: [0; 3] });
            let options = RenderOptions { out: out.clone(), format, film, ..RenderOptions::default() };
            let report = render(&views, &mut draw, &options, &Task::silent()).unwrap();
            assert_eq!(report.done[0].path, out.join(file));
            assert_eq!((report.done[0].textured, report.film.is_some()), (1.0, true));
        }
        let red = |format: &str| {
            image::open(folder.path().join(format).join("a.png")).unwrap().to_rgba16().get_pixel(0, 0).0[0]
        };
        assert_eq!([red("Png"), red("Png16")], [188 * 257, 48192]);
    }

    #[test]
    fn what_is_not_covered_is_transparent_black_or_keeps_the_grey_of_legends() {
        for (grey, expected) in [(false, [0; 4]), (true, [128, 128, 128, 0])] {
            let folder = tempfile::tempdir().unwrap();
            let mut draw = |view: &RequestedView, _: &Task| {
                let (width, height) = (view.camera.width, view.camera.height);
                let mut rgba = [128, 128, 128, 0].repeat((width * height) as usize);
                rgba[4..8].copy_from_slice(&[9, 8, 7, 1]);
                Ok(Picture { width, height, rgba }.into())
            };
            let options = RenderOptions { out: folder.path().into(), grey, ..RenderOptions::default() };
            render(&[view("a", 60)], &mut draw, &options, &Task::silent()).unwrap();
            let picture = image::open(folder.path().join("a.png")).unwrap().to_rgba8();
            assert_eq!(picture.get_pixel(0, 0).0, expected);
            assert_eq!(picture.get_pixel(1, 0).0, [9, 8, 7, 1], "what is hardly covered keeps its colour");
        }
    }

    #[test]
    fn a_film_alone_leaves_no_pictures_of_its_frames() {
        let folder = tempfile::tempdir().unwrap();
        let (out, file) = (folder.path().join("out"), folder.path().join("out/film.apng"));
        let film = Some(VideoOptions { file: file.clone(), fps: 5.0, background: [0; 3] });
        let options = RenderOptions { out: out.clone(), film, film_alone: true, ..RenderOptions::default() };
        let views = [view("a", 8), view("b", 8)];
        let report = render(&views, &mut shades(None), &options, &Task::silent()).unwrap();
        assert_eq!((report.film, report.done.len(), report.failed.len()), (Some(file), 0, 0));
        assert_eq!(std::fs::read_dir(out).unwrap().count(), 1);
    }

    #[test]
    fn a_view_that_fails_is_told_and_the_others_go_on_but_a_film_needs_all() {
        let (folder, report) = rendered(&[view("a", 8), view("b", 8), view("c", 8)], Some(2), true);
        let report = report.unwrap();
        assert_eq!(report.done.len(), 2);
        let failed: Vec<_> = report.failed.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(failed, ["b", "film"]);
        assert!(!folder.path().join("films/film.apng").exists() && folder.path().join("out/c.png").exists());
    }

    #[test]
    fn a_film_of_two_sizes_is_refused_before_anything_is_drawn() {
        let (folder, report) = rendered(&[view("a", 8), view("b", 9)], None, true);
        let message = report.unwrap_err().to_string();
        assert!(message.contains("--size") && message.contains("9 x 6"), "{message}");
        assert!(!folder.path().join("out").exists());
    }

    #[test]
    fn whoever_asks_to_stop_gets_no_film() {
        let folder = tempfile::tempdir().unwrap();
        let task = Task::silent();
        task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        let options = RenderOptions { out: folder.path().join("out"), ..RenderOptions::default() };
        let stopped = render(&[view("a", 8)], &mut shades(None), &options, &task);
        assert!(matches!(stopped, Err(Error::Cancelled)));
    }
}
