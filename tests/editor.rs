//! The editor's window, driven by the names of its widgets, with the software adapter where there is no other.

mod common;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::app::command;
use quadratura::app::editor::Editor;
use quadratura::geometry::Similarity;
use quadratura::layers::Options;
use quadratura::recipe::create::{NewProject, create_project};
use quadratura::task::Task;

/// A guard against waiting for ever, far beyond what any step takes.
const NEVER: Duration = Duration::from_secs(600);

fn window(project: Option<PathBuf>) -> Harness<'static, Editor> {
    let builder = Harness::builder().with_size([1280.0, 800.0]);
    builder.build_eframe(|creation| Editor::new(&creation.egui_ctx, None, project))
}

/// Lets frames go by until something is as it should be.
fn wait(harness: &mut Harness<'_, Editor>, what: &str, done: impl Fn(&Editor) -> bool) {
    let start = Instant::now();
    while !done(harness.state()) {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        let notes: Vec<&str> = harness.state().notes.list().iter().map(|note| note.text.as_str()).collect();
        assert!(start.elapsed() < NEVER, "waiting for {what}: {notes:?}");
    }
    harness.step();
}

fn piazza(folder: &Path) -> PathBuf {
    let (project, site) =
        (folder.join("piazza"), Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza"));
    let new = NewProject {
        photos: site.join("photos"),
        cameras: site.join("sparse"),
        model: site.join("piazza.obj"),
        world_from_model: Similarity::IDENTITY,
        options: Options::default(),
    };
    create_project(&project, &new, &Task::silent()).unwrap();
    project
}

#[test]
fn an_empty_window_says_what_to_do_and_the_palette_has_every_command() {
    let mut harness = window(None);
    harness.step();
    harness.get_by_label_contains("Open project");
    harness.get_by_label_contains("drop the folder of a project");
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
    wait(&mut harness, "the refusal", |editor| editor.jobs.is_idle() && !editor.notes.list().is_empty());
    let note = &harness.state().notes.list()[0].text;
    assert!(note.contains("there is no project here") && note.contains("quadratura new"), "{note}");
    harness.get_by_label_contains("there is no project here");
    assert!(harness.state().session.is_none());
}

#[test]
fn a_site_is_opened_built_and_shown_by_hand() {
    if common::gpu_rasteriser().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(piazza(folder.path())));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.jobs.is_idle());
    harness.get_by_label("01_church.jpg, not built");
    harness.get_by_label("No photo has layers yet.");

    harness.get_by_label("Build layers").click();
    harness.step();
    let built = |editor: &Editor| {
        let session = editor.session.as_ref().unwrap();
        session.painter.is_some() && session.photos.iter().all(|photo| photo.is_current())
    };
    wait(&mut harness, "the layers", built);
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
    harness.get_by_label("01_church.jpg, current");

    // Selecting by hand: a photo in the list, then an object in the outliner.
    harness.get_by_label("04_arcade.jpg, current").click();
    harness.step();
    harness.step();
    assert_eq!(harness.state().selected_photo_name().as_deref(), Some("04_arcade.jpg"));
    harness.get_by_label("Look through the photo").click();
    wait(&mut harness, "the flight's end", |editor| editor.space.through() == Some(3));
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
    wait(&mut harness, "the way back", |editor| editor.space.through() == Some(3));

    // Another program may not write meanwhile, and may afterwards.
    let project = folder.path().join("piazza");
    let locked = quadratura::io::lock::ProjectLock::take(&project).unwrap_err().to_string();
    assert!(locked.contains("is writing to this project"), "{locked}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    wait(&mut harness, "closing", |editor| editor.session.is_none() && editor.jobs.is_idle());
    quadratura::io::lock::ProjectLock::take(&project).unwrap();
}
