//! The confirmation of a merge whose image layer would be mostly empty, with its figures.

use eframe::egui::{Context, Grid, RichText, Ui};

use super::{answers_ui, grouped, percent};
use crate::state::lists::PendingMerge;
use crate::state::request::{DecideRequest, Request};
use crate::widget::dialog::{Dialog, Keys};
use quadratura_stacks::decide::MergeCost;

/// The answer that confirms the merge.
const MERGE: &str = "Merge anyway";

/// Draws the question while it is open.
pub fn merging_ui(context: &Context, pending: Option<&PendingMerge>, requests: &mut Vec<Request>) {
    let Some(PendingMerge { cost, .. }) = pending else { return };
    let asked = Dialog::new("merging", 420.0).show(context, |ui, keys| question_ui(ui, keys, cost));
    if asked.inner.is_some() || asked.is_left() {
        requests.push(DecideRequest::ConfirmMerge(asked.inner == Some(true)).into());
    }
}

fn question_ui(ui: &mut Ui, keys: &mut Keys, cost: &MergeCost) -> Option<bool> {
    ui.label(RichText::new(format!("Merge {} layers?", cost.layers)).heading());
    ui.add_space(4.0);
    ui.label(cost_message(cost));
    ui.add_space(6.0);
    Grid::new("merging").num_columns(3).spacing([18.0, 4.0]).show(ui, |ui| {
        ui.label("");
        ui.weak("Texels");
        ui.weak("Used");
        ui.end_row();
        for (name, texels) in [("Now", cost.before), ("Merged", cost.texels)] {
            ui.label(name);
            ui.label(grouped(texels));
            ui.label(percent(cost.used, texels));
            ui.end_row();
        }
    });
    ui.add_space(10.0);
    let answer = ui.horizontal(|ui| answers_ui(ui, keys, &[MERGE, "Cancel"])).inner;
    answer.map(|answer| answer == MERGE)
}

fn cost_message(cost: &MergeCost) -> String {
    let [width, height] = cost.size;
    let size = format!("One rectangle around all of them is {width} × {height} px");
    if cost.is_too_large() {
        let longest = cost.longest;
        return format!(
            "{size}, and no layer of this photo may be longer than {longest} px: layers that do not fit stay \
             separate when the photo is built."
        );
    }
    format!(
        "{size}: {:.1} times the texels that they have now, most of them empty. The merged layer needs that much \
         more memory in the image editor, and when it is built and filled.",
        cost.times()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_question_has_the_figures() {
        let cost = MergeCost {
            layers: 2,
            size: [4096, 2048],
            texels: 8_388_608,
            before: 1_048_576,
            used: 500_000,
            photo: 6_291_456,
            longest: 16_384,
        };
        let words = cost_message(&cost);
        assert!(words.contains("4096 × 2048 px: 8.0 times"), "{words}");
        let words = cost_message(&MergeCost { longest: 2048, ..cost });
        assert!(words.contains("longer than 2048 px"), "{words}");
    }
}
