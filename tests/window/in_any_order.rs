//! Build, update, strokes, undo and redo in any order and at any time: nothing that the views show is lost, and no message
//! says that something is damaged.
//!
//! `QUADRATURA_ROUNDS` sets the number of sequences, each with delays of its own.

use std::time::{Duration, Instant};

use egui_kittest::Harness;
use glam::DVec2;
use quadratura::testing::app::ask::BuildAsk;
use quadratura::testing::app::command::{self, Command};
use quadratura::testing::app::editor::Editor;
use quadratura::testing::document::{PhotoDecisions, Project};
use quadratura::testing::projection::Picture;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::scene::synthetic::Rng;

use crate::common;
use crate::harness::{built_photos, opened, wait};

/// The number of actions of a sequence.
const ACTIONS: u32 = 7;
/// The longest time between two of them, in milliseconds.
const LONGEST_MS: f64 = 900.0;

#[test]
fn what_is_built_painted_and_undone_in_any_order_stays_readable() {
    if common::adapter().is_none() {
        return;
    }
    let rounds = std::env::var("QUADRATURA_ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(2);
    let folder = tempfile::tempdir().unwrap();
    let project = built_photos(folder.path(), "project", 2, true);
    let mut harness = opened(&project);
    harness.state_mut().run(&command::layers::KEEP_UP);
    harness.state_mut().fly_to_photo(PhotoId(0));
    wait(&mut harness, "the photo's view", |editor| editor.space.through() == Some(PhotoId(0)));
    for seed in 0..rounds {
        let mut rng = Rng::new(seed);
        for action in 0..ACTIONS {
            act(&mut harness, &mut rng);
            pass(&mut harness, rng.between(0.0, LONGEST_MS));
            said_nothing_wrong(&harness, seed, action);
        }
        wait(&mut harness, "everything", is_settled);
        said_nothing_wrong(&harness, seed, ACTIONS);
    }
    let shown = picture(&mut harness);
    harness.state_mut().apply(BuildAsk::RestartPainter);
    wait(&mut harness, "a new painter", |editor| editor.device.is_some() && is_settled(editor));
    let anew = picture(&mut harness);
    assert_eq!((shown.width, shown.height), (anew.width, anew.height));
    let other = shown.rgba.iter().zip(&anew.rgba).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(100 * other < shown.rgba.len(), "{other} of {} samples differ", shown.rgba.len());
}

/// One thing that a user may do at any time.
fn act(harness: &mut Harness<'_, Editor>, rng: &mut Rng) {
    match rng.whole(0, 9) {
        0 | 1 => decide_margin(harness.state_mut(), 2 + rng.whole(0, 3)),
        2 => run(harness, &command::layers::BUILD),
        3..=5 => stroke(harness.state_mut(), rng),
        6 | 7 => run(harness, &command::edit::UNDO),
        8 => run(harness, &command::edit::REDO),
        _ => run(harness, &command::file::READ_AGAIN),
    }
}

fn run(harness: &mut Harness<'_, Editor>, command: &'static Command) {
    if (command.ready)(harness.state()).is_ok() {
        harness.state_mut().run(command);
    }
}

fn decide_margin(editor: &mut Editor, margin: u32) {
    let Some(session) = &editor.session else { return };
    let mut project = Project::clone(session.history.present());
    let mut decided = PhotoDecisions::default();
    decided.options.margin = Some(margin);
    project.decisions.set("01_church.jpg", decided);
    editor.edit("margin", project, None);
}

/// A stroke of the brush across the middle of the view.
fn stroke(editor: &mut Editor, rng: &mut Rng) {
    let (view, size_px) = (editor.space.viewpoint, editor.space.size_px());
    let [width, height] = size_px.map(f64::from);
    let mut at = || DVec2::new(rng.between(0.3, 0.7) * width, rng.between(0.4, 0.7) * height);
    let (from, to) = (at(), at());
    let brush = &mut editor.space.brush;
    brush.brush.colour = [rng.whole(0, 255) as u8, 40, 200];
    assert!(brush.begin((&view, size_px), from, 1.0));
    brush.go_to(to, 1.0);
    brush.end();
}

/// Lets frames go by for some time.
fn pass(harness: &mut Harness<'_, Editor>, milliseconds: f64) {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs_f64(milliseconds / 1000.0) {
        harness.step();
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Nothing runs or waits, all layers are up to date, and the view shows them.
fn is_settled(editor: &Editor) -> bool {
    let Some(session) = &editor.session else { return false };
    let is_current = session.photos.iter().all(|photo| photo.is_current());
    let waits = !editor.space.brush.waiting.is_empty() || editor.history_target.is_some();
    let waits = waits || session.pending.invalidation.is_some() || session.pending.reload;
    let updates = editor.updating.is_wanted();
    editor.running.is_idle() && is_current && !waits && !updates && editor.space.shows_present()
}

fn picture(harness: &mut Harness<'_, Editor>) -> Picture {
    wait(harness, "a picture at rest", |editor| {
        is_settled(editor) && !editor.space.is_behind(editor.window.now_s)
    });
    Picture::clone(&harness.state().space.picture().expect("it was waited for").image)
}

/// No message says that something cannot be read.
fn said_nothing_wrong(harness: &Harness<'_, Editor>, seed: u64, action: u32) {
    let wrong = ["is not used", "does not exist", "damaged", "is missing", "from a copy", "the previous"];
    for note in harness.state().notes.list() {
        let text = note.text.to_string();
        let found = wrong.iter().find(|words| text.contains(**words));
        assert!(found.is_none(), "seed {seed}, after action {action}: {text}");
    }
}
