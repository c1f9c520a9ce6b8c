//! The legend of colours, over the 3D view.

use eframe::egui::style::ScrollStyle;
use eframe::egui::{Color32, Label, Rect, ScrollArea, Sense, TextStyle, Ui, Vec2, pos2, vec2};

use super::view::SpacePaneView;
use crate::command;
use crate::panel::{small_button, text_width};
use crate::state::request::Request;
use quadratura_view::DisplayMode;
use quadratura_view::legend::{ColourRamp, Legend, colour_at, legend};

/// The size of a colour sample, in points.
const FIELD: Vec2 = vec2(16.0, 12.0);
/// The size of a colour ramp, in points.
const RAMP: Vec2 = vec2(240.0, 14.0);
/// The smallest gap between two marks of a ramp, in points.
const APART: f32 = 6.0;
/// The number of steps of a ramp, each too small to be visible.
const STEPS: u32 = 80;
/// The greatest height, in points: a site may have hundreds of photos.
const HIGHEST: f32 = 280.0;

/// Returns whether the picture that is shown has a legend and it is on.
pub fn is_shown(view: &SpacePaneView<'_>) -> bool {
    let space = &view.scene.space;
    space.legend_shown && space.shown_display() != DisplayMode::Colour && !space.exploded.is_on()
}

/// Draws the legend.
pub fn legend_ui(view: &SpacePaneView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let session = view.scene.session;
    let photos: Vec<&str> = session.opened.site.photos.iter().map(|photo| photo.name.as_str()).collect();
    let groups = match view.scene.space.shown_display() {
        DisplayMode::Group => view.colour.report(session).map(|report| report.described_groups()),
        _ => None,
    };
    let display = view.scene.space.shown_display();
    let Some(legend) = legend(display, &photos, &groups.unwrap_or_default()) else { return };
    let title = match &legend {
        Legend::Entries { title, .. } | Legend::Scale { title, .. } => title,
        Legend::Words(words) => words,
    };
    ui.horizontal_wrapped(|ui| {
        ui.strong(*title);
        if small_button(ui, "Hide", "Hide the legend", command::view::LEGEND.tooltip).clicked() {
            requests.push(view.commands.requested(&command::view::LEGEND));
        }
    });
    match &legend {
        Legend::Entries { entries, .. } => {
            // The bar is always there where the list is longer, so that one sees that there is more.
            ui.spacing_mut().scroll = ScrollStyle::solid();
            let list = ScrollArea::vertical().max_height(HIGHEST).id_salt("legend");
            let of_photos =
                matches!(view.scene.space.shown_display(), DisplayMode::Weights | DisplayMode::BestPhoto);
            let is_seen = |colour: &[u8; 3]| {
                !of_photos || view.scene.space.picture().is_some_and(|shown| shown.contains(*colour))
            };
            let seen = entries.iter().filter(|(_, colour)| is_seen(colour));
            list.show(ui, |ui| seen.for_each(|(name, colour)| entry(ui, name, *colour)));
        }
        Legend::Scale { ramp, marks, .. } => scale(ui, ramp, marks),
        Legend::Words(_) => (),
    }
    entry(ui, "grey: not covered by any photo", [128; 3]);
}

fn entry(ui: &mut Ui, name: &str, [r, g, b]: [u8; 3]) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(FIELD, Sense::hover());
        ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
        ui.label(name);
    });
}

fn scale(ui: &mut Ui, ramp: ColourRamp, marks: &[&str]) {
    let line = ui.text_style_height(&TextStyle::Body);
    let width = RAMP.x.min(ui.available_width());
    let (rect, _) = ui.allocate_exact_size(vec2(width, RAMP.y + 2.0 + line), Sense::hover());
    for step in 0..STEPS {
        let [r, g, b] = colour_at(ramp, (step as f32 + 0.5) / STEPS as f32);
        let part = width / STEPS as f32;
        let field = Rect::from_min_size(rect.min + vec2(step as f32 * part, 0.0), vec2(part, RAMP.y));
        ui.painter().rect_filled(field, 0.0, Color32::from_rgb(r, g, b));
    }
    let widths: Vec<f32> = marks.iter().map(|mark| text_width(ui, mark)).collect();
    for ((mark, width), left) in marks.iter().zip(&widths).zip(lefts(&widths, width)) {
        let at = pos2(rect.left() + left, rect.top() + RAMP.y + 2.0);
        // Half a point of tolerance prevents wrapping by rounding errors.
        ui.put(Rect::from_min_size(at, vec2(width + 0.5, line)), Label::new(*mark).extend());
    }
}

/// Returns the left edges of marks at equal distances along a ramp: the first and last are kept within it, the others
/// are centred at their positions and moved left as far as the next mark requires.
fn lefts(widths: &[f32], ramp: f32) -> Vec<f32> {
    let last = widths.len().saturating_sub(1).max(1) as f32;
    let mut right = ramp;
    let mut lefts: Vec<f32> = (0..widths.len()).map(|_| 0.0).collect();
    for (place, width) in widths.iter().enumerate().rev() {
        let middle = ramp * place as f32 / last;
        lefts[place] = (middle - width / 2.0).min(right - width).max(0.0);
        right = lefts[place] - APART;
    }
    lefts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stand_where_they_belong_and_none_over_another() {
        assert_eq!(lefts(&[10.0, 10.0, 10.0], 240.0), [0.0, 115.0, 230.0]);
        // The last mark is wide: the one before it moves left.
        let widths = [8.0, 8.0, 8.0, 78.0];
        let lefts = lefts(&widths, 240.0);
        assert_eq!(lefts, [0.0, 76.0, 148.0, 162.0]);
    }
}
