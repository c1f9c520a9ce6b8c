//! Layer options: the project's in a window, and a photo's own in the inspector.

use eframe::egui::{
    Align2, Button, CollapsingHeader, Context, DragValue, Response, Slider, SliderClamping, Ui, Window,
};

use super::{button, slider_ui, small_button, text_width};
use crate::command::{Commands, layers};
use crate::state::State;
use crate::state::request::{DecideRequest, Flag, OptionsEdit, Request, WindowRequest};
use crate::state::session::Session;
use crate::widget::dialog::escaped;
use quadratura_document::decisions::PhotoOptions;
use quadratura_layers::{BoxShape, Options};

/// A numeric option with its slider.
struct Number {
    name: &'static str,
    tooltip: &'static str,
    range: std::ops::RangeInclusive<f64>,
    decimals: usize,
    suffix: &'static str,
}

/// The tolerance, in percent of the distance; the range is that of [`Options::problem`].
const TOLERANCE: Number = Number {
    name: "Depth tolerance",
    tooltip: "A surface occludes another one that is farther away by more than this share of the distance. Increase \
              it where surfaces close to each other occlude each other by mistake.",
    range: 0.001..=9.9,
    decimals: 3,
    suffix: " %",
};
const SUPPORT: Number = Number {
    name: "Contact noise",
    tooltip: "Where surfaces occlude each other in a cycle, an overlap of at most this many pixels is ignored as \
              contact noise; a larger one is resolved by a cut.",
    range: 0.0..=1000.0,
    decimals: 0,
    suffix: " px",
};
const MARGIN: Number = Number {
    name: "Margin",
    tooltip: "Pixels added around an image layer on every side.",
    range: 0.0..=256.0,
    decimals: 0,
    suffix: " px",
};

const LEAST_VISIBLE: Number = Number {
    name: "Barely visible",
    tooltip: "A surface that the photo shows at fewer pixels than this, and at less than the share below, gets no image \
              layer. 0: every surface gets one.",
    range: 0.0..=10_000.0,
    decimals: 0,
    suffix: " px",
};
/// In percent.
const LEAST_SHARE: Number = Number {
    name: "Barely visible share",
    tooltip: "A surface that the photo shows at this share of its pixels or more gets an image layer, however few \
              they are.",
    range: 0.0..=100.0,
    decimals: 2,
    suffix: " %",
};

/// In percent.
const TOLERATED: Number = Number {
    name: "Tolerated overlap",
    tooltip: "Parts of one object that occlude each other stay together, where their overlap is at most this share of \
              what the photo shows of the smaller part. The photo does not texture what is behind. 0: they are apart.",
    range: 0.0..=100.0,
    decimals: 2,
    suffix: " %",
};

/// In percent of the photo's longer side; 100 is all of the photo.
const REACH: Number = Number {
    name: "Surroundings reach",
    tooltip: "How far behind the model the surroundings (sky, hills, far houses) are needed, as a share of the photo’s \
              longer side. 100 %: in the whole photo.",
    range: 0.0..=100.0,
    decimals: 2,
    suffix: " %",
};

/// Draws a slider with its name; returns the new value when it was moved, and whether the gesture continues.
fn number(ui: &mut Ui, of: &Number, value: f64, requests: &mut Vec<Request>) -> Option<(f64, bool)> {
    let mut moved = value;
    let slider = Slider::new(&mut moved, of.range.clone())
        .logarithmic(true)
        // Smaller values are indistinguishable: without this limit 1 px would be far to the right.
        .smallest_positive(0.1_f64.powi(of.decimals as i32))
        .clamping(SliderClamping::Always)
        .max_decimals(of.decimals)
        .suffix(of.suffix);
    let response = ui
        .scope(|ui| slider_ui(ui, of.name, text_width(ui, LEAST_SHARE.name), slider))
        .inner
        .on_hover_text(of.tooltip);
    wanted(&response, moved, requests)
}

fn wanted(response: &Response, moved: f64, requests: &mut Vec<Request>) -> Option<(f64, bool)> {
    if response.drag_stopped() && !response.changed() {
        requests.push(Request::Decide(DecideRequest::EndGesture));
    }
    response.changed().then(|| (moved, response.dragged() && !response.drag_stopped()))
}

/// Draws the options of a photo, each inherited from the project or its own.
pub fn photo_options_ui(
    commands: Commands<'_>,
    session: &Session,
    photo: &str,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let project = session.history.present();
    let own = project.decisions.photos.get(photo).map(|decided| decided.options).unwrap_or_default();
    let title =
        if own.is_default() { "Layer options: project defaults" } else { "Layer options: its own values" };
    CollapsingHeader::new(title).id_salt("photo options").show(ui, |ui| {
        let all = own.applied_to(&project.options);
        let mut rows = PhotoOptionRows { photo, ui, requests };
        rows.row(&TOLERANCE, percent(all.tolerance), own.tolerance.is_some(), |value| PhotoOptions {
            tolerance: value.map(share),
            ..own
        });
        rows.row(&SUPPORT, all.min_support.into(), own.min_support.is_some(), |value| PhotoOptions {
            min_support: value.map(whole),
            ..own
        });
        rows.row(&MARGIN, all.margin.into(), own.margin.is_some(), |value| PhotoOptions {
            margin: value.map(whole),
            ..own
        });
        rows.row(&LEAST_VISIBLE, all.min_visible.into(), own.min_visible.is_some(), |value| PhotoOptions {
            min_visible: value.map(whole),
            ..own
        });
        rows.row(&LEAST_SHARE, percent(all.min_share), own.min_share.is_some(), |value| PhotoOptions {
            min_share: value.map(share),
            ..own
        });
        rows.row(&TOLERATED, percent(all.tolerated), own.tolerated.is_some(), |value| PhotoOptions {
            tolerated: value.map(share),
            ..own
        });
        if ui.button(layers::OPTIONS.name).on_hover_text(layers::OPTIONS.tooltip).clicked() {
            requests.push(commands.requested(&layers::OPTIONS));
        }
    });
}

/// Draws the rows of a photo's own options.
struct PhotoOptionRows<'a> {
    photo: &'a str,
    ui: &'a mut Ui,
    requests: &'a mut Vec<Request>,
}

impl PhotoOptionRows<'_> {
    /// Draws a number; a photo's own one has a button that resets it to the project's.
    fn row(&mut self, of: &Number, value: f64, is_own: bool, with: impl Fn(Option<f64>) -> PhotoOptions) {
        let Self { photo, ui, requests } = self;
        let edit = |options| OptionsEdit::Photo((*photo).to_owned(), options);
        if let Some((moved, goes_on)) = number(ui, of, value, requests) {
            requests.push(Request::Decide(DecideRequest::Options { edit: edit(with(Some(moved))), goes_on }));
        }
        ui.horizontal(|ui| {
            ui.add_space(12.0);
            if !is_own {
                ui.weak("project default");
                return;
            }
            let name = format!("{}: use project default", of.name);
            if small_button(ui, "Use project default", &name, "Removes the photo’s own value.").clicked() {
                requests
                    .push(Request::Decide(DecideRequest::Options { edit: edit(with(None)), goes_on: false }));
            }
        });
    }
}

/// What the window of the layer options shows.
pub struct LayerOptionsView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// Whether the window is open.
    shown: bool,
}

impl<'a> LayerOptionsView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            shown: state.dialogs.layer_options,
        }
    }
}

/// Draws the window of the project's options when it is open.
pub fn layer_options_ui(context: &Context, view: &LayerOptionsView<'_>, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let mut open = view.shown;
    let window = Window::new("Layer options").open(&mut open).resizable(false).collapsible(false);
    let middle = context.content_rect().center();
    window.default_width(430.0).pivot(Align2::CENTER_CENTER).default_pos(middle).show(context, |ui| {
        ui.label(
            "These options apply to all photos without values of their own; layers change when they are built.",
        );
        ui.add_space(6.0);
        let options = &session.history.present().options;
        numbers(options, ui, requests);
        shape(options, ui, requests);
        ui.add_space(6.0);
        let usual = Options { method: options.method, ..Options::default() };
        ui.horizontal(|ui| {
            let reset = ui.add_enabled(*options != usual, Button::new("Restore defaults"));
            if reset.on_hover_text("Restores the options of a new project.").clicked() {
                requests.push(Request::Decide(DecideRequest::Options {
                    edit: OptionsEdit::Project(usual),
                    goes_on: false,
                }));
            }
            button(view.commands, ui, &layers::BUILD, requests);
        });
    });
    if view.shown && (!open || escaped(context)) {
        requests.push(WindowRequest::Flip(Flag::LayerOptions).into());
    }
}

fn numbers(options: &Options, ui: &mut Ui, requests: &mut Vec<Request>) {
    let request = |moved: Option<(f64, bool)>, with: &dyn Fn(f64) -> Options, requests: &mut Vec<Request>| {
        if let Some((value, goes_on)) = moved {
            requests.push(Request::Decide(DecideRequest::Options {
                edit: OptionsEdit::Project(with(value)),
                goes_on,
            }));
        }
    };
    let moved = number(ui, &TOLERANCE, percent(options.tolerance), requests);
    request(moved, &|value| Options { tolerance: share(value), ..options.clone() }, requests);
    let moved = number(ui, &SUPPORT, options.min_support.into(), requests);
    request(moved, &|value| Options { min_support: whole(value), ..options.clone() }, requests);
    let moved = number(ui, &MARGIN, options.margin.into(), requests);
    request(moved, &|value| Options { margin: whole(value), ..options.clone() }, requests);
    let moved = number(ui, &LEAST_VISIBLE, options.min_visible.into(), requests);
    request(moved, &|value| Options { min_visible: whole(value), ..options.clone() }, requests);
    let moved = number(ui, &LEAST_SHARE, percent(options.min_share), requests);
    request(moved, &|value| Options { min_share: share(value), ..options.clone() }, requests);
    let moved = number(ui, &TOLERATED, percent(options.tolerated), requests);
    request(moved, &|value| Options { tolerated: share(value), ..options.clone() }, requests);
    let moved = number(ui, &REACH, percent(options.reach), requests);
    request(moved, &|value| Options { reach: share(value), ..options.clone() }, requests);
    let moved = largest_side(options, ui, requests);
    request(moved, &|value| Options { largest_side: whole(value), ..options.clone() }, requests);
}

/// Artists have no use for smaller image layers.
const LEAST_SIDE: f64 = 512.0;
/// Image editors open no larger images.
const MOST_SIDE: f64 = 300_000.0;

fn largest_side(options: &Options, ui: &mut Ui, requests: &mut Vec<Request>) -> Option<(f64, bool)> {
    let mut side = f64::from(options.largest_side);
    ui.horizontal(|ui| {
        let value = DragValue::new(&mut side).range(LEAST_SIDE..=MOST_SIDE).speed(64.0).suffix(" px");
        let field = ui.add(value.fixed_decimals(0));
        let label = ui.label("Longest side of an image layer");
        let tooltip = "A surface that needs a larger image layer gets several, side by side.";
        let field = field.labelled_by(label.id).on_hover_text(tooltip);
        wanted(&field, side, requests)
    })
    .inner
}

fn shape(options: &Options, ui: &mut Ui, requests: &mut Vec<Request>) {
    let mut wanted = options.clone();
    ui.horizontal(|ui| {
        ui.label("Sides of image layers");
        ui.radio_value(&mut wanted.boxes, BoxShape::PowerOfTwo, "powers of two")
            .on_hover_text("64, 128, 256 … pixels: all programs and devices accept such pictures.");
        ui.radio_value(&mut wanted.boxes, BoxShape::Exact, "as needed")
            .on_hover_text("Image layers are as small as possible.");
    });
    ui.checkbox(&mut wanted.published, "Merge within one visibility layer only").on_hover_text(
        "Surfaces share an image layer only with surfaces of the same visibility layer; this gives more image \
         layers.",
    );
    if wanted != *options {
        requests.push(Request::Decide(DecideRequest::Options {
            edit: OptionsEdit::Project(wanted),
            goes_on: false,
        }));
    }
}

fn percent(share: f32) -> f64 {
    // The value is rounded as it was typed: a float's own digits would be visible.
    (f64::from(share) * 1e7).round() / 1e5
}

fn share(percent: f64) -> f32 {
    (percent / 100.0) as f32
}

fn whole(value: f64) -> u32 {
    value.round().max(0.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sliders_reach_nothing_that_the_method_refuses() {
        for value in [TOLERANCE.range.start(), TOLERANCE.range.end()] {
            let options = Options { tolerance: share(*value), ..Options::default() };
            assert_eq!(options.problem(), None, "{value} %");
        }
        for side in [LEAST_SIDE, MOST_SIDE] {
            let options = Options { largest_side: whole(side), ..Options::default() };
            assert_eq!(options.problem(), None, "{side}");
        }
        for reach in [REACH.range.start(), REACH.range.end()] {
            let options = Options { reach: share(*reach), ..Options::default() };
            assert_eq!(options.problem(), None, "{reach} %");
        }
        assert_eq!(percent(Options::default().reach), 4.0);
        assert_eq!(percent(Options::default().tolerance), 0.01);
        assert_eq!(share(percent(0.02)), 0.02);
    }
}
