//! The inspector page of all trees: what they cost, the light on them, and masks of the real ones.

use eframe::egui::{DragValue, Grid, Label, RichText, Ui};
use glam::DVec3;

use super::tree::goes_on;
use crate::command::trees;
use crate::panel::inspect::view::InspectorView;
use crate::panel::{button, grouped, named, rows, small_button, title};
use crate::state::numbers::counted;
use crate::state::request::{DecideRequest, MaskRequest, Request, TreeRequest};
use crate::state::trees::light::{SunAngles, shown_strength, sun_angles, sun_direction, with_strength};
use quadratura_document::trees::{LightStrength, TreeLight, Trees};
use quadratura_trees::light::{LightSupport, clear_day, is_needed};

/// The largest margin of masks, in pixels.
const MOST_MARGIN: u32 = 512;
/// The change of light for each point of a drag.
const LIGHT_STEP: f64 = 0.01;

/// Draws the page of all trees.
pub fn trees_page(ui: &mut Ui, view: &InspectorView<'_>, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let all = session.trees();
    requests.push(TreeRequest::WantFigures.into());
    title(ui, "Project", "Trees");
    facts_ui(ui, view, all);
    ui.add_space(6.0);
    button(view.commands, ui, &trees::PLACE, requests);
    ui.separator();
    light_ui(ui, view, &all.light, session.scene_frame.up, requests);
    ui.separator();
    masks_ui(ui, view, requests);
}

fn facts_ui(ui: &mut Ui, view: &InspectorView<'_>, all: &Trees) {
    let of = |name: &str| all.placed.iter().filter(|tree| tree.species == name).count();
    let mut facts = vec![("Trees", grouped(all.placed.len() as u64))];
    let polygons = all.species.keys().map(|name| {
        let each = view.trees.figures_of(all, name).map(|figures| figures.counts.polygons);
        each.map(|each| each.saturating_mul(of(name) as u64))
    });
    if let Some(polygons) = polygons.sum::<Option<u64>>() {
        facts.push(("Polygons", grouped(polygons)));
    }
    for name in all.species.keys() {
        facts.push((name, of(name).to_string()));
    }
    rows(ui, &facts);
    for (name, species) in &all.species {
        if let Some(Err(problem)) = view.trees.figures.of(species) {
            ui.colored_label(ui.visuals().error_fg_color, format!("{name} is not shown: {problem}"));
        }
    }
}

/// Draws the light on all trees.
fn light_ui(
    ui: &mut Ui,
    view: &InspectorView<'_>,
    light: &TreeLight,
    up: DVec3,
    requests: &mut Vec<Request>,
) {
    ui.strong("Light");
    let now = light.strength.given().copied().or(view.trees.light.strength()).unwrap_or_else(clear_day);
    Grid::new("light on trees").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        sun_ui(ui, light, up, requests);
        strength_ui(ui, light, shown_strength(&now), requests);
    });
    ui.add(Label::new(RichText::new(source_of_light(view, light)).weak()).wrap());
    photos_ui(ui, view, light, requests);
    let default = *light == TreeLight::default();
    ui.add_enabled_ui(!default, |ui| {
        let tooltip = "Removes what was decided about the light on trees.";
        if small_button(ui, "Reset light", "Reset light", tooltip).clicked() {
            requests.push(TreeRequest::Light { light: TreeLight::default(), goes_on: false }.into());
        }
    });
}

/// Draws whether trees are as photos show them.
fn photos_ui(ui: &mut Ui, view: &InspectorView<'_>, light: &TreeLight, requests: &mut Vec<Request>) {
    let mut with_photos = !light.without_photos;
    let tooltip = "Seen from near a photo in which they are masked, trees are as bright and coloured as this photo shows them. \
                   They keep their own leaves, and light that is set here goes on top.";
    if ui.checkbox(&mut with_photos, "Match photos").on_hover_text(tooltip).changed() {
        let light = TreeLight { without_photos: !with_photos, ..*light };
        requests.push(TreeRequest::Light { light, goes_on: false }.into());
    }
    let is_needed = view.session.is_some_and(|session| is_needed(session.history.present()));
    if with_photos
        && is_needed
        && let Some(estimate) = view.trees.light.estimate()
    {
        let trees = estimate.ratios.len();
        let text = match trees {
            0 => "No photo shows enough of a masked tree. Mask the real trees, so that their light is taken from photos."
                .to_owned(),
            1 => "One tree has light from photos.".to_owned(),
            _ => format!("{trees} trees have light from photos."),
        };
        ui.add(Label::new(RichText::new(text).weak()).wrap());
    }
}

fn sun_ui(ui: &mut Ui, light: &TreeLight, up: DVec3, requests: &mut Vec<Request>) {
    let angles = sun_angles(light, up);
    type Set = fn(SunAngles, f64) -> SunAngles;
    let rows: [(&str, f64, std::ops::RangeInclusive<f64>, &str, Set); 2] = [
        (
            "Sun: bearing",
            angles.bearing,
            -360.0..=360.0,
            "Where the sun is, about what is up: against the clock as seen from above, from the x axis of the world.",
            |angles, bearing| SunAngles { bearing, ..angles },
        ),
        (
            "Sun: height",
            angles.height,
            -90.0..=90.0,
            "How high the sun is above the horizon.",
            |angles, height| SunAngles { height, ..angles },
        ),
    ];
    for (name, mut degrees, range, tooltip, set) in rows {
        let label = ui.label(name);
        let field = DragValue::new(&mut degrees).range(range).suffix("°").max_decimals(1).speed(0.5);
        let field = ui.add(field.update_while_editing(false)).labelled_by(label.id).on_hover_text(tooltip);
        if field.changed() {
            let sun = Some(sun_direction(set(angles, degrees), up));
            requests.push(
                TreeRequest::Light { light: TreeLight { sun, ..*light }, goes_on: goes_on(&field) }.into(),
            );
        } else if field.drag_stopped() {
            requests.push(DecideRequest::EndGesture.into());
        }
        ui.end_row();
    }
}

/// Says what the light is from.
fn source_of_light(view: &InspectorView<'_>, light: &TreeLight) -> String {
    if light.strength.given().is_some() {
        return "Given. Reset light to have it estimated from the photos.".into();
    }
    match view.trees.light.last() {
        None if view.session.is_none_or(|session| session.trees().placed.is_empty()) => {
            "Estimated from the photos once a tree stands.".into()
        }
        None => "It is being estimated from the photos.".into(),
        Some(Err(problem)) => format!("That of a clear day, because it could not be estimated: {problem}"),
        Some(Ok(estimate)) => match estimate.support {
            LightSupport::Photos { photos, blocks, split, .. } => {
                let ratio = if split {
                    ""
                } else {
                    " Fewer than 4 photos do, so sun and sky have their usual ratio."
                };
                let (photos, blocks) = (counted(photos as u64, "photo"), counted(blocks as u64, "block"));
                format!("Estimated from {photos} that show trees, in {blocks} of 8 × 8 pixels.{ratio}")
            }
            LightSupport::Faces { .. } => {
                "Estimated from the model beside the trees. Mask real trees to estimate it from them.".into()
            }
            LightSupport::ClearDay => {
                "That of a clear day: no photo shows a tree, or the model beside one.".into()
            }
        },
    }
}

fn strength_ui(ui: &mut Ui, light: &TreeLight, now: LightStrength, requests: &mut Vec<Request>) {
    type Part = fn(&mut LightStrength) -> &mut [f64; 3];
    let rows: [(&str, &str, Part); 3] = [
        ("Sun", "What a white surface reflects that faces the sun.", |light| &mut light.sun),
        ("Sky", "What a white surface reflects that looks up, without the sun.", |light| &mut light.sky),
        ("Ground", "What a white surface reflects that looks down.", |light| &mut light.ground),
    ];
    for (name, tooltip, part) in rows {
        let unit =
            "Linear light in the photos' common exposure, where 1 is the brightest light of a picture.";
        ui.label(name).on_hover_text(format!("{tooltip} {unit}"));
        ui.horizontal_wrapped(|ui| {
            for (channel, colour) in ["red", "green", "blue"].into_iter().enumerate() {
                let mut after = now;
                let value = &mut part(&mut after)[channel];
                let field = DragValue::new(value).speed(LIGHT_STEP).range(0.0..=1e3).max_decimals(3);
                let field = field.clamp_existing_to_range(false);
                let field = ui.add(field.update_while_editing(false)).on_hover_text(colour);
                named(&field, &format!("{name}: {colour}"));
                if field.changed() {
                    let light = with_strength(light, after);
                    requests.push(TreeRequest::Light { light, goes_on: goes_on(&field) }.into());
                } else if field.drag_stopped() {
                    requests.push(DecideRequest::EndGesture.into());
                }
            }
        });
        ui.end_row();
    }
}

fn masks_ui(ui: &mut Ui, view: &InspectorView<'_>, requests: &mut Vec<Request>) {
    ui.strong("Photos");
    ui.horizontal_wrapped(|ui| {
        button(view.commands, ui, &trees::MASK, requests);
        let mut margin = view.masking.margin_px;
        let field = ui.add(DragValue::new(&mut margin).range(0..=MOST_MARGIN).suffix(" px"));
        let label = ui.label("margin");
        let tooltip = "Pixels to mask around trees, because they are not quite like the real ones.";
        if field.labelled_by(label.id).on_hover_text(tooltip).changed() {
            requests.push(MaskRequest::Margin(margin).into());
        }
        button(view.commands, ui, &trees::CLEAR_MASKS, requests);
    });
}
