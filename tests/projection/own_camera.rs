//! In a photo's own camera, at its size and its own exposure, a picture is the photo.

use glam::DVec2;
use quadratura::projection::relief::Relief;
use quadratura::projection::surface::Surface;
use quadratura::projection::{Mode, Picture, Quality, Renders, Shot};
use quadratura::task::Task;

use crate::bench::{Bench, apart};

/// What came of comparing a picture with its photo.
struct Likeness {
    /// Share of the pixels whose 3 x 3 neighbourhood is one element.
    inside: f64,
    /// The pixels there that differ by more than 1, and by how much.
    off: Vec<(usize, u8)>,
    /// Over all pixels that are textured all over.
    psnr: f64,
}

/// `parts`: see [`Bench::parts`].
fn likeness(photo: &[[u8; 3]], picture: &Picture, parts: &[u32]) -> Likeness {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let one_part = |i: usize| {
        let (x, y) = (i % width, i / width);
        let within = x > 0 && y > 0 && x + 1 < width && y + 1 < height && parts[i] > 0;
        within && (0..9).all(|k| parts[(y + k / 3 - 1) * width + x + k % 3 - 1] == parts[i])
    };
    let (mut inside, mut off) = (0, Vec::new());
    let (mut squares, mut count) = (0.0, 0.0);
    for (i, (pixel, own)) in picture.rgba.chunks(4).zip(photo).enumerate() {
        // Elsewhere the photo shows what is not modelled.
        if pixel[3] == 255 {
            squares += pixel.iter().zip(own).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
            count += 3.0;
        }
        if one_part(i) {
            inside += 1;
            let apart = if pixel[3] == 255 { apart(pixel, own) } else { 255 };
            off.extend((apart > 1).then_some((i, apart)));
        }
    }
    let psnr = 10.0 * (255.0f64.powi(2) * count / squares).log10();
    Likeness { inside: inside as f64 / (width * height) as f64, off, psnr }
}

/// Whether something shows in a pixel that covers no pixel's centre.
fn has_sliver(surface: &Surface, shot: &Shot, pixel: usize) -> bool {
    let width = shot.camera.width as usize;
    let corner = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
    let owner = |at: DVec2| {
        let ray = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(corner + at);
        surface.owner(shot.viewpoint(), ray, 1e-4).map(|hit| hit.face)
    };
    let places = (0..32 * 32).map(|k| DVec2::new(f64::from(k % 32), f64::from(k / 32)) / 31.0);
    let centre = owner(DVec2::splat(0.5));
    places.map(owner).any(|face| face != centre)
}

fn check(bench: &Bench, photo: usize, least_inside: f64, quality: Quality, least_psnr: f64) {
    let pixels = bench.pixels(photo);
    let (width, height) = (pixels.width, pixels.height);
    let at = |i: u32| {
        let [r, g, b, _] = pixels.rgba16(i % width, i / width);
        [r, g, b].map(|sample| (sample >> 8) as u8)
    };
    let own: Vec<[u8; 3]> = (0..width * height).map(at).collect();
    let mut renderer = bench.renderer(&Relief::default());
    let surface = Surface::of(&bench.site.model);
    let mut shot = bench.own(photo);
    let parts = bench.parts(photo, &renderer.faces(&shot, &Task::silent()).unwrap());
    shot.quality = quality;
    for mode in Mode::ALL {
        shot.blend.mode = mode;
        let picture = renderer.picture(&shot, &Task::silent()).unwrap();
        let Likeness { inside, off, psnr } = likeness(&own, &picture, &parts);
        // Samples of a pixel may show what is thinner than a pixel and has no place in any layer.
        let (slivers, off): (Vec<_>, Vec<_>) =
            off.into_iter().partition(|(pixel, _)| has_sliver(&surface, &shot, *pixel));
        let places: Vec<_> =
            off.iter().take(8).map(|(i, off)| (i % width as usize, i / width as usize, off)).collect();
        let line = format!(
            "{}, {mode}, {quality:?}: {:.1} % inside elements, {} off by more than 1 {places:?}, {} with slivers; {psnr:.2} dB",
            bench.site.photos[photo].name,
            100.0 * inside,
            off.len(),
            slivers.len(),
        );
        println!("{line}");
        assert!(inside > least_inside && off.is_empty() && psnr > least_psnr, "{line}");
        // One pixel in twenty thousand.
        assert!(slivers.len() * 20_000 < own.len(), "{line}");
    }
}

// Previews take sRGB for a quartic, which is off by up to 0.7 steps: 51 dB.
#[test]
fn the_piazzas_photos_come_back_in_their_own_cameras() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    for photo in [0, 3] {
        check(&bench, photo, 0.5, Quality::Final, 55.0);
        check(&bench, photo, 0.5, Quality::Preview, 50.0);
    }
}

#[test]
fn the_castles_photos_come_back_in_their_own_cameras() {
    let Some(bench) = Bench::castle(&["0003", "0004", "0005"]) else { return };
    check(&bench, 1, 0.8, Quality::Final, 55.0);
    check(&bench, 1, 0.8, Quality::Preview, 50.0);
}
