//! The pages of the inspector about objects, faces and image layers.

pub mod layer;
pub mod next;
pub mod surface;
pub mod tree;
pub mod trees;
pub mod view;

use eframe::egui::{CollapsingHeader, Ui};

use super::rows;

/// The greatest height of lists on a page, in points: the parts below stay within reach.
const LIST: f32 = 260.0;

/// Draws facts that are seldom needed, closed until they are asked for.
pub fn details_ui(ui: &mut Ui, facts: &[(&str, String)]) {
    ui.add_space(8.0);
    CollapsingHeader::new("Details").id_salt("details").show(ui, |ui| rows(ui, facts));
}
