//! The editor's window, driven by the names of its widgets, with the software adapter where there is no other.

use std::path::{Path, PathBuf};

use crate::common;
use crate::harness::{
    appears, built_photos, command, is_there, opened, press, project_of, small_piazza, wait, window,
};
use crate::paper;
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::testing::app::command;
use quadratura::testing::app::command::words::worded;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::RoundTripRequest;
use quadratura::testing::app::selection::Selection;
use quadratura::testing::files::lock::ProjectLock;
use quadratura::testing::io::project::read_project;
use quadratura::testing::layers::LayerIndex;
use quadratura::testing::scene::PhotoId;

/// So many photos tell what most tests ask: the last of them is the arcade.
const PHOTOS: usize = 4;

fn piazza(folder: &Path, photos: usize) -> PathBuf {
    let (site, project) = (folder.join("site"), folder.join("piazza"));
    small_piazza(&site, photos);
    project_of(&site, &project);
    project
}

#[test]
fn an_empty_window_says_what_to_do_and_the_palette_has_every_command() {
    let mut harness = window(None);
    harness.step();
    harness.get_by_label_contains("Open project");
    harness.get_by_label_contains("drop a site folder or project folder");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::P);
    harness.step();
    harness.step();
    for command in command::all() {
        let row = format!("{} › {}", command.menu.name(), command.name);
        harness.get_by_label(&row);
    }
}

#[test]
fn a_folder_that_is_no_project_is_told_and_the_window_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(folder.path().to_path_buf()));
    wait(&mut harness, "the refusal", |editor| editor.running.is_idle() && !editor.notes.list().is_empty());
    let note = worded(&harness.state().notes.list()[0].text);
    assert!(note.contains("there is no project in this folder") && note.contains("New project…"), "{note}");
    harness.get_by_label_contains(&note);
    assert!(harness.state().session.is_none());
}

/// A window with a part of the piazza, opened and built by hand; none where no adapter is.
fn built(folder: &Path) -> Option<Harness<'static, Editor>> {
    common::adapter()?;
    let mut harness = window(Some(piazza(folder, PHOTOS)));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.get_by_label("01_church.jpg, not built");
    harness.get_by_label("No photo has layers yet.");
    harness.get_by_label("Build layers").click();
    harness.step();
    wait(&mut harness, "the layers", is_current);
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
    harness.get_by_label("01_church.jpg, built");
    Some(harness)
}

/// The same as it is when it is opened again.
fn opened_again(folder: &Path) -> Option<Harness<'static, Editor>> {
    common::adapter()?;
    let mut harness = opened(&built_photos(folder, "piazza", PHOTOS, true));
    wait(&mut harness, "the layers", is_current);
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
    Some(harness)
}

fn is_current(editor: &Editor) -> bool {
    let session = editor.session.as_ref().unwrap();
    editor.space.device.is_some()
        && editor.running.is_idle()
        && session.photos.iter().all(|photo| photo.is_current())
}

#[test]
fn a_site_is_opened_built_and_shown_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };

    // Selecting by hand: a photo in the list, then flying into its camera.
    harness.get_by_label("04_arcade.jpg, built").click();
    harness.step();
    harness.step();
    assert_eq!(harness.state().selected_photo_name().as_deref(), Some("04_arcade.jpg"));
    harness.get_by_label("Look through camera").click();
    wait(&mut harness, "the flight's end", |editor| editor.space.through() == Some(PhotoId(3)));
    let here = harness.state().space.viewpoint;

    // A drag turns the view and leaves the photo; a key leads back.
    let view = harness.get_by_label("3D view").rect().center();
    harness.drag_at(view);
    harness.hover_at(view + [60.0, 10.0].into());
    harness.step();
    harness.drop_at(view + [60.0, 10.0].into());
    harness.step();
    assert!(harness.state().space.through().is_none());
    assert_ne!(harness.state().space.viewpoint, here);
    harness.key_press(Key::Num0);
    wait(&mut harness, "the way back", |editor| editor.space.through() == Some(PhotoId(3)));

    // Another program may not write meanwhile, and may afterwards.
    let project = folder.path().join("piazza");
    let locked = ProjectLock::take(&project).unwrap_err().to_string();
    assert!(locked.contains("is writing to this project"), "{locked}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    wait(&mut harness, "closing", |editor| editor.session.is_none() && editor.running.is_idle());
    ProjectLock::take(&project).unwrap();
}

#[test]
fn a_decision_is_one_step_that_can_be_undone_and_is_saved_when_the_user_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = opened_again(folder.path()) else { return };
    let project = folder.path().join("piazza");
    let name = |editor: &Editor| {
        editor.session.as_ref().unwrap().photos[0].stack.as_ref().unwrap().image_layers[0].name.clone()
    };
    let (first, layers) = {
        let stack = harness.state().session.as_ref().unwrap().photos[0].stack.clone().unwrap();
        (name(harness.state()), stack.image_layers.len())
    };

    // A name is typed and holds when the field is left.
    harness.state_mut().select(Selection::Layer { photo: PhotoId(0), layer: LayerIndex(0) });
    harness.step();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Name").click();
    harness.step();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.get_by_role_and_label(Role::TextInput, "Name").type_text("the palazzo");
    harness.step();
    harness.key_press(Key::Enter);
    wait(&mut harness, "the step", |editor| editor.is_dirty());
    wait(&mut harness, "the name", |editor| name(editor) == "the palazzo");
    wait(&mut harness, "the name being kept", |_| project.join("project.unsaved.json").is_file());
    assert_eq!(read_project(&project).unwrap().decisions.photos.len(), 0, "nothing is saved yet");

    // Saved, undone past the save, and done again.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "the save", |editor| !editor.is_dirty());
    assert_eq!(read_project(&project).unwrap().decisions.photos.len(), 1);
    command(&mut harness, "Undo");
    wait(&mut harness, "the step back", |editor| editor.is_dirty());
    wait(&mut harness, "the name of before", |editor| name(editor) == first);
    command(&mut harness, "Redo");
    wait(&mut harness, "the step forth", |editor| !editor.is_dirty());

    // Two layers become one, unless the method forbids it, and then a note says why.
    let mut merged = false;
    for other in (1..layers as u32).map(LayerIndex) {
        harness.state_mut().select(Selection::Layer { photo: PhotoId(0), layer: LayerIndex(0) });
        harness.state_mut().toggle_layer(PhotoId(0), other);
        command(&mut harness, "Merge layers");
        // One that keeps much emptiness is asked about first.
        if is_there(&harness, "Merge anyway") {
            press(&mut harness, "Merge anyway");
        }
        if harness.state().is_dirty() {
            merged = true;
            break;
        }
        let note = harness.state().notes.list().last().unwrap();
        assert!(
            note.text.to_string().contains("merge") || note.text.to_string().contains("hide"),
            "{}",
            note.text
        );
    }
    assert!(merged, "some layer goes with the first one");
    wait(&mut harness, "a stale stack", |editor| !editor.session.as_ref().unwrap().photos[0].is_current());
    command(&mut harness, "Build layers");
    wait(&mut harness, "the layers", is_current);
    assert!(
        harness.state().session.as_ref().unwrap().photos[0].stack.as_ref().unwrap().image_layers.len()
            < layers
    );

    // Closing asks; what is not saved is found again as after a crash.
    wait(&mut harness, "the merge being kept", |_| project.join("project.unsaved.json").is_file());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    harness.step();
    harness.step();
    harness.get_by_label("Cancel").click();
    harness.step();
    harness.step();
    assert!(harness.state().session.is_some());
    drop(harness);
    let mut harness = window(Some(project.clone()));
    wait(&mut harness, "the project", |editor| editor.session.is_some());
    wait(&mut harness, "quiet", |editor| editor.running.is_idle());
    harness.get_by_label("Restore").click();
    wait(&mut harness, "what was not saved", |editor| editor.is_dirty());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "the save", |editor| !editor.is_dirty());
    let decided = read_project(&project).unwrap().decisions;
    assert_eq!(decided.photos["01_church.jpg"].merge.len(), 1);
    assert!(!project.join("project.unsaved.json").exists());
}

#[test]
fn a_flight_is_made_of_two_views_played_and_filmed() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = opened_again(folder.path()) else { return };
    command(&mut harness, "Add bookmark");
    assert_eq!(harness.state().session.as_ref().unwrap().opened.project.views[0].name, "View 1");
    command(&mut harness, "Add keyframe");
    let start = harness.state().space.viewpoint;
    command(&mut harness, "Next photo");
    wait(&mut harness, "the flight to the next photo", |editor| editor.space.through() == Some(PhotoId(1)));
    command(&mut harness, "Add keyframe");
    harness.get_by_label("Keyframe 1").click();
    wait(&mut harness, "the start", |editor| {
        editor.space.viewpoint.position().distance(start.position()) < 1e-9
    });
    command(&mut harness, "Play flight");
    wait(&mut harness, "the end", |editor| !editor.plays());
    let end = harness.state().session.as_ref().unwrap().opened.site.photos[1].pose.center_in_world();
    assert!(harness.state().space.viewpoint.position().distance(end) < 1e-9);

    command(&mut harness, "Render picture…");
    harness.get_by_label("Render").click();
    let picture = folder.path().join("piazza/pictures/view.png");
    wait(&mut harness, "the picture", |editor| picture.is_file() && editor.running.is_idle());

    // Of all this a step of the history each: undone, nothing is left to save.
    for step in ["Undo", "Undo", "Undo"] {
        assert!(harness.state().is_dirty());
        command(&mut harness, step);
    }
    assert!(!harness.state().is_dirty());
}

/// A program that opens nothing: whoever paints is this test.
#[cfg(unix)]
const NOBODY: &str = "/bin/true";

#[cfg(unix)]
#[test]
fn what_is_painted_and_saved_comes_home_by_itself_and_goes_again_when_it_is_taken_back() {
    use quadratura::testing::document::export_record::ExportFormat;
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(piazza(folder.path(), PHOTOS)));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.state_mut().settings.image_editor.editor = None;
    harness.state_mut().settings.image_editor.program = NOBODY.into();
    harness.state_mut().settings.image_editor.format = ExportFormat::Xcf;
    harness.state_mut().run(&command::layers::BUILD_PHOTO);
    let built = |editor: &Editor| editor.space.device.is_some() && editor.running.is_idle();
    wait(&mut harness, "the layers", built);
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());

    harness.get_by_label("01_church.jpg, built").click();
    harness.step();
    harness.step();
    harness.get_by_label("Edit in image editor").click();
    harness.step();
    wait(&mut harness, "the export", |editor| editor.running.is_idle());
    harness.get_by_label_contains("What you save there is imported automatically.");
    let file = folder.path().join("piazza/editing/01_church.jpg.xcf");
    let mut paper = paper::Paper::read(&file);
    let sheet = paper.image_layers().find(|sheet| sheet.pixels_where(true).len() > 500).unwrap();
    let shown = sheet.pixels_where(true);
    shown.iter().take(400).for_each(|(x, y)| sheet.paint(*x, *y, [65535, 0, 65535, 65535]));
    paper.write(&file);
    let looked =
        |editor: &Editor| editor.round_trip.report.as_ref().is_some_and(|report| !report.looks.is_empty());
    wait(&mut harness, "what was painted", looked);
    harness.get_by_label("Import 1");
    assert!(harness.query_all_by_label_contains("Before: ").next().is_some());
    harness.get_by_label_contains("400 px painted");

    // Once more in the image editor is on with the same file, not a new one.
    harness.state_mut().run(&command::paint::EDIT);
    wait(&mut harness, "the file that was begun", |editor| editor.running.is_idle());
    harness.get_by_label_contains("as you left it");
    let files = std::fs::read_dir(file.parent().unwrap()).unwrap().count();
    assert_eq!(files, 1);

    harness.get_by_label("Undo import").click();
    harness.step();
    wait(&mut harness, "no import", |editor| {
        editor.round_trip.history.is_empty() && editor.running.is_idle()
    });
    harness.get_by_label("undone");
    harness.get_by_label("There are none that can be undone.");

    // By hand it comes again.
    harness.state_mut().apply(RoundTripRequest::ImportFiles(vec![file]));
    wait(&mut harness, "the import by hand", |editor| editor.round_trip.history.len() == 1);
}

#[test]
fn exposures_are_decided_by_hand_and_kept_and_what_is_hidden_is_listed() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(piazza(folder.path(), 9)));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.state_mut().run(&command::layers::BUILD);
    wait(&mut harness, "the layers", |editor| editor.running.is_idle());

    harness.get_by_role_and_label(Role::Button, "Colour").click();
    harness.step();
    wait(&mut harness, "the exposures", |editor| {
        editor.session.as_ref().and_then(|session| editor.quality.colour.report(session)).is_some()
    });
    harness.step();
    harness.get_by_label("Leave out").click();
    harness.step();
    wait(&mut harness, "the decision", |editor| editor.running.is_idle() && editor.is_dirty());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    let project = folder.path().join("piazza");
    let left_out = |project: &Path| read_project(project).unwrap().colour.left_out.len();
    assert_eq!(left_out(&project), 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.step();
    wait(&mut harness, "the way back", |editor| editor.running.is_idle() && editor.is_dirty());
    assert!(harness.state().session.as_ref().unwrap().opened.project.colour.is_default());

    harness.get_by_role_and_label(Role::Button, "Fill").click();
    harness.step();
    wait(&mut harness, "the worst", |editor| editor.running.is_idle());
    harness.step();
    harness.get_by_label("Worst first");
    harness.get_by_label("Occluded areas of 01_church.jpg");
}

#[test]
fn a_photo_is_looked_at_layer_by_layer() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(piazza(folder.path(), PHOTOS)));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.get_by_label("04_arcade.jpg, not built").click();
    harness.key_press(Key::F3);
    harness.step();
    harness.step();
    harness.get_by_label("This photo has no layers yet.");
    harness.get_all_by_label("Build layers of this photo").next().unwrap().click();
    let built = |editor: &Editor| {
        let session = editor.session.as_ref().unwrap();
        session.photos[3].is_current() && editor.running.is_idle()
    };
    wait(&mut harness, "the layers of one photo", built);
    // What was built is read by jobs that the next frames start.
    harness.step();
    wait(&mut harness, "what the view shows", |editor| editor.running.is_idle());

    // Without its front layer the photo is another picture; what is at a pixel has a name.
    let point = |harness: &mut Harness<'_, Editor>| {
        let view = harness.get_by_label("Photo view").rect();
        let at = view.min + view.size() * eframe::egui::vec2(0.5, 0.6);
        harness.hover_at(at);
        harness.step();
        harness.step();
        at
    };
    let at = point(&mut harness);
    appears(&mut harness, "shown by the photo, ");
    harness.key_press(Key::Period);
    harness.step();
    assert_eq!(harness.state().flat.photo.hidden_layers, 1);
    wait(&mut harness, "the photo without its first layer", |editor| editor.running.is_idle());
    point(&mut harness);
    appears(&mut harness, " away");
    let first = harness.query_all_by_label_contains("Visibility layer 1, ").next();
    assert!(first.is_none(), "the first one was taken off");

    // A click goes from the layer to the object to the face.
    for expected in ["Layer {", "Object(", "Face("] {
        harness.drag_at(at);
        harness.step();
        harness.drop_at(at);
        harness.step();
        harness.step();
        let selection = format!("{:?}", harness.state().selection.main);
        assert!(selection.starts_with(expected), "{selection}");
    }

    // The layer alone, and where its texels come from.
    harness.key_press(Key::F4);
    harness.step();
    harness.step();
    harness.get_by_label("Image layer view");
    harness.get_by_label("Provenance").click();
    harness.step();
    wait(&mut harness, "where texels come from", |editor| editor.running.is_idle());
    harness.get_by_label("this photo");

    // Faces without texture are listed with the reason, and a click goes to the face.
    harness.key_press(Key::U);
    harness.step();
    harness.step();
    harness.get_by_label("Faces without texture from this photo");
    let stack = harness.state().session.as_ref().unwrap().photos[3].stack.clone().unwrap();
    let names = stack.untextured.iter().map(|face| format!("{}[{}]", face.object, face.face));
    let shown = names.filter(|name| harness.query_all_by_label(name).next().is_some()).last();
    harness.get_all_by_label(&shown.expect("the list shows some faces")).last().unwrap().click();
    harness.step();
    harness.step();
    let selection = format!("{:?}", harness.state().selection.main);
    assert!(selection.starts_with("Face("), "{selection}");

    // Small pictures of photos are there for the next start.
    let kept = std::fs::read_dir(folder.path().join("piazza/cache/thumbnails")).unwrap().count();
    assert_eq!(kept, PHOTOS);
}
