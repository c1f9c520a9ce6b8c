//! The panel of the photos' exposures; the 3D view shows changes while a slider is dragged.

use eframe::egui::{Button, ComboBox, DragValue, Grid, Response, RichText, ScrollArea, Slider, Ui};

use super::{NameCell, name_cell, room_for_names, slider_ui, text_width, toggle_ui};
use crate::command::{Commands, flat};
use crate::state::State;
use crate::state::quality::colour::ColourSession;
use crate::state::request::{QualityRequest, Request, SelectRequest};
use crate::state::running::Running;
use crate::state::selection::Selection;
use crate::state::session::Session;
use crate::widget::elide::beside;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_document::colour::REST;
use quadratura_projection::exposure::ExposureRule;
use quadratura_views::colour::{ColourEdit, ColourReport, PhotoColour, found_name, keeping_found};

/// The range of sliders, in stops: photos of one site rarely differ more. Larger numbers can be typed.
const STOPS: f64 = 3.0;
/// The width of a number and of the remark beside it, in points, with the gaps.
const BESIDE_NAMES: f32 = 92.0 + 66.0 + 24.0;
/// The difference in stops that is not visible.
const NOTHING: f64 = 0.005;

/// Rounds stops for display, without a negative zero.
fn shown(stops: f64) -> f64 {
    if stops.abs() < NOTHING { 0.0 } else { stops }
}

/// What the panel of exposures shows.
pub struct ColourView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// The exposures of photos.
    colour: &'a ColourSession,
    /// The running jobs.
    running: &'a Running,
    /// The photo that commands on a photo apply to.
    photo: Option<PhotoId>,
}

impl<'a> ColourView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            colour: &state.quality.colour,
            running: &state.running,
            photo: state.selected_photo(),
        }
    }
}

/// Draws the panel.
pub fn colour_ui(view: &ColourView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let any_stack = view.session.is_some_and(|s| s.photos.iter().any(|p| p.stack.is_some()));
    if !any_stack {
        ui.weak("Build the layers first, so that photos can be compared where they show the same surface.");
        return;
    }
    requests.push(QualityRequest::WantEstimate.into());
    if view.colour.failed(view.running) {
        ui.label("The photos could not be compared; the messages give the reason.");
        if ui.button("Try again").clicked() {
            requests.push(QualityRequest::EstimateAgain.into());
        }
        return;
    }
    let Some(report) = view.session.and_then(|session| view.colour.report(session)) else {
        ui.horizontal(|ui| {
            ui.add(Spinner::new());
            ui.label("Comparing exposures…");
        });
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        switches(view, &report, ui, requests);
        if let Some(photo) = view.photo.and_then(|photo| report.photos.get(photo.index())) {
            selected(view, photo, &report, ui, requests);
        }
        ui.separator();
        all(view, &report, ui, requests);
        ui.separator();
        supports(&report, ui);
    });
}

fn decide(requests: &mut Vec<Request>, edit: ColourEdit) {
    requests.push(Request::Quality(QualityRequest::Colour { edits: vec![edit], goes_on: false }));
}

fn switches(view: &ColourView<'_>, report: &ColourReport, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let colour = &session.opened.project.colour;
    let mut switch = |on: bool, name: &str, tooltip: &str, edit: fn(bool) -> ColourEdit| {
        let mut on = on;
        if ui.checkbox(&mut on, name).on_hover_text(tooltip).changed() {
            decide(requests, edit(on));
        }
    };
    let even = "Matches the exposure of photos before they are blended; off: photos are used as they are.";
    switch(report.even, "Match exposure", even, ColourEdit::Even);
    let corners = "Removes the darkening of corners by lenses from views; off: views keep it where that predicts left-out photos better.";
    switch(colour.vignetting == Some(true), "Remove vignetting", corners, |on| {
        ColourEdit::Vignetting(on.then_some(true))
    });
    let haze = "Estimates and corrects light that was added everywhere in a photo, such as haze.";
    switch(colour.offset, "Correct haze", haze, ColourEdit::Offset);
    rules(colour.exposure, report, ui, requests);
    // The button is always there, so that the parts below do not move during a drag.
    let reset = ui.add_enabled(!colour.is_default(), Button::new("Reset all"));
    if reset.on_hover_text("Removes all decisions about colour.").clicked() {
        decide(requests, ColourEdit::Reset);
    }
}

/// The width of the list of rules, in points: the longest name fits.
const RULE_WIDTH: f32 = 190.0;

/// Draws the choice of the rule by which views are exposed, with the figures behind it.
fn rules(set: Option<ExposureRule>, report: &ColourReport, ui: &mut Ui, requests: &mut Vec<Request>) {
    let text = |rule: Option<ExposureRule>| match rule {
        None => format!("Decided: {}", rule_name(report.rule_decided)),
        Some(rule) => rule_name(rule).into(),
    };
    ui.add_enabled_ui(report.even, |ui| {
        let label = ui.label("Exposure of views");
        let width = ui.available_width().min(RULE_WIDTH);
        let list =
            ComboBox::from_id_salt("exposure of views").selected_text(text(set)).width(width).truncate();
        let choice = list.show_ui(ui, |ui| {
            for rule in std::iter::once(None).chain(ExposureRule::ALL.map(Some)) {
                if ui.selectable_label(rule == set, text(rule)).clicked() && rule != set {
                    decide(requests, ColourEdit::Rule(rule));
                }
            }
        });
        let mut tooltip = String::from("The exposure of views. A reference photo takes precedence.");
        if !report.rules.is_empty() {
            tooltip += "\nLeft-out photos are predicted with";
            for score in &report.rules {
                tooltip += &format!("\n{:.2} dB: {}", score.psnr, rule_name(score.rule));
            }
        }
        choice.response.labelled_by(label.id).on_hover_text(tooltip);
    });
}

/// Names a rule for the exposure of views.
fn rule_name(rule: ExposureRule) -> &'static str {
    match rule {
        ExposureRule::Near => "like photos nearby",
        ExposureRule::Metered => "by a light meter",
        ExposureRule::Common => "common exposure",
        ExposureRule::Raw => "photos as they are",
    }
}

/// Draws the selected photo, with all decisions about its colour.
fn selected(
    view: &ColourView<'_>,
    photo: &PhotoColour,
    report: &ColourReport,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    ui.separator();
    ui.weak("Photo");
    ui.label(RichText::new(&photo.photo).strong());
    ui.add_enabled_ui(report.even, |ui| {
        exposure(photo, ui, "Brighter by", requests);
        let channels = ["Red", "Green", "Blue"];
        let names = channels.iter().map(|name| text_width(ui, name)).fold(0.0, f32::max);
        for (channel, name) in channels.into_iter().enumerate() {
            let mut stops = photo.stops;
            stops[channel] = shown(stops[channel]);
            let response = slider(ui, name, names, &mut stops[channel]);
            drag(&response, photo, stops, requests);
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.weak("In the photo’s view:");
        toggle_ui(view.commands, ui, &flat::EVEN, requests);
    });
    ui.label(origin(photo));
    group(photo, report, ui, requests);
    ui.horizontal_wrapped(|ui| {
        let mut left_out = photo.left_out;
        let tooltip = "Excludes the photo from the estimate of exposures.";
        if ui.checkbox(&mut left_out, "Leave out").on_hover_text(tooltip).changed() {
            let name = photo.photo.clone();
            decide(requests, if left_out { ColourEdit::LeaveOut(name) } else { ColourEdit::Free(name) });
        }
        let mut reference = photo.reference;
        let tooltip = "Renders all pictures with the exposure of this photo, from any viewpoint.";
        if ui.checkbox(&mut reference, "Reference").on_hover_text(tooltip).changed() {
            decide(requests, ColourEdit::Reference(reference.then(|| photo.photo.clone())));
        }
        if photo.fixed && ui.button("As estimated").on_hover_text("Restores the estimate.").clicked() {
            decide(requests, ColourEdit::Free(photo.photo.clone()));
        }
    });
}

/// Draws the choice of a photo's group of light.
fn group(photo: &PhotoColour, report: &ColourReport, ui: &mut Ui, requests: &mut Vec<Request>) {
    let name = |group: usize| match report.light_set {
        true => report.light[group].name.clone(),
        false => found_name(&report.light[group]),
    };
    // Found groups become decided ones with the first change.
    let mut found = keeping_found(report);
    let mut moved = |to: String, requests: &mut Vec<Request>| {
        let mut edits = std::mem::take(&mut found);
        edits.push(ColourEdit::Group(to, vec![photo.photo.clone()]));
        requests.push(Request::Quality(QualityRequest::Colour { edits, goes_on: false }));
    };
    ui.add_enabled_ui(report.even, |ui| {
        let label = ui.label("Group of light");
        let width = ui.available_width().min(RULE_WIDTH);
        let text = if report.light.len() > 1 { name(photo.group) } else { "One for all photos".into() };
        let list = ComboBox::from_id_salt("group of light").selected_text(text).width(width).truncate();
        let choice = list.show_ui(ui, |ui| {
            for at in (0..report.light.len()).filter(|_| report.light.len() > 1) {
                if ui.selectable_label(at == photo.group, name(at)).clicked() && at != photo.group {
                    let is_rest = report.light[at].name == REST || (!report.light_set && at == 0);
                    moved(if is_rest { REST.into() } else { name(at) }, requests);
                }
            }
            let free = (2..).map(|number| format!("Light {number}"));
            let mut free = free.filter(|new| (0..report.light.len()).all(|at| name(at) != *new));
            if let Some(new) = free.next()
                && ui.button("A new group").clicked()
            {
                moved(new, requests);
            }
            if report.light.len() > 1 && ui.button("One group for all photos").clicked() {
                decide(requests, ColourEdit::OneGroup);
            }
            if report.light_set && ui.button("As found in the photos").clicked() {
                decide(requests, ColourEdit::FindGroups);
            }
        });
        let tooltip = format!("Photos of one group were taken in the same light.{}", leaning(report));
        choice.response.labelled_by(label.id).on_hover_text(tooltip);
    });
}

/// Says whether views lean to groups of light, and why, where there are several.
fn leaning(report: &ColourReport) -> String {
    let otherwise = "With a reference photo, views show the light of its group.";
    let is_one = report.light.len() < 2;
    if is_one { String::new() } else { format!("\n{}", report.leaning_in_words(otherwise)) }
}

/// Draws a slider that moves all channels together.
fn exposure(photo: &PhotoColour, ui: &mut Ui, text: &str, requests: &mut Vec<Request>) {
    let mean = shown(photo.stops.iter().sum::<f64>() / 3.0);
    let mut moved = mean;
    let response = slider(ui, text, text_width(ui, text), &mut moved);
    let response = response.on_hover_text("By how much the photo is brighter than the others.");
    drag(&response, photo, photo.stops.map(|stops| stops + moved - mean), requests);
}

fn slider(ui: &mut Ui, name: &str, names: f32, stops: &mut f64) -> Response {
    let slider = Slider::new(stops, -STOPS..=STOPS)
        .clamping(eframe::egui::SliderClamping::Never)
        .step_by(0.01)
        .fixed_decimals(2)
        .suffix(" stops");
    ui.scope(|ui| slider_ui(ui, name, names, slider)).inner
}

/// Handles a slider or number: during a drag the value is only previewed.
fn drag(response: &Response, photo: &PhotoColour, stops: [f64; 3], requests: &mut Vec<Request>) {
    let ends = response.drag_stopped() || response.lost_focus();
    // Sliders round their values even where the user has not moved them.
    let moved = stops.iter().zip(photo.stops).any(|(now, before)| (now - before).abs() > NOTHING);
    let changed = response.changed() && moved;
    // A drag that changed the value fixes the exposure.
    if changed || (response.drag_stopped() && photo.fixed) {
        let goes_on = response.dragged() && !ends;
        let edits = vec![ColourEdit::Fix(photo.photo.clone(), stops)];
        requests.push(Request::Quality(QualityRequest::Colour { edits, goes_on }));
    }
}

/// Draws all photos, each with its exposure.
fn all(view: &ColourView<'_>, report: &ColourReport, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.strong("All photos");
    let names = room_for_names(ui, BESIDE_NAMES);
    Grid::new("exposures").num_columns(3).spacing([8.0, 4.0]).show(ui, |ui| {
        for (id, photo) in PhotoId::all(report.photos.len()).zip(&report.photos) {
            let others = beside(id.index(), |place| Some(report.photos.get(place)?.photo.as_str()));
            let cell = NameCell { name: &photo.photo, others: &others, width: names };
            if name_cell(ui, view.photo == Some(id), &cell).clicked() {
                requests.push(Request::Select(SelectRequest::Only(Selection::Photo(id))));
            }
            let mean = shown(photo.stops.iter().sum::<f64>() / 3.0);
            let mut moved = mean;
            let value = DragValue::new(&mut moved).speed(0.01).fixed_decimals(2).suffix(" stops");
            let response = ui.add_enabled(report.even, value);
            let name = format!("Exposure of {}", photo.photo);
            response.widget_info(|| {
                eframe::egui::WidgetInfo::labeled(eframe::egui::Role::SpinButton, true, &name)
            });
            drag(&response, photo, photo.stops.map(|stops| stops + moved - mean), requests);
            ui.weak(badge(photo));
            ui.end_row();
        }
    });
}

fn badge(photo: &PhotoColour) -> String {
    let fixed = photo.fixed.then_some("fixed");
    let left_out = photo.left_out.then_some("left out");
    let reference = photo.reference.then_some("reference");
    let alone = (photo.estimated.is_none() && !photo.fixed && !photo.left_out).then_some("isolated");
    [fixed, left_out, reference, alone].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Describes the source of a photo's exposure.
fn origin(photo: &PhotoColour) -> String {
    let estimated = photo.estimated.map(|stops| stops.map(|s| format!("{s:+.2}")).join(", "));
    match (photo.fixed, estimated) {
        (true, Some(estimated)) => format!("Set by hand; the estimate is {estimated}."),
        (true, None) => "Set by hand; there is no estimate.".into(),
        (false, Some(_)) if photo.points > 0 => {
            format!("Estimated at {} points that other photos show, too.", photo.points)
        }
        (false, _) if photo.left_out => "Left out: the photo is used as it is.".into(),
        (false, _) => "No surface is shared with another photo: the photo is used as it is.".into(),
    }
}

fn supports(report: &ColourReport, ui: &mut Ui) {
    let mean = |three: [f64; 3]| three.iter().sum::<f64>() / 3.0;
    let (before, after) = (mean(report.before), mean(report.after));
    if before - after > NOTHING {
        ui.label(format!(
            "Photos differ by {before:.2} stops where they show the same surfaces, and by {after:.2} after matching."
        ));
    } else {
        ui.label(format!("Photos differ by {before:.2} stops where they show the same surfaces."));
    }
    ui.weak(format!("{} points, {} comparisons.", report.points, report.pairs));
    if report.groups > 1 {
        ui.weak(format!("{} groups of photos have no surfaces in common.", report.groups));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounds_to_nothing_has_no_sign() {
        for (stops, text) in [(-0.004, "0.00"), (0.004, "0.00"), (-0.006, "-0.01"), (1.5, "1.50")] {
            assert_eq!(format!("{:.2}", shown(stops)), text);
        }
    }
}
