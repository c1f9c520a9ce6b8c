//! The table of stacks, with a row for each photo, for `build` and `info`.

use serde_json::{Value, json};

use super::bytes::readable_bytes;
use super::table::Table;
use quadratura_document::Stack;

const HEADINGS: [&str; 14] = [
    "photo",
    "state",
    "faces",
    "elements",
    "whole",
    "vis. layers",
    "image layers",
    "texels",
    "unmerged",
    "used",
    "cuts",
    "free cuts",
    "forgiven",
    "size",
];

/// The explanation of the columns.
const LEGEND: &str = "
faces: faces that are nearest at one pixel of the photo or more
elements: groups of faces that do not occlude each other; whole: objects that are a single element
texels: area of all image layers, relative to the photo's; used: the part of it that surfaces cover
unmerged: area if every face had an image layer of its own
cuts: cuts of faces that resolve cycles of occlusion; free cuts: those that added no element
forgiven: contradictions of a few pixels that were ignored as contact noise
";

/// A table of stacks.
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
    /// Adds a photo; `stack` is its stack on disk, if there is one.
    pub fn add(&mut self, photo: &str, state: &str, stack: Option<&Stack>) {
        self.add_worded(photo, state, state, stack);
    }

    /// Adds a photo whose state has one name in JSON, `state`, and another in the table, `word`.
    pub fn add_worded(&mut self, photo: &str, state: &str, word: &str, stack: Option<&Stack>) {
        let mut row = json!({ "photo": photo, "state": state });
        match stack {
            Some(stack) => {
                self.table.row(cells(photo, word, stack));
                row["stack"] = facts(stack);
                self.has_stacks = true;
                self.violations.extend(violations(stack));
            }
            None => self.table.row([photo.to_owned(), word.to_owned()]),
        }
        self.rows.push(row);
    }

    /// Returns the table as text.
    pub fn text(&self) -> String {
        let legend = if self.has_stacks { LEGEND } else { "" };
        format!("{}{legend}{}", self.table.render(), self.violations.concat())
    }

    /// Returns the rows as JSON.
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

/// Returns how often a stack of the published method contradicts its own order.
fn violations(stack: &Stack) -> Option<String> {
    let pairs = stack.counts.violations;
    let px = stack.counts.violation_px;
    (pairs > 0).then(|| format!("{}: {pairs} pairs contradict the order, at {px} pixels\n", stack.photo.name))
}

fn pixels(stack: &Stack) -> f64 {
    f64::from(stack.photo.width) * f64::from(stack.photo.height)
}
