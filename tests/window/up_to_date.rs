//! *Keep everything up to date*: what the window builds and fills by itself, and what it leaves alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::common;
use crate::harness::{appears, first_photos, opened, wait};
use crate::paper;
use egui_kittest::Harness;
use quadratura::task::Task;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::life::{Goal, LifeEvent};
use quadratura::testing::app::request::{JobRequest, ProjectRequest};
use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::document::{PhotoDecisions, Project, Stack};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::sites::open::open;
use quadratura::testing::stacks::fill::stale_fillings;

const CHURCH: &str = "01_church.jpg";
/// A colour that no stone of the piazza has.
const MAGENTA: [u16; 4] = [65535, 0, 65535, 65535];

/// A project of the piazza's first photos whose layers are built and not filled, in a window that updates nothing.
fn built(folder: &Path, photos: usize) -> (PathBuf, Harness<'static, Editor>) {
    let project = first_photos(folder, photos);
    let mut harness = opened(&project);
    harness.state_mut().run(&command::layers::BUILD);
    wait(&mut harness, "the layers", idle);
    (project, harness)
}

fn idle(editor: &Editor) -> bool {
    editor.running.is_idle()
}

/// Nothing runs, and nothing is left to be updated.
pub fn is_up_to_date(editor: &Editor) -> bool {
    let Some(session) = &editor.session else { return false };
    let mut photos = session.photos.iter();
    let are_filled = photos
        .all(|photo| photo.is_current() && photo.stack.as_ref().is_some_and(|stack| stack.fill.is_some()));
    idle(editor) && are_filled && session.pending.invalidation.is_none()
}

fn keep_up_to_date(harness: &mut Harness<'_, Editor>) {
    harness.state_mut().run(&command::layers::KEEP_UP);
    wait(harness, "fillings", is_up_to_date);
}

fn decide_margin(harness: &mut Harness<'_, Editor>, margin: u32) {
    let editor = harness.state_mut();
    let mut project = Project::clone(editor.session.as_ref().unwrap().history.present());
    let mut decided = PhotoDecisions::default();
    decided.options.margin = Some(margin);
    project.decisions.set(CHURCH, decided);
    editor.edit("margin", project, None);
}

fn stack_on_disk(project: &Path) -> Stack {
    StackStore::new(project).current(CHURCH).unwrap().unwrap()
}

/// The files below these folders of a project, with their modification times.
fn files(project: &Path, folders: &[&str]) -> BTreeMap<PathBuf, SystemTime> {
    let mut found = BTreeMap::new();
    let mut left: Vec<PathBuf> = folders.iter().map(|folder| project.join(folder)).collect();
    while let Some(folder) = left.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => left.push(path),
                false => drop(found.insert(path.clone(), fs::metadata(&path).unwrap().modified().unwrap())),
            }
        }
    }
    found
}

#[test]
fn an_unsaved_decision_is_built_and_filled_by_itself_and_its_stack_is_out_of_date_once_it_is_discarded() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (project, mut harness) = built(folder.path(), 2);
    assert!(stack_on_disk(&project).fill.is_none());
    keep_up_to_date(&mut harness);
    let plain = stack_on_disk(&project);
    assert!(plain.fill.is_some());
    decide_margin(&mut harness, 11);
    wait(&mut harness, "another stack", |editor| {
        let made = editor.session.as_ref().and_then(|session| session.stack_of(PhotoId(0)));
        made.is_some_and(|stack| stack.inputs != plain.inputs) && is_up_to_date(editor)
    });
    assert!(stack_on_disk(&project).inputs.contains('-'), "made from a decision that is not saved");

    harness.state_mut().settings.keep_up_to_date = false;
    harness.state_mut().apply(ProjectRequest::Life(LifeEvent::Leave(Goal::Close)));
    harness.state_mut().apply(ProjectRequest::Life(LifeEvent::Discard));
    wait(&mut harness, "the end", |editor| editor.session.is_none() && idle(editor));
    harness.state_mut().apply(ProjectRequest::Open(project.clone()));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && idle(editor));
    assert_eq!(harness.state().session.as_ref().unwrap().photos[0].word, "stale");
    keep_up_to_date(&mut harness);
    assert_eq!(stack_on_disk(&project).inputs, plain.inputs);
}

#[test]
fn files_of_the_site_that_changed_on_disk_wait_for_a_click() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (project, mut harness) = built(folder.path(), 2);
    keep_up_to_date(&mut harness);
    let before = stack_on_disk(&project);
    let file = folder.path().join("site/piazza.obj");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}\n# exported again\n")).unwrap();
    decide_margin(&mut harness, 11);
    appears(&mut harness, "Files have changed on disk: the model.");
    wait(&mut harness, "that nothing runs", idle);
    assert_eq!(stack_on_disk(&project), before, "neither built from what was read nor from what is on disk");
    harness.state_mut().apply(JobRequest::Reread(None));
    wait(&mut harness, "another stack", |editor| {
        let made = editor.session.as_ref().and_then(|session| session.stack_of(PhotoId(0)));
        made.is_some_and(|stack| stack.inputs != before.inputs) && is_up_to_date(editor)
    });
}

#[test]
fn paint_that_was_left_behind_is_seen_from_other_photos_when_the_project_is_opened() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (project, mut harness) = built(folder.path(), 3);
    keep_up_to_date(&mut harness);
    harness.state_mut().settings.keep_up_to_date = false;
    harness.state_mut().settings.image_editor.editor = None;
    // A program that opens nothing: whoever paints is this test.
    harness.state_mut().settings.image_editor.program = "/bin/true".into();
    harness.state_mut().settings.image_editor.format = ExportFormat::Psd;
    harness.state_mut().selection.photo = Some(PhotoId(0));
    harness.state_mut().run(&command::paint::EDIT);
    wait(&mut harness, "the export", idle);
    let file = project.join("editing/01_church.jpg.psd");
    let mut paper = paper::Paper::read(&file);
    // The surroundings have no surface that other photos share.
    let sheets = paper.image_layers().filter(|sheet| !sheet.name.starts_with("surroundings"));
    let sheet = sheets.max_by_key(|sheet| sheet.pixels_where(true).len()).unwrap();
    let shown = sheet.pixels_where(true);
    shown.iter().take(3000).for_each(|(x, y)| sheet.paint(*x, *y, MAGENTA));
    paper.write(&file);
    wait(&mut harness, "the import", |editor| editor.round_trip.history.len() == 1 && idle(editor));
    drop(harness);
    let left = |project: &Path| {
        let opened = open(project, &Task::silent()).unwrap();
        stale_fillings(project, &opened.project, &opened.site).unwrap()
    };
    assert!(!left(&project).is_empty(), "the other photos lack the paint");

    let before = files(&project, &["exports", "editing"]);
    let mut harness = opened(&project);
    harness.state_mut().run(&command::layers::KEEP_UP);
    harness.step();
    wait(&mut harness, "the paint on other photos", |editor| {
        is_up_to_date(editor) && left(&project).is_empty()
    });
    assert_eq!(
        files(&project, &["exports", "editing"]),
        before,
        "an update writes neither exports nor open files"
    );
    assert_eq!(harness.state().round_trip.history.len(), 1, "nothing was imported once more");
}
