//! The panels around the views.

pub mod help;
pub mod inspector;
pub mod menu;
pub mod notes;
mod outliner;
mod photos;
pub mod status;
pub mod welcome;

use eframe::egui::{Panel, Ui};

use super::editor::{Ask, Editor};

/// Photos above, objects and layers below.
pub fn left_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let photos = Panel::top("photos").resizable(true).default_size(340.0);
    photos.show(ui, |ui| photos::photos_ui(editor, ui, asks));
    outliner::outliner_ui(editor, ui, asks);
}

/// `12 345 678` with thin groups, as people read numbers.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// A share in percent, as precise as it is of interest.
pub fn percent(part: u64, all: u64) -> String {
    let share = 100.0 * part as f64 / all.max(1) as f64;
    if share > 0.0 && share < 10.0 { format!("{share:.1} %") } else { format!("{share:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_shares_rounded() {
        assert_eq!(grouped(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!([grouped(0), grouped(999)], ["0", "999"]);
        assert_eq!([percent(1, 3), percent(1, 300), percent(0, 0)], ["33 %", "0.3 %", "0 %"]);
    }
}
