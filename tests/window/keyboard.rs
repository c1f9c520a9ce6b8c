//! The keyboard in the window: who a key belongs to, and where the focus is.

use std::path::Path;

use crate::harness::{appears, is_there, project_of, site_of_piazza, wait, window};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use quadratura::testing::app::command;
use quadratura::testing::app::command::KeysIn;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::panes::{KeyOwner, Pane};
use quadratura::testing::io::project::read_project;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::view::DisplayMode;

/// A window with the piazza, nothing built.
fn opened(folder: &Path) -> Harness<'static, Editor> {
    let project = folder.join("piazza");
    project_of(&site_of_piazza(), &project);
    let mut harness = window(Some(project));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness
}

/// Frames until whatever opens or closes has done so.
fn settle(harness: &mut Harness<'_, Editor>) {
    (0..4).for_each(|_| harness.step());
}

/// Runs a command where it is ready; whether it was.
fn ask(harness: &mut Harness<'_, Editor>, name: &str) -> bool {
    let command = command::all().find(|command| command.name == name).unwrap();
    let is_ready = (command.ready)(harness.state()).is_ok();
    harness.state_mut().run(command);
    settle(harness);
    is_ready
}

#[test]
fn while_a_dialog_is_open_no_key_reaches_what_is_behind_it_and_escape_closes_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    harness.state_mut().keep_view();
    settle(&mut harness);
    assert!(harness.state().is_dirty());
    let dialogs = [
        ("Settings…", "Mouse in the 3D view"),
        ("New project…", "Project folder"),
        ("Export…", "Other programs"),
        ("Import edited files…", "exported from this project"),
        ("Choose image editor…", "opens photos in"),
        ("Render picture…", "Render picture of the view"),
        ("Command palette", "Window › Command palette"),
        ("Quit", "Save changes to"),
    ];
    for (name, words) in dialogs {
        // These need a project that is built.
        if !ask(&mut harness, name) {
            assert!(["Export…", "Render picture…"].contains(&name), "{name} does not open");
            continue;
        }
        assert!(is_there(&harness, words), "{name}");
        assert!(harness.state().has_dialog(), "{name}");
        harness.key_press(Key::Num2);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::I);
        settle(&mut harness);
        assert!(harness.state().space.look.display == DisplayMode::Colour, "2 behind {name}");
        assert!(harness.state().is_dirty(), "Ctrl+Z behind {name}");
        assert_eq!(
            harness.state().round_trip.dialogs.import.is_some(),
            name == "Import edited files…",
            "Ctrl+I behind {name}"
        );
        // Text is as large as one likes in dialogs, too.
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Plus);
        settle(&mut harness);
        assert_eq!(harness.state().settings.scale, 1.1, "{name}");
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Num0);
        settle(&mut harness);
        harness.key_press(Key::Escape);
        settle(&mut harness);
        // A line that is typed into is left first.
        if harness.state().has_dialog() {
            harness.key_press(Key::Escape);
            settle(&mut harness);
        }
        assert!(!harness.state().has_dialog() && !is_there(&harness, words), "{name}");
    }
    harness.key_press(Key::Num2);
    settle(&mut harness);
    assert!(harness.state().space.look.display == DisplayMode::Weights, "and then keys hold again");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert!(!harness.state().is_dirty());
}

#[test]
fn enter_imports_what_was_typed() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    assert!(ask(&mut harness, "Import edited files…"));
    // The line has the focus: whoever types types into it.
    let line = harness.get_by_role_and_label(Role::TextInput, "File or folder");
    assert!(line.accesskit_node().is_focused());
    line.type_text("no-such-file.psd");
    harness.step();
    harness.key_press(Key::Enter);
    settle(&mut harness);
    assert!(harness.state().round_trip.dialogs.import.is_none());
    wait(&mut harness, "the refusal", |editor| {
        editor.notes.list().iter().any(|note| note.text.to_string().contains("no-such-file.psd"))
    });
}

#[test]
fn enter_saves_what_is_asked_about_and_tab_goes_to_the_next_answer() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    harness.state_mut().keep_view();
    harness.state_mut().keep_view();
    settle(&mut harness);
    assert!(ask(&mut harness, "Close project"));
    assert!(harness.get_by_label("Save").accesskit_node().is_focused());
    harness.key_press(Key::Tab);
    settle(&mut harness);
    assert!(harness.get_by_label("Do not save").accesskit_node().is_focused());
    harness.key_press(Key::Escape);
    settle(&mut harness);
    assert!(harness.state().session.is_some());

    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    appears(&mut harness, "Save changes to");
    settle(&mut harness);
    harness.key_press(Key::Enter);
    wait(&mut harness, "the way out", |editor| editor.session.is_none());
    assert_eq!(read_project(&folder.path().join("piazza")).unwrap().views.len(), 2);
}

#[test]
fn a_folder_that_is_not_there_is_typed_on_and_letters_without_a_project_are_no_commands() {
    let mut harness = window(None);
    settle(&mut harness);
    let notes = |harness: &Harness<'_, Editor>| harness.state().notes.list().len();
    harness.get_by_role_and_label(Role::TextInput, "Folder of a site or project").focus();
    harness.step();
    harness
        .get_by_role_and_label(Role::TextInput, "Folder of a site or project")
        .type_text("/no/such/folder");
    harness.step();
    harness.key_press(Key::Enter);
    settle(&mut harness);
    harness.get_by_label("There is no such folder.");
    let line = harness.get_by_role_and_label(Role::TextInput, "Folder of a site or project");
    assert!(line.accesskit_node().is_focused());
    harness.key_press(Key::Escape);
    settle(&mut harness);
    for key in [Key::L, Key::F, Key::Num2, Key::CloseBracket] {
        harness.key_press(key);
        settle(&mut harness);
    }
    assert_eq!(notes(&harness), 0, "{:?}", harness.state().notes.list());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut harness);
    assert_eq!(notes(&harness), 1, "keys with Ctrl are meant");
}

#[test]
fn the_photo_that_keys_select_comes_into_sight_in_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    let photos = &harness.state().session.as_ref().unwrap().opened.site.photos;
    let (count, last) = (photos.len(), photos[photos.len() - 1].name.clone());
    let first = format!("{}, not built", photos[0].name);
    let last = format!("{last}, not built");
    let has = |harness: &Harness<'_, Editor>, name: &str| harness.query_by_label(name).is_some();
    assert!(has(&harness, &first) && !has(&harness, &last), "the list is longer than its panel");
    for _ in 0..=count {
        if harness.state().selected_photo() != Some(PhotoId(count as u32 - 1)) {
            harness.key_press(Key::CloseBracket);
            settle(&mut harness);
        }
    }
    assert_eq!(harness.state().selected_photo(), Some(PhotoId(count as u32 - 1)));
    appears(&mut harness, &last);
}

#[test]
fn windows_beside_the_work_let_keys_through_and_escape_closes_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    let windows =
        [("Keys and mouse", "with Shift faster"), ("Layer options…", "Longest side of an image layer")];
    for (place, (name, words)) in windows.into_iter().enumerate() {
        assert!(ask(&mut harness, name), "{name}");
        assert!(is_there(&harness, words) && !harness.state().has_dialog(), "{name}");
        let (key, shown) = [(Key::Num2, DisplayMode::Weights), (Key::Num4, DisplayMode::Coverage)][place];
        harness.key_press(key);
        settle(&mut harness);
        assert!(harness.state().space.look.display == shown, "{name}");
        harness.key_press(Key::Escape);
        settle(&mut harness);
        assert!(!is_there(&harness, words), "{name}");
    }
}

#[test]
fn how_far_surroundings_are_needed_is_an_option_of_layers_and_one_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    let reach = |editor: &Editor| editor.session.as_ref().unwrap().history.present().options.reach;
    let before = reach(harness.state());
    assert!(ask(&mut harness, "Layer options…"));
    let slider = harness.get_by_role_and_label(Role::Slider, "Surroundings reach");
    slider.set_value_accesskit(100.0);
    settle(&mut harness);
    assert_eq!(reach(harness.state()), 1.0, "the whole photo");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(reach(harness.state()), before);
}

/// Frames until the pointer is known to be over the view of this name.
fn point_at(harness: &mut Harness<'_, Editor>, view: &str) {
    let middle = harness.get_by_label(view).rect().center();
    harness.hover_at(middle);
    settle(harness);
}

#[test]
fn space_after_a_click_in_a_list_plays_the_flight_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    harness.state_mut().add_keyframe();
    harness.state_mut().show_everything();
    settle(&mut harness);
    harness.state_mut().add_keyframe();
    harness.state_mut().flights.time_s = 0.0;
    settle(&mut harness);
    let steps = |harness: &Harness<'_, Editor>| {
        harness.state().session.as_ref().unwrap().history.undoes().map(str::to_owned)
    };
    let before = steps(&harness);
    let name = harness.state().session.as_ref().unwrap().model().objects[0].name.clone();
    harness.get_by_role_and_label(Role::TreeItem, &name).click();
    settle(&mut harness);
    assert!(harness.state().selected_object() == Some(name), "the row is selected");
    harness.key_press(Key::Space);
    harness.step();
    assert!(harness.state().plays());
    assert_eq!(steps(&harness), before);
    // In the photo, Space belongs to the photo.
    harness.key_press(Key::Space);
    harness.key_press(Key::F3);
    settle(&mut harness);
    assert!(!harness.state().plays());
    point_at(&mut harness, "Photo view");
    harness.key_press(Key::Space);
    settle(&mut harness);
    assert!(!harness.state().plays());
}

#[test]
fn a_key_that_changes_the_project_does_so_in_its_own_view_only() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    let name = harness.state().session.as_ref().unwrap().model().objects[0].name.clone();
    harness.get_by_role_and_label(Role::TreeItem, &name).click();
    settle(&mut harness);
    harness.key_press(Key::K);
    settle(&mut harness);
    assert!(!harness.state().is_dirty(), "the keys belong to the list");
    point_at(&mut harness, "3D view");
    assert_eq!(harness.state().panes.key_owner(), KeyOwner::View(Pane::Space));
    harness.key_press(Key::K);
    settle(&mut harness);
    assert!(harness.state().is_dirty(), "the keys belong to the view under the pointer");
    // No other key without Ctrl is a change of the project.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    for command in command::all() {
        let plain = command.keys.iter().find(|keys| !keys.modifiers.command);
        let Some(keys) = plain.filter(|_| command.keys_in != KeysIn::Space) else { continue };
        harness.key_press_modifiers(keys.modifiers, keys.logical_key);
        settle(&mut harness);
        assert!(!harness.state().is_dirty(), "{}", command.name);
        harness.key_press(Key::Escape);
        settle(&mut harness);
    }
}

#[test]
fn the_assistant_begins_in_its_first_field() {
    let mut harness = window(None);
    settle(&mut harness);
    assert!(ask(&mut harness, "New project…"));
    let field = harness.get_by_role_and_label(Role::TextInput, "Folder of the site");
    assert!(field.accesskit_node().is_focused());
}

#[test]
fn a_click_in_the_history_goes_to_that_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    (0..3).for_each(|_| harness.state_mut().keep_view());
    settle(&mut harness);
    let views = |harness: &Harness<'_, Editor>| {
        harness.state().session.as_ref().unwrap().history.present().views.len()
    };
    assert_eq!(views(&harness), 3);
    assert!(ask(&mut harness, "History"));
    harness.get_by_label("project as opened").click();
    settle(&mut harness);
    assert_eq!(views(&harness), 0);
    harness.get_by_label("bookmark View 2").click();
    settle(&mut harness);
    assert_eq!(views(&harness), 2);
    harness.key_press(Key::Escape);
    settle(&mut harness);
    assert!(!is_there(&harness, "project as opened"));
}

#[test]
fn the_help_has_about_and_diagnostics() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    assert!(ask(&mut harness, "About Quadratura"));
    assert!(is_there(&harness, "Licence: MIT OR Apache-2.0"));
    harness.key_press(Key::Escape);
    settle(&mut harness);
    assert!(!is_there(&harness, "Licence: MIT OR Apache-2.0"));
    assert!(harness.state().diagnostics().contains("9 photos (0 built)"));
    assert!(ask(&mut harness, "Copy diagnostics"));
    assert!(harness.state().notes.list().iter().any(|note| note.text.to_string().contains("copied")));
}
