//! The lists on the left: the selected photo's image layers, and the objects of the model with their faces.
//!
//! Both are one list of rows of equal height. Only visible rows are drawn: a model of twenty thousand faces costs the
//! same as one of twenty.

pub mod keys;
pub mod layers;
pub mod merging;
pub mod objects;
pub mod outliner;
pub mod row;
pub mod rows;
pub mod switching;
pub mod table;

use std::collections::BTreeSet;

use eframe::egui::{self, Id};

use self::merging::PendingMerge;
pub use self::outliner::outliner_ui;
use self::rows::ListRow;
pub use self::table::LayerList;
use crate::app::state::selection::Selection;

/// The state of the lists: open rows, the filter, the cursor.
#[derive(Default)]
pub struct ListsState {
    /// The text that names must contain to be listed.
    filter: String,
    /// Rows whose open state differs from their default.
    turned: BTreeSet<ListRow>,
    /// The row of the keyboard cursor.
    cursor: Option<ListRow>,
    /// The start of a range of image layers: photo, and index in its stack.
    anchor: Option<(usize, usize)>,
    /// Whether the list was scrolled to its top after a project was opened.
    begun: bool,
    /// The selection when the lists were drawn last.
    known: Selection,
    /// The merge that waits for confirmation.
    merging: Option<PendingMerge>,
    /// The widget id of the list, once it was drawn.
    id: Option<Id>,
}

impl ListsState {
    /// Resets the state that belongs to a project.
    pub fn forget(&mut self) {
        *self = Self { id: self.id, ..Self::default() };
    }

    /// Returns whether a question is open.
    pub fn asks(&self) -> bool {
        self.merging.is_some()
    }

    /// Returns the start of a range of image layers: photo, and index in its stack.
    pub fn anchor(&self) -> Option<(usize, usize)> {
        self.anchor
    }

    /// Sets the start of a range, after stacks were rebuilt.
    pub fn set_anchor(&mut self, anchor: Option<(usize, usize)>) {
        self.anchor = anchor;
    }

    /// Returns whether a row is open.
    fn is_open(&self, row: ListRow) -> bool {
        row.is_open_at_first() != self.turned.contains(&row)
    }

    fn set_open(&mut self, row: ListRow, open: bool) {
        if open == row.is_open_at_first() {
            self.turned.remove(&row);
        } else {
            self.turned.insert(row);
        }
    }

    /// Returns whether the list has the keyboard's focus.
    fn has_focus(&self, context: &egui::Context) -> bool {
        self.id.is_some_and(|id| context.memory(|memory| memory.has_focus(id)))
    }
}
