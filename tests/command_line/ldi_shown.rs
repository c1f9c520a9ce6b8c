//! What views of layered depth images show instead of colours, on the tiny site.

use image::Rgba;

use super::site::{Site, stderr_of, stdout_of};
use quadratura::testing::ldi::holes::Hole;
use quadratura::testing::view::legend::{Origin, colour_of_number};

/// What is shown, and the title of its legend.
const QUANTITIES: [(&str, &str); 4] = [
    ("holes", "Empty pixels"),
    ("layer", "Layers"),
    ("provenance", "Source"),
    ("density", "Resolution (depth pixels per pixel)"),
];

fn opaque([r, g, b]: [u8; 3]) -> Rgba<u8> {
    Rgba([r, g, b, 255])
}

#[test]
fn a_view_shows_holes_layers_sources_and_resolution_by_colours_that_a_legend_explains() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
    for (show, title) in QUANTITIES {
        let words =
            format!("ldi render left.ldi --cameras sparse --size 80x60 --out {show} --show {show} --json");
        let rendered = site.json(&words);
        assert_eq!(rendered["legend"]["title"], title, "{rendered:#}");
        let textured = rendered["pictures"][1]["textured"].as_f64().unwrap();
        assert!(if show == "holes" { textured == 1.0 } else { textured > 0.5 && textured < 1.0 }, "{show}");
        let colours = rendered["legend"]["colours"].as_array().unwrap();
        assert!(colours.iter().all(|entry| entry["colour"].as_str().unwrap().len() == 7), "{rendered:#}");
    }
    let shown = stdout_of(&site.run("ldi render left.ldi --out holes --show holes").success());
    assert!(shown.contains("hidden or empty") && !shown.contains("transparent"), "{shown}");
    let refused = stderr_of(&site.run("ldi render left.ldi --out other --show weights").failure().code(2));
    assert!(refused.contains("holes") && refused.contains("density"), "{refused}");
}

#[test]
fn views_of_a_project_from_images_show_the_same_quantities() {
    let Some(site) = Site::built() else { return };
    let picture = |words: &str, out: &str| {
        let rendered = site.json(&format!("render project --cameras photos --out {out} {words} --json"));
        assert_eq!(rendered["problems"].as_array().unwrap().len(), 0, "{rendered:#}");
        (rendered, image::open(site.path(out).join("left.png")).unwrap().to_rgba8())
    };
    let count =
        |picture: &image::RgbaImage, colour| picture.pixels().filter(|pixel| **pixel == colour).count();
    for (show, title) in QUANTITIES {
        let (rendered, shown) = picture(&format!("--as ldi --unfilled --show {show}"), show);
        assert_eq!(rendered["legend"]["title"], title, "{rendered:#}");
        // Its own photo has nearly all of the weight, so that the colours of categories are pure, and no pixel of a face is empty.
        let usual = match show {
            "layer" => colour_of_number(0),
            "provenance" => Origin::Photo.colour(),
            _ => continue,
        };
        let all = shown.pixels().filter(|pixel| pixel[3] == 255).count();
        assert!(2 * count(&shown, opaque(usual)) > all && all > 0, "{show}");
    }
    // With its photo, the view has what that photo shows, in its first layer.
    let (_, layers) = picture("--as photo --unfilled --show layer", "first");
    let (_, sources) = picture("--as photo --unfilled --show provenance", "photo");
    let first = count(&layers, opaque(colour_of_number(0)));
    // The floor and the wall fill the photo, which is 160 x 120, but for a strip of sky.
    assert!(first > 160 * 120 / 2, "{first} pixels are of the first layer");
    assert_eq!(first, count(&sources, opaque(Origin::Photo.colour())), "and all of them from the photo");
    // Without its photo, the other one lacks what lies beyond its frame and what the box hides from it.
    let (_, holes) = picture("--as photo --unfilled --show holes --without left.png", "other");
    for hole in [Hole::OutsideFrame, Hole::Empty] {
        assert!(count(&holes, opaque(hole.colour())) > 0, "{hole:?}");
    }
    for (words, needed) in [
        ("--as ldi --show weights", "density"),
        ("--as ldi --show exploded", "density"),
        ("--show holes", "--as ldi"),
    ] {
        let words = format!("render project --cameras photos --out x {words}");
        let refused = stderr_of(&site.run(&words).failure().code(2));
        assert!(refused.contains(needed), "{words}: {refused}");
    }
}

#[test]
fn sets_and_cubes_show_them_too() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --set 2 --out set.ldi").success();
    site.run("ldi build project --photo left --from site --ldi-scale 0.5 --cube --out cube.ldi").success();
    // The faces of a cube are in no photo's camera, so that all photos are others.
    for (file, photo) in [("set.ldi", Origin::Photo), ("cube.ldi", Origin::OtherPhoto)] {
        for (show, title) in QUANTITIES {
            let words =
                format!("ldi render {file} --cameras sparse --size 80x60 --out {show} --show {show} --json");
            let rendered = site.json(&words);
            assert_eq!(rendered["legend"]["title"], title, "{file}: {rendered:#}");
            let shown = image::open(site.path(show).join("left.png")).unwrap().to_rgba8();
            let has = |colour| shown.pixels().any(|pixel| *pixel == opaque(colour));
            match show {
                "layer" => assert!(has(colour_of_number(0)), "{file}"),
                "provenance" => assert!(has(photo.colour()), "{file}"),
                "holes" => assert!(shown.pixels().all(|pixel| pixel[3] == 255), "{file}"),
                _ => assert!(shown.pixels().any(|pixel| pixel[3] == 255), "{file}"),
            }
        }
    }
}

/// Another program's reader.
#[path = "../../examples/read_ldi.rs"]
#[allow(dead_code, reason = "its main function is of the example alone")]
mod read_ldi;

#[test]
fn a_reader_of_another_program_reads_packed_files_and_others_alike() {
    let Some(site) = Site::built() else { return };
    for words in ["--photo left --out x.ldi", "--set 2 --out x.ldi"] {
        let read = |packing: &str| {
            site.run(&format!("ldi build project {words} --packing {packing}")).success();
            read_ldi::picture_of(&std::fs::read(site.path("x.ldi")).unwrap()).unwrap()
        };
        let (packed, plain) = (read("deflate"), read("none"));
        assert!(packed == plain, "{words}");
        std::fs::remove_file(site.path("x.ldi")).unwrap();
    }
    // The first layer is what the image's own camera shows, black where nothing is.
    site.run("ldi build project --photo left --out left.ldi").success();
    site.run("ldi render left.ldi --out own --splat pixel").success();
    let read = read_ldi::picture_of(&std::fs::read(site.path("left.ldi")).unwrap()).unwrap();
    let mut own = image::open(site.path("own/left.png")).unwrap().to_rgba8();
    own.pixels_mut().filter(|pixel| pixel[3] == 0).for_each(|pixel| *pixel = Rgba([0; 4]));
    let (width, height) = own.dimensions();
    let header = format!("P6 {width} {height} 255\n").into_bytes();
    assert!([header, image::DynamicImage::ImageRgba8(own).to_rgb8().into_raw()].concat() == read);
}
