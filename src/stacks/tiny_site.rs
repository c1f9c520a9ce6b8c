//! A site of two photos and two quads, for examples and tests: a box in front of a wall, in known colours.

use std::fs::{File, create_dir_all, write};
use std::path::{Path, PathBuf};

use crate::build::{BuildOptions, build};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Samples;
use quadratura_base::task::Task;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_layered_files::png::write_rgba;
use quadratura_layers::SoftwareRasteriser;
use quadratura_sites::create::{NewProject, create_project};
use quadratura_sites::open::Opened;

/// Width and height of the photos in pixels.
const SIZE: [u32; 2] = [64, 48];

/// The cameras in COLMAP's text format: one lens, two positions three units apart.
const CAMERAS: &str = "1 PINHOLE 64 48 64 64 32 24\n";
const IMAGES: &str = "1 1 0 0 0 1.5 0 0 1 left.png\n\n2 1 0 0 0 -1.5 0 0 1 right.png\n\n";

/// The photos' names and the positions of their cameras along x.
const PHOTOS: [(&str, f64); 2] = [("left.png", -1.5), ("right.png", 1.5)];

/// The model: a wall at depth 12, and a box's front at depth 6; y points down.
const MODEL: &str = "\
o wall
v -20 -20 12
v -20 20 12
v 20 20 12
v 20 -20 12
f 4 3 2 1
o box
v -1 -1 6
v -1 1 6
v 1 1 6
v 1 -1 6
f 8 7 6 5
";

/// Writes the site into `folder`: `photos/left.png`, `photos/right.png`, the cameras in `sparse/`, and `model.obj`.
///
/// # Errors
/// Returns [`Error::Io`] when a file cannot be written.
pub fn tiny_site(folder: &Path) -> Result<()> {
    let (photos, sparse) = (folder.join("photos"), folder.join("sparse"));
    for part in [&photos, &sparse] {
        create_dir_all(part).map_err(Error::io(part, "create the folder"))?;
    }
    let files = [("sparse/cameras.txt", CAMERAS), ("sparse/images.txt", IMAGES), ("model.obj", MODEL)];
    for (name, text) in files {
        let file = folder.join(name);
        write(&file, text).map_err(Error::io(&file, "write it"))?;
    }
    for (name, x) in PHOTOS {
        let file = photos.join(name);
        let out = File::create(&file).map_err(Error::io(&file, "create it"))?;
        write_rgba(out, &photo(x), None).map_err(Error::io(&file, "write it"))?;
    }
    Ok(())
}

/// Writes the site into `folder` and makes a project of it in `folder/project`.
///
/// # Errors
/// Returns the errors of [`tiny_site`] and of [`create_project`].
pub fn tiny_project(folder: &Path) -> Result<(PathBuf, Opened)> {
    tiny_site(folder)?;
    let project = folder.join("project");
    let new = NewProject {
        photos: folder.join("photos"),
        cameras: folder.join("sparse"),
        model: folder.join("model.obj"),
        ..NewProject::default()
    };
    let opened = create_project(&project, &new, &Task::silent())?;
    Ok((project, opened))
}

/// Writes the site, makes a project of it, and builds its stacks.
///
/// # Errors
/// Returns the errors of [`tiny_project`] and of [`build`].
pub fn tiny_stacks(folder: &Path) -> Result<(PathBuf, Opened)> {
    let (project, opened) = tiny_project(folder)?;
    let (store, options) = (StackStore::new(&project), BuildOptions::default());
    for built in build(&opened.site, &store, &SoftwareRasteriser, &options, &Task::silent())? {
        built.stack?;
    }
    Ok((project, opened))
}

/// Photographs the site from a camera at `x`.
fn photo(x: f64) -> Raster {
    let [width, height] = SIZE;
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let samples = pixels.flat_map(|(column, row)| {
        let (dx, dy) = ((f64::from(column) - 31.5) / 64.0, (f64::from(row) - 23.5) / 64.0);
        colour(x, dx, dy)
    });
    Raster::new(width, height, Samples::U8(samples.collect()))
}

/// Returns the colour that a ray from (x, 0, 0) in direction (dx, dy, 1) meets.
fn colour(x: f64, dx: f64, dy: f64) -> [u8; 4] {
    let (on_box, on_wall) = ([x + 6.0 * dx, 6.0 * dy], [x + 12.0 * dx, 12.0 * dy]);
    if on_box.iter().all(|at| at.abs() < 1.0) {
        return [200, if on_box[0] < 0.0 { 60 } else { 90 }, 40, 255];
    }
    let shade = |at: f64| 120 + (50.0 * at.sin()) as u8;
    [shade(on_wall[0]), shade(on_wall[1]), 150, 255]
}
