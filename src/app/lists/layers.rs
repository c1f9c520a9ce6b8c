//! Rows of image layers, and the selection of several.

use eframe::egui::{Align, Button, RichText, Role, Ui, WidgetInfo};

use super::outliner::Outliner;
use super::row::{DrawnRow, RowText, text_in};
use super::rows::ListRow;
use super::table::columns;
use crate::app::action::quality::filling::want_shares;
use crate::app::command::layers::AS_TABLE;
use crate::app::editor::Editor;
use crate::app::panel::{grouped, percent};
use crate::app::state::State;
use crate::app::state::ask::{Ask, SelectAsk};
use crate::app::state::selection::Selection;
use crate::document::ImageLayer;
use crate::recipe::layer_table::{Column, LayerFigures};

/// The width of the button that turns the list into a table, in points.
const TABLE: f32 = 52.0;
/// The width of `100 % hidden`, in points.
const HIDDEN: f32 = 92.0;
/// The list width below which only the share is shown, in points.
const ROOM: f32 = 230.0;
/// The width of `100 %`, in points.
const SHARE: f32 = 46.0;

/// Requests the figures that the table shows.
pub(super) fn want_figures(editor: &mut Editor, width: f32) {
    let list = editor.state.settings.layer_list;
    let shows_trust = list.as_table && columns(width, list.column).contains(&Column::Trust);
    if let Some(photo) = editor.state.selected_photo().filter(|_| shows_trust) {
        want_shares(&mut editor.state, &mut editor.work, photo);
    }
}

impl State {
    /// Returns the confidence of the filling of each layer of the selected photo, 0 to 1, where it is known.
    pub fn layer_trust(&self) -> Vec<Option<f64>> {
        let shares = self.selected_photo().and_then(|photo| self.quality.fill.shares.get(&photo)?.found());
        let trust = |shares: &crate::recipe::fill::shares::LayerShares| {
            (shares.filled() > 0).then_some(shares.confidence)
        };
        shares.map(|shares| shares.iter().map(trust).collect()).unwrap_or_default()
    }
}

impl Outliner<'_> {
    pub(super) fn layers_title(&mut self, ui: &mut Ui) {
        let Some(photo) = self.site.photo else { return };
        let count = self.site.stack().map(|stack| format!(" ({})", stack.image_layers.len()));
        let name = &self.site.session.opened.site.photos[photo].name;
        let name = format!("Layers of {name}{}", count.unwrap_or_default());
        let mut line = self.line(ui, ListRow::Layers, &name);
        let rect = line.take_right(TABLE).shrink2([0.0, 2.0].into());
        let as_table = self.state.settings.layer_list.as_table;
        let button = ui.put(rect, Button::selectable(as_table, RichText::new("Table").small()));
        button.widget_info(|| WidgetInfo::selected(Role::Button, true, as_table, AS_TABLE.name));
        if button.on_hover_text(AS_TABLE.tooltip).clicked() {
            self.asks.push(AS_TABLE.asked(self.state));
        }
        line.text(ui, &name, RowText::Strong);
        self.title_clicked(ui, ListRow::Layers, &line);
    }

    pub(super) fn depth(&mut self, ui: &mut Ui, order: u32) {
        let layers = self.site.stack().map(|stack| &stack.image_layers[..]).unwrap_or_default();
        let count = layers.iter().filter(|layer| layer.order == order).count();
        let name = match order {
            0 => format!("In front ({count})"),
            order => format!("Behind {order} ({count})"),
        };
        let line = self.line(ui, ListRow::Depth(order), &name);
        line.text(ui, &name, RowText::Plain);
        self.title_clicked(ui, ListRow::Depth(order), &line);
        line.response.on_hover_text(match order {
            0 => "Image layers that nothing of the photo hides.".to_owned(),
            _ => format!(
                "Image layers at depth {order}: so many others lie before them, one hidden by the other. An image layer \
                 may hold surfaces of several visibility layers; so depths are more than those."
            ),
        });
    }

    pub(super) fn layer(&mut self, ui: &mut Ui, index: usize, rows: &[ListRow]) {
        let Some(layer) = self.site.stack().and_then(|stack| stack.image_layers.get(index)) else { return };
        let row = ListRow::Layer(index);
        let mut line = self.line(ui, row, &layer.name);
        let figures = LayerFigures::from_layer(layer);
        if self.state.settings.layer_list.as_table {
            self.cells(ui, &mut line, index, layer);
        } else if figures.hidden > 0 {
            let share = percent(figures.hidden, figures.used);
            let (text, width) = match line.response.rect.width() {
                ROOM.. => (format!("{share} hidden"), HIDDEN),
                _ => (share, SHARE),
            };
            let weak = ui.visuals().weak_text_color();
            text_in(ui, line.take_right(width), &text, weak, Align::Max);
        }
        line.text(ui, &layer.name, RowText::Plain);
        self.layer_clicked(ui, index, &line, rows);
        line.response.on_hover_ui(|ui| layer_tooltip(ui, layer, &figures));
    }

    fn layer_clicked(&mut self, ui: &Ui, index: usize, line: &DrawnRow, rows: &[ListRow]) {
        let response = &line.response;
        if response.double_clicked() {
            self.activate(ListRow::Layer(index));
        } else if response.clicked() {
            let modifiers = ui.input(|input| input.modifiers);
            self.take_focus(ui, ListRow::Layer(index));
            match (modifiers.shift, modifiers.command) {
                (true, _) => self.select_range(rows, index),
                (false, true) => {
                    let Some(photo) = self.site.photo else { return };
                    self.lists.anchor = Some((photo, index));
                    self.asks.push(Ask::Select(SelectAsk::Toggle(photo, index)));
                }
                (false, false) => self.select_layer(index),
            }
        }
    }

    /// Selects one layer and makes it the anchor of a range.
    pub(super) fn select_layer(&mut self, layer: usize) {
        let Some(photo) = self.site.photo else { return };
        self.lists.anchor = Some((photo, layer));
        self.asks.push(Ask::Select(SelectAsk::Only(Selection::Layer { photo, layer })));
    }

    /// Selects the listed layers from the anchor to this one.
    pub(super) fn select_range(&mut self, rows: &[ListRow], to: usize) {
        let Some(photo) = self.site.photo else { return };
        let begun = self.lists.anchor.filter(|(of, _)| *of == photo).map(|(_, layer)| layer);
        let selected = match self.state.selection {
            Selection::Layer { photo: of, layer } if of == photo => Some(layer),
            _ => None,
        };
        let layers: Vec<usize> = rows
            .iter()
            .filter_map(|row| if let ListRow::Layer(layer) = row { Some(*layer) } else { None })
            .collect();
        let from = begun.or(selected).unwrap_or(to);
        self.lists.anchor = Some((photo, from));
        self.asks.push(Ask::Select(SelectAsk::Layers(photo, between(&layers, from, to))));
    }
}

/// Returns the part of a list between two entries, inclusive, with `to` last; only `to` where `from` is not in the
/// list.
fn between(listed: &[usize], from: usize, to: usize) -> Vec<usize> {
    let index = |of: usize| listed.iter().position(|layer| *layer == of);
    let (Some(a), Some(b)) = (index(from), index(to)) else { return vec![to] };
    let mut range = listed[a.min(b)..=a.max(b)].to_vec();
    if b < a {
        range.reverse();
    }
    range
}

/// Draws the tooltip of a layer in a few lines.
fn layer_tooltip(ui: &mut Ui, layer: &ImageLayer, figures: &LayerFigures) {
    ui.strong(&layer.name);
    ui.label(format!("{} × {} px, {} texels", layer.rect.w, layer.rect.h, grouped(figures.texels)));
    let (used, hidden) = (percent(figures.used, figures.texels), percent(figures.hidden, figures.used));
    ui.label(format!("{used} used, {hidden} of that hidden in the photo"));
    if figures.hidden > 0 {
        ui.label(format!("{} of the hidden part filled", percent(figures.filled, figures.hidden)));
    }
    ui.weak("A double click shows the layer alone; Ctrl and Shift select several.");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_goes_by_what_is_listed_whichever_way_it_is_drawn() {
        let listed = [4, 2, 9, 1];
        assert_eq!(between(&listed, 2, 1), [2, 9, 1]);
        assert_eq!(between(&listed, 1, 2), [1, 9, 2], "the one gone to is last");
        assert_eq!(between(&listed, 7, 9), [9], "where it began is not listed any more");
    }
}
