//! How the image layers of a photo are listed: by depth, or as a table sorted by a column.

use serde::{Deserialize, Serialize};

use quadratura_stacks::layer_table::LayerColumn;

/// The display options of the list of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct LayerList {
    /// Whether layers are listed as a table, rather than by depth.
    pub as_table: bool,
    /// The column that the table is sorted by.
    pub column: LayerColumn,
    /// Whether the order is descending.
    pub falling: bool,
}

impl LayerList {
    /// Sorts by a column; reverses the order where the table is sorted by it already.
    pub fn sort_by(&mut self, column: LayerColumn) {
        self.falling = if self.column == column { !self.falling } else { column.descends_by_default() };
        self.column = column;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_click_on_a_heading_turns_the_order_round() {
        let mut list = LayerList::default();
        list.sort_by(LayerColumn::Waste);
        assert!(list.falling, "the most wasteful first");
        list.sort_by(LayerColumn::Waste);
        assert!(!list.falling);
        list.sort_by(LayerColumn::Name);
        assert!(!list.falling && list.column == LayerColumn::Name);
    }
}
