//! Measuring, exports to other programs and orthophotos in the window.

use std::fs;

use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::selection::Selection;
use quadratura::testing::app::site_frame::{LevelChoice, ScaleChoice};
use quadratura::testing::scene::FaceId;
use quadratura::testing::views::measure::{PointOnFace, pixel_at};

use crate::common;
use crate::harness::{appears, built_photos, first_photos, is_there, opened, press, wait};

/// The first face of an object of the piazza.
fn face_of(editor: &Editor, object: &str) -> FaceId {
    let model = editor.session.as_ref().unwrap().model();
    model.object(model.object_named(object).unwrap()).faces[0]
}

#[test]
fn two_points_are_measured_and_a_known_length_sets_the_scale_which_undo_takes_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(&first_photos(folder.path(), 2));
    harness.state_mut().run(&command::view::MEASURE);
    appears(&mut harness, "Click the first point");
    let face = face_of(harness.state(), "church.facade");
    let model = harness.state().session.as_ref().unwrap().opened.site.model.clone();
    // Two points of the facade that photos see.
    let session = harness.state().session.as_ref().unwrap();
    let corners: Vec<_> = model.ring_points(face).collect();
    let middle = corners.iter().sum::<glam::DVec3>() / corners.len() as f64;
    let inner =
        corners.iter().map(|corner| PointOnFace { position: middle + (*corner - middle) * 0.7, face });
    let seen: Vec<_> =
        inner.filter(|point| pixel_at(&session.opened, &session.solid, *point).is_some()).collect();
    let (first, second) = (seen[0], *seen.last().unwrap());
    for point in [first, second] {
        harness.state_mut().space.measure.add(point);
    }
    harness.step();
    assert!(is_there(&harness, "± "), "the uncertainty is said");
    assert!(is_there(&harness, " units"), "there is no scale yet");
    let units = first.position.distance(second.position);
    harness.state_mut().space.measure.length = format!("{}", 2.0 * units);
    harness.step();
    press(&mut harness, "Set scale");
    let scale = |editor: &Editor| editor.session.as_ref().unwrap().history.present().frame.metres_per_unit();
    assert!((scale(harness.state()).unwrap() - 2.0).abs() < 1e-9);
    appears(&mut harness, " m");
    harness.state_mut().run(&command::edit::UNDO);
    harness.step();
    assert_eq!(scale(harness.state()), None);
}

#[test]
fn the_sites_frame_is_set_in_a_dialog_step_by_step_and_undo_takes_back_each() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(&first_photos(folder.path(), 2));
    harness.state_mut().run(&command::images::FRAME);
    appears(&mut harness, "Site frame");
    assert!(is_there(&harness, "not set"));
    let frame = |editor: &Editor| editor.session.as_ref().unwrap().history.present().frame.clone();
    let dialog = harness.state_mut().dialogs.site_frame.as_mut().unwrap();
    (dialog.level, dialog.scale) = (LevelChoice::Verticals, ScaleChoice::Unit(1.0, "m"));
    harness.step();
    press(&mut harness, "Set");
    appears(&mut harness, "upright edges of the model");
    let set = frame(harness.state());
    assert!(set.up.is_some() && set.scale.as_ref().is_some_and(|scale| scale.value == 1.0), "{set:?}");
    // A map needs north: the dialog says so, and nothing changes.
    let dialog = harness.state_mut().dialogs.site_frame.as_mut().unwrap();
    dialog.map = ["25832", "1", "2", "3"].map(str::to_owned);
    harness.step();
    press(&mut harness, "Set");
    appears(&mut harness, "needs a frame that is level, in metres and to the north");
    assert_eq!(frame(harness.state()), set);
    let dialog = harness.state_mut().dialogs.site_frame.as_mut().unwrap();
    dialog.north = ["0,0,0".into(), "0,1,0".into(), String::new()];
    harness.step();
    press(&mut harness, "Set");
    appears(&mut harness, "EPSG:25832");
    press(&mut harness, "Close");
    harness.state_mut().run(&command::edit::UNDO);
    harness.step();
    assert_eq!(frame(harness.state()), set);
    harness.state_mut().run(&command::edit::UNDO);
    harness.step();
    assert!(frame(harness.state()).is_empty());
}

#[test]
fn one_dialog_lists_all_formats_and_exports_the_cameras_of_the_site() {
    let folder = tempfile::tempdir().unwrap();
    if common::adapter().is_none() {
        return;
    }
    let project = built_photos(folder.path(), "piazza", 2, true);
    let mut harness = opened(&project);
    harness.state_mut().run(&command::paint::EXPORT);
    appears(&mut harness, "Other programs");
    for format in [
        "PSD",
        "XCF",
        "Blender",
        "GLB",
        "OBJ",
        "USD",
        "OpenEXR",
        "Nuke (experimental)",
        "Cameras",
        "Layered depth image",
        "Orthophoto",
    ] {
        assert!(is_there(&harness, format), "{format} is not offered");
    }
    press(&mut harness, "Cameras");
    press(&mut harness, "Export");
    wait(&mut harness, "the export", |editor| {
        editor.round_trip.dialogs.export.as_ref().is_some_and(|dialog| dialog.done.is_some())
    });
    appears(&mut harness, "Open folder");
    assert!(is_there(&harness, "files to "), "what was written is said");
    assert!(project.join("cameras/sparse/0/cameras.txt").is_file());
}

#[test]
fn an_orthophoto_of_a_face_says_what_is_missing_has_a_preview_and_is_written() {
    let folder = tempfile::tempdir().unwrap();
    if common::adapter().is_none() {
        return;
    }
    let project = built_photos(folder.path(), "piazza", 2, true);
    let mut harness = opened(&project);
    let face = face_of(harness.state(), "church.facade");
    harness.state_mut().selection.main = Selection::Face(face);
    harness.state_mut().run(&command::images::ORTHOPHOTO);
    appears(&mut harness, "The site has no unit");
    press(&mut harness, "Cancel");
    let mut changed = (**harness.state().session.as_ref().unwrap().history.present()).clone();
    changed.frame = serde_json::from_str(r#"{"scale": {"value": 1, "from": "a test"}}"#).unwrap();
    harness.state_mut().state.edit("scale of the site", changed, None);
    harness.state_mut().run(&command::images::ORTHOPHOTO);
    appears(&mut harness, "church.facade[0]");
    let dialog = |editor: &Editor| editor.dialogs.orthophoto.clone().unwrap();
    harness.state_mut().dialogs.orthophoto.as_mut().unwrap().scale = "500".into();
    harness.step();
    press(&mut harness, "Preview");
    wait(&mut harness, "the preview", |editor| dialog(editor).preview.is_some());
    let preview = dialog(harness.state()).preview.unwrap();
    let shown = preview.pixels().iter().filter(|pixel| pixel[3] == 255).count();
    assert!(2 * shown > preview.pixels().len(), "{shown} of {} pixels", preview.pixels().len());
    wait(&mut harness, "the job", |editor| editor.running.is_idle());
    press(&mut harness, "Draw");
    wait(&mut harness, "the orthophoto", |editor| dialog(editor).done.is_some());
    appears(&mut harness, "Record ");
    for file in ["church.facade_0.tif", "church.facade_0.pdf", "church.facade_0.provenance.png"] {
        let bytes = fs::metadata(project.join("orthophotos").join(file)).map(|file| file.len());
        assert!(bytes.is_ok_and(|bytes| bytes > 500), "{file}");
    }
}
