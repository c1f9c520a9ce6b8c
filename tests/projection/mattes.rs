//! See-through surfaces: the GPU's pictures against the twin's, a photo's own camera, alpha, and the order of the model.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use quadratura::error::Result;
use quadratura::task::Task;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::sources::{COVERED, FILLED};
use quadratura::testing::projection::{LayerTextureId, LayerTexturePixels, Renders, Sources, Texels};
use quadratura::testing::scene::impostor::Facing;
use quadratura::testing::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura::testing::scene::synthetic::{Modeller, Rng, Scene, random};
use quadratura::testing::scene::{FaceId, Model, Object, PhotoId, Site};
use quadratura::testing::view::hidden::{Culling, HiddenFaces};
use quadratura::testing::view::legend::{MATTE, colour_at, colour_of_number};
use quadratura::testing::view::{DisplayMode, Mode, Picture, Quality, Shot};

use crate::bench::{Bench, apart_over_grey as apart, renderer_of};
use crate::impostors::turning;
use crate::random_scenes::{bench, view};

/// Layer textures with mattes, and with a filling wherever a photo does not show its needed texels.
struct WithMattes {
    texels: Arc<dyn Texels>,
    /// For each layer texture what impostors cover in it, as quads in photo pixels; `None` where it has no matte.
    quads: Vec<Option<Vec<[DVec2; 4]>>>,
    /// The matte at a photo position, in 255ths, and whether an impostor covers it there.
    matte: fn(DVec2, bool) -> u8,
}

impl Texels for WithMattes {
    fn layer_texture(&self, id: LayerTextureId) -> Result<LayerTexturePixels> {
        let mut pixels = self.texels.layer_texture(id)?;
        let rect = pixels.rect;
        let positions = (rect.y..rect.bottom()).flat_map(|y| {
            (rect.x..rect.right()).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
        });
        let texels = pixels.rgba.as_chunks_mut::<4>().0.iter_mut().zip(&mut pixels.needed);
        for ((texel, needed), px) in texels.zip(positions.clone()) {
            if *needed & COVERED != 0 && texel[3] == 0 {
                let wave = |c: f64| (120.0 + 60.0 * ((px.x + 2.0 * px.y) / 19.0 + c).sin()) as u8;
                *texel = [wave(0.0), wave(1.0), wave(2.0), 255];
                *needed |= FILLED;
            }
        }
        if let Some(quads) = &self.quads[id.0 as usize] {
            let is_within = |px: DVec2| quads.iter().any(|quad| holds(quad, px));
            pixels.matte = Some(positions.map(|px| (self.matte)(px, is_within(px))).collect());
        }
        Ok(pixels)
    }
}

/// Nothing, all, and everything between, over some twenty pixels, on impostors; all elsewhere.
fn waves(px: DVec2, is_within: bool) -> u8 {
    if !is_within {
        return 255;
    }
    let wave = (px.x / 7.0 + 0.3 * px.y / 7.0).sin() + (px.y / 11.0 - 0.4 * px.x / 11.0).cos();
    (127.5 + 160.0 * wave).clamp(0.0, 255.0) as u8
}

/// Whether a convex quad contains a point, its outline included.
fn holds(quad: &[DVec2; 4], px: DVec2) -> bool {
    let side = |i: usize| (quad[(i + 1) % 4] - quad[i]).perp_dot(px - quad[i]);
    (0..4).all(|i| side(i) >= 0.0) || (0..4).all(|i| side(i) <= 0.0)
}

/// Gives all impostors these mattes in all photos.
fn put(bench: &mut Bench, matte: fn(DVec2, bool) -> u8) {
    let model = bench.site.model.clone();
    let sources = Arc::make_mut(&mut bench.sources);
    let mut quads = vec![None; sources.layer_textures.len()];
    for face in model.see_through_surfaces() {
        for server in sources.servers_of(face) {
            let photo = sources.photo(server.photo);
            let image = |corner: DVec3| photo.camera.image_from_camera(photo.pose.camera_from_world(corner));
            let of_texture = quads[server.layer_texture.0 as usize].get_or_insert_with(Vec::new);
            let Some(impostor) = model.impostor(face) else {
                // Of faces that do not turn, layers have mattes everywhere.
                let far = [[-1e6, -1e6], [1e6, -1e6], [1e6, 1e6], [-1e6, 1e6]].map(DVec2::from);
                of_texture.push(far);
                continue;
            };
            let corners = impostor.corners(&Facing::of_pose(&photo.pose));
            if let [Some(a), Some(b), Some(c), Some(d)] = corners.map(image) {
                of_texture.push([a, b, c, d]);
            }
        }
    }
    for (layer_texture, quads) in sources.layer_textures.iter_mut().zip(&quads) {
        layer_texture.see_through = quads.is_some();
    }
    bench.texels = Arc::new(WithMattes { texels: bench.texels.clone(), quads, matte });
}

/// Gives all impostors mattes from nothing to all, and fills what is hidden.
pub fn put_mattes(bench: &mut Bench) {
    put(bench, waves);
}

/// The faces through which one sees.
fn see_through(bench: &Bench) -> BTreeSet<FaceId> {
    let (model, sources) = (&bench.site.model, &bench.sources);
    let has_matte = |face: &FaceId| {
        let mut servers = sources.servers_of(*face).iter();
        servers.any(|server| sources.layer_texture(server.layer_texture).see_through)
    };
    model.see_through_surfaces().filter(has_matte).collect()
}

/// The faces in a pixel, from back to front: the opaque one, and the see-through ones in front of it.
fn faces_in(bench: &Bench, surface: &ModelSurface, shot: &Shot, px: DVec2) -> Vec<FaceId> {
    let through = see_through(bench);
    let hidden: HiddenFaces = through.iter().copied().chain(shot.hidden.iter()).collect();
    let (eye, ray) = (shot.viewpoint(), shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px));
    let culling = Culling { backs: shot.backs, hidden: &hidden };
    let opaque = surface.owner(eye, ray, 1e-4, culling);
    let reach = opaque.map_or(f64::INFINITY, |hit| hit.t);
    let all = Culling { hidden: &shot.hidden, ..culling };
    let before = surface.through(eye, ray, &through, all).into_iter().filter(|hit| hit.t <= reach);
    opaque.into_iter().chain(before).map(|hit| hit.face).collect()
}

/// A pixel's faces and those of its neighbours are the same: elsewhere final pictures, which have four samples a pixel,
/// show something else than the twin, which has one.
fn is_inside(faces: &[Vec<FaceId>], i: usize, width: usize) -> bool {
    let beside = |row: usize| [row.wrapping_sub(1), row, row.wrapping_add(1)];
    let around = [i.wrapping_sub(width), i, i + width].into_iter().flat_map(beside);
    around.into_iter().all(|other| faces.get(other) == Some(&faces[i]))
}

fn stacks(bench: &Bench, shot: &Shot) -> Vec<Vec<FaceId>> {
    let surface = ModelSurface::from_model(&bench.site.model).with_backs(&bench.site.model, &bench.sources);
    let (width, height) = (shot.camera.width, shot.camera.height);
    let at = |i: u32| DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
    (0..width * height).map(|i| faces_in(bench, &surface, shot, at(i))).collect()
}

/// How far pictures are from their twins.
#[derive(Debug, Default)]
struct Difference {
    /// Pixels away from outlines, those that see-through faces cover, those in which two or more of them lie in front of each
    /// other, and those with an alpha between 0 and 1.
    inside: f64,
    through: f64,
    several: f64,
    partial: f64,
    /// Those that differ by more than three steps, and the sum of differences.
    far: f64,
    sum: f64,
}

fn compare(bench: &Bench, shot: &Shot, all: &mut Difference) {
    let (found, expected) = {
        let (mut gpu, mut twin) = (bench.renderer(&Relief::default()), bench.twin(&Relief::default()));
        (gpu.picture(shot, &Task::silent()).unwrap(), twin.picture(shot, &Task::silent()).unwrap())
    };
    let (faces, through) = (stacks(bench, shot), see_through(bench));
    for i in (0..faces.len()).filter(|i| is_inside(&faces, *i, shot.camera.width as usize)) {
        let (a, b) = (&found.pixels()[i], &expected.pixels()[i]);
        let count = faces[i].iter().filter(|face| through.contains(face)).count();
        all.inside += 1.0;
        all.through += f64::from(u8::from(count > 0));
        all.several += f64::from(u8::from(count > 1));
        all.partial += f64::from(u8::from(b[3] % 255 != 0));
        all.far += f64::from(u8::from(apart(a, b) > 3.0));
        all.sum += apart(a, b);
    }
}

/// The scene in which some objects turn, and others are declared see-through as they are modelled.
fn fenced(scene: Scene) -> Scene {
    let mut scene = turning(scene);
    let model = Arc::unwrap_or_clone(scene.model);
    let names: Vec<String> = model.objects.iter().map(|object| object.name.clone()).collect();
    let is_one =
        |object: &Object| names.iter().position(|name| *name == object.name).is_some_and(|i| i % 3 < 2);
    scene.model = Arc::new(model.with_see_through(is_one));
    scene
}

#[test]
fn the_gpu_and_its_twin_see_through_faces_that_do_not_turn_alike() {
    compare_all((64..=65).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]).map(fenced));
}

#[test]
fn the_gpu_and_its_twin_see_through_crossing_impostors_alike() {
    compare_all((61..=63).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]).map(turning));
}

fn compare_all(scenes: impl Iterator<Item = Scene>) {
    let mut all = [Difference::default(), Difference::default()];
    for (seed, scene) in (1..).zip(scenes) {
        let mut rng = Rng::new(seed);
        let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
        bench.pin(0.2, &mut rng);
        put_mattes(&mut bench);
        for mode in Mode::ALL {
            for (all, quality) in all.iter_mut().zip([Quality::Preview, Quality::Final]) {
                let mut shot = view(&scene, &mut rng);
                (shot.blend.mode, shot.quality, shot.surroundings) = (mode, quality, seed % 2 == 0);
                compare(&bench, &shot, all);
            }
        }
    }
    let [preview, last] = &all;
    println!("preview: {preview:?}\nfinal: {last:?}");
    for all in &all {
        assert!(all.through > 0.2 * all.inside && all.several > 0.02 * all.inside, "{all:?}");
        assert!(all.partial > 1000.0, "{all:?}");
    }
    assert!(last.far < 2e-3 * last.inside && last.sum < 0.9 * last.inside, "final: {last:?}");
    assert!(
        preview.far < 5e-2 * preview.inside && preview.sum < 2.5 * preview.inside,
        "preview: {preview:?}"
    );
}

#[test]
fn faces_that_are_seen_are_those_behind_a_see_through_one_where_nothing_of_it_is_there() {
    let (mut all, mut flipped, mut through) = (0, 0, 0);
    for (seed, scene) in (1..).zip([turning(random::boxes(62, 8)), fenced(random::soup(64, 24))]) {
        let mut rng = Rng::new(seed);
        let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
        put_mattes(&mut bench);
        let (mut gpu, mut twin) = (bench.renderer(&Relief::default()), bench.twin(&Relief::default()));
        for quality in [Quality::Preview, Quality::Final] {
            let shot = Shot { quality, ..view(&scene, &mut rng) };
            let task = Task::silent();
            // After the picture of the view its tables serve again, and after another view they do not.
            gpu.picture(&shot, &task).unwrap();
            let first = gpu.seen_faces(&shot, &task).unwrap();
            gpu.seen_faces(&view(&scene, &mut rng), &task).unwrap();
            let seen = gpu.seen_faces(&shot, &task).unwrap();
            // Tiles may lie elsewhere by then, and graphics adapters filter with weights of 8 bits: where a matte is just a half, the face
            // may be seen or not.
            let others = seen.iter().zip(&first).filter(|(seen, first)| seen != first).count();
            assert!(others * 1000 < seen.len(), "{others}, whether or not the picture was drawn before");
            let (expected, nearest) =
                (twin.seen_faces(&shot, &task).unwrap(), gpu.faces(&shot, &task).unwrap());
            let (stacks, width) = (stacks(&bench, &shot), shot.camera.width as usize);
            for i in (0..stacks.len()).filter(|i| is_inside(&stacks, *i, width)) {
                all += 1;
                flipped += u32::from(seen[i] != expected[i]);
                through += u32::from(seen[i] != nearest[i]);
            }
        }
    }
    println!("of {all} pixels {flipped} differ; {through} are seen through");
    // Where a matte is about 1/32, rounding decides: its waves cross that on a few of a hundred pixels.
    assert!(through > 500 && flipped * 50 < all, "{through}, {flipped} of {all}");
}

#[test]
fn a_photos_own_camera_shows_its_layers_laid_over_each_other() {
    let (scene, mut rng) = (turning(random::boxes(64, 8)), Rng::new(4));
    let Some(mut bench) = bench(scene, &mut rng) else { return };
    put_mattes(&mut bench);
    let (mut compared, mut partial) = (0, 0);
    for photo in 0..3 {
        let shot = bench.own(photo);
        let picture = bench.renderer(&Relief::default()).picture(&shot, &Task::silent()).unwrap();
        let (faces, width) = (stacks(&bench, &shot), shot.camera.width as usize);
        for i in (0..faces.len()).filter(|i| is_inside(&faces, *i, width)) {
            let (x, y) = ((i % width) as i32, (i / width) as i32);
            let Some((expected, is_partial)) = laid(&bench, PhotoId(photo as u32), &faces[i], [x, y]) else {
                continue;
            };
            compared += 1;
            partial += u32::from(is_partial);
            // Where every matte is 0 or 1 it is the photo's own byte. Elsewhere the product of colour and matte and each
            // layer over the other are rounded to 8 bits.
            let most = if is_partial { 3.0 } else { 1.0 };
            let found = &picture.pixels()[i];
            assert!(apart(found, &expected) <= most, "photo {photo}, {x}, {y}: {found:?}, {expected:?}");
        }
    }
    println!("{compared} pixels, of which {partial} are partly seen through");
    assert!(compared > 3000 && partial > 300, "{compared}, {partial}");
}

/// The layers of a photo at a pixel, from back to front over each other, and whether one sees partly through one of them;
/// `None` where one of them is not known or nothing opaque is behind.
fn laid(bench: &Bench, photo: PhotoId, faces: &[FaceId], [x, y]: [i32; 2]) -> Option<([u8; 4], bool)> {
    let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let (mut light, mut is_partial) = ([0.0; 3], false);
    for (depth, face) in faces.iter().enumerate() {
        let mut servers = bench.sources.servers_of(*face).iter();
        let server = servers.find(|s| s.photo == photo && !s.back && s.domain.holds(px))?;
        let pixels = bench.texels.layer_texture(server.layer_texture).unwrap();
        let at = pixels.rect.index(x, y)?;
        let [r, g, b, confidence] = pixels.rgba.as_chunks::<4>().0[at];
        let matte = pixels.matte.as_ref().map_or(255, |matte| matte[at]);
        if confidence == 0 || (depth == 0 && matte < 255) {
            return None;
        }
        is_partial |= matte % 255 != 0;
        let alpha = f64::from(matte) / 255.0;
        let own = [r, g, b].map(|value| linear_of_srgb(f64::from(value) / 255.0));
        light = std::array::from_fn(|c| alpha * own[c] + (1.0 - alpha) * light[c]);
    }
    let [r, g, b] = light.map(|light| (255.0 * srgb_from_linear(light)).round() as u8);
    (!faces.is_empty()).then_some(([r, g, b, 255], is_partial))
}

#[test]
fn without_a_background_alpha_is_what_covers_the_pixel_and_colours_are_the_surfaces_own() {
    let mut counted = [0; 4];
    for scene in [random::soup(61, 24), random::boxes(61, 8), random::boxes(62, 8)].map(turning) {
        let mut rng = Rng::new(5);
        let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
        let texels = bench.texels.clone();
        for _ in 0..4 {
            let mut shot = Shot { surroundings: false, ..view(&scene, &mut rng) };
            let model = &bench.site.model;
            shot.hidden = model.face_ids().filter(|face| !model.stands_for_impostor(*face)).collect();
            let mut draw = |matte: fn(DVec2, bool) -> u8| {
                bench.texels = texels.clone();
                put(&mut bench, matte);
                bench.renderer(&Relief::default()).picture(&shot, &Task::silent()).unwrap()
            };
            let pictures = [draw(|_, _| 102), draw(|_, _| 255)];
            count_surfaces(&bench, &shot, &pictures, &mut counted);
        }
    }
    println!("pixels by the number of surfaces: {counted:?}");
    assert!(counted[1] > 1000 && counted[2] > 500 && counted[3] > 10, "{counted:?}");
}

/// Checks pixels without anything opaque: of pictures of mattes of 0.4 and of 1.
fn count_surfaces(bench: &Bench, shot: &Shot, pictures: &[Picture; 2], counted: &mut [u32; 4]) {
    let (faces, through) = (stacks(bench, shot), see_through(bench));
    for i in (0..faces.len()).filter(|i| is_inside(&faces, *i, shot.camera.width as usize)) {
        // Impostors that no photo shows are like other faces.
        if faces[i].is_empty() || !faces[i].iter().all(|face| through.contains(face)) {
            continue;
        }
        let [found, solid] = [0, 1].map(|picture: usize| pictures[picture].pixels()[i]);
        // A matte of 0.4 on each of n surfaces: 1 - 0.6^n. A surface that no photo shows is not there.
        let alpha = |n: i32| (255.0 * (1.0 - 0.6f64.powi(n))).round() as u8;
        let surfaces = (0..=faces[i].len() as i32).find(|n| found[3].abs_diff(alpha(*n)) <= 1);
        let surfaces = surfaces.unwrap_or_else(|| panic!("{found:?} through {} surfaces", faces[i].len()));
        counted[surfaces.min(3) as usize] += 1;
        if surfaces == 1 && faces[i].len() == 1 {
            // Half a step of 8 bits, over 0.4, once for the product and once for the sum with the grey.
            let far = (0..3).map(|c| found[c].abs_diff(solid[c])).max().unwrap();
            assert!(far <= 4, "{found:?}, {solid:?}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_order_of_the_models_objects() {
    let (mut inside, mut several, mut far) = (0, 0, 0);
    for scene in (61..=62).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]).map(turning) {
        let mut rng = Rng::new(6);
        let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
        put_mattes(&mut bench);
        let (model, through) = (reversed(&scene, &bench.site.model), see_through(&bench));
        // The same servers, at the faces' other ids.
        let mut sources = Sources::clone(&bench.sources);
        let named = |model: &Model, name: &str| model.face_ids().find(|face| model.face_name(*face) == name);
        for face in model.face_ids() {
            let before = named(&bench.site.model, &model.face_name(face)).unwrap();
            sources.of_face[face.0 as usize] = bench.sources.of_face[before.0 as usize].clone();
        }
        let site = Site { model, photos: bench.site.photos.clone() };
        let (sources, flat) = (Arc::new(sources), Relief::default());
        let mut gpu = bench.renderer(&flat);
        let mut other = renderer_of(&bench.gpu, &site, &sources, &bench.gains, &flat, &bench.texels);
        for _ in 0..4 {
            let shot = view(&scene, &mut rng);
            let [a, b] = [&mut gpu, &mut other].map(|gpu| gpu.picture(&shot, &Task::silent()).unwrap());
            let faces = stacks(&bench, &shot);
            for i in (0..faces.len()).filter(|i| is_inside(&faces, *i, shot.camera.width as usize)) {
                let count = faces[i].iter().filter(|face| through.contains(face)).count();
                inside += 1;
                several += u32::from(count > 1);
                far += u32::from(apart(&a.pixels()[i], &b.pixels()[i]) > 1.0);
            }
        }
    }
    println!("of {inside} pixels {several} with two see-through faces or more, {far} differ");
    // Of opaque faces in one plane the last one of the model is shown; no two of these scenes' are.
    assert!(several > 1000 && far * 1000 < inside, "{several}, {far} of {inside}");
}

/// A model with its objects in the reverse order.
fn reversed(scene: &Scene, model: &Model) -> Arc<Model> {
    let mut m = Modeller::new();
    for object in model.objects.iter().rev() {
        m.object(object.name.clone());
        for face in &object.faces {
            m.polygon(&model.ring_points(*face).collect::<Vec<_>>());
        }
    }
    let of_name = |name: &str| model.objects.iter().find(|object| object.name == name).unwrap();
    let up = -(scene.pose.rotation.transpose() * DVec3::Y);
    let turns = |object: &Object| model.impostor(of_name(&object.name).faces[0]).is_some();
    let (mut reversed, _) = Arc::unwrap_or_clone(m.finish()).with_impostors(up, turns);
    for object in &mut reversed.objects {
        object.billboard = of_name(&object.name).billboard;
    }
    Arc::new(reversed)
}

#[test]
fn matte_shows_what_see_through_faces_cover_and_other_modes_show_those_that_cover_half() {
    let (scene, mut rng) = (turning(random::boxes(61, 8)), Rng::new(7));
    let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
    put_mattes(&mut bench);
    let (mut gpu, through) = (bench.renderer(&Relief::default()), see_through(&bench));
    let opaque = bench.site.model.face_ids().filter(|face| !through.contains(face));
    let opaque: HiddenFaces = opaque.collect();
    let (mut partial, mut cut_out) = (0, 0);
    for _ in 0..4 {
        let shot = Shot { surroundings: false, ..view(&scene, &mut rng) };
        let alone = Shot { hidden: opaque.clone(), ..shot.clone() };
        let (faces, faces_alone) = (stacks(&bench, &shot), stacks(&bench, &alone));
        let mut draw = |shot: &Shot, display: DisplayMode| {
            gpu.picture(&Shot { display, ..shot.clone() }, &Task::silent()).unwrap()
        };
        let [mattes, items] = [DisplayMode::Matte, DisplayMode::Item].map(|display| draw(&shot, display));
        let alone = draw(&alone, DisplayMode::Colour);
        for i in (0..faces.len()).filter(|i| is_inside(&faces, *i, 144)) {
            let (matte, item, alpha) = (&mattes.pixels()[i], &items.pixels()[i], alone.pixels()[i][3]);
            let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
            match (&faces[i][..], &faces_alone[i][..]) {
                ([face], _) if !through.contains(face) => {
                    assert_eq!(*matte, opaque(MATTE[0]), "other faces are dark");
                }
                // One see-through face, before an opaque one.
                ([_, face], [alone]) if face == alone && is_inside(&faces_alone, i, 144) => {
                    let expected = opaque(colour_at(MATTE, f32::from(alpha) / 255.0));
                    // Half a step of alpha is 3.3 steps at the dark end.
                    assert!(apart(matte, &expected) <= 4.0, "{matte:?} at {alpha}");
                    let shows = apart(item, &opaque(colour_of_number(face.0))) <= 2.0;
                    assert!(shows == (alpha >= 128) || alpha.abs_diff(128) <= 1, "{item:?} at {alpha}");
                    partial += u32::from(alpha % 255 != 0);
                    cut_out += u32::from(!shows);
                }
                _ => (),
            }
        }
    }
    println!("{partial} partial, {cut_out} cut out");
    assert!(partial > 300 && cut_out > 300, "{partial} {cut_out}");
}
