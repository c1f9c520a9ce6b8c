//! Tests of generated plants.

use glam::DVec3;

use crate::{Counts, Limb, Plant, Primitive, Profile, Shape, Species, SubObject, Use, grow, largest_stretch};

const MAPLE: &str = include_str!("../../../examples/maple.json");
const OAK: &str = include_str!("../../../examples/oak.json");

fn species(text: &str) -> Species {
    let species: Species = serde_json::from_str(text).unwrap();
    species.check().unwrap();
    species
}

fn grown(text: &str, trees: u32) -> Plant {
    grow(&Species { trees, ..species(text) }).unwrap()
}

fn counts(plant: &Plant) -> [u64; 3] {
    let Counts { sub_objects, polygons, triangles, .. } = plant.whole().counts;
    [sub_objects, polygons, triangles]
}

#[test]
fn the_maple_the_oak_and_a_wood_have_the_numbers_of_the_published_ones() {
    let (maple, placed, oak) = (grown(MAPLE, 1), grown(MAPLE, 13), grown(OAK, 1));
    assert_eq!(counts(&maple), [73_547, 1_323_512, 2_536_144]);
    assert_eq!(counts(&placed), [956_111, 17_205_656, 32_969_872]);
    assert_eq!(counts(&oak), [50_608, 737_288, 1_393_576]);
    assert_eq!([&maple, &placed, &oak].map(|plant| plant.whole().counts.levels), [7, 8, 7]);
}

#[test]
fn each_level_of_the_maple_has_the_published_number_of_polygons() {
    let maple = grown(MAPLE, 1);
    let mut polygons: Vec<u64> = maple.objects.iter().map(|object| object.counts.polygons).collect();
    polygons.dedup();
    assert_eq!(polygons, [2, 56, 328, 1_848, 17_048, 120_168, 1_323_512]);
    assert!(maple.objects.len() <= 13, "one or two variants a level: {}", maple.objects.len());
    let limbs: u64 = 1_323_512 - 55_440 * 2;
    assert_eq!(limbs * 100 / 1_323_512, 91, "limbs are nearly 92 % of the polygons");
}

#[test]
fn one_seed_gives_one_tree_and_another_seed_another() {
    let maple = species(MAPLE);
    assert!(grow(&maple).unwrap() == grow(&maple).unwrap());
    assert!(grow(&maple).unwrap() != grow(&Species { seed: 2, ..maple }).unwrap());
}

#[test]
fn children_are_as_long_as_ratio_and_profile_say_and_a_golden_turn_apart() {
    let mut maple = species(MAPLE);
    // A thick trunk, so that none of its branches has to be shorter than they say.
    maple.levels[1].ratio = 0.3;
    maple.levels[0].wander = 0.0;
    maple.levels[1].spread = 0.0;
    let plant = grow(&maple).unwrap();
    let (height, bare, ratio) = (maple.height, maple.levels[0].bare, maple.levels[1].ratio);
    let mut turns = Vec::new();
    for (i, Use { parent_from_child, .. }) in plant.whole().uses.iter().enumerate() {
        let place = (i as f64 + 0.5) / 11.0;
        let length = height * ratio * Profile::Sphere.at(1.0 - place);
        // The largest stretch of a similarity loses half of the digits.
        assert!((largest_stretch(&parent_from_child.matrix3) / length - 1.0).abs() < 1e-6);
        // The trunk is straight; its curve's parameter runs nearly evenly along it.
        let share = parent_from_child.translation.z / height;
        assert!((share - (bare + (1.0 - bare) * place)).abs() < 0.01, "child {i} is at {share}");
        let direction = parent_from_child.matrix3.z_axis;
        let [low, high] = maple.levels[1].angle;
        let lean = low + (high - low) * place;
        assert!((direction.angle_between(DVec3::Z).to_degrees() - lean).abs() < 1e-6);
        turns.push(direction.y.atan2(direction.x).to_degrees());
    }
    for pair in turns.windows(2) {
        assert!(((pair[1] - pair[0]).rem_euclid(360.0) - 137.508).abs() < 1e-6, "{turns:?}");
    }
}

#[test]
fn the_radius_of_limbs_falls_as_their_length_to_the_power_of_1_2() {
    let maple = species(MAPLE);
    let plant = grow(&maple).unwrap();
    let radius = |polygons: u64| {
        let object = plant.objects.iter().find(|object| object.counts.polygons == polygons).unwrap();
        let Shape::Limb(limb) = &object.primitives[0].shape else { panic!("{}", object.name) };
        limb.points[0].radius
    };
    let mut length = maple.height;
    for (level, polygons) in [1_323_512, 120_168, 17_048, 1_848, 328, 56].into_iter().enumerate() {
        // Only the tree is in metres; all others have length 1.
        let in_metres = radius(polygons) * if level == 0 { 1.0 } else { length * maple.levels[level].ratio };
        length *= if level == 0 { 1.0 } else { maple.levels[level].ratio };
        let expected = maple.height * maple.girth * (length / maple.height).powf(1.2);
        assert!((in_metres / expected - 1.0).abs() < 1e-12, "level {level}: {in_metres} for {expected}");
    }
}

/// The limb of a sub-object, if it is one.
fn limb(object: &SubObject) -> Option<&Limb> {
    match &object.primitives[..] {
        [Primitive { shape: Shape::Limb(limb), .. }] => Some(limb),
        _ => None,
    }
}

#[test]
fn no_limb_is_thicker_at_its_foot_than_its_parent_is_there() {
    for text in [MAPLE, OAK] {
        let plant = grown(text, 1);
        let mut shares = Vec::new();
        for object in &plant.objects {
            let Some(parent) = limb(object) else { continue };
            let place = |at: DVec3| {
                let points = (0..=1000).map(|i| parent.along(f64::from(i) / 1000.0).0);
                points.min_by(|a, b| a.position.distance(at).total_cmp(&b.position.distance(at))).unwrap()
            };
            for Use { child, parent_from_child } in &object.uses {
                let Some(child) = limb(&plant.objects[*child]) else { continue };
                let radius = child.points[0].radius * largest_stretch(&parent_from_child.matrix3);
                shares.push(radius / place(parent_from_child.translation).radius);
            }
        }
        // Between the places on the curve that are tried the radius changes by less than a hundredth.
        assert!(shares.iter().all(|share| *share < 0.91), "{shares:?}");
        assert!(shares.iter().any(|share| *share > 0.89), "some limbs are as thick as they may be");
    }
}

#[test]
fn trees_of_a_wood_are_apart_on_the_ground() {
    let placed = grown(MAPLE, 13);
    let feet: Vec<DVec3> = placed.whole().uses.iter().map(|of| of.parent_from_child.translation).collect();
    assert_eq!(feet.len(), 13);
    for (i, a) in feet.iter().enumerate() {
        assert_eq!(a.z, 0.0);
        assert!(feet[..i].iter().all(|b| a.distance(*b) > 0.4 * species(MAPLE).height));
    }
}

#[test]
fn a_crown_has_its_shape_and_begins_above_the_ground() {
    let bounds = grown(MAPLE, 1).whole().bounds;
    let (low, high) = (bounds.space.low, bounds.space.high);
    // Boxes are larger than what they hold; a maple of 11 m is still no 30 m wide, and stands on the ground.
    assert!(high.z > 11.0 && high.z < 20.0 && (high - low).x < 30.0, "{low} {high}");
}

#[test]
fn numbers_out_of_range_are_named_by_their_path() {
    let bad = |change: &dyn Fn(&mut Species)| {
        let mut maple = species(MAPLE);
        change(&mut maple);
        maple.check().unwrap_err()
    };
    assert_eq!(bad(&|s| s.levels[2].ratio = 1.5).0, "levels[2].ratio");
    assert_eq!(bad(&|s| s.levels[1].angle[1] = f64::NAN).0, "levels[1].angle[1]");
    assert_eq!(bad(&|s| s.leaf.through[2] = 2.0).0, "leaf.through[2]");
    let (path, found) = bad(&|s| s.trees = 0);
    assert_eq!((path.as_str(), found.as_str()), ("trees", "0, expected a number from 1 to 10000"));
}
