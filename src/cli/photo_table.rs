//! The first table of `info`: a row for each photo with what has become of it.

use super::bytes::readable_bytes;
use super::table::Table;
use crate::document::Stack;
use crate::recipe::fill::FillShares;

const HEADINGS: [&str; 9] = [
    "photo",
    "state",
    "layers",
    "filling",
    "hidden",
    "from photos",
    "from paint of others",
    "inpainted",
    "size",
];

const LEGEND: &str = "
layers: image layers; hidden: share of the surfaces in them that the photo does not show, without backdrops
from photos, from paint of others, inpainted: how the hidden parts are filled; the photo's own paint lies over it
";

/// The states of photos.
pub struct PhotoTable(Table);

impl Default for PhotoTable {
    fn default() -> Self {
        Self(Table::new(&HEADINGS))
    }
}

impl PhotoTable {
    /// Adds a photo in a state; `stack` is its stack on disk, if there is one, and `filling` the state of its filling.
    pub fn add(&mut self, photo: &str, state: &str, stack: Option<&Stack>, filling: Option<&str>) {
        let Some(stack) = stack else {
            self.0.row([photo.to_owned(), state.to_owned()]);
            return;
        };
        let shares = FillShares::from_stack(stack);
        let inpainted = shares.by_example + shares.diffused;
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let filled = match &stack.fill {
            Some(_) => [shares.from_photos, shares.from_paint, inpainted].map(percent),
            None => Default::default(),
        };
        let names = [photo.to_owned(), state.to_owned(), stack.image_layers.len().to_string()];
        let names = names.into_iter().chain([filling.unwrap_or_default().to_owned(), percent(shares.hidden)]);
        let bytes = stack.bytes;
        self.0.row(names.chain(filled).chain([readable_bytes(bytes)]));
    }

    /// Returns the table as text.
    pub fn text(&self) -> String {
        format!("{}{LEGEND}", self.0.render())
    }
}
