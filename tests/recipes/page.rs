//! Pages of layered depth images, drawn by a browser and compared with the warp that `ldi render` draws with.
//!
//! Needs Chromium, which `sh tests/editors.sh` installs, and Python; without them the test is left out.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common;
use glam::{DMat3, DVec3};
use quadratura::testing::geometry::{Pinhole, Pose};
use quadratura::testing::images::export::{MeshOptions, export_page};
use quadratura::testing::ldi::levels::pyramid;
use quadratura::testing::ldi::{
    DepthPixel, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, Splat, WarpOptions, warp,
};

const SIZE: [u32; 2] = [640, 480];

fn surface(nu: DVec3) -> LdiSurface {
    LdiSurface { nu, object: "plane".to_owned(), face: None }
}

/// A square before a wall that goes on behind it, on a floor, under a sky.
fn scene() -> Ldi {
    let [width, height] = SIZE;
    let camera = Pinhole { width, height, fx: 600.0, fy: 600.0, cx: 320.0, cy: 240.0 };
    let surfaces = vec![
        surface(DVec3::new(2e-5, 0.0, 0.1)),
        surface(DVec3::new(0.0, 0.0, 0.16)),
        // It meets the wall at row 360.
        surface(DVec3::new(2e-5, 0.0004, 0.1 - 0.0004 * 360.0)),
    ];
    let row = |y: u32| {
        let of = |x: u32| {
            let position = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
            let wave = |by: f64, at: f64| (40.0 * (at / by).sin()) as i32;
            let colour = |base: [i32; 3]| {
                let light = wave(9.0, position.x) + wave(13.0, position.y);
                let [r, g, b] = base.map(|value| (value + light).clamp(0, 255) as u8);
                [r, g, b, 255]
            };
            let pixel = |surface: u16, base| DepthPixel {
                inverse_depth: match surface {
                    0 => 0.0,
                    _ => surfaces[usize::from(surface) - 1].nu.dot(position) as f32,
                },
                colour: colour(base),
                surface,
                splat: Splat(0),
            };
            let behind = match y {
                0..100 => pixel(0, [150, 180, 210]),
                100..360 => pixel(1, [170, 150, 130]),
                _ => pixel(3, [110, 120, 100]),
            };
            let is_square = (250..390).contains(&x) && (160..330).contains(&y);
            let front = is_square.then(|| pixel(2, [160, 90, 90]));
            front.into_iter().chain([behind]).map(move |pixel| (x as u16, pixel))
        };
        (0..width).flat_map(of).collect::<Vec<_>>()
    };
    let level = ResolutionLevel::of_rows(camera, (0..height).map(row));
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose: Pose { rotation: DMat3::from_rotation_y(0.4), translation: DVec3::new(1.0, -2.0, 0.5) },
        photo_rect: None,
        gain: [0.0; 3],
        levels: pyramid(level, &surfaces),
        surfaces,
        sources: vec!["scene.png".to_owned()],
        report: LdiReport { quartiles: [7.0, 9.0, 10.0], ..LdiReport::default() },
    }
}

/// Draws a page from a viewpoint, on the processor.
fn drawn([browser, python]: &[PathBuf; 2], page: &Path, at: DVec3) -> image::RgbImage {
    let [width, height] = SIZE;
    let DVec3 { x, y, z } = at;
    let shot = page.with_extension("png");
    let output = Command::new(python)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/page/exact.py"))
        .arg(browser)
        .arg(format!("file://{}/index.html#at={x},{y},{z}&size={width}x{height}", page.display()))
        .args([width, height].map(|side| side.to_string()))
        .arg(&shot)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    image::open(shot).unwrap().to_rgb8()
}

/// Returns PSNR in dB over the pixels that the expected picture covers wholly, and their share.
fn psnr(seen: &image::RgbImage, expected: &[[u8; 4]]) -> (f64, f64) {
    let (mut sum, mut count) = (0.0, 0u32);
    for (seen, expected) in seen.pixels().zip(expected).filter(|(_, expected)| expected[3] == 255) {
        sum += (0..3).map(|c| (f64::from(seen[c]) - f64::from(expected[c])).powi(2)).sum::<f64>() / 3.0;
        count += 1;
    }
    let mean = sum / f64::from(count);
    (10.0 * (255.0f64.powi(2) / mean).log10(), f64::from(count) / expected.len() as f64)
}

#[test]
fn a_page_shows_what_the_warp_shows_wherever_one_can_go() {
    let (Some(browser), Some(python)) = (common::chromium(), common::python()) else { return };
    let programs = [browser, python];
    let folder = tempfile::tempdir().unwrap();
    let ldi = scene();
    let options = MeshOptions { quality: 95, ..MeshOptions::default() };
    let task = quadratura::task::Task::silent();
    let exported = export_page(&ldi, &folder.path().join("page"), "A square", &options, &task).unwrap();
    let (window, safe) = exported.seen.unwrap();
    let whole = quadratura::testing::ldi::lean::Window { zoom: 1.0, ..window };
    let [right, down] = [safe.across[0], safe.across[4]];
    assert!(right > 0.05 && down > 0.05 && safe.along[1] > 0.05, "{safe:?}");
    let offsets = [
        DVec3::ZERO,
        DVec3::new(0.7 * right, 0.0, 0.0),
        DVec3::new(-0.3 * right, 0.3 * down, 0.3 * safe.along[1]),
    ];
    for at in offsets {
        let expected =
            warp(&ldi, &whole.shot(&ldi, at, SIZE), &WarpOptions::default(), &task).unwrap().picture;
        let (found, share) = psnr(&drawn(&programs, &exported.path, at), expected.pixels());
        // The goal of pages; the JPEG alone leaves 43 to 46 dB of this scene.
        assert!(found >= 40.0 && share > 0.9, "{found:.1} dB over {share:.3} of the picture at {at}");
    }
}
