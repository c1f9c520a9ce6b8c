//! A whole session in the editor's window, by the names of what is seen: from the empty window to paint that is there
//! when the project is opened again.
#![cfg(unix)]

use std::path::Path;

use crate::common;
use crate::harness::{appears, command, is_there, press, small_piazza, wait, window};
use crate::paper;
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::scene::PhotoId;

/// A program that opens nothing: whoever paints is this test.
const NOBODY: &str = "/bin/true";
/// A colour that no stone of the piazza has.
const MAGENTA: [u16; 4] = [65535, 0, 65535, 65535];
/// So much is painted that nobody can overlook it.
const PAINTED: usize = 3000;

#[test]
fn a_site_becomes_a_project_is_built_painted_on_undone_rendered_saved_and_is_as_it_was_when_it_is_opened_again()
 {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (site, project) = (folder.path().join("square"), folder.path().join("square-project"));
    small_piazza(&site, 3);
    let mut harness = window(None);
    begin(&mut harness, &site);
    build(&mut harness);
    choose_nobody(&mut harness);

    let file = project.join("editing/01_church.jpg.xcf");
    edit(&mut harness);
    paint_on(&file);
    appears(&mut harness, "Import 1");
    appears(&mut harness, "Before: ");
    assert!(is_there(&harness, "After: ") && is_there(&harness, "3\u{2009}000 px painted"));

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "no import", |editor| {
        editor.round_trip.history.is_empty() && editor.running.is_idle()
    });
    assert!(is_there(&harness, "undone"));
    assert_eq!(magenta(&picture(&mut harness, &project)), 0);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    wait(&mut harness, "the import again", |editor| {
        editor.round_trip.history.len() == 1 && editor.running.is_idle()
    });
    let shown = magenta(&picture(&mut harness, &project));
    assert!(shown > PAINTED / 10, "{shown} pixels of the picture are painted");

    // Something to save, too; then everything is closed, and opened from the list of the empty window.
    command(&mut harness, "Add bookmark");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "the save", |editor| !editor.is_dirty());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    wait(&mut harness, "closing", |editor| editor.session.is_none() && editor.running.is_idle());
    press(&mut harness, "square-project");
    wait(&mut harness, "the project again", is_shown);
    assert_eq!(harness.state().round_trip.history.len(), 1);
    let book = PaintStore::new(&project).read().unwrap();
    assert_eq!((book.imports.len(), book.next_import()), (1, 2), "nothing was imported once more");
    look_through(&mut harness);
    let again = magenta(&picture(&mut harness, &project));
    assert!(again > PAINTED / 10, "{again} pixels of the picture are painted");
}

/// From the empty window to a project that was checked.
fn begin(harness: &mut Harness<'_, Editor>, site: &Path) {
    harness.step();
    harness.get_by_label_contains("New project").click();
    appears(harness, "The photos are missing");
    harness.get_by_role_and_label(Role::TextInput, "Folder of the site").focus();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Folder of the site").type_text(site.to_str().unwrap());
    harness.key_press(Key::Enter);
    for found in ["3 photos", "3 of", "faces"] {
        appears(harness, found);
    }
    harness.get_by_label("Create project").click();
    wait(harness, "the project", |editor| editor.session.is_some());
    appears(harness, "The model is aligned with the photos");
    press(harness, "Close window");
}

fn build(harness: &mut Harness<'_, Editor>) {
    harness.get_by_label("01_church.jpg, not built");
    press(harness, "Build layers");
    wait(harness, "the layers", is_shown);
    look_through(harness);
}

/// Everything is built, and the 3D view shows it.
fn is_shown(editor: &Editor) -> bool {
    let built = editor.session.as_ref().is_some_and(|session| {
        editor.space.device.is_some() && session.photos.iter().all(|photo| photo.is_current())
    });
    built && editor.running.is_idle() && editor.space.has_picture()
}

fn look_through(harness: &mut Harness<'_, Editor>) {
    harness.get_by_label_contains("01_church.jpg, built").click();
    harness.step();
    harness.step();
    command(harness, "Look through camera");
    wait(harness, "the photo's view", |editor| editor.space.through() == Some(PhotoId(0)));
}

fn choose_nobody(harness: &mut Harness<'_, Editor>) {
    command(harness, "Choose image editor…");
    press(harness, "Another program");
    harness.get_by_role_and_label(Role::TextInput, "Program").focus();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Program").type_text(NOBODY);
    harness.step();
    press(harness, "XCF (GIMP)");
    press(harness, "Close");
}

fn edit(harness: &mut Harness<'_, Editor>) {
    command(harness, "Edit in image editor");
    wait(harness, "the export", |editor| editor.running.is_idle());
    harness.get_by_label_contains("What you save there is imported automatically.");
}

/// Paints on the layer of which the photo shows most, and saves.
fn paint_on(file: &Path) {
    let mut paper = paper::Paper::read(file);
    let sheet = paper.image_layers().max_by_key(|sheet| sheet.pixels_where(true).len()).unwrap();
    let shown = sheet.pixels_where(true);
    assert!(shown.len() > PAINTED);
    shown.iter().take(PAINTED).for_each(|(x, y)| sheet.paint(*x, *y, MAGENTA));
    paper.write(file);
}

/// Makes a picture of the view.
fn picture(harness: &mut Harness<'_, Editor>, project: &Path) -> image::RgbaImage {
    let file = project.join("pictures/view.png");
    command(harness, "Render picture…");
    press(harness, "Render");
    wait(harness, "the picture", |editor| file.is_file() && editor.running.is_idle());
    let picture = image::open(&file).unwrap().to_rgba8();
    std::fs::remove_file(&file).unwrap();
    picture
}

/// Pixels of a picture that are painted.
fn magenta(picture: &image::RgbaImage) -> usize {
    picture.pixels().filter(|pixel| pixel[0] > 150 && pixel[1] < 100 && pixel[2] > 150).count()
}
