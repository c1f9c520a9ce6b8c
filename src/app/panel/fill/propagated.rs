//! The panel of propagated paint: sources, targets and disagreements.

use eframe::egui::{Button, CollapsingHeader, RichText, Ui};

use super::not_there;
use crate::command::layers::{PROPAGATE, TAKE_OFF};
use crate::panel::button;
use crate::panel::counted;
use crate::panel::fill::FillView;
use crate::state::request::{QualityRequest, Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_layers::Faces;
use quadratura_stacks::fill::propagation::{PaintedPhoto, PropagationToPhoto, laid_over};
use quadratura_stacks::fill::seen::{EditedPaint, Seen, SeenEdit};
use quadratura_stacks::survey::face_named;

/// The number of listed places: the most disputed ones.
const MOST: usize = 40;

/// Draws the panel.
pub fn propagation_ui(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    CollapsingHeader::new("Propagated paint").default_open(true).show(ui, |ui| {
        requests.push(QualityRequest::WantPainters.into());
        let lookup = &view.fill.painters;
        let Some(painters) = lookup.found().cloned() else { return not_there(lookup.failed(view.running), ui) };
        if painters.is_empty() && !view.session.is_some_and(Session::has_propagated) {
            ui.weak(
                "There is no paint yet. Paint on a surface in one photo can be projected to the other photos that \
                 show it: graffiti removed in one photo is removed from all.",
            );
            return;
        }
        choose(view, &painters, ui, requests);
        ui.horizontal_wrapped(|ui| {
            let ready = view.commands.ready(&PROPAGATE).is_ok();
            let look = ui.add_enabled(ready, Button::new("Preview"));
            if look.on_hover_text("Shows what paint would be projected to which photos; nothing is written.").clicked() {
                requests.push(Request::Quality(QualityRequest::LookAtPropagation));
            }
            button(view.commands, ui, &PROPAGATE, requests);
            button(view.commands, ui, &TAKE_OFF, requests);
        });
        found(view, ui, requests);
    });
}

/// Draws the choice of photos whose paint is projected to the others.
fn choose(view: &FillView<'_>, painters: &[PaintedPhoto], ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let options = &session.opened.project.fill;
    ui.label("Projected to other photos that show the same surfaces, when occluded areas are filled:");
    for painter in painters {
        let mut on = options.propagates(&painter.photo);
        let text = format!("paint of {}", painter.photo);
        let tooltip = counted(painter.pixels, "painted pixel");
        if ui.checkbox(&mut on, text).on_hover_text(tooltip).changed() {
            requests.push(see(EditedPaint::OfPhoto(painter.photo.clone()), on));
        }
    }
    exceptions(session, view, ui, requests);
}

/// Returns the request that makes paint seen everywhere, or only in its photo.
fn see(paint: EditedPaint, everywhere: bool) -> Request {
    let seen = if everywhere { Seen::Everywhere } else { Seen::OnlyHere };
    Request::Quality(QualityRequest::See(SeenEdit { paint, seen }))
}

/// Draws the exceptions for the selection, and those that there are.
fn exceptions(session: &Session, view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let options = &session.opened.project.fill;
    let mut listed: Vec<(String, EditedPaint)> = Vec::new();
    let model = session.model();
    let selected = match view.selection.main {
        Selection::Object(object) => Some(Faces::whole(&model.object(object).name)),
        Selection::Face(face) => {
            let object = model.object(model.face(face).object).name.clone();
            Some(Faces { object, faces: vec![model.face(face).index] })
        }
        _ => None,
    };
    let surfaces = selected.into_iter().chain(options.only_here.surfaces.iter().cloned());
    listed.extend(
        surfaces.map(|faces| (format!("paint on {faces} only in its photo"), EditedPaint::On(faces))),
    );
    let imports = options.only_here.imports.iter();
    listed.extend(
        imports.map(|n| (format!("paint of import {n} only in its photo"), EditedPaint::OfImport(*n))),
    );
    let photos = view
        .photo
        .map(|photo| session.opened.site.photo(photo).name.clone())
        .into_iter()
        .chain(options.protected.iter().cloned());
    listed.extend(photos.map(|photo| (format!("{photo} keeps its pixels"), EditedPaint::To(photo))));
    listed.dedup();
    for (text, paint) in listed {
        let mut stays = match &paint {
            EditedPaint::On(faces) => options.only_here.surfaces.contains(faces),
            EditedPaint::OfImport(number) => options.only_here.imports.contains(number),
            EditedPaint::To(photo) => options.protected.contains(photo),
            EditedPaint::All | EditedPaint::OfPhoto(_) => continue,
        };
        if ui.checkbox(&mut stays, text).changed() {
            requests.push(see(paint, !stays));
        }
    }
}

fn found(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let offered = &view.fill.offered;
    if offered.is_sought(view.running) {
        ui.horizontal(|ui| {
            ui.add(Spinner::new());
            ui.label("Computing the preview…");
        });
    } else if let Some((options, propagated)) = offered.found() {
        let all = session.opened.project.fill.propagate.patterns().is_empty();
        if all || *options == session.opened.project.fill {
            summary(session, propagated, true, ui, requests);
        }
    }
    let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.as_deref()).collect();
    let laid = laid_over(&stacks);
    if !laid.is_empty() {
        summary(session, &laid, false, ui, requests);
    }
}

/// Draws how much paint is, or would be, projected to which photo; a click on a disagreement shows its place.
fn summary(
    session: &Session,
    propagated: &[PropagationToPhoto],
    would: bool,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let texels: u64 = propagated.iter().map(|it| it.paint.texels).sum();
    let mut photos: Vec<PhotoId> =
        propagated.iter().filter(|it| it.paint.texels > 0).map(|it| it.photo).collect();
    photos.sort_unstable();
    photos.dedup();
    let verb = if would { "would be projected" } else { "projected" };
    ui.add_space(4.0);
    ui.strong(match texels {
        0 => format!("No paint {verb} to another photo."),
        _ => format!("{} {verb} to {}.", counted(texels, "pixel"), counted(photos.len() as u64, "photo")),
    });
    let disputed = propagated.iter().filter(|it| it.disputed() > 0).count();
    if disputed > 0 {
        let indices = counted(disputed as u64, "place");
        let text = format!("Paint conflicts with other paint at {indices}; a click shows the place.");
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    for it in propagated.iter().take(MOST) {
        place(session, it, ui, requests);
    }
    if propagated.len() > MOST {
        ui.weak(format!("{} more.", counted((propagated.len() - MOST) as u64, "place")));
    }
}

fn place(session: &Session, it: &PropagationToPhoto, ui: &mut Ui, requests: &mut Vec<Request>) {
    let name = &session.opened.site.photo(it.photo).name;
    let text = RichText::new(format!("{} in {name}", it.paint.face));
    let text = if it.disputed() > 0 { text.color(ui.visuals().warn_fg_color) } else { text };
    let face = face_named(session.model(), &it.paint.face).ok();
    let button = ui.add_enabled(face.is_some(), Button::selectable(false, text).truncate());
    if button.on_hover_text("Shows the face in this photo.").clicked() {
        requests.extend(face.into_iter().flat_map(|face| {
            [
                Request::Select(SelectRequest::Only(Selection::Face(face))),
                Request::Select(SelectRequest::ShowInPhoto(it.photo, face, None)),
            ]
        }));
    }
    ui.horizontal_wrapped(|ui| {
        ui.add_space(8.0);
        ui.weak(propagation_message(it));
    });
}

/// Describes the paint projected to a photo, and the disagreements.
fn propagation_message(it: &PropagationToPhoto) -> String {
    let paint = &it.paint;
    let own = (paint.own > 0).then(|| format!("{} painted here already", counted(paint.own, "pixel")));
    let conflicts = (paint.conflicts > 0)
        .then(|| format!("{} of them in conflict", super::super::grouped(paint.conflicts)));
    let dissents = (paint.dissents > 0)
        .then(|| format!("{} where a third photo's paint differs", counted(paint.dissents, "pixel")));
    let laid = format!("{} from {}", counted(paint.texels, "pixel"), paint.from);
    [Some(laid), own, conflicts, dissents].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::stack::PropagationEntry;

    #[test]
    fn what_stands_against_paint_is_told_in_words() {
        let paint = PropagationEntry {
            face: "wall[0]".into(),
            from: "a.jpg".into(),
            texels: 1,
            own: 7,
            conflicts: 5,
            dissents: 0,
            coarse: 0,
        };
        let message = propagation_message(&PropagationToPhoto { photo: PhotoId(0), paint });
        assert_eq!(message, "1 pixel from a.jpg, 7 pixels painted here already, 5 of them in conflict");
    }
}
