//! The table of image layers, with a row for each photo, and the list of those of which a photo shows little.

use serde_json::{Value, json};

use super::table::Table;
use quadratura_document::Stack;
use quadratura_layers::Options;
use quadratura_stacks::layer_report::{LayerReport, SMALL_PX};

const HEADINGS: [&str; 6] =
    ["image layers of", "layers", "parts per object", "median visible", "small", "barely visible faces"];

/// How a project of an earlier version gets the layers of new projects.
const HINT: &str = "every face has a layer, however little of it is visible; \
                    `build --save-options --min-visible 64` leaves the others out, as in new projects\n";

/// A table of image layers.
#[derive(Default)]
pub struct LayerTable {
    reports: Vec<(String, LayerReport)>,
}

impl LayerTable {
    /// Adds the stack of a photo.
    pub fn add(&mut self, stack: &Stack) {
        self.reports.push((stack.photo.name.clone(), LayerReport::new(stack)));
    }

    /// Returns the table as text, with what the project's options leave undone, and with `in_detail` the small layers;
    /// empty without rows.
    pub fn text(&self, in_detail: bool, options: &Options) -> String {
        if self.reports.is_empty() {
            return String::new();
        }
        let mut table = Table::new(&HEADINGS);
        for (photo, report) in &self.reports {
            table.row([
                photo.clone(),
                report.layers.to_string(),
                format!("{:.2}", report.parts_per_object),
                format!("{:.0} %", 100.0 * report.median_visible),
                report.small.len().to_string(),
                report.barely_visible.to_string(),
            ]);
        }
        let legend = format!(
            "\nmedian visible: half of the layers show a larger share of their surfaces\n\
             small: layers with fewer than {SMALL_PX} visible pixels; barely visible faces are in no layer\n"
        );
        let hint = if options.min_visible == 0 { HINT } else { "" };
        let small = if in_detail { self.small() } else { String::new() };
        format!("{}{legend}{hint}{small}", table.render())
    }

    /// Lists the small layers, photo by photo.
    fn small(&self) -> String {
        let mut text = String::new();
        for (photo, report) in self.reports.iter().filter(|(_, report)| !report.small.is_empty()) {
            text.push_str(&format!("\n{photo}: layers with fewer than {SMALL_PX} visible pixels\n"));
            let mut table = Table::default();
            for layer in &report.small {
                let pixels = format!("{} of {} pixels", layer.visible, layer.covered);
                table.row([format!("  {} [{}]", layer.name, layer.id), pixels, layer.why.clone()]);
            }
            text.push_str(&table.render());
        }
        text
    }

    /// Returns the reports as JSON, by photo.
    pub fn into_json(self) -> Value {
        self.reports.into_iter().map(|(photo, report)| (photo, json!(report))).collect()
    }
}
