//! The lists on the left: the selected photo's image layers, and the objects of the model with their faces.
//!
//! Both are one list of rows of one height, of which only those in sight are made: a model of twenty thousand faces
//! costs what one of twenty costs.

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

use self::merging::Merging;
pub use self::outliner::outliner_ui;
use self::rows::Row;
pub use self::table::LayerList;
use crate::app::state::selection::Selection;

/// What is open, searched for and pointed at in the lists.
#[derive(Default)]
pub struct Lists {
    /// Only what has these letters in its name is listed.
    filter: String,
    /// Rows that are not as they are at first: closed, or open.
    turned: BTreeSet<Row>,
    /// Where the keyboard is.
    cursor: Option<Row>,
    /// Where a range of image layers begins.
    anchor: Option<(usize, usize)>,
    /// The list was shown from its top.
    begun: bool,
    /// What was selected when the lists were drawn last.
    known: Selection,
    /// A merge that waits for a yes.
    merging: Option<Merging>,
    /// The list as a widget, once it was drawn.
    id: Option<Id>,
}

impl Lists {
    /// Forgets what belonged to a project.
    pub fn forget(&mut self) {
        *self = Self { id: self.id, ..Self::default() };
    }

    /// A question waits for an answer.
    pub fn asks(&self) -> bool {
        self.merging.is_some()
    }

    /// Where a range of image layers begins: photo, and place in its stack.
    pub fn anchor(&self) -> Option<(usize, usize)> {
        self.anchor
    }

    /// Carries it over to other stacks.
    pub fn set_anchor(&mut self, anchor: Option<(usize, usize)>) {
        self.anchor = anchor;
    }

    /// The row shows what is below it.
    fn is_open(&self, row: Row) -> bool {
        row.is_open_at_first() != self.turned.contains(&row)
    }

    fn set_open(&mut self, row: Row, open: bool) {
        if open == row.is_open_at_first() {
            self.turned.remove(&row);
        } else {
            self.turned.insert(row);
        }
    }

    /// Arrow keys move through the list.
    fn has_focus(&self, context: &egui::Context) -> bool {
        self.id.is_some_and(|id| context.memory(|memory| memory.has_focus(id)))
    }
}
