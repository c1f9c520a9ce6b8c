//! The window in small sizes, and what its parts say: nothing that one needs is cut, and words agree.

use std::path::Path;

use crate::common;
use crate::harness;
use crate::harness::{built_photos, command, is_there, opened, press, wait};
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::request::QualityRequest;
use quadratura::testing::app::selection::Selection;
use quadratura::testing::app::settings::Colours;
use quadratura::testing::layers::LayerIndex;
use quadratura::testing::scene::PhotoId;

/// What a window of 1024 x 700 pixels has at one and a half times the size, in points: the smallest that is spoken of.
const SMALL: [f32; 2] = [683.0, 467.0];
/// The same at the usual size.
const MIDDLE: [f32; 2] = [1024.0, 700.0];
/// Of two photos: enough to compare, and soon built.
const PHOTOS: usize = 2;
/// Edges of neighbours are drawn over each other by so many points.
const OVERLAP: f32 = 1.5;

fn steps(harness: &mut Harness<'_, Editor>) {
    (0..4).for_each(|_| harness.step());
}

/// A window with some photos of the piazza, built; none where no adapter is.
fn built(folder: &Path) -> Option<Harness<'static, Editor>> {
    common::adapter()?;
    let mut harness = opened(&built_photos(folder, "piazza", PHOTOS, true));
    wait(&mut harness, "the layers", |editor| {
        let session = editor.session.as_ref().unwrap();
        session.photos.iter().all(|photo| photo.is_current())
            && editor.space.device.is_some()
            && editor.running.is_idle()
    });
    wait(&mut harness, "a picture", |editor| editor.space.has_picture());
    Some(harness)
}

fn resize(harness: &mut Harness<'_, Editor>, size: [f32; 2]) {
    harness.set_size(size.into());
    steps(harness);
}

/// What can be clicked, moved or written in.
fn is_tool(role: Role) -> bool {
    use Role::{Button, CheckBox, ComboBox, RadioButton, Slider, SpinButton, TextInput};
    matches!(role, Button | CheckBox | ComboBox | RadioButton | Slider | SpinButton | TextInput)
}

/// Of all tools and lines of text: what they are, what they are called, where they are.
fn widgets(harness: &Harness<'_, Editor>) -> Vec<(Role, String, Rect)> {
    let root = harness.root();
    let nodes = root.children_recursive();
    // What was not drawn has no place.
    let known = nodes.filter(|node| {
        let it = node.accesskit_node();
        !it.is_hidden() && it.raw_bounds().is_some()
    });
    known
        .map(|node| {
            let it = node.accesskit_node();
            let name = it.label().or(it.value()).unwrap_or_default();
            (it.role(), name, node.rect())
        })
        .filter(|(role, _, rect)| (is_tool(*role) || *role == Role::Label) && rect.is_finite())
        .collect()
}

/// Tools that begin within a view and end outside of it, and tools of the right side that end outside of the window.
fn cut(harness: &Harness<'_, Editor>, view: &str, size: [f32; 2]) -> Vec<String> {
    let view = harness.get_by_label(view).rect();
    let within = |rect: &Rect| rect.left() >= view.left() - OVERLAP && rect.left() < view.right();
    let beside = |rect: &Rect| rect.left() >= view.right();
    let tells = |(role, name, rect): (Role, String, Rect)| format!("{role:?} {name:?} at {rect:?}");
    let all = widgets(harness).into_iter().filter(|(_, _, rect)| rect.width() > 0.0);
    all.filter(|(role, _, rect)| {
        let (right, bottom) = (rect.right() - OVERLAP, rect.bottom() - OVERLAP);
        (is_tool(*role) && within(rect) && (right > view.right() || bottom > size[1]))
            || (beside(rect) && right > size[0])
    })
    .map(tells)
    .collect()
}

/// The tools and lines of a dialog that lie outside of the window.
fn outside(harness: &Harness<'_, Editor>, size: [f32; 2]) -> Vec<String> {
    let window = Rect::from_min_size(Default::default(), size.into()).expand(OVERLAP);
    let all = widgets(harness).into_iter().filter(|(role, _, _)| is_tool(*role));
    let all = all.filter(|(_, _, rect)| rect.left() > window.right() || rect.right() > window.right());
    all.map(|(role, name, rect)| format!("{role:?} {name:?} at {rect:?}")).collect()
}

#[test]
fn in_a_small_window_no_tool_is_cut_in_any_view_or_panel() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    for size in [SMALL, MIDDLE] {
        resize(&mut harness, size);
        harness.state_mut().select(Selection::Layer { photo: PhotoId(0), layer: LayerIndex(3) });
        for (shows, view) in [
            (&command::flat::SHOW_SPACE, "3D view"),
            (&command::flat::SHOW_PHOTO, "Photo view"),
            (&command::flat::SHOW_LAYER, "Image layer view"),
        ] {
            harness.state_mut().run(shows);
            steps(&mut harness);
            wait(&mut harness, view, |editor| editor.running.is_idle());
            steps(&mut harness);
            assert_eq!(cut(&harness, view, size), Vec::<String>::new(), "{view} at {size:?}");
        }
        harness.state_mut().run(&command::flat::SHOW_SPACE);
        for tab in ["Fill", "Colour", "Paint", "Selection"] {
            let tabs = harness.query_all_by_label(tab);
            tabs.max_by(|a, b| a.rect().left().total_cmp(&b.rect().left())).unwrap().click();
            steps(&mut harness);
            wait(&mut harness, tab, |editor| editor.running.is_idle());
            steps(&mut harness);
            let mut cut = cut(&harness, "3D view", size);
            // The table of all photos is scrolled where it has no room.
            cut.retain(|it| {
                tab != "Fill"
                    || !(it.contains('%') || ["Photos", "Inpainted", "Empty"].iter().any(|h| it.contains(h)))
            });
            assert_eq!(cut, Vec::<String>::new(), "{tab} at {size:?}");
        }
        let face = harness.state().session.as_ref().unwrap().model().objects[0].faces[0];
        let object = quadratura::testing::scene::ObjectId(0);
        for selection in [
            Selection::Nothing,
            Selection::Photo(PhotoId(0)),
            Selection::Object(object),
            Selection::Face(face),
        ] {
            harness.state_mut().select(selection);
            steps(&mut harness);
            assert_eq!(cut(&harness, "3D view", size), Vec::<String>::new(), "{selection:?} at {size:?}");
        }
        for shown in command::view::DISPLAY_COMMANDS {
            harness.state_mut().run(shown);
            steps(&mut harness);
            assert_eq!(cut(&harness, "3D view", size), Vec::<String>::new(), "{} at {size:?}", shown.name);
        }
        harness.state_mut().run(&command::view::COLOUR);
    }
}

#[test]
fn what_has_no_room_in_a_bar_is_behind_a_button_by_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    resize(&mut harness, [1920.0, 1080.0]);
    let wireframe = |harness: &Harness<'_, Editor>| is_there(harness, "Wireframe");
    assert!(wireframe(&harness) && !is_there(&harness, "More tools: 3D view"));
    resize(&mut harness, SMALL);
    assert!(!wireframe(&harness));
    press(&mut harness, "More tools: 3D view");
    press(&mut harness, "Wireframe");
    assert!(harness.state().space.wireframe);
    assert!(wireframe(&harness), "the list stays open: several may be switched");
}

#[test]
fn panels_shrink_with_the_window_and_have_their_users_width_again_when_it_grows() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    steps(&mut harness);
    let view = |harness: &Harness<'_, Editor>| harness.get_by_label("3D view").rect();
    let wide = view(&harness);
    assert!((wide.left() - 290.0).abs() < 2.0, "{wide:?}");
    resize(&mut harness, SMALL);
    let narrow = view(&harness);
    assert!(narrow.left() < SMALL[0] / 3.0 && narrow.right() > SMALL[0] * 2.0 / 3.0 - 2.0, "{narrow:?}");
    resize(&mut harness, [1280.0, 800.0]);
    assert_eq!(view(&harness), wide);
    // What is written on a panel makes it no wider, and either side can be put away.
    harness.state_mut().select(Selection::Layer { photo: PhotoId(1), layer: LayerIndex(0) });
    steps(&mut harness);
    assert_eq!(view(&harness), wide);
    for key in [Key::F6, Key::F7] {
        harness.key_press(key);
        steps(&mut harness);
    }
    assert!(view(&harness).width() > 1276.0, "{:?}", view(&harness));
    harness.state_mut().run(&command::file::LAYOUT);
    steps(&mut harness);
    assert_eq!(view(&harness), wide);
}

#[test]
fn settings_and_lists_of_keys_have_room_in_a_small_window() {
    let mut harness = harness::window(None);
    resize(&mut harness, SMALL);
    for command in [&command::file::SETTINGS, &command::file::KEYS, &command::file::NEW] {
        harness.state_mut().run(command);
        steps(&mut harness);
        assert_eq!(outside(&harness, SMALL), Vec::<String>::new(), "{}", command.name);
        harness.key_press(Key::Escape);
        steps(&mut harness);
    }
}

#[test]
fn cameras_are_browsed_for_as_a_file_or_as_a_folder_from_one_button() {
    let mut harness = harness::window(None);
    harness.state_mut().run(&command::file::NEW);
    steps(&mut harness);
    // Photos, cameras, the model and the project, from top to bottom.
    let browse = harness.query_all_by_label("Browse…").nth(1).expect("the dialog has a button for each part");
    browse.click();
    steps(&mut harness);
    assert!(is_there(&harness, "Choose a folder…") && is_there(&harness, "Choose a file…"));
    assert_eq!(harness.query_all_by_label("Browse…").count(), 4);
}

fn press_of(key: Key, modifiers: Modifiers) -> Event {
    Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
}

#[test]
fn letters_that_come_in_the_same_frame_as_the_keys_of_the_palette_are_all_in_it() {
    let mut harness = harness::window(None);
    harness.step();
    let letters = "theme light".chars().map(|letter| Event::Text(letter.into()));
    let mut events = vec![press_of(Key::P, Modifiers::COMMAND)];
    events.extend(letters);
    harness.input_mut().events = events;
    steps(&mut harness);
    harness.get_by_label("Window › Theme: light");
    harness.key_press(Key::Enter);
    steps(&mut harness);
    assert_eq!(harness.state().settings.colours, Colours::Light);
}

#[test]
fn a_photo_and_its_page_say_the_same_of_its_state_and_layers_of_one_name_are_numbered() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    harness.state_mut().select(Selection::Photo(PhotoId(1)));
    steps(&mut harness);
    harness.get_by_label("02_from_southwest.jpg, built");
    assert_eq!(harness.query_all_by_label("built").count(), PHOTOS, "in the list");
    harness.get_by_label_contains("built · ");
    let stack = harness.state().session.as_ref().unwrap().photos[1].stack.clone().unwrap();
    let depths = stack.image_layers.last().unwrap().order + 1;
    harness.get_by_label("Details").click_accesskit();
    steps(&mut harness);
    harness.get_by_label(&format!("{}, at {depths} depths", stack.image_layers.len()));
    let mut names: Vec<&str> = stack.image_layers.iter().map(|layer| layer.name.as_str()).collect();
    assert!(
        names.iter().any(|name| name.ends_with(" (2)")),
        "an object of the piazza has two layers: {names:?}"
    );
    names.sort_unstable();
    assert!(names.windows(2).all(|two| two[0] != two[1]), "{names:?}");
}

#[test]
fn even_colour_shows_the_photo_in_the_exposure_it_is_blended_with() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    harness.state_mut().select(Selection::Photo(PhotoId(0)));
    command(&mut harness, "Show photo");
    assert_eq!(harness.state().even_factors(PhotoId(0)), None, "nobody has asked for it");
    command(&mut harness, "Matched exposure");
    wait(&mut harness, "the exposures", |editor| editor.even_factors(PhotoId(0)).is_some());
    let edit = quadratura::testing::views::colour::ColourEdit::Fix("01_church.jpg".into(), [1.0; 3]);
    harness.state_mut().apply(QualityRequest::Colour { edits: vec![edit], goes_on: false });
    let factors = harness.state().even_factors(PhotoId(0)).unwrap();
    assert!(
        factors.iter().all(|factor| (factor - 0.5).abs() < 1e-9),
        "a stop less is half the light: {factors:?}"
    );
}

#[test]
fn enter_flies_into_a_photo_and_never_out_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    harness.state_mut().select(Selection::Photo(PhotoId(1)));
    let through = |editor: &Editor| editor.space.through();
    harness.key_press(Key::Enter);
    wait(&mut harness, "the flight", |editor| through(editor) == Some(PhotoId(1)));
    harness.key_press(Key::Enter);
    (0..30).for_each(|_| harness.step());
    assert_eq!(through(harness.state()), Some(PhotoId(1)));
}
