//! The table of paint that was laid over other photos: a row a photo, face and painter.

use serde_json::{Value, json};

use super::table::Table;
use crate::document::stack::SpreadPaint;

const HEADINGS: [&str; 7] =
    ["photo", "face", "painted in", "laid over", "own paint stays", "in conflict", "two paints differ"];

const LEGEND: &str = "
in conflict: the photo's own paint clearly says something else; two paints differ: a third photo's does, and the
nearer one is shown
";

/// Rows of paint.
pub struct SpreadTable {
    table: Table,
    rows: Vec<Value>,
}

impl Default for SpreadTable {
    fn default() -> Self {
        Self { table: Table::new(&HEADINGS), rows: Vec::new() }
    }
}

impl SpreadTable {
    /// Adds what belongs on one photo.
    pub fn add(&mut self, photo: &str, spread: &[SpreadPaint]) {
        for paint in spread {
            let names = [photo, &paint.face, &paint.from].map(str::to_owned);
            let counts = [paint.texels, paint.own, paint.conflicts, paint.dissents];
            self.table.row(names.into_iter().chain(counts.map(|count| count.to_string())));
            self.rows.push(json!({ "photo": photo, "paint": paint }));
        }
    }

    /// For people, below a line that says what it is, in pixels; nothing without rows.
    pub fn text(&self, title: &str) -> String {
        match self.rows.is_empty() {
            true => String::new(),
            false => format!("\n{title}, in pixels:\n{}{LEGEND}", self.table.render()),
        }
    }

    /// For programs: a list.
    pub fn into_json(self) -> Value {
        self.rows.into()
    }
}
