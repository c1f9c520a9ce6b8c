//! Rows of objects and their faces.

use eframe::egui::{Button, RichText, Role, Ui, WidgetInfo};

use super::row::{DrawnRow, RowText, text_in};
use super::{Outliner, ROW};
use crate::command::edit::ALL_ON;
use crate::command::view::FRAME;
use crate::panel::menu::{SURFACE, context_ui};
use crate::state::lists::row::ListRow;
use crate::state::numbers::grouped;
use crate::state::request::{DecideRequest, Request, SelectRequest, SpaceRequest};
use crate::widget::elide::beside;
use quadratura_base::scene::{FaceIndex, ObjectId};

/// The tooltip of an object's eye.
const EYE: &str = "Shows or hides the object in the 3D view. It remains in the model.";
/// The width of the button that restores an object, in points.
const RESTORE: f32 = 58.0;

impl Outliner<'_> {
    pub(super) fn objects_title(&mut self, ui: &mut Ui) {
        let count = self.site.whole.objects.len();
        let off = self.site.whole.objects.iter().filter(|object| self.site.is_off(&object.name)).count();
        let off = if off > 0 { format!(", {off} removed") } else { String::new() };
        let name = format!("Objects ({}{off})", grouped(count as u64));
        let mut line = self.line(ui, ListRow::Objects, &name);
        if !off.is_empty() {
            let rect = line.take_right(76.0).shrink2([0.0, 2.0].into());
            let button = ui.put(rect, Button::new(RichText::new("Restore all").small()));
            if button.on_hover_text(ALL_ON.tooltip).clicked() {
                self.requests.push(self.view.commands.requested(&ALL_ON));
            }
        }
        line.text(ui, &name, RowText::Strong);
        self.title_clicked(ui, ListRow::Objects, &line);
    }

    /// Opens or closes the rows below a title that was clicked.
    pub(super) fn title_clicked(&mut self, ui: &Ui, row: ListRow, line: &DrawnRow) {
        if line.response.clicked() {
            self.lists.turn(row);
            self.take_focus(ui, row);
        }
    }

    pub(super) fn object(&mut self, ui: &mut Ui, id: ObjectId) {
        let (row, object) = (ListRow::Object(id), self.site.whole.object(id));
        let off = self.site.is_off(&object.name);
        let mut line = self.line(ui, row, &object.name);
        let shown = self.view.visibility.is_shown(&object.name);
        if off {
            self.restore_ui(ui, &mut line, &object.name);
        } else if line.eye(ui, self.id_of(row), &object.name, shown, EYE) {
            self.lists.cursor = Some(row);
            self.requests.push(SpaceRequest::ShowObject(object.name.clone(), !shown).into());
        }
        line.take_right(4.0);
        let count = line.take_right(40.0);
        let weak = ui.visuals().weak_text_color();
        text_in(ui, count, &grouped(object.faces.len() as u64), weak, eframe::egui::Align::Max);
        let objects = &self.site.whole.objects;
        let others = beside(id.index(), |place| Some(objects.get(place)?.name.as_str()));
        line.name(ui, &object.name, &others, if off || !shown { RowText::Weak } else { RowText::Plain });
        self.surface_clicked(ui, row, &line);
        self.surface_menu(row, &line);
        line.response.on_hover_ui(|ui| {
            ui.strong(&object.name);
            ui.label(match object.faces.len() {
                1 => "1 face".into(),
                count => format!("{} faces", grouped(count as u64)),
            });
            if object.billboard {
                ui.label("A flat stand-in for something that is not a wall.");
            }
            ui.weak(match (off, shown) {
                (true, _) => "Removed from the model in this project.",
                (false, true) => "A double click frames the object.",
                (false, false) => "Hidden in the 3D view by its eye; it remains in the model.",
            });
        });
    }

    /// Draws the button that restores an object that was removed from the model.
    fn restore_ui(&mut self, ui: &mut Ui, line: &mut DrawnRow, name: &str) {
        let rect = line.take_right(RESTORE).shrink2([0.0, 2.0].into());
        let button = ui.put(rect, Button::new(RichText::new("Restore").small()));
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Restore {name}")));
        if button.on_hover_text("Restores the object that was removed from the model.").clicked() {
            self.requests.push(DecideRequest::SwitchObject(name.to_owned(), true).into());
        }
    }

    /// Opens the menu of an object or a face; a right click selects it first.
    fn surface_menu(&mut self, row: ListRow, line: &DrawnRow) {
        if line.response.secondary_clicked() {
            self.lists.cursor = Some(row);
            self.requests.extend(self.site.selection(row).map(|it| Request::Select(SelectRequest::Only(it))));
        }
        let (commands, requests) = (self.view.commands, &mut *self.requests);
        line.response.context_menu(|ui| context_ui(commands, ui, SURFACE, requests));
    }

    pub(super) fn face(&mut self, ui: &mut Ui, id: ObjectId, index: FaceIndex) {
        let (row, object) = (ListRow::Face(id, index), &self.site.whole.object(id).name);
        let name = format!("{object}[{index}]");
        let line = self.line(ui, row, &name);
        line.text(ui, &name, if self.site.is_off(object) { RowText::Weak } else { RowText::Plain });
        self.surface_clicked(ui, row, &line);
        self.surface_menu(row, &line);
    }

    fn surface_clicked(&mut self, ui: &Ui, row: ListRow, line: &DrawnRow) {
        if line.response.double_clicked() {
            self.activate(row);
        } else if line.response.clicked() {
            self.take_focus(ui, row);
            self.requests.extend(self.site.selection(row).map(|it| Request::Select(SelectRequest::Only(it))));
        }
    }

    /// Activates a row, by double click or Enter.
    pub(super) fn activate(&mut self, row: ListRow) {
        match row {
            ListRow::Layer(_) => {
                let show = self.view.commands.requested(&crate::command::flat::SHOW_LAYER);
                self.requests.extend(
                    self.site
                        .selection(row)
                        .map(|it| Request::Select(SelectRequest::Only(it)))
                        .into_iter()
                        .chain([show]),
                );
            }
            ListRow::Object(_) | ListRow::Face(..) | ListRow::Tree(_) => {
                if let Some(this) = self.site.selection(row) {
                    self.requests.extend([
                        Request::Select(SelectRequest::Only(this)),
                        self.view.commands.requested(&FRAME),
                    ]);
                }
            }
            row if row.opens() => {
                self.lists.turn(row);
            }
            _ => (),
        }
    }

    pub(super) fn say(&mut self, ui: &mut Ui, words: &'static str) {
        let (_, rect) = ui.allocate_space(eframe::egui::vec2(ui.available_width(), ROW));
        let room = rect.shrink2([16.0, 0.0].into());
        let label = eframe::egui::Label::new(RichText::new(words).weak()).truncate();
        ui.put(room, label);
    }
}
