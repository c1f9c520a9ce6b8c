//! The table of propagated paint, with a row for each photo, face and source photo.

use serde_json::{Value, json};

use super::table::Table;
use quadratura_document::stack::PropagationEntry;

const HEADINGS: [&str; 8] = [
    "photo",
    "face",
    "painted in",
    "projected",
    "own paint stays",
    "in conflict",
    "sources differ",
    "too coarse",
];

const LEGEND: &str = "
in conflict: pixels where the photo's own paint has a clearly different colour
sources differ: pixels where the paint of a third photo has a clearly different colour; the nearer paint is shown
too coarse: pixels that stay as the photo shows them, because the paint is less than half as fine
";

/// A table of propagated paint.
pub struct PropagatedTable {
    table: Table,
    rows: Vec<Value>,
}

impl Default for PropagatedTable {
    fn default() -> Self {
        Self { table: Table::new(&HEADINGS), rows: Vec::new() }
    }
}

impl PropagatedTable {
    /// Adds the paint that was projected to one photo.
    pub fn add(&mut self, photo: &str, propagated: &[PropagationEntry]) {
        for paint in propagated {
            let names = [photo, &paint.face, &paint.from].map(str::to_owned);
            let counts = [paint.texels, paint.own, paint.conflicts, paint.dissents, paint.coarse];
            self.table.row(names.into_iter().chain(counts.map(|count| count.to_string())));
            self.rows.push(json!({ "photo": photo, "paint": paint }));
        }
    }

    /// Returns the table as text under a title, in pixels; empty without rows.
    pub fn text(&self, title: &str) -> String {
        match self.rows.is_empty() {
            true => String::new(),
            false => format!("\n{title}, in pixels:\n{}{LEGEND}", self.table.render()),
        }
    }

    /// Returns the rows as JSON.
    pub fn into_json(self) -> Value {
        self.rows.into()
    }
}
