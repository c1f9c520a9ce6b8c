//! The table of fillings, with a row for each photo, for `fill` and `info`.

use serde_json::{Value, json};

use super::bytes::readable_bytes;
use super::table::Table;
use quadratura_document::Stack;
use quadratura_stacks::fill::FillShares;

const HEADINGS: [&str; 10] = [
    "photo",
    "filling",
    "hidden",
    "of backdrops",
    "from photos",
    "from paint of others",
    "patch-based",
    "smooth",
    "empty",
    "size",
];

const LEGEND: &str = "
hidden: share of all texels that surfaces cover; of backdrops: hidden texels of objects whose name contains 'backdrop',
which are counted apart; the columns to its right: shares of all hidden texels
from photos, from paint of others: what other photos show of the surface, and what was painted on it in them; the
photo's own paint is laid over all of this, and is counted under `paint:` of `info`
patch-based, smooth: inpainted, because no photo shows the surface there; empty: left without colour
surroundings: what the photo above shows where no surface is, such as sky; no other row and no total contains it
";

/// What the row of a photo's surroundings is called.
const SURROUNDINGS: &str = "  surroundings";

/// A table of fillings.
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
    /// Adds the stack of a photo, whose filling is in the given state.
    pub fn add(&mut self, stack: &Stack, state: &str) {
        let shares = FillShares::from_stack(stack);
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let FillShares { from_photos, from_paint, by_example, diffused, empty, .. } = shares;
        let filled = [from_photos, from_paint, by_example, diffused, empty];
        let bytes = stack.fill.as_ref().map_or(String::new(), |fill| readable_bytes(fill.bytes));
        let name = stack.photo.name.clone();
        let hidden = [shares.hidden, shares.hidden_of_backdrops].map(percent);
        let cells = [name, state.to_owned()].into_iter().chain(hidden);
        self.table.row(cells.chain(filled.map(percent)).chain([bytes]));
        if let (Some(hidden), Some(filled)) = (shares.hidden_of_surroundings, shares.filled_of_surroundings) {
            let mut cells = vec![String::new(); HEADINGS.len() - 1];
            cells[0] = SURROUNDINGS.to_owned();
            cells[2] = percent(hidden);
            cells[HEADINGS.len() - 2] = percent(1.0 - filled);
            self.table.row(cells);
        }
        self.rows.push(json!({ "photo": stack.photo.name, "state": state, "shares": shares }));
    }

    /// Adds a photo that could not be filled.
    pub fn add_failed(&mut self, photo: &str) {
        self.table.row([photo.to_owned(), "failed".to_owned()]);
        self.rows.push(json!({ "photo": photo, "state": "failed" }));
    }

    /// Returns the table as text; empty without rows.
    pub fn text(&self) -> String {
        if self.rows.is_empty() { String::new() } else { format!("{}{LEGEND}", self.table.render()) }
    }

    /// Returns the rows as JSON.
    pub fn into_json(self) -> Value {
        self.rows.into()
    }
}
