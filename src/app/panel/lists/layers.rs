//! Rows of image layers, and the selection of several.

use eframe::egui::{Align, Button, RichText, Role, Ui, WidgetInfo};

use super::Outliner;
use super::row::{DrawnRow, RowText, text_in};
use super::table::columns;
use crate::command::layers::AS_TABLE;
use crate::panel::layer::shown::shown_ui;
use crate::panel::menu::{LAYER, context_ui};
use crate::panel::photo::drawing::MERGED;
use crate::state::lists::layer_list::LayerList;
use crate::state::lists::row::ListRow;
use crate::state::numbers::{grouped, percent};
use crate::state::request::{FlatRequest, QualityRequest, Request};
use crate::widget::elide::beside;
use quadratura_base::scene::PhotoId;
use quadratura_document::ImageLayer;
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_table::{LayerColumn, LayerFigures};

/// The width of the button that turns the list into a table, in points.
const TABLE: f32 = 52.0;
/// The width of `100 % hidden`, in points.
const HIDDEN: f32 = 92.0;
/// The list width below which only the share is shown, in points.
const ROOM: f32 = 230.0;
/// The width of the mark of layers that will be one, in points.
const MERGED_MARK: f32 = 16.0;
/// The width of `100 %`, in points.
const SHARE: f32 = 46.0;

/// The tooltip of a layer's eye.
const EYE: &str = "Shows or hides the layer in the photo and the exploded view; with Alt, shows only this layer. It is \
                   a view and changes nothing in the project.";

/// Returns the request for the figures that the table shows, where it shows some that have to be computed.
pub(super) fn wanted_figures(list: LayerList, photo: Option<PhotoId>, width: f32) -> Option<Request> {
    let shows_trust = list.as_table && columns(width, list.column).contains(&LayerColumn::Trust);
    let photo = photo.filter(|_| shows_trust)?;
    Some(QualityRequest::WantShares(photo).into())
}

impl Outliner<'_> {
    pub(super) fn layers_title(&mut self, ui: &mut Ui) {
        let Some(photo) = self.site.photo else { return };
        let count = self.site.stack().map(|stack| format!(" ({})", stack.image_layers.len()));
        let name = &self.site.session.opened.site.photo(photo).name;
        let name = format!("Layers of {name}{}", count.unwrap_or_default());
        let mut line = self.line(ui, ListRow::Layers, &name);
        let rect = line.take_right(TABLE).shrink2([0.0, 2.0].into());
        let as_table = self.as_table();
        let button = ui.put(rect, Button::selectable(as_table, RichText::new("Table").small()));
        button.widget_info(|| WidgetInfo::selected(Role::Button, true, as_table, AS_TABLE.name));
        if button.on_hover_text(AS_TABLE.tooltip).clicked() {
            self.requests.push(self.view.commands.requested(&AS_TABLE));
        }
        line.text(ui, &name, RowText::Strong);
        self.title_clicked(ui, ListRow::Layers, &line);
    }

    pub(super) fn depth(&mut self, ui: &mut Ui, order: u32) {
        let layers = self.site.stack().map(|stack| &stack.image_layers[..]).unwrap_or_default();
        let count = layers.iter().filter(|layer| layer.order == order).count();
        let deepest = layers.last().map_or(order, |last| last.order);
        let name = format!("Depth {} of {}, 1 nearest ({count})", order + 1, deepest + 1);
        let line = self.line(ui, ListRow::Depth(order), &name);
        line.text(ui, &name, RowText::Plain);
        self.title_clicked(ui, ListRow::Depth(order), &line);
        line.response.on_hover_text(match order {
            0 => "Image layers that nothing occludes.".to_owned(),
            _ => "Image layers behind others that occlude one another in turn. An image layer may contain surfaces of \
                  several visibility layers, so there are more depths than visibility layers."
                .to_owned(),
        });
    }

    pub(super) fn layer(&mut self, ui: &mut Ui, index: LayerIndex, rows: &[ListRow]) {
        let Some(layer) = self.site.stack().and_then(|stack| stack.image_layers.get(index.index())) else {
            return;
        };
        let row = ListRow::Layer(index);
        let merges = self.merged_with(index);
        let said =
            if merges.is_some() { format!("{}, to be merged", layer.name) } else { layer.name.clone() };
        let mut line = self.line(ui, row, &said);
        let figures = LayerFigures::from_layer(layer);
        let shown = self.layer_eye(ui, index, layer, &mut line);
        if merges.is_some() {
            text_in(ui, line.take_left(MERGED_MARK), "+", MERGED, Align::LEFT);
        }
        if self.as_table() {
            self.cells(ui, &mut line, index, layer);
        } else if figures.hidden > 0 {
            let share = percent(figures.hidden, figures.used);
            let (text, width) = match line.response.rect.width() {
                ROOM.. => (format!("{share} hidden"), HIDDEN),
                _ => (share, SHARE),
            };
            text_in(ui, line.take_right(width), &text, line.weak, Align::Max);
        }
        let layers = self.site.stack().map(|stack| &stack.image_layers[..]).unwrap_or_default();
        let others = beside(index.index(), |place| Some(layers.get(place)?.name.as_str()));
        line.name(ui, &layer.name, &others, if shown { RowText::Plain } else { RowText::Weak });
        self.layer_clicked(ui, index, &line, rows);
        self.layer_menu(index, layer, &line);
        line.response.on_hover_ui(|ui| {
            layer_tooltip(ui, layer, &figures);
            merges.iter().for_each(|names| drop(ui.label(format!("Will be one layer: {names}."))));
        });
    }

    /// Returns the names of the layers that a layer will be one with when the photo is built.
    fn merged_with(&self, index: LayerIndex) -> Option<String> {
        let (photo, stack) = (self.site.photo?, self.site.stack()?);
        let merge = self
            .site
            .session
            .layers_to_merge(photo, self.view.running)
            .into_iter()
            .find(|merge| merge.contains(&index))?;
        let names: Vec<&str> = merge.iter().map(|layer| stack.layer(*layer).name.as_str()).collect();
        Some(names.join(" + "))
    }

    /// Draws the eye of a layer; returns whether the layer is shown.
    fn layer_eye(&mut self, ui: &Ui, index: LayerIndex, layer: &ImageLayer, line: &mut DrawnRow) -> bool {
        let Some(photo) = self.site.photo else { return true };
        let shown = self.view.layer_views.is_shown(photo, layer);
        let id = self.id_of(ListRow::Layer(index));
        let clicked = line.eye(ui, id, &layer.name, shown, EYE);
        if clicked && ui.input(|input| input.modifiers.alt) {
            self.requests.push(FlatRequest::Solo(photo, index).into());
        } else if clicked {
            self.requests.push(FlatRequest::ShowLayer(photo, index, !shown).into());
        }
        shown
    }

    /// Opens the menu of a layer; a right click selects the layer first.
    fn layer_menu(&mut self, index: LayerIndex, layer: &ImageLayer, line: &DrawnRow) {
        let row = ListRow::Layer(index);
        if line.response.secondary_clicked() && !self.site.is_selected(row, self.view.selection) {
            self.lists.cursor = Some(row);
            self.requests.extend(self.lists.select_layer(self.site, index));
        }
        let (view, photo, requests) = (self.view, self.site.photo, &mut *self.requests);
        line.response.context_menu(|ui| {
            photo.into_iter().for_each(|photo| shown_ui(view.layer_views, ui, photo, index, layer, requests));
            context_ui(view.commands, ui, LAYER, requests);
        });
    }

    fn layer_clicked(&mut self, ui: &Ui, index: LayerIndex, line: &DrawnRow, rows: &[ListRow]) {
        let response = &line.response;
        if response.double_clicked() {
            self.activate(ListRow::Layer(index));
        } else if response.clicked() {
            let modifiers = ui.input(|input| input.modifiers);
            self.take_focus(ui, ListRow::Layer(index));
            let request = match (modifiers.shift, modifiers.command) {
                (true, _) => self.lists.select_range(self.site, self.view.selection.main, rows, index),
                (false, true) => self.lists.toggle_layer(self.site, index),
                (false, false) => self.lists.select_layer(self.site, index),
            };
            self.requests.extend(request);
        }
    }
}

/// Draws the tooltip of a layer in a few lines.
fn layer_tooltip(ui: &mut Ui, layer: &ImageLayer, figures: &LayerFigures) {
    ui.strong(&layer.name);
    ui.label(format!("{} × {} px, {} texels", layer.rect.w, layer.rect.h, grouped(figures.texels)));
    let (used, hidden) = (percent(figures.used, figures.texels), percent(figures.hidden, figures.used));
    ui.label(format!("{used} used, {hidden} of that hidden in the photo"));
    if figures.hidden > 0 {
        ui.label(format!("{} of the hidden area filled", percent(figures.filled, figures.hidden)));
    }
    ui.weak("A double click shows only this layer; Ctrl and Shift select several.");
}
