//! The parts of a row: a clickable background, a triangle that opens, an eye that switches, text.

use eframe::egui::{
    Align, Color32, Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, TextStyle, Ui, WidgetInfo,
    pos2, vec2,
};

use super::{Outliner, ROW};
use crate::state::lists::row::ListRow;
use crate::widget::elide::elided;
use crate::widget::look::{focus_stroke, selected as selected_colours};

/// The indentation of a level, in points.
const STEP: f32 = 14.0;
/// The margin left of all rows, and of rows without a triangle, in points.
const LEFT: f32 = 2.0;
/// The margin right of all rows, in points, for the scroll bar.
const RIGHT: f32 = 6.0;
/// The corner radius of a row that is selected or under the pointer, in points.
const ROUND: f32 = 3.0;
/// Half the side of a triangle, in points.
const TRIANGLE: f32 = 4.0;
/// The width of a triangle or an eye with its margins, in points.
const MARK: f32 = 18.0;

/// A row that is being drawn.
pub struct DrawnRow {
    /// The free space for text and widgets.
    pub room: Rect,
    /// The response to clicks on the row.
    pub response: Response,
    /// The colour of its text.
    pub color: Color32,
    /// The colour of remarks: on a selected row that of its text, so that they are read there, too.
    pub weak: Color32,
}

impl Outliner<'_> {
    /// Draws the background of a row, with its triangle where it opens. `name` is its accessible name.
    pub(super) fn line(&mut self, ui: &mut Ui, row: ListRow, name: &str) -> DrawnRow {
        let (_, rect) = ui.allocate_space(vec2(ui.available_width(), ROW));
        let selected = self.site.is_selected(row, self.view.selection);
        let response = ui.interact(rect, self.id_of(row), Sense::CLICK);
        response.widget_info(|| WidgetInfo::selected(Role::TreeItem, true, selected, name));
        let visuals = ui.visuals();
        let (fill, of_text) = selected_colours(visuals);
        let (color, weak) = match selected {
            true => (of_text, of_text),
            false => (visuals.text_color(), visuals.weak_text_color()),
        };
        if selected {
            ui.painter().rect_filled(rect, ROUND, fill);
        } else if response.hovered() && row.is_stop() {
            ui.painter().rect_filled(rect, ROUND, visuals.widgets.hovered.weak_bg_fill);
        }
        if self.lists.cursor == Some(row) && self.has_focus(ui.ctx()) {
            ui.painter().rect_stroke(rect, ROUND, focus_stroke(visuals), StrokeKind::Inside);
        }
        let level = row.level(self.as_table());
        let left = rect.left() + LEFT + level as f32 * STEP;
        let room = Rect::from_min_max(pos2(left, rect.top()), rect.max - vec2(RIGHT, 0.0));
        let mut line = DrawnRow { room, response, color, weak };
        if row.opens() {
            self.triangle(ui, row, &mut line, name);
        } else {
            // The text is aligned with that of a row with a triangle.
            line.take_left(if level > 1 { MARK - STEP } else { LEFT });
        }
        line
    }

    fn triangle(&mut self, ui: &Ui, row: ListRow, line: &mut DrawnRow, name: &str) {
        let open = self.lists.is_open(row);
        let rect = line.take_left(MARK);
        let response = ui.interact(rect, self.id_of(row).with("opens"), Sense::CLICK);
        let verb = if open { "Close" } else { "Open" };
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("{verb} {name}")));
        let (center, r) = (rect.center(), TRIANGLE);
        let corners = match open {
            true => [vec2(-r, -r * 0.6), vec2(r, -r * 0.6), vec2(0.0, r * 0.8)],
            false => [vec2(-r * 0.6, -r), vec2(r * 0.8, 0.0), vec2(-r * 0.6, r)],
        };
        let color = if response.hovered() { ui.visuals().strong_text_color() } else { line.color };
        let corners = corners.map(|corner| center + corner).to_vec();
        ui.painter().add(Shape::convex_polygon(corners, color, Stroke::NONE));
        ui.ctx().accesskit_node_builder(line.response.id, |node| node.set_expanded(open));
        if response.clicked() {
            self.lists.set_open(row, !open);
            self.take_focus(ui, row);
        }
    }
}

impl DrawnRow {
    /// Takes this width from the left of the free space, in points.
    pub fn take_left(&mut self, width: f32) -> Rect {
        let taken = Rect::from_min_max(self.room.min, pos2(self.room.left() + width, self.room.bottom()));
        self.room.min.x = taken.right();
        taken
    }

    /// Takes this width from the right of the free space, in points.
    pub fn take_right(&mut self, width: f32) -> Rect {
        let taken = Rect::from_min_max(pos2(self.room.right() - width, self.room.top()), self.room.max);
        self.room.max.x = taken.left();
        taken
    }

    /// Draws a name at the left of the free space; where it is longer, it is shortened so that it differs from those beside it.
    pub fn name(&self, ui: &Ui, name: &str, others: &[&str], look: RowText) {
        self.text(ui, &elided(ui, name, others, self.room.width(), &TextStyle::Body), look);
    }

    /// Draws text at the left of the free space; it is shortened in the middle where it is longer.
    pub fn text(&self, ui: &Ui, text: &str, look: RowText) {
        let color = match look {
            RowText::Weak => self.weak,
            RowText::Plain | RowText::Strong => self.color,
        };
        let color = if matches!(look, RowText::Strong) { ui.visuals().strong_text_color() } else { color };
        text_in(ui, self.room, text, color, Align::LEFT);
    }

    /// Draws a checkbox as an eye; returns whether it was clicked.
    pub fn eye(&mut self, ui: &Ui, id: eframe::egui::Id, name: &str, on: bool, tooltip: &str) -> bool {
        let rect = self.take_right(MARK + 4.0);
        let response = ui.interact(rect, id.with("eye"), Sense::CLICK);
        response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, on, format!("Show {name}")));
        let color = match (response.hovered(), on) {
            (true, _) => ui.visuals().strong_text_color(),
            (false, true) => self.color.gamma_multiply(0.75),
            (false, false) => self.weak,
        };
        draw_eye(ui, rect.center(), on, color);
        let clicked = response.clicked();
        response.on_hover_text(tooltip);
        clicked
    }
}

/// The look of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowText {
    /// Text as the row has it.
    Plain,
    /// Text of a title.
    Strong,
    /// Text of a remark.
    Weak,
}

/// Draws one line of text, aligned in a rectangle and truncated to it.
pub fn text_in(ui: &Ui, rect: Rect, text: &str, color: Color32, align: Align) {
    styled_text_in(ui, rect, text, color, align, TextStyle::Body);
}

/// Draws one line of text in the given style, at the left or right of a rectangle, centred vertically and shortened in
/// the middle to its width.
pub fn styled_text_in(ui: &Ui, rect: Rect, text: &str, color: Color32, align: Align, style: TextStyle) {
    let text = elided(ui, text, &[], rect.width(), &style);
    let galley = ui.painter().layout_no_wrap(text, style.resolve(ui.style()), color);
    let x = match align {
        Align::Max => rect.right() - galley.size().x,
        _ => rect.left(),
    };
    let at = pos2(x, rect.center().y - galley.size().y / 2.0);
    ui.painter().galley(at, galley, color);
}

/// Draws an eye: two lids and a pupil; a closed one is its lower lid with lashes.
fn draw_eye(ui: &Ui, center: Pos2, open: bool, color: Color32) {
    let stroke = Stroke::new(1.3, color);
    let lid = |bend: f32| -> Vec<Pos2> {
        let at = |share: f32| center + vec2(7.0 * share, bend * (1.0 - share * share));
        (-6..=6).map(|step| at(step as f32 / 6.0)).collect()
    };
    let painter = ui.painter();
    painter.add(Shape::line(lid(4.5), stroke));
    if open {
        painter.add(Shape::line(lid(-4.5), stroke));
        painter.circle_filled(center, 2.2, color);
    } else {
        for share in [-0.55, 0.0, 0.55f32] {
            let lash = center + vec2(7.0 * share, 4.5 * (1.0 - share * share));
            painter.line_segment([lash, lash + vec2(2.0 * share, 2.6)], stroke);
        }
    }
}
