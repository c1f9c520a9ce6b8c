//! Surfaces, where they are inherited, and pictures.

use super::*;
use crate::Material;

fn materials(text: &str) -> Vec<Material> {
    plant(text).materials().into_iter().map(|material| Material::clone(material)).collect()
}

#[test]
fn surfaces_reflect_their_diffuse_colour_and_leaves_let_light_through() {
    let found = materials(&format!(
        "surface bark ambient 1 1 1 diffuse .5 .25 0 specpow 9\nsurface leafy diffuse 0 1 0\n\
         surface blade bark translu .5 0 1 .5 3\n\
         triangle bark 0 0 0 1 0 0 0 1 0 triangle leafy 0 0 0 1 0 0 0 1 0 triangle blade 0 0 0 1 0 0 0 1 0\n\
         triangle diffuse 1 0 0 0 0 0 1 0 0 0 1 0 {TRIANGLE}"
    ));
    let seen: Vec<_> = found.iter().map(|m| (m.name.as_str(), m.reflected, m.through, m.leaf)).collect();
    assert_eq!(
        seen,
        [
            ("bark", [0.5, 0.25, 0.0], [0.0; 3], false),
            ("leafy", [0.0, 1.0, 0.0], [0.0; 3], true),
            ("blade", [0.5, 0.25, 0.0], [0.0, 0.5, 0.25], true),
            ("surface_1", [1.0, 0.0, 0.0], [0.0; 3], false),
            ("grey", [0.5; 3], [0.0; 3], false),
        ]
    );
}

#[test]
fn what_has_no_surface_takes_the_nearest_one_around_it() {
    let text = format!(
        "surface red diffuse 1 0 0 surface green diffuse 0 1 0 surface blue diffuse 0 0 1\n\
         name leaf list {TRIANGLE} triangle green 0 0 0 1 0 0 0 2 0 end\n\
         name twig list object leaf object blue leaf applysurf red object leaf triangle cursurf 0 0 0 1 0 0 0 3 0 end\n\
         object twig object blue twig object green twig translate 1 0 0\n"
    );
    let plant = plant(&text);
    let named = |name: &str| plant.objects.iter().filter(|object| object.name == name).count();
    // Grey, blue, red and green leaves; three twigs, of which the blue one has two equal leaves.
    assert_eq!((named("leaf"), named("twig")), (4, 3));
    let whole = plant.whole();
    let of_twig = |twig: usize| -> Vec<String> {
        let twig = &plant.objects[whole.uses[twig].child];
        twig.uses.iter().map(|of| plant.objects[of.child].primitives[0].material.name.clone()).collect()
    };
    assert_eq!(
        [of_twig(0), of_twig(1), of_twig(2)],
        [["grey", "blue", "red"], ["blue", "blue", "red"], ["green", "blue", "red"]]
    );
    assert_eq!(plant.objects[whole.uses[0].child].primitives[0].material.name, "red");
}

#[test]
fn a_list_that_has_a_name_has_its_surface_too() {
    let text =
        "surface red diffuse 1 0 0 name leaf list red triangle 0 0 0 1 0 0 0 1 0 end scale 2 2 2 object leaf";
    assert_eq!(materials(text)[0].name, "red");
}

#[test]
fn a_surface_and_an_object_may_have_one_name() {
    let plant = plant(
        "surface leaf diffuse 0 1 0 name leaf triangle 0 0 0 1 0 0 0 1 0 object leaf leaf object leaf translate 1 0 0",
    );
    let names: Vec<&str> =
        plant.objects.iter().filter_map(|o| o.primitives.first()).map(|p| p.material.name.as_str()).collect();
    assert_eq!(names, ["leaf", "grey"]);
}

#[test]
fn pictures_are_on_triangles_and_multiply_their_surface() {
    let files = Files::new(&[(
        "tree.ray",
        "surface dim diffuse .5 .5 .5\n\
         triangle 0 0 0 1 0 0 0 1 0 texture image leaf.png map uv\n\
         triangle dim 0 0 0 1 0 0 0 1 0 translate 0 0 1 texture image leaf.png component diffuse range 0 1 map uv scale 2 2 2\n\
         box 0 0 0 1 1 1 texture image no.png map uv\ntriangle 0 0 0 1 0 0 0 1 0 texture image no.png\n",
    )]);
    image::RgbaImage::new(2, 1).save(files.0.path().join("leaf.png")).unwrap();
    let (plant, notes) = files.noted().unwrap();
    let whole = plant.whole();
    let [first, second] = [0, 1].map(|i| whole.primitives[i].material.clone());
    assert_eq!((first.reflected, second.reflected), ([1.0; 3], [0.5; 3]));
    assert!(first.picture.is_some() && first.picture == second.picture && first.cutout.is_none());
    let textures: Vec<[f64; 2]> = corners(whole, 1).iter().map(|corner| corner.texture.to_array()).collect();
    assert_eq!(textures, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(corners(whole, 1)[0].position.z, 1.0);
    assert!(
        notes.iter().any(|note| note.contains("a texture has no effect") && note.contains("1 more")),
        "{notes:?}"
    );
}
