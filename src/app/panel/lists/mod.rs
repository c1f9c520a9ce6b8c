//! The lists on the left: the selected photo's image layers, the trees, and the objects of the model with their faces.
//!
//! All are one list of rows of equal height. Only visible rows are drawn: a model of twenty thousand faces costs the
//! same as one of twenty.

mod keys;
mod layers;
mod objects;
pub mod outliner;
mod row;
mod table;
mod trees;

use eframe::egui::{Context, Id, Ui};

use crate::state::State;
use crate::state::lists::ListsState;
use crate::state::lists::row::ListRow;
use crate::state::lists::rows::ListedSite;
use crate::state::request::Request;

/// The height of a row, in points: a line of text, large enough to be clicked.
const ROW: f32 = 23.0;

/// The context for drawing rows.
struct Outliner<'a> {
    /// The state without the lists.
    state: &'a State,
    /// The data that the lists show.
    site: &'a ListedSite<'a>,
    /// The state of the lists.
    lists: &'a mut ListsState,
    /// The widget id of the list.
    id: Id,
    /// The asks pushed while drawing.
    requests: &'a mut Vec<Request>,
}

impl Outliner<'_> {
    /// Returns whether the list has the keyboard's focus.
    fn has_focus(&self, context: &Context) -> bool {
        context.memory(|memory| memory.has_focus(self.id))
    }

    /// Moves the keyboard's focus and cursor to a row that was clicked.
    fn take_focus(&mut self, ui: &Ui, row: ListRow) {
        self.lists.cursor = Some(row);
        ui.ctx().memory_mut(|memory| memory.request_focus(self.id));
    }

    /// Returns the widget id of a row.
    fn id_of(&self, row: ListRow) -> Id {
        Id::unique(("row of the lists", row))
    }

    fn as_table(&self) -> bool {
        self.state.settings.layer_list.as_table
    }
}
