//! In a photo's own camera, at its size and its own exposure, a picture is the photo.

use glam::DVec2;
use quadratura::task::Task;
use quadratura::testing::gpu::Renderer;
use quadratura::testing::projection::Renders;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::view::{Mode, Picture, Quality};

use crate::bench::{Bench, apart};

/// Where a pixel of *final* quality is sampled, and its centre, in pixels: the standard places of four
/// samples.
const SAMPLES: [DVec2; 5] = [
    DVec2::new(0.375, 0.125),
    DVec2::new(0.875, 0.375),
    DVec2::new(0.125, 0.625),
    DVec2::new(0.625, 0.875),
    DVec2::splat(0.5),
];

/// For each pixel of a photo whether its 3 x 3 neighbourhood is one element: all of its samples see faces
/// that one image layer shows, so that nothing thinner than a pixel lies between. (A little more than is
/// promised: an image layer may hold several elements, and lines between its faces count as inside.)
fn one_element(bench: &Bench, renderer: &mut Renderer, photo: usize) -> Vec<bool> {
    let own = bench.own(photo);
    let mut layers = SAMPLES.map(|at| {
        let mut shot = own.clone();
        // The centres of these pixels are the samples of the photo's.
        (shot.camera.cx, shot.camera.cy) = (own.camera.cx + 0.5 - at.x, own.camera.cy + 0.5 - at.y);
        bench.layers(photo, &renderer.faces(&shot, &Task::silent()).unwrap(), at)
    });
    let (width, height) = (own.camera.width as usize, own.camera.height as usize);
    let (first, others) = layers.split_first_mut().expect("there are five");
    for (i, layer) in first.iter_mut().enumerate() {
        if others.iter().any(|other| other[i] != *layer) {
            *layer = 0;
        }
    }
    let one = |i: usize| {
        let (x, y) = (i % width, i / width);
        let within = x > 0 && y > 0 && x + 1 < width && y + 1 < height && first[i] > 0;
        within && (0..9).all(|k| first[(y + k / 3 - 1) * width + x + k % 3 - 1] == first[i])
    };
    (0..first.len()).map(one).collect()
}

/// What came of comparing a picture with its photo.
struct ImageMetrics {
    /// Share of the pixels whose neighbourhood is one element.
    inside: f64,
    /// The pixels there that differ by more than 1, and by how much.
    off: Vec<(usize, u8)>,
    /// Over all pixels that are textured all over.
    psnr: f64,
}

/// `one_element`: see there.
fn metrics(photo: &[[u8; 3]], picture: &Picture, one_element: &[bool]) -> ImageMetrics {
    let (mut inside, mut off) = (0, Vec::new());
    let (mut squares, mut count) = (0.0, 0.0);
    for (i, (pixel, own)) in picture.rgba.chunks(4).zip(photo).enumerate() {
        // Elsewhere the photo shows what is not modelled.
        if pixel[3] == 255 {
            squares += pixel.iter().zip(own).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
            count += 3.0;
        }
        if one_element[i] {
            inside += 1;
            let apart = if pixel[3] == 255 { apart(pixel, own) } else { 255 };
            off.extend((apart > 1).then_some((i, apart)));
        }
    }
    let psnr = 10.0 * (255.0f64.powi(2) * count / squares).log10();
    ImageMetrics { inside: f64::from(inside) / photo.len() as f64, off, psnr }
}

/// In all modes; at least this share of the pixels is inside elements, and so like the photo is all of it,
/// in *final* and in *preview* quality, in dB.
pub fn check(bench: &Bench, photo: usize, least_inside: f64, least_psnr: [f64; 2]) {
    let pixels = bench.pixels(photo);
    let (width, height) = (pixels.width, pixels.height);
    let at = |i: u32| {
        let [r, g, b, _] = pixels.rgba16(i % width, i / width);
        [r, g, b].map(|sample| (sample >> 8) as u8)
    };
    let own: Vec<[u8; 3]> = (0..width * height).map(at).collect();
    let mut renderer = bench.renderer(&Relief::default());
    let one_element = one_element(bench, &mut renderer, photo);
    for (quality, least_psnr) in [Quality::Final, Quality::Preview].into_iter().zip(least_psnr) {
        for mode in Mode::ALL {
            let mut shot = bench.own(photo);
            (shot.quality, shot.blend.mode) = (quality, mode);
            let picture = renderer.picture(&shot, &Task::silent()).unwrap();
            let ImageMetrics { inside, off, psnr } = metrics(&own, &picture, &one_element);
            let place = |&(i, off): &(usize, u8)| (i % width as usize, i / width as usize, off);
            let line = format!(
                "{}, {mode}, {quality:?}: {:.1} % inside elements, {} off by more than 1 {:?}; {psnr:.2} dB",
                bench.site.photos[photo].name,
                100.0 * inside,
                off.len(),
                off.iter().take(20).map(place).collect::<Vec<_>>()
            );
            println!("{line}");
            assert!(inside > least_inside && off.is_empty() && psnr > least_psnr, "{line}");
        }
    }
}

// Previews take sRGB for a quartic, which is off by up to 0.7 steps: 51 dB.
#[test]
fn the_piazzas_photos_come_back_in_their_own_cameras() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    check(&bench, 0, 0.5, [55.0, 50.0]);
    check(&bench, 3, 0.5, [55.0, 50.0]);
}

#[test]
fn the_castles_photos_come_back_in_their_own_cameras() {
    let Some(bench) = Bench::castle(&["0003", "0004", "0005"]) else { return };
    check(&bench, 1, 0.8, [55.0, 50.0]);
}
