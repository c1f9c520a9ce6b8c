//! The masks of a photo with their origins, and suggestions, as part of the inspector.

use eframe::egui::{DragValue, Ui};

use super::button;
use super::{counted, link_ui, percent, small_button};
use crate::command::{Command, mask};
use crate::panel::inspect::view::InspectorView;
use crate::state::masking::keeping::MaskWork;
use crate::state::masking::origin_words;
use crate::state::masking::suggested::ShownSuggestion;
use crate::state::request::{MaskRequest, Request, SelectRequest};
use quadratura_base::scene::PhotoId;
use quadratura_document::masks::Mask;
use quadratura_sites::masks::MaskEdit;
use quadratura_stacks::masks::suggest::UNSEEN;

/// The largest margin around objects, in pixels, equal to the command line's.
const MOST_MARGIN: u32 = 4096;

/// Draws the masks of a photo.
pub fn masks_ui(view: &InspectorView<'_>, photo: PhotoId, ui: &mut Ui, requests: &mut Vec<Request>) {
    requests.push(MaskRequest::WantSuggestions.into());
    let Some(session) = view.session else { return };
    let open = view.masking.suggestions_of(session, photo);
    let it = session.opened.site.photo(photo);
    let all = u64::from(it.camera.width) * u64::from(it.camera.height);
    let masks = session.history.present().masks.of(&it.name);
    // Without masks, the page says so among what to do next.
    if !masks.is_empty() {
        ui.add_space(8.0);
        ui.strong("Masks");
        for of_one in masks {
            row(&it.name, of_one, all, ui, requests);
        }
        buttons(view, [&mask::BRUSH, &mask::LASSO, &mask::LOOK], ui, requests);
    }
    let unlikely = view.masking.unlikely_in(session, photo);
    if open.is_empty() && unlikely == 0 {
        return;
    }
    ui.add_space(6.0);
    ui.strong("Suggestions").on_hover_text(format!(
        "Outlines show objects that only this photo shows, such as people and cars. {UNSEEN}"
    ));
    for shown in open.iter() {
        suggestion(shown, photo, all, ui, requests);
    }
    if unlikely > 0 {
        unlikely_ui(view, unlikely, ui, requests);
    }
    if !open.is_empty() {
        buttons(view, [&mask::ACCEPT, &mask::DISMISS], ui, requests);
    }
}

fn buttons<const N: usize>(
    view: &InspectorView<'_>,
    commands: [&'static Command; N],
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    ui.horizontal_wrapped(|ui| {
        commands.into_iter().for_each(|command| button(view.commands, ui, command, requests))
    });
}

/// Draws the switch that lists what is hardly an object.
fn unlikely_ui(view: &InspectorView<'_>, count: usize, ui: &mut Ui, requests: &mut Vec<Request>) {
    let mut on = view.masking.suggested.offers_unlikely();
    let found = counted(count as u64, "finding");
    let tooltip = format!("{found} in this photo: hardly objects, such as haze, glare and window panes.");
    if ui.checkbox(&mut on, "Show unlikely ones").on_hover_text(tooltip).changed() {
        requests.push(Request::Mask(MaskRequest::OfferUnlikely(on)));
    }
}

/// Draws a suggestion in a photo of `all` pixels, with its buttons.
fn suggestion(shown: &ShownSuggestion, photo: PhotoId, all: u64, ui: &mut Ui, requests: &mut Vec<Request>) {
    let number = shown.it.number;
    ui.horizontal_wrapped(|ui| {
        let mut asked = |text: &str, tooltip: &str, request: Request| {
            if small_button(ui, text, &format!("{text} suggestion {number}"), tooltip).clicked() {
                requests.push(request);
            }
        };
        asked("Mask", "Masks the outlined area.", Request::Mask(MaskRequest::Accept(vec![number])));
        asked(
            "Dismiss",
            "Removes this suggestion, until the next search.",
            Request::Mask(MaskRequest::Dismiss(vec![number])),
        );
        let text = format!("{number}: {}, {}", shown.confidence(), percent(shown.it.pixels, all));
        let tooltip = format!(
            "Shows the place. {}; on average {:.1} times as bright or as dark as in other photos.",
            counted(shown.it.pixels, "pixel"),
            shown.it.score.exp()
        );
        if link_ui(ui, text).on_hover_text(tooltip).clicked() {
            requests.push(Request::Select(SelectRequest::ShowRect(photo, shown.it.rect)));
        }
    });
}

fn row(photo: &str, of_one: &Mask, all: u64, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.horizontal_wrapped(|ui| {
        let words = origin_words(&of_one.from);
        let remove = small_button(ui, "Remove", &format!("Remove mask {words}"), "Removes this mask.");
        if remove.clicked() {
            let edit = MaskEdit::Remove { photo: photo.to_owned(), from: of_one.from.clone() };
            let name = format!("removal of mask {words} of {photo}");
            requests.push(Request::Mask(MaskRequest::Mask(name, MaskWork::Edits(vec![edit].into()))));
        }
        ui.label(format!("{words}: {} of the photo", percent(of_one.pixels, all)))
            .on_hover_text(counted(of_one.pixels, "pixel"));
    });
}

/// Draws the button that masks the selected object in the selected photo.
pub fn object_mask_ui(view: &InspectorView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.horizontal_wrapped(|ui| {
        button(view.commands, ui, &mask::OBJECT, requests);
        let mut margin = view.masking.margin_px;
        let value = DragValue::new(&mut margin).range(0..=MOST_MARGIN).suffix(" px");
        let field = ui.add(value);
        let label = ui.label("margin");
        let tooltip = "Pixels to mask around the object, because models are a few pixels off.";
        if field.labelled_by(label.id).on_hover_text(tooltip).changed() {
            requests.push(Request::Mask(MaskRequest::Margin(margin)));
        }
    });
}
