//! The question whether paint is seen from everywhere, with a picture of both, and where the answer is changed.

use std::sync::{Arc, Weak};

use eframe::egui::{Context, Frame, Image, RichText, Sense, TextureHandle, TextureOptions, Ui};

use crate::panel::paint::PaintView;
use crate::panel::pictures::image;
use crate::state::request::{QualityRequest, Request};
use crate::widget::spinner::Spinner;
use quadratura_stacks::fill::both_ways::BothWays;
use quadratura_stacks::fill::seen::{EditedPaint, Seen, SeenEdit};

/// The pictures of the question on the device.
#[derive(Default)]
pub struct QuestionTextures {
    /// The pictures that the textures show.
    of: Weak<BothWays>,
    /// Only in its photo, and from everywhere.
    textures: Option<[TextureHandle; 2]>,
}

impl QuestionTextures {
    /// Uploads new pictures, and drops those of the question before.
    fn follow(&mut self, both: Option<&Arc<BothWays>>, context: &Context) {
        let Some(both) = both else { return *self = Self::default() };
        if std::ptr::eq(self.of.as_ptr(), Arc::as_ptr(both)) {
            return;
        }
        let load = |name: &str, picture| context.load_texture(name, image(picture), TextureOptions::LINEAR);
        self.textures =
            Some([load("paint only here", &both.only_here), load("paint everywhere", &both.everywhere)]);
        self.of = Arc::downgrade(both);
    }
}

/// Draws the question where it is to be answered.
pub fn question_ui(
    ui: &mut Ui,
    view: &PaintView<'_>,
    textures: &mut QuestionTextures,
    requests: &mut Vec<Request>,
) {
    if !view.asks_where_seen {
        return textures.follow(None, ui.ctx());
    }
    requests.push(QualityRequest::WantBothWays.into());
    let lookup = &view.fill.both_ways;
    let both = lookup.found().and_then(Option::as_ref);
    textures.follow(both, ui.ctx());
    Frame::group(ui.style()).show(ui, |ui| {
        ui.label(RichText::new("Is paint seen from everywhere?").heading());
        ui.label(
            "This project was made before paint of one photo was shown in the others. It is seen only in its photo \
             until you choose.",
        );
        match (both, &textures.textures) {
            (Some(both), Some(textures)) => {
                side_by_side(ui, textures, ["Only in its photo", "From everywhere"], &both.photo);
                ui.weak(format!("{}, with paint of {}", both.photo, both.from.join(", ")));
            }
            _ if lookup.is_sought(view.running) => {
                ui.horizontal(|ui| {
                    ui.add(Spinner::new());
                    ui.label("Making a picture of both…");
                });
            }
            _ if lookup.found().is_some() => {
                ui.weak("No other photo shows the places that are painted now.");
            }
            _ => (),
        }
        answers(ui, requests);
    });
    ui.separator();
}

fn answers(ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.horizontal_wrapped(|ui| {
        let everywhere =
            "Projects paint to all photos that show the surface, and fills occluded areas again.";
        if ui.button("Show it from everywhere").on_hover_text(everywhere).clicked() {
            requests.push(QualityRequest::Propagate.into());
        }
        let only =
            "Paint replaces no pixels of other photos. You can change this later, also for single photos.";
        if ui.button("Only in its photo").on_hover_text(only).clicked() {
            requests
                .push(QualityRequest::See(SeenEdit { paint: EditedPaint::All, seen: Seen::OnlyHere }).into());
        }
        if ui.button("Later").on_hover_text("Asks again when the project is opened.").clicked() {
            requests.push(QualityRequest::ChooseLater.into());
        }
    });
}

/// Draws two pictures of a subject with their names, side by side where they fit.
pub fn side_by_side(ui: &mut Ui, textures: &[TextureHandle; 2], names: [&str; 2], subject: &str) {
    let room = ui.available_width();
    let width = ((room - ui.spacing().item_spacing.x) / 2.0).max(80.0).min(room);
    ui.horizontal_wrapped(|ui| {
        for (texture, name) in textures.iter().zip(names) {
            let size = texture.size_vec2();
            let shown = size * (width / size.x).min(width / size.y).min(8.0);
            ui.vertical(|ui| {
                ui.set_width(width);
                let (rect, response) = ui.allocate_exact_size(shown, Sense::hover());
                Image::new((texture.id(), size)).fit_to_exact_size(shown).paint_at(ui, rect);
                response.widget_info(|| {
                    let label = format!("{name}: {subject}");
                    eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Image, true, label)
                });
                ui.weak(name);
            });
        }
    });
}
