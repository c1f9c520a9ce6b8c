//! See-through surfaces: the GPU's pictures against the twin's, a photo's own camera, alpha, and the order of the model.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use quadratura::error::Result;
use quadratura::task::Task;
use quadratura::testing::projection::hidden::{Culling, HiddenFaces};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::sources::{COVERED, FILLED};
use quadratura::testing::projection::surface::Surface;
use quadratura::testing::projection::{
    LayerTextureId, LayerTexturePixels, Mode, Quality, Renders, Shot, Texels,
};
use quadratura::testing::scene::FaceId;
use quadratura::testing::scene::impostor::Facing;
use quadratura::testing::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura::testing::scene::synthetic::{Rng, random};

use crate::bench::Bench;
use crate::impostors::turning;
use crate::random_scenes::{bench, view};

/// Layer textures with mattes on what impostors cover in them, and with a filling wherever a photo does not show its needed
/// texels.
struct WithMattes {
    texels: Arc<dyn Texels>,
    /// For each layer texture what impostors cover in it, as quads in photo pixels; empty where it has no matte.
    quads: Vec<Vec<[DVec2; 4]>>,
    /// The matte at a photo position, in 255ths.
    matte: fn(DVec2) -> u8,
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
        let quads = &self.quads[id.0 as usize];
        if !quads.is_empty() {
            let is_within = |px: DVec2| quads.iter().any(|quad| holds(quad, px));
            pixels.matte =
                Some(positions.map(|px| if is_within(px) { (self.matte)(px) } else { 255 }).collect());
        }
        Ok(pixels)
    }
}

/// Nothing, all, and everything between, over some twenty pixels.
fn waves(px: DVec2) -> u8 {
    let wave = (px.x / 7.0 + 0.3 * px.y / 7.0).sin() + (px.y / 11.0 - 0.4 * px.x / 11.0).cos();
    (127.5 + 160.0 * wave).clamp(0.0, 255.0) as u8
}

/// Whether a convex quad contains a point, its outline included.
fn holds(quad: &[DVec2; 4], px: DVec2) -> bool {
    let side = |i: usize| (quad[(i + 1) % 4] - quad[i]).perp_dot(px - quad[i]);
    (0..4).all(|i| side(i) >= 0.0) || (0..4).all(|i| side(i) <= 0.0)
}

/// Gives all impostors these mattes in all photos.
fn put(bench: &mut Bench, matte: fn(DVec2) -> u8) {
    let model = bench.site.model.clone();
    let sources = Arc::make_mut(&mut bench.sources);
    let mut quads = vec![Vec::new(); sources.layer_textures.len()];
    for face in model.face_ids().filter(|face| model.stands_for_impostor(*face)) {
        let impostor = model.impostor(face).unwrap();
        for server in sources.servers_of(face) {
            let photo = sources.photo(server.photo);
            let corners = impostor.corners(&Facing::of_pose(&photo.pose));
            let image = |corner: DVec3| photo.camera.image_from_camera(photo.pose.camera_from_world(corner));
            if let [Some(a), Some(b), Some(c), Some(d)] = corners.map(image) {
                quads[server.layer_texture.0 as usize].push([a, b, c, d]);
            }
        }
    }
    for (layer_texture, quads) in sources.layer_textures.iter_mut().zip(&quads) {
        layer_texture.see_through = !quads.is_empty();
    }
    bench.texels = Arc::new(WithMattes { texels: bench.texels.clone(), quads, matte });
}

/// Gives all impostors mattes from nothing to all.
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
    model.face_ids().filter(|face| model.stands_for_impostor(*face)).filter(has_matte).collect()
}

/// The faces in a pixel, from back to front: the opaque one, and the see-through ones in front of it.
fn faces_in(bench: &Bench, surface: &Surface, shot: &Shot, px: DVec2) -> Vec<FaceId> {
    let through = see_through(bench);
    let hidden: HiddenFaces = through.iter().copied().collect();
    let (eye, ray) = (shot.viewpoint(), shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px));
    let culling = Culling { backs: shot.backs, hidden: &hidden };
    let opaque = surface.owner(eye, ray, 1e-4, culling);
    let reach = opaque.map_or(f64::INFINITY, |hit| hit.t);
    let all = Culling { hidden: &HiddenFaces::default(), ..culling };
    let before = surface.through(eye, ray, &through, all).into_iter().filter(|hit| hit.t <= reach);
    opaque.into_iter().chain(before).map(|hit| hit.face).collect()
}

/// A pixel's faces and those of its neighbours are the same: elsewhere final pictures, which have four samples a pixel,
/// show something else than the twin, which has one.
fn is_inside(faces: &[Vec<FaceId>], i: usize, width: usize) -> bool {
    let around = [i.wrapping_sub(1), i + 1, i.wrapping_sub(width), i + width];
    around.iter().all(|other| faces.get(*other) == Some(&faces[i]))
}

fn stacks(bench: &Bench, shot: &Shot) -> Vec<Vec<FaceId>> {
    let surface = Surface::from_model(&bench.site.model).with_backs(&bench.site.model, &bench.sources);
    let (width, height) = (shot.camera.width, shot.camera.height);
    let at = |i: u32| DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
    (0..width * height).map(|i| faces_in(bench, &surface, shot, at(i))).collect()
}

/// The steps of 8 bits by which two pixels differ, laid over the grey of what is not textured: what is nearly transparent has
/// no colour to speak of.
fn apart(a: &[u8; 4], b: &[u8; 4]) -> f64 {
    let over = |pixel: &[u8; 4], c: usize| {
        let (alpha, grey) = (f64::from(pixel[3]) / 255.0, linear_of_srgb(128.0 / 255.0));
        let light = alpha * linear_of_srgb(f64::from(pixel[c]) / 255.0) + (1.0 - alpha) * grey;
        255.0 * srgb_from_linear(light)
    };
    let colour = (0..3).map(|c| (over(a, c) - over(b, c)).abs()).fold(0.0, f64::max);
    colour.max(f64::from(a[3].abs_diff(b[3])))
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

#[test]
fn the_gpu_and_its_twin_see_through_crossing_impostors_alike() {
    let scenes = (61..=63).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]).map(turning);
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
        assert!(all.through > 0.2 * all.inside && all.several > 0.03 * all.inside, "{all:?}");
        assert!(all.partial > 0.02 * all.inside, "{all:?}");
    }
    assert!(last.far < 2e-3 * last.inside && last.sum < 0.9 * last.inside, "final: {last:?}");
    assert!(
        preview.far < 5e-2 * preview.inside && preview.sum < 2.5 * preview.inside,
        "preview: {preview:?}"
    );
}
