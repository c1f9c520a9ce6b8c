//! The confirmation of a merge whose image layer would be mostly empty, with its figures.

use eframe::egui::{Context, Grid, RichText, Ui};

use crate::app::editor::Editor;
use crate::app::panel::{answers_ui, grouped, percent};
use crate::app::state::State;
use crate::app::widget::dialog::{Dialog, Keys};
use crate::recipe::decide::{LayerEdit, MergeCost};

/// The answer that confirms the merge.
const MERGE: &str = "Merge anyway";

/// A merge that waits for confirmation.
pub struct PendingMerge {
    edit: LayerEdit,
    cost: MergeCost,
}

impl Editor {
    /// Draws the question while it is open.
    pub(in crate::app) fn merging_ui(&mut self, context: &Context) {
        let Some(PendingMerge { cost, .. }) = &self.state.lists.merging else { return };
        let asked = Dialog::new("merging", 420.0).show(context, |ui, keys| question_ui(ui, keys, cost));
        if asked.inner.is_none() && !asked.is_left() {
            return;
        }
        if let Some(PendingMerge { edit, .. }) =
            self.state.lists.merging.take().filter(|_| asked.inner == Some(true))
        {
            self.state.decide(&edit);
        }
    }
}

impl State {
    /// Returns the cost of the image layer that several layers of a photo would merge into; none for fewer than two.
    pub fn merge_cost(&self, photo: usize, layers: &[usize]) -> Option<MergeCost> {
        let session = self.session.as_ref()?;
        let (stack, project) = (session.photos.get(photo)?.stack.as_ref()?, session.history.present());
        let own = project.decisions.of(&session.opened.site.photos[photo].name).options;
        MergeCost::new(stack, layers, &own.applied_to(&project.options))
    }

    /// Asks for confirmation of a merge.
    pub fn ask_to_merge(&mut self, edit: LayerEdit, cost: MergeCost) {
        self.lists.merging = Some(PendingMerge { edit, cost });
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
            "{size}, and no layer of this photo may be longer than {longest} px: when the photo is built, what does \
             not fit stays apart."
        );
    }
    format!(
        "{size}: {:.1} times the texels that they have now, most of them empty. It would take so much more room in the \
         image editor and while it is made and filled.",
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
