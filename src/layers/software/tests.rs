//! Closed-form scenes, written straight into views: what is seen can be said in a sentence.

use super::*;
use crate::Item;
use crate::rasteriser::{Occlusion, VISIBLE};
use quadratura_base::geometry::InverseDepth;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceId;

const TOLERANCE: f32 = 1e-4;

/// Returns a view of 16 x 8 pixels without items.
fn empty_view() -> ProjectedModel {
    ProjectedModel { width: 16, height: 8, largest_inverse_depth: 1.0, ..ProjectedModel::default() }
}

/// Adds an item with the inverse depth `a (X - u0) + c`, u0 = 8, and triangles of clip corners.
fn add_item(view: &mut ProjectedModel, a: f32, c: f32, triangles: &[[[f32; 3]; 3]]) {
    let item = view.items.len() as u32;
    let inverse_depth = InverseDepth { a, b: 0.0, c, u0: 8.0, v0: 4.0 };
    let bounds = PixelRect::of_size(view.width, view.height);
    view.items.push(Item {
        face: FaceId(item),
        triangle: None,
        inverse_depth,
        back: false,
        bounds,
        see_through: false,
    });
    view.corners.extend_from_slice(triangles);
    view.triangle_items.extend(triangles.iter().map(|_| item));
}

/// Adds an upright rectangle of whole pixels `[x0, x1) x [y0, y1)` at one depth.
fn add_rectangle(view: &mut ProjectedModel, depth: f32, [x0, y0, x1, y1]: [f32; 4]) {
    let corner = |x: f32, y: f32| [(x / 8.0 - 1.0) * depth, (1.0 - y / 4.0) * depth, depth];
    let [a, b, c, d] = [corner(x0, y0), corner(x0, y1), corner(x1, y1), corner(x1, y0)];
    add_item(view, 0.0, 1.0 / depth, &[[a, b, c], [a, c, d]]);
}

fn draw(view: &ProjectedModel) -> Fragments {
    SoftwareRasteriser.fragments(view, TOLERANCE, &Task::silent()).expect("it is not stopped")
}

fn layers(view: &ProjectedModel) -> StencilLayers {
    let working = vec![true; view.items.len()];
    SoftwareRasteriser.stencil_peeling(view, TOLERANCE, &working, &Task::silent()).expect("it is not stopped")
}

fn entries(fragments: &Fragments, x: u32, y: u32) -> &[u32] {
    let lists = &fragments.lists;
    let band = lists.bands.iter().find(|b| (b.y0..b.y1).contains(&y)).expect("bands leave no gaps");
    lists.pixel(band, x, y)
}

#[test]
fn a_rectangle_covers_its_pixels_once_each() {
    let mut view = empty_view();
    add_rectangle(&mut view, 2.0, [3.0, 1.0, 10.0, 6.0]);
    let drawn = draw(&view);
    for (x, y) in (0..8).flat_map(|y| (0..16).map(move |x| (x, y))) {
        let expected: &[u32] = if (3..10).contains(&x) && (1..6).contains(&y) { &[VISIBLE] } else { &[] };
        assert_eq!(entries(&drawn, x, y), expected, "pixel {x}, {y}");
    }
}

#[test]
fn a_pixel_centre_on_a_common_edge_belongs_to_one_of_the_neighbours() {
    let mut view = empty_view();
    add_rectangle(&mut view, 1.0, [0.0, 0.5, 7.5, 4.5]);
    add_rectangle(&mut view, 1.0, [7.5, 0.5, 16.0, 4.5]);
    add_rectangle(&mut view, 1.0, [0.0, 4.5, 16.0, 8.0]);
    let drawn = draw(&view);
    assert_eq!(drawn.lists.len(), 16 * 8);
    assert_eq!(entries(&drawn, 7, 2), [1 | VISIBLE], "an edge on the left is inside");
    assert_eq!(entries(&drawn, 3, 4), [2 | VISIBLE], "an edge at the top is inside");
    assert_eq!(entries(&drawn, 3, 0), [VISIBLE], "the photo's own first row too");
}

#[test]
fn the_nearer_rectangle_occludes_the_farther_where_both_are() {
    let mut view = empty_view();
    add_rectangle(&mut view, 4.0, [0.0, 0.0, 10.0, 8.0]);
    add_rectangle(&mut view, 2.0, [8.0, 0.0, 16.0, 8.0]);
    let drawn = draw(&view);
    assert_eq!(drawn.presence, [Presence::Working, Presence::Working]);
    assert_eq!(drawn.occlusions, [Occlusion { front: 1, back: 0, px: 16 }]);
    assert_eq!(entries(&drawn, 9, 0), [0, 1 | VISIBLE]);
}

#[test]
fn a_covered_item_is_hidden_by_the_owner_of_its_first_pixel() {
    let mut view = empty_view();
    add_rectangle(&mut view, 4.0, [5.0, 3.0, 9.0, 6.0]);
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 16.0, 8.0]);
    add_rectangle(&mut view, 2.0, [4.0, 2.0, 7.0, 7.0]);
    add_rectangle(&mut view, 2.0, [20.0, 0.0, 30.0, 8.0]);
    let drawn = draw(&view);
    assert_eq!(drawn.presence[0], Presence::Hidden { x: 5, y: 3, by: 2 });
    assert_eq!(drawn.presence[1..3], [Presence::Working; 2]);
    assert_eq!(drawn.presence[3], Presence::Nowhere);
    assert!(drawn.occlusions.is_empty(), "what is outside the working set occludes nothing");
    assert_eq!(entries(&drawn, 5, 3), [1 | VISIBLE, 2 | VISIBLE], "coplanar items are both visible");
}

#[test]
fn a_ground_that_runs_behind_the_camera_covers_the_lower_half() {
    let mut view = empty_view();
    // y = -w/4 on the horizon's side at infinity: a plane one unit below the camera.
    let corner = |x: f32, depth: f32| [x, -1.0, depth];
    let [a, b, c, d] = [corner(-1e6, 1e4), corner(1e6, 1e4), corner(1e6, -1e4), corner(-1e6, -1e4)];
    add_item(&mut view, 0.0, 0.1, &[[a, b, c], [a, c, d]]);
    let drawn = draw(&view);
    let covered = |y| (0..16).filter(|&x| !entries(&drawn, x, y).is_empty()).count();
    assert_eq!((0..8).map(covered).collect::<Vec<_>>(), [0, 0, 0, 0, 16, 16, 16, 16]);
}

#[test]
fn what_lies_behind_the_camera_is_nowhere() {
    let mut view = empty_view();
    add_item(&mut view, 0.0, 1.0, &[[[-5.0, -5.0, -1.0], [5.0, -5.0, -1.0], [0.0, 5.0, -1.0]]]);
    assert_eq!(draw(&view).presence, [Presence::Nowhere]);
}

#[test]
fn crossing_items_occlude_each_other() {
    let mut view = empty_view();
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 16.0, 8.0]);
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 16.0, 8.0]);
    view.items[0].inverse_depth.a = 0.01;
    view.items[1].inverse_depth.a = -0.01;
    let pairs = draw(&view).occlusions;
    assert_eq!(pairs, [Occlusion { front: 0, back: 1, px: 64 }, Occlusion { front: 1, back: 0, px: 64 }]);
}

#[test]
fn exact_peeling_marks_what_lies_behind_and_forgives_on_request() {
    let mut view = empty_view();
    add_rectangle(&mut view, 4.0, [0.0, 0.0, 10.0, 8.0]);
    add_rectangle(&mut view, 2.0, [8.0, 0.0, 16.0, 8.0]);
    add_rectangle(&mut view, 8.0, [0.0, 0.0, 16.0, 8.0]);
    let round = |alive: [bool; 3], forgiven: &[(u32, u32)]| {
        SoftwareRasteriser.occluded(&view, TOLERANCE, &alive, forgiven).expect("it is not stopped")
    };
    assert_eq!(round([true; 3], &[]), [true, false, true]);
    assert_eq!(round([true; 3], &[(1, 0)]), [false, false, true]);
    assert_eq!(round([false, true, true], &[(1, 2)]), [false, false, false]);
}

#[test]
fn stencil_peeling_finds_the_order_of_a_staircase() {
    let mut view = empty_view();
    for step in 0..4 {
        add_rectangle(&mut view, 2.0 + step as f32, [step as f32 * 3.0, 0.0, step as f32 * 3.0 + 4.0, 8.0]);
    }
    let peeled = layers(&view);
    assert_eq!(peeled.layer, [Some(0), Some(1), Some(2), Some(3)]);
    assert_eq!((peeled.locked, peeled.passes), (0, 2 + 2 + 2 + 1));
}

#[test]
fn stencil_peeling_may_put_an_item_before_its_occluder() {
    let mut view = empty_view();
    // A hides Y, Y hides X, and where it does, Z lies behind both and is taken out in X's stead.
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 4.0, 8.0]); // A
    add_rectangle(&mut view, 4.0, [2.0, 0.0, 8.0, 8.0]); // Y
    add_rectangle(&mut view, 6.0, [6.0, 0.0, 12.0, 8.0]); // X
    add_rectangle(&mut view, 8.0, [6.0, 0.0, 12.0, 8.0]); // Z: wins every pixel of X
    assert_eq!(layers(&view).layer, [Some(0), Some(1), Some(0), Some(2)], "X stands before Y");
}

#[test]
fn stencil_peeling_locks_up_in_a_cycle() {
    let mut view = empty_view();
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 16.0, 8.0]);
    add_rectangle(&mut view, 2.0, [0.0, 0.0, 16.0, 8.0]);
    view.items[0].inverse_depth.a = 0.01;
    view.items[1].inverse_depth.a = -0.01;
    let peeled = layers(&view);
    assert_eq!((peeled.layer, peeled.locked), (vec![Some(0), Some(0)], 2));
}

#[test]
fn a_stopped_task_stops_the_drawing() {
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let stopped = SoftwareRasteriser.fragments(&empty_view(), TOLERANCE, &task);
    assert!(matches!(stopped, Err(quadratura_base::Error::Cancelled)));
}
