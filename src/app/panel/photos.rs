//! The list of photos: thumbnails with names and states.

use eframe::egui::load::SizedTexture;
use eframe::egui::{
    Color32, Id, Image, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, TextStyle, Ui, UiBuilder,
    Vec2, pos2, vec2,
};

use super::gone::{gone_ui, locate_ui};
use super::menu::{PHOTO, context_ui};
use super::percent;
use crate::command::Commands;
use crate::command::layers::BUILD;
use crate::state::State;
use crate::state::request::{Request, SelectRequest, SpaceRequest};
use crate::state::selection::Selection;
use crate::state::session::{BUILT, MISSING, PhotoStatus, Session};
use crate::widget::elide::{beside, elided};
use crate::widget::look::focus_stroke;
use crate::widget::look::{good, selected as selected_colours};
use quadratura_base::scene::PhotoId;
use quadratura_stacks::layer_table::LayerFigures;
use std::collections::BTreeSet;

/// The height of a row, in points.
const ROW: f32 = 62.0;
/// The size of a thumbnail, in points.
const PICTURE: Vec2 = vec2(84.0, 56.0);
/// The largest share of a row's width that the thumbnail takes: the name beside it is equally important.
const PICTURE_SHARE: f32 = 0.34;

/// The gap between the lines of a row, in points: three lines fit.
const BETWEEN: f32 = 1.0;
/// The side of the symbol of a photo's state, in points.
const SIGN: f32 = 10.0;

/// Looks up the thumbnail of a photo: there is none until it is made.
pub type ThumbnailLookup<'a> = &'a dyn Fn(PhotoId) -> Option<SizedTexture>;

/// What the list of photos shows.
pub struct PhotosView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// The photo that commands on a photo apply to.
    photo: Option<PhotoId>,
    /// The names of photos that have paint.
    painted: &'a BTreeSet<String>,
}

impl<'a> PhotosView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            photo: state.selected_photo(),
            painted: &state.round_trip.painted,
        }
    }
}

/// Draws the list.
pub fn photos_ui(
    ui: &mut Ui,
    view: &PhotosView<'_>,
    thumbnails: ThumbnailLookup<'_>,
    requests: &mut Vec<Request>,
) {
    ui.add_space(4.0);
    let Some(session) = view.session else { return };
    let behind = session.photos.iter().filter(|photo| !photo.is_current()).count();
    ui.horizontal(|ui| {
        ui.strong("Photos");
        if behind > 0 {
            let text = format!("Build {behind}");
            let ready = view.commands.ready(&BUILD).is_ok();
            let button = eframe::egui::Button::new(text).small();
            if ui.add_enabled(ready, button).on_hover_text(BUILD.tooltip).clicked() {
                requests.push(view.commands.requested(&BUILD));
            }
        }
    });
    gone_ui(ui, session, requests);
    let count = session.photos.len();
    let goes_to = gone_to(view, ui);
    ScrollArea::vertical().auto_shrink(false).show_rows(ui, ROW, count, |ui, rows| {
        if let Some(photo) = goes_to {
            show_row(ui, photo.index(), rows.start);
        }
        for id in rows.map(PhotoId::new) {
            row(ui, view, session, id, thumbnails(id), requests);
        }
    });
}

/// Returns the photo that was selected since the last frame: its row is scrolled into view.
fn gone_to(view: &PhotosView<'_>, ui: &Ui) -> Option<PhotoId> {
    let id = Id::unique("photo in sight");
    let before = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or_default(id), view.photo));
    view.photo.filter(|_| before != view.photo)
}

/// Scrolls as little as necessary. `first` is the row at the top of `ui`.
fn show_row(ui: &Ui, index: usize, first: usize) {
    let step = ROW + ui.spacing().item_spacing.y;
    let top = ui.max_rect().top() + (index as f32 - first as f32) * step;
    let rect = Rect::from_x_y_ranges(ui.max_rect().x_range(), top..=top + ROW);
    ui.scroll_to_rect(rect, None);
}

fn row(
    ui: &mut Ui,
    view: &PhotosView<'_>,
    session: &Session,
    id: PhotoId,
    thumbnail: Option<SizedTexture>,
    requests: &mut Vec<Request>,
) {
    let photo = session.opened.site.photo(id);
    let status = &session.photos[id.index()];
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let selected = view.photo == Some(id);
    let changes = Changes::new(view, session, &photo.name);
    response.widget_info(|| {
        let label = format!("{}, {}{}", photo.name, status.word, changes.words(", "));
        eframe::egui::WidgetInfo::selected(eframe::egui::Role::Button, true, selected, label)
    });
    let visuals = ui.visuals();
    if selected {
        ui.painter().rect_filled(rect, 4.0, selected_colours(visuals).0.gamma_multiply(0.6));
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, visuals.widgets.hovered.weak_bg_fill);
    }
    if response.has_focus() {
        ui.painter().rect_stroke(rect, 4.0, focus_stroke(visuals), StrokeKind::Inside);
    }
    let size = vec2(PICTURE.x.min(PICTURE_SHARE * rect.width()), PICTURE.y);
    let picture = Rect::from_min_size(rect.min + vec2(3.0, 3.0), size);
    match thumbnail {
        Some(texture) => {
            let image = Image::new(texture).maintain_aspect_ratio(true);
            image.fit_to_exact_size(size).paint_at(ui, fitted(picture, texture.size));
        }
        None => {
            ui.painter().rect_filled(picture, 2.0, visuals.extreme_bg_color);
        }
    }
    let text = Rect::from_min_max(rect.min + vec2(size.x + 12.0, 3.0), rect.max - vec2(4.0, 3.0));
    let mut ui = ui.new_child(UiBuilder::new().max_rect(text));
    ui.spacing_mut().item_spacing.y = BETWEEN;
    if selected {
        let of_text = selected_colours(ui.visuals()).1;
        (ui.visuals_mut().override_text_color, ui.visuals_mut().weak_text_color) =
            (Some(of_text), Some(of_text));
    }
    let photos = &session.opened.site.photos;
    let others = beside(id.index(), |place| Some(photos.get(place)?.name.as_str()));
    let name = elided(&ui, &photo.name, &others, ui.available_width(), &TextStyle::Body);
    ui.add(eframe::egui::Label::new(RichText::new(name).strong()).truncate().selectable(false));
    word_of_state(&mut ui, selected, status, changes, requests);
    details(&mut ui, status);
    if response.double_clicked() {
        requests.push(Request::Space(SpaceRequest::FlyToPhoto(id)));
    } else if response.clicked() {
        requests.push(Request::Select(SelectRequest::Only(Selection::Photo(id))));
    }
    if response.secondary_clicked() {
        requests.push(Request::Select(SelectRequest::Only(Selection::Photo(id))));
    }
    response.context_menu(|ui| context_ui(view.commands, ui, PHOTO, requests));
    response.on_hover_ui(|ui| tooltip(ui, &photo.name, status, changes));
}

/// Returns the largest rectangle of this proportion, centred in another.
fn fitted(rect: Rect, size: Vec2) -> Rect {
    let scale = (rect.width() / size.x).min(rect.height() / size.y);
    Rect::from_center_size(rect.center(), size * scale)
}

/// The user's changes to a photo.
#[derive(Clone, Copy)]
struct Changes {
    painted: bool,
    masked: bool,
}

impl Changes {
    fn new(view: &PhotosView<'_>, session: &Session, photo: &str) -> Self {
        let masked = !session.history.present().masks.of(photo).is_empty();
        Self { painted: view.painted.contains(photo), masked }
    }

    /// Formats the changes, each preceded by `between`; empty where there are none.
    fn words(self, between: &str) -> String {
        let words = [(self.painted, "painted"), (self.masked, "masked")];
        words.iter().filter(|(is, _)| *is).map(|(_, word)| format!("{between}{word}")).collect()
    }
}

/// Explains the word for a photo's state.
fn meaning(word: &str) -> &'static str {
    match word {
        BUILT => "Its layers are up to date.",
        "stale" => {
            "Its layers are out of date, because masks, options or model have changed: build it again."
        }
        "broken" => "Its layers cannot be read: build it again.",
        MISSING => "Its file is missing. Its layers are shown as they were built.",
        _ => "It has no layers yet: build it.",
    }
}

fn word_of_state(
    ui: &mut Ui,
    selected: bool,
    status: &PhotoStatus,
    changes: Changes,
    requests: &mut Vec<Request>,
) {
    let colour = match status.word {
        BUILT => good(ui.visuals()),
        "stale" => ui.visuals().warn_fg_color,
        "broken" | MISSING => ui.visuals().error_fg_color,
        _ => ui.visuals().weak_text_color(),
    };
    let text = format!("{}{}", status.word, changes.words(" · "));
    // On the colour of a selected row, the symbol alone has the colour of the state.
    let of_text = if selected { ui.visuals().text_color() } else { colour };
    let text = RichText::new(text).color(of_text).small();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (rect, _) = ui.allocate_exact_size(Vec2::splat(SIGN), Sense::hover());
        sign(ui, rect, status.word, colour);
        if status.word == MISSING {
            locate_ui(ui, requests);
        }
        ui.add(eframe::egui::Label::new(text).truncate().selectable(false));
    });
}

/// Draws the symbol of a state, recognisable without its colour: full, half, crossed out or empty.
fn sign(ui: &Ui, rect: Rect, word: &str, colour: Color32) {
    let (painter, middle, radius) = (ui.painter(), rect.center(), rect.width() / 2.0 - 1.0);
    let stroke = Stroke::new(1.4, colour);
    match word {
        BUILT => painter.circle_filled(middle, radius, colour),
        "stale" => {
            let half = Rect::from_min_max(pos2(rect.left(), middle.y), rect.max);
            painter.with_clip_rect(half).circle_filled(middle, radius, colour);
            painter.circle_stroke(middle, radius, stroke)
        }
        "broken" | MISSING => {
            let corner = vec2(radius, radius);
            painter.line_segment([middle - corner, middle + corner], stroke);
            let corner = vec2(radius, -radius);
            painter.line_segment([middle - corner, middle + corner], stroke)
        }
        _ => painter.circle_stroke(middle, radius, stroke),
    };
}

fn tooltip(ui: &mut Ui, name: &str, status: &PhotoStatus, changes: Changes) {
    ui.strong(name);
    ui.label(meaning(status.word));
    if let Some(problem) = &status.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    if changes.painted {
        ui.label("It has paint from an image editor.");
    }
    if changes.masked {
        ui.label("Masked parts of it are not used.");
    }
    ui.weak("Click selects, double-click flies to its camera.");
}

fn details(ui: &mut Ui, status: &PhotoStatus) {
    let Some(stack) = &status.stack else { return };
    let layers = stack.image_layers.len();
    let text = match status.figures() {
        Some(LayerFigures { hidden, filled, .. }) if filled > 0 => {
            format!("{layers} layers, {} filled", percent(filled, hidden))
        }
        Some(LayerFigures { hidden, used, .. }) => {
            format!("{layers} layers, {} hidden", percent(hidden, used))
        }
        None => String::new(),
    };
    ui.add(eframe::egui::Label::new(RichText::new(text).weak().small()).truncate().selectable(false));
}
