//! Rows of species and their trees.

use eframe::egui::{Align, Ui};

use super::Outliner;
use super::row::{RowText, text_in};
use crate::command::view::FRAME;
use crate::panel::menu::{TREE, context_ui};
use crate::state::lists::row::ListRow;
use crate::state::numbers::grouped;
use crate::state::request::{Request, SelectRequest, TreeRequest};
use crate::state::selection::Selection;
use quadratura_document::trees::TreeIndex;

/// The tooltip of the eye of a tree or a species.
const EYE: &str = "Shows or hides it in the 3D view. It remains in the project.";
/// The width of the number of trees or polygons of a species, in points.
const COUNT: f32 = 76.0;

impl Outliner<'_> {
    pub(super) fn trees_title(&mut self, ui: &mut Ui) {
        let row = ListRow::Trees;
        let name = format!("Trees ({})", grouped(self.site.trees().placed.len() as u64));
        let line = self.line(ui, row, &name);
        line.text(ui, &name, RowText::Strong);
        if line.response.double_clicked() {
            self.lists.turn(row);
        } else if line.response.clicked() {
            self.take_focus(ui, row);
            self.requests.push(SelectRequest::Only(Selection::Trees).into());
        }
        line.response.on_hover_text("A click shows their light and cost on the right.");
    }

    pub(super) fn species(&mut self, ui: &mut Ui, number: u32) {
        let row = ListRow::Species(number);
        let Some(species) = self.site.species(number) else { return };
        let names: Vec<String> = self.site.trees_of(species).map(|tree| tree.name.clone()).collect();
        let mut line = self.line(ui, row, species);
        let shown = names.iter().any(|name| !self.view.trees.hidden.contains(name));
        if !names.is_empty() && line.eye(ui, self.id_of(row), species, shown, EYE) {
            self.requests.push(TreeRequest::Show(names.clone(), !shown).into());
        }
        line.take_right(4.0);
        let count = line.take_right(COUNT.min(0.5 * line.room.width()));
        let words = match names.len() {
            1 => "1 tree".into(),
            count => format!("{} trees", grouped(count as u64)),
        };
        text_in(ui, count, &words, ui.visuals().weak_text_color(), Align::Max);
        line.text(ui, species, if shown { RowText::Plain } else { RowText::Weak });
        self.title_clicked(ui, row, &line);
        let polygons =
            self.view.trees.figures_of(self.site.trees(), species).map(|figures| figures.counts.polygons);
        line.response.on_hover_ui(|ui| {
            ui.strong(species);
            if let Some(polygons) = polygons {
                ui.label(format!("{} polygons a tree", grouped(polygons)));
            }
        });
    }

    pub(super) fn tree(&mut self, ui: &mut Ui, index: TreeIndex) {
        let row = ListRow::Tree(index);
        let Some(tree) = self.site.trees().at(index) else { return };
        let mut line = self.line(ui, row, &tree.name);
        let shown = !self.view.trees.hidden.contains(&tree.name);
        if line.eye(ui, self.id_of(row), &tree.name, shown, EYE) {
            self.lists.cursor = Some(row);
            self.requests.push(TreeRequest::Show(vec![tree.name.clone()], !shown).into());
        }
        line.text(ui, &tree.name, if shown { RowText::Plain } else { RowText::Weak });
        let select = Request::Select(SelectRequest::Only(Selection::Tree(index)));
        if line.response.double_clicked() {
            self.requests.extend([select, self.view.commands.requested(&FRAME)]);
        } else if line.response.clicked() || line.response.secondary_clicked() {
            self.take_focus(ui, row);
            self.requests.push(select);
        }
        let (commands, requests) = (self.view.commands, &mut *self.requests);
        line.response.context_menu(|ui| context_ui(commands, ui, TREE, requests));
    }
}
