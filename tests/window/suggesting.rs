//! What is suggested to complete the model, in the window: looked at as glass, renamed, extended, added, undone.

use std::fs;

use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::sites::suggest::{
    PlaneKind, SuggestedFace, SuggestedModel, SuggestedObject, model_hash,
};

use crate::common;
use crate::harness::{appears, first_photos, opened, press, wait};

/// A square of 4 units that faces the first camera from 12 units away.
fn before_the_camera(editor: &Editor) -> Vec<DVec3> {
    let pose = editor.session.as_ref().unwrap().opened.site.photos[0].pose;
    let corners = [(-2.0, 2.0), (2.0, 2.0), (2.0, -2.0), (-2.0, -2.0)];
    corners.map(|(x, y)| pose.world_from_camera(DVec3::new(x, y, 12.0))).to_vec()
}

fn offered(editor: &Editor) -> &[quadratura::testing::app::model_suggestions::OfferedObject] {
    editor.suggested_model.offered.as_ref().map_or(&[], |offered| &offered.objects)
}

fn pointer(harness: &mut Harness<'_, Editor>, at: Pos2, pressed: Option<bool>) {
    harness.event(Event::PointerMoved(at));
    if let Some(pressed) = pressed {
        let button = PointerButton::Primary;
        harness.event(Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    }
    harness.step();
}

#[test]
fn suggestions_are_renamed_extended_added_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    if common::adapter().is_none() {
        return;
    }
    let project = first_photos(folder.path(), 2);
    let mut harness = opened(&project);
    let (model, ring) = {
        let session = harness.state().session.as_ref().unwrap();
        let model = quadratura::testing::io::project::resolved(&project, &session.history.present().model);
        (model, before_the_camera(harness.state()))
    };
    let before = fs::read(&model).unwrap();
    let object = |name: &str| SuggestedObject {
        name: name.into(),
        kind: PlaneKind::Plumb,
        faces: vec![SuggestedFace { ring: ring.clone() }],
        points: 40,
        photos_for: 2.0,
        photos_against: 0.0,
        gain: Some(3.0),
    };
    let found = SuggestedModel {
        objects: vec![object("kiosk_1"), object("kiosk_2")],
        dropped: 0,
        psnr_db: 20.0,
        photos: 2,
        points: 99,
        problems: Vec::new(),
    };
    let editor = harness.state_mut();
    let hash = model_hash(&project, editor.session.as_ref().unwrap().history.present()).unwrap();
    editor.model_suggested(project.clone(), hash, &found);
    // The window takes clicks once its size is known and it has faded in.
    (0..6).for_each(|_| harness.step());
    press(&mut harness, "Reject kiosk_2");
    assert_eq!(offered(harness.state()).len(), 1);
    let field = harness.get_by_role_and_label(Role::TextInput, "Name of suggestion 1");
    field.focus();
    harness.step();
    harness.state_mut().suggested_model.offered.as_mut().unwrap().objects[0].name = "news".into();
    harness.step();

    // In the photo view, the right edge of the square is dragged away from it.
    harness.state_mut().run(&command::flat::SHOW_PHOTO);
    wait(&mut harness, "the photo", |editor| editor.running.is_idle());
    (0..3).for_each(|_| harness.step());
    let camera = harness.state().session.as_ref().unwrap().opened.site.photos[0].camera;
    let view = harness.get_by_label("Photo view").rect();
    let room = view.size() - vec2(24.0, 24.0);
    let scale = (room.x / camera.width as f32).min(room.y / camera.height as f32);
    let at = |x: f64, y: f64| {
        let px = camera.image_from_camera(DVec3::new(x, y, 12.0)).unwrap();
        let middle = vec2(camera.width as f32, camera.height as f32) / 2.0;
        view.center() + (vec2(px.x as f32, px.y as f32) - middle) * scale
    };
    pointer(&mut harness, at(2.0, 1.8), None);
    pointer(&mut harness, at(2.0, 1.8), Some(true));
    (1..=10).for_each(|i| pointer(&mut harness, at(2.0 + 0.2 * f64::from(i), 1.8), None));
    pointer(&mut harness, at(4.0, 1.8), Some(false));
    let offer = &offered(harness.state())[0];
    let wide = offer.faces[0].ring[0].distance(offer.faces[0].ring[1]);
    assert!(offer.is_changed && (wide - 6.0).abs() < 0.1, "the edge went from 2 to 4: {wide}");

    press(&mut harness, "Add 1 object to the model");
    wait(&mut harness, "the addition", |editor| {
        editor.running.is_idle() && editor.suggested_model.offered.is_none()
    });
    wait(&mut harness, "the model", |editor| {
        editor.running.is_idle() && editor.session.as_ref().unwrap().model().object_named("news").is_some()
    });
    assert!(fs::read(&model).unwrap().starts_with(&before), "what was there stays");
    assert!(!harness.state().suggested_model.shown && offered(harness.state()).is_empty());
    harness.state_mut().run(&command::edit::UNDO);
    wait(&mut harness, "the model as before", |editor| {
        editor.running.is_idle() && editor.session.as_ref().unwrap().model().object_named("news").is_none()
    });
    assert_eq!(fs::read(&model).unwrap(), before);
    appears(&mut harness, "Photo view");
}
