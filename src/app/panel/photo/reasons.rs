//! The list of faces without texture from the photo, each with the reason; a click shows the face.

use eframe::egui::{Button, ComboBox, RichText, ScrollArea, Ui};
use glam::{DVec2, DVec3};

use super::view::PhotoView;
use crate::panel::{link_ui, named};
use crate::state::flat::photo::PhotoPane;
use crate::state::request::{Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use crate::widget::look::selection_look;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_document::stack::{Untextured, UntexturedReason};
use quadratura_stacks::survey::face_named;
use quadratura_stacks::untextured::{REASONS, untextured, words};

/// Returns the faces without texture from a photo whose layers are built.
fn listed(session: &Session, photo: PhotoId) -> Option<Vec<Untextured>> {
    let stack = session.stack_of(photo)?;
    let decided = session.history.present().decisions.of(&session.opened.site.photo(photo).name);
    Some(untextured(stack, &decided))
}

/// Draws the list.
pub fn reasons_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    photo: PhotoId,
    requests: &mut Vec<Request>,
) {
    ui.add_space(4.0);
    ui.strong("Faces without texture from this photo");
    let Some(faces) = view.session.and_then(|session| listed(session, photo)) else {
        ui.weak("This list is available when the photo's layers are built.");
        return;
    };
    let faces: Vec<&Untextured> = faces.iter().collect();
    choose(ui, &mut pane.reason, &faces);
    let wanted = pane.reason;
    let is_wanted = |face: &&Untextured| wanted.is_none_or(|reason| face.reason == reason);
    let mut listed: Vec<&Untextured> = faces.into_iter().filter(is_wanted).collect();
    if let Some(session) = view.session {
        worst_first(&mut listed, session.model());
    }
    if listed.is_empty() {
        ui.weak(match wanted {
            None => "None: this photo textures every face.",
            Some(_) => "None for this reason.",
        });
        return;
    }
    let height = ui.spacing().interact_size.y;
    // Names may be longer than the list is wide.
    let area = ScrollArea::both().id_salt("untextured").auto_shrink(false);
    area.show_rows(ui, height, listed.len(), |ui, rows| {
        rows.for_each(|index| row(ui, view, pane, listed[index], requests));
    });
}

/// Sorts faces by how bad it is that they have no texture: those first for which something can be done, and of these the
/// largest.
fn worst_first(faces: &mut [&Untextured], model: &Model) {
    let rank = |face: &Untextured| REASONS.iter().position(|reason| *reason == face.reason);
    let area = |face: &Untextured| {
        let ring = model.face_named(&face.object, face.face).map(|face| model.ring_points(face).collect());
        ring.map_or(0.0, |ring: Vec<DVec3>| area_of(&ring))
    };
    let mut keyed: Vec<_> = faces.iter().map(|face| (rank(face), area(face), *face)).collect();
    keyed.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    faces.iter_mut().zip(keyed).for_each(|(face, (_, _, sorted))| *face = sorted);
}

/// Returns the area of a planar polygon, in square units of the world.
fn area_of(ring: &[DVec3]) -> f64 {
    let Some(first) = ring.first() else { return 0.0 };
    let fans = ring.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first));
    fans.sum::<DVec3>().length() / 2.0
}

fn choose(ui: &mut Ui, filter: &mut Option<UntexturedReason>, faces: &[&Untextured]) {
    let count = |reason: Option<UntexturedReason>| {
        faces.iter().filter(|face| reason.is_none_or(|reason| face.reason == reason)).count()
    };
    let text = |reason: Option<UntexturedReason>| {
        let name = reason.map_or("all reasons", words);
        format!("{name} ({})", count(reason))
    };
    let width = ui.available_width() - 16.0;
    let combo = ComboBox::from_id_salt("reason").selected_text(text(*filter)).width(width);
    let combo = combo.show_ui(ui, |ui| {
        ui.selectable_value(filter, None, text(None));
        for reason in REASONS.into_iter().filter(|reason| count(Some(*reason)) > 0) {
            ui.selectable_value(filter, Some(reason), text(Some(reason)));
        }
    });
    named(&combo.response, "Reason");
}

fn row(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    it: &Untextured,
    requests: &mut Vec<Request>,
) {
    let Some(session) = view.session else { return };
    let face = session.model().face_named(&it.object, it.face);
    let selected = face.is_some_and(|face| view.selection.main == Selection::Face(face));
    let mut gone_to = false;
    ui.horizontal(|ui| {
        selection_look(ui.visuals_mut());
        let name = format!("{}[{}]", it.object, it.face);
        let button = ui.add_enabled(face.is_some(), Button::selectable(selected, name));
        gone_to = button.on_disabled_hover_text("The face is no longer in the model.").clicked();
        match &it.by {
            Some(by) => {
                ui.weak("hidden by");
                let front = face_named(session.model(), by).ok();
                if link_ui(ui, by).on_hover_text("Selects the face in front.").clicked() {
                    requests.extend(
                        front.map(|front| Request::Select(SelectRequest::Only(Selection::Face(front)))),
                    );
                }
            }
            None => {
                ui.label(RichText::new(words(it.reason)).weak());
            }
        }
    });
    if let Some(face) = face.filter(|_| gone_to) {
        requests.push(Request::Select(SelectRequest::Only(Selection::Face(face))));
        let at = it.at.map(|[x, y]| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        pane.go_to(face, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::FaceIndex;
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn hidden_faces_come_before_degenerate_ones_and_large_ones_before_small_ones() {
        let mut m = Modeller::new();
        for (name, half) in [("small", 1.0), ("large", 3.0), ("odd", 9.0)] {
            m.object(name).screen(5.0, [-half, -half, half, half]);
        }
        let model = m.finish();
        let face = |object: &str, reason| Untextured {
            object: object.into(),
            face: FaceIndex(0),
            reason,
            by: None,
            at: None,
            px: None,
        };
        let (small, large) =
            (face("small", UntexturedReason::Hidden), face("large", UntexturedReason::Hidden));
        let odd = face("odd", UntexturedReason::Degenerate);
        let mut faces = [&odd, &small, &large];
        worst_first(&mut faces, &model);
        assert_eq!(faces.map(|face| face.object.as_str()), ["large", "small", "odd"]);
        assert_eq!(area_of(&[DVec3::ZERO, DVec3::X * 2.0, DVec3::new(2.0, 2.0, 0.0), DVec3::Y * 2.0]), 4.0);
    }
}
