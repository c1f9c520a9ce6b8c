//! The keyboard in the lists: arrows move, open and close; Enter frames or shows. No key of it changes the
//! project.

use eframe::egui::{EventFilter, Key, Modifiers, Ui};

use super::Outliner;
use crate::state::lists::cursor::along;
use crate::state::lists::row::ListRow;

/// The arrow keys belong to the list as long as it has the focus.
const ARROWS: EventFilter =
    EventFilter { horizontal_arrows: true, vertical_arrows: true, tab: false, escape: false };

impl Outliner<'_> {
    /// Handles the keys that were pressed; returns whether the cursor moved to another row.
    pub(super) fn keys(&mut self, ui: &Ui, rows: &[ListRow]) -> bool {
        if !self.has_focus(ui.ctx()) {
            return false;
        }
        ui.ctx().memory_mut(|memory| memory.set_focus_lock_filter(self.id, ARROWS));
        let pressed = |modifiers, key| ui.input_mut(|input| input.count_and_consume_key(modifiers, key) > 0);
        let (here, as_table) = (self.lists.here(rows), self.as_table());
        let (extends, next, before) = (
            pressed(Modifiers::SHIFT, Key::ArrowDown) as i8 - pressed(Modifiers::SHIFT, Key::ArrowUp) as i8,
            pressed(Modifiers::NONE, Key::ArrowDown),
            pressed(Modifiers::NONE, Key::ArrowUp),
        );
        let step = extends as isize + isize::from(next) - isize::from(before);
        let to = if step != 0 {
            along(rows, here, step > 0)
        } else if pressed(Modifiers::NONE, Key::ArrowRight) {
            here.and_then(|here| self.lists.enter(rows, here, as_table))
        } else if pressed(Modifiers::NONE, Key::ArrowLeft) {
            here.and_then(|here| self.lists.leave(rows, here, as_table))
        } else {
            None
        };
        let row = here.map(|here| rows[here]);
        if let Some(row) = row.filter(|_| pressed(Modifiers::NONE, Key::Enter)) {
            self.activate(row);
        }
        let Some(to) = to else { return false };
        self.requests.extend(self.lists.go(self.site, self.view.selection.main, rows, to, extends != 0));
        true
    }
}
