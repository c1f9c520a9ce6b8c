//! The controls of how an image layer is shown: eye, solo, opacity.

use eframe::egui::{DragValue, Ui};

use crate::panel::named;
use crate::state::flat::layer_views::LayerViews;
use crate::state::request::{FlatRequest, Request};
use quadratura_base::scene::PhotoId;
use quadratura_document::ImageLayer;
use quadratura_layers::LayerIndex;

/// Draws the controls of a layer of a photo.
pub fn shown_ui(
    views: &LayerViews,
    ui: &mut Ui,
    photo: PhotoId,
    index: LayerIndex,
    layer: &ImageLayer,
    requests: &mut Vec<Request>,
) {
    ui.horizontal_wrapped(|ui| {
        let mut shown = views.is_shown(photo, layer);
        let eye = ui.checkbox(&mut shown, "Shown");
        if eye.on_hover_text("Shows the layer in the photo and the exploded view.").changed() {
            requests.push(FlatRequest::ShowLayer(photo, index, shown).into());
        }
        let mut solo = views.is_solo(photo, layer);
        let only = ui.checkbox(&mut solo, "Solo");
        if only.on_hover_text("Shows only this layer of the photo.").changed() {
            requests.push(FlatRequest::Solo(photo, index).into());
        }
        let plain = views.is_plain(photo);
        let all = ui.add_enabled(!plain, eframe::egui::Button::new("Show all layers").small());
        if all.on_hover_text("Shows all layers of the photo, opaque.").clicked() {
            requests.push(FlatRequest::ShowAllLayers(photo).into());
        }
    });
    let mut opacity = f32::from(views.opacity(photo, layer)) / 255.0 * 100.0;
    let value = DragValue::new(&mut opacity).range(0.0..=100.0).fixed_decimals(0).suffix(" %");
    let value = ui.horizontal_wrapped(|ui| {
        ui.label("Opacity");
        ui.add(value)
    });
    named(&value.inner, "Opacity");
    if value.inner.changed() {
        requests.push(FlatRequest::Opacity(photo, index, (opacity / 100.0 * 255.0).round() as u8).into());
    }
}
