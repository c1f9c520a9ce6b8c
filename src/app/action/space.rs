//! Actions of the 3D view: its viewpoint, its display options, its pictures, and the layers that are pulled apart.

use std::sync::Arc;

use super::flat::slot::{ResultRequest, want};
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::panes::Pane;
use crate::state::request::SpaceRequest;
use crate::state::space::FrameFacts;
use crate::state::space::exploded::Panes3D;
use crate::state::space::measure::MeasuringTool;
use crate::work::Work;
use quadratura_base::error::Error;
use quadratura_document::Project;
use quadratura_document::frame::Stated;
use quadratura_editing::exploded::layer_textures::layer_thumbnails;
use quadratura_io::stack_store::StackStore;

/// The longer side of a photo's layer pictures, in pixels: seen from the side they are smaller than the window.
const LONGEST_PX: u32 = 1024;

/// Applies a request about the 3D view.
pub fn apply(state: &mut State, work: &mut Work, request: SpaceRequest) {
    match request {
        SpaceRequest::FlyToPhoto(photo) => {
            state.panes.show(Pane::Space);
            state.fly_to_photo(photo);
        }
        SpaceRequest::LookFrom(view) => state.look_from(&view),
        SpaceRequest::Frame => state.frame(),
        SpaceRequest::ShowAll => state.show_all(),
        SpaceRequest::Snap => {
            state.panes.show(Pane::Space);
            state.snap();
        }
        // The view never leaves the photo here: confirming a text field with a second Enter must not leave it.
        SpaceRequest::FlyInto => {
            state.panes.show(Pane::Space);
            if state.space.through() != state.selected_photo() {
                state.snap();
            }
        }
        SpaceRequest::Level => state.level(),
        SpaceRequest::Display(shown) => state.space.look.display = shown,
        SpaceRequest::PullApart => state.toggle_exploded(),
        SpaceRequest::FollowSelection => follow_selection(state),
        SpaceRequest::Draw(drawn) => draw(state, work, drawn),
        SpaceRequest::WantLayerPictures => want_layer_pictures(state, work),
        SpaceRequest::ShowObject(name, on) => state.show_object(&name, on),
        SpaceRequest::Isolate(name) => state.isolate_object(&name),
        SpaceRequest::ShowAllObjects => state.show_all_objects(),
        SpaceRequest::ShowUncovered(uncovered) => state.show_uncovered(uncovered),
        SpaceRequest::Brush => {
            state.panes.show(Pane::Space);
            state.space.brush.give_up();
            state.space.brush.on = !state.space.brush.on;
            // The left button does one thing at a time.
            state.trees.hand.on = false;
            state.space.measure.on = false;
        }
        SpaceRequest::Measure => {
            state.panes.show(Pane::Space);
            let on = !state.space.measure.on;
            state.space.measure = MeasuringTool { on, ..MeasuringTool::default() };
            state.space.brush.give_up();
            state.space.brush.on = false;
            state.trees.hand.on = false;
        }
        SpaceRequest::SetScale => set_scale(state),
        SpaceRequest::ResizeBrush(factor) => state.space.brush.resize(factor),
    }
}

/// Sets the site's scale by the length between the points of the measuring tool.
fn set_scale(state: &mut State) {
    let (Some(points), Some(metres)) = (state.space.measure.both(), state.space.measure.metres()) else {
        return;
    };
    let Some(session) = &state.session else { return };
    let units = points[0].position.distance(points[1].position);
    if units <= 0.0 {
        return;
    }
    let model = session.model();
    let [a, b] = points.map(|point| model.face_name(point.face));
    let mut project = Project::clone(session.history.present());
    let from = format!("{metres} m between a point of {a} and one of {b}");
    project.frame.scale = Some(Stated { value: metres / units, from });
    state.edit("scale of the site", project, None);
}

/// Continues what the view does by itself while it is shown: a flight, and taking the newest picture.
pub fn check_cancelled(state: &mut State, work: &mut Work) {
    if !state.panes.is_shown(Pane::Space) {
        return;
    }
    let now_s = state.window.now_s;
    state.space.travel(now_s);
    receive(state, work);
}

/// Takes the newest picture from the painter.
fn receive(state: &mut State, work: &mut Work) {
    let (Some(session), Some(painter)) = (&mut state.session, &mut work.painter) else { return };
    match painter.receive() {
        Some(Ok(painted)) => {
            // Rays intersect the surface that is shown.
            let is_new = !Arc::ptr_eq(&session.solid, &painted.surface);
            session.solid = painted.surface.clone();
            state.space.show(painted);
            if is_new {
                state.follow_visibility();
            }
        }
        Some(Err(error)) => space_failed(state, work, &error),
        None => (),
    }
}

/// Requests the picture that is due from the painter.
fn draw(state: &mut State, work: &mut Work, frame: FrameFacts) {
    let Some(painter) = &mut work.painter else { return };
    let now_s = state.window.now_s;
    let moves = frame.moves || state.space.flies(now_s) || state.plays();
    state.space.images.stands_in = state.settings.images_while_moving;
    let (request, again_s) = state.space.due(FrameFacts { moves, ..frame }, now_s, painter.is_busy());
    let tells_in_s = state.space.tells_in_s();
    again_s.into_iter().chain(tells_in_s).for_each(|seconds| state.window.wake_within(seconds));
    request.into_iter().for_each(|request| painter.request(request));
}

/// Shows in the view why it cannot be drawn, until it is restarted.
pub fn space_failed(state: &mut State, work: &mut Work, error: &Error) {
    work.drop_painter(&mut state.space);
    if state.space.fail(&error.to_string()) {
        state.notify(Note::new(Weight::Problem, format!("The 3D view: {error}")));
    }
}

/// Pulls apart the layers of another photo, because that one is selected now.
fn follow_selection(state: &mut State) {
    if state.space.exploded.is_on() && state.selected_photo() != state.space.exploded.photo {
        state.pull_apart();
        state.window.wake_within(0.0);
    }
}

/// Starts making the pictures of the layers that are pulled apart, unless they exist or are being made.
fn want_layer_pictures(state: &mut State, work: &mut Work) {
    let Some(scene) = state.scene() else { return };
    let (Some(version), session) = (scene.version_apart(), scene.session) else { return };
    let folder = StackStore::new(&session.folder).folder(&version.stack.photo.name);
    let stack = version.stack.clone();
    let request = ResultRequest {
        key: version,
        name: "Preparing the exploded view",
        gives_up: true,
        slot: |state| &mut state.space.exploded.made,
    };
    want(state, work, request, move |task| {
        Ok(Panes3D { pictures: layer_thumbnails(&folder, &stack, LONGEST_PX, task)? })
    });
}

impl State {
    /// Frames the selection in the view that is in use.
    pub fn frame(&mut self) {
        let framed = match self.panes.used() {
            Pane::Space => false,
            Pane::Photo => self.frame_in_photo(),
            Pane::Layer => {
                self.flat.layer.view.fit();
                true
            }
        };
        if !framed {
            self.frame_selection();
        }
    }

    /// Frames everything in the view that is in use.
    pub fn show_all(&mut self) {
        match self.panes.used() {
            Pane::Space => self.show_everything(),
            Pane::Photo => self.flat.photo.view.fit(),
            Pane::Layer => self.flat.layer.view.fit(),
        }
    }
}
