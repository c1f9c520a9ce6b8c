//! `tree export` and `tree import`: what is painted on a species in an image editor.

use std::fs;
use std::path::{Path, PathBuf};

use image::{Rgba, RgbaImage};
use serde_json::Value;

use super::site::{Site, json_of, stderr_of, stdout_of};

const LEAF: &str = "material leaf reflected .05 .3 .05 through .02 .2 0 leaf\n\
                    polygon 4  -1 0 0 0 0 0 0 1  1 0 0 0 0 0 1 1  1 1.5 2 0 0 0 1 0  -1 1.5 2 0 0 0 0 0\n";

/// A project with a species `bush` of 64 twigs of 64 leaves each.
fn planted() -> Site {
    let site = Site::new();
    site.make_project();
    let cube = |step: f64, child: &str| -> String {
        let part = |i: usize| {
            let (sin, cos) = (2.4 * i as f64).sin_cos();
            let [x, y, z] = [i % 4, i / 4 % 4, i / 16].map(|at| step * at as f64 + (0.3 * i as f64).sin());
            let minus = -sin;
            format!(
                "{{ transform {cos} {sin} 0 0  {minus} {cos} 0 0  0 0 1 0  {x} {y} {z} 1 use {child} }}\n"
            )
        };
        (0..64).map(part).collect()
    };
    fs::write(site.path("leaf.plant"), LEAF).unwrap();
    fs::write(site.path("twig.plant"), cube(4.0, "leaf")).unwrap();
    fs::write(site.path("bush.plant"), cube(17.0, "twig")).unwrap();
    // So dense that images as fine as wanted save something.
    fs::write(site.path("dense.plant"), cube(5.0, "twig")).unwrap();
    fs::write(site.path("grove.plant"), cube(12.0, "dense")).unwrap();
    site.run("tree species project bush --from bush.plant").success();
    site
}

/// The pictures of a direction's slabs in an exported folder.
fn slabs(folder: &Path, direction: &str) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_of_it = |file: &PathBuf| file.file_name().unwrap().to_string_lossy().starts_with(direction);
    let mut files: Vec<PathBuf> = files.filter(is_of_it).collect();
    files.sort();
    assert!(!files.is_empty(), "{direction} in {}", folder.display());
    files
}

fn repaint(file: &Path, change: impl Fn(u32, u32, Rgba<u8>) -> Rgba<u8>) {
    let before: RgbaImage = image::open(file).unwrap().to_rgba8();
    let (width, height) = before.dimensions();
    RgbaImage::from_fn(width, height, |x, y| change(x, y, *before.get_pixel(x, y))).save(file).unwrap();
}

/// The share of what a direction's slabs show that is red.
fn share_of_red(folder: &Path, direction: &str) -> f64 {
    let pictures = slabs(folder, direction).into_iter().map(|file| image::open(file).unwrap().to_rgba8());
    let shown: Vec<Rgba<u8>> = pictures
        .flat_map(|picture| picture.pixels().copied().collect::<Vec<_>>())
        .filter(|of| of[3] > 0)
        .collect();
    shown.iter().filter(|of| of[0] > of[1]).count() as f64 / shown.len() as f64
}

fn reddened(pixel: Rgba<u8>) -> Rgba<u8> {
    if pixel[3] > 0 { Rgba([200, 40, 30, pixel[3]]) } else { pixel }
}

fn paint_of(site: &Site) -> Value {
    site.json("tree list project --json")["species"][0]["paint"].clone()
}

#[test]
fn a_species_that_is_reddened_from_one_side_is_red_from_all_until_the_import_is_undone() {
    let site = planted();
    site.run("tree species project bush --from grove.plant").success();
    let baked =
        |site: &Site| site.json("tree bake project --json")["species"][0]["is_new"].as_bool().unwrap();
    assert!(baked(&site) && !baked(&site));
    let exported = site.json("tree export project bush --format folder --out layers --json");
    assert_eq!((&exported["views"], &exported["species"]), (&6.into(), &"bush".into()));
    let folder = site.path("layers/bush.layers");
    let unchanged = site.json("tree import project layers/bush.layers --json");
    assert_eq!((&unchanged["import"], &unchanged["changed"]), (&Value::Null, &0.into()), "{unchanged:#}");
    assert!(!site.path("project/paint").exists() && !baked(&site));

    slabs(&folder, "+x").iter().for_each(|file| repaint(file, |_, _, pixel| reddened(pixel)));
    let preview = site.json("tree import project layers/bush.layers --dry-run --json");
    assert!(preview["changed"].as_u64().unwrap() > 500 && !site.path("project/paint").exists());
    let imported = stdout_of(&site.run("tree import project layers/bush.layers").success());
    assert!(imported.contains("import 1:") && imported.contains("--undo"), "{imported}");
    assert!(paint_of(&site)["texels"].as_u64().unwrap() > 500);
    assert!(baked(&site), "images are made again");
    assert!(!baked(&site), "once");
    let again = site.json("tree import project layers/bush.layers --json");
    assert_eq!((&again["import"], &again["changed"]), (&Value::Null, &0.into()));

    // The edited folder is kept, and the next export shows the paint from all sides.
    let second = site.json("tree export project bush --format folder --out layers --json");
    assert!(second["path"].as_str().unwrap().ends_with("bush-2.layers"), "{second:#}");
    for direction in ["+x", "-x", "+y", "-y", "+z", "-z"] {
        let share = share_of_red(&site.path("layers/bush-2.layers"), direction);
        assert!(share > 0.9, "{direction}: {share}");
    }
    let none = site.json("tree import project layers/bush-2.layers --json");
    assert_eq!(none["changed"], 0, "{none:#}");

    let history = site.json("tree import project --history --json");
    assert_eq!(history["imports"][0]["species"], serde_json::json!(["bush"]));
    let undone = stdout_of(&site.run("tree import project --undo").success());
    assert!(undone.contains("import 1 of") && undone.contains("bush.layers"), "{undone}");
    assert!(paint_of(&site).is_null() && baked(&site) && !site.path("project/paint").exists());
    site.run("tree import project --undo").failure().code(1);

    let from_parts = |options: &str| {
        let made = site.json(&format!("tree bake project {options} --json"))["species"][0].clone();
        [&made["is_new"], &made["from_parts"]].map(|value| value.as_bool().unwrap())
    };
    assert_eq!(from_parts("--from-parts"), [false, false], "those that are there stay");
    assert_eq!(from_parts("--from-parts --force"), [true, true]);
    // No part of this plant has images, so all are made from polygons, whatever is asked for.
    site.run("tree species project bush --from bush.plant").success();
    assert_eq!(from_parts("--from-parts"), [true, false]);
    fs::create_dir(site.path("nothing")).unwrap();
    let nothing = stderr_of(&site.run("tree import project nothing").failure().code(1));
    assert!(nothing.contains("nothing: this folder contains no layered file"), "{nothing}");
}

#[test]
fn erased_texels_take_leaves_away_and_paint_where_nothing_is_is_kept_and_told() {
    let site = planted();
    site.run("tree export project bush --format folder --out layers").success();
    let folder = site.path("layers/bush.layers");
    let above = |pixels: &Path| -> usize {
        let pictures = slabs(pixels, "+y").into_iter().map(|file| image::open(file).unwrap().to_rgba8());
        let shown = |picture: RgbaImage| {
            let half = picture.height() / 2;
            picture.enumerate_pixels().filter(|(_, y, pixel)| *y < half && pixel[3] > 0).count()
        };
        pictures.map(shown).sum()
    };
    let before = above(&folder);
    for file in slabs(&folder, "+x") {
        // The upper half of the view from +x is what is high; a blue pixel is put into the corner.
        let half = image::open(&file).unwrap().height() / 2;
        repaint(&file, |x, y, pixel| match (x, y) {
            (0, 0) => Rgba([20, 30, 220, 255]),
            (_, y) if y < half => Rgba([0, 0, 0, 0]),
            _ => pixel,
        });
    }
    let told = stdout_of(&site.run("tree import project layers/bush.layers").success());
    assert!(told.contains("where the plant has nothing") && told.contains("erased"), "{told}");
    let paint = paint_of(&site);
    assert!(paint["erased"].as_u64().unwrap() > 200 && paint["beside"].as_u64() == Some(6), "{paint}");
    site.run("tree export project bush --format folder --out layers").success();
    let after = above(&site.path("layers/bush-2.layers"));
    assert!((after as f64) < 0.1 * before as f64, "{after} of {before}");
    let corner = image::open(&slabs(&site.path("layers/bush-2.layers"), "+x")[0]).unwrap().to_rgba8();
    assert_eq!(corner.get_pixel(0, 0).0, [20, 30, 220, 255]);
}

#[test]
fn a_layered_file_of_each_format_is_imported_as_it_was_exported_and_a_part_is_painted_everywhere() {
    let site = planted();
    for format in ["psd", "xcf", "ora"] {
        site.run(&format!("tree export project bush --part twig.plant --format {format} --out layers"))
            .success();
        let done = site.json(&format!("tree import project layers/bush%2C%20twig.plant.{format} --json"));
        assert_eq!((&done["changed"], &done["problems"]), (&0.into(), &serde_json::json!([])), "{done:#}");
        let layers = done["files"][0]["layers"].as_array().unwrap();
        assert!(layers.len() > 20 && layers.iter().all(|layer| layer["state"] == "unchanged"), "{done:#}");
    }
    let folder = site.json("tree import project layers --json");
    assert_eq!(folder["files"].as_array().map(Vec::len), Some(3), "{folder:#}");
    site.run("tree export project bush --part leaf.plant --format folder --out layers").success();
    let folder = site.path("layers/bush%2C%20leaf.plant.layers");
    for direction in ["+x", "+y", "-y", "+z", "-z", "-x"] {
        let files = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        let named = |file: &PathBuf| file.file_name().unwrap().to_string_lossy().starts_with(direction);
        files.filter(named).for_each(|file| repaint(&file, |_, _, pixel| reddened(pixel)));
    }
    site.json("tree import project layers/bush%2C%20leaf.plant.layers --json");
    site.run("tree export project bush --format folder --out layers").success();
    for direction in ["+x", "-y", "+z"] {
        let share = share_of_red(&site.path("layers/bush.layers"), direction);
        assert!(share > 0.95, "{direction}: {share}");
    }
}

#[test]
fn what_is_wrong_with_a_file_is_told_with_its_name_and_the_rest_is_imported() {
    let site = planted();
    let unknown = stderr_of(&site.run("tree export project palm --out layers").failure().code(1));
    assert!(unknown.contains("palm") && unknown.contains("bush"), "{unknown}");
    let part = stderr_of(&site.run("tree export project bush --part stem --out layers").failure().code(1));
    assert!(part.contains("no part \"stem\"") && part.contains("twig.plant"), "{part}");
    let own = stderr_of(&site.run("tree export project bush --out project/paint").failure().code(1));
    assert!(own.contains("belongs to the project"), "{own}");

    site.run("tree export project bush --format folder --out layers").success();
    let folder = site.path("layers/bush.layers");
    let files = slabs(&folder, "+x");
    files.iter().for_each(|file| repaint(file, |_, _, pixel| reddened(pixel)));
    site.run("tree import project layers/bush.layers").success();
    let all = paint_of(&site)["texels"].as_u64().unwrap();
    let photos = stderr_of(&site.run("import project layers/bush.layers").failure().code(1));
    assert!(photos.contains("species of tree") && photos.contains("quadratura tree import"), "{photos}");
    // One layer is gone, and keeps its paint; one has another size, is left out, and keeps it as well.
    fs::remove_file(&files[1]).unwrap();
    RgbaImage::new(9, 9).save(&files[2]).unwrap();
    repaint(&files[0], |_, _, pixel| pixel);
    let done = site.run("tree import project layers/bush.layers --json").failure().code(1);
    let told = json_of(&done);
    let state = |word: &str| {
        told["files"][0]["layers"].as_array().unwrap().iter().filter(|layer| layer["state"] == word).count()
    };
    assert_eq!((state("missing"), state("left-out")), (1, 1), "{told:#}");
    assert!(told["problems"][0].as_str().unwrap().contains("9 x 9"), "{told:#}");
    assert_eq!(paint_of(&site)["texels"].as_u64().unwrap(), all);

    // A damaged file of points is named, and the other paint is shown.
    let trees = site.path("project/paint/trees");
    let book: Value = serde_json::from_slice(&fs::read(trees.join("trees.json")).unwrap()).unwrap();
    let coat = trees.join(book["coats"][0]["file"].as_str().unwrap());
    let bytes = fs::read(&coat).unwrap();
    fs::write(&coat, &bytes[..bytes.len() / 2]).unwrap();
    let baked = stderr_of(&site.run("tree bake project").success());
    let name = coat.file_name().unwrap().to_string_lossy().into_owned();
    assert!(baked.contains(&name) && baked.contains("cut short") && baked.contains("restore it"), "{baked}");
    fs::write(&coat, &bytes).unwrap();
    fs::write(trees.join("trees.json"), "{").unwrap();
    let book = stderr_of(&site.run("tree import project layers/bush.layers").failure().code(1));
    assert!(book.contains("trees.json") && book.contains("restore it from a copy"), "{book}");
    let shown = stderr_of(&site.run("tree bake project").success());
    assert!(shown.contains("without its paint") && shown.contains("trees.json"), "{shown}");

    // A file of another project, and one that no program exported.
    fs::write(folder.join("quadratura-key.txt"), "0123456789abcdef0123").unwrap();
    fs::remove_file(trees.join("trees.json")).unwrap();
    fs::remove_dir_all(&trees).unwrap();
    let foreign = stderr_of(&site.run("tree import project layers/bush.layers").failure().code(1));
    assert!(foreign.contains("0123456789abcdef0123") && foreign.contains("export again"), "{foreign}");
    let missing = stderr_of(&site.run("tree import project no-such.psd").failure().code(1));
    assert!(missing.contains("no-such.psd"), "{missing}");
}

#[test]
fn a_plant_that_has_changed_since_the_export_keeps_its_paint_and_the_import_says_so() {
    let site = planted();
    site.run("tree export project bush --format folder --out layers").success();
    slabs(&site.path("layers/bush.layers"), "+x")
        .iter()
        .for_each(|file| repaint(file, |_, _, pixel| reddened(pixel)));
    // The leaves become a little larger.
    fs::write(site.path("leaf.plant"), LEAF.replace(" 1.5 2 0", " 1.5 2.2 0")).unwrap();
    let told = stdout_of(&site.run("tree import project layers/bush.layers").success());
    assert!(told.contains("has changed since this export"), "{told}");
    site.run("tree export project bush --format folder --out layers").success();
    let share = share_of_red(&site.path("layers/bush-2.layers"), "+x");
    assert!(share > 0.8, "{share}");
    // Without its species the paint is kept, and with one of this name it is back.
    let before = paint_of(&site);
    site.run("tree species project bush --remove").success();
    let kept = stderr_of(&site.run("tree list project").success());
    assert!(kept.contains("texels of paint are kept of the species \"bush\""), "{kept}");
    let gone = stderr_of(&site.run("tree import project layers/bush.layers").failure().code(1));
    assert!(gone.contains("\"bush\"") && gone.contains("tree species"), "{gone}");
    site.run("tree species project bush --from bush.plant").success();
    assert_eq!(paint_of(&site), before);
}

/// Photos show the real tree, not the paint: light that made up for the paint would take it away again.
#[test]
fn paint_leaves_the_light_that_photos_show_on_trees_as_it_was() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("leaf.plant"), LEAF).unwrap();
    site.run("tree species project bush --from leaf.plant").success();
    // Before the wall, in the middle of both photos; what is up in the photos is -y.
    site.run("tree place project bush --at 0,0.5,3 --height 1").success();
    site.run("tree mask project").success();
    let light = || site.json("tree light project --json");
    let green_and_red = |out: &str| {
        site.run(&format!("render project --cameras photos --out {out}")).success();
        let picture = image::open(site.path(&format!("{out}/left.png"))).unwrap().to_rgba8();
        let sum = |channel: usize| picture.pixels().map(|pixel| u64::from(pixel[channel])).sum::<u64>();
        (sum(1), sum(0))
    };
    let (before, (green, red)) = (light(), green_and_red("before"));
    assert_eq!(
        (&before["estimate"]["support"]["from"], &before["photos"]["bush_1"]),
        (&"photos".into(), &2.into()),
        "{before:#}"
    );
    site.run("tree export project bush --format folder --out layers").success();
    for direction in ["+y", "-y"] {
        slabs(&site.path("layers/bush.layers"), direction)
            .iter()
            .for_each(|file| repaint(file, |_, _, pixel| reddened(pixel)));
    }
    site.run("tree import project layers/bush.layers").success();
    // The estimate is made again, not read from the cache.
    fs::remove_file(site.path("project/cache/tree-light.json")).unwrap();
    let (after, (less_green, more_red)) = (light(), green_and_red("after"));
    assert_eq!((&after["estimate"], &after["light"]), (&before["estimate"], &before["light"]));
    assert!(less_green < green && more_red > red, "green {green} to {less_green}, red {red} to {more_red}");
}

/// The pixels of a folder's guide of trees that are not transparent.
fn guided(site: &Site, out: &str) -> usize {
    let guide = image::open(site.path(out).join("left.png.layers/guides/trees.png")).unwrap().to_rgba8();
    guide.pixels().filter(|pixel| pixel[3] > 0).count()
}

#[test]
fn exports_of_photos_have_a_guide_of_the_trees() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("leaf.plant"), LEAF).unwrap();
    let export = |format: &str, out: &str| {
        let exported =
            site.json(&format!("export project --photo left.png --format {format} --out {out} --json"));
        exported["photos"][0]["key"].as_str().unwrap_or_else(|| panic!("{exported:#}")).to_owned()
    };
    let bare = export("folder", "bare");
    assert!(!site.path("bare/left.png.layers/guides/trees.png").exists());
    site.run("tree species project bush --from leaf.plant").success();
    site.run("tree place project bush --at 0,0.5,3 --height 1").success();
    let planted = export("folder", "planted");
    assert_ne!(bare, planted, "another document");
    let whole = guided(&site, "planted");
    assert!(whole > 50, "{whole} pixels");
    // Behind the wall nothing of it is seen, so that there is no guide.
    site.run("tree move project bush_1 --at 0,0.5,30").success();
    assert_eq!(export("folder", "behind"), bare);
    site.run("tree move project bush_1 --at 0,0.5,3").success();
    // An import knows the guide in every format. It reports paint on the guide, and does not import it.
    for format in ["psd", "ora", "xcf"] {
        export(format, "files");
        let read = site.json(&format!("import project files/left.png.{format} --dry-run --json"));
        let layers = read["files"][0]["layers"].to_string();
        assert!(!layers.contains("unknown") && !layers.contains("helper"), "{format}: {layers}");
    }
    let file = site.path("planted/left.png.layers/guides/trees.png");
    let mut guide = image::open(&file).unwrap().to_rgba8();
    guide.pixels_mut().for_each(|pixel| *pixel = Rgba([255, 0, 0, 255]));
    guide.save(&file).unwrap();
    let read = stdout_of(&site.run("import project planted/left.png.layers --dry-run").success());
    assert!(read.contains("guide of trees") && read.contains("not imported"), "{read}");
    // A plant without polygons has no guide, and one that cannot be read is noted. Both leave the rest to be exported.
    fs::write(site.path("empty.plant"), "# nothing\n").unwrap();
    site.run("tree species project empty --from empty.plant");
    site.run("tree place project empty --at 0,0.5,3");
    fs::remove_file(site.path("leaf.plant")).unwrap();
    let noted = stderr_of(&site.run("export project --photo left.png --out files").success());
    assert!(noted.contains("leaf.plant"), "{noted}");
}
