//! Masks in the editor's window: strokes of the mouse on the photo, what is suggested and accepted by a click, an
//! object's pixels, and a photo's own options; each a step that is undone, done again and saved.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use crate::common;
use crate::harness::{copy_of_piazza, is_there, project_of, wait, window};
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::Rgb;
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::selection::Selection;
use quadratura::testing::document::masks::MaskOrigin;
use quadratura::testing::geometry::{PixelRect, Spans};
use quadratura::testing::io::mask_file::mask_png;
use quadratura::testing::io::mask_store::MaskStore;
use quadratura::testing::io::project::read_project;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::stacks::masks::suggest::{MaskSuggestion, Suggestions, suggestion_folder};

/// Of the piazza's photos that are drawn on, in pixels.
const SIZE: [f32; 2] = [2160.0, 1440.0];
const CHURCH: &str = "01_church.jpg";

/// A project of the piazza's first photos.
fn project(folder: &Path, photos: usize) -> PathBuf {
    let (site, project) = (folder.join("site"), folder.join("project"));
    copy_of_piazza(&site, photos);
    project_of(&site, &project);
    project
}

/// A window with the first photo of a project in its view.
fn opened(project: &Path) -> Harness<'static, Editor> {
    let mut harness = window(Some(project.to_path_buf()));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.key_press(Key::F3);
    steps(&mut harness, 3);
    wait(&mut harness, "the photo", |editor| editor.running.is_idle());
    harness
}

fn steps(harness: &mut Harness<'_, Editor>, count: usize) {
    (0..count).for_each(|_| harness.step());
}

/// Points per pixel of a photo that fills the view, and where one of its pixels is on the screen.
fn at(harness: &Harness<'_, Editor>, x: f32, y: f32) -> (f32, Pos2) {
    let view = harness.get_by_label("Photo view").rect();
    let room = view.size() - vec2(24.0, 24.0);
    let scale = (room.x / SIZE[0]).min(room.y / SIZE[1]);
    (scale, view.center() + vec2(x - SIZE[0] / 2.0, y - SIZE[1] / 2.0) * scale)
}

fn button(
    harness: &mut Harness<'_, Editor>,
    pos: Pos2,
    button: PointerButton,
    pressed: bool,
    held: Modifiers,
) {
    harness.event(Event::PointerButton { pos, button, pressed, modifiers: held });
    harness.step();
}

/// A drag through places of the photo, in its pixels.
fn draw(harness: &mut Harness<'_, Editor>, places: &[[f32; 2]], held: Modifiers) {
    let on_screen: Vec<Pos2> = places.iter().map(|[x, y]| at(harness, *x, *y).1).collect();
    harness.event(Event::ModifiersChanged(held));
    harness.hover_at(on_screen[0]);
    harness.step();
    button(harness, on_screen[0], PointerButton::Primary, true, held);
    for place in &on_screen {
        harness.hover_at(*place);
        harness.step();
    }
    button(harness, on_screen[on_screen.len() - 1], PointerButton::Primary, false, held);
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.step();
}

/// What is masked of a photo by one maker, as the window has it.
fn masked(editor: &Editor, from: &MaskOrigin) -> Spans {
    let session = editor.session.as_ref().unwrap();
    let masks = &session.history.present().masks;
    let Some(mask) = masks.find(CHURCH, from) else { return Spans::default() };
    MaskStore::new(&session.folder).read(&mask.file, SIZE.map(|side| side as u32)).unwrap()
}

fn drawn(harness: &mut Harness<'_, Editor>) -> Spans {
    wait(harness, "the mask", |editor| editor.masking.is_kept());
    masked(harness.state(), &MaskOrigin::Drawn)
}

fn undoes(editor: &Editor) -> Option<&str> {
    editor.session.as_ref().unwrap().history.undoes()
}

#[test]
fn strokes_on_the_photo_make_masks_that_are_undone_done_again_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), 3);
    let mut harness = opened(&project);

    // By brush: what a disc covers on its way.
    harness.key_press(Key::B);
    steps(&mut harness, 2);
    let radius = harness.state().masking.radius_px([2160, 1440]);
    draw(&mut harness, &[[600.0, 500.0], [800.0, 500.0], [1000.0, 500.0]], Modifiers::NONE);
    let stroke = drawn(&mut harness);
    let exact = PI * radius * radius + 2.0 * radius * 400.0;
    // Places of the screen are known to half of its pixels, which are several of the photo.
    let px = f64::from(0.5 / at(&harness, 0.0, 0.0).0);
    let unsure = 2.0 * px * (2.0 * radius) + 40.0;
    assert!((stroke.count() as f64 - exact).abs() < unsure, "{} {exact}", stroke.count());
    assert!(stroke.holds(800, 500) && !stroke.holds(800, 500 + radius as i32 + 4 + px as i32));
    assert_eq!(undoes(harness.state()), Some("mask of 01_church.jpg by brush"));

    // By lasso, and a part of it uncovered with a key held: a step each.
    harness.key_press(Key::L);
    steps(&mut harness, 2);
    draw(&mut harness, &[[300.0, 900.0], [700.0, 900.0], [700.0, 1200.0], [300.0, 1200.0]], Modifiers::NONE);
    let both = drawn(&mut harness);
    let lasso = both.minus(&stroke).count() as f64;
    assert!((lasso - 400.0 * 300.0).abs() < 2.0 * px * 700.0, "{lasso}");
    draw(
        &mut harness,
        &[[500.0, 800.0], [900.0, 800.0], [900.0, 1300.0], [500.0, 1300.0]],
        Modifiers::COMMAND,
    );
    let left = drawn(&mut harness);
    assert!(left.holds(400, 1000) && !left.holds(600, 1000) && left.minus(&both).is_empty());
    assert_eq!(undoes(harness.state()), Some("mask erasure in 01_church.jpg by lasso"));

    // Back and forth, a step a stroke.
    for expected in [&both, &stroke, &Spans::default()] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        steps(&mut harness, 2);
        assert_eq!(masked(harness.state(), &MaskOrigin::Drawn).count(), expected.count());
    }
    assert!(!harness.state().is_dirty());
    for expected in [&stroke, &both, &left] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
        steps(&mut harness, 2);
        assert_eq!(masked(harness.state(), &MaskOrigin::Drawn).count(), expected.count());
    }
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    steps(&mut harness, 2);
    let saved = read_project(&project).unwrap().masks;
    assert_eq!(saved.of(CHURCH).iter().map(|mask| mask.pixels).collect::<Vec<_>>(), [left.count()]);
    assert!(!harness.state().is_dirty());
    harness.get_by_label("01_church.jpg, not built, masked");
}

#[test]
fn a_stroke_is_given_up_by_escape_and_the_photo_moves_while_a_tool_is_in_use() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), 3);
    let mut harness = opened(&project);
    harness.key_press(Key::B);
    steps(&mut harness, 2);
    let (start, end) = (at(&harness, 900.0, 600.0).1, at(&harness, 1200.0, 600.0).1);

    // Escape in the middle of a stroke; once more, and the tool is put away.
    harness.hover_at(start);
    harness.step();
    button(&mut harness, start, PointerButton::Primary, true, Modifiers::NONE);
    harness.hover_at(end);
    harness.step();
    harness.key_press(Key::Escape);
    harness.step();
    button(&mut harness, end, PointerButton::Primary, false, Modifiers::NONE);
    steps(&mut harness, 2);
    assert!(drawn(&mut harness).is_empty() && harness.state().masking.tool.is_some());

    // The middle button moves the photo, and so does the left one with Space.
    for space in [false, true] {
        let used = if space { PointerButton::Primary } else { PointerButton::Middle };
        if space {
            harness.key_down(Key::Space);
        }
        harness.hover_at(start);
        harness.step();
        button(&mut harness, start, used, true, Modifiers::NONE);
        harness.hover_at(end);
        steps(&mut harness, 2);
        button(&mut harness, end, used, false, Modifiers::NONE);
        if space {
            harness.key_up(Key::Space);
        }
        steps(&mut harness, 2);
        assert!(drawn(&mut harness).is_empty());
        let selected = harness.state().selection.main;
        assert_eq!(selected, Selection::Nothing, "no click");
    }
    // It lies to the right of where it was, twice: a dab there is far from where it would have been.
    let dab = at(&harness, 1500.0, 600.0).1;
    harness.hover_at(dab);
    harness.step();
    button(&mut harness, dab, PointerButton::Primary, true, Modifiers::NONE);
    button(&mut harness, dab, PointerButton::Primary, false, Modifiers::NONE);
    steps(&mut harness, 2);
    let dab = drawn(&mut harness).bounds();
    assert!((dab.x + dab.w as i32 / 2 - 900).abs() < 20, "{dab:?}");

    harness.key_press(Key::Escape);
    steps(&mut harness, 2);
    assert!(harness.state().masking.tool.is_none());
    draw(&mut harness, &[[900.0, 300.0], [1000.0, 300.0]], Modifiers::NONE);
    assert_eq!(drawn(&mut harness).bounds(), dab, "without a tool nothing is drawn");
}

/// The number of texels that the photo shows of its layers.
fn visible(editor: &Editor) -> u64 {
    let stack = editor.session.as_ref().unwrap().photos[0].stack.clone().unwrap();
    stack.image_layers.iter().map(|layer| layer.texels_visible).sum()
}

#[test]
fn a_masked_photo_is_stale_and_is_built_again_by_the_click_that_is_offered() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), 3);
    let mut harness = opened(&project);
    harness.get_all_by_label("Build layers of this photo").next().unwrap().click();
    let is = |word: &'static str| {
        move |editor: &Editor| {
            editor.session.as_ref().unwrap().photos[0].word == word && editor.running.is_idle()
        }
    };
    wait(&mut harness, "the layers", is("built"));
    let before = visible(harness.state());

    harness.key_press(Key::B);
    steps(&mut harness, 2);
    draw(&mut harness, &[[900.0, 700.0], [1300.0, 700.0]], Modifiers::NONE);
    let stroke = drawn(&mut harness).count();
    wait(&mut harness, "a stale photo", is("stale"));
    steps(&mut harness, 2);
    harness.get_by_label("01_church.jpg, stale, masked");
    harness.get_by_label("This photo’s layers are out of date.");
    harness.get_all_by_label("Build layers of this photo").next().unwrap().click();
    harness.step();
    wait(&mut harness, "the layers without what is masked", is("built"));
    let lost = before - visible(harness.state());
    assert!(lost > stroke / 2 && lost <= 2 * stroke, "{lost} of {stroke} pixels");

    // Undone, the photo is stale again: its layers lack what was masked.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    steps(&mut harness, 2);
    wait(&mut harness, "a stale photo", is("stale"));

    // A photo's own options are one step, and make it stale alone.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    wait(&mut harness, "the mask again", is("built"));
    harness.get_by_label(&format!("{CHURCH}, built, masked")).click();
    steps(&mut harness, 3);
    harness.get_by_label("Layer options: project defaults").click();
    // The options open in the frames after.
    steps(&mut harness, 30);
    harness.get_by_role_and_label(Role::Slider, "Margin").set_value_accesskit(7.0);
    steps(&mut harness, 3);
    let own = |editor: &Editor| {
        let session = editor.session.as_ref().unwrap();
        session.history.present().decisions.of(CHURCH).options.margin
    };
    assert_eq!(own(harness.state()), Some(7));
    assert_eq!(undoes(harness.state()), Some("options of 01_church.jpg"));
    wait(&mut harness, "a stale photo", is("stale"));
    harness.get_by_label("Margin: use project default").click_accesskit();
    steps(&mut harness, 3);
    assert_eq!(own(harness.state()), None);
    wait(&mut harness, "a photo as it was", is("built"));
}

/// The piazza with somebody in a dark coat in the first photo, who stands before the facade.
fn with_a_foreign_layer(folder: &Path) -> PathBuf {
    let (site, project) = (folder.join("site"), folder.join("project"));
    copy_of_piazza(&site, 9);
    let file = site.join("photos").join(CHURCH);
    let mut photo = image::open(&file).unwrap().to_rgb8();
    for (x, y) in (1155..1205).flat_map(|x| (910..1120).map(move |y| (x, y))) {
        photo.put_pixel(x, y, Rgb([40, 60, 110]));
    }
    photo.save(&file).unwrap();
    project_of(&site, &project);
    project
}

/// Keeps findings with these numbers and likelihoods, in the first photo, as an earlier search does.
fn keep_findings(project: &Path, findings: &[(u32, f64)]) {
    let folder = suggestion_folder(project);
    std::fs::create_dir_all(&folder).unwrap();
    let size = SIZE.map(|side| side as u32);
    let one = |&(number, likelihood): &(u32, f64)| {
        let rect = PixelRect { x: 300 * number as i32, y: 400, w: 80, h: 160 };
        let mask = format!("{number}.png");
        let masked = Spans::of_pixels(rect, |_, _| true);
        std::fs::write(folder.join(&mask), mask_png(&masked, size).unwrap()).unwrap();
        let (pixels, share) = (masked.count(), 0.004);
        let (photo, picture) = (CHURCH.to_owned(), format!("{CHURCH}.jpg"));
        MaskSuggestion { number, photo, size, rect, pixels, share, score: 1.0, likelihood, mask, picture }
    };
    let list = findings.iter().map(one).collect();
    let json = serde_json::to_vec(&Suggestions { version: 2, list }).unwrap();
    std::fs::write(folder.join("suggestions.json"), json).unwrap();
}

#[test]
fn what_is_hardly_an_object_is_listed_by_a_switch_of_the_suggestions() {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), 3);
    keep_findings(&project, &[(1, 0.9), (2, 0.2)]);
    let mut harness = opened(&project);
    harness.state_mut().select(Selection::Photo(PhotoId(0)));
    steps(&mut harness, 3);
    wait(&mut harness, "the suggestions", |editor| editor.masking.suggested.count() > 0);
    steps(&mut harness, 3);
    let listed = |harness: &Harness<'_, Editor>| {
        [1, 2].map(|number| harness.query_by_label(&format!("Mask suggestion {number}")).is_some())
    };
    assert_eq!(listed(&harness), [true, false]);
    for both in [true, false] {
        harness.get_by_role_and_label(Role::CheckBox, "Show unlikely ones").click_accesskit();
        steps(&mut harness, 3);
        assert_eq!(listed(&harness), [true, both]);
    }
    // Where nothing else is left, the switch is.
    harness.state_mut().run(&command::mask::DISMISS);
    steps(&mut harness, 3);
    assert_eq!(listed(&harness), [false, false]);
    harness.get_by_role_and_label(Role::CheckBox, "Show unlikely ones").click_accesskit();
    steps(&mut harness, 3);
    assert_eq!(listed(&harness), [false, true]);
}

#[test]
fn what_stands_in_one_photo_alone_is_masked_by_a_click_and_an_object_by_a_button() {
    let folder = tempfile::tempdir().unwrap();
    let project = with_a_foreign_layer(folder.path());
    let mut harness = opened(&project);
    harness.get_all_by_label("Find transient objects").next().unwrap().click();
    harness.step();
    let found = |editor: &Editor| editor.masking.suggested.count() > 0 && editor.running.is_idle();
    wait(&mut harness, "somebody", found);
    let before = harness.state().masking.suggested.count();
    // What came of it is told in the photo that it is in, and in no other.
    steps(&mut harness, 2);
    assert!(is_there(&harness, "found in this photo"));
    harness.state_mut().select(Selection::Photo(PhotoId(1)));
    steps(&mut harness, 3);
    assert!(!is_there(&harness, "found in this photo"));
    harness.state_mut().select(Selection::Photo(PhotoId(0)));
    steps(&mut harness, 3);
    harness.state_mut().selection.main = Selection::Nothing;
    assert!(masked(harness.state(), &MaskOrigin::Suggested).is_empty(), "nothing is masked unasked");

    let (_, coat) = at(&harness, 1180.0, 1010.0);
    harness.hover_at(coat);
    steps(&mut harness, 2);
    harness.get_by_label_contains("only this photo shows it");
    button(&mut harness, coat, PointerButton::Primary, true, Modifiers::NONE);
    button(&mut harness, coat, PointerButton::Primary, false, Modifiers::NONE);
    steps(&mut harness, 2);
    wait(&mut harness, "the mask", |editor| editor.masking.is_kept());
    let mask = masked(harness.state(), &MaskOrigin::Suggested);
    assert!(mask.holds(1180, 1010), "{:?}", mask.bounds());
    assert!(undoes(harness.state()).unwrap().starts_with("mask of 01_church.jpg by suggestion"));

    // Undone, it is suggested again, and the list beside the photo has it for the keyboard.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.state_mut().select(Selection::Photo(PhotoId(0)));
    steps(&mut harness, 4);
    assert!(masked(harness.state(), &MaskOrigin::Suggested).is_empty());
    assert_eq!(harness.state().masking.suggested.count(), before);
    let number = harness.state().open_suggestions()[0];
    harness.get_by_label(&format!("Mask suggestion {number}")).click_accesskit();
    steps(&mut harness, 2);
    wait(&mut harness, "the mask", |editor| editor.masking.is_kept());
    assert!(!masked(harness.state(), &MaskOrigin::Suggested).is_empty());
    steps(&mut harness, 2);
    if harness.state().open_suggestions().is_empty() {
        assert!((command::mask::DISMISS.ready)(harness.state()).is_err());
    } else {
        harness.state_mut().run(&command::mask::DISMISS);
    }
    // The view has listed anew what is neither masked nor dismissed.
    steps(&mut harness, 2);
    assert!(harness.state().open_suggestions().is_empty());
    assert!(!is_there(&harness, "found in this photo"), "nothing is left to be clicked");

    // An object that the model has: its pixels, by a button beside what is known of it.
    let session = harness.state().session.as_ref().unwrap();
    let place = session.model().objects.iter().position(|object| object.name == "church.facade").unwrap();
    let object = quadratura::testing::scene::ObjectId(place as u32);
    harness.state_mut().select(Selection::Object(object));
    steps(&mut harness, 3);
    harness.get_by_label("Mask object in this photo").click_accesskit();
    steps(&mut harness, 2);
    wait(&mut harness, "the mask", |editor| editor.masking.is_kept());
    let session = harness.state().session.as_ref().unwrap();
    let is_object = |from: &MaskOrigin| matches!(from, MaskOrigin::Object(_));
    let masks = session.history.present().masks.of(CHURCH);
    assert!(masks.iter().any(|mask| is_object(&mask.from) && mask.pixels > 1000), "{masks:?}");
}
