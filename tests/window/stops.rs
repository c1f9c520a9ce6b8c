//! What the views show while layers are built, updated, painted on, and steps are undone and done again, in any order and at any
//! time: never a surface without its texture, and nobody is told that something is damaged.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::common;
use crate::harness::{built_photos, opened, wait};
use crate::paper;
use crate::up_to_date::is_up_to_date;
use egui_kittest::Harness;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::SpaceRequest;
use quadratura::testing::document::Project;
use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::scene::synthetic::Rng;

/// The rounds of a usual run; `QUADRATURA_ROUNDS` sets another number.
const ROUNDS: u64 = 1;
/// The actions of a round.
const ACTIONS: usize = 7;
/// The longest time after an action, in milliseconds: shorter than building a photo takes, and longer than an edit rests.
const LONGEST_MS: f64 = 700.0;
/// What no message may say: these are about files that are gone or damaged.
const NEVER_SAID: [&str; 7] = [
    "is not used",
    "could not be read",
    "cannot be read",
    "does not exist",
    "damaged",
    "was replaced while",
    "shows the previous",
];
/// The share of a picture that may be grey in a photo's own camera, beyond what it is in a view that was made anew.
const GREY_SHARE: f64 = 0.001;

#[test]
fn views_have_all_their_textures_whatever_is_built_painted_and_undone_meanwhile() {
    if common::adapter().is_none() {
        return;
    }
    let rounds = std::env::var("QUADRATURA_ROUNDS").ok().and_then(|rounds| rounds.parse().ok());
    for seed in 0..rounds.unwrap_or(ROUNDS) {
        let folder = tempfile::tempdir().unwrap();
        let project = built_photos(folder.path(), "project", 2, true);
        let mut window = opened(&project);
        let editor = window.state_mut();
        editor.settings.image_editor.editor = None;
        // A program that opens nothing: whoever paints is this test.
        editor.settings.image_editor.program = "/bin/true".into();
        editor.settings.image_editor.format = ExportFormat::Psd;
        editor.selection.photo = Some(PhotoId(0));
        editor.run(&command::paint::EDIT);
        wait(&mut window, "the export", |editor| editor.running.is_idle());
        window.state_mut().settings.keep_up_to_date = true;
        let file = project.join("editing/01_church.jpg.psd");
        let mut rng = Rng::new(seed);
        let mut said = Vec::new();
        for _ in 0..ACTIONS {
            said.push(act(&mut window, &file, &mut rng));
            pass(&mut window, rng.between(0.0, LONGEST_MS));
            assert_untroubled(&window, seed, &said);
        }
        window.state_mut().settings.keep_up_to_date = true;
        wait(&mut window, "the last update", is_up_to_date);
        let grey = grey_in_picture(&mut window);
        assert_untroubled(&window, seed, &said);
        window.state_mut().run(&command::view::RESTART);
        let anew = grey_in_picture(&mut window);
        assert!(
            grey <= anew + GREY_SHARE,
            "seed {seed}: {grey} of the picture is grey, anew {anew}: {said:?}"
        );
    }
}

/// Does something of what users do; returns what it was.
fn act(window: &mut Harness<'_, Editor>, file: &Path, rng: &mut Rng) -> &'static str {
    match rng.whole(0, 9) {
        0 | 1 => {
            widen(window.state_mut(), rng.whole(4, 9));
            "edit"
        }
        2 => {
            window.state_mut().run(&command::layers::BUILD);
            "build"
        }
        3 | 4 => {
            paint(file, rng);
            "paint"
        }
        5 | 6 => {
            window.state_mut().run(&command::edit::UNDO);
            "undo"
        }
        7 => {
            window.state_mut().run(&command::edit::REDO);
            "redo"
        }
        8 => {
            let keep = &mut window.state_mut().settings.keep_up_to_date;
            *keep = !*keep;
            "pause or resume"
        }
        _ => {
            let photo = PhotoId(rng.whole(0, 1));
            window.state_mut().apply(SpaceRequest::FlyToPhoto(photo));
            "fly"
        }
    }
}

/// Makes the layers of all photos out of date.
fn widen(editor: &mut Editor, margin: u32) {
    let mut project = Project::clone(editor.session.as_ref().unwrap().history.present());
    project.options.margin = margin;
    editor.edit("margin", project, None);
}

/// Paints a square on what the photo shows, and saves.
fn paint(file: &Path, rng: &mut Rng) {
    let mut paper = paper::Paper::read(file);
    let sheet = paper.image_layers().max_by_key(|sheet| sheet.pixels_where(true).len()).unwrap();
    let shown = sheet.pixels_where(true);
    let (x0, y0) = shown[rng.whole(0, shown.len() as u32 - 1) as usize];
    let colour = [257 * rng.whole(0, 255) as u16, 0, 65535, 65535];
    let square = shown.iter().filter(|(x, y)| (x0..x0 + 20).contains(x) && (y0..y0 + 20).contains(y));
    square.for_each(|(x, y)| sheet.paint(*x, *y, colour));
    paper.write(file);
}

/// Lets frames go by for some time.
fn pass(window: &mut Harness<'_, Editor>, milliseconds: f64) {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs_f64(milliseconds / 1000.0) {
        window.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn assert_untroubled(window: &Harness<'_, Editor>, seed: u64, said: &[&str]) {
    for note in window.state().notes.list() {
        let text = note.text.to_string();
        assert!(!NEVER_SAID.iter().any(|never| text.contains(never)), "seed {seed}, after {said:?}: {text}");
    }
}

/// The share of the view that is grey, in the first photo's own camera, once nothing changes there any more.
fn grey_in_picture(window: &mut Harness<'_, Editor>) -> f64 {
    window.state_mut().apply(SpaceRequest::FlyToPhoto(PhotoId(0)));
    let is_settled = |editor: &Editor| {
        let painter = editor.work.painter.as_ref();
        editor.running.is_idle()
            && editor.space.has_picture()
            && editor.space.shows_present()
            && painter.is_some_and(|painter| painter.is_settled() && !painter.is_busy())
    };
    // The picture at rest comes a moment after the flight has ended.
    for _ in 0..2 {
        wait(window, "the picture", is_settled);
        pass(window, LONGEST_MS);
    }
    wait(window, "the picture at rest", is_settled);
    let picture = window.state().space.picture().unwrap().image.clone();
    let pixels = picture.rgba.as_chunks::<4>().0;
    let grey = pixels.iter().filter(|[r, g, b, _]| r == g && g == b && (80..=170).contains(r));
    grey.count() as f64 / pixels.len() as f64
}
