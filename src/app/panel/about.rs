//! The name and version of the program.

use eframe::egui::{Context, RichText, Window};

use crate::widget::dialog::escaped;

/// Draws *About* while it is open.
pub fn about_ui(device: Option<&str>, shown: &mut bool, context: &Context) {
    if !*shown {
        return;
    }
    Window::new("About Quadratura").open(shown).resizable(false).show(context, |ui| {
        ui.label(RichText::new(format!("Quadratura {}", env!("CARGO_PKG_VERSION"))).heading());
        ui.label("Image layers by proven visibility, from calibrated photos and a coarse model, to paint on and project back.");
        ui.add_space(4.0);
        ui.label(format!("Graphics device: {}", device.unwrap_or("none in use")));
        ui.label(format!("Licence: {}", env!("CARGO_PKG_LICENSE")));
    });
    *shown &= !escaped(context);
}
