//! The table of stacks, a row a photo: what `build` made and what `info` finds.

use serde_json::{Value, json};

use super::bytes::readable_bytes;
use super::table::Table;
use crate::document::Stack;

const HEADINGS: [&str; 14] = [
    "photo",
    "state",
    "faces",
    "elements",
    "whole",
    "vis. layers",
    "image layers",
    "texels",
    "apart",
    "used",
    "cuts",
    "free",
    "forgiven",
    "size",
];

/// What the columns mean.
const LEGEND: &str = "
faces: nearest at one pixel at least; whole: objects in one element; texels, used: of all image layers,
against the photo's pixels; apart: if every face had a layer of its own; free: cuts that cost no element
";

/// Rows of stacks.
pub struct StackTable {
    table: Table,
    rows: Vec<Value>,
    violations: Vec<String>,
    has_stacks: bool,
}

impl Default for StackTable {
    fn default() -> Self {
        Self { table: Table::new(&HEADINGS), rows: Vec::new(), violations: Vec::new(), has_stacks: false }
    }
}

impl StackTable {
    /// Adds a photo; `stack` is what is on disk, if there is one.
    pub fn add(&mut self, photo: &str, state: &str, stack: Option<&Stack>) {
        let mut row = json!({ "photo": photo, "state": state });
        match stack {
            Some(stack) => {
                self.table.row(cells(photo, state, stack));
                row["stack"] = facts(stack);
                self.has_stacks = true;
                self.violations.extend(violations(stack));
            }
            None => self.table.row([photo.to_owned(), state.to_owned()]),
        }
        self.rows.push(row);
    }

    /// For people.
    pub fn text(&self) -> String {
        let legend = if self.has_stacks { LEGEND } else { "" };
        format!("{}{legend}{}", self.table.render(), self.violations.concat())
    }

    /// For programs: a list.
    pub fn into_json(self) -> Value {
        self.rows.into()
    }
}

fn cells(photo: &str, state: &str, stack: &Stack) -> Vec<String> {
    let counts = &stack.counts;
    let of_photo = |texels: u64| format!("{:.2}", texels as f64 / pixels(stack));
    let count = |number: u32| number.to_string();
    vec![
        photo.to_owned(),
        state.to_owned(),
        count(counts.faces),
        count(counts.elements),
        count(counts.whole_objects),
        count(counts.visibility_layers),
        stack.image_layers.len().to_string(),
        of_photo(stack.texels),
        of_photo(stack.texels_unmerged),
        of_photo(stack.texels_used),
        count(counts.cuts),
        count(counts.free_cuts),
        count(counts.forgiven),
        readable_bytes(stack.bytes),
    ]
}

fn facts(stack: &Stack) -> Value {
    json!({
        "method": stack.method,
        "width": stack.photo.width,
        "height": stack.photo.height,
        "counts": stack.counts,
        "image_layers": stack.image_layers.len(),
        "texels": stack.texels,
        "texels_used": stack.texels_used,
        "texels_unmerged": stack.texels_unmerged,
        "bytes": stack.bytes,
        "untextured": stack.untextured.len(),
        "notes": stack.notes,
    })
}

/// A stack made by the published method says how often its order is wrong.
fn violations(stack: &Stack) -> Option<String> {
    let (pairs, px) = (stack.counts.violations, stack.counts.violation_px);
    (pairs > 0).then(|| format!("{}: {pairs} pairs contradict the order, at {px} pixels\n", stack.photo.name))
}

fn pixels(stack: &Stack) -> f64 {
    f64::from(stack.photo.width) * f64::from(stack.photo.height)
}
