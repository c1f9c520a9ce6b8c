//! Leftovers: what a photo barely shows is in no image layer, and the document still gives the photo back.

use std::sync::Arc;

use quadratura::testing::geometry::PixelRect;
use quadratura::testing::import::photo::read_photo;
use quadratura::testing::layered_files::composite::lay_over;
use quadratura::testing::layered_files::{Depth, EditedLayer, Raster, read_layered};
use serde_json::Value;

use super::paper::Paper;
use super::{RED, Studio, layer, paint_the_wall, states};

const FORMATS: [&str; 4] = ["psd", "ora", "xcf", "folder"];
const NAME: &str = "leftovers - do not paint here";
/// The wall, of which a box hides a part, counts as barely visible.
const NO_WALL: &str = "build project -q --save-options --min-visible wall=999999 --min-share wall=1";

/// A project whose wall is left over, exported after that.
fn without_wall(format: &'static str) -> Option<Studio> {
    let studio = Studio::new(format)?;
    std::fs::remove_dir_all(studio.site.path("layers")).unwrap();
    studio.site.run(NO_WALL).success();
    studio.export();
    Some(studio)
}

fn stack_of(studio: &Studio) -> Value {
    studio.site.json("info project --photo left.png --json")["untextured"]["by_photo"]["left.png"].clone()
}

/// Everything of a document but the photo and the guides, over nothing.
pub fn stacked(layers: &[EditedLayer]) -> Raster {
    let mut canvas = Raster::blank(160, 120, Depth::Eight);
    for layer in layers.iter().filter(|layer| layer.visible && !layer.name.starts_with("photo")) {
        let rect = layer.rect.intersection(&PixelRect::of_size(160, 120));
        let (x, y) = (rect.x - layer.rect.x, rect.y - layer.rect.y);
        let pixels = layer.pixels.read().unwrap().cropped(PixelRect { x, y, ..rect });
        lay_over(&mut canvas, &Arc::new(pixels), rect);
    }
    canvas
}

#[test]
fn a_document_with_leftovers_gives_the_photo_back_and_they_have_no_token() {
    for format in FORMATS {
        let Some(studio) = without_wall(format) else { return };
        let document = read_layered(&studio.file()).unwrap();
        let top = document.layers.last().unwrap();
        assert_eq!((top.name.as_str(), &top.id), (NAME, &None), "{format}");
        assert!(top.locked || format == "folder", "{format}: files of a folder cannot be locked");
        let is_wall = |layer: &&EditedLayer| layer.name.starts_with("wall");
        assert_eq!(document.layers.iter().filter(is_wall).count(), 0, "{format}");
        let photo = read_photo(&studio.site.path("photos/left.png"), 160, 120).unwrap();
        let (stacked, photo) = (stacked(&document.layers), Raster::of_photo(photo));
        // The wall and the floor cover the whole photo.
        assert!(stacked == photo, "{format}: the document is not the photo");
    }
}

#[test]
fn leftovers_bring_nothing_and_paint_on_them_is_reported_and_not_imported() {
    for format in FORMATS {
        let Some(studio) = without_wall(format) else { return };
        let quiet = studio.import();
        assert_eq!(quiet["import"], Value::Null, "{format}: {quiet:#}");
        assert!(
            !states(&quiet).iter().any(|state| ["painted-helper", "unknown"].contains(state)),
            "{quiet:#}"
        );

        let mut paper = Paper::read(&studio.file());
        let sheet = paper.sheets.iter_mut().find(|sheet| sheet.name == NAME).unwrap();
        for (x, y) in sheet.pixels_where(true).into_iter().step_by(7) {
            sheet.paint(x, y, RED);
        }
        if format == "folder" {
            let file = std::fs::File::create(studio.file().join("leftovers.png")).unwrap();
            quadratura::testing::layered_files::png::write_rgba(file, &sheet.pixels, None).unwrap();
        } else {
            paper.write(&studio.file());
        }
        let report = studio.import();
        assert_eq!(report["import"], Value::Null, "{format}: {report:#}");
        let found = layer(&report, "leftovers");
        assert_eq!(found["state"], "painted-helper", "{format}");
        assert!(found["notes"].to_string().contains("not imported"), "{format}: {found:#}");
        assert!(studio.paint().is_empty(), "{format}");
    }
}

#[test]
fn paint_from_an_older_export_comes_in_and_brings_the_layer_back() {
    for format in FORMATS {
        let Some(studio) = Studio::new(format) else { return };
        let mut paper = Paper::read(&studio.file());
        let expected = paint_the_wall(&mut paper, [0, 0]);
        paper.write(&studio.file());
        studio.site.run(NO_WALL).success();
        let untextured = stack_of(&studio);
        assert_eq!(untextured[0]["reason"], "barely-visible", "{untextured:#}");
        let state = |studio: &Studio| studio.site.json("info project --json")["photos"][0]["state"].clone();
        assert_eq!(state(&studio), "current");

        studio.import();
        assert_eq!(studio.paint(), expected, "{format}");
        assert_eq!(state(&studio), "stale", "{format}: the painted wall has no image layer yet");
        studio.site.run("build project -q").success();
        assert_eq!(state(&studio), "current");
        studio.export();
        let again = studio.site.path("layers");
        let newest = std::fs::read_dir(again)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .find(|path| path.to_string_lossy().contains("left.png-2."));
        let document = read_layered(&newest.unwrap()).unwrap();
        let names: Vec<_> = document.layers.iter().map(|layer| layer.name.as_str()).collect();
        assert!(names.iter().any(|name| name.starts_with("wall")), "{format}: {names:?}");

        studio.site.run("import project --undo -q").success();
        assert_eq!(state(&studio), "stale", "{format}: nothing keeps the wall any more");
    }
}
