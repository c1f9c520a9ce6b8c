//! Tests of paint on plants: what is painted from one direction is seen from all, in all images.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::graph::painted_within;
use super::slabs::SlabPixels;
use super::*;
use crate::bounds::Ball;
use crate::tests::{draft, square};
use crate::{BakeOptions, ImageCopy, Material, Plant, PlantImages, assemble, bake, finest_copy};
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;

const GREEN: [f32; 3] = [0.1, 0.4, 0.1];
const RED: Vec3 = Vec3::new(0.6, 0.05, 0.04);
const OPTIONS: BakeOptions = BakeOptions { side: 32, least_side: 192, most_side: 192, ..BakeOptions::SLABS };

/// Five branches of 20 twigs of 300 leaves each, whose balls no two directions +-x, +-y show behind each other.
fn branchy() -> Plant {
    let mut rng = Rng::new(8);
    let mut in_ball = |child: usize, count: usize, size: f64| {
        let mut uses = Vec::new();
        while uses.len() < count {
            let at = DVec3::from_array([0.0; 3].map(|_: f64| rng.between(-1.0, 1.0)));
            if at.length() < 1.0 {
                let turn = DMat3::from_rotation_z(rng.between(0.0, 6.0));
                let linear = size * turn * DMat3::from_rotation_x(rng.between(0.0, 6.0));
                uses.push((child, DAffine3::from_mat3_translation(linear, at)));
            }
        }
        uses
    };
    let (twig, branch) = (in_ball(0, 300, 0.08), in_ball(1, 20, 0.3));
    let tree: Vec<_> = (0..5).map(|index| (2, DAffine3::from_translation(middle_of(index)))).collect();
    let leaf = Material { reflected: GREEN, through: [0.1, 0.3, 0.0], leaf: true, ..Material::default() };
    let drafts = vec![
        draft("leaf", vec![square(leaf)], &[]),
        draft("twig", Vec::new(), &twig),
        draft("branch", Vec::new(), &branch),
        draft("tree", Vec::new(), &tree),
    ];
    assemble(drafts, 3, DVec3::Z, 1.0).unwrap()
}

fn middle_of(branch: usize) -> DVec3 {
    let index = branch as f64;
    DVec3::new(3.4 * ((2 * branch) % 5) as f64, 3.4 * index, 0.2 * index)
}

/// The third branch, with all of its leaves.
const BRANCH: usize = 2;

fn in_branch(point: DVec3, slack: f64) -> bool {
    point.distance(middle_of(BRANCH)) < 1.42 + slack
}

fn srgb16(colour: Vec3, alpha: f32) -> [u16; 4] {
    let [r, g, b] =
        colour.to_array().map(|light| (65535.0 * srgb_from_linear(f64::from(light))).round() as u16);
    [r, g, b, (65535.0 * alpha).round() as u16]
}

/// Paints all texels of the images from +x in which something of the chosen points is, in one colour.
fn painted_from_x(
    plant: &Plant,
    copy: &ImageCopy,
    chosen: &dyn Fn(DVec3) -> bool,
    colour: [u16; 4],
) -> Vec<PaintedSlab> {
    let frame = SlabFrame::of(&plant.whole().bounds, copy, OPTIONS.slabs);
    let mut pixels: BTreeMap<usize, SlabPixels> = BTreeMap::new();
    for (point, _, (x, y), slab) in samples(&frame, &copy.views[0], 0) {
        if chosen(point) {
            let of_slab = pixels.entry(slab).or_default();
            if !of_slab.iter().any(|(u, v, _)| (*u, *v) == (x, y)) {
                of_slab.push((x, y, colour));
            }
        }
    }
    painted_slabs(&copy.views[0], &frame, 0, &pixels).into_values().map(|(slab, _)| slab).collect()
}

/// Returns the samples of a view: where each is, its colour, its texel and its slab.
fn samples(
    frame: &SlabFrame,
    view: &crate::MBuffer,
    direction: usize,
) -> Vec<(DVec3, Vec3, (u32, u32), usize)> {
    let mut all = Vec::new();
    let mut samples = view.samples.iter();
    for (pixel, count) in (0u32..).zip(&view.counts) {
        let (x, y) = (pixel % frame.side, pixel / frame.side);
        for sample in samples.by_ref().take(usize::from(*count)) {
            let depth = frame.depth(sample.depth);
            let at = frame.point(direction, [f64::from(x) + 0.5, f64::from(y) + 0.5], depth);
            all.push((at, sample.reflected(), (x, y), frame.slab(direction, depth)));
        }
    }
    all
}

fn field(documents: Vec<Vec<PaintedSlab>>, object: usize) -> BTreeMap<usize, Arc<PaintField>> {
    [(object, Arc::new(PaintField::new(documents)))].into()
}

fn finest(plant: &Plant) -> ImageCopy {
    finest_copy(plant, &OPTIONS, &Task::silent()).unwrap().unwrap()
}

/// Returns for each direction and copy of a sub-object's images the share of samples at chosen points that are red.
fn shares_of_red(
    plant: &Plant,
    images: &PlantImages,
    object: usize,
    chosen: &dyn Fn(DVec3) -> bool,
) -> Vec<f64> {
    let of = images.objects[object].as_ref().unwrap();
    let mut shares = Vec::new();
    for copy in &of.copies {
        let frame = SlabFrame::of(&plant.objects[object].bounds, copy, OPTIONS.slabs);
        for (direction, view) in copy.views.iter().enumerate() {
            let chosen = samples(&frame, view, direction).into_iter().filter(|(at, ..)| chosen(*at));
            let red: Vec<bool> = chosen.map(|(_, colour, ..)| colour.x > colour.y).collect();
            let count = red.iter().filter(|is_red| **is_red).count();
            shares.push(count as f64 / red.len().max(1) as f64);
        }
    }
    shares
}

#[test]
fn a_branch_reddened_from_one_side_is_red_from_all_in_all_copies_and_in_its_own_images_and_others_stay_green()
{
    let plant = branchy();
    let copy = finest(&plant);
    let paint = painted_from_x(&plant, &copy, &|at| in_branch(at, 0.0), srgb16(RED, 1.0));
    let PaintedPlant { plant: red, unpainted } = painted(&plant, plant.root, &field(vec![paint], plant.root));
    assert_eq!((unpainted, red.whole().counts), (0, plant.whole().counts));
    // One branch of five is of its own, with triangles for each of its twigs.
    let names: Vec<&str> = red.objects.iter().map(|object| &object.name[..]).collect();
    let count = |name: &str| names.iter().filter(|of| **of == name).count();
    assert_eq!((count("branch"), count("twig"), count("leaf")), (2, 21, 1), "{names:?}");
    let images = bake(&red, &OPTIONS, &Task::silent()).unwrap();
    let of_branch = shares_of_red(&red, &images, red.root, &|at| in_branch(at, -0.1));
    assert!(of_branch.iter().all(|share| *share > 0.97), "{of_branch:?}");
    let of_others = shares_of_red(&red, &images, red.root, &|at| !in_branch(at, 0.4));
    assert!(of_others.iter().all(|share| *share < 0.005), "{of_others:?}");
    let branches = (0..red.objects.len()).filter(|index| red.objects[*index].name == "branch");
    let mut shares: Vec<f64> = branches
        .map(|index| {
            let of = shares_of_red(&red, &images, index, &|_| true);
            of.iter().sum::<f64>() / of.len() as f64
        })
        .collect();
    shares.sort_by(f64::total_cmp);
    assert!(shares[0] < 0.01 && shares[1] > 0.95, "{shares:?}");
}

#[test]
fn a_texel_that_was_painted_shows_its_colour_in_the_next_images_and_texels_beside_it_stay() {
    let plant = branchy();
    let copy = finest(&plant);
    let half = |at: DVec3| in_branch(at, 0.0) && at.z > middle_of(BRANCH).z;
    let paint = painted_from_x(&plant, &copy, &half, srgb16(RED, 1.0));
    let after = painted(&plant, plant.root, &field(vec![paint.clone()], plant.root)).plant;
    let frame = SlabFrame::of(&plant.whole().bounds, &copy, OPTIONS.slabs);
    let again = finest(&after);
    assert_eq!((again.side, again.delta), (copy.side, copy.delta), "the same frame");
    let [old, new] = [&copy, &again].map(|copy| slab_pictures(&copy.views[0], &frame, 0));
    let (mut right, mut painted_count, mut kept, mut beside) = (0, 0, 0, 0);
    for (slab, (old, new)) in old.iter().zip(&new).enumerate() {
        for (pixel, (old, new)) in old.iter().zip(new).enumerate().filter(|(_, (old, _))| old[3] > 0) {
            let corner = frame.corner(0);
            let [x, y] = [pixel as u32 % frame.side, pixel as u32 / frame.side];
            let is_at = |point: &PaintPoint| {
                let at = SlabFrame::rotation(0) * point.at.as_dvec3();
                let column = (
                    ((at.x - corner[0]) / frame.delta).floor() as u32,
                    ((at.y - corner[1]) / frame.delta).floor() as u32,
                );
                column == (x, y) && !point.change.is_none()
            };
            let of_slab = paint.iter().find(|of| of.slab == slab);
            match of_slab.is_some_and(|of| of.points.iter().any(is_at)) {
                true => {
                    painted_count += 1;
                    right += usize::from(new[0] > 190 && new[1] < 90);
                }
                false => {
                    beside += 1;
                    kept += usize::from(old == new);
                }
            }
        }
    }
    assert!(painted_count > 100 && right as f64 > 0.95 * painted_count as f64, "{right} of {painted_count}");
    assert!(kept as f64 > 0.98 * beside as f64, "{kept} of {beside}");
}

#[test]
fn erased_texels_take_samples_away_from_all_sides_and_half_erased_ones_half_of_the_coverage() {
    let plant = branchy();
    let copy = finest(&plant);
    let frame = SlabFrame::of(&plant.whole().bounds, &copy, OPTIONS.slabs);
    let count = |images: &ImageCopy, direction: usize| {
        let samples = samples(&frame, &images.views[direction], direction);
        samples.into_iter().filter(|(at, ..)| in_branch(*at, -0.1)).count()
    };
    let coverage = |images: &ImageCopy| -> u32 {
        images.views[0].samples.iter().map(|sample| sample.mask.count_ones()).sum()
    };
    let with = |alpha: f32| {
        let mut paint = painted_from_x(&plant, &copy, &|at| in_branch(at, 0.0), srgb16(RED, alpha));
        // Relative to full coverage, so that all texels lose the same share.
        paint.iter_mut().flat_map(|slab| &mut slab.points).for_each(|point| {
            if !point.change.is_none() {
                point.change.alpha = alpha;
            }
        });
        finest(&painted(&plant, plant.root, &field(vec![paint], plant.root)).plant)
    };
    let (erased, half) = (with(0.0), with(0.5));
    for direction in 0..6 {
        let (before, after) = (count(&copy, direction), count(&erased, direction));
        assert!(before > 200 && (after as f64) < 0.04 * before as f64, "{direction}: {after} of {before}");
    }
    let [all, half, none] = [&copy, &half, &erased].map(coverage).map(f64::from);
    assert!(none < half && half < all, "{none} {half} {all}");
}

#[test]
fn paint_where_nothing_is_changes_nothing_and_is_kept() {
    let plant = branchy();
    let copy = finest(&plant);
    let frame = SlabFrame::of(&plant.whole().bounds, &copy, OPTIONS.slabs);
    let pixels = BTreeMap::from([(0, vec![(0, 0, [1, 2, 3, 65535]), (1, 0, [0, 0, 0, 0])])]);
    let (slab, tally) = painted_slabs(&copy.views[4], &frame, 4, &pixels).remove(&0).unwrap();
    assert_eq!(tally, SlabTally { beside: 2, ..SlabTally::default() });
    assert_eq!((slab.points.len(), slab.beside.len(), slab.beside[0].colour), (0, 2, [1, 2, 3, 65535]));
    assert!(PaintField::new(vec![vec![slab]]).is_empty());
}

#[test]
fn paint_on_a_sub_object_is_on_all_its_instances_and_none_becomes_one_of_its_own() {
    let plant = branchy();
    let branch = plant.objects.iter().position(|object| object.name == "branch").unwrap();
    let alone = painted(&plant, branch, &BTreeMap::new()).plant;
    assert_eq!(alone.whole().name, "branch");
    let copy = finest(&alone);
    let paint = painted_from_x(&alone, &copy, &|_| true, srgb16(RED, 1.0));
    let after = painted(&plant, plant.root, &field(vec![paint], branch)).plant;
    assert_eq!(after.objects.iter().filter(|object| object.name == "branch").count(), 1);
    let images = bake(&after, &OPTIONS, &Task::silent()).unwrap();
    let shares = shares_of_red(&after, &images, after.root, &|_| true);
    assert!(shares.iter().all(|share| *share > 0.95), "{shares:?}");
}

#[test]
fn a_second_file_changes_what_the_first_one_shows() {
    let plant = branchy();
    let copy = finest(&plant);
    let all = |colour: Vec3, from: Vec3| {
        let mut paint = painted_from_x(&plant, &copy, &|at| in_branch(at, 0.0), srgb16(colour, 1.0));
        let change = Change::of_colour(from, colour);
        paint
            .iter_mut()
            .flat_map(|slab| &mut slab.points)
            .filter(|point| !point.change.is_none())
            .for_each(|point| point.change = change);
        paint
    };
    let blue = Vec3::new(0.05, 0.1, 0.7);
    let field = PaintField::new(vec![all(RED, Vec3::from_array(GREEN)), all(blue, RED)]);
    let point = field
        .documents()
        .next()
        .unwrap()
        .next()
        .unwrap()
        .points
        .iter()
        .find(|point| !point.change.is_none())
        .unwrap()
        .at;
    let change = field.at(point.as_dvec3(), true);
    assert!(change.reflected(Vec3::from_array(GREEN)).abs_diff_eq(blue, 1e-4));
    assert!(field.touches(&Ball { middle: point.as_dvec3(), radius: 1e-3 }));
    assert!(!field.touches(&Ball { middle: middle_of(0), radius: 0.5 }));
}

#[test]
fn what_would_make_a_plant_too_large_keeps_its_colours_and_is_counted() {
    let plant = branchy();
    let copy = finest(&plant);
    let paint = painted_from_x(&plant, &copy, &|at| in_branch(at, 0.0), srgb16(RED, 1.0));
    let within = painted_within(&plant, plant.root, &field(vec![paint], plant.root), 3000);
    // Ten twigs of 300 leaves have room, and the others do not.
    assert_eq!(within.unpainted, 3000);
    assert_eq!(within.plant.objects.iter().filter(|object| object.name == "twig").count(), 11);
}

#[test]
fn what_paint_reaches_keeps_all_its_polygons() {
    let plant = crate::tests::layered::branch();
    let copy = finest(&plant);
    let paint = painted_from_x(&plant, &copy, &|at| at.z > 0.5, srgb16(RED, 1.0));
    let red = painted(&plant, plant.root, &field(vec![paint], plant.root)).plant;
    let levels = |reached: bool| {
        let of = red.objects.iter().filter(move |object| object.paint.is_empty() != reached);
        of.filter(|object| object.primitives.len() > 1).map(|object| object.detail.count())
    };
    assert!(levels(true).count() > 0 && levels(true).all(|count| count == 1));
    assert!(plant.whole().detail.count() > 1 && levels(false).all(|count| count > 1));
}
