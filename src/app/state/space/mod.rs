//! The 3D view: its viewpoint, its display options, and the newest picture.

mod apart;
pub mod brush;
pub mod exploded;
mod flying;
pub mod images;
mod images_status;
pub mod measure;
pub mod memory;
pub mod pace;
pub mod picking;
pub mod picture;
pub mod scene;
mod showing;
pub mod travel;
pub mod view_pixel;
pub mod visibility;

use std::time::Duration;

use self::brush::{SpaceBrush, UnseenStroke};
use self::exploded::Exploded;
use self::images::{DrawnFrom, SpaceImages};
use self::measure::MeasuringTool;
use self::pace::DrawingPace;
use self::picture::{NewestPicture, PaintedPicture, PictureRequest};
use self::travel::Travel;
use self::visibility::ModelVisibility;
use super::session::Session;
use crate::state::model_suggestions::EdgeGrip;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_images::live::LiveOptions;
use quadratura_view::flight::FrameLens;
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::navigation::Viewpoint;
use quadratura_view::{DisplayMode, Quality, Shot};
use quadratura_views::render::Appearance;

/// The time without a change after which the view is drawn in final quality, in seconds.
const RESTS_S: f64 = 0.25;
/// The number of pictures of before strokes that are kept for their undo.
const BEFORE_STROKES: usize = 3;
/// The time that trees may take in a picture of a moving view: more than half of that of all of it ([`DrawingPace`]).
const TREES_WITHIN: Duration = Duration::from_millis(30);
/// The time for which a picture may be another one than is asked for before the view says so, in seconds: a moving view
/// is always one picture behind.
const BEHIND_S: f64 = 0.3;
/// The vertical field of view of a free viewpoint, in radians: 45 degrees, close to that of photos.
const FIELD_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Facts that the view reports with each frame that it draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameFacts {
    /// The background colour, sRGB.
    pub background: [u8; 3],
    /// Whether the view moves.
    pub moves: bool,
}

/// The state of the 3D view: viewpoint, display options, and the newest picture.
pub struct SpaceView {
    /// The name of the device that draws the view; none while no renderer runs.
    pub device: Option<String>,
    /// The current viewpoint.
    pub viewpoint: Viewpoint,
    /// The blending of photos, and the display mode.
    pub look: Appearance,
    /// The objects and surfaces that are shown.
    pub visibility: ModelVisibility,
    /// The exploded view.
    pub exploded: Exploded,
    /// The brush.
    pub brush: SpaceBrush,
    /// The measuring tool.
    pub measure: MeasuringTool,
    /// The edge of a suggestion under the pointer.
    pub grip: EdgeGrip,
    /// Layered depth images, from which the view may be drawn.
    pub images: SpaceImages,
    /// Whether the legend is shown.
    pub legend_shown: bool,
    /// Whether outlines of faces are drawn.
    pub wireframe: bool,
    /// Whether cameras are drawn.
    pub cameras: bool,
    /// Whether the photo that the view looks through is drawn over it.
    pub photo_over: bool,
    /// The opacity of that photo, 0 to 1.
    pub photo_opacity: f32,
    /// The share of the view's width, from the left, in which the photo is drawn.
    pub wipe: f32,
    /// The photo that the view looks through.
    through: Option<PhotoId>,
    /// The viewpoint before the flight into a photo.
    back: Option<Viewpoint>,
    travel: Option<Travel>,
    /// The time at which the last flight ended, in seconds of the window's clock.
    landed_s: Option<f64>,
    shown: Option<NewestPicture>,
    /// Pictures of before strokes of the brush, oldest first, with these strokes.
    before_strokes: Vec<(Vec<UnseenStroke>, NewestPicture)>,
    asked: Option<PictureRequest>,
    /// The number of changes of the project's content that pictures have to show.
    revision: u64,
    /// The time since which the picture has not been what is asked for, in seconds of the window's clock.
    behind_s: Option<f64>,
    /// Whether the content of photos has changed since the last request for a picture.
    stirred: bool,
    pace: DrawingPace,
    /// The time of the last change of the view, in seconds of the window's clock.
    changed_s: f64,
    /// The size of the view in pixels, as it was drawn last.
    size_px: [u32; 2],
    hovered: Option<FaceId>,
    /// The reason why nothing can be drawn.
    pub trouble: Option<String>,
    /// The reason that a note has already reported.
    message: Option<String>,
}

impl Default for SpaceView {
    fn default() -> Self {
        use glam::DVec3;
        let scene_frame =
            quadratura_view::navigation::SceneFrame { up: DVec3::Z, center: DVec3::ZERO, radius: 1.0 };
        Self::at(Viewpoint::overview(&scene_frame, FrameLens::with_field_of_view(FIELD_RAD)))
    }
}

impl SpaceView {
    fn at(viewpoint: Viewpoint) -> Self {
        Self {
            device: None,
            viewpoint,
            look: Appearance { without_backs: true, ..Appearance::default() },
            visibility: ModelVisibility::default(),
            exploded: Exploded::default(),
            brush: SpaceBrush::default(),
            measure: MeasuringTool::default(),
            grip: EdgeGrip::default(),
            images: SpaceImages::default(),
            legend_shown: true,
            wireframe: false,
            cameras: true,
            photo_over: false,
            photo_opacity: 1.0,
            wipe: 1.0,
            through: None,
            back: None,
            travel: None,
            landed_s: None,
            shown: None,
            before_strokes: Vec::new(),
            asked: None,
            revision: 0,
            behind_s: None,
            stirred: false,
            pace: DrawingPace::default(),
            changed_s: 0.0,
            size_px: [1, 1],
            hovered: None,
            trouble: None,
            message: None,
        }
    }

    /// Makes the view of a project: through its first photo, which gives the best impression of the project.
    pub fn from_session(session: &Session) -> Self {
        match session.opened.site.photo_ids().next() {
            Some(first) => Self { through: Some(first), ..Self::at(session.viewpoint_of(first)) },
            None => {
                let lens = FrameLens::with_field_of_view(FIELD_RAD);
                Self::at(Viewpoint::overview(&session.scene_frame, lens))
            }
        }
    }

    /// Requests a new picture, because the current one shows an earlier state of the project. It stays visible until
    /// the new one is drawn.
    pub fn refresh(&mut self) {
        self.asked = None;
        self.revision += 1;
    }

    /// Moves to a viewpoint at once.
    pub fn show_from(&mut self, viewpoint: Viewpoint, now_s: f64) {
        self.moved(now_s);
        self.viewpoint = viewpoint;
    }

    /// Returns the size of the view in pixels, as it was drawn last.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Returns the width of the view in its heights.
    pub fn width(&self) -> f64 {
        let [width, height] = self.size_px.map(f64::from);
        width / height.max(1.0)
    }

    /// Requests new pictures because only the content of photos has changed. The current picture stays until the next
    /// one, which has the quality of a moving view; a final one follows when the view rests.
    pub fn redraw(&mut self) {
        self.refresh();
        self.stirred = true;
    }

    /// Returns whether there is a picture of the current project to show.
    pub fn has_picture(&self) -> bool {
        self.shown.is_some()
    }

    /// Returns the newest picture.
    pub fn picture(&self) -> Option<&NewestPicture> {
        self.shown.as_ref()
    }

    /// Returns whether the picture shows the present state of the project.
    pub fn shows_present(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| shown.request.revision == self.revision)
    }

    /// Returns the viewpoint of the picture on the screen, which is an earlier one until a new picture is drawn; the
    /// present one where there is no picture.
    pub fn seen_from(&self) -> Viewpoint {
        self.shown.as_ref().map_or(self.viewpoint, |shown| Viewpoint {
            pose: shown.request.shot.pose,
            lens: shown.request.lens,
            pivot: self.viewpoint.pivot,
        })
    }

    /// Returns the revision of the next picture that shows a change which is made now.
    pub fn next_revision(&self) -> u64 {
        self.revision + 1
    }

    /// Shows a picture that was drawn.
    pub fn show(&mut self, painted: PaintedPicture) {
        let PaintedPicture { request, image, faces, spent, images, .. } = painted;
        let is_of_images = images.as_ref().is_some_and(|status| !status.photos.is_empty());
        // The first picture takes what textures and programs take, too.
        if self.shown.is_some() {
            let pace = if is_of_images { &mut self.images.pace } else { &mut self.pace };
            pace.learn(&request.shot, spent);
        }
        self.images.status = images.map(|status| (status, spent));
        let strokes = self.brush.seen(request.revision);
        let before = self.shown.replace(NewestPicture::new(request, image, faces));
        if let Some(before) = before.filter(|_| !strokes.is_empty()) {
            self.before_strokes.push((strokes, before));
            let surplus = self.before_strokes.len().saturating_sub(BEFORE_STROKES);
            self.before_strokes.drain(..surplus);
        }
    }

    /// Hides a stroke that is being undone, until a picture without it is drawn: its preview, or the picture with it, in whose
    /// place the one of before is shown where that is of the same view.
    pub fn hide_stroke(&mut self, number: u32) {
        self.brush.undone(number);
        let is_it =
            |(strokes, _): &(Vec<UnseenStroke>, NewestPicture)| strokes.iter().any(|it| it.number == number);
        let Some(at) = self.before_strokes.iter().position(is_it) else { return };
        let next = self.next_revision();
        let mut pictures = self.before_strokes.split_off(at);
        let (strokes, before) = pictures.swap_remove(0);
        let same_view = |shown: &NewestPicture| shown.request.shot.pose == before.request.shot.pose;
        if self.shown.as_ref().is_some_and(same_view) {
            self.shown = Some(before);
            let others = strokes.into_iter().filter(|stroke| stroke.number != number);
            self.brush.unseen.extend(others.map(|stroke| UnseenStroke { revision: next, ..stroke }));
        }
    }

    /// Drops the picture, because nothing can be drawn. Returns whether the reason is new: every change of the layers
    /// tries again, and a missing driver is reported once.
    pub fn fail(&mut self, trouble: &str) -> bool {
        (self.asked, self.shown, self.behind_s) = (None, None, None);
        self.before_strokes.clear();
        self.brush.unseen.clear();
        let is_new = self.message.as_deref() != Some(trouble);
        (self.message, self.trouble) = (Some(trouble.to_owned()), Some(trouble.to_owned()));
        is_new
    }

    /// Returns the request for the picture that is due, and the time in seconds after which the view is drawn again. A
    /// picture is coarse while the view moves, or shows something else or smaller, and final when it rests. None is due where it was
    /// requested already, or where the view moves and the painter is busy with a picture that does not yield.
    pub fn due(
        &mut self,
        frame: FrameFacts,
        now_s: f64,
        painter_is_busy: bool,
    ) -> (Option<PictureRequest>, Option<f64>) {
        if self.stirred {
            self.changed_s = now_s;
        }
        let moves = frame.moves || self.stirred;
        let left_s = RESTS_S - (now_s - self.changed_s);
        // A view that has stopped moving is refined after a moment.
        let again_s = (!moves && left_s > 0.0).then_some(left_s);
        let coarse = self.request(frame.background, moves, false);
        let shows_it = |shown: &NewestPicture| {
            let PictureRequest { shot, from, .. } = &shown.request;
            shown.request.shows_the_same(&coarse)
                && (&shot.camera, from) == (&coarse.shot.camera, &coarse.from)
        };
        // A final picture can take a minute, so that a coarse one of the same view, as large, is shown before it.
        let rests = !moves && left_s <= 0.0 && self.shown.as_ref().is_some_and(shows_it);
        let request = if rests { self.request(frame.background, moves, rests) } else { coarse };
        let is_behind = self.shown.as_ref().is_some_and(|shown| !shown.request.shows_the_same(&request));
        self.behind_s = is_behind.then(|| self.behind_s.unwrap_or(now_s));
        // A picture of a moving view is waited for, so that there are some; that of a view at rest is given up for the next one.
        let waits = painter_is_busy && self.asked.as_ref().is_none_or(|asked| !asked.yields);
        if self.asked.as_ref() == Some(&request) || (moves && waits) {
            return (None, again_s);
        }
        self.asked = Some(request.clone());
        self.stirred = false;
        (Some(request), again_s)
    }

    fn request(&self, background: [u8; 3], moves: bool, rests: bool) -> PictureRequest {
        let pace = match self.drawn_from(moves, 1.0) {
            DrawnFrom::Model => self.pace,
            DrawnFrom::Images(_) | DrawnFrom::StandIn(_) => self.images.pace,
        };
        let scale = if moves { pace.scale(self.size_px) } else { 1.0 };
        let [width, height] = self.size_px.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
        let quality = if rests { Quality::Final } else { Quality::Preview };
        let look = Appearance { quality, ..self.look.clone() };
        // A view at rest shows trees as fine as they are.
        let trees_within = (!rests).then_some(TREES_WITHIN);
        let shot = look.shot(self.viewpoint.camera(width, height), self.viewpoint.pose);
        let shot = Shot { trees_within, ..shot };
        let (lens, from) = (self.viewpoint.lens, self.drawn_from(moves, scale));
        PictureRequest { shot, lens, from, yields: !moves, background, revision: self.revision }
    }

    /// Returns why the view cannot be drawn from layered depth images now, as the end of a sentence.
    pub fn why_no_images(&self) -> Option<&'static str> {
        if self.look.display != DisplayMode::Colour {
            Some("they show photos, and no other display mode")
        } else if self.visibility.hides_objects() {
            Some("they cannot hide objects")
        } else if self.look.blend.agreement && self.look.blend.without_transients {
            Some("they cannot leave transient objects out")
        } else if self.brush.on {
            Some("the brush paints on the model")
        } else {
            None
        }
    }

    /// Returns what the next picture is drawn from; it has `scale` of the view's sides.
    fn drawn_from(&self, moves: bool, scale: f64) -> DrawnFrom {
        let larger = 1.0 / scale;
        match &self.images {
            _ if self.why_no_images().is_some() => DrawnFrom::Model,
            images if images.on => {
                DrawnFrom::Images(LiveOptions { peeled: images.peeled, larger, complete: false })
            }
            images if images.stands_in && moves => {
                DrawnFrom::StandIn(LiveOptions { peeled: 0, larger, complete: true })
            }
            _ => DrawnFrom::Model,
        }
    }

    /// Returns the time in seconds after which the view is drawn again to say that its picture is not what is asked for.
    pub fn tells_in_s(&self) -> Option<f64> {
        self.behind_s.map(|_| BEHIND_S)
    }

    /// Returns whether the picture has not been what is asked for, for longer than a moving view takes.
    pub fn is_behind(&self, now_s: f64) -> bool {
        self.behind_s.is_some_and(|since_s| now_s - since_s > BEHIND_S)
    }

    /// Returns the display mode of the picture that is shown, which may be that before the last choice.
    pub fn shown_display(&self) -> DisplayMode {
        self.shown.as_ref().map_or(self.look.display, |shown| shown.request.shot.display)
    }

    /// Drops references to photos and faces, because the site was read again.
    pub fn forget_site(&mut self) {
        self.forget_faces();
        (self.shown, self.exploded) = (None, Exploded::default());
        self.before_strokes.clear();
        (self.through, self.travel, self.back) = (None, None, None);
    }

    /// Drops references to faces, because the model has changed.
    pub fn forget_faces(&mut self) {
        self.look.hidden = HiddenFaces::default();
        (self.hovered, self.exploded.hovered) = (None, None);
        if let Some(shown) = &mut self.shown {
            shown.faces.clear();
        }
    }

    /// Returns the photo that the view looks through.
    pub fn through(&self) -> Option<PhotoId> {
        self.through
    }
}

#[cfg(test)]
mod tests;
