//! The panel of flights: bookmarks on the left, the timeline on the right.

use eframe::egui::{
    Align, ComboBox, DragValue, Layout, Pos2, Rect, Role, ScrollArea, Sense, Shape, Stroke, TextEdit, Ui,
    WidgetInfo, pos2, vec2,
};

use crate::command;
use crate::command::Commands;
use crate::panel::menu::{KEYFRAME, context_ui};
use crate::panel::{button, named};
use crate::state::State;
use crate::state::flight::Flights;
use crate::state::request::{DecideRequest, FlightRequest, Request};
use crate::state::session::Session;
use crate::widget::look::selected as selected_colours;
use quadratura_document::bookmark::BookmarkIndex;
use quadratura_document::camera_path::{KeyframeIndex, PathSpeed};
use quadratura_document::history::Gesture;
use quadratura_document::{CameraPath, Project};

/// The shortest timeline, and the time beyond the last keyframe, in seconds.
const LEAST_S: f64 = 6.0;
const BEYOND_S: f64 = 2.0;
/// Half the side of a keyframe's mark, in points.
const MARK: f32 = 6.0;

/// What the panel of flights shows.
pub struct TimelineView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// Bookmarks and the flight.
    flights: &'a Flights,
}

impl<'a> TimelineView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self { commands: Commands::of(state), session: state.session.as_ref(), flights: &state.flights }
    }
}

/// Draws the panel.
pub fn timeline_ui(ui: &mut Ui, view: &TimelineView<'_>, requests: &mut Vec<Request>) {
    ui.add_space(4.0);
    ui.horizontal_top(|ui| {
        ui.allocate_ui_with_layout(vec2(250.0, ui.available_height()), Layout::top_down(Align::Min), |ui| {
            views(view, ui, requests);
        });
        ui.separator();
        ui.vertical(|ui| {
            ui.horizontal_wrapped(|ui| controls(view, ui, requests));
            line(view, ui, requests);
        });
    });
}

fn views(view: &TimelineView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    ui.horizontal(|ui| {
        ui.strong("Bookmarks");
        button(view.commands, ui, &command::flight::KEEP, requests);
    });
    let views = &session.opened.project.views;
    if views.is_empty() {
        ui.weak("Add a bookmark to return to a view later.");
    }
    ScrollArea::vertical().id_salt("views").auto_shrink([false, false]).show(ui, |ui| {
        for (index, bookmark) in views.iter().enumerate() {
            ui.horizontal(|ui| view_row(view, ui, index, &bookmark.name, requests));
        }
    });
}

fn view_row(view: &TimelineView<'_>, ui: &mut Ui, index: usize, name: &str, requests: &mut Vec<Request>) {
    if ui.button("Go").on_hover_text("Flies to this bookmark.").clicked() {
        requests.push(Request::Flight(FlightRequest::FlyToView(BookmarkIndex(index))));
    }
    let id = ui.make_persistent_id(("name of view", index));
    let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| name.to_owned());
    let field = ui.add(TextEdit::singleline(&mut typed).desired_width(120.0));
    field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, format!("Name of {name}")));
    if field.lost_focus() && typed.trim() != name && !typed.trim().is_empty() {
        let named = typed.trim().to_owned();
        request_edit(view, requests, "name of a bookmark", |project| project.views[index].name = named);
    }
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, typed));
    } else {
        ui.data_mut(|data| data.remove::<String>(id));
    }
    if ui.small_button("Remove").on_hover_text("Removes this bookmark.").clicked() {
        request_edit(view, requests, "removal of a bookmark", |project| {
            project.views.remove(index);
        });
    }
}

fn controls(view: &TimelineView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    use command::flight::{ADD, FILM, PLAY, REMOVE, STILL};
    for command in [&PLAY, &ADD, &REMOVE] {
        button(view.commands, ui, command, requests);
    }
    ui.label(format!("{:.2} s", view.flights.time_s));
    let path = view.session.and_then(|session| session.opened.project.flight.clone());
    if let Some(mut path) = path {
        let before = path.clone();
        film(ui, &mut path);
        let changed = path != before;
        if changed {
            let gesture = Some(Gesture(ui.make_persistent_id("film").value()));
            edit_path(view, requests, "video settings", path, gesture);
        }
        // A drag lasts until the pointer is released, mostly in a frame that changes nothing more; clicks and typed
        // values are steps of their own.
        let (down, released) = ui.input(|input| (input.pointer.any_down(), input.pointer.any_released()));
        if released || (changed && !down) {
            requests.push(Request::Decide(DecideRequest::EndGesture));
        }
    }
    for command in [&STILL, &FILM] {
        button(view.commands, ui, command, requests);
    }
}

fn film(ui: &mut Ui, path: &mut CameraPath) {
    let combo = ComboBox::from_id_salt("speed").selected_text(speed_name(path.speed)).width(120.0);
    let combo = combo.show_ui(ui, |ui| {
        for speed in [PathSpeed::Timed, PathSpeed::Constant, PathSpeed::Eased] {
            ui.selectable_value(&mut path.speed, speed, speed_name(speed));
        }
    });
    named(&combo.response, "Speed of the flight");
    ui.add(DragValue::new(&mut path.fps).range(1.0..=120.0).suffix(" fps"));
    let mut size = path.size;
    ui.add(DragValue::new(&mut size[0]).range(16..=7680).suffix(" px wide"));
    ui.add(DragValue::new(&mut size[1]).range(16..=4320).suffix(" px high"));
    if size != path.size {
        path.resize(size);
    }
}

fn speed_name(speed: PathSpeed) -> &'static str {
    match speed {
        PathSpeed::Timed => "Keyframe timing",
        PathSpeed::Constant => "Constant speed",
        PathSpeed::Eased => "Ease in and out",
    }
}

/// Pushes a request for an edit of the project.
fn request_edit(
    view: &TimelineView<'_>,
    requests: &mut Vec<Request>,
    name: &str,
    edit: impl FnOnce(&mut Project),
) {
    if let Some(mut project) = view.session.map(|session| Project::clone(session.history.present())) {
        edit(&mut project);
        requests.push(Request::Decide(DecideRequest::Edit(name.to_owned(), Box::new(project), None)));
    }
}

fn edit_path(
    view: &TimelineView<'_>,
    requests: &mut Vec<Request>,
    name: &str,
    path: CameraPath,
    gesture: Option<Gesture>,
) {
    if let Some(project) = view.session.map(|session| Project::clone(session.history.present())) {
        let project = Project { flight: Some(path), ..project };
        requests.push(Request::Decide(DecideRequest::Edit(name.to_owned(), Box::new(project), gesture)));
    }
}

/// Draws the timeline, its keyframes, and the current time.
fn line(view: &TimelineView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let path = view.session.and_then(|session| session.opened.project.flight.clone());
    let path = path.filter(|path| !path.keyframes.is_empty());
    let Some(path) = path else {
        ui.weak(
            "Move to a viewpoint and add a keyframe, then move on and add another: the flight goes from one to the \
             next.",
        );
        return;
    };
    let span_s = (path.end_s() + BEYOND_S).max(LEAST_S);
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width() - 8.0, 54.0), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Time of the flight"));
    let line = TimeScale { rect: rect.shrink2(vec2(12.0, 0.0)), span_s };
    draw(view, ui, &line, &path);
    let dragged = keyframes(view, ui, &line, &path, requests);
    let pointer =
        response.interact_pointer_pos().filter(|_| !dragged && (response.dragged() || response.clicked()));
    if let Some(pointer) = pointer {
        requests.push(FlightRequest::Pause.into());
        requests.push(Request::Flight(FlightRequest::GoTo(line.time_at(pointer).clamp(0.0, path.end_s()))));
    }
}

/// The mapping of seconds to a rectangle.
struct TimeScale {
    rect: Rect,
    span_s: f64,
}

impl TimeScale {
    fn x(&self, time_s: f64) -> f32 {
        self.rect.left() + (time_s / self.span_s) as f32 * self.rect.width()
    }

    fn time_at(&self, pointer: Pos2) -> f64 {
        f64::from((pointer.x - self.rect.left()) / self.rect.width()) * self.span_s
    }
}

fn draw(view: &TimelineView<'_>, ui: &Ui, line: &TimeScale, path: &CameraPath) {
    let painter = ui.painter_at(line.rect.expand2(vec2(12.0, 0.0)));
    let visuals = ui.visuals();
    painter.rect_filled(line.rect.expand2(vec2(10.0, 0.0)), 4.0, visuals.extreme_bg_color);
    let weak = visuals.weak_text_color();
    let step = if line.span_s > 60.0 { 10 } else { 1 };
    for second in (0..=line.span_s as u32).step_by(step) {
        let x = line.x(f64::from(second));
        painter.vline(x, line.rect.top()..=line.rect.top() + 6.0, Stroke::new(1.0, weak));
        let font = eframe::egui::FontId::proportional(12.0);
        painter.text(pos2(x + 3.0, line.rect.top()), eframe::egui::Align2::LEFT_TOP, second, font, weak);
    }
    let middle = line.rect.bottom() - 18.0;
    let from_to = line.x(0.0)..=line.x(path.end_s());
    painter.hline(from_to, middle, Stroke::new(2.0, weak));
    let now = line.x(view.flights.time_s);
    painter.vline(now, line.rect.y_range(), Stroke::new(2.0, visuals.selection.stroke.color));
}

/// Draws the keyframes, which can be selected and dragged; returns whether one is being dragged or was clicked.
fn keyframes(
    view: &TimelineView<'_>,
    ui: &mut Ui,
    line: &TimeScale,
    path: &CameraPath,
    requests: &mut Vec<Request>,
) -> bool {
    let mut busy = false;
    for (index, frame) in path.keyframes.iter().enumerate() {
        let center = pos2(line.x(frame.t), line.rect.bottom() - 18.0);
        let id = ui.make_persistent_id(("keyframe", index));
        let mark = Rect::from_center_size(center, vec2(2.4 * MARK, 2.4 * MARK));
        let response = ui.interact(mark, id, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Keyframe {}", index + 1)));
        let selected = view.flights.keyframe == Some(KeyframeIndex(index));
        diamond(ui, center, selected, response.hovered());
        if response.clicked() || response.drag_started() {
            busy = true;
            requests.push(FlightRequest::SelectKeyframe(KeyframeIndex(index)).into());
            requests.push(Request::Flight(FlightRequest::GoTo(frame.t)));
        }
        if response.dragged() {
            busy = true;
            let pointer = response.interact_pointer_pos();
            let mut moved = path.clone();
            moved.shift(KeyframeIndex(index), pointer.map_or(frame.t, |pointer| line.time_at(pointer)));
            edit_path(view, requests, "time of a keyframe", moved, Some(Gesture(id.value())));
        }
        if response.drag_stopped() {
            requests.push(Request::Decide(DecideRequest::EndGesture));
        }
        if response.secondary_clicked() {
            requests.push(FlightRequest::SelectKeyframe(KeyframeIndex(index)).into());
        }
        response.context_menu(|ui| context_ui(view.commands, ui, KEYFRAME, requests));
        response.on_hover_text(format!(
            "Keyframe {} at {:.2} s; drag it to another time.",
            index + 1,
            frame.t
        ));
    }
    busy
}

fn diamond(ui: &Ui, center: Pos2, selected: bool, hovered: bool) {
    let size = if hovered { MARK * 1.2 } else { MARK };
    let corners = [vec2(0.0, -size), vec2(size, 0.0), vec2(0.0, size), vec2(-size, 0.0)];
    let visuals = ui.visuals();
    let fill = if selected { selected_colours(visuals).1 } else { visuals.text_color() };
    let points = corners.iter().map(|corner| center + *corner).collect();
    ui.painter().add(Shape::convex_polygon(points, fill, Stroke::new(1.0, visuals.extreme_bg_color)));
}
