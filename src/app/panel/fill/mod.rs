//! The panel of occluded areas: how much of them is visible, how they are filled, and the options.

pub mod propagated;
pub mod question;
pub mod worst;

use eframe::egui::{Button, CollapsingHeader, Grid, RichText, ScrollArea, TextEdit, Ui};

use self::propagated::propagation_ui;
use self::worst::worst_ui;
use super::button;
use super::{NameCell, grouped, name_cell, percent, room_for_names};
use crate::command::{Commands, layers, view};
use crate::state::State;
use crate::state::quality::filling::FillSession;
use crate::state::request::{QualityRequest, Request, SelectRequest};
use crate::state::running::Running;
use crate::state::selection::{Selection, SelectionState};
use crate::state::session::Session;
use crate::widget::elide::beside;
use crate::widget::look::selection_look;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_layers::LayerIndex;
use quadratura_layers::fill::{FillOptions, Invent};
use quadratura_stacks::fill::FillShares;
use quadratura_stacks::fill::shares::LayerShares;

/// The width of the columns beside the names, in points, with the gaps: of their headings, in small letters.
const BESIDE_NAMES: f32 = 36.0 + 36.0 + 50.0 + 34.0 + 40.0;

/// What the panel of occluded areas shows.
pub struct FillView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// The facts about fillings.
    fill: &'a FillSession,
    /// What is selected.
    selection: &'a SelectionState,
    /// The running jobs.
    running: &'a Running,
    /// The photo that commands on a photo apply to.
    photo: Option<PhotoId>,
}

impl<'a> FillView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            fill: &state.quality.fill,
            selection: &state.selection,
            running: &state.running,
            photo: state.selected_photo(),
        }
    }
}

/// Draws the panel.
pub fn fill_ui(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let any_stack = view.session.is_some_and(|s| s.photos.iter().any(|p| p.stack.is_some()));
    if !any_stack {
        ui.weak("Build the layers first, to see what photos do not show of them.");
        return;
    }
    requests.push(QualityRequest::WantWorst.into());
    requests.extend(view.photo.map(|photo| QualityRequest::WantShares(photo).into()));
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            button(view.commands, ui, &layers::FILL, requests);
            button(view.commands, ui, &view::CONFIDENCE, requests);
        });
        stale_ui(view, ui, requests);
        options(view, ui, requests);
        propagation_ui(view, ui, requests);
        ui.separator();
        worst_ui(view, ui, requests);
        ui.separator();
        let Some(session) = view.session else { return };
        if let Some(photo) = view.photo {
            of_photo(view, session, photo, ui, requests);
            ui.separator();
        }
        photos(view, session, ui, requests);
    });
}

/// Says which fillings are out of date.
fn stale_ui(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    requests.push(QualityRequest::WantStale.into());
    let stale = view.fill.stale.found().map_or(0, Vec::len);
    if stale > 0 {
        let fillings = if stale == 1 {
            "The filling of 1 photo is"
        } else {
            &format!("The fillings of {stale} photos are")
        };
        let text =
            format!("{fillings} out of date: views and exports show paint and options as they were then.");
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
}

fn options(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(options) = view.session.map(|session| session.opened.project.fill.clone()) else {
        return;
    };
    CollapsingHeader::new("Fill options").default_open(false).show(ui, |ui| {
        ui.label("Inpainting, where no photo shows the surface:");
        let mut invent = options.invent;
        let example = "Continues textures that photos show of the same surface.";
        ui.radio_value(&mut invent, Invent::Exemplar, "patch-based").on_hover_text(example);
        let smooth = "Continues colours smoothly from the border.";
        ui.radio_value(&mut invent, Invent::Diffusion, "smooth").on_hover_text(smooth);
        if invent != options.invent {
            requests.push(Request::Quality(QualityRequest::Fill(FillOptions { invent, ..options.clone() })));
        }
        let label = ui.label("Objects that are not filled:");
        let mut text = view.fill.without.clone().unwrap_or_else(|| options.without.join(", "));
        let edit = TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
        let edit = edit.hint_text("names, or tree_* for all names that begin so");
        let response = ui.add(edit).labelled_by(label.id);
        if response.changed() {
            requests.push(QualityRequest::TypeWithout(Some(text.clone())).into());
        }
        if response.lost_focus() {
            requests.push(QualityRequest::TypeWithout(None).into());
            let names = text.split(',').map(str::trim).filter(|name| !name.is_empty());
            let without: Vec<String> = names.map(str::to_owned).collect();
            if without != options.without {
                requests.push(Request::Quality(QualityRequest::Fill(FillOptions { without, ..options })));
            }
        }
        ui.weak("Existing fillings stay until you fill again.");
    });
}

/// Draws a remark in place of data that is being looked up, or could not be.
fn not_there(failed: bool, ui: &mut Ui) {
    if failed {
        ui.label("This could not be read; the messages give the reason.");
    } else {
        ui.add(Spinner::new());
    }
}

/// Draws the provenance of the hidden texels of a photo's layers.
fn of_photo(
    view: &FillView<'_>,
    session: &Session,
    photo: PhotoId,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let name = &session.opened.site.photo(photo).name;
    ui.strong(format!("Occluded areas of {name}"));
    let Some(stack) = session.stack_of(photo) else {
        ui.weak("Its layers are not built.");
        return;
    };
    let Some(lookup) = view.fill.shares.get(&photo) else { return not_there(false, ui) };
    let Some(shares) = lookup.found() else { return not_there(lookup.failed(view.running), ui) };
    let mut rows: Vec<(LayerIndex, &LayerShares)> = LayerIndex::all(shares.len()).zip(shares).collect();
    rows.retain(|(_, shares)| shares.hidden + shares.propagated > 0);
    rows.sort_by_key(|(layer, shares)| (std::cmp::Reverse(shares.hidden), *layer));
    if rows.is_empty() {
        ui.weak("Nothing is hidden.");
    }
    // The names are those of layers that can be selected.
    selection_look(ui.visuals_mut());
    for (layer, shares) in rows {
        let Some(it) = stack.image_layers.get(layer.index()) else { continue };
        let this = Selection::Layer { photo, layer };
        let text = format!("{}: {} hidden", it.name, grouped(shares.hidden));
        if ui.add(Button::selectable(view.selection.main == this, text).truncate()).clicked() {
            requests.push(Request::Select(SelectRequest::Only(this)));
        }
        ui.weak(shares_message(shares));
    }
}

/// Describes the provenance of a layer's hidden texels.
fn shares_message(shares: &LayerShares) -> String {
    let of = |name: &str, part: u64| (part > 0).then(|| format!("{} {name}", percent(part, shares.hidden)));
    let filled = shares.filled();
    let trusted = (filled > 0).then(|| format!("confidence {:.2}", shares.confidence));
    let propagated = (shares.propagated > 0)
        .then(|| format!("{} more under paint projected from other photos", grouped(shares.propagated)));
    let parts = [
        of("painted", shares.painted),
        of("from photos", shares.from_photos),
        of("from their paint", shares.from_paint),
        of("patch-based", shares.by_example),
        of("smooth", shares.diffused),
        of("empty", shares.hidden.saturating_sub(filled)).filter(|_| shares.painted == 0),
        trusted,
        propagated,
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Draws all photos, as shares of their hidden texels.
fn photos(view: &FillView<'_>, session: &Session, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.strong("All photos");
    let names = room_for_names(ui, BESIDE_NAMES);
    // Where the figures do not fit, the table scrolls.
    ScrollArea::horizontal().id_salt("all photos").show(ui, |ui| table(view, session, names, ui, requests));
}

fn table(view: &FillView<'_>, session: &Session, names: f32, ui: &mut Ui, requests: &mut Vec<Request>) {
    Grid::new("fillings").num_columns(5).spacing([8.0, 4.0]).striped(true).show(ui, |ui| {
        for (heading, tooltip) in [
            ("Photo", "The photo."),
            ("Hidden", "Share of its layers' area that the photo does not show."),
            ("Photos", "Share of the occluded areas that is filled from other photos, or from their paint."),
            ("Inpainted", "Share of the occluded areas that is inpainted, patch-based or smooth."),
            ("Empty", "Share of the occluded areas that is not filled."),
        ] {
            ui.label(RichText::new(heading).weak().small()).on_hover_text(tooltip);
        }
        ui.end_row();
        for ((id, photo), status) in session.opened.site.numbered_photos().zip(&session.photos) {
            let Some(stack) = &status.stack else { continue };
            let photos = &session.opened.site.photos;
            let others = beside(id.index(), |place| Some(photos.get(place)?.name.as_str()));
            let cell = NameCell { name: &photo.name, others: &others, width: names };
            if name_cell(ui, view.photo == Some(id), &cell).clicked() {
                requests.push(Request::Select(SelectRequest::Only(Selection::Photo(id))));
            }
            let shares = FillShares::from_stack(stack);
            let invented = shares.by_example + shares.diffused;
            for share in [shares.hidden, shares.from_photos + shares.from_paint, invented, shares.empty] {
                ui.label(format!("{:.0} %", 100.0 * share));
            }
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_told_in_words_and_what_is_not_there_is_left_out() {
        let shares = LayerShares {
            hidden: 200,
            from_photos: 100,
            by_example: 50,
            confidence: 0.5,
            ..LayerShares::default()
        };
        assert_eq!(
            shares_message(&shares),
            "50 % from photos, 25 % patch-based, 25 % empty, confidence 0.50"
        );
        assert_eq!(shares_message(&LayerShares { hidden: 1, ..LayerShares::default() }), "100 % empty");
    }
}
