//! The keyboard in the lists: arrows move, open and close; Enter frames or shows; Space toggles.

use eframe::egui::{EventFilter, Id, Key, Modifiers, Ui};

use super::outliner::Outliner;
use super::rows::ListRow;
use crate::app::state::ask::{Ask, DecideAsk, SelectAsk};

/// The arrow keys belong to the list as long as it has the focus.
const ARROWS: EventFilter =
    EventFilter { horizontal_arrows: true, vertical_arrows: true, tab: false, escape: false };

impl Outliner<'_> {
    /// Handles the keys that were pressed; returns whether the cursor moved to another row.
    pub(super) fn keys(&mut self, ui: &Ui, id: Id, rows: &[ListRow]) -> bool {
        if !self.lists.has_focus(ui.ctx()) {
            return false;
        }
        ui.ctx().memory_mut(|memory| memory.set_focus_lock_filter(id, ARROWS));
        let pressed = |modifiers, key| ui.input_mut(|input| input.count_and_consume_key(modifiers, key) > 0);
        let here = self.lists.cursor.and_then(|cursor| rows.iter().position(|row| *row == cursor));
        let (extends, next, before) = (
            pressed(Modifiers::SHIFT, Key::ArrowDown) as i8 - pressed(Modifiers::SHIFT, Key::ArrowUp) as i8,
            pressed(Modifiers::NONE, Key::ArrowDown),
            pressed(Modifiers::NONE, Key::ArrowUp),
        );
        let step = extends as isize + isize::from(next) - isize::from(before);
        let to = if step != 0 {
            along(rows, here, step > 0)
        } else if pressed(Modifiers::NONE, Key::ArrowRight) {
            here.and_then(|here| self.opened(rows, here))
        } else if pressed(Modifiers::NONE, Key::ArrowLeft) {
            here.and_then(|here| self.closed(rows, here))
        } else {
            None
        };
        if let Some(row) = here.map(|here| rows[here]) {
            if pressed(Modifiers::NONE, Key::Enter) {
                self.activate(row);
            }
            if pressed(Modifiers::NONE, Key::Space) {
                self.switch(row);
            }
        }
        let Some(to) = to else { return false };
        self.go(rows, to, extends != 0);
        true
    }

    /// Opens a closed row; returns the first row below an open one.
    fn opened(&mut self, rows: &[ListRow], here: usize) -> Option<usize> {
        let row = rows[here];
        if row.opens() && !self.lists.is_open(row) {
            self.lists.set_open(row, true);
            return None;
        }
        let to = along(rows, Some(here), true)?;
        (self.level(rows[to]) > self.level(row)).then_some(to)
    }

    /// Closes an open row; returns the parent of a closed one.
    fn closed(&mut self, rows: &[ListRow], here: usize) -> Option<usize> {
        let row = rows[here];
        if row.opens() && self.lists.is_open(row) {
            self.lists.set_open(row, false);
            return None;
        }
        rows[..here].iter().rposition(|other| other.is_stop() && self.level(*other) < self.level(row))
    }

    fn level(&self, row: ListRow) -> usize {
        row.level(self.state.settings.layer_list.as_table)
    }

    /// Moves the cursor to a row and selects it, or all layers from the anchor to it.
    fn go(&mut self, rows: &[ListRow], to: usize, extends: bool) {
        let row = rows[to];
        self.lists.cursor = Some(row);
        match row {
            ListRow::Layer(layer) if extends => self.select_range(rows, layer),
            ListRow::Layer(layer) => self.select_layer(layer),
            _ => self.asks.extend(self.site.selection(row).map(|it| Ask::Select(SelectAsk::Only(it)))),
        }
    }

    fn switch(&mut self, row: ListRow) {
        if let ListRow::Object(index) | ListRow::Face(index, _) = row {
            let name = &self.site.whole.objects[index].name;
            let off = self.site.session.history.present().objects_off.contains(name);
            self.asks.push(Ask::Decide(DecideAsk::SwitchObject(name.clone(), off)));
        }
    }
}

/// Returns the next row that the cursor stops at, or the previous one; the first where there is no cursor.
fn along(rows: &[ListRow], here: Option<usize>, down: bool) -> Option<usize> {
    match (here, down) {
        (None, _) => rows.iter().position(|row| row.is_stop()),
        (Some(here), true) => {
            rows.iter().skip(here + 1).position(|row| row.is_stop()).map(|more| here + 1 + more)
        }
        (Some(here), false) => rows[..here].iter().rposition(|row| row.is_stop()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_pass_over_what_cannot_be_selected() {
        let rows = [
            ListRow::Layers,
            ListRow::Head,
            ListRow::Layer(2),
            ListRow::Layer(0),
            ListRow::Objects,
            ListRow::Say("none"),
        ];
        assert_eq!(along(&rows, None, true), Some(0));
        assert_eq!(along(&rows, Some(0), true), Some(2));
        assert_eq!(along(&rows, Some(2), false), Some(0));
        assert_eq!(along(&rows, Some(4), true), None);
        assert_eq!(along(&rows, Some(0), false), None);
    }
}
