//! Tests of the lists of layers and objects: their rows, what the cursor selects, and merges that are asked about.

use std::sync::Arc;

use super::bench::{PHOTOS, TestBench};
use super::layered::layered;
use crate::state::lists::ListsState;
use crate::state::lists::row::ListRow;
use crate::state::lists::rows::{ListedSite, rows};
use crate::state::request::{DecideRequest, Flag, Request, SelectRequest, WindowRequest};
use crate::state::selection::Selection;
use quadratura_base::scene::{FaceIndex, ObjectId, PhotoId};
use quadratura_layers::{Faces, LayerIndex};
use quadratura_stacks::decide::LayerEdit;
use quadratura_stacks::layer_table::LayerColumn;

/// Returns the rows of the lists as they are.
fn listed(bench: &TestBench) -> Vec<ListRow> {
    let site = ListedSite::from_state(&bench.state).unwrap();
    rows(bench.state.settings.layer_list, &bench.state.quality.fill, &bench.state.lists, &site)
}

/// Changes the lists as a panel does, and applies what they ask for.
fn hand(
    bench: &mut TestBench,
    act: impl FnOnce(&mut ListsState, &ListedSite<'_>, Selection, &[ListRow]) -> Option<Request>,
) {
    let mut lists = std::mem::take(&mut bench.state.lists);
    let site = ListedSite::from_state(&bench.state).unwrap();
    let rows = rows(bench.state.settings.layer_list, &bench.state.quality.fill, &lists, &site);
    let request = act(&mut lists, &site, bench.state.selection.main, &rows);
    bench.state.lists = lists;
    request.into_iter().for_each(|request| bench.request(request));
}

fn layers_in(rows: &[ListRow]) -> Vec<LayerIndex> {
    rows.iter().filter_map(|row| if let ListRow::Layer(layer) = row { Some(*layer) } else { None }).collect()
}

// ---- rows ----

#[test]
fn without_a_project_nothing_is_listed() {
    assert!(ListedSite::from_state(&TestBench::empty().state).is_none());
}

#[test]
fn a_photo_without_layers_says_how_they_are_made() {
    let rows = listed(&TestBench::new());
    assert_eq!(rows[0], ListRow::Layers);
    assert!(matches!(rows[1], ListRow::Say(words) if words.contains("Build layers")));
    assert_eq!(rows[2], ListRow::Objects);
}

#[test]
fn layers_are_listed_by_depth_and_a_closed_depth_lists_none() {
    let mut bench = layered();
    let count = bench.session().photos[0].stack.as_ref().unwrap().image_layers.len();
    assert_eq!(layers_in(&listed(&bench)), LayerIndex::all(count).collect::<Vec<_>>());
    let depths = listed(&bench).iter().filter(|row| matches!(row, ListRow::Depth(_))).count();
    assert!(depths > 1);
    bench.state.lists.turn(ListRow::Depth(0));
    let rows = listed(&bench);
    assert!(rows.contains(&ListRow::Depth(0)) && layers_in(&rows).len() < count);
    bench.state.lists.turn(ListRow::Layers);
    assert_eq!(listed(&bench)[..2], [ListRow::Layers, ListRow::Objects]);
}

#[test]
fn a_table_has_headings_and_the_order_of_its_column() {
    let mut bench = layered();
    bench.request(WindowRequest::Flip(Flag::LayerTable));
    bench.request(WindowRequest::SortLayers(LayerColumn::Name));
    let rows = listed(&bench);
    assert_eq!(rows[1], ListRow::Head);
    assert!(!rows.iter().any(|row| matches!(row, ListRow::Depth(_))));
    let before = layers_in(&rows);
    bench.request(WindowRequest::SortLayers(LayerColumn::Name));
    let after = layers_in(&listed(&bench));
    let stack = bench.session().photos[0].stack.clone().unwrap();
    let name = |layer: &LayerIndex| stack.layer(*layer).name.to_lowercase();
    assert!(before.is_sorted_by_key(name) && after.iter().rev().is_sorted_by_key(name));
}

#[test]
fn the_filter_is_for_layers_and_objects_and_says_where_nothing_is_left() {
    let mut bench = layered();
    bench.state.lists.filter = "no such name".into();
    let said = listed(&bench).iter().filter(|row| matches!(row, ListRow::Say(_))).count();
    assert_eq!(said, 2);
}

#[test]
fn an_object_that_is_removed_stays_listed() {
    let mut bench = TestBench::new();
    let name = bench.session().model().objects[0].name.clone();
    bench.state.switch_object(&name, false);
    assert!(bench.project().objects_off.contains(&name));
    let site = ListedSite::from_state(&bench.state).unwrap();
    assert!(site.is_off(&name) && listed(&bench).contains(&ListRow::Object(ObjectId(0))));
}

// ---- the cursor ----

#[test]
fn a_selection_made_elsewhere_opens_its_row_once() {
    let mut bench = layered();
    bench.state.lists.turn(ListRow::Objects);
    let face = bench.session().model().objects[1].faces[0];
    bench.request(SelectRequest::Only(Selection::Face(face)));
    let mut follows = Vec::new();
    for _ in 0..2 {
        hand(&mut bench, |lists, site, selection, _| {
            follows.push(lists.follow(selection, site, false));
            None
        });
    }
    assert_eq!(follows, [true, false]);
    assert_eq!(bench.state.lists.cursor, Some(ListRow::Face(ObjectId(1), FaceIndex(0))));
    assert!(listed(&bench).contains(&ListRow::Face(ObjectId(1), FaceIndex(0))));
}

#[test]
fn the_cursor_selects_where_it_goes() {
    let mut bench = layered();
    for (row, selection) in [
        (ListRow::Layer(LayerIndex(1)), Selection::Layer { photo: PhotoId(0), layer: LayerIndex(1) }),
        (ListRow::Object(ObjectId(2)), Selection::Object(ObjectId(2))),
        (ListRow::Objects, Selection::Object(ObjectId(2))),
    ] {
        hand(&mut bench, |lists, site, selected, rows| {
            let to = rows.iter().position(|other| *other == row).unwrap();
            lists.go(site, selected, rows, to, false)
        });
        assert_eq!((bench.state.lists.cursor, bench.state.selection.main), (Some(row), selection));
    }
}

#[test]
fn a_range_goes_from_the_layer_that_was_selected_alone() {
    let mut bench = layered();
    hand(&mut bench, |lists, site, _, _| lists.select_layer(site, LayerIndex(0)));
    hand(&mut bench, |lists, site, selected, rows| lists.select_range(site, selected, rows, LayerIndex(2)));
    assert_eq!(bench.state.selection.layers(), (PhotoId(0), [0, 1, 2].map(LayerIndex).to_vec()));
    assert_eq!(bench.state.selection.main, Selection::Layer { photo: PhotoId(0), layer: LayerIndex(2) });
    hand(&mut bench, |lists, site, selected, rows| lists.select_range(site, selected, rows, LayerIndex(1)));
    assert_eq!(
        bench.state.selection.layers(),
        (PhotoId(0), [0, 1].map(LayerIndex).to_vec()),
        "it still begins there"
    );
}

#[test]
fn layers_are_added_one_by_one_and_all_of_them_are_marked() {
    let mut bench = layered();
    hand(&mut bench, |lists, site, _, _| lists.select_layer(site, LayerIndex(0)));
    hand(&mut bench, |lists, site, _, _| lists.toggle_layer(site, LayerIndex(2)));
    let site = ListedSite::from_state(&bench.state).unwrap();
    let marked = |layer| site.is_selected(ListRow::Layer(LayerIndex(layer)), &bench.state.selection);
    assert_eq!([0, 1, 2].map(marked), [true, false, true]);
    assert_eq!(bench.state.lists.anchor(), Some((PhotoId(0), LayerIndex(2))));
}

// ---- merging ----

/// Puts two layers of a photo, one of which hides the other, far from each other: merging them would waste much.
fn with_distant_layers() -> TestBench {
    let mut bench = layered();
    let session = bench.state.session.as_mut().unwrap();
    let stack = Arc::make_mut(session.photos[0].stack.as_mut().unwrap());
    stack.image_layers[1].needed_rect.x += 40_000;
    bench
}

#[test]
fn linked_layers_are_selected_together_and_one_can_be_taken_off() {
    let mut bench = with_distant_layers();
    let session = bench.state.session.as_mut().unwrap();
    let stack = Arc::make_mut(session.photos[0].stack.as_mut().unwrap());
    stack.linked = vec![vec![stack.image_layers[0].id.clone(), stack.image_layers[1].id.clone()]];
    let layer = |index: u32| LayerIndex(index);
    for first in [0, 1] {
        bench.request(SelectRequest::Only(Selection::Layer { photo: PhotoId(0), layer: layer(first) }));
        assert_eq!(bench.state.selection.layers().1, [layer(0), layer(1)]);
    }
    bench.request(SelectRequest::Toggle(PhotoId(0), layer(0)));
    assert_eq!(bench.state.selection.layers().1, [layer(1)]);
}

/// Makes a bench in which a decision waits as a merge that wastes much does.
fn asked_to_merge() -> TestBench {
    let mut bench = with_distant_layers();
    let cost = bench.session().merge_cost(PhotoId(0), &[LayerIndex(0), LayerIndex(1)]).unwrap();
    assert!(cost.is_too_large());
    let of = vec![Faces::whole(&bench.session().model().objects[0].name)];
    bench.state.request_to_merge(LayerEdit::Exclude { photo: PHOTOS[0].into(), of }, cost);
    bench
}

#[test]
fn a_merge_that_is_not_possible_is_told_at_once_whatever_it_wastes() {
    let mut bench = with_distant_layers();
    bench.request(SelectRequest::Layers(PhotoId(0), vec![LayerIndex(0), LayerIndex(1)]));
    bench.request(DecideRequest::Merge);
    assert_eq!((bench.state.is_asking(), bench.undoes(), bench.said().len()), (false, None, 1));
}

#[test]
fn a_merge_that_waits_is_a_question_and_then_a_step() {
    let mut bench = asked_to_merge();
    assert!(bench.state.lists.is_asking() && bench.state.is_asking() && bench.undoes().is_none());
    bench.request(DecideRequest::ConfirmMerge(true));
    assert!(!bench.state.is_asking());
    assert!(bench.project().decisions.photos.contains_key(PHOTOS[0]), "{:?}", bench.said());
}

#[test]
fn a_merge_that_is_given_up_is_no_step() {
    let mut bench = asked_to_merge();
    bench.request(DecideRequest::ConfirmMerge(false));
    assert_eq!((bench.state.is_asking(), bench.undoes()), (false, None));
    bench.request(DecideRequest::ConfirmMerge(true));
    assert_eq!(bench.undoes(), None, "nothing waits any more");
}
