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

use crate::command::Commands;
use crate::state::State;
use crate::state::flat::layer_views::LayerViews;
use crate::state::lists::ListsState;
use crate::state::lists::layer_list::LayerList;
use crate::state::lists::row::ListRow;
use crate::state::lists::rows::ListedSite;
use crate::state::quality::filling::FillSession;
use crate::state::request::Request;
use crate::state::running::Running;
use crate::state::selection::SelectionState;
use crate::state::space::visibility::ModelVisibility;
use crate::state::trees::TreesState;

/// The height of a row, in points: a line of text, large enough to be clicked.
const ROW: f32 = 23.0;

/// What the lists show beside the data of the site.
pub struct ListsView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// What is selected.
    selection: &'a SelectionState,
    /// The running jobs.
    running: &'a Running,
    /// The facts about fillings.
    fill: &'a FillSession,
    /// The trees of the project.
    trees: &'a TreesState,
    /// How layers are listed.
    layer_list: LayerList,
    /// Which layers are shown.
    layer_views: &'a LayerViews,
    /// Which objects the 3D view shows.
    visibility: &'a ModelVisibility,
}

impl<'a> ListsView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            selection: &state.selection,
            running: &state.running,
            fill: &state.quality.fill,
            trees: &state.trees,
            layer_list: state.settings.layer_list,
            layer_views: &state.flat.layer_views,
            visibility: &state.space.visibility,
        }
    }
}

/// The context for drawing rows.
struct Outliner<'a> {
    /// What the rows show beside the site.
    view: &'a ListsView<'a>,
    /// The data that the lists show.
    site: &'a ListedSite<'a>,
    /// The state of the lists.
    lists: &'a mut ListsState,
    /// The widget id of the list.
    id: Id,
    /// The requests pushed while drawing.
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
        self.view.layer_list.as_table
    }
}
