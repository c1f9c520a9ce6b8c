//! Image layers: nothing is lost, nothing stands before what hides it, and the stack gives the
//! photo back.

use std::collections::{BTreeMap, BTreeSet};

use quadratura::testing::layers::content::PixelSpan;
use quadratura::testing::layers::{BoxShape, Options, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{closed_form, random};
use rayon::prelude::*;

use crate::oracle::{Oracle, each_pixel};
use crate::random_scenes;
use crate::sorted::Case;

/// Image layers that need a pixel, and whether they show it.
type Stacked = BTreeMap<(u32, u32), BTreeMap<usize, bool>>;

fn stacked(case: &Case) -> Stacked {
    let mut stacked = Stacked::new();
    for (layer, content) in case.sorted.contents.iter().enumerate() {
        let pixels = |span: &PixelSpan| {
            (span.x0..span.x1).map({
                let y = span.y;
                move |x| (x, y)
            })
        };
        for pixel in content.needed.iter().flat_map(pixels) {
            let twice = stacked.entry(pixel).or_default().insert(layer, false);
            assert!(twice.is_none(), "{}: image layer {layer} needs {pixel:?} twice", case.name);
        }
        for pixel in content.visible.iter().flat_map(pixels) {
            let needed = stacked.get_mut(&pixel).and_then(|layers| layers.get_mut(&layer));
            *needed.expect("what is visible is needed") = true;
        }
    }
    stacked
}

/// Everything that must hold of the image layers of a result.
pub fn check(case: &Case) {
    rectangles_hold_their_elements(case);
    let expected = image_layers_by_pixel(case);
    assert!(stacked(case) == expected, "{}: the image layers hold something else", case.name);
    the_stack_gives_the_photo_back(case, &expected);
    the_leftovers_are_what_no_image_layer_shows(case);
}

/// Every patch lies in one rectangle, and that has the shape that was asked for.
fn rectangles_hold_their_elements(case: &Case) {
    let Case { name, options, sorted, .. } = case;
    let mut held = BTreeSet::new();
    for cluster in &sorted.clusters.list {
        if options.boxes == BoxShape::PowerOfTwo {
            assert!(cluster.rect.w.is_power_of_two() && cluster.rect.h.is_power_of_two(), "{name}");
        }
        for patch in &cluster.patches {
            assert_eq!(cluster.rect.union(&patch.bounds), cluster.rect, "{name}: a patch sticks out");
            assert!(held.insert((patch.element, patch.bounds.x, patch.bounds.y)), "{name}: twice");
        }
        let layers =
            cluster.patches.iter().map(|p| sorted.layers.elements[p.element.index()].visibility_layer);
        let layers: BTreeSet<u32> = layers.collect();
        assert!(!options.published || layers.len() == 1, "{name}: merged across visibility layers");
    }
    let elements: BTreeSet<_> = held.into_iter().map(|(element, ..)| element).collect();
    for (index, element) in sorted.layers.elements.iter().enumerate() {
        let textured = element.nodes.iter().any(|node| !sorted.leftovers.nodes[node.0 as usize]);
        let has_layer = elements.iter().any(|held| held.index() == index);
        assert_eq!(has_layer, textured, "{name}: element {index} and its image layer");
    }
    assert!(sorted.clusters.list.is_sorted_by_key(|cluster| cluster.order), "{name}");
}

/// The same table from the fragment lists: element by element, the patch that holds the pixel.
fn image_layers_by_pixel(case: &Case) -> Stacked {
    let oracle = Oracle::new(case);
    let mut stacked = Stacked::new();
    for ((x, y, _), fragments) in each_pixel(&case.fragments.lists).zip(oracle.elements_by_pixel()) {
        for (element, visible) in fragments {
            let holds = |layer: &usize| {
                case.sorted.clusters.list[*layer].patches.iter().any(|patch| {
                    let b = patch.bounds;
                    let inside =
                        (b.x..b.right()).contains(&(x as i32)) && (b.y..b.bottom()).contains(&(y as i32));
                    patch.element == element && inside
                })
            };
            let found: Vec<usize> = (0..case.sorted.clusters.list.len()).filter(holds).collect();
            assert_eq!(found.len(), 1, "{}: {found:?} hold element {element} at {x}, {y}", case.name);
            *stacked.entry((x, y)).or_default().entry(found[0]).or_default() |= visible;
        }
    }
    stacked
}

/// Every visible pixel is in an image layer or among the leftovers, which are drawn in front of all layers.
fn the_leftovers_are_what_no_image_layer_shows(case: &Case) {
    let oracle = Oracle::new(case);
    let lists = &case.fragments.lists;
    let expected: Vec<(u32, u32)> = each_pixel(lists)
        .zip(oracle.leftovers_by_pixel())
        .filter(|(_, left)| *left)
        .map(|((x, y, _), _)| (x, y))
        .collect();
    let spans = case.sorted.leftovers.spans.iter();
    let found: Vec<(u32, u32)> = spans.flat_map(|s| (s.x0..s.x1).map(move |x| (x, s.y))).collect();
    assert_eq!(found, expected, "{}: leftovers", case.name);
}

/// Back to front by `order`, the last image layer that needs a pixel shows it: nothing hidden, once
/// it is filled, is drawn over something visible, forgiven pairs excepted.
fn the_stack_gives_the_photo_back(case: &Case, stacked: &Stacked) {
    let order = |layer: usize| case.sorted.clusters.list[layer].order;
    let mut wrong: BTreeMap<(usize, usize), u32> = BTreeMap::new();
    for (pixel, layers) in stacked {
        let spans = &case.sorted.leftovers.spans;
        let is_left_over = spans.iter().any(|s| s.y == pixel.1 && (s.x0..s.x1).contains(&pixel.0));
        if is_left_over {
            continue;
        }
        assert!(layers.values().any(|visible| *visible), "{}: {pixel:?} is lost", case.name);
        for (&shown, _) in layers.iter().filter(|(_, visible)| **visible) {
            for (&hidden, _) in layers.iter().filter(|(_, visible)| !**visible) {
                if order(hidden) <= order(shown) {
                    *wrong.entry((shown, hidden)).or_default() += 1;
                }
            }
        }
    }
    let against: u32 = case.sorted.layers.against.iter().map(|pair| pair.2).sum();
    let px: u32 = wrong.values().sum();
    assert!(px <= against, "{}: {wrong:?} but {against} px were forgiven", case.name);
}

#[test]
fn image_layers_hold_what_their_elements_cover_in_an_order_that_gives_the_photo_back() {
    let mut scenes = closed_form::all();
    scenes.extend(random_scenes());
    scenes.par_iter().for_each(|scene| check(&Case::new(scene, &SoftwareRasteriser)));
}

#[test]
fn so_they_do_with_every_option() {
    let default = Options::default;
    let options = [
        Options { published: true, ..default() },
        Options { boxes: BoxShape::Exact, margin: 0, ..default() },
        Options { margin: 9, ..default() },
        Options { largest_side: 64, ..default() },
        Options { boxes: BoxShape::Exact, largest_side: 64, published: true, ..default() },
        Options { min_visible: 0, ..default() },
        Options { min_visible: 400, min_share: 0.3, ..default() },
        Options { min_visible: u32::MAX, min_share: 1.0, ..default() },
        Options { tolerated: 0.3, ..default() },
    ];
    (0..20_u64).into_par_iter().for_each(|seed| {
        for scene in [random::soup(4000 + seed, 16), random::boxes(4000 + seed, 6)] {
            for options in &options {
                check(&Case::with(&scene, &SoftwareRasteriser, options.clone()));
            }
        }
    });
}
