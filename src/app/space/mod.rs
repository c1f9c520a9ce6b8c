//! The 3D view: the live preview and its navigation.

pub mod exploded;
pub mod hint;
pub mod input;
pub mod legend;
pub mod overlay;
pub mod pace;
pub mod picking;
pub mod tools;

use eframe::egui::{Color32, Id, Rect, Sense, TextureHandle, TextureOptions, Ui, Vec2, pos2};

use self::exploded::Exploded;
use self::pace::DrawingPace;
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::painter::{PaintedPicture, Request};
use crate::projection::Quality;
use crate::projection::flight::{Flight, FrameLens};
use crate::projection::navigation::Viewpoint;
use crate::recipe::render::Appearance;

/// The duration of a flight between viewpoints, in seconds: long enough to follow, short enough not to wait.
const FLIGHT_S: f64 = 0.6;
/// The time without a change after which the view is drawn in final quality, in seconds.
const RESTS_S: f64 = 0.25;
/// The vertical field of view of a free viewpoint, in radians: 45 degrees, close to that of photos.
const FIELD_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// The state of the 3D view: viewpoint, display options, and the newest picture.
pub struct Space {
    /// The current viewpoint.
    pub viewpoint: Viewpoint,
    /// The blending of photos, and the display mode.
    pub look: Appearance,
    /// The exploded view.
    pub exploded: Exploded,
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
    through: Option<usize>,
    /// The viewpoint before the flight into a photo.
    back: Option<Viewpoint>,
    travel: Option<Travel>,
    shown: Option<NewestPicture>,
    asked: Option<Request>,
    /// Whether the content of photos has changed since the last request for a picture.
    stirred: bool,
    pace: DrawingPace,
    /// The time of the last change of the view, in seconds of the window's clock.
    changed_s: f64,
    /// The size of the view in pixels, as it was drawn last.
    size_px: [u32; 2],
    hovered: Option<crate::scene::FaceId>,
    /// The reason why nothing can be drawn.
    pub trouble: Option<String>,
    /// The reason that a note has already reported.
    message: Option<String>,
    /// The widget id of the view, once it was drawn.
    pub id: Option<Id>,
}

/// A flight to another viewpoint.
struct Travel {
    flight: Flight,
    since_s: f64,
    to: Viewpoint,
    through: Option<usize>,
}

/// The newest picture.
struct NewestPicture {
    texture: TextureHandle,
    request: Request,
    faces: Vec<u32>,
}

impl Default for Space {
    fn default() -> Self {
        use glam::DVec3;
        let scene_frame =
            crate::projection::navigation::SceneFrame { up: DVec3::Z, center: DVec3::ZERO, radius: 1.0 };
        Self::at(Viewpoint::overview(&scene_frame, FrameLens::with_field_of_view(FIELD_RAD)))
    }
}

impl Space {
    fn at(viewpoint: Viewpoint) -> Self {
        Self {
            viewpoint,
            look: Appearance { without_backs: true, ..Appearance::default() },
            exploded: Exploded::default(),
            legend_shown: true,
            wireframe: false,
            cameras: true,
            photo_over: false,
            photo_opacity: 1.0,
            wipe: 1.0,
            through: None,
            back: None,
            travel: None,
            shown: None,
            asked: None,
            stirred: false,
            pace: DrawingPace::default(),
            changed_s: 0.0,
            size_px: [1, 1],
            hovered: None,
            trouble: None,
            message: None,
            id: None,
        }
    }

    /// Makes the view of a project: through its first photo, which gives the best impression of the project.
    pub fn from_session(session: &Session) -> Self {
        if session.photos.is_empty() {
            return Self::at(Viewpoint::overview(
                &session.scene_frame,
                FrameLens::with_field_of_view(FIELD_RAD),
            ));
        }
        Self { through: Some(0), ..Self::at(session.viewpoint_of(0)) }
    }

    /// Requests a new picture, because the current one shows an earlier state of the project. It stays visible until
    /// the new one is drawn.
    pub fn refresh(&mut self) {
        self.asked = None;
    }

    /// Moves to a viewpoint at once.
    pub fn show_from(&mut self, viewpoint: Viewpoint, now_s: f64) {
        self.moved(now_s);
        self.viewpoint = viewpoint;
    }

    /// Returns the size of the view in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Requests new pictures because only the content of photos has changed. The current picture stays until the next
    /// one, which has the quality of a moving view; a final one follows when the view rests.
    pub fn redraw(&mut self) {
        self.asked = None;
        self.stirred = true;
    }

    /// Returns whether a picture of the current project was drawn.
    pub fn has_picture(&self) -> bool {
        self.shown.is_some()
    }

    /// Drops references to photos and faces, because the site was read again.
    pub fn forget_site(&mut self) {
        self.forget_faces();
        (self.shown, self.exploded) = (None, Exploded::default());
        (self.through, self.travel, self.back) = (None, None, None);
    }

    /// Drops references to faces, because the model has changed.
    pub fn forget_faces(&mut self) {
        (self.hovered, self.exploded.hovered) = (None, None);
        if let Some(shown) = &mut self.shown {
            shown.faces.clear();
        }
    }

    /// Returns the photo that the view looks through.
    pub fn through(&self) -> Option<usize> {
        self.through
    }

    /// Records a movement by the user: the view leaves the photo.
    fn moved(&mut self, now_s: f64) {
        self.changed_s = now_s;
        self.through = None;
        self.travel = None;
    }

    fn fly(&mut self, to: Viewpoint, through: Option<usize>, session: &Session, now_s: f64) {
        match self.viewpoint.flight_to(&to, FLIGHT_S, session.scene_frame.up) {
            Some(flight) => {
                self.through = None;
                self.travel = Some(Travel { flight, since_s: now_s, to, through });
            }
            None => {
                self.viewpoint = to;
                self.through = through;
            }
        }
        self.changed_s = now_s;
    }

    /// Advances a flight; returns whether there is one.
    fn travel(&mut self, now_s: f64) -> bool {
        let Some(travel) = &self.travel else { return false };
        let since = now_s - travel.since_s;
        if since >= FLIGHT_S {
            (self.viewpoint, self.through) = (travel.to, travel.through);
            self.travel = None;
        } else {
            let (camera, pose) = travel.flight.at(since);
            self.viewpoint =
                Viewpoint { pose, lens: FrameLens::from_camera(&camera), pivot: travel.to.pivot };
        }
        self.changed_s = now_s;
        true
    }
}

/// Draws the view and handles its input.
pub fn space_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Canvas, true, "3D view"));
    editor.state.space.id = Some(response.id);
    let density = ui.ctx().pixels_per_point();
    let side = |points: f32| ((points * density).round() as u32).max(1);
    editor.state.space.size_px = [side(rect.width()), side(rect.height())];
    let now_s = ui.input(|input| input.time);
    let flies = editor.state.space.travel(now_s);
    let moves = input::navigate(editor, ui, &response, rect, now_s) || editor.state.plays();
    receive(editor, ui);
    if editor.state.space.exploded.is_on() {
        ui.painter_at(rect).rect_filled(rect, 0.0, background(ui));
        exploded::exploded_ui(editor, ui, &response, rect, asks);
    } else {
        ask(editor, ui, now_s, flies || moves);
        paint(editor, ui, rect);
        picking::pick(editor, ui, &response, rect, asks);
    }
    let mut controls = tools::Controls::new(&editor.state);
    tools::tools_ui(ui, &editor.state, &mut controls, rect, asks);
    controls.put_back(&mut editor.state);
}

/// Takes the newest picture from the painter.
fn receive(editor: &mut Editor, ui: &Ui) {
    let Some(session) = &mut editor.state.session else { return };
    let Some(painter) = &mut editor.work.painter else { return };
    match painter.receive() {
        Some(Ok(painted)) => {
            // Rays intersect the surface that is shown.
            session.solid = painted.surface.clone();
            editor.state.space.show(painted, ui);
        }
        Some(Err(error)) => space_failed(&mut editor.state, &mut editor.work, &error),
        None => (),
    }
}

impl Space {
    fn show(&mut self, painted: PaintedPicture, ui: &Ui) {
        let PaintedPicture { request, image, faces, spent, .. } = painted;
        self.pace.learn(&request.shot, spent);
        match &mut self.shown {
            Some(shown) => {
                shown.texture.set(image, TextureOptions::LINEAR);
                (shown.request, shown.faces) = (request, faces);
            }
            None => {
                let texture = ui.ctx().load_texture("3D view", image, TextureOptions::LINEAR);
                self.shown = Some(NewestPicture { texture, request, faces });
            }
        }
    }
}

/// Requests the picture that is due: a coarse one while the view moves, a final one when it rests.
fn ask(editor: &mut Editor, ui: &Ui, now_s: f64, moves: bool) {
    let background = background(ui);
    let Some(painter) = &mut editor.work.painter else { return };
    let space = &mut editor.state.space;
    if space.stirred {
        space.changed_s = now_s;
    }
    let moves = moves || space.stirred;
    let rests = !moves && now_s - space.changed_s >= RESTS_S;
    let scale = if moves { space.pace.scale(space.size_px) } else { 1.0 };
    let px = space.size_px.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    let quality = if rests { Quality::Final } else { Quality::Preview };
    let look = Appearance { quality, ..space.look.clone() };
    let shot = look.shot(space.viewpoint.camera(px[0], px[1]), space.viewpoint.pose);
    let request =
        Request { shot, yields: !moves, background: [background.r(), background.g(), background.b()] };
    if !rests && !moves {
        // A view that has stopped moving is refined after a moment.
        ui.ctx().request_repaint_after_secs((RESTS_S - (now_s - space.changed_s)) as f32);
    }
    if space.asked.as_ref() == Some(&request) || (moves && painter.is_busy()) {
        return;
    }
    space.asked = Some(request.clone());
    space.stirred = false;
    painter.ask(request);
}

fn background(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(44, 47, 52) } else { Color32::from_rgb(206, 211, 216) }
}

fn paint(editor: &mut Editor, ui: &mut Ui, rect: Rect) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, background(ui));
    if let Some(shown) = &editor.state.space.shown {
        // The last picture is shown until the next one is drawn.
        painter.image(
            shown.texture.id(),
            rect,
            Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)),
            Color32::WHITE,
        );
    }
    overlay::overlay_ui(editor, ui, rect);
}

/// Converts a position in the view, in points from its top left corner, to pixels of full-size pictures.
fn px_of(offset: Vec2, density: f32) -> glam::DVec2 {
    glam::DVec2::new(f64::from(offset.x * density), f64::from(offset.y * density))
}

impl State {
    /// Flies to a free viewpoint.
    pub fn fly_to_viewpoint(&mut self, there: Viewpoint) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        self.space.fly(there, None, session, now_s);
    }

    /// Flies into the camera of a photo.
    pub fn fly_to_photo(&mut self, photo: usize) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        if self.space.through.is_none() && self.space.travel.is_none() {
            self.space.back = Some(self.space.viewpoint);
        }
        self.space.fly(session.viewpoint_of(photo), Some(photo), session, now_s);
        self.select(crate::app::state::selection::Selection::Photo(photo));
    }

    /// Flies into the selected photo, or back to the previous viewpoint.
    pub fn snap(&mut self) {
        let Some(photo) = self.selected_photo() else { return };
        let now_s = self.window.now_s;
        match (self.space.through, self.space.back.take()) {
            (Some(through), Some(back)) if through == photo => {
                let Some(session) = &self.session else { return };
                self.space.fly(back, None, session, now_s);
            }
            (_, back) => {
                self.space.back = back;
                self.fly_to_photo(photo);
            }
        }
    }

    /// Selects the photo `by` positions further; flies there when the view looks through a photo.
    pub fn step_photo(&mut self, by: isize) {
        let Some(session) = &self.session else { return };
        let count = session.photos.len() as isize;
        if count == 0 {
            return;
        }
        let photo = self.photo.map_or(0, |photo| (photo as isize + by).rem_euclid(count) as usize);
        if self.space.through.is_some()
            || self.space.travel.as_ref().is_some_and(|travel| travel.through.is_some())
        {
            self.fly_to_photo(photo);
        } else {
            self.select(crate::app::state::selection::Selection::Photo(photo));
        }
    }

    /// Moves back until the whole model is visible.
    pub fn show_everything(&mut self) {
        let Some(session) = &self.session else { return };
        let scene_frame = session.scene_frame;
        self.fly_to_ball(scene_frame.center, scene_frame.radius);
    }

    /// Frames the selection.
    pub fn frame_selection(&mut self) {
        let Some(session) = &self.session else { return };
        match picking::ball_of(self.selection, session) {
            Some((center, radius)) => self.fly_to_ball(center, radius),
            None => match self.selection.photo() {
                Some(photo) => self.fly_to_photo(photo),
                None => self.show_everything(),
            },
        }
    }

    fn fly_to_ball(&mut self, center: glam::DVec3, radius: f64) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        let mut there = self.space.viewpoint;
        there.lens = FrameLens::with_field_of_view(FIELD_RAD);
        there.show(center, radius);
        self.space.fly(there, None, session, now_s);
    }

    /// Levels the horizon.
    pub fn level(&mut self) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        let mut there = self.space.viewpoint;
        there.level(session.scene_frame.up);
        self.space.fly(there, None, session, now_s);
    }
}

/// Shows in the view why it cannot be drawn, until it is restarted.
pub fn space_failed(state: &mut State, work: &mut Work, error: &crate::Error) {
    (state.space.asked, state.space.shown) = (None, None);
    work.drop_painter(state);
    let trouble = error.to_string();
    // Every change of the layers tries again: a missing driver is reported once.
    let is_reported = state.space.message.as_ref() == Some(&trouble);
    if !is_reported {
        state.tell(Note::new(Weight::Problem, format!("The 3D view: {error}")));
    }
    (state.space.message, state.space.trouble) = (Some(trouble.clone()), Some(trouble));
}
