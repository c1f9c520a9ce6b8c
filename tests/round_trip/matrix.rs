//! What editors do to a file besides painting, for every format.

use std::fs;

use quadratura::testing::geometry::PixelRect;
use quadratura::testing::layered_files::{Depth, Raster};

use super::paper::{Colour, Paper, Sheet, token};
use super::{RED, Studio, layer, paint_the_wall, states, tree};

const FORMATS: [&str; 4] = ["psd", "ora", "xcf", "folder"];
/// Those in which layers can be moved, renamed and copied.
const LAYERED: [&str; 3] = ["psd", "ora", "xcf"];

/// Paints the wall, then does `edit` to the file; exactly the paint comes home.
fn comes_home(format: &'static str, edit: impl Fn(Paper) -> Paper) {
    let Some(studio) = Studio::new(format) else { return };
    let mut paper = Paper::read(&studio.file());
    let expected = paint_the_wall(&mut paper, [0, 0]);
    edit(paper).write(&studio.file());
    let report = studio.import();
    assert_eq!(studio.paint(), expected, "{format}: {report:#}");
    let wall = layer(&report, "wall");
    assert_eq!((&wall["state"], &wall["painted"]), (&"painted".into(), &expected.len().into()), "{report:#}");
    assert_eq!(states(&report).iter().filter(|state| **state == "painted").count(), 1, "{report:#}");
}

/// Does `edit` to a file that nobody painted on; nothing comes home.
fn brings_nothing(format: &'static str, edit: impl Fn(Paper) -> Paper) {
    let Some(studio) = Studio::new(format) else { return };
    let before = tree(&studio.site.project());
    edit(Paper::read(&studio.file())).write(&studio.file());
    let report = studio.import();
    assert!(studio.paint().is_empty(), "{format}: {report:#}");
    assert_eq!(report["import"], serde_json::Value::Null, "{report:#}");
    assert!(tree(&studio.site.project()) == before, "{format}: the project is as it was");
}

#[test]
fn an_untouched_file_brings_nothing() {
    FORMATS.iter().for_each(|format| brings_nothing(format, |paper| paper));
}

#[test]
fn exactly_the_painted_pixels_come_home() {
    FORMATS.iter().for_each(|format| comes_home(format, |paper| paper));
}

fn renamed(mut paper: Paper) -> Paper {
    for (index, sheet) in paper.image_layers().enumerate() {
        let token = token(&sheet.name).unwrap().to_owned();
        sheet.name = match index % 3 {
            0 => format!("{} [{token}]#1", &sheet.name[..4]),
            1 => format!("{} copy", sheet.name),
            _ => format!("mine {index} [x] [{token}]"),
        };
    }
    paper.sheet("wall").name.insert_str(0, "wall ");
    paper.sheets.reverse();
    paper
}

#[test]
fn layers_may_be_renamed_and_reordered() {
    for format in LAYERED {
        brings_nothing(format, renamed);
        comes_home(format, renamed);
    }
}

#[test]
fn layers_may_be_cropped_to_their_content_and_enlarged() {
    let cropped = |mut paper: Paper| {
        paper.image_layers().for_each(Sheet::crop);
        paper
    };
    let enlarged = |mut paper: Paper| {
        paper.image_layers().for_each(|sheet| sheet.grow(PixelRect { x: 0, y: 0, w: 160, h: 120 }));
        paper
    };
    for format in LAYERED {
        brings_nothing(format, cropped);
        comes_home(format, cropped);
        brings_nothing(format, enlarged);
        comes_home(format, enlarged);
    }
}

#[test]
fn a_copy_of_a_layer_that_was_painted_on_counts_with_it() {
    for format in LAYERED {
        let Some(studio) = Studio::new(format) else { return };
        let mut paper = Paper::read(&studio.file());
        let wall = paper.sheet("wall").clone();
        let mut copy = Sheet { name: format!("{} copy", wall.name), ..wall.clone() };
        let mut expected = std::collections::BTreeMap::new();
        for (x, y) in wall.pixels_where(false).into_iter().step_by(17) {
            copy.paint(x, y, RED);
            expected.insert((x, y), RED);
        }
        paper.sheets.push(copy);
        paper.write(&studio.file());
        studio.import();
        assert_eq!(studio.paint(), expected, "{format}");
    }
}

#[test]
fn sixteen_bits_are_no_paint_and_no_obstacle() {
    for format in LAYERED {
        brings_nothing(format, |paper| paper.in_depth(Depth::Sixteen));
        comes_home(format, |paper| paper.in_depth(Depth::Sixteen));
    }
}

#[test]
fn a_canvas_may_be_cropped_and_enlarged() {
    for format in LAYERED {
        for (width, height, dx, dy) in [(200, 150, 13, 8), (150, 110, -4, -6)] {
            brings_nothing(format, |paper| paper.on_canvas(width, height, dx, dy));
            comes_home(format, |paper| paper.on_canvas(width, height, dx, dy));
        }
    }
}

#[test]
fn what_a_cropped_canvas_cuts_off_is_not_erased() {
    for format in LAYERED {
        let cut = |paper: Paper| {
            let mut paper = paper.on_canvas(120, 90, -20, -10);
            let canvas = PixelRect { x: 0, y: 0, w: 120, h: 90 };
            for sheet in paper.image_layers() {
                let inside = sheet.rect.intersection(&canvas);
                let part = PixelRect { x: inside.x - sheet.rect.x, y: inside.y - sheet.rect.y, ..inside };
                sheet.pixels = sheet.pixels.clone().cropped(part);
                sheet.rect = inside;
            }
            paper
        };
        brings_nothing(format, cut);
    }
}

#[test]
fn a_file_that_lost_its_key_is_known_by_its_tokens() {
    let keyless = |mut paper: Paper| {
        paper.key = "somebody else's".into();
        paper
    };
    for format in LAYERED {
        brings_nothing(format, keyless);
        comes_home(format, keyless);
    }
}

#[test]
fn a_file_with_the_key_of_an_export_that_is_not_known_here_is_refused() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    paper.key = "0123456789abcdef0123".into();
    paper.write(&studio.file());
    let refused = studio.site.run("import project layers/left.png.psd").failure().code(1);
    let message = super::site::stderr_of(&refused);
    assert!(message.contains("0123456789abcdef0123.json") && message.contains("export again"), "{message}");
    assert!(studio.paint().is_empty());
}

#[test]
fn a_name_that_lost_its_token_is_made_up_for_by_the_one_in_the_xcf() {
    let nameless = |mut paper: Paper| {
        for (index, sheet) in paper.image_layers().enumerate() {
            sheet.name = format!("{} {index}", &sheet.name[..4]);
        }
        paper
    };
    brings_nothing("xcf", nameless);
    comes_home("xcf", nameless);
}

#[test]
fn a_layer_that_was_moved_is_taken_home_from_where_it_belongs() {
    for format in LAYERED {
        comes_home(format, |mut paper| {
            let wall = paper.sheet("wall");
            (wall.rect.x, wall.rect.y) = (wall.rect.x + 5, wall.rect.y - 3);
            paper
        });
    }
}

#[test]
fn a_layer_merged_into_another_is_missing_and_no_paint_on_that() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let top = paper.sheet("box").clone();
    let wall = paper.sheet("wall");
    wall.grow(top.rect);
    for (x, y) in top.pixels_where(true) {
        wall.paint(x, y, top.at(x, y));
    }
    let bare = wall.pixels_where(true)[0];
    wall.paint(bare.0, bare.1, RED);
    paper.sheets.retain(|sheet| !sheet.name.starts_with("box"));
    paper.write(&studio.file());
    let report = studio.import();
    assert_eq!(studio.paint(), [(bare, RED)].into(), "{report:#}");
    assert_eq!(layer(&report, "box")["state"], "missing");
}

#[test]
fn paint_on_the_photo_and_on_a_layer_without_a_token_is_told_and_left_out() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let photo = paper.sheets.iter_mut().find(|sheet| sheet.name.starts_with("photo")).unwrap();
    photo.paint(3, 3, RED);
    let rect = PixelRect { x: 5, y: 5, w: 2, h: 2 };
    let mine = Sheet {
        name: "mine".into(),
        rect,
        pixels: Raster::blank(2, 2, Depth::Eight),
        visible: true,
        id: None,
    };
    paper.sheets.push(mine);
    paper.write(&studio.file());
    let report = studio.import();
    assert_eq!(layer(&report, "photo")["state"], "painted-helper");
    assert_eq!(layer(&report, "mine")["state"], "unknown");
    assert!(studio.paint().is_empty());
}

#[test]
fn a_scaled_image_is_refused_and_taken_home_on_request() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    paper.sheet("wall");
    let mut small = paper.on_canvas(80, 60, 0, 0);
    for sheet in &mut small.sheets {
        let even = PixelRect::from_edges(
            sheet.rect.x.div_euclid(2) * 2,
            sheet.rect.y.div_euclid(2) * 2,
            (sheet.rect.right() + 1).div_euclid(2) * 2,
            (sheet.rect.bottom() + 1).div_euclid(2) * 2,
        );
        sheet.grow(even);
        sheet.pixels = halved(&sheet.pixels);
        sheet.rect = PixelRect { x: even.x / 2, y: even.y / 2, w: even.w / 2, h: even.h / 2 };
    }
    let wall = small.sheet("wall");
    let inner: Vec<_> = wall
        .pixels_where(true)
        .into_iter()
        .filter(|(x, y)| (5..15).contains(x) && (5..15).contains(y))
        .collect();
    let neon = [65535, 0, 65535, 65535];
    inner.iter().for_each(|(x, y)| wall.paint(*x, *y, neon));
    small.write(&studio.file());
    let refused = studio.site.run("import project layers/left.png.psd").failure();
    assert!(super::site::stderr_of(&refused).contains("--scaled"));
    studio.import_with("--scaled");
    let painted = studio.paint();
    let neon_px = painted
        .iter()
        .filter(|((x, y), c)| **c == neon && (10..30).contains(x) && (10..30).contains(y))
        .count();
    assert!(inner.len() > 50 && neon_px * 10 >= inner.len() * 32, "{neon_px} of 4 * {}", inner.len());
    assert!(
        painted.keys().all(|(x, y)| (9..31).contains(x) && (9..31).contains(y)),
        "nothing else: {}",
        painted.len()
    );
}

/// The mean of four.
fn halved(raster: &Raster) -> Raster {
    let mut half = Raster::blank(raster.width() / 2, raster.height() / 2, raster.depth());
    for y in 0..half.height() {
        for x in 0..half.width() {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| raster.rgba16(2 * x + dx, 2 * y + dy));
            let alpha: u32 = four.iter().map(|c| u32::from(c[3])).sum();
            let mean = |i: usize| {
                let sum: u64 = four.iter().map(|c| u64::from(c[i]) * u64::from(c[3])).sum();
                (sum / u64::from(alpha.max(1))) as u16
            };
            half.set_rgba16(x, y, [mean(0), mean(1), mean(2), (alpha / 4) as u16] as Colour);
        }
    }
    half
}

#[test]
fn a_strange_file_is_refused_with_a_remedy() {
    let Some(studio) = Studio::new("psd") else { return };
    fs::remove_dir_all(studio.site.path("project/exports")).unwrap();
    let refused = studio.site.run("import project layers/left.png.psd").failure().code(1);
    assert!(super::site::stderr_of(&refused).contains("is not in this project"));
}
