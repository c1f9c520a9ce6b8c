//! Nothing is lost in the window: whatever ends it, whatever cannot be written, whatever is damaged on disk.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common;
use crate::harness::{SMALL_SIZE, appears, command, first_photos, is_there, opened, press, wait};
use crate::paper;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::{DecideRequest, JobRequest, ProjectRequest};
use quadratura::testing::document::Project;
use quadratura::testing::document::history::Gesture;
use quadratura::testing::document::masks::{Mask, MaskOrigin};
use quadratura::testing::geometry::{PixelRect, Spans};
use quadratura::testing::io::mask_store::MaskStore;
use quadratura::testing::io::project::{change_project, read_project};
use quadratura::testing::layered_files::Raster;
use quadratura::testing::scene::PhotoId;

const CHURCH: &str = "01_church.jpg";
const UNSAVED: &str = "project.unsaved.json";

fn project(folder: &Path) -> PathBuf {
    first_photos(folder, 3)
}

fn present(editor: &Editor) -> &Project {
    editor.session.as_ref().unwrap().history.present()
}

/// Decides something, as a drag of a slider does that has not ended.
fn decide(harness: &mut Harness<'_, Editor>, margin: u32) {
    let mut project = Project::clone(present(harness.state()));
    project.options.margin = margin;
    harness.state_mut().edit("margin", project, Some(Gesture(1)));
}

fn taken_back(project: &Path) -> Harness<'static, Editor> {
    let mut harness = opened(project);
    press(&mut harness, "Restore");
    harness
}

#[test]
fn a_window_that_ends_without_a_question_leaves_its_last_decision_to_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    // A display that is gone takes the window with it.
    let mut harness = opened(&project);
    decide(&mut harness, 11);
    assert!(!project.join(UNSAVED).exists(), "the drag goes on");
    drop(harness);
    let mut harness = taken_back(&project);
    assert_eq!(present(harness.state()).options.margin, 11);

    // A signal: what is decided is on disk before the window closes.
    decide(&mut harness, 12);
    harness.state().work.ending.request();
    drop(harness);
    let harness = taken_back(&project);
    assert_eq!(present(harness.state()).options.margin, 12);
}

#[test]
fn what_is_decided_by_one_click_is_kept_at_once_and_what_was_found_stays_until_it_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    harness.state_mut().apply(DecideRequest::SwitchObject("church.facade".into(), false));
    // No frame goes by: the job has begun with the decision.
    while !harness.state().running.is_idle() {
        let editor = harness.state_mut();
        editor.work.jobs.receive(&mut editor.state.running);
        std::thread::yield_now();
    }
    let kept = fs::read_to_string(project.join(UNSAVED)).unwrap();
    assert!(kept.contains("church.facade"), "{kept}");
    drop(harness);

    let mut harness = opened(&project);
    decide(&mut harness, 13);
    drop(harness);
    assert_eq!(
        fs::read_to_string(project.join(UNSAVED)).unwrap(),
        kept,
        "nobody has said what becomes of it"
    );
}

fn pointer(harness: &mut Harness<'_, Editor>, pos: Pos2, pressed: bool) {
    let button = PointerButton::Primary;
    harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    harness.step();
}

#[test]
fn a_stroke_that_has_just_ended_is_kept_when_the_display_goes() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    harness.key_press(Key::F3);
    (0..3).for_each(|_| harness.step());
    harness.key_press(Key::B);
    (0..2).for_each(|_| harness.step());
    let at = harness.get_by_label("Photo view").rect().center();
    harness.hover_at(at);
    harness.step();
    pointer(&mut harness, at, true);
    harness.hover_at(at + [30.0, 0.0].into());
    harness.step();
    pointer(&mut harness, at + [30.0, 0.0].into(), false);
    drop(harness);
    let harness = taken_back(&project);
    assert!(present(harness.state()).masks.find(CHURCH, &MaskOrigin::Drawn).is_some());
}

#[test]
fn a_save_that_fails_while_leaving_says_why_in_the_dialog_and_can_be_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    decide(&mut harness, 14);
    // Nobody can write a file where a folder is.
    let (file, aside) = (project.join("project.json"), project.join("aside.json"));
    fs::rename(&file, &aside).unwrap();
    fs::create_dir(&file).unwrap();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    (0..3).for_each(|_| harness.step());
    press(&mut harness, "Save");
    appears(&mut harness, "project could not be saved");
    assert!(is_there(&harness, "project.json: could not "), "the dialog says which file");
    press(&mut harness, "Stay here");
    assert!(harness.state().is_dirty() && !is_there(&harness, "could not be saved"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    (0..3).for_each(|_| harness.step());
    press(&mut harness, "Save");
    appears(&mut harness, "Leave without saving");
    fs::remove_dir(&file).unwrap();
    fs::rename(&aside, &file).unwrap();
    press(&mut harness, "Try again");
    wait(&mut harness, "leaving", |editor| editor.session.is_none());
    assert_eq!(read_project(&project).unwrap().options.margin, 14);
    assert!(!project.join(UNSAVED).exists());
}

/// Masks so many pixels of the church; the file is named in the project, beside an older one.
fn mask(project: &Path, pixels: u32) -> PathBuf {
    let store = MaskStore::new(project);
    let block = |w: u32| Spans::of_pixels(PixelRect { x: 5, y: 5, w, h: 1 }, |_, _| true);
    store.add(CHURCH, "drawn", &block(pixels - 1), SMALL_SIZE).unwrap();
    let file = store.add(CHURCH, "drawn", &block(pixels), SMALL_SIZE).unwrap();
    change_project(project, |project| {
        let mut project = project?;
        let mask = Mask { from: MaskOrigin::Drawn, file: file.clone(), pixels: u64::from(pixels) };
        project.masks.put(CHURCH, mask);
        Ok(project)
    })
    .unwrap();
    store.path(&file)
}

/// Clicks a link of a note, once the panel of notes is as large as it becomes.
fn click(harness: &mut Harness<'_, Editor>, link: &str) {
    (0..10).for_each(|_| harness.step());
    press(harness, link);
}

fn photos(editor: &Editor) -> usize {
    editor.session.as_ref().map_or(0, |session| session.photos.len())
}

#[test]
fn a_mask_that_is_gone_is_taken_away_or_replaced_by_an_older_one_with_a_click_on_its_note() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let file = mask(&project, 9);
    fs::remove_file(&file).unwrap();
    let mut harness = opened(&project);
    appears(&mut harness, "is left out: its mask, drawn by hand, cannot be used");
    assert_eq!(photos(harness.state()), 2);
    assert!(!is_there(&harness, "quadratura mask"), "no word of the command line");
    click(&mut harness, "Remove this mask");
    wait(&mut harness, "the photo", |editor| photos(editor) == 3 && editor.running.is_idle());
    assert!(!is_there(&harness, "Remove this mask"), "it helps no longer");
    command(&mut harness, "Undo");
    wait(&mut harness, "no photo", |editor| photos(editor) == 2 && editor.running.is_idle());
    appears(&mut harness, "Restore the version of a moment ago");
    click(&mut harness, "Restore the version of a moment ago");
    wait(&mut harness, "the photo", |editor| photos(editor) == 3 && editor.running.is_idle());
    assert_eq!(present(harness.state()).masks.of(CHURCH)[0].pixels, 8);
}

#[test]
fn a_mask_that_is_damaged_within_is_told_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let file = mask(&project, 9);
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let mut harness = opened(&project);
    harness.state_mut().selection.photo = Some(PhotoId(0));
    harness.key_press(Key::F3);
    appears(&mut harness, "cannot be built: its mask, drawn by hand, cannot be used");
    click(&mut harness, "Remove this mask");
    assert!(present(harness.state()).masks.of(CHURCH).is_empty());
    command(&mut harness, "Undo");
    assert!(!present(harness.state()).masks.of(CHURCH).is_empty());
}

#[cfg(unix)]
#[test]
fn an_import_that_brings_a_mask_is_one_step_that_is_undone_and_done_again() {
    use quadratura::testing::document::export_record::ExportFormat;
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    harness.state_mut().settings.image_editor.editor = None;
    // A program that opens nothing: whoever paints is this test.
    harness.state_mut().settings.image_editor.program = "/bin/true".into();
    harness.state_mut().settings.image_editor.format = ExportFormat::Psd;
    harness.state_mut().selection.photo = Some(PhotoId(0));
    harness.state_mut().run(&command::layers::BUILD_PHOTO);
    wait(&mut harness, "the layers", |editor| editor.running.is_idle());
    harness.state_mut().run(&command::paint::EDIT);
    wait(&mut harness, "the export", |editor| editor.running.is_idle());

    let file = project.join("editing/01_church.jpg.psd");
    let mut paper = paper::Paper::read(&file);
    let rect = PixelRect { x: 100, y: 100, w: 50, h: 40 };
    let mut pixels = Raster::blank(50, 40, paper.depth);
    (0..50 * 40).for_each(|at| pixels.set_rgba16(at % 50, at / 50, [65535; 4]));
    paper.sheets.push(paper::Sheet { name: "mask".into(), rect, pixels, visible: true, id: None });
    paper.write(&file);
    let has_mask = |editor: &Editor| present(editor).masks.of(CHURCH).len() == 1;
    wait(&mut harness, "the mask", |editor| has_mask(editor) && editor.running.is_idle());
    let undoes = |editor: &Editor| editor.session.as_ref().unwrap().history.undoes().map(str::to_owned);
    assert_eq!(undoes(harness.state()).as_deref(), Some("import 1"));
    assert!(!harness.state().is_dirty(), "it is in project.json");

    command(&mut harness, "Undo");
    wait(&mut harness, "no mask", |editor| !has_mask(editor) && editor.running.is_idle());
    assert!(read_project(&project).unwrap().masks.is_empty());
    assert_eq!(undoes(harness.state()), None);
    command(&mut harness, "Redo");
    wait(&mut harness, "the mask again", |editor| has_mask(editor) && editor.running.is_idle());
    assert_eq!(read_project(&project).unwrap().masks, present(harness.state()).masks);
    assert!(!harness.state().is_dirty());
    assert_eq!(undoes(harness.state()).as_deref(), Some("import 1"));

    // What is decided meanwhile is saved beside the mask that is there.
    decide(&mut harness, 15);
    harness.state_mut().end_gesture();
    harness.state_mut().apply(ProjectRequest::Save);
    assert!(!harness.state().is_dirty());
    let saved = read_project(&project).unwrap();
    assert_eq!((saved.options.margin, saved.masks.of(CHURCH).len()), (15, 1));
}

/// The model is exported again, a little otherwise, as it is written by another program.
fn change_model(folder: &Path) {
    let file = folder.join("site/piazza.obj");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}\n# exported again\n")).unwrap();
}

#[test]
fn a_model_that_changes_on_disk_is_told_and_read_by_a_click() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    let model = |editor: &Editor| editor.session.as_ref().unwrap().opened.whole.clone();
    let before = model(harness.state());
    change_model(folder.path());
    appears(&mut harness, "Files have changed on disk: the model.");
    harness.state_mut().settings.notes_shown = true;
    click(&mut harness, "Reload from disk");
    wait(&mut harness, "the model", |editor| {
        editor.running.is_idle() && !std::sync::Arc::ptr_eq(&before, &model(editor))
    });
    let message = harness
        .state()
        .notes
        .list()
        .iter()
        .filter(|note| note.text.to_string().starts_with("Files have changed on disk"))
        .count();
    assert_eq!(message, 1, "once");
}

#[test]
fn layers_are_built_of_the_model_as_it_is_on_disk() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    harness.state_mut().run(&command::layers::BUILD);
    wait(&mut harness, "the layers", |editor| editor.running.is_idle());
    // A roof is lifted, and nobody waits until that is noticed.
    let file = folder.path().join("site/piazza.obj");
    let text = fs::read_to_string(&file).unwrap();
    let at = text.lines().position(|line| line.starts_with("v ")).unwrap();
    let lifted: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(place, line)| match place == at {
            true => line
                .split(' ')
                .map(|word| word.parse::<f64>().map_or(word.into(), |x| (x + 0.01).to_string()))
                .collect::<Vec<_>>()
                .join(" "),
            false => line.to_owned(),
        })
        .collect();
    fs::write(&file, lifted.join("\n")).unwrap();
    harness.state_mut().run(&command::layers::BUILD);
    let built = |editor: &Editor| {
        let notes =
            editor.notes.list().iter().filter(|note| note.text.to_string().starts_with("Layers built"));
        notes.count() == 2 && editor.running.is_idle()
    };
    wait(&mut harness, "the layers again", built);
    let message = &harness.state().notes.list();
    assert!(
        message.iter().any(|note| note.text.to_string().contains("They are reloaded before the build.")),
        "{message:?}"
    );
    let last = message.iter().rfind(|note| note.text.to_string().starts_with("Layers built")).unwrap();
    assert!(last.text.to_string().contains("0 were up to date"), "{}", last.text);
}

#[test]
fn objects_whose_switching_was_stopped_are_told_and_switched_when_the_files_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path());
    let mut harness = opened(&project);
    let has = |editor: &Editor| {
        let model = &editor.session.as_ref().unwrap().opened.site.model;
        model.objects.iter().any(|object| object.name == "church.facade")
    };
    let stopped = |harness: &Harness<'_, Editor>| is_there(harness, "The site was not reloaded (stopped)");
    // It may be done before it hears that it is to stop.
    for _ in 0..50 {
        harness.state_mut().switch_object("church.facade", false);
        wait(&mut harness, "the switching", |editor| {
            editor.running.all().any(|(_, job)| job.name == "Switching objects") || !has(editor)
        });
        harness.state_mut().apply(JobRequest::StopAll);
        wait(&mut harness, "the end", |editor| editor.running.is_idle());
        if stopped(&harness) {
            break;
        }
        harness.state_mut().switch_object("church.facade", true);
        wait(&mut harness, "the way back", |editor| has(editor) && editor.running.is_idle());
    }
    if !stopped(&harness) {
        return;
    }
    assert!(has(harness.state()), "the model is as it was");
    click(&mut harness, "Reload from disk");
    wait(&mut harness, "the model", |editor| editor.running.is_idle() && !has(editor));
}
