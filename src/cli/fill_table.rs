//! The table of fillings, a row a photo: what `fill` made and what `info` finds.

use serde_json::{Value, json};

use super::bytes::readable_bytes;
use super::table::Table;
use crate::document::Stack;
use crate::recipe::fill::FillShares;

const HEADINGS: [&str; 9] =
    ["photo", "filling", "hidden", "from photos", "from paint", "by example", "diffused", "empty", "size"];

const LEGEND: &str = "
hidden: of all texels that surfaces cover; the shares behind it: of the hidden ones
";

/// Rows of fillings.
pub struct FillTable {
    table: Table,
    rows: Vec<Value>,
}

impl Default for FillTable {
    fn default() -> Self {
        Self { table: Table::new(&HEADINGS), rows: Vec::new() }
    }
}

impl FillTable {
    /// Adds the stack of a photo.
    pub fn add(&mut self, stack: &Stack, state: &str) {
        let shares = FillShares::of(stack);
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let FillShares { from_photos, from_paint, by_example, diffused, empty, .. } = shares;
        let filled = [from_photos, from_paint, by_example, diffused, empty];
        let bytes = stack.fill.as_ref().map_or(String::new(), |fill| readable_bytes(fill.bytes));
        let name = stack.photo.name.clone();
        let cells = [name, state.to_owned(), percent(shares.hidden)].into_iter();
        self.table.row(cells.chain(filled.map(percent)).chain([bytes]));
        self.rows.push(json!({ "photo": stack.photo.name, "state": state, "shares": shares }));
    }

    /// Adds a photo without a filling.
    pub fn add_failed(&mut self, photo: &str) {
        self.table.row([photo.to_owned(), "failed".to_owned()]);
        self.rows.push(json!({ "photo": photo, "state": "failed" }));
    }

    /// For people; nothing without rows.
    pub fn text(&self) -> String {
        if self.rows.is_empty() { String::new() } else { format!("{}{LEGEND}", self.table.render()) }
    }

    /// For programs: a list.
    pub fn into_json(self) -> Value {
        self.rows.into()
    }
}
