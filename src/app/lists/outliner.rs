//! The list as a widget: the visible rows, a search field, and clicks on rows.

use eframe::egui::{Id, Rect, Role, ScrollArea, Sense, TextEdit, Ui, WidgetInfo, pos2, vec2};

use super::ListsState;
use super::row::ROW;
use super::rows::{ListRow, ListedSite, rows};
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::selection::Selection;

/// The number of rows above which the list has a search field.
const SEARCHED: usize = 12;

/// The width of the button that clears the field, with the gap before it, in points.
const CLEAR: f32 = 32.0;
/// The margin right of the field, in points.
const RIGHT: f32 = 4.0;

/// Draws the list.
pub fn outliner_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    super::layers::want_figures(editor, ui.available_width());
    // The lists change while the rest of the state is read.
    let mut lists = std::mem::take(&mut editor.state.lists);
    let state = &editor.state;
    if let Some(site) = ListedSite::from_state(state) {
        Outliner { state, site: &site, lists: &mut lists, asks }.ui(ui);
    }
    editor.state.lists = lists;
}

/// The context for drawing rows.
pub(super) struct Outliner<'a> {
    /// The state without the lists.
    pub state: &'a State,
    /// The data that the lists show.
    pub site: &'a ListedSite<'a>,
    /// The state of the lists.
    pub lists: &'a mut ListsState,
    /// The asks pushed while drawing.
    pub asks: &'a mut Vec<Ask>,
}

impl Outliner<'_> {
    fn ui(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        self.filter_ui(ui);
        let follows = self.follow_selection();
        let rows = rows(self.state, self.lists, self.site);
        let id = ui.make_persistent_id("layers and objects");
        self.lists.id = Some(id);
        let list = ui.interact(ui.available_rect_before_wrap(), id, Sense::focusable_noninteractive());
        list.widget_info(|| WidgetInfo::labeled(Role::Tree, true, "Layers and objects"));
        let goes = self.keys(ui, id, &rows);
        let sought = self.lists.cursor.filter(|_| follows || goes);
        ui.spacing_mut().item_spacing.y = 0.0;
        let area = ScrollArea::vertical().auto_shrink(false);
        // The list of another project starts at its top.
        let begun = std::mem::replace(&mut self.lists.begun, true);
        let area = if begun { area } else { area.vertical_scroll_offset(0.0) };
        area.show_rows(ui, ROW, rows.len(), |ui, seen| {
            let top = ui.max_rect().top() - seen.start as f32 * ROW;
            for layer_index in seen.clone() {
                self.row(ui, layer_index, &rows);
            }
            self.keep_head(ui, top, &rows);
            if let Some(layer_index) = sought.and_then(|sought| rows.iter().position(|row| *row == sought)) {
                let at = pos2(ui.max_rect().left(), top + layer_index as f32 * ROW);
                ui.scroll_to_rect(Rect::from_min_size(at, vec2(1.0, ROW)), None);
            }
        });
    }

    /// Keeps the headings visible while rows of the table are at the top of the visible part.
    fn keep_head(&mut self, ui: &mut Ui, top: f32, rows: &[ListRow]) {
        let edge = ui.clip_rect().top();
        let Some(head) = rows.iter().position(|row| *row == ListRow::Head) else { return };
        let last = rows.iter().rposition(|row| matches!(row, ListRow::Layer(_))).unwrap_or(head);
        let [above, below] = [head, last].map(|layer_index| top + layer_index as f32 * ROW);
        if above < edge && below > edge {
            let width = ui.max_rect().width();
            self.head(ui, Rect::from_min_size(pos2(ui.max_rect().left(), edge), vec2(width, ROW)));
        }
    }

    fn filter_ui(&mut self, ui: &mut Ui) {
        let layers = self.site.stack().map_or(0, |stack| stack.image_layers.len());
        if layers.max(self.site.whole.objects.len()) <= SEARCHED {
            self.lists.filter.clear();
            return;
        }
        ui.horizontal(|ui| {
            let clear = !self.lists.filter.is_empty();
            let width = ui.available_width() - if clear { CLEAR } else { RIGHT };
            let field = TextEdit::singleline(&mut self.lists.filter).hint_text("Find by name");
            let field = ui.add(field.desired_width(width));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("Find by name"));
            field.on_hover_text("Lists only layers and objects that have these letters in their names.");
            if clear {
                let button = ui.small_button("×");
                button.widget_info(|| WidgetInfo::labeled(Role::Button, true, "List everything again"));
                if button.clicked() {
                    self.lists.filter.clear();
                }
            }
        });
        ui.add_space(2.0);
    }

    /// Follows a selection made elsewhere: opens and scrolls to its row; returns whether the selection changed.
    fn follow_selection(&mut self) -> bool {
        let selection = self.state.selection;
        if std::mem::replace(&mut self.lists.known, selection) == selection {
            return false;
        }
        let as_table = self.state.settings.layer_list.as_table;
        let Some((row, above)) = self.site.row_of(selection, as_table) else { return false };
        above.into_iter().for_each(|row| self.lists.set_open(row, true));
        self.lists.cursor = Some(row);
        true
    }

    /// Returns whether a row is selected, alone or with others.
    pub(super) fn is_selected(&self, row: ListRow) -> bool {
        let state = self.state;
        self.site.selection(row).is_some_and(|this| match this {
            Selection::Layer { photo, layer } => {
                state.selection == this || state.more_layers.contains(&(photo, layer))
            }
            _ => state.selection == this,
        })
    }

    fn row(&mut self, ui: &mut Ui, layer_index: usize, rows: &[ListRow]) {
        let row = rows[layer_index];
        match row {
            ListRow::Layers => self.layers_title(ui),
            ListRow::Head => {
                let (_, rect) = ui.allocate_space(vec2(ui.available_width(), ROW));
                // Headings above the visible part are drawn at its top.
                if rect.top() >= ui.clip_rect().top() {
                    self.head(ui, rect);
                }
            }
            ListRow::Depth(order) => self.depth(ui, order),
            ListRow::Layer(layer) => self.layer(ui, layer, rows),
            ListRow::Objects => self.objects_title(ui),
            ListRow::Object(object) => self.object(ui, object),
            ListRow::Face(object, index) => self.face(ui, object, index),
            ListRow::Say(words) => self.say(ui, words),
        }
    }

    /// Moves the keyboard's focus and cursor to a row that was clicked.
    pub(super) fn take_focus(&mut self, ui: &Ui, row: ListRow) {
        self.lists.cursor = Some(row);
        if let Some(id) = self.lists.id {
            ui.ctx().memory_mut(|memory| memory.request_focus(id));
        }
    }

    /// Returns the widget id of a row.
    pub(super) fn id(&self, row: ListRow) -> Id {
        Id::unique(("row of the lists", row))
    }
}
