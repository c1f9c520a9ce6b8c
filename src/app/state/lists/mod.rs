//! The lists on the left: the selected photo's image layers, and the objects of the model with their faces. Both are
//! one list of rows.

pub mod cursor;
pub mod layer_list;
pub mod merging;
mod removing;
pub mod row;
pub mod rows;

use std::collections::BTreeSet;

use self::row::ListRow;
use super::selection::Selection;
use quadratura_base::scene::PhotoId;
use quadratura_layers::LayerIndex;
use quadratura_stacks::decide::{LayerEdit, MergeCost};

/// The state of the lists: open rows, the filter, the cursor.
#[derive(Default)]
pub struct ListsState {
    /// The text that names must contain to be listed.
    pub filter: String,
    /// Rows whose open state differs from their default.
    turned: BTreeSet<ListRow>,
    /// The row of the keyboard cursor.
    pub cursor: Option<ListRow>,
    /// The start of a range of image layers: photo, and index in its stack.
    anchor: Option<(PhotoId, LayerIndex)>,
    /// Whether the list was scrolled to its top after a project was opened.
    pub begun: bool,
    /// The selection when the lists were drawn last.
    known: Selection,
    /// The merge that waits for confirmation.
    pub merging: Option<PendingMerge>,
    /// The removal of an object that waits for confirmation.
    pub removing: Option<PendingRemoval>,
}

/// A merge that waits for confirmation.
pub struct PendingMerge {
    edit: LayerEdit,
    /// The cost of the merged layer.
    pub cost: MergeCost,
}

/// The removal of an object that waits for confirmation, with its consequences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PendingRemoval {
    /// The name of the object.
    pub object: String,
    /// The number of its faces.
    pub faces: usize,
    /// The names of the photos whose layers become out of date.
    pub stale: Vec<String>,
    /// The names of the photos whose layers contain it.
    pub showing: Vec<String>,
}

impl ListsState {
    /// Resets the state that belongs to a project.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Returns whether a question is open.
    pub fn is_asking(&self) -> bool {
        self.merging.is_some() || self.removing.is_some()
    }

    /// Returns the start of a range of image layers: photo, and index in its stack.
    pub fn anchor(&self) -> Option<(PhotoId, LayerIndex)> {
        self.anchor
    }

    /// Sets the start of a range, after stacks were rebuilt.
    pub fn set_anchor(&mut self, anchor: Option<(PhotoId, LayerIndex)>) {
        self.anchor = anchor;
    }

    /// Returns whether a row is open.
    pub fn is_open(&self, row: ListRow) -> bool {
        row.is_open_at_first() != self.turned.contains(&row)
    }

    /// Opens or closes a row.
    pub fn set_open(&mut self, row: ListRow, open: bool) {
        if open == row.is_open_at_first() {
            self.turned.remove(&row);
        } else {
            self.turned.insert(row);
        }
    }

    /// Closes an open row, and opens a closed one.
    pub fn turn(&mut self, row: ListRow) {
        self.set_open(row, !self.is_open(row));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::ObjectId;

    #[test]
    fn a_row_that_is_turned_twice_is_as_it_was_at_first() {
        let mut lists = ListsState::default();
        for (row, open) in [(ListRow::Layers, true), (ListRow::Object(ObjectId(2)), false)] {
            assert_eq!(lists.is_open(row), open);
            lists.turn(row);
            assert_eq!(lists.is_open(row), !open);
            lists.turn(row);
            assert_eq!(lists.is_open(row), open);
        }
        assert!(lists.turned.is_empty());
    }

    #[test]
    fn another_project_begins_with_a_list_as_new() {
        let mut lists = ListsState { filter: "roof".into(), begun: true, ..ListsState::default() };
        lists.turn(ListRow::Objects);
        lists.set_anchor(Some((PhotoId(0), LayerIndex(3))));
        lists.forget();
        assert!(lists.filter.is_empty() && !lists.begun && lists.is_open(ListRow::Objects));
        assert_eq!(lists.anchor(), None);
    }
}
