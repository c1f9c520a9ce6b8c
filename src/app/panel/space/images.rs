//! The bar of the 3D view while that is drawn from layered depth images: how much of them is hidden.

use eframe::egui::{Slider, Ui};

use super::view::SpacePaneView;
use crate::panel::bar::{BarPart, BarPosition};
use crate::panel::named;
use crate::state::request::Request;
use crate::state::space::memory::SpaceMemory;

/// The parts of the bar.
pub fn tools<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 1] {
    [BarPart::Tool(hidden_layers)]
}

/// Draws the choice of how many layers are hidden, nearest first.
fn hidden_layers(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    _: BarPosition,
    _: &mut Vec<Request>,
) {
    let known = view.scene.space.images.status.as_ref().map_or(0, |(status, _)| status.layers);
    // What is hidden stays hidden where the next image has fewer layers.
    let most = known.max(it.peeled);
    ui.horizontal(|ui| {
        ui.label("Layered depth image");
        ui.add_enabled_ui(most > 0, |ui| {
            let slider = Slider::new(&mut it.peeled, 0..=most.max(1));
            let slider = slider.custom_formatter(move |value, _| format!("{value:.0} of {most} layers"));
            let slider = ui.add(slider.text("hidden"));
            named(&slider, "depth layers hidden");
            slider.on_hover_text(
                "Hides the nearest depth pixels along each ray of the image's camera, to show what is behind them.",
            );
        });
    });
}
