//! The window that lists what is suggested to complete the model.

pub mod glass;

use eframe::egui::{
    Button, Checkbox, Color32, Context, Grid, RichText, ScrollArea, TextEdit, Ui, Window, vec2,
};

use self::glass::colour_of_offer;
use crate::panel::{counted, named, small_button};
use crate::state::model_suggestions::{ModelSuggestions, OfferedObject};
use crate::state::request::{ModelRequest, Request};
use crate::state::running::{JobKind, Running};
use crate::widget::spinner::Spinner;

/// The size of the names' fields, the width of the window, and the greatest height of the list, in points.
const NAME: [f32; 2] = [130.0, 20.0];
const WIDTH: f32 = 400.0;
const LIST: f32 = 300.0;

/// Draws the window while it is shown; what is typed and ticked is changed in `offered`.
pub fn model_suggestions_ui(
    context: &Context,
    running: &Running,
    shown: bool,
    offered: &mut Option<ModelSuggestions>,
    requests: &mut Vec<Request>,
) {
    let Some(offered) = offered.as_mut().filter(|_| shown) else { return };
    let mut open = true;
    let window = Window::new("Suggestions for the model").open(&mut open).resizable(false);
    window.default_pos([860.0, 400.0]).show(context, |ui| {
        ui.set_width(WIDTH);
        ui.label("Glass in the photo and in the 3D view shows what the model lacks. Drag an edge to extend a face along its plane.");
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(LIST).show(ui, |ui| list(ui, offered, requests));
        ui.add_space(4.0);
        buttons(ui, offered, running.runs(JobKind::Model), requests);
    });
    if !open {
        requests.push(ModelRequest::Hide.into());
    }
}

fn list(ui: &mut Ui, offered: &mut ModelSuggestions, requests: &mut Vec<Request>) {
    let mut pointed = None;
    Grid::new("suggestions for the model").num_columns(5).min_col_width(0.0).spacing([10.0, 4.0]).show(
        ui,
        |ui| {
            for (index, object) in offered.objects.iter_mut().enumerate() {
                if row(ui, index, object, requests) {
                    pointed = Some(index);
                }
                ui.end_row();
            }
        },
    );
    offered.pointed = pointed;
}

/// Draws an object; returns whether the pointer is on its row.
fn row(ui: &mut Ui, index: usize, object: &mut OfferedObject, requests: &mut Vec<Request>) -> bool {
    let name = object.name.clone();
    let (swatch, seen) = ui.allocate_exact_size(vec2(14.0, 14.0), eframe::egui::Sense::hover());
    ui.painter().rect_filled(swatch, 3.0, colour_of_offer(index));
    let tick =
        ui.add(Checkbox::without_text(&mut object.wanted)).on_hover_text("Whether it is added to the model.");
    named(&tick, &format!("Add {name}"));
    let field = ui.add_sized(NAME, TextEdit::singleline(&mut object.name));
    named(&field, &format!("Name of suggestion {}", index + 1));
    let figures = ui.label(figures(object)).on_hover_text(
        "The gain is by how much the object lowers the error of photos that are predicted from the others, where they show it \
         (of 255). The share is that of the photos that confirm it.",
    );
    let reject =
        small_button(ui, "Reject", &format!("Reject {name}"), "Removes it; it is not offered again.");
    if reject.clicked() {
        requests.push(ModelRequest::Reject(index).into());
    }
    [seen, tick, field, figures, reject].iter().any(|response| response.hovered())
}

fn figures(object: &OfferedObject) -> RichText {
    let faces = counted(object.faces.len() as u64, "face");
    if object.is_changed {
        return RichText::new(format!("{faces}, extended"));
    }
    let gain = object.gain.map_or_else(String::new, |gain| format!(", gain {gain:.1}"));
    RichText::new(format!("{faces}{gain}, {:.0} %", 100.0 * object.confidence))
}

fn buttons(ui: &mut Ui, offered: &ModelSuggestions, runs: bool, requests: &mut Vec<Request>) {
    let wanted = offered.objects.iter().filter(|object| object.wanted).count();
    ui.horizontal(|ui| {
        let text = format!("Add {} to the model", counted(wanted as u64, "object"));
        let add = Button::new(RichText::new(text).strong());
        let help = "Writes them to the model’s file (OBJ), or to a copy of a model of another format, as one step that can be undone.";
        if ui.add_enabled(wanted > 0 && !runs, add).on_hover_text(help).clicked() {
            requests.push(ModelRequest::Add.into());
        }
        let again = ui.add_enabled(!runs, Button::new("Suggest again"));
        if again.on_hover_text("Searches once more, with the model as it is now.").clicked() {
            requests.push(ModelRequest::SuggestAgain.into());
        }
        if runs {
            ui.add(Spinner::new());
        }
    });
}

/// The colours of suggestions, repeated.
pub const COLOURS: [Color32; 6] = [
    Color32::from_rgb(0x40, 0xd8, 0xff),
    Color32::from_rgb(0x7c, 0xf0, 0x7c),
    Color32::from_rgb(0xff, 0xd0, 0x40),
    Color32::from_rgb(0xff, 0x80, 0xd0),
    Color32::from_rgb(0xb0, 0x90, 0xff),
    Color32::from_rgb(0xff, 0x98, 0x60),
];
