//! Mattes from the photos to the files for editors and back, on a site of a wall, a floor and a round tree.

use std::fs;
use std::path::PathBuf;

use image::{Rgb, RgbImage, RgbaImage};
use serde_json::Value;

use super::common::adapter;
use super::site::{Site, stderr_of};

const PHOTOS: [&str; 3] = ["left.png", "middle.png", "right.png"];
const SIZE: [u32; 2] = [320, 240];
const FOCAL: f64 = 160.0;
/// Where the cameras are along x; they look along z, and y points down.
const CAMERAS: [f64; 3] = [-5.0, 0.0, 5.0];
/// The crown: a sphere, whose outline every camera sees in the middle of the rectangle.
const CROWN: [f64; 3] = [0.0, 0.3, 6.0];
const RADIUS: f64 = 0.75;

/// The colour that a ray from (x, 0, 0) in the direction (dx, dy, 1) meets.
fn colour(x: f64, dx: f64, dy: f64, tree: bool) -> [f64; 3] {
    let to = [CROWN[0] - x, CROWN[1], CROWN[2]];
    let (along, length) = (to[0] * dx + to[1] * dy + to[2], dx * dx + dy * dy + 1.0);
    let nearest = to.iter().map(|at| at * at).sum::<f64>() - along * along / length;
    if tree && nearest < RADIUS * RADIUS {
        return [30.0, 80.0 - 40.0 * nearest / RADIUS, 20.0];
    }
    if 12.0 * dy > 2.0 {
        let (z, wide) = (2.0 / dy, x + 2.0 * dx / dy);
        return [150.0 + 30.0 * (wide * 2.0).sin(), 130.0, 110.0 + 25.0 * (z * 3.0).sin()];
    }
    let (wide, high) = (x + 12.0 * dx, 12.0 * dy);
    [190.0 + 25.0 * (wide * 2.5).sin(), 150.0 + 25.0 * (high * 2.0).sin(), 120.0 + 10.0 * (wide * 0.7).sin()]
}

fn photo(x: f64, tree: bool) -> RgbImage {
    const SAMPLES: u32 = 4;
    RgbImage::from_fn(SIZE[0], SIZE[1], |column, row| {
        let mut sum = [0.0; 3];
        for at in 0..SAMPLES * SAMPLES {
            let within = |at: u32| (f64::from(at) + 0.5) / f64::from(SAMPLES);
            let across = f64::from(column) + within(at % SAMPLES) - f64::from(SIZE[0]) / 2.0;
            let down = f64::from(row) + within(at / SAMPLES) - f64::from(SIZE[1]) / 2.0;
            let seen = colour(x, across / FOCAL, down / FOCAL, tree);
            (0..3).for_each(|c| sum[c] += seen[c]);
        }
        Rgb(sum.map(|sum| (sum / f64::from(SAMPLES * SAMPLES)).round() as u8))
    })
}

/// The site, built; with the tree in the photos or without it.
fn site(tree: bool) -> Site {
    let site = Site::with_photos(&PHOTOS, SIZE[0], SIZE[1], 1);
    for (name, x) in PHOTOS.iter().zip(CAMERAS) {
        photo(x, tree).save(site.path("photos").join(name)).unwrap();
    }
    let camera =
        format!("1 PINHOLE {} {} {FOCAL} {FOCAL} {} {}\n", SIZE[0], SIZE[1], SIZE[0] / 2, SIZE[1] / 2);
    fs::write(site.path("sparse/cameras.txt"), camera).unwrap();
    let pose = |(at, (name, x)): (usize, (&&str, f64))| format!("{} 1 0 0 0 {} 0 0 1 {name}\n\n", at + 1, -x);
    let poses: String = PHOTOS.iter().zip(CAMERAS).enumerate().map(pose).collect();
    fs::write(site.path("sparse/images.txt"), poses).unwrap();
    let model = "o wall\nv -30 -30 12\nv -30 2 12\nv 30 2 12\nv 30 -30 12\nf 4 3 2 1\n\
                 o floor\nv -30 2 -9\nv -30 2 12\nv 30 2 12\nv 30 2 -9\nf 8 7 6 5\n\
                 o tree.billboard\nv -1 -1 6\nv -1 2 6\nv 1 2 6\nv 1 -1 6\nf 12 11 10 9\n";
    fs::write(site.path("model.obj"), model).unwrap();
    site.make_project();
    site.run("build project").success();
    site
}

/// The tree's layer of a photo, exported as a folder: the picture's file, its corner in the photo, and the picture.
fn tree_layer(site: &Site, out: &str, photo: &str) -> (PathBuf, [i64; 2], RgbaImage) {
    site.run(&format!("export project --format folder --out {out}")).success();
    let folder = site.path(out).join(format!("{photo}.layers"));
    let stack: Value = serde_json::from_slice(&fs::read(folder.join("stack.json")).unwrap()).unwrap();
    let layers = stack["image_layers"].as_array().unwrap();
    let tree = layers.iter().find(|layer| layer["name"].as_str().unwrap().starts_with("tree")).unwrap();
    let file = folder.join(tree["file"].as_str().unwrap());
    let corner = [0, 1].map(|i| tree["rect"][i].as_i64().unwrap());
    let picture = image::open(&file).unwrap().to_rgba8();
    (file, corner, picture)
}

/// How much of a pixel of the middle photo the crown covers.
fn truth(x: i64, y: i64) -> f64 {
    let at = [x as f64 + 0.5 - f64::from(SIZE[0]) / 2.0, y as f64 + 0.5 - f64::from(SIZE[1]) / 2.0];
    let centre = [CROWN[0] / CROWN[2] * FOCAL, CROWN[1] / CROWN[2] * FOCAL];
    let off = (at[0] - centre[0]).hypot(at[1] - centre[1]);
    (RADIUS / CROWN[2] * FOCAL - off + 0.5).clamp(0.0, 1.0)
}

#[test]
fn one_sees_through_a_billboard_between_its_leaves_and_what_is_erased_stays_erased() {
    if adapter().is_none() {
        return;
    }
    let site = site(true);
    site.run("fill project").success();
    let (file, [left, top], found) = tree_layer(&site, "layers", "middle.png");
    let (mut wrong, mut count) = (0, 0);
    // The rectangle is 2 wide and 3 high, at a depth of 6; its outline is left out.
    for y in 96..170_i64 {
        for x in 136..184_i64 {
            let alpha = f64::from(found.get_pixel((x - left) as u32, (y - top) as u32)[3]) / 255.0;
            count += 1;
            wrong += u32::from((alpha > 0.5) != (truth(x, y) > 0.5));
        }
    }
    // A ring of half a pixel around the crown is 4 % of this.
    assert!(wrong * 100 <= 4 * count, "{wrong} of {count}");

    // Outlines of faces are rounded by one pixel here and there.
    assert!(off_by_more(&site, "middle.png") * 1000 <= 320 * 240, "the photo's own camera sees the photo");

    // A hole in the crown, and a leaf where there was none.
    let mut painted = found.clone();
    for (x, y, alpha) in [(160, 128, 0), (161, 128, 0), (140, 100, 255)] {
        painted.put_pixel((x - left) as u32, (y - top) as u32, image::Rgba([200, 10, 10, alpha]));
    }
    painted.save(&file).unwrap();
    site.run("import project layers/middle.png.layers").success();
    site.run("update project").success();
    let (_, _, again) = tree_layer(&site, "again", "middle.png");
    for (x, y, pixel) in again.enumerate_pixels() {
        let (expected, here) = (painted.get_pixel(x, y), (i64::from(x) + left, i64::from(y) + top));
        assert!(pixel == expected || (pixel[3], expected[3]) == (0, 0), "{here:?}: {pixel:?}, {expected:?}");
    }

    site.run("fill project --no-mattes").success();
    let (_, _, solid) = tree_layer(&site, "solid", "middle.png");
    let at = |x: i64, y: i64| solid.get_pixel((x - left) as u32, (y - top) as u32)[3];
    assert_eq!((at(138, 98), at(160, 128)), (255, 0), "solid but for what was erased");
}

#[test]
fn a_tree_that_is_not_there_is_seen_through_and_the_photo_is_given_back() {
    if adapter().is_none() {
        return;
    }
    let site = site(false);
    let told = stderr_of(&site.run("fill project").success());
    assert!(!told.contains("error"), "{told}");
    let (_, [left, top], found) = tree_layer(&site, "layers", "middle.png");
    let inner = (100..165_i64).flat_map(|y| (140..180_i64).map(move |x| (x, y)));
    let seen = inner.filter(|(x, y)| found.get_pixel((x - left) as u32, (y - top) as u32)[3] == 0).count();
    assert!(seen * 100 >= 95 * 65 * 40, "{seen} of {}", 65 * 40);
    assert!(off_by_more(&site, "middle.png") * 1000 <= 320 * 240, "the photo's own camera sees the photo");
}

/// The number of pixels at which the view of a photo's own camera differs from the photo by more than 3 of 255, and one
/// for the rounding of previews.
fn off_by_more(site: &Site, photo: &str) -> u32 {
    site.run("render project --cameras sparse --out views --quality preview").success();
    let seen = image::open(site.path("views").join(photo)).unwrap().to_rgb8();
    let own = image::open(site.path("photos").join(photo)).unwrap().to_rgb8();
    let off = |(a, b): (&Rgb<u8>, &Rgb<u8>)| (0..3).any(|c| a[c].abs_diff(b[c]) > 4);
    seen.pixels().zip(own.pixels()).filter(|pair| off(*pair)).count() as u32
}
