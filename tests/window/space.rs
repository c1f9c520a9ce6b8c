//! The 3D view of the window: backs of faces, layers pulled apart, what colours mean, pictures to keep.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use quadratura::task::Task;
use quadratura::testing::app::command::{self, images, view};
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::{DecideRequest, QualityRequest, TreeRequest};
use quadratura::testing::app::selection::Selection;
use quadratura::testing::app::view_pixel::ViewPixel;
use quadratura::testing::document::trees::{PlantSource, TreeSpecies};
use quadratura::testing::gpu::Gpu;
use quadratura::testing::projection::Renders;
use quadratura::testing::scene::PhotoId;
use quadratura::testing::sites::open::open;
use quadratura::testing::view::{DisplayMode, Quality, Shot};
use quadratura::testing::views::colour::ColourEdit;
use quadratura::testing::views::preview::{self, PreviewOptions};
use quadratura::testing::views::render::Appearance;

use crate::common;
use crate::harness::{appears, built_photos, opened, wait};

/// A window with the piazza, of which one photo is built; none where no adapter is.
fn built(folder: &Path) -> Option<(Harness<'static, Editor>, PathBuf)> {
    common::adapter()?;
    let project = built_photos(folder, "piazza", 9, false);
    let mut harness = opened(&project);
    let is_built = |editor: &Editor| editor.space.device.is_some() && editor.running.is_idle();
    wait(&mut harness, "the layers", is_built);
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
    Some((harness, project))
}

#[test]
fn backs_are_left_out_until_somebody_wants_them_and_what_is_drawn_is_what_is_picked() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, _)) = built(folder.path()) else { return };
    assert!(harness.state().space.look.without_backs);
    // From behind what the first photo looks at: seen from there, facades are backs.
    let editor = harness.state_mut();
    let session = editor.session.as_ref().unwrap();
    let (eye, center) = (editor.space.viewpoint.position(), session.scene_frame.center);
    let mut behind = editor.space.viewpoint;
    behind.pivot = center;
    behind.orbit(std::f64::consts::PI, 0.0, session.scene_frame.up);
    assert!(behind.position().distance(eye) > session.scene_frame.radius * 0.1);
    editor.space.show_from(behind, 0.0);
    let ray = (center - behind.position()).normalize();
    let first = |backs: bool| session_hit(harness.state(), behind.position(), ray, backs);
    let (with, without) = (first(true), first(false));
    assert!(
        without.is_none_or(|without| with.unwrap() <= without),
        "what is left out only lets one see farther"
    );

    harness.step();
    // In a window of this size it has no room in the bar.
    harness.get_by_label("More tools: 3D view").click();
    harness.step();
    harness.step();
    harness.get_by_role_and_label(Role::Button, "Back faces").click();
    harness.step();
    harness.step();
    assert!(!harness.state().space.look.without_backs);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::B);
    harness.step();
    harness.step();
    assert!(harness.state().space.look.without_backs);
}

#[test]
fn what_is_seen_around_the_model_follows_a_photos_exposure_in_the_background() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, project)) = built(folder.path()) else { return };
    let file = project.join("cache/surroundings.bin");
    let before = fs::read(&file).unwrap();
    let change = |harness: &mut Harness<'_, Editor>, edit: ColourEdit| {
        harness.state_mut().apply(QualityRequest::Colour { edits: vec![edit], goes_on: false });
    };
    let photo = || "01_church.jpg".to_owned();
    change(&mut harness, ColourEdit::Fix(photo(), [1.0; 3]));
    wait(&mut harness, "other surroundings", |editor| {
        editor.running.is_idle() && fs::read(&file).is_ok_and(|now| now != before)
    });
    change(&mut harness, ColourEdit::Free(photo()));
    wait(&mut harness, "those of before", |editor| {
        editor.running.is_idle() && fs::read(&file).is_ok_and(|now| now == before)
    });
    let told =
        |words: &str| harness.state().notes.list().iter().any(|it| it.text.to_string().contains(words));
    assert!(!told("previous surroundings"), "the 3D view could not show them");
}

fn session_hit(editor: &Editor, eye: glam::DVec3, ray: glam::DVec3, backs: bool) -> Option<f64> {
    editor
        .session
        .as_ref()
        .unwrap()
        .solid
        .first_visible(
            eye,
            ray,
            quadratura::testing::view::hidden::Culling {
                backs,
                ..quadratura::testing::view::hidden::Culling::nothing()
            },
        )
        .map(|hit| hit.t)
}

#[test]
fn layers_are_pulled_apart_named_selected_and_put_together_again() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, _)) = built(folder.path()) else { return };
    let before = harness.state().space.viewpoint;
    harness.key_press(Key::V);
    wait(&mut harness, "the sheets", |editor| {
        editor.scene().is_some_and(|scene| editor.textures.space.layers.are_complete(scene))
    });
    wait(&mut harness, "their places", |editor| {
        let exploded = &editor.space.exploded;
        (exploded.now_apart - exploded.apart).abs() < 1e-3
    });
    harness.get_by_label_contains("spacing");

    // Somewhere in the view is a layer: it is named, and a click selects it.
    let view = harness.get_by_label("3D view").rect();
    let places = (1..8).flat_map(|y| (1..12).map(move |x| (x, y)));
    let at = |(x, y): (u32, u32)| -> Pos2 {
        view.min + [view.width() * x as f32 / 12.0, view.height() * y as f32 / 9.0].into()
    };
    let found = places.map(at).find(|place| {
        harness.hover_at(*place);
        harness.step();
        harness.state().space.exploded.hovered.is_some()
    });
    let place = found.expect("sheets are in the view");
    let layer = harness.state().space.exploded.hovered.unwrap();
    let stack = harness.state().selected_stack().unwrap();
    let name = stack.layer(layer).name.clone();
    harness.drag_at(place);
    harness.drop_at(place);
    wait(&mut harness, "the selection", |editor| {
        editor.selection.main == Selection::Layer { photo: PhotoId(0), layer }
    });
    assert!(!name.is_empty());

    harness.get_by_label("Collapse").click();
    wait(&mut harness, "the way back", |editor| {
        !editor.space.exploded.is_on() && editor.space.viewpoint.position().distance(before.position()) < 1e-6
    });
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
}

#[test]
fn every_understanding_view_says_what_its_colours_mean() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, _)) = built(folder.path()) else { return };
    let message = [
        (&view::WEIGHTS, "01_church.jpg"),
        (&view::COVERAGE, "Photos that cover a point"),
        (&view::DENSITY, "Resolution (texels per pixel)"),
        (&view::CONFIDENCE, "Confidence"),
        (&view::PROVENANCE, "inpainted (patch-based)"),
        (&view::ITEM, "Every face and every tree has a colour of its own."),
    ];
    for (command, words) in message {
        harness.state_mut().run(command);
        // The legend is that of the picture that is shown.
        wait(&mut harness, "its picture", |editor| editor.space.shown_display() == editor.space.look.display);
        harness.step();
        assert!(harness.query_all_by_label(words).next().is_some(), "{}: {words}", command.name);
    }
    harness.state_mut().run(&view::COLOUR);
    wait(&mut harness, "the photos", |editor| editor.space.shown_display() == DisplayMode::Colour);
    harness.step();
    assert!(harness.query_by_label("Hide the legend").is_none(), "photos are what they are");
}

/// A slice of a picture has depths and shortlists of its own: at an edge a pixel may go to the face next to it, and
/// rounding may differ by a step of 8 bits.
fn assert_alike(found: &[u8], expected: &[u8], what: &str) {
    let pairs = found.as_chunks::<4>().0.iter().zip(expected.as_chunks::<4>().0);
    let far = pairs.clone().filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count();
    let all = pairs.count();
    println!("{what}: {far} of {all} pixels differ by more than a step");
    assert!(all > 0 && far * 1000 <= all, "{what}: {far} of {all} pixels differ");
}

#[test]
fn a_picture_made_in_the_window_is_the_one_that_the_command_line_renders() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, project)) = built(folder.path()) else { return };
    let picture = project.join("pictures/view.png");
    for display in [&view::COLOUR, &view::PROVENANCE] {
        harness.state_mut().run(display);
        harness.state_mut().request_still();
        harness.step();
        harness.step();
        harness.get_by_label("Render").click();
        wait(&mut harness, "the picture", |editor| picture.is_file() && editor.running.is_idle());
        let found = image::open(&picture).unwrap().to_rgba8();
        std::fs::remove_file(&picture).unwrap();

        let editor = harness.state();
        let view = editor.space.viewpoint;
        let look = Appearance { quality: Quality::Final, ..editor.space.look.clone() };
        let opened = open(&project, &Task::silent()).unwrap();
        let gpu = Gpu::headless().unwrap();
        let options = PreviewOptions::default();
        let mut own =
            preview::open(&project, &opened.project, &opened.site, &gpu, &options, &Task::silent()).unwrap();
        let shot = look.shot(view.camera(found.width(), found.height()), view.pose);
        let expected = own.picture(&shot, &Task::silent()).unwrap();
        assert_alike(found.as_raw(), &expected.rgba, &format!("{:?}", look.display));
        if look.display == DisplayMode::Provenance {
            // One photo, nothing filled, nothing painted: all of the model is the photo itself. Around it is the dome.
            let [r, g, b] = quadratura::testing::view::legend::Origin::Photo.colour();
            let near = |pixel: &&[u8; 4]| {
                pixel[3] < 255 || pixel.iter().zip([r, g, b]).all(|(a, b)| a.abs_diff(b) <= 2)
            };
            let of_model = Shot { surroundings: false, ..shot };
            let of_model = own.picture(&of_model, &Task::silent()).unwrap();
            assert!(of_model.rgba.as_chunks::<4>().0.iter().all(|pixel| near(&pixel)));
        }
    }
}

#[test]
fn the_view_is_drawn_from_a_layered_depth_image_and_the_photo_is_saved_as_one_and_as_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, project)) = built(folder.path()) else { return };
    let is_of_images = |editor: &Editor| {
        let status = editor.space.images.status.as_ref();
        status.is_some_and(|(status, _)| status.photos == [PhotoId(0)] && status.building.is_empty())
    };
    let of_model = harness.state().space.picture().unwrap().image.clone();
    harness.key_press_modifiers(Modifiers::SHIFT, Key::I);
    wait(&mut harness, "a layered depth image", is_of_images);
    appears(&mut harness, "01_church · depth complexity");
    let of_image = harness.state().space.picture().unwrap().image.clone();
    // Through the photo's own camera both show the photo, but for the resolution: means differ by no more than 3 of 255.
    let mean = |picture: &quadratura::testing::view::Picture, c: usize| {
        let sum: u64 = picture.pixels().iter().map(|pixel| u64::from(pixel[c])).sum();
        sum as f64 / picture.pixels().len() as f64
    };
    for c in 0..3 {
        let (model, image) = (mean(&of_model, c), mean(&of_image, c));
        assert!((model - image).abs() < 3.0, "channel {c}: {model} and {image}");
    }

    // Without the nearest layer, the view is another one.
    harness.get_by_label("depth layers hidden").focus();
    harness.step();
    harness.key_press(Key::ArrowRight);
    harness.step();
    assert_eq!(harness.state().space.images.peeled, 1);
    wait(&mut harness, "the layers behind", |editor| {
        is_of_images(editor) && !std::sync::Arc::ptr_eq(&editor.space.picture().unwrap().image, &of_image)
    });
    harness.state_mut().run(&view::WEIGHTS);
    appears(&mut harness, "they show photos, and no other display mode");
    harness.state_mut().run(&view::COLOUR);
    harness.state_mut().run(&images::SHOW);
    wait(&mut harness, "the model", |editor| editor.space.images.status.is_none());

    for (command, made) in
        [(&images::SAVE, "ldi/01_church.ldi"), (&images::PAGE, "pages/01_church/index.html")]
    {
        harness.state_mut().run(command);
        harness.step();
        harness.step();
        harness.get_by_label("Save").click();
        harness.step();
        harness.step();
        assert!(harness.state().dialogs.save_image.is_none());
        wait(&mut harness, made, |editor| editor.running.is_idle());
        assert!(project.join(made).is_file(), "{:?}", harness.state().notes.list());
    }
}

/// A cross of two leaves, two units high.
const BUSH: &str = "material leaf reflected .1 .4 .1 through .1 .4 0 leaf\n\
    polygon 4  -1 0 0 0 0 0 0 1  1 0 0 0 0 0 1 1  1 0 2 0 0 0 1 0  -1 0 2 0 0 0 0 0\n\
    polygon 4  0 -1 0 0 0 0 0 1  0 1 0 0 0 0 1 1  0 1 2 0 0 0 1 0  0 -1 2 0 0 0 0 0\n";

/// The window with a species of two leaves in its project, and the tool that places trees.
fn with_tool(harness: &mut Harness<'_, Editor>, project: &Path) {
    fs::write(project.join("bush.plant"), BUSH).unwrap();
    let editor = harness.state_mut();
    let mut after = (**editor.session.as_ref().unwrap().history.present()).clone();
    let species = TreeSpecies { from: PlantSource::File("bush.plant".into()), up: None, unit: None };
    after.trees.species.insert("bush".into(), species);
    editor.apply(DecideRequest::Edit("species".into(), Box::new(after), None));
    editor.apply(TreeRequest::Choose("bush".into()));
    editor.run(&command::trees::PLACE);
    let known =
        |editor: &Editor| editor.trees().and_then(|trees| editor.trees.figures_of(trees, "bush")).is_some();
    wait(harness, "the figures", |editor| known(editor) && editor.running.is_idle());
    harness.get_by_label("Species to place");
}

/// Waits until the picture shows the present trees at rest.
fn wait_for_trees(harness: &mut Harness<'_, Editor>) {
    wait(harness, "the trees", |editor| editor.space.shows_present() && editor.trees.sent.is_some());
}

/// Waits for a place in the view where something is found, also a hundredth of the view to each side: what is on an edge in one picture
/// may not be in the next, and on a busy machine the picture may still be the one before.
fn place_of(harness: &mut Harness<'_, Editor>, found: impl Fn(&Editor, &ViewPixel) -> bool) -> Pos2 {
    let place = |editor: &Editor| {
        let size_px = editor.space.size_px();
        let is_found = |[x, y]: [i32; 2]| {
            let [x, y] = [f64::from(x) / 100.0, f64::from(y) / 100.0];
            let at_px = glam::DVec2::new(x * f64::from(size_px[0]), y * f64::from(size_px[1]));
            found(editor, &ViewPixel { viewpoint: editor.space.viewpoint, size_px, at_px })
        };
        let is_inside = |[x, y]: &[i32; 2]| (-1..=1).all(|dy| (-1..=1).all(|dx| is_found([x + dx, y + dy])));
        (10..90).rev().flat_map(|y| (10..90).map(move |x| [x, y])).find(is_inside)
    };
    let at = Cell::new(None);
    wait(harness, "such a place in the view", |editor| {
        at.set(place(editor));
        at.get().is_some()
    });
    let [x, y] = at.get().expect("it was waited for").map(|share| share as f32 / 100.0);
    let view = harness.get_by_label("3D view").rect();
    view.min + view.size() * eframe::egui::vec2(x, y)
}

#[test]
fn a_tree_is_placed_dragged_picked_hidden_and_removed_in_the_view_and_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let Some((mut harness, project)) = built(folder.path()) else { return };
    with_tool(&mut harness, &project);
    wait_for_trees(&mut harness);
    let last = |harness: &Harness<'_, Editor>| {
        harness.state().session.as_ref().unwrap().history.undoes().map(str::to_owned)
    };
    let placing = Some("placing of bush_1".to_owned());
    let ground = place_of(&mut harness, |editor, pixel| {
        editor.scene().and_then(|scene| scene.ground_at(pixel)).is_some()
    });
    harness.drag_at(ground);
    harness.step();
    assert_eq!(harness.state().selected_tree().unwrap().name, "bush_1");
    let foot = harness.state().selected_tree().unwrap().at;
    harness.hover_at(ground - eframe::egui::vec2(0.0, 30.0));
    harness.step();
    harness.drop_at(ground - eframe::egui::vec2(0.0, 30.0));
    harness.step();
    assert_ne!(harness.state().selected_tree().unwrap().at, foot, "the tree follows the pointer");
    assert_eq!(last(&harness), placing, "placing and dragging are one gesture");
    harness.key_press(Key::Escape);
    harness.step();
    harness.step();
    assert!(!harness.state().trees.hand.on);

    // It is picked by what is drawn, and named in the list.
    wait_for_trees(&mut harness);
    harness.state_mut().select(Selection::Nothing);
    let on_tree = place_of(&mut harness, |editor, pixel| {
        editor.scene().and_then(|scene| scene.tree_at(pixel)).is_some()
    });
    harness.drag_at(on_tree);
    harness.drop_at(on_tree);
    wait(&mut harness, "the selection", |editor| editor.selected_tree().is_some());
    harness.step();
    harness.get_by_role_and_label(Role::TreeItem, "bush_1");
    harness.get_by_role_and_label(Role::TreeItem, "Trees (1)");
    harness.get_by_label("Foot x");
    harness.get_by_label_contains("Polygons");

    // It is planned, so that it casts a shadow; the box takes that away and back, one step of the history each.
    let casts = |harness: &Harness<'_, Editor>| harness.state().selected_tree().unwrap().casts;
    assert!(casts(&harness));
    for expected in [false, true] {
        harness.get_by_label("Casts a shadow").click();
        harness.step();
        harness.step();
        assert_eq!((casts(&harness), last(&harness)), (expected, Some("shadow of bush_1".to_owned())));
    }
    for expected in [false, true] {
        harness.state_mut().run(&command::edit::UNDO);
        harness.step();
        assert_eq!(casts(&harness), expected);
    }
    assert_eq!(last(&harness), placing);

    // Its eye hides it, and nothing of the project changes.
    harness.get_by_label("Show bush_1").click();
    harness.step();
    harness.step();
    wait_for_trees(&mut harness);
    assert_eq!(last(&harness), placing);
    let view = harness.get_by_label("3D view").rect();
    let at = (on_tree - view.min) / view.size();
    let number = |editor: &Editor| {
        let size_px = editor.space.size_px();
        let at_px = glam::DVec2::new(
            f64::from(at.x) * f64::from(size_px[0]),
            f64::from(at.y) * f64::from(size_px[1]),
        );
        editor.scene()?.tree_at(&ViewPixel { viewpoint: editor.space.viewpoint, size_px, at_px })
    };
    // On a busy machine, the trees that are sent may still be those before.
    wait(&mut harness, "that the tree is hidden", |editor| number(editor).is_none());
    harness.get_by_label("Show bush_1").click();
    harness.step();
    harness.step();
    wait_for_trees(&mut harness);
    wait(&mut harness, "the tree that is shown again", |editor| number(editor).is_some());
    harness.state_mut().run(&command::trees::REMOVE);
    wait_for_trees(&mut harness);
    harness.step();
    assert!(harness.query_by_label("bush_1").is_none() && harness.state().selected_tree().is_none());
    harness.state_mut().run(&command::edit::UNDO);
    harness.step();
    harness.step();
    harness.get_by_role_and_label(Role::TreeItem, "bush_1");

    // The page of all trees: whether they are as photos show them is a step of the history.
    harness.get_by_role_and_label(Role::TreeItem, "Trees (1)").click();
    harness.step();
    harness.step();
    let before = last(&harness);
    let matched = |harness: &Harness<'_, Editor>| {
        !harness.state().session.as_ref().unwrap().history.present().trees.light.without_photos
    };
    assert!(matched(&harness));
    for expected in [false, true] {
        // The page is longer than the window, so that a pointer would have to scroll first.
        harness.get_by_label("Match photos").click_accesskit();
        harness.step();
        harness.step();
        assert_eq!((matched(&harness), last(&harness)), (expected, Some("light on trees".to_owned())));
    }
    for expected in [false, true] {
        harness.state_mut().run(&command::edit::UNDO);
        harness.step();
        assert_eq!(matched(&harness), expected);
    }
    assert_eq!(last(&harness), before);
}
