//! What the colours of the 3D view mean, beside it.

use eframe::egui::{Align2, Color32, Label, Rect, Role, ScrollArea, Sense, Ui, Vec2, WidgetInfo, pos2, vec2};

use crate::app::command;
use crate::app::editor::{Ask, Editor};
use crate::projection::Shown;
use crate::projection::legend::{Legend, Ramp, colour_at, legend};

/// Of a colour's field.
const FIELD: Vec2 = vec2(16.0, 12.0);
/// Of a ramp.
const RAMP: Vec2 = vec2(240.0, 14.0);
/// A ramp is drawn in so many steps, each too small to be seen.
const STEPS: u32 = 80;
/// No higher, in points: a site may have hundreds of photos.
const HIGHEST: f32 = 280.0;

/// What is shown has a legend, and it is wanted.
pub fn is_shown(editor: &Editor) -> bool {
    let space = &editor.space;
    space.legend_shown && space.look.shown != Shown::Colour && !space.exploded.is_on()
}

/// Draws it.
pub fn legend_ui(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(session) = &editor.session else { return };
    let photos: Vec<&str> = session.opened.site.photos.iter().map(|photo| photo.name.as_str()).collect();
    let Some(legend) = legend(editor.space.look.shown, &photos) else { return };
    let title = match &legend {
        Legend::Entries { title, .. } | Legend::Scale { title, .. } => title,
        Legend::Words(words) => words,
    };
    ui.horizontal(|ui| {
        ui.strong(*title);
        let hides = ui.small_button("Hide").on_hover_text(command::view::LEGEND.tooltip);
        hides.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Hide the legend"));
        if hides.clicked() {
            asks.push(Ask::Run(&command::view::LEGEND));
        }
    });
    match &legend {
        Legend::Entries { entries, .. } => {
            let list = ScrollArea::vertical().max_height(HIGHEST).id_salt("legend");
            list.show(ui, |ui| entries.iter().for_each(|(name, colour)| entry(ui, name, *colour)));
        }
        Legend::Scale { ramp, marks, .. } => scale(ui, ramp, marks),
        Legend::Words(_) => (),
    }
    entry(ui, "grey: no photo serves it", [128; 3]);
}

fn entry(ui: &mut Ui, name: &str, [r, g, b]: [u8; 3]) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(FIELD, Sense::hover());
        ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
        ui.label(name);
    });
}

fn scale(ui: &mut Ui, ramp: Ramp, marks: &[&str]) {
    let line = ui.text_style_height(&eframe::egui::TextStyle::Body);
    let (rect, _) = ui.allocate_exact_size(RAMP + vec2(0.0, line + 2.0), Sense::hover());
    for step in 0..STEPS {
        let [r, g, b] = colour_at(ramp, (step as f32 + 0.5) / STEPS as f32);
        let width = RAMP.x / STEPS as f32;
        let field = Rect::from_min_size(rect.min + vec2(step as f32 * width, 0.0), vec2(width, RAMP.y));
        ui.painter().rect_filled(field, 0.0, Color32::from_rgb(r, g, b));
    }
    let last = marks.len().saturating_sub(1).max(1);
    for (place, mark) in marks.iter().enumerate() {
        let align = match place {
            0 => Align2::LEFT_TOP,
            place if place == last => Align2::RIGHT_TOP,
            _ => Align2::CENTER_TOP,
        };
        let at = pos2(rect.left() + RAMP.x * place as f32 / last as f32, rect.top() + RAMP.y + 2.0);
        let galley = ui.painter().layout_no_wrap((*mark).into(), Default::default(), Color32::WHITE);
        let width = galley.size().x.max(10.0) * 1.3;
        ui.put(align.anchor_size(at, vec2(width, line)), Label::new(*mark).extend());
    }
}
