//! The layers as a table that can be sorted by any column: choice of columns, headings, cells.

use eframe::egui::{
    Align, Button, Popup, Rect, Role, Sense, Shape, Stroke, TextStyle, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

use super::Outliner;
use super::row::{DrawnRow, styled_text_in, text_in};
use crate::state::lists::row::ListRow;
use crate::state::request::{Request, WindowRequest};
use quadratura_document::ImageLayer;
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_table::{LayerColumn, LayerFigures};

/// The smallest width of a name, in points.
const NAME: f32 = 86.0;
/// The width of the button for columns that do not fit, in points.
const MORE: f32 = 20.0;
/// The margin left of names, in points.
const LEFT: f32 = 18.0;
/// The margin right of the last column, in points, equal to that of rows.
const RIGHT: f32 = 6.0;

/// The gap between a name and the first column, in points.
const GAP: f32 = 6.0;
/// The width of the triangle that shows the sort order, in points.
const TRIANGLE: f32 = 9.0;
/// The distance of the names' triangle from the left edge of their heading, in points.
const BEHIND_NAME: f32 = 42.0;
/// The start of the line below the headings, in points from the left edge.
const LINE: f32 = 14.0;

/// Returns the heading of a column, its width in points, and its tooltip.
fn heading(column: LayerColumn) -> (&'static str, f32, &'static str) {
    match column {
        LayerColumn::Name => ("Name", NAME, "The layer's name."),
        LayerColumn::Depth => ("Depth", 48.0, "Position in the stack: 1 is the nearest."),
        LayerColumn::Size => ("Size", 48.0, "Texels of its rectangle, which need storage and memory."),
        LayerColumn::Hidden => {
            ("Hidden", 56.0, "Share of the area of its surfaces that the photo does not show.")
        }
        LayerColumn::Used => ("Used", 50.0, "Share of its rectangle that its surfaces cover."),
        LayerColumn::Waste => ("Waste", 56.0, "Texels of its rectangle that no surface covers."),
        LayerColumn::Filled => ("Filled", 54.0, "Share of the hidden area that is filled."),
        LayerColumn::Trust => {
            ("Confidence", 74.0, "Mean confidence of the filling, from 0 to 1: a photo has 1.")
        }
    }
}

/// Returns the columns that fit a table of this width, in points: the sort column first, then the others by usefulness.
pub(super) fn columns(width: f32, sorted_by: LayerColumn) -> Vec<LayerColumn> {
    let mut wanted: Vec<LayerColumn> =
        LayerColumn::ALL.into_iter().filter(|column| *column != LayerColumn::Name).collect();
    wanted.sort_by_key(|column| *column != sorted_by);
    let mut room = width - NAME - LEFT - RIGHT;
    let mut shown: Vec<LayerColumn> = Vec::new();
    for column in wanted {
        let (_, width, _) = heading(column);
        if width > room {
            break;
        }
        room -= width;
        shown.push(column);
    }
    LayerColumn::ALL.into_iter().filter(|column| shown.contains(column)).collect()
}

impl Outliner<'_> {
    pub(super) fn cells(&self, ui: &Ui, line: &mut DrawnRow, index: LayerIndex, layer: &ImageLayer) {
        let figures = LayerFigures::from_layer(layer);
        let list = self.view.layer_list;
        let trust = self
            .site
            .photo
            .map(|photo| self.view.fill.layer_trust(photo))
            .unwrap_or_default()
            .get(index.index())
            .copied()
            .flatten();
        for column in columns(ui.available_width(), list.column).into_iter().rev() {
            let (_, width, _) = heading(column);
            let rect = line.take_right(width);
            let text = cell(column, layer, &figures, trust);
            let color = if column == list.column { line.color } else { line.weak };
            text_in(ui, rect, &text, color, Align::Max);
        }
        line.room.max.x -= GAP;
    }

    /// Draws the headings; a click sorts.
    pub(super) fn head(&mut self, ui: &mut Ui, rect: Rect) {
        let list = self.view.layer_list;
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        let shown = columns(rect.width(), list.column);
        let (low, high) = (rect.min + vec2(LEFT, 0.0), rect.max - vec2(RIGHT, 0.0));
        let mut room = Rect::from_min_max(low, high);
        let mut take = |width: f32| {
            let taken = Rect::from_min_max(pos2(room.right() - width, room.top()), room.max);
            room.max.x = taken.left();
            taken
        };
        for column in shown.iter().rev() {
            let (_, width, _) = heading(*column);
            self.heading(ui, take(width), *column);
        }
        let more = take(MORE);
        self.heading(ui, room, LayerColumn::Name);
        let rest: Vec<LayerColumn> =
            LayerColumn::ALL.into_iter().filter(|c| *c != LayerColumn::Name && !shown.contains(c)).collect();
        if !rest.is_empty() {
            self.more(ui, more, &rest);
        }
        let below = [rect.left_bottom() + vec2(LINE, -0.5), rect.right_bottom() - vec2(0.0, 0.5)];
        ui.painter().line_segment(below, ui.visuals().widgets.noninteractive.bg_stroke);
    }

    fn heading(&mut self, ui: &Ui, rect: Rect, column: LayerColumn) {
        let (name, _, tooltip) = heading(column);
        let list = self.view.layer_list;
        let sorts = list.column == column;
        let response = ui.interact(rect, self.id_of(ListRow::Head).with(name), Sense::click());
        response.widget_info(|| {
            WidgetInfo::selected(Role::ColumnHeader, true, sorts, format!("Sort by {}", name.to_lowercase()))
        });
        let lit = sorts || response.hovered() || response.has_focus();
        let color = if lit { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
        let align = if column == LayerColumn::Name { Align::Min } else { Align::Max };
        let text = if sorts { rect.with_max_x(rect.right() - TRIANGLE) } else { rect };
        styled_text_in(ui, text, name, color, align, TextStyle::Small);
        if sorts {
            let up = if list.falling { 1.0 } else { -1.0 };
            let center = match column {
                LayerColumn::Name => pos2(rect.left() + BEHIND_NAME, rect.center().y),
                _ => pos2(rect.right() - TRIANGLE / 2.0, rect.center().y),
            };
            let corners = [vec2(-3.5, -2.0 * up), vec2(3.5, -2.0 * up), vec2(0.0, 2.5 * up)];
            let corners = corners.map(|corner| center + corner).to_vec();
            ui.painter().add(Shape::convex_polygon(corners, color, Stroke::NONE));
        }
        if response.clicked() {
            self.requests.push(Request::Window(WindowRequest::SortLayers(column)));
        }
        response.on_hover_text(tooltip);
    }

    /// Draws the button for the columns that do not fit: sorting by one of them shows it.
    fn more(&mut self, ui: &mut Ui, rect: Rect, rest: &[LayerColumn]) {
        let button = ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
            ui.add(Button::new("…").small().frame(false))
        });
        let button = button.inner;
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, "More columns"));
        Popup::menu(&button).show(|ui| {
            for column in rest {
                let (name, _, tooltip) = heading(*column);
                let text = format!("Sort by {}", name.to_lowercase());
                if ui.button(text).on_hover_text(tooltip).clicked() {
                    self.requests.push(Request::Window(WindowRequest::SortLayers(*column)));
                }
            }
        });
        button.on_hover_text("Columns that do not fit. A wider list shows them, too.");
    }
}

fn cell(column: LayerColumn, layer: &ImageLayer, figures: &LayerFigures, trust: Option<f64>) -> String {
    let share = |share: f64| format!("{:.0} %", 100.0 * share);
    match column {
        LayerColumn::Name => layer.name.clone(),
        LayerColumn::Depth => (layer.order + 1).to_string(),
        LayerColumn::Size => short(figures.texels),
        LayerColumn::Used => share(figures.used_share()),
        LayerColumn::Waste => short(figures.waste),
        LayerColumn::Hidden => share(figures.hidden_share()),
        LayerColumn::Filled => figures.filled_share().map_or_else(|| "–".into(), share),
        LayerColumn::Trust => trust.map_or_else(|| "–".into(), |trust| format!("{trust:.2}")),
    }
}

/// Formats a number for a narrow column: `940`, `12 k`, `1.5 M`.
fn short(number: u64) -> String {
    match number {
        0..=999 => number.to_string(),
        1_000..=999_499 => format!("{:.0} k", number as f64 / 1e3),
        999_500..=9_949_999 => format!("{:.1} M", number as f64 / 1e6),
        _ => format!("{:.0} M", number as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_table_has_the_column_that_it_is_sorted_by_and_a_wide_one_has_all() {
        for column in LayerColumn::ALL.into_iter().filter(|column| *column != LayerColumn::Name) {
            let shown = columns(280.0, column);
            assert!(shown.contains(&column) && shown.len() >= 2, "{column:?}: {shown:?}");
            let width: f32 = shown.iter().map(|column| heading(*column).1).sum();
            assert!(width + NAME + LEFT + RIGHT <= 280.0);
        }
        assert_eq!(columns(560.0, LayerColumn::Name).len(), LayerColumn::ALL.len() - 1);
    }

    #[test]
    fn numbers_fit_their_columns() {
        let message = [0, 999, 1_000, 262_144, 999_499, 999_500, 8_388_608, 33_554_432].map(short);
        assert_eq!(message, ["0", "999", "1 k", "262 k", "999 k", "1.0 M", "8.4 M", "34 M"]);
    }
}
