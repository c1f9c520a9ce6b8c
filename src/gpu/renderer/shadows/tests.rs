//! Shadows of trees on faces: in closed form, against the CPU reference, and where there must be none.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::left_out::on_adapter;
use crate::renderer::tests::cancelled_before_drawing;
use crate::{Gpu, Renderer, TileStore};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Model;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::task::Task;
use quadratura_foliage::synthetic::{bushy, plant_of};
use quadratura_foliage::{
    CastShadows, Material, OutdoorLight, PlacedSpecies, PlacedTrees, Plant, Tree, left_in_shadow,
};
use quadratura_projection::TextureOptions;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::one_photo;
use quadratura_projection::pyramid::PyramidOptions;
use quadratura_projection::relief::Relief;
use quadratura_projection::twin::ReferenceRenderer;
use quadratura_projection::{Gains, LayerTextureId, LayerTexturePixels, Renders, Sources, TREE, Texels};
use quadratura_view::{Picture, Quality, Shot, TreeMethod};

/// The side of the photo, in pixels.
const SIDE: u32 = 64;
/// The colour of everything in it, in sRGB.
const COLOUR: [u8; 3] = [220, 200, 180];

/// A photo of one colour.
struct Plain;

impl Texels for Plain {
    fn layer_texture(&self, _: LayerTextureId) -> Result<LayerTexturePixels> {
        let [r, g, b] = COLOUR;
        let count = (SIDE * SIDE) as usize;
        let rgba = [r, g, b, 255].repeat(count);
        Ok(LayerTexturePixels {
            rect: PixelRect::of_size(SIDE, SIDE),
            rgba,
            needed: vec![1; count],
            matte: None,
        })
    }
}

/// A model whose faces one photo from above shows, from whichever side they are seen, and what draws it.
struct Bench {
    gpu: Gpu,
    model: Arc<Model>,
    sources: Arc<Sources>,
}

impl Bench {
    /// A ground of 24 x 24 at z = 0, and what is built on it; `None` without an adapter.
    fn new(build: impl Fn(&mut Modeller)) -> Option<Self> {
        let gpu = on_adapter(Gpu::headless())?;
        let mut model = Modeller::new();
        model.object("ground").quad(DVec3::new(-12.0, -12.0, 0.0), 24.0 * DVec3::X, 24.0 * DVec3::Y);
        build(&mut model);
        let model = model.finish();
        let pose = look_at(DVec3::new(0.0, -0.5, 22.0), DVec3::ZERO);
        let sources = one_photo(centred(SIDE, SIDE, 40.0), pose, model.faces.len());
        Some(Self { gpu, model, sources: sources.into() })
    }

    fn renderer(&self, placed: Option<&PlacedTrees>) -> Renderer {
        let tiles =
            TileStore::new(&self.gpu, &self.sources, Arc::new(Plain), TextureOptions::default()).unwrap();
        let (model, sources) = (self.model.clone(), self.sources.clone());
        let mut renderer =
            Renderer::new(&self.gpu, model, sources, Gains::none(1), &Relief::default(), tiles).unwrap();
        renderer.set_trees(placed.cloned().map(Arc::new)).unwrap();
        renderer
    }

    fn picture(&self, placed: Option<&PlacedTrees>, shot: &Shot) -> Picture {
        self.renderer(placed).picture(shot, &Task::silent()).unwrap()
    }

    /// Returns the pixels at whose centres a view shows a face, each with the point of the face and its normal, which looks to
    /// the viewer.
    fn points(&self, placed: &PlacedTrees, shot: &Shot) -> Vec<(usize, DVec3, DVec3)> {
        let numbers = self.renderer(Some(placed)).faces(shot, &Task::silent()).unwrap();
        let eye = shot.viewpoint();
        let point = |(at, number): (usize, &u32)| {
            let face = number.checked_sub(1).filter(|_| number & TREE == 0)?;
            let plane = self.model.faces[face as usize].plane;
            let (x, y) = (at as u32 % shot.camera.width, at as u32 / shot.camera.width);
            let px = glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let ray = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
            let depth = -plane.signed_distance(eye) / plane.normal.dot(ray);
            let normal = if plane.normal.dot(ray) > 0.0 { -plane.normal } else { plane.normal };
            Some((at, eye + depth * ray, normal))
        };
        numbers.iter().enumerate().filter_map(point).collect()
    }
}

/// A sun at 45 degrees in the direction of x, and a sky.
fn light() -> OutdoorLight {
    OutdoorLight {
        towards_sun: DVec3::new(1.0, 0.0, 1.0).normalize(),
        up: DVec3::Z,
        sun: Vec3::new(1.0, 0.8, 0.5),
        sky: Vec3::new(0.3, 0.3, 0.4),
        ground: Vec3::splat(0.1),
    }
}

fn placed(plant: Plant, world_from_plant: DAffine3, casts: bool) -> PlacedTrees {
    let tree = Tree {
        number: 0,
        name: "tree".into(),
        species: 0,
        world_from_plant,
        tint: Vec3::ONE,
        casts,
        ratios: Arc::default(),
        sunlit: None,
    };
    let species =
        vec![PlacedSpecies { plant: Arc::new(plant), unpainted: None, images: None, openness: None }];
    PlacedTrees { species, trees: vec![tree], light: light() }
}

/// A level square leaf of side 2, four above the origin.
fn leaf(casts: bool) -> PlacedTrees {
    let material = Material { leaf: true, ..Material::default() };
    placed(plant_of(material), DAffine3::from_translation(4.0 * DVec3::Z), casts)
}

fn from(eye: DVec3, quality: Quality) -> Shot {
    Shot { quality, ..Shot::new(centred(200, 150, 170.0), look_at(eye, DVec3::new(-3.0, 0.0, 0.0))) }
}

/// Returns how much linear light of a pixel is left.
fn left(with: &Picture, without: &Picture, at: usize) -> Vec3 {
    let light = |picture: &Picture| {
        let [r, g, b, _] = picture.pixels()[at];
        DVec3::from_array([r, g, b].map(|byte| linear_of_srgb(f64::from(byte) / 255.0))).as_vec3()
    };
    light(with) / light(without)
}

#[test]
fn a_square_leaf_darkens_just_its_shadow_on_the_ground_and_as_much_as_sky_and_sun_say() {
    let Some(bench) = Bench::new(|_| {}) else { return };
    for (eye, quality, trees) in [
        (DVec3::new(-2.0, -9.0, 8.0), Quality::Preview, TreeMethod::Flakes),
        (DVec3::new(-8.0, 6.0, 5.0), Quality::Final, TreeMethod::Polygons),
    ] {
        let shot = Shot { trees, ..from(eye, quality) };
        let placed = leaf(true);
        let (with, without) = (bench.picture(Some(&placed), &shot), bench.picture(None, &shot));
        let expected = left_in_shadow(&placed.light, DVec3::Z, 1.0, 1.0);
        let (mut dark, mut bright) = (0, 0);
        for (at, point, _) in bench.points(&placed, &shot) {
            // The leaf's middle comes to x = -4; how far the point is beyond the shadow's border.
            let beyond = ((point.x + 4.0).abs() - 1.0).max(point.y.abs() - 1.0);
            // The penumbra is 5 cm wide, and a pixel shows up to 20 cm of the ground.
            if beyond < -0.2 {
                let left = left(&with, &without, at);
                // A step of 8 bits is up to 2 % of dark light.
                assert!((left - expected).abs().max_element() < 0.02, "{left}, not {expected}, at {point}");
                dark += 1;
            } else if beyond > 0.3 && with.pixels()[at] != without.pixels()[at] {
                // A final picture's pixel beside the leaf shows some of it.
                assert!(quality == Quality::Final, "{point}");
            } else if beyond > 0.3 {
                bright += 1;
            }
        }
        assert!(dark > 300 && bright > 10_000, "{dark} and {bright} pixels");
    }
}

#[test]
fn nothing_is_darkened_behind_a_wall_nor_what_looks_away_from_the_sun() {
    let Some(bench) = Bench::new(|model| {
        // Where the leaf's shadow comes down.
        model.object("wall").quad(DVec3::new(-3.0, -3.0, 0.0), 6.0 * DVec3::Y, 5.0 * DVec3::Z);
    }) else {
        return;
    };
    let placed = leaf(true);
    let changed = |eye: DVec3, quality: Quality| {
        let shot = from(eye, quality);
        let (with, without) = (bench.picture(Some(&placed), &shot), bench.picture(None, &shot));
        let points = bench.points(&placed, &shot).into_iter();
        let changed = points.filter(|(at, ..)| with.pixels()[*at] != without.pixels()[*at]);
        changed.map(|(_, point, _)| point).collect::<Vec<DVec3>>()
    };
    // From behind: the wall's dark side, and the ground in its shadow.
    let behind = changed(DVec3::new(-10.0, -2.0, 1.5), Quality::Preview);
    // At its foot the wall is as near to the sun as the ground, within two pixels of the map, which are as large as the picture's.
    let at_foot = |point: &DVec3| point.z < 1e-6 && (point.x + 3.0).abs() < 0.15;
    assert!(behind.iter().all(at_foot), "{behind:?}");
    // From before: the leaf's shadow on the wall alone, from z = 0 to 2.
    let found = changed(DVec3::new(6.0, -7.0, 3.0), Quality::Preview);
    assert!(found.len() > 300, "{} pixels", found.len());
    for point in found {
        let is_in_shadow = point.z < 2.2 && point.y.abs() < 1.2 && (point.x + 3.0).abs() < 0.2;
        assert!(is_in_shadow, "{point}");
    }
}

#[test]
fn without_trees_that_cast_pictures_have_the_same_bytes() {
    let Some(bench) = Bench::new(|_| {}) else { return };
    let shot = from(DVec3::new(-2.0, -9.0, 8.0), Quality::Final);
    let bare = bench.picture(None, &shot);
    let none = Shot { trees: TreeMethod::None, ..shot.clone() };
    assert!(bench.picture(Some(&leaf(true)), &none) == bare, "nothing of trees");
    let mut far = leaf(true);
    far.trees[0].world_from_plant.translation = DVec3::new(0.0, -400.0, 4.0);
    assert!(bench.picture(Some(&far), &shot) == bare, "behind the camera");
    // One that casts none stands there, and the ground is as it was.
    let (with, placed) = (bench.picture(Some(&leaf(false)), &shot), leaf(false));
    for (at, point, _) in bench.points(&placed, &shot) {
        let is_beside = (point.x + 4.0).abs() < 1.5 && point.y.abs() < 1.5;
        assert!(!is_beside || with.pixels()[at] == bare.pixels()[at], "{point}");
    }
    // A renderer that drew shadows once draws none when the tree casts none any more.
    let mut renderer = bench.renderer(Some(&leaf(true)));
    let first = renderer.picture(&shot, &Task::silent()).unwrap();
    renderer.set_trees(Some(Arc::new(leaf(false)))).unwrap();
    assert!(first != with && renderer.picture(&shot, &Task::silent()).unwrap() == with);
}

/// A crown beside a wall, with a roof over some of its shadow.
fn crown() -> Option<(Bench, PlacedTrees)> {
    let bench = Bench::new(|model| {
        model.object("wall").quad(DVec3::new(-7.0, -6.0, 0.0), 12.0 * DVec3::Y, 4.0 * DVec3::Z);
        model.object("roof").quad(DVec3::new(-6.0, 0.0, 1.5), 3.0 * DVec3::X, 4.0 * DVec3::Y);
    })?;
    let place = DAffine3::from_mat3_translation(1.8 * DMat3::IDENTITY, DVec3::new(0.5, 0.3, 4.0));
    Some((bench, placed(bushy(), place, true)))
}

#[test]
fn shadows_of_a_crown_are_those_of_the_twin() {
    let Some((bench, placed)) = crown() else { return };
    let ball = placed.ball(&placed.trees[0]);
    let cast = CastShadows::new(&placed, &ball, &Task::silent()).unwrap();
    let (surface, towards_sun) = (ModelSurface::from_model(&bench.model), placed.light.towards_sun);
    let light_left = move |point: DVec3, normal: Option<DVec3>| {
        let start = point + 1e-4 * towards_sun;
        let sunlit = if surface.nearest(start, towards_sun).is_some() { 0.0 } else { 1.0 };
        cast.left(point, normal.unwrap_or(towards_sun), sunlit).as_dvec3().to_array()
    };
    let (model, sources) = (bench.model.clone(), bench.sources.clone());
    let options = PyramidOptions::default();
    let (gains, relief) = (Gains::none(1), Relief::default());
    let twin = ReferenceRenderer::new(model, sources, gains, relief, Arc::new(Plain), options);
    let (mut twin, mut shaded) = (twin.with_shadows(Arc::new(light_left)), 0);
    for eye in [DVec3::new(-2.0, -9.0, 8.0), DVec3::new(2.0, 8.0, 4.0), DVec3::new(-11.0, 1.0, 6.0)] {
        let shot = from(eye, Quality::Preview);
        let found = bench.picture(Some(&placed), &shot);
        let expected = twin.picture(&shot, &Task::silent()).unwrap();
        let (mut far, mut sum, mut all) = (0, 0.0, 0);
        let bare = bench.picture(None, &shot);
        for (at, ..) in bench.points(&placed, &shot) {
            let apart = found.pixels()[at][0].abs_diff(expected.pixels()[at][0]);
            all += 1;
            far += u32::from(apart > 16);
            sum += f64::from(found.pixels()[at][0]) - f64::from(expected.pixels()[at][0]);
            shaded += u32::from(expected.pixels()[at][0] + 8 < bare.pixels()[at][0]);
        }
        // The twin looks at 16 points of the sun, the shader at 16 lookups around the point; both are a little rough, and leaves
        // are finer than the map.
        assert!(far * 50 < all && (sum / f64::from(all)).abs() < 1.5, "from {eye}: {far} of {all}, {sum}");
    }
    assert!(shaded > 300, "{shaded} pixels of shadow");
}

#[test]
fn a_picture_that_is_drawn_in_bands_has_the_same_shadows() {
    let Some((bench, placed)) = crown() else { return };
    // So large that it is more than one band.
    let camera = centred(640, 480, 540.0);
    let shot = Shot { camera, ..from(DVec3::new(-2.0, -9.0, 8.0), Quality::Preview) };
    let mut renderer = bench.renderer(Some(&placed));
    let whole = renderer.picture(&shot, &Task::silent()).unwrap();
    let mut sliced = renderer.begin(&shot, &Task::silent()).unwrap();
    let mut bands = 1;
    while !renderer.advance(&mut sliced, &Task::silent()).unwrap() {
        bands += 1;
    }
    let sliced = sliced.picture();
    let differing = whole.pixels().iter().zip(sliced.pixels()).filter(|(a, b)| a != b).count();
    assert!(bands > 1 && differing * 1000 < whole.pixels().len(), "{bands} bands, {differing} pixels differ");
}

#[test]
fn shadows_drawn_in_slices_are_the_same_and_can_be_given_up() {
    let Some((bench, mut placed)) = crown() else { return };
    let Tree { world_from_plant, .. } = placed.trees[0];
    let beside = DAffine3::from_translation(DVec3::new(3.0, -2.5, 0.0)) * world_from_plant;
    placed.trees.push(Tree { number: 1, world_from_plant: beside, ..placed.trees[0].clone() });
    let [before, shot] =
        [DVec3::new(2.0, 8.0, 4.0), DVec3::new(-2.0, -9.0, 8.0)].map(|eye| from(eye, Quality::Preview));
    let expected = bench.picture(Some(&placed), &shot);
    let mut sliced = bench.renderer(Some(&placed));
    sliced.picture(&before, &Task::silent()).unwrap();
    // What is drawn comes in the smallest slices, as on a device that takes a minute for each sample.
    sliced.shadows.as_mut().unwrap().paces.iter_mut().for_each(|pace| pace.learn(1.0, 60.0));
    let given_up = sliced.picture(&shot, &cancelled_before_drawing());
    assert!(matches!(given_up, Err(Error::Cancelled)), "{:?}", given_up.err());
    assert_eq!(sliced.picture(&shot, &Task::silent()).unwrap(), expected);
    // One tree alone has another shadow.
    placed.trees.pop();
    assert!(bench.picture(Some(&placed), &shot) != expected);
}

/// How far apart two pictures are: the share of the pixels that differ by more than 8 of 255.
fn apart(a: &Picture, b: &Picture) -> f64 {
    let differs = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > 8);
    let count = a.pixels().iter().zip(b.pixels()).filter(|pair| differs(*pair)).count();
    count as f64 / a.pixels().len() as f64
}

#[test]
fn maps_serve_a_moving_view_while_they_hold_what_it_sees_and_others_only_where_they_are_the_same() {
    let Some((bench, mut placed)) = crown() else { return };
    // A row that is wider than the view, so that maps are of a part of it.
    let Tree { world_from_plant, .. } = placed.trees[0];
    let beside = |number: u32| {
        let apart = DVec3::new(6.0 * (f64::from(number) - 4.0), 0.0, 0.0);
        Tree {
            number,
            world_from_plant: DAffine3::from_translation(apart) * world_from_plant,
            ..placed.trees[0].clone()
        }
    };
    placed.trees = (0..9).map(beside).collect();
    let task = Task::silent();
    let plenty = Some(std::time::Duration::from_secs(3600));
    let moving = |x: f64| {
        let pose = look_at(DVec3::new(x, -9.0, 8.0), DVec3::new(x - 1.0, 0.0, 0.0));
        let shot = Shot { quality: Quality::Preview, ..Shot::new(centred(200, 150, 340.0), pose) };
        Shot { trees_within: plenty, ..shot }
    };
    let layers = |renderer: &Renderer| renderer.shadows.as_ref().unwrap().maps[0].as_ref().unwrap().layers;
    let mut renderer = bench.renderer(Some(&placed));
    renderer.picture(&moving(-2.0), &task).unwrap();
    let held = layers(&renderer);
    assert!(held.iter().flatten().count() > 0);
    let near_by = renderer.picture(&moving(-1.9), &task).unwrap();
    assert!(layers(&renderer) == held, "no map was drawn anew");
    let mut new = bench.renderer(Some(&placed));
    let expected = new.picture(&moving(-1.9), &task).unwrap();
    assert!(layers(&new) != held, "a new renderer has other maps");
    let without = bench.renderer(None).picture(&moving(-1.9), &task).unwrap();
    // The maps' pixels lie elsewhere, which is seen on the borders of what lies in the shade.
    let (found, shaded) = (apart(&near_by, &expected), apart(&without, &expected));
    assert!(
        found > 0.0 && 10.0 * found < shaded,
        "{found} of the pixels, where {shaded} are trees and their shadows"
    );
    // Pictures of views that do not move do not depend on those before them, of the same view even.
    let rests = Shot { trees_within: None, ..moving(-1.9) };
    let expected = bench.picture(Some(&placed), &rests);
    assert!(renderer.picture(&rests, &task).unwrap() == expected);
    assert!(layers(&renderer) != held);
    assert!(renderer.picture(&rests, &task).unwrap() == expected);
    // Far away.
    renderer.picture(&moving(-2.0), &task).unwrap();
    let held = layers(&renderer);
    renderer.picture(&moving(9.0), &task).unwrap();
    assert!(layers(&renderer) != held);
    // Trees that have moved have other shadows, and those that cast none have no maps.
    placed.trees.pop();
    renderer.set_trees(Some(placed.clone().into())).unwrap();
    assert!(layers(&renderer).iter().all(Option::is_none));
    placed.trees.iter_mut().for_each(|tree| tree.casts = false);
    renderer.set_trees(Some(placed.into())).unwrap();
    assert!(renderer.shadows.is_none());
}
