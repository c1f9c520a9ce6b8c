//! The lists of layers and objects and the pages about them, driven by the names of their widgets, with the software
//! adapter where there is no other.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common;
use crate::harness;
use crate::harness::{built_photos, opened, project_of, small_piazza, wait};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use quadratura::testing::app::command;
use quadratura::testing::app::editor::Editor;
use quadratura::testing::app::selection::Selection;
use quadratura::testing::document::Stack;
use quadratura::testing::document::paint::{PaintEntry, PaintPatch, PaintedView};
use quadratura::testing::document::stack::PropagationEntry;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::io::layer_reader::read_layer;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::LayerIndex;
use quadratura::testing::layers::fill::{FillOptions, Invent, Propagation};
use quadratura::testing::scene::{FaceIndex, PhotoId};
use quadratura::testing::stacks::fill::viewpoints::Viewpoints;
use quadratura::testing::stacks::layer_table::{LayerColumn, sorted};

/// A project of the first photos of the piazza.
fn project(folder: &Path, photos: usize) -> PathBuf {
    let (site, project) = (folder.join("site"), folder.join("piazza"));
    small_piazza(&site, photos);
    project_of(&site, &project);
    project
}

/// The project that is open in an editor.
macro_rules! session {
    ($editor:expr) => {
        $editor.session.as_ref().unwrap()
    };
}

/// So many photos tell all that is asked here: two of the church, one of the arcade.
const PHOTOS: usize = 4;

/// A window with a part of the piazza and the layers of its photos; none where no adapter is.
fn built(folder: &Path) -> Option<Harness<'static, Editor>> {
    common::adapter()?;
    let mut harness = opened(&built_photos(folder, "piazza", PHOTOS, true));
    wait(&mut harness, "the layers", |editor| all_current(editor) && editor.running.is_idle());
    Some(harness)
}

fn all_current(editor: &Editor) -> bool {
    session!(editor).photos.iter().all(|photo| photo.is_current())
}

fn stack(editor: &Editor) -> &Stack {
    session!(editor).photos[0].stack.as_deref().unwrap()
}

fn steps(harness: &mut Harness<'_, Editor>) {
    (0..3).for_each(|_| harness.step());
}

fn click(harness: &mut Harness<'_, Editor>, role: Role, name: &str) {
    harness.get_by_role_and_label(role, name).click();
    steps(harness);
}

/// The names of rows in sight, from top to bottom.
fn rows(harness: &Harness<'_, Editor>) -> Vec<String> {
    let mut rows: Vec<_> = harness
        .query_all_by_role(Role::TreeItem)
        .map(|row| (row.rect().top(), row.accesskit_node().label().unwrap_or_default()))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, name)| name).collect()
}

#[test]
fn an_object_is_hidden_by_its_eye_and_removed_by_a_command_that_asks() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    let layers = stack(harness.state()).image_layers.len();
    click(&mut harness, Role::Button, &format!("Close Layers of 01_church.jpg ({layers})"));
    let all = session!(harness.state()).opened.whole.objects.len();
    let listed = rows(&harness);
    assert_eq!(listed[..2], [format!("Layers of 01_church.jpg ({layers})"), format!("Objects ({all})")]);
    let (first, second) = (listed[2].clone(), listed[3].clone());
    let used = |editor: &Editor| session!(editor).model().objects.len();

    // The eye is a view: nothing of the project changes, and nothing is out of date.
    click(&mut harness, Role::CheckBox, &format!("Show {first}"));
    let face = {
        let model = session!(harness.state()).model();
        model.objects.iter().find(|object| object.name == first).unwrap().faces[0]
    };
    assert!(harness.state().space.look.hidden.contains(face));
    assert!(!harness.state().is_dirty() && all_current(harness.state()) && used(harness.state()) == all);
    click(&mut harness, Role::CheckBox, &format!("Show {first}"));
    assert!(!harness.state().space.look.hidden.contains(face));

    // Removing asks first, and says what becomes out of date.
    click(&mut harness, Role::TreeItem, &first);
    let ask = |harness: &mut Harness<'_, Editor>| {
        harness.state_mut().run(&command::edit::SWITCH_OFF);
        steps(harness);
        harness.get_by_label(&format!("Remove {first} from the model?"));
        harness.get_by_label_contains(&format!("the layers and fillings of {PHOTOS} photos"));
    };
    ask(&mut harness);
    click(&mut harness, Role::Button, "Cancel");
    assert!(!harness.state().is_dirty());
    click(&mut harness, Role::TreeItem, &second);
    click(&mut harness, Role::TreeItem, &first);
    ask(&mut harness);
    click(&mut harness, Role::Button, "Remove");
    assert_eq!(session!(harness.state()).history.undoes(), Some(format!("removal of {first}").as_str()));
    wait(&mut harness, "the model without it", |editor| used(editor) == all - 1 && editor.running.is_idle());
    assert!(session!(harness.state()).photos.iter().all(|photo| !photo.is_current()), "as the question said");
    assert_eq!(harness.state().selection.main, Selection::Nothing, "what is removed cannot be selected");
    assert!(rows(&harness).contains(&first), "it stays in the list");
    harness.get_by_label(&format!("Objects ({all}, 1 removed)"));

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "the whole model", |editor| used(editor) == all && editor.running.is_idle());
    wait(&mut harness, "photos as they were", all_current);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    wait(&mut harness, "the model without it", |editor| used(editor) == all - 1 && editor.running.is_idle());
    click(&mut harness, Role::Button, &format!("Restore {first}"));
    wait(&mut harness, "the whole model again", |editor| used(editor) == all);
}

#[test]
fn a_layer_is_hidden_alone_and_faint_in_the_photo_and_nothing_is_decided() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    harness.key_press(Key::F3);
    steps(&mut harness);
    let layer = stack(harness.state()).image_layers[0].clone();
    let name = layer.name.clone();
    let shown = |harness: &Harness<'_, Editor>, index: u32| {
        let peeling = harness.state().flat.peeling(session!(harness.state()), PhotoId(0), 0);
        peeling.opacities.of(LayerIndex(index))
    };
    let eye = format!("Show {name}");
    let first_eye = |harness: &mut Harness<'_, Editor>| {
        harness.query_all_by_label(&eye).next().unwrap().click();
        steps(harness);
    };
    first_eye(&mut harness);
    assert_eq!([shown(&harness, 0), shown(&harness, 1)], [0, 255]);
    let count = |editor: &Editor| editor.flat.loading.peeled.last(|_| true).is_some();
    wait(&mut harness, "the photo without the layer", |editor| count(editor) && editor.running.is_idle());
    first_eye(&mut harness);
    assert_eq!(shown(&harness, 0), 255);

    // Solo and opacity are in the inspector.
    harness.state_mut().select(Selection::Layer { photo: PhotoId(0), layer: LayerIndex(0) });
    steps(&mut harness);
    click(&mut harness, Role::CheckBox, "Solo");
    assert_eq!([shown(&harness, 0), shown(&harness, 1)], [255, 0]);
    click(&mut harness, Role::Button, "Show all layers");
    assert_eq!([shown(&harness, 0), shown(&harness, 1)], [255, 255]);
    assert!(!harness.state().is_dirty(), "these are views");
}

#[test]
fn names_are_found_and_the_keyboard_walks_opens_and_closes() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    harness.get_by_role_and_label(Role::TextInput, "Find by name").click();
    harness.step();
    harness.get_by_role_and_label(Role::TextInput, "Find by name").type_text("WINDOWS");
    steps(&mut harness);
    let found = rows(&harness);
    let object = "palazzo_east.windows".to_owned();
    assert_eq!(found[2..], [object.as_str()], "below the two titles");
    click(&mut harness, Role::TreeItem, &object);
    assert_eq!(harness.state().selected_object(), Some(object.clone()));

    for key in [Key::ArrowRight, Key::ArrowDown] {
        harness.key_press(key);
        steps(&mut harness);
    }
    let face = |editor: &Editor| matches!(editor.selection.main, Selection::Face(_));
    assert!(face(harness.state()), "{:?}", harness.state().selection.main);
    harness.get_by_role_and_label(Role::TreeItem, &format!("{object}[0]"));
    for key in [Key::ArrowLeft, Key::ArrowLeft] {
        harness.key_press(key);
        steps(&mut harness);
    }
    assert!(!face(harness.state()) && harness.state().selected_object() == Some(object.clone()));
    assert!(!rows(&harness).contains(&format!("{object}[0]")), "it is closed");
    harness.key_press(Key::Space);
    steps(&mut harness);
    assert!(!harness.state().is_dirty(), "no key of the list changes the project");
}

#[test]
fn the_table_is_sorted_by_its_headings_and_a_range_goes_by_what_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    click(&mut harness, Role::Button, "Layers as table");
    click(&mut harness, Role::ColumnHeader, "Sort by size");
    let by_size = |editor: &Editor, falling| sorted(stack(editor), LayerColumn::Size, falling, |_| None);
    let name = |editor: &Editor, layer: LayerIndex| stack(editor).layer(layer).name.clone();
    for falling in [true, false] {
        let expected: Vec<String> =
            by_size(harness.state(), falling).into_iter().map(|layer| name(harness.state(), layer)).collect();
        let listed = rows(&harness);
        assert!(listed.len() > 6 && listed[1..6] == expected[..5], "{listed:?} {expected:?}");
        if falling {
            click(&mut harness, Role::ColumnHeader, "Sort by size");
        }
    }
    assert!(!harness.state().settings.layer_list.falling);

    // From one row to another with Shift, and one more with the keyboard; then one less with Ctrl.
    let order = by_size(harness.state(), false);
    let once = |layer: &&LayerIndex| {
        let its = name(harness.state(), **layer);
        order.iter().filter(|other| name(harness.state(), **other) == its).count() == 1
    };
    let unlike: Vec<LayerIndex> = order[..8].iter().filter(once).copied().collect();
    let (from, to) = (unlike[0], unlike[2]);
    let place = |layer: LayerIndex| order.iter().position(|other| *other == layer).unwrap();
    let mut range: Vec<LayerIndex> = order[place(from)..=place(to)].to_vec();
    let names = [from, to].map(|layer| name(harness.state(), layer));
    click(&mut harness, Role::TreeItem, &names[0]);
    harness.get_by_role_and_label(Role::TreeItem, &names[1]).click_modifiers(Modifiers::SHIFT);
    steps(&mut harness);
    range.sort_unstable();
    assert_eq!(harness.state().selection.layers(), (PhotoId(0), range.clone()));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowDown);
    steps(&mut harness);
    range.push(order[place(to) + 1]);
    range.sort_unstable();
    assert_eq!(harness.state().selection.layers(), (PhotoId(0), range.clone()));
    harness.get_by_label(&format!("{} image layers", range.len()));
    harness.get_by_role_and_label(Role::TreeItem, &names[0]).click_modifiers(Modifiers::COMMAND);
    steps(&mut harness);
    range.retain(|layer| *layer != from);
    assert_eq!(harness.state().selection.layers(), (PhotoId(0), range));

    // Columns without room are in a menu.
    click(&mut harness, Role::Button, "More columns");
    click(&mut harness, Role::Button, "Sort by waste");
    assert_eq!(harness.state().settings.layer_list.column, LayerColumn::Waste);
    harness.get_by_role_and_label(Role::ColumnHeader, "Sort by waste");
}

/// Two layers that could be merged at a high price.
fn dear_pair(editor: &Editor) -> Option<[LayerIndex; 2]> {
    let count = stack(editor).image_layers.len();
    let pairs =
        (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b].map(|layer| LayerIndex(layer as u32))));
    let cost = |pair: &[LayerIndex]| session!(editor).merge_cost(PhotoId(0), pair);
    pairs.into_iter().find(|pair| cost(pair).is_some_and(|cost| cost.is_high()))
}

#[test]
fn a_merge_that_keeps_much_emptiness_is_asked_about_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    let pair = dear_pair(harness.state()).expect("some two layers of the piazza lie far apart");
    let cost = session!(harness.state()).merge_cost(PhotoId(0), &pair).unwrap();
    harness.state_mut().select_layers(PhotoId(0), pair.to_vec());
    steps(&mut harness);
    let ask = |harness: &mut Harness<'_, Editor>| {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::M);
        steps(harness);
    };
    ask(&mut harness);
    harness.get_by_label("Merge 2 layers?");
    let [width, height] = cost.size;
    harness.get_by_label_contains(&format!("One rectangle around all of them is {width} × {height} px"));
    click(&mut harness, Role::Button, "Cancel");
    assert!(!harness.state().is_dirty());
    ask(&mut harness);
    click(&mut harness, Role::Button, "Merge anyway");
    assert!(harness.state().is_dirty());
    let decisions = &session!(harness.state()).history.present().decisions;
    assert_eq!(decisions.photos["01_church.jpg"].merge.len(), 1);
}

#[test]
fn a_face_tells_how_each_photo_stands_to_it_and_is_excluded_and_allowed_there() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    let facade = |editor: &Editor| {
        let model = session!(editor).model();
        model.objects.iter().find(|object| object.name == "church.facade").unwrap().faces[0]
    };
    let face = facade(harness.state());
    harness.state_mut().select(Selection::Face(face));
    steps(&mut harness);
    harness.get_by_role_and_label(Role::TreeItem, "church.facade[0]");
    let excluded = |editor: &Editor| {
        session!(editor)
            .history
            .present()
            .decisions
            .of("01_church.jpg")
            .excludes("church.facade", FaceIndex(0))
    };
    let drawn_by = |editor: &Editor| editor.work.painter.as_ref().map(|painter| painter.surface.clone());
    let painter = drawn_by(harness.state()).unwrap();
    click(&mut harness, Role::Button, "Exclude 01_church.jpg");
    assert!(excluded(harness.state()));
    wait(&mut harness, "the view after the decision", |editor| {
        !session!(editor).photos.is_empty() && !Arc::ptr_eq(&session!(editor).solid, &painter)
    });
    let same = drawn_by(harness.state()).is_some_and(|now| Arc::ptr_eq(&now, &painter));
    assert!(same, "no decision needs another renderer before something is built");
    harness.get_by_label("no texture: excluded by hand");
    click(&mut harness, Role::Button, "Allow 01_church.jpg");
    assert!(!excluded(harness.state()));
    click(&mut harness, Role::Button, "Pin to 01_church.jpg");
    harness.get_by_label_contains("pinned to this photo");
    click(&mut harness, Role::Button, "Unpin 01_church.jpg");
    assert!(
        !harness
            .state()
            .session
            .as_ref()
            .unwrap()
            .history
            .present()
            .decisions
            .photos
            .contains_key("01_church.jpg")
    );

    // To the photo, with the face still selected.
    let named = session!(harness.state()).opened.site.photo_named("04_arcade.jpg");
    harness.get_by_role_and_label(Role::Button, "04_arcade.jpg").click();
    steps(&mut harness);
    assert_eq!(harness.state().selected_photo(), named);
    assert_eq!(harness.state().selection.main, Selection::Face(face));
    harness.get_by_label("Photo view");
}

#[test]
fn what_is_seen_most_is_ranked_by_kept_views_where_there_are_some_and_by_the_photos_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut harness) = built(folder.path()) else { return };
    click(&mut harness, Role::Button, "Fill");
    let found = |editor: &Editor| editor.quality.fill.worst.found().is_some() && editor.running.is_idle();
    wait(&mut harness, "the worst", found);
    steps(&mut harness);
    harness.get_by_label_contains("Seen from the photos' cameras.");
    let viewpoints = |editor: &Editor| editor.quality.fill.seen_from(&session!(editor).opened.project);
    let views = |editor: &Editor| editor.quality.fill.worst.found().unwrap().views.len();
    assert_eq!(views(harness.state()), PHOTOS);

    harness.state_mut().run(&command::flight::KEEP);
    steps(&mut harness);
    assert_eq!(viewpoints(harness.state()), Viewpoints::Kept);
    wait(&mut harness, "what the kept view sees", |editor| found(editor) && views(editor) == 1);
    steps(&mut harness);
    let worst = harness.state().quality.fill.worst.found().unwrap().layers[0].clone();
    let photo = &session!(harness.state()).opened.site.photo(worst.photo).name;
    let stack = session!(harness.state()).photos[worst.photo.index()].stack.clone().unwrap();
    let row = format!("{} – {photo}", stack.layer(worst.layer).name);
    harness.get_all_by_label(&row).next().unwrap().click();
    steps(&mut harness);
    assert_eq!(harness.state().selection.main, Selection::Layer { photo: worst.photo, layer: worst.layer });

    harness.get_by_role_and_label(Role::ComboBox, "Seen from").click();
    steps(&mut harness);
    harness.get_by_label(&format!("the photos' cameras ({PHOTOS})")).click();
    steps(&mut harness);
    assert_eq!(viewpoints(harness.state()), Viewpoints::Photos);
    wait(&mut harness, "what the photos see", |editor| found(editor) && views(editor) == PHOTOS);
}

/// Paints on the facade of the church in the first photo, as an import would.
fn paint_facade(folder: &Path) {
    let photo = "01_church.jpg";
    let stacks = StackStore::new(folder);
    let stack = stacks.current(photo).unwrap().unwrap();
    let layer = stack.image_layers.iter().find(|layer| layer.name.contains("church.facade")).unwrap();
    let texels = read_layer(&stacks.folder(photo).join(&layer.file), layer.rect, layer.rect).unwrap();
    let shown = texels.chunks_exact(4).enumerate().filter(|(_, texel)| texel[3] > 0).map(|(at, _)| at as u32);
    let at = |at: u32| (layer.rect.x + (at % layer.rect.w) as i32, layer.rect.y + (at / layer.rect.w) as i32);
    let magenta = [65535, 0, 65535, 65535];
    // In the middle, where the layer holds nothing else.
    let shown: Vec<u32> = shown.collect();
    let middle = &shown[shown.len() / 2..][..3000];
    let painted: Vec<_> = middle.iter().map(|it| at(*it)).map(|(x, y)| (x, y, magenta)).collect();
    let outline =
        stack.surfaces.iter().find(|surface| surface.object == "church.facade").unwrap().outline.clone();
    let store = PaintStore::new(folder);
    let before = store.read().unwrap();
    let mut book = before.clone();
    let mut entry = PaintEntry {
        photo: photo.into(),
        object: "church.facade".into(),
        face: Some(FaceIndex(0)),
        triangle: None,
        beyond: false,
        layer: layer.id.clone(),
        document: "key@file.psd".into(),
        import: book.next_import(),
        view: "view".into(),
        outline,
        file: String::new(),
        rect: PixelRect { x: 0, y: 0, w: 0, h: 0 },
        pixels: 0,
    };
    store.add(&mut entry, &PaintPatch::of_pixels(&painted)).unwrap();
    book.views.insert("view".into(), PaintedView { photo: stack.photo, camera: stack.camera });
    book.entries.push(entry);
    book.tidy();
    store.commit(&book, &before).unwrap();
}

#[test]
fn paint_of_one_photo_is_laid_over_the_others_and_taken_off_again() {
    if common::adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut harness = harness::window(Some(project(folder.path(), 2)));
    wait(&mut harness, "the project", |editor| editor.session.is_some() && editor.running.is_idle());
    harness.state_mut().run(&command::layers::BUILD);
    wait(&mut harness, "the layers", |editor| all_current(editor) && editor.running.is_idle());
    // The quick way of filling is enough.
    harness.state_mut().edit_fill(FillOptions { invent: Invent::Diffusion, ..FillOptions::default() });
    paint_facade(&folder.path().join("piazza"));
    click(&mut harness, Role::Button, "Fill");
    wait(&mut harness, "who has painted", |editor| editor.quality.fill.painters.found().is_some());
    steps(&mut harness);
    let off = harness.state();
    assert_eq!((command::layers::TAKE_OFF.ready)(off), Err("no paint is projected to another photo"));
    harness.get_by_role_and_label(Role::CheckBox, "paint of 01_church.jpg");
    let propagated = |editor: &Editor| -> Vec<PropagationEntry> {
        let fills = session!(editor).photos.iter().filter_map(|photo| photo.stack.as_ref()?.fill.as_ref());
        fills.flat_map(|fill| fill.propagated.clone()).collect()
    };
    // Options without a choice are those of a project of before.
    harness.state_mut().round_trip.painted.insert("01_church.jpg".into());
    // The menu has the same name as the tab, which is farther to the right.
    let tabs = harness.query_all_by_role_and_label(Role::Button, "Paint");
    tabs.max_by(|a, b| a.rect().left().total_cmp(&b.rect().left())).unwrap().click();
    steps(&mut harness);
    wait(&mut harness, "a picture of both", |editor| editor.quality.fill.both_ways.found().is_some());
    steps(&mut harness);
    harness.get_by_label("Is paint seen from everywhere?");
    for seen in ["Only in its photo: ", "From everywhere: "] {
        let pictures = harness.query_all_by_role(Role::Image);
        let named = pictures.filter_map(|picture| picture.accesskit_node().label());
        assert!(named.into_iter().any(|name| name.starts_with(seen)), "{seen}");
    }
    click(&mut harness, Role::Button, "Show it from everywhere");
    assert_eq!(session!(harness.state()).opened.project.fill.propagate, Propagation::Of(vec!["*".into()]));
    wait(&mut harness, "the fillings", |editor| !propagated(editor).is_empty() && editor.running.is_idle());
    assert!(propagated(harness.state()).iter().all(|paint| paint.from == "01_church.jpg"));
    let laid: u64 = propagated(harness.state()).iter().map(|paint| paint.texels).sum();
    assert!(laid > 500, "{laid}");
    steps(&mut harness);
    assert!(harness.query_by_label("Is paint seen from everywhere?").is_none(), "it is answered");
    click(&mut harness, Role::Button, "Fill");
    wait(&mut harness, "who has painted", |editor| editor.quality.fill.painters.found().is_some());
    steps(&mut harness);
    harness.get_by_label_contains(" projected to ");
    harness.get_all_by_label_contains("church.facade[0] in ").next().unwrap().click();
    steps(&mut harness);
    assert!(
        matches!(harness.state().selection.main, Selection::Face(_)),
        "{:?}",
        harness.state().selection.main
    );
    harness.get_by_label("Photo view");

    click(&mut harness, Role::CheckBox, "paint of 01_church.jpg");
    assert!(session!(harness.state()).opened.project.fill.only_here.photos.contains("01_church.jpg"));
    wait(&mut harness, "what is out of date", |editor| {
        editor.quality.fill.stale.found().is_some_and(|stale| !stale.is_empty())
    });
    steps(&mut harness);
    harness.get_by_label_contains("out of date: views and exports show paint");
    harness.state_mut().run(&command::edit::UNDO);
    steps(&mut harness);
    assert!(session!(harness.state()).opened.project.fill.only_here.photos.is_empty());
    harness.state_mut().run(&command::layers::TAKE_OFF);
    wait(&mut harness, "no paint elsewhere", |editor| {
        propagated(editor).is_empty() && editor.running.is_idle()
    });
    assert_eq!(session!(harness.state()).opened.project.fill.propagate, Propagation::None);
}
