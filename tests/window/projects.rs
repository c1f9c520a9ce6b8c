//! Projects come and go in the editor's window: made with the assistant, checked and mended, found again, waited for,
//! left; and what happens when the program itself makes a mistake.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common;
use crate::harness::{appears, command, copy_of_piazza, is_there, press, project_of, wait, window};
use eframe::egui::accesskit::Role;
use eframe::egui::{DroppedFile, Key, Modifiers, OutputCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::{DecideRequest, ProjectRequest};
use quadratura::testing::app::running::JobKind;
use quadratura::testing::document::Project;
use quadratura::testing::files::lock::ProjectLock;
use quadratura::testing::geometry::Similarity;
use quadratura::testing::io::project::read_project;

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("folders have none".into())
    }
}

fn drop_on(harness: &mut Harness<'_, Editor>, path: &Path) {
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_path_buf())));
    harness.step();
    harness.step();
}

fn idle(editor: &Editor) -> bool {
    editor.running.is_idle()
}

/// Where the model stands, as the user has decided.
fn stands(editor: &Editor) -> Similarity {
    editor.session.as_ref().unwrap().history.present().world_from_model
}

/// The piazza with files of its own: three photos, so that it is quick, and a model that lies on its side if wanted.
fn site(folder: &Path, lying: bool) -> PathBuf {
    let to = folder.join("square");
    copy_of_piazza(&to, 3);
    let model = fs::read_to_string(to.join("piazza.obj")).unwrap();
    let turned = |line: &str| match line.strip_prefix("v ").filter(|_| lying) {
        Some(vertex) => {
            let at: Vec<&str> = vertex.split_whitespace().collect();
            format!("v {} {} -{}\n", at[0], at[2], at[1]).replace("--", "")
        }
        None => format!("{line}\n"),
    };
    fs::write(to.join("piazza.obj"), model.lines().map(turned).collect::<String>()).unwrap();
    to
}

fn project(folder: &Path, site: &Path) -> PathBuf {
    let project = folder.join("project");
    project_of(site, &project);
    project
}

#[test]
fn a_folder_that_is_dropped_becomes_a_project_that_is_checked_and_mended_with_a_click() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), true);
    let mut harness = window(None);
    drop_on(&mut harness, &site);
    appears(&mut harness, "3 photos");
    appears(&mut harness, "cameras");
    appears(&mut harness, "3 of");
    appears(&mut harness, "faces");
    let made = folder.path().join("square-project");
    harness.get_by_label("Create project").click();
    wait(&mut harness, "the project", |editor| editor.session.is_some());
    assert_eq!(read_project(&made).unwrap().model, "../square/piazza.obj");

    wait(&mut harness, "the check", idle);
    appears(&mut harness, "Fix alignment");
    assert!(is_there(&harness, "axes differ"), "the mistake is named");
    harness.get_by_label("Fix alignment").click();
    harness.step();
    appears(&mut harness, "The model is aligned with the photos");
    assert_ne!(stands(harness.state()), Similarity::IDENTITY);
    harness.get_by_label("Undo alignment").click();
    harness.step();
    appears(&mut harness, "The model is not aligned with the photos");
    assert_eq!(stands(harness.state()), Similarity::IDENTITY);
    harness.state_mut().apply(DecideRequest::Undo);
    assert_ne!(stands(harness.state()), Similarity::IDENTITY, "moving it was a step like any other");
}

#[test]
fn what_is_missing_for_a_project_is_said_where_it_belongs_and_nothing_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), false);
    fs::remove_file(site.join("piazza.obj")).unwrap();
    fs::write(site.join("sparse/images.txt"), "nonsense\n").unwrap();
    let mut harness = window(None);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::N);
    harness.step();
    harness.step();
    appears(&mut harness, "The photos are missing");
    harness.get_by_role_and_label(Role::TextInput, "Folder of the site").focus();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Folder of the site").type_text(site.to_str().unwrap());
    harness.key_press(Key::Enter);
    appears(&mut harness, "Not found. Choose a coarse model");
    appears(&mut harness, "images.txt, line 1");
    harness.get_by_label("Create project").click();
    harness.step();
    assert!(harness.state().session.is_none() && !folder.path().join("square-project").exists());
    harness.key_press(Key::Escape);
    harness.step();
    harness.step();
    assert!(!is_there(&harness, "Create project"));
}

#[test]
fn what_is_exported_again_while_the_assistant_is_open_is_looked_at_again() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), false);
    let model = fs::read(site.join("piazza.obj")).unwrap();
    let mut harness = window(None);
    drop_on(&mut harness, &site);
    appears(&mut harness, "faces");
    fs::write(site.join("piazza.obj"), "v 0 0 0\n").unwrap();
    appears(&mut harness, "no faces among 1 vertices");
    fs::write(site.join("piazza.obj"), model).unwrap();
    appears(&mut harness, "77 objects");
}

#[test]
fn a_site_that_moved_is_found_again_and_project_json_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), false);
    let project = project(folder.path(), &site);
    let elsewhere = folder.path().join("archive/2024");
    fs::create_dir_all(&elsewhere).unwrap();
    fs::rename(&site, elsewhere.join("square")).unwrap();

    let mut harness = window(Some(project.clone()));
    appears(&mut harness, "Project files have moved");
    let photos = elsewhere.join("square/photos");
    harness.get_by_role_and_label(Role::TextInput, "Photos").focus();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Photos").type_text(photos.to_str().unwrap());
    appears(&mut harness, "Guessed: check that");
    appears(&mut harness, "3 photos");
    appears(&mut harness, "faces");
    harness.step();
    harness.get_by_label("Use these locations").click();
    wait(&mut harness, "the project", |editor| editor.session.is_some());
    assert_eq!(read_project(&project).unwrap().cameras, "../archive/2024/square/sparse");
}

#[test]
fn a_project_that_another_program_writes_to_opens_as_soon_as_it_is_free() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &site(folder.path(), false));
    let lock = ProjectLock::take(&project).unwrap();
    let mut harness = window(Some(project));
    appears(&mut harness, "Project is already open");
    assert!(is_there(&harness, &format!("process {}", std::process::id())));
    drop(lock);
    wait(&mut harness, "the project", |editor| editor.session.is_some());
    harness.step();
    assert!(!is_there(&harness, "Project is already open"));
}

#[test]
fn leaving_a_project_while_something_is_written_asks_and_stops_it_only_if_told() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &site(folder.path(), false));
    let mut harness = window(Some(project));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    let editor = harness.state_mut();
    editor.work.jobs.start(&mut editor.state.running, JobKind::Export, "Exporting", |task| {
        loop {
            task.check_cancelled()?;
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
    });
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    appears(&mut harness, "Files are still being written");
    harness.get_by_label("Continue working").click();
    harness.step();
    harness.step();
    assert!(harness.state().session.is_some() && harness.state().running.runs(JobKind::Export));

    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    appears(&mut harness, "Files are still being written");
    harness.get_by_label("Stop and close the project").click();
    wait(&mut harness, "the end", |editor| editor.session.is_none() && editor.running.is_idle());
}

/// A result that makes the window panic when it arrives.
fn fault(editor: &mut Editor) {
    let running = &mut editor.state.running;
    editor.work.jobs.start(running, JobKind::Look, "Looking", |_| Ok(Box::new(|_| panic!("the wall fell"))));
}

#[test]
fn a_fault_in_the_window_is_told_and_the_project_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &site(folder.path(), false));
    let mut harness = window(Some(project));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    fault(harness.state_mut());
    appears(&mut harness, "An internal error occurred");
    harness.get_by_label("Reopen project").click();
    harness.step();
    wait(&mut harness, "the project again", |editor| editor.session.is_some() && editor.running.is_idle());
    assert!(!is_there(&harness, "An internal error occurred"));
}

#[test]
fn what_was_decided_in_the_last_moment_before_a_fault_is_offered_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &site(folder.path(), false));
    let mut harness = window(Some(project.clone()));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    let decided = Project { world_from_model: twice_as_large(), ..read_project(&project).unwrap() };
    harness.state_mut().edit("size of the model", decided, None);
    fault(harness.state_mut());
    appears(&mut harness, "An internal error occurred");
    press(&mut harness, "Reopen project");
    appears(&mut harness, "Recover unsaved changes?");
    press(&mut harness, "Restore");
    assert_eq!(stands(harness.state()), twice_as_large());
}

fn twice_as_large() -> Similarity {
    Similarity { scale: 2.0, ..Similarity::IDENTITY }
}

#[test]
fn of_two_projects_asked_for_in_a_row_only_the_last_one_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), false);
    let projects = ["first", "second"].map(|name| folder.path().join(name));
    projects.iter().for_each(|project| project_of(&site, project));
    let mut harness = window(None);
    harness.state_mut().apply(ProjectRequest::Open(projects[0].clone()));
    // Read to its end, and nothing of it was shown yet.
    while ProjectLock::holder(&projects[0]).is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_secs(4));
    harness.state_mut().apply(ProjectRequest::Open(projects[1].clone()));
    wait(&mut harness, "the second", |editor| editor.session.is_some() && editor.running.is_idle());
    assert_eq!(harness.state().session.as_ref().unwrap().folder, projects[1]);
    assert_eq!(harness.state().settings.known.recent, [projects[1].clone()]);
    assert_eq!(ProjectLock::holder(&projects[0]), None);
}

#[test]
fn a_photo_that_is_missing_is_still_named_after_a_decision() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path(), false);
    let project = project(folder.path(), &site);
    let mut harness = window(Some(project.clone()));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.state_mut().keep_view();
    harness.step();
    command(&mut harness, "Missing files…");
    appears(&mut harness, "Photos are missing");
    harness.get_by_label("04_arcade.jpg");
}

#[test]
fn each_drag_of_the_films_settings_is_a_step_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &site(folder.path(), false));
    let mut harness = window(Some(project));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.state_mut().add_keyframe();
    harness.step();
    harness.step();
    let before = harness.get_by_value("25 fps").rect().center();
    let fps = |harness: &Harness<'_, Editor>| {
        let session = harness.state().session.as_ref().unwrap();
        session.history.present().flight.as_ref().unwrap().fps
    };
    let mut seen = vec![fps(&harness)];
    for _ in 0..2 {
        harness.drag_at(before);
        harness.step();
        for step in 1..6 {
            harness.hover_at(before + [8.0 * step as f32, 0.0].into());
            harness.step();
        }
        harness.drop_at(before + [40.0, 0.0].into());
        harness.step();
        harness.step();
        seen.push(fps(&harness));
    }
    assert!(seen[0] != seen[1] && seen[1] != seen[2], "{seen:?}");
    harness.state_mut().apply(DecideRequest::Undo);
    assert_eq!(fps(&harness), seen[1]);
}

#[test]
fn the_sample_project_is_opened_from_the_welcome_page_in_a_folder_that_is_typed() {
    let folder = tempfile::tempdir().unwrap();
    let sample = folder.path().join("sample");
    let mut harness = window(None);
    harness.step();
    harness.get_by_label_contains("Open sample project…").click();
    appears(&mut harness, "Copy and open");
    let dialogs = &mut harness.state_mut().opening.dialogs;
    dialogs.sample.as_mut().expect("the dialog is open").set(&sample);
    harness.step();
    harness.get_by_label("Copy and open").click();
    wait(&mut harness, "the project", |editor| editor.session.is_some());
    assert!(!is_there(&harness, "Copy and open"), "the dialog is closed");
    assert_eq!(harness.state().session.as_ref().unwrap().folder, sample.join("project"));
    assert_eq!(harness.state().session.as_ref().unwrap().opened.site.photos.len(), 9);
}

#[test]
fn a_message_is_copied_by_the_menu_of_a_right_click() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(Some(folder.path().to_path_buf()));
    wait(&mut harness, "the refusal", |editor| editor.running.is_idle() && !editor.notes.list().is_empty());
    harness.get_by_label_contains("there is no project in this folder").click_secondary();
    appears(&mut harness, "Copy message");
    harness.get_by_label("Copy message").click();
    let copies = |harness: &Harness<'_, Editor>| {
        let commands = harness.output().platform_output.commands.iter();
        let texts = commands.filter_map(|command| match command {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
        texts.collect::<Vec<_>>()
    };
    let mut copied = Vec::new();
    for _ in 0..3 {
        harness.step();
        copied.extend(copies(&harness));
    }
    assert!(copied.len() == 1 && copied[0].contains("there is no project in this folder"), "{copied:?}");
}

#[test]
fn sizes_and_colours_are_set_and_projects_that_are_gone_can_be_forgotten() {
    let gone = PathBuf::from("no such folder/castle");
    let mut harness = window(None);
    harness.state_mut().settings.known.recent.push(gone);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Comma);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Plus);
    harness.step();
    harness.step();
    assert_eq!(harness.state().settings.scale, 1.1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num0);
    harness.step();
    harness.step();
    assert_eq!(harness.state().settings.scale, 1.0);
    harness.get_by_label("Light").click();
    harness.step();
    harness.step();
    assert_eq!(harness.ctx.theme(), eframe::egui::Theme::Light);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Comma);
    harness.step();
    harness.step();
    harness.get_by_label_contains(" from list").click();
    harness.step();
    harness.step();
    assert!(harness.state().settings.known.recent.is_empty());
}
