//! The list as a widget: the visible rows, a search field, and clicks on rows.

use eframe::egui::{Rect, Role, ScrollArea, Sense, TextEdit, Ui, WidgetInfo, pos2, vec2};

use super::layers::wanted_figures;
use super::{ListsView, Outliner, ROW};
use crate::state::State;
use crate::state::lists::ListsState;
use crate::state::lists::row::ListRow;
use crate::state::lists::rows::{ListedSite, rows};
use crate::state::request::Request;
use crate::widget::focus::{FocusKind, mark};

/// The number of rows above which the list has a search field.
const SEARCHED: usize = 12;

/// The width of the button that clears the field, with the gap before it, in points.
const CLEAR: f32 = 32.0;
/// The margin right of the field, in points.
const RIGHT: f32 = 4.0;

/// Draws the list.
pub fn outliner_ui(ui: &mut Ui, state: &State, lists: &mut ListsState, requests: &mut Vec<Request>) {
    let (Some(site), view) = (ListedSite::from_state(state), &ListsView::new(state)) else { return };
    requests.extend(wanted_figures(view.layer_list, site.photo, ui.available_width()));
    let id = ui.make_persistent_id("layers and objects");
    Outliner { view, site: &site, lists, id, requests }.ui(ui);
}

impl Outliner<'_> {
    fn ui(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        self.filter_ui(ui);
        let follows = self.lists.follow(self.view.selection.main, self.site, self.as_table());
        let rows = rows(self.view.layer_list, self.view.fill, self.lists, self.site);
        let list = ui.interact(ui.available_rect_before_wrap(), self.id, Sense::focusable_noninteractive());
        list.widget_info(|| WidgetInfo::labeled(Role::Tree, true, "Layers and objects"));
        mark(&list, FocusKind::List);
        let goes = self.keys(ui, &rows);
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
            field.on_hover_text("Lists only layers and objects whose names contain these letters.");
            if clear {
                let button = ui.small_button("×");
                button.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Clear the search"));
                if button.clicked() {
                    self.lists.filter.clear();
                }
            }
        });
        ui.add_space(2.0);
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
            ListRow::Trees => self.trees_title(ui),
            ListRow::Species(number) => self.species(ui, number),
            ListRow::Tree(tree) => self.tree(ui, tree),
            ListRow::Objects => self.objects_title(ui),
            ListRow::Object(object) => self.object(ui, object),
            ListRow::Face(object, index) => self.face(ui, object, index),
            ListRow::Say(words) => self.say(ui, words),
        }
    }
}
