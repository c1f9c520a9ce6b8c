//! The first table of `info`: a row for each photo with what has become of it.

use super::bytes::readable_bytes;
use super::table::Table;
use quadratura_document::Stack;
use quadratura_stacks::fill::FillShares;

/// The headings of [`filling_cells`].
pub const FILLING_HEADINGS: [&str; 4] = ["hidden", "from photos", "from paint of others", "inpainted"];

const LEGEND: &str = "
layers: image layers; hidden: share of the surfaces in them that the photo does not show, without backdrops and surroundings
from photos, from paint of others, inpainted: how the hidden parts, those of backdrops included, are filled;
what is missing to 100 % is empty; the photo's own paint lies over it
";

/// The table of the states of photos.
pub struct PhotoStateTable(Table);

impl Default for PhotoStateTable {
    fn default() -> Self {
        let headings = [&["photo", "state", "layers", "filling"], &FILLING_HEADINGS[..], &["size"]].concat();
        Self(Table::new(&headings))
    }
}

impl PhotoStateTable {
    /// Adds a photo in a state; `stack` is its stack on disk, if there is one, and `filling` the state of its filling.
    pub fn add(&mut self, photo: &str, state: &str, stack: Option<&Stack>, filling: Option<&str>) {
        let Some(stack) = stack else {
            self.0.row([photo.to_owned(), state.to_owned()]);
            return;
        };
        let layers = stack.image_layers.len().to_string();
        let names = [photo.to_owned(), state.to_owned(), layers, filling.unwrap_or_default().to_owned()];
        self.0.row(names.into_iter().chain(filling_cells(stack)).chain([readable_bytes(stack.bytes)]));
    }

    /// Returns the table as text.
    pub fn text(&self) -> String {
        format!("{}{LEGEND}", self.0.render())
    }
}

/// Returns the hidden share of a stack, and how it is filled: empty without a filling.
pub fn filling_cells(stack: &Stack) -> [String; 4] {
    let shares = FillShares::from_stack(stack);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let inpainted = shares.by_example + shares.diffused;
    let filled = [shares.from_photos, shares.from_paint, inpainted];
    let [photos, paint, inpainted] =
        filled.map(|share| stack.fill.as_ref().map_or_else(String::new, |_| percent(share)));
    [percent(shares.hidden), photos, paint, inpainted]
}
