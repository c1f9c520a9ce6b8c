//! The confirmation of the removal of an object from the model, with what becomes out of date.

use eframe::egui::{Context, RichText, Ui};

use super::{answers_ui, counted};
use crate::state::lists::PendingRemoval;
use crate::state::request::{DecideRequest, Request};
use crate::widget::dialog::{Dialog, Keys};

/// The answer that confirms the removal.
const REMOVE: &str = "Remove";
/// The number of photos that are named.
const NAMED: usize = 4;

/// Draws the question while it is open.
pub fn removing_ui(context: &Context, pending: Option<&PendingRemoval>, requests: &mut Vec<Request>) {
    let Some(pending) = pending else { return };
    let asked = Dialog::new("removing", 440.0).show(context, |ui, keys| question_ui(ui, keys, pending));
    if asked.inner.is_some() || asked.is_left() {
        requests.push(DecideRequest::ConfirmRemoval(asked.inner == Some(true)).into());
    }
}

fn question_ui(ui: &mut Ui, keys: &mut Keys, pending: &PendingRemoval) -> Option<bool> {
    ui.label(RichText::new(format!("Remove {} from the model?", pending.object)).heading());
    ui.add_space(4.0);
    consequences(pending).into_iter().for_each(|words| drop(ui.label(words)));
    ui.add_space(10.0);
    let answer = ui.horizontal(|ui| answers_ui(ui, keys, &["Cancel", REMOVE])).inner;
    answer.map(|answer| answer == REMOVE)
}

fn consequences(pending: &PendingRemoval) -> Vec<String> {
    let PendingRemoval { faces, stale, showing, .. } = pending;
    let mut words = vec![format!(
        "Photos, layers and views of this project ignore its {}. Paint on them stays in the project and is used again \
         when the object is restored.",
        counted(*faces as u64, "face")
    )];
    words.push(match stale.len() {
        0 => "No photo has layers yet, so nothing becomes out of date.".into(),
        count => format!(
            "Out of date: the layers and fillings of {}. {}",
            counted(count as u64, "photo"),
            match showing.len() {
                0 => "None of them contains the object.".into(),
                count => format!("{} the object: {}.", contain(count), listed(showing)),
            }
        ),
    });
    words.push("To hide the object in the 3D view only, use its eye in the list.".into());
    words
}

fn contain(count: usize) -> String {
    if count == 1 { "One of them contains".into() } else { format!("{count} of them contain") }
}

fn listed(names: &[String]) -> String {
    let first = names.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_question_names_what_becomes_out_of_date() {
        let names = |count: usize| (1..=count).map(|i| format!("{i}.jpg")).collect::<Vec<_>>();
        let pending = PendingRemoval { object: "roof".into(), faces: 3, stale: names(9), showing: names(6) };
        let words = consequences(&pending).join(" ");
        assert!(words.contains("its 3 faces") && words.contains("fillings of 9 photos"), "{words}");
        assert!(
            words.contains("6 of them contain the object: 1.jpg, 2.jpg, 3.jpg, 4.jpg and 2 more."),
            "{words}"
        );
        let none = PendingRemoval { stale: Vec::new(), showing: Vec::new(), ..pending };
        assert!(consequences(&none).join(" ").contains("nothing becomes out of date"));
    }
}
