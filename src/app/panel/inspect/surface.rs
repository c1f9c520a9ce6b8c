//! The inspector pages of objects and faces: which photos texture them, why others do not, and which photo is pinned.

use eframe::egui::{Align, Button, Layout, RichText, Ui};

use super::LIST;
use super::next::site_steps_ui;
use crate::command::edit;
use crate::panel::inspect::view::InspectorView;
use crate::panel::masks::object_mask_ui;
use crate::panel::{button, counted, link_ui, long_list, rows, small_button, title};
use crate::state::request::{DecideRequest, Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{FaceId, ObjectId, PhotoId};
use quadratura_layers::Faces;
use quadratura_stacks::decide::{EXCLUDED, FaceInPhoto, FaceInPhotos, LayerEdit};
use quadratura_stacks::survey::face_named;
use quadratura_stacks::untextured::{FaceTexture, words as reason_words};
use quadratura_views::measure::{area, worded};

/// Draws the page of an object.
pub fn object_page(ui: &mut Ui, view: &InspectorView<'_>, object: ObjectId, requests: &mut Vec<Request>) {
    let counts = view.selection.facts.photos_of_object(object);
    let Some(session) = view.session else { return };
    let model = session.model();
    let it = model.object(object);
    title(ui, "Object", &it.name);
    let mut words = vec![counted(it.faces.len() as u64, "face")];
    if it.billboard && it.impostor.is_none() {
        words.push("billboard, shown from both sides".into());
    }
    ui.weak(words.join(" · "));
    site_steps_ui(view, Some(object), ui, requests);
    ui.add_space(6.0);
    surface_buttons(view, ui, requests);
    decided_ui(session, object, ui, requests);
    let mut turns = it.impostor.is_some();
    let turning = ui.checkbox(&mut turns, "Turns towards the camera");
    let help = "For trees and the like: one upright rectangle about the middle of the object faces each photo and each \
                viewer, in place of the faces of the model.";
    if turning.on_hover_text(help).changed() {
        requests.push(DecideRequest::TurnObject(it.name.clone(), turns).into());
    }
    let mut through = it.see_through;
    let declaring = ui.checkbox(&mut through, "See-through in places");
    let help = "For trees, fences, railings and the like: Fill finds how much of each pixel the object covers, and views \
                show what is behind its gaps.";
    if declaring.on_hover_text(help).changed() {
        requests.push(DecideRequest::SeeThroughObject(it.name.clone(), through).into());
    }
    if session.is_decided_about(&it.name) {
        let help = "Billboards turn, by their names, and one may see through what turns.";
        if ui.button("Remove decisions").on_hover_text(help).clicked() {
            requests.push(DecideRequest::FreeObject(it.name.clone()).into());
        }
    }
    ui.strong("Faces, with the number of photos that show them");
    let warns = ui.visuals().warn_fg_color;
    long_list(ui, "faces of object", LIST, it.faces.len(), |ui, id| {
        let count = u64::from(counts.get(id).copied().unwrap_or_default());
        let text = RichText::new(format!("{}: {}", model.face_name(it.faces[id]), counted(count, "photo")));
        let text = if count == 0 { text.color(warns) } else { text };
        if ui.add(Button::selectable(false, text).truncate()).clicked() {
            requests.push(Request::Select(SelectRequest::Only(Selection::Face(it.faces[id]))));
        }
    });
}

/// Draws the photos that are excluded from an object, and those to which it is pinned, each with a button that undoes that.
fn decided_ui(session: &Session, object: ObjectId, ui: &mut Ui, requests: &mut Vec<Request>) {
    for (photo, decided) in session.decided_about_object(object) {
        let name = &session.opened.site.photo(photo).name;
        ui.horizontal_wrapped(|ui| {
            let (text, tooltip) = match decided {
                EXCLUDED => ("Allow", "Lets the photo texture the object again."),
                _ => ("Unpin", "Lets the other photos texture the object again, too."),
            };
            if small_button(ui, text, &format!("{text} {name}"), tooltip).clicked() {
                let of = vec![Faces::whole(&session.model().object(object).name)];
                let edit = LayerEdit::Free { photo: name.clone(), of };
                requests.push(DecideRequest::Layers(Box::new(edit)).into());
            }
            match decided {
                EXCLUDED => ui.label(format!("{name} is excluded: it does not texture the object.")),
                _ => ui.label(format!("The object is pinned to {name}.")),
            };
        });
    }
}

/// Draws the page of a face.
pub fn face_page(ui: &mut Ui, view: &InspectorView<'_>, face: FaceId, requests: &mut Vec<Request>) {
    let Some(found) = view.selection.facts.photos_of_face(face) else { return };
    let Some(session) = view.session else { return };
    let model = session.model();
    title(ui, "Face", &model.face_name(face));
    let it = model.face(face);
    let planar = if it.planar { "planar" } else { "not planar: treated as triangles" };
    let area = area(&session.opened, &session.solid, face);
    let area = worded(area, &session.history.present().frame, 2);
    let mut facts =
        vec![("Area", area), ("Corners", model.ring(face).len().to_string()), ("Shape", planar.to_owned())];
    if let Some(pinned) = found.pinned_to {
        facts.push(("Pinned to", session.opened.site.photo(pinned).name.clone()));
    }
    rows(ui, &facts);
    ui.horizontal_wrapped(|ui| {
        let object = model.object(it.object).name.clone();
        if link_ui(ui, object).on_hover_text("Selects the object.").clicked() {
            requests.push(Request::Select(SelectRequest::Only(Selection::Object(it.object))));
        }
        button(view.commands, ui, &edit::SWITCH_OFF, requests);
    });
    ui.add_space(6.0);
    ui.strong("In the photos");
    if session.photos.iter().all(|photo| photo.stack.is_none()) {
        ui.weak("No photo has layers yet: build them with Layers › Build layers.");
        return;
    }
    for id in in_order(found) {
        photo_row(session, face, id, found, ui, requests);
    }
}

/// Orders photos that texture the face or have a decision before the others. The order does not change while photos are
/// excluded one after the other.
fn in_order(found: &FaceInPhotos) -> Vec<PhotoId> {
    let rank = |photo: &FaceInPhoto| match (&photo.given, photo.decided) {
        (FaceTexture::Texture { .. }, _) | (_, Some(_)) => 0,
        (FaceTexture::Nothing(_), None) => 1,
        (FaceTexture::Unknown | FaceTexture::NotBuilt, None) => 2,
    };
    let mut photos: Vec<PhotoId> = PhotoId::all(found.photos.len()).collect();
    photos.sort_by_key(|photo| (rank(&found.photos[photo.index()]), *photo));
    photos
}

/// Draws a photo's name with its decisions, and what it contributes in the line below.
fn photo_row(
    session: &Session,
    face: FaceId,
    id: PhotoId,
    found: &FaceInPhotos,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let photo = &found.photos[id.index()];
    let name = &session.opened.site.photo(id).name;
    let at = if let FaceTexture::Nothing(why) = &photo.given { why.at } else { None };
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            requests.extend(decisions(session, face, photo, name, ui));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let text = RichText::new(name).color(ui.visuals().hyperlink_color).underline();
                let link = ui.add(Button::new(text).truncate().frame(false));
                if link.on_hover_text("Shows the face in this photo.").clicked() {
                    requests.push(Request::Select(SelectRequest::ShowInPhoto(id, face, at)));
                }
            });
        });
    });
    ui.horizontal_wrapped(|ui| {
        ui.add_space(6.0);
        ui.weak(photo_message(photo, id, found, session));
        let by = if let FaceTexture::Nothing(why) = &photo.given { why.by.as_deref() } else { None };
        if let Some(by) = by {
            let front = face_named(session.model(), by).ok();
            if link_ui(ui, by).on_hover_text("Selects the face in front.").clicked() {
                requests
                    .extend(front.map(|front| Request::Select(SelectRequest::Only(Selection::Face(front)))));
            }
        }
    });
    ui.add_space(2.0);
}

/// Describes what a photo contributes to a face; the occluding surfaces follow.
fn photo_message(photo: &FaceInPhoto, id: PhotoId, found: &FaceInPhotos, session: &Session) -> String {
    match &photo.given {
        FaceTexture::NotBuilt => "its layers are not built".into(),
        FaceTexture::Unknown => "its layers are from another model: build them again".into(),
        FaceTexture::Nothing(why) if why.by.is_some() => "no texture: hidden behind".into(),
        FaceTexture::Nothing(why) => format!("no texture: {}", reason_words(why.reason)),
        FaceTexture::Texture { image_layers, back } => {
            let layers = counted(*image_layers as u64, "image layer");
            let side = if *back { ", on its back" } else { "" };
            let pinned = match found.pinned_to {
                Some(to) if to == id => ", pinned to this photo".into(),
                Some(to) => format!(", but pinned to {}", session.opened.site.photo(to).name),
                None => String::new(),
            };
            format!("textured in {layers}{side}{pinned}")
        }
    }
}

/// Draws buttons for the decisions about a face in a photo; returns the request of the one that was clicked.
fn decisions(
    session: &Session,
    face: FaceId,
    photo: &FaceInPhoto,
    name: &str,
    ui: &mut Ui,
) -> Option<Request> {
    let model = session.model();
    let of = || {
        let it = model.face(face);
        vec![Faces { object: model.object(it.object).name.clone(), faces: vec![it.index] }]
    };
    let edit = |edit: fn(String, Vec<Faces>) -> LayerEdit| {
        Request::Decide(DecideRequest::Layers(Box::new(edit(name.to_owned(), of()))))
    };
    let free = |photo, of| LayerEdit::Free { photo, of };
    let gives = matches!(photo.given, FaceTexture::Texture { .. });
    let pinned = photo.decided.is_some_and(|decided| decided != EXCLUDED);
    if photo.decided == Some(EXCLUDED) {
        let tooltip = "Lets the photo texture the face again.";
        return small_button(ui, "Allow", &format!("Allow {name}"), tooltip).clicked().then(|| edit(free));
    }
    let mut asked = None;
    if gives {
        let tooltip = "Does not texture the face from this photo.";
        if small_button(ui, "Exclude", &format!("Exclude {name}"), tooltip).clicked() {
            asked = Some(edit(|photo, of| LayerEdit::Exclude { photo, of }));
        }
    }
    if pinned {
        let tooltip = "Lets the other photos texture the face again, too.";
        if small_button(ui, "Unpin", &format!("Unpin {name}"), tooltip).clicked() {
            asked = Some(edit(free));
        }
    } else if gives {
        let tooltip = "Textures the face from this photo only, as far as the photo shows it.";
        if small_button(ui, "Pin", &format!("Pin to {name}"), tooltip).clicked() {
            asked = Some(edit(|photo, of| LayerEdit::Pin { photo, of }));
        }
    }
    asked
}

/// Draws the decisions about an object, for the photo that was selected last.
fn surface_buttons(view: &InspectorView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    button(view.commands, ui, &edit::SWITCH_OFF, requests);
    if let Some(photo) =
        view.photo.zip(view.session).map(|(photo, session)| &session.opened.site.photo(photo).name)
    {
        ui.weak(format!("For {photo}:"));
    }
    ui.horizontal_wrapped(|ui| {
        for command in [&edit::PIN, &edit::EXCLUDE] {
            button(view.commands, ui, command, requests);
        }
    });
    object_mask_ui(view, ui, requests);
    ui.add_space(6.0);
}
