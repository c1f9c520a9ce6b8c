//! Tests of graphs of sub-objects: order, repetition, cycles, counts, bounds and limits.

use glam::{DAffine3, DMat3, DVec3};

use super::{draft, square};
use crate::{
    CurvePoint, Draft, Limb, MOST_LEVELS, Material, Mesh, Plant, PlantFlaw, Primitive, Shape, Use, assemble,
};
use quadratura_base::scene::synthetic::Rng;

fn shifted(x: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, 0.0, 0.0))
}

#[test]
fn children_come_before_those_that_use_them_and_what_nobody_uses_is_left_out() {
    let drafts = vec![
        draft("tree", Vec::new(), &[(2, shifted(1.0)), (2, shifted(2.0)), (1, shifted(0.0))]),
        draft("leaf", vec![square(Material::default())], &[]),
        draft("twig", vec![square(Material::default())], &[(1, shifted(3.0))]),
        draft("stone", vec![square(Material::default())], &[]),
    ];
    let plant = assemble(drafts, 0, DVec3::new(0.0, 2.0, 0.0), 0.5).unwrap();
    let names: Vec<&str> = plant.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!((names, plant.root, plant.up), (vec!["leaf", "twig", "tree"], 2, DVec3::Y));
    let counts = plant.whole().counts;
    // The tree has no polygons of its own, so it is no sub-object in the published counts.
    assert_eq!((counts.sub_objects, counts.polygons, counts.triangles, counts.levels), (5, 5, 10, 3));
}

#[test]
fn sub_objects_of_the_same_content_are_one_also_where_they_use_such() {
    let leaf = |name: &str| draft(name, vec![square(Material::default())], &[]);
    let twig = |name: &str, child: usize, x: f64| draft(name, Vec::new(), &[(child, shifted(x))]);
    let all = [(2, shifted(0.0)), (3, shifted(0.0)), (4, shifted(0.0)), (5, shifted(0.0))];
    let red = Material { reflected: [1.0, 0.0, 0.0], ..Material::default() };
    let drafts = vec![
        leaf("a"),
        leaf("b"),
        twig("c", 0, 1.0),
        twig("d", 1, 1.0),
        twig("e", 1, 1.5),
        draft("f", vec![square(red)], &[]),
        draft("tree", Vec::new(), &all),
    ];
    let plant = assemble(drafts, 6, DVec3::Z, 1.0).unwrap();
    let names: Vec<&str> = plant.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["a", "c", "e", "f", "tree"]);
    assert_eq!(plant.whole().uses.iter().map(|of| of.child).collect::<Vec<_>>(), [1, 1, 2, 3]);
    assert_eq!(plant.materials().len(), 2);
}

#[test]
fn a_sub_object_that_uses_itself_by_way_of_others_is_refused_with_the_way() {
    let drafts = vec![
        draft("tree", Vec::new(), &[(1, shifted(0.0))]),
        draft("branch", Vec::new(), &[(2, shifted(0.0))]),
        draft("twig", Vec::new(), &[(1, shifted(0.0))]),
    ];
    let flaw = assemble(drafts, 0, DVec3::Z, 1.0).unwrap_err();
    assert_eq!(flaw, PlantFlaw::Cycle(["branch", "twig", "branch"].map(String::from).to_vec()));
    assert_eq!(flaw.to_string(), r#"a sub-object uses itself: "branch" uses "twig" uses "branch""#);
}

/// A chain in which each sub-object uses the next one `fan` times.
fn chain(levels: usize, fan: usize) -> Vec<Draft> {
    let uses = |level: usize| vec![(level + 1, shifted(0.0)); if level + 1 < levels { fan } else { 0 }];
    (0..levels).map(|level| draft("link", vec![square(Material::default())], &uses(level))).collect()
}

#[test]
fn counts_of_a_plant_without_end_are_the_largest_number_and_levels_are_limited() {
    let plant = assemble(chain(MOST_LEVELS, 10), 0, DVec3::Z, 1.0).unwrap();
    let counts = plant.whole().counts;
    assert_eq!((counts.sub_objects, counts.triangles, counts.levels), (u64::MAX, u64::MAX, MOST_LEVELS));
    let flaw = assemble(chain(MOST_LEVELS + 1, 1), 0, DVec3::Z, 1.0).unwrap_err();
    assert_eq!(flaw, PlantFlaw::Levels(MOST_LEVELS + 1));
    let uses = assemble(chain(3, 600_000), 0, DVec3::Z, 1.0).unwrap_err();
    assert_eq!(uses, PlantFlaw::Uses(1_200_000));
}

#[test]
fn a_plant_that_grows_beyond_all_numbers_is_refused() {
    let large = DAffine3::from_scale(DVec3::splat(1e200));
    let drafts = vec![
        draft("tree", Vec::new(), &[(1, large)]),
        draft("branch", Vec::new(), &[(2, large)]),
        draft("leaf", vec![square(Material::default())], &[]),
    ];
    assert_eq!(assemble(drafts, 0, DVec3::Z, 1.0).unwrap_err(), PlantFlaw::Endless("tree".into()));
}

fn any_map(rng: &mut Rng) -> DAffine3 {
    let linear = DMat3::from_cols_array(&std::array::from_fn(|_| rng.between(-1.0, 1.0)));
    DAffine3::from_mat3_translation(linear, DVec3::new(rng.between(-3.0, 3.0), rng.unit(), rng.unit()))
}

fn any_limb(rng: &mut Rng) -> Primitive {
    let mut point = || {
        let position = DVec3::new(rng.between(-2.0, 2.0), rng.between(-2.0, 2.0), rng.between(-2.0, 2.0));
        CurvePoint { position, radius: rng.between(0.0, 0.5) }
    };
    let points = (0..7).map(|_| point()).collect();
    let limb = Limb { points, sides: 6, segments: 9, object_from_limb: any_map(rng) };
    Primitive { shape: Shape::Limb(limb), ..square(Material::default()) }
}

/// Calls `visit` with each corner of each instance, in the root's frame.
fn each_corner(plant: &Plant, object: usize, map: &DAffine3, visit: &mut impl FnMut(DVec3)) {
    for mesh in Mesh::of(&plant.objects[object]) {
        mesh.corners.iter().for_each(|corner| visit(map.transform_point3(corner.position)));
    }
    for Use { child, parent_from_child } in &plant.objects[object].uses {
        each_corner(plant, *child, &(*map * *parent_from_child), visit);
    }
}

#[test]
fn boxes_and_balls_hold_every_corner_of_every_instance() {
    let mut rng = Rng::new(11);
    for case in 0..60 {
        let mut drafts = vec![draft("leaf", vec![square(Material::default()), any_limb(&mut rng)], &[])];
        for index in 1..5 {
            let uses: Vec<_> =
                (0..3).map(|_| (rng.whole(0, index - 1) as usize, any_map(&mut rng))).collect();
            drafts.push(draft(&format!("{index}"), vec![any_limb(&mut rng)], &uses));
        }
        let plant = assemble(drafts, 4, DVec3::Z, 1.0).unwrap();
        let bounds = plant.whole().bounds;
        let mut farthest = 0.0f64;
        each_corner(&plant, plant.root, &DAffine3::IDENTITY, &mut |corner| {
            farthest = farthest.max(corner.distance(bounds.ball.middle));
            let (low, high) = (bounds.space.low - 1e-9, bounds.space.high + 1e-9);
            assert!(corner.cmpge(low).all() && corner.cmple(high).all(), "case {case}: {corner}");
        });
        assert!(farthest <= bounds.ball.radius, "case {case}: {farthest} of {}", bounds.ball.radius);
        // Balls in maps that stretch differently grow with each level: after four levels by a factor of up to 5 here.
        assert!(farthest > bounds.ball.radius / 8.0, "case {case}: {farthest} of {}", bounds.ball.radius);
    }
}
