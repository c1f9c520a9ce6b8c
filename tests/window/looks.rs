//! How the window looks, against pictures that were looked at and found good; and what it is to those who hear it.
//!
//! Where the look has changed on purpose: `UPDATE_SNAPSHOTS=1 cargo test --release --test window looks::` makes the pictures in
//! tests/snapshots anew, at half the window's size; look at them before they are kept.

use crate::common;
use crate::harness;
use crate::harness::{command, press, project_of, site_of_piazza, wait};
use eframe::egui::Ui;
use eframe::egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{
    Harness, SnapshotError, SnapshotOptions, image_snapshot_options, try_image_snapshot_options,
};
use image::{Rgba, RgbaImage};
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::settings::Colours;

/// The pixels of a halved picture that may differ, beyond those that the comparison takes for anti-aliasing. With the
/// arithmetic of a processor without SSE, the setting that differs most (docs/quality.md), 22 pixels of the photo view
/// differ, in its smallest letters; with the usual arithmetic none. A word of six letters changes 40 pixels, and a button
/// that moves by 4 points 30: the test below measures these. A single letter (3) or a button that moves by 1 point (6)
/// is not noticed.
const PIXELS_THAT_MAY_DIFFER: usize = 25;

fn compare(harness: &mut Harness<'_, Editor>, name: &str) {
    let options = SnapshotOptions::new().max_failed_pixels(PIXELS_THAT_MAY_DIFFER);
    let window = harness.render().expect("there is an adapter");
    image_snapshot_options(&halved(&window), name, &options);
}

/// The picture at half its size along each side, each pixel the rounded mean of four: so the window is compared and so
/// it is kept. A widget that has gone or moved still shows, and the files take a quarter of the bytes.
fn halved(picture: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(picture.width() / 2, picture.height() / 2, |x, y| {
        let four =
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| picture.get_pixel(2 * x + dx, 2 * y + dy).0);
        Rgba(
            [0, 1, 2, 3].map(|c| ((four.iter().map(|pixel| u32::from(pixel[c])).sum::<u32>() + 2) / 4) as u8),
        )
    })
}

fn in_colours(harness: &mut Harness<'_, Editor>, colours: Colours) {
    harness.state_mut().settings.colours = colours;
    (0..3).for_each(|_| harness.step());
}

/// What can be clicked, moved or written in, and has no name.
fn nameless(harness: &Harness<'_, Editor>) -> Vec<String> {
    let with_names = [
        Role::Button,
        Role::CheckBox,
        Role::RadioButton,
        Role::ComboBox,
        Role::Slider,
        Role::SpinButton,
        Role::TextInput,
        Role::MultilineTextInput,
        Role::Tab,
        Role::TreeItem,
    ];
    let root = harness.root();
    let nodes = root.children_recursive().map(|node| node.accesskit_node());
    let wanting = nodes.filter(|node| with_names.contains(&node.role()) && !node.is_hidden());
    let wanting = wanting.filter(|node| node.label().is_none_or(|label| label.trim().is_empty()));
    wanting.map(|node| format!("{:?} {:?} at {:?}", node.role(), node.value(), node.raw_bounds())).collect()
}

/// Clicks a tab of the right side; menus and switches may have the same name.
fn to_side(harness: &mut Harness<'_, Editor>, name: &str) {
    let named = harness.query_all_by_label(name);
    let rightmost = named.max_by(|a, b| a.rect().left().total_cmp(&b.rect().left()));
    rightmost.unwrap().click();
    (0..3).for_each(|_| harness.step());
}

/// A piece of a panel: three lines of text and two buttons, the second of which stands `right` points further right.
fn piece(word: &str, right: f32) -> RgbaImage {
    let contents = |ui: &mut Ui| {
        ui.label("Image layers");
        ui.label(word);
        ui.label("36 at 17 depths");
        ui.horizontal(|ui| {
            let _ = ui.button("Fit");
            ui.add_space(right);
            let _ = ui.button("1:1");
        });
    };
    let mut harness = Harness::builder().with_size([240.0, 120.0]).build_ui(contents);
    harness.run();
    halved(&harness.render().expect("there is an adapter"))
}

/// The number of pixels that differ by the measure of [`compare`].
fn differing(kept: &RgbaImage, new: &RgbaImage) -> i32 {
    let folder = tempfile::tempdir().unwrap();
    kept.save(folder.path().join("piece.png")).unwrap();
    let options = SnapshotOptions::new().output_path(folder.path());
    match try_image_snapshot_options(new, "piece", &options) {
        Ok(()) => 0,
        Err(SnapshotError::Diff { diff, .. }) => diff,
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_changed_word_and_a_moved_button_differ_by_more_pixels_than_may() {
    if common::adapter().is_none() {
        return;
    }
    let kept = piece("photos", 0.0);
    assert_eq!(differing(&kept, &piece("photos", 0.0)), 0);
    // Snapshots that are made anew are never different.
    let compares = std::env::var_os("UPDATE_SNAPSHOTS").is_none();
    for (word, right) in [("layers", 0.0), ("photos", 4.0)] {
        let count = differing(&kept, &piece(word, right));
        assert!(
            !compares || count > PIXELS_THAT_MAY_DIFFER as i32,
            "{word:?}, {right} points: {count} pixels"
        );
    }
}

#[test]
fn the_first_window_in_dark_and_in_light() {
    // Letters and widgets are drawn by the adapter: without one nothing can be compared.
    if common::adapter().is_none() {
        return;
    }
    let mut harness = harness::window(None);
    in_colours(&mut harness, Colours::Dark);
    compare(&mut harness, "first_dark");
    in_colours(&mut harness, Colours::Light);
    compare(&mut harness, "first_light");
}

#[test]
fn a_photo_with_two_layers_taken_off_looks_as_it_should_and_all_panels_have_names() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("piazza");
    project_of(&site_of_piazza(), &project);
    let mut harness = harness::window(Some(project));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    press(&mut harness, "Build layers");
    wait(&mut harness, "the layers", |editor| {
        let session = editor.session.as_ref().unwrap();
        let built = session.photos.iter().all(|photo| photo.is_current());
        built && editor.space.device.is_some() && editor.running.is_idle()
    });
    assert_eq!(nameless(&harness), Vec::<String>::new(), "the 3D view");
    for side in ["Fill", "Colour", "Paint", "Selection"] {
        to_side(&mut harness, side);
        wait(&mut harness, "the panel", |editor| editor.running.is_idle());
        assert_eq!(nameless(&harness), Vec::<String>::new(), "{side}");
    }
    for name in ["Bookmarks and flight", "Exploded view", "Exploded view"] {
        command(&mut harness, name);
        wait(&mut harness, name, |editor| editor.running.is_idle());
        assert_eq!(nameless(&harness), Vec::<String>::new(), "{name}");
    }
    command(&mut harness, "Bookmarks and flight");

    harness.get_by_label_contains("02_from_southwest.jpg, ").click();
    harness.step();
    command(&mut harness, "Show photo");
    for _ in 0..2 {
        command(&mut harness, "Hide nearest layer");
    }
    // Nobody's adapter is anybody else's.
    harness.state_mut().space.device = Some("the adapter".into());
    wait(&mut harness, "the photo", |editor| editor.running.is_idle());
    (0..3).for_each(|_| harness.step());
    assert_eq!(nameless(&harness), Vec::<String>::new(), "the photo view");
    compare(&mut harness, "photo");
}
