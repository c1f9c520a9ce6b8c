//! A tiny site written to disk, and the program run on it.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use image::{Rgb, RgbImage};
use serde_json::Value;
use tempfile::TempDir;

use super::common::adapter;

/// The names of the photos, one of them as awkward as they come.
pub const PHOTOS: [&str; 2] = ["left.png", "north side/tür 2.png"];

/// A folder with photos, cameras and a model: a wall, a box before it, a shed hidden behind it, a
/// floor that runs behind the cameras.
pub struct Site {
    pub folder: TempDir,
}

impl Site {
    /// Two photos of 160 x 120.
    pub fn new() -> Self {
        Self::with_photos(&PHOTOS, 160, 120, 1)
    }

    /// Photos of `width` x `height`, and a box for every place in a grid of `boxes` x `boxes`.
    pub fn with_photos(names: &[&str], width: u32, height: u32, boxes: u32) -> Self {
        let site = Self { folder: tempfile::tempdir().unwrap() };
        for name in names {
            let file = site.path("photos").join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            let colour = |x: u32, y: u32| Rgb([(x * 7 + y) as u8, (x ^ y) as u8, (y * 3) as u8]);
            RgbImage::from_fn(width, height, colour).save(file).unwrap();
        }
        fs::create_dir_all(site.path("sparse")).unwrap();
        let (focal, cx, cy) = (width, width / 2, height / 2);
        let camera = format!("1 PINHOLE {width} {height} {focal} {focal} {cx} {cy}\n");
        fs::write(site.path("sparse/cameras.txt"), camera).unwrap();
        fs::write(site.path("sparse/images.txt"), poses(names)).unwrap();
        fs::write(site.path("model.obj"), model(boxes)).unwrap();
        site
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn project(&self) -> PathBuf {
        self.path("project")
    }

    /// The program in the site's folder; one argument a word.
    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.folder.path()).args(words.split_whitespace());
        command
    }

    pub fn run(&self, words: &str) -> Assert {
        self.command(words).assert()
    }

    /// Runs a command that succeeds and returns its JSON.
    pub fn json(&self, words: &str) -> Value {
        json_of(&self.run(words).success())
    }

    /// A project whose stacks are built and not filled; none where there is no GPU.
    pub fn built() -> Option<Self> {
        adapter()?;
        let site = Self::new();
        site.make_project();
        site.run("build project").success();
        Some(site)
    }

    /// `quadratura new` with everything right.
    pub fn make_project(&self) {
        self.run("new project --photos photos --cameras sparse --model model.obj").success();
    }
}

pub fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_quadratura"))
}

pub fn json_of(done: &Assert) -> Value {
    serde_json::from_slice(&done.get_output().stdout).expect("standard output is JSON and nothing else")
}

pub fn stderr_of(done: &Assert) -> String {
    String::from_utf8(done.get_output().stderr.clone()).unwrap()
}

pub fn stdout_of(done: &Assert) -> String {
    String::from_utf8(done.get_output().stdout.clone()).unwrap()
}

/// Cameras in a row, a metre apart, that look along z; y is down.
fn poses(names: &[&str]) -> String {
    let pose = |(name, x): (&&str, usize)| format!("{} 1 0 0 0 -{x} 0 0 1 {name}\n\n", x + 1);
    names.iter().zip(0..).map(pose).collect()
}

fn model(boxes: u32) -> String {
    let mut obj = Obj::default();
    obj.upright("wall", [-20.0, -20.0, 20.0, 2.0], 12.0);
    obj.upright("shed", [-1.0, -1.0, 1.0, 1.0], 15.0);
    obj.face("floor", [[-20.0, 2.0, -9.0], [-20.0, 2.0, 12.0], [20.0, 2.0, 12.0], [20.0, 2.0, -9.0]]);
    for i in 0..boxes * boxes {
        let (x, y) = (f64::from(i % boxes), f64::from(i / boxes));
        let step = 3.0 / f64::from(boxes);
        let (x, y) = (-1.5 + x * step, -1.5 + y * step);
        obj.upright(
            &format!("box {i}"),
            [x, y, x + step * 1.2, y + step * 1.2],
            6.0 + 0.01 * f64::from(i % 97),
        );
    }
    obj.text
}

#[derive(Default)]
struct Obj {
    text: String,
    vertices: u32,
}

impl Obj {
    /// A rectangle `[x0, y0, x1, y1]` that faces the cameras at depth `z`.
    fn upright(&mut self, name: &str, [x0, y0, x1, y1]: [f64; 4], z: f64) {
        self.face(name, [[x0, y0, z], [x0, y1, z], [x1, y1, z], [x1, y0, z]]);
    }

    fn face(&mut self, name: &str, corners: [[f64; 3]; 4]) {
        writeln!(self.text, "o {name}").unwrap();
        for [x, y, z] in corners {
            writeln!(self.text, "v {x} {y} {z}").unwrap();
        }
        let first = self.vertices + 1;
        writeln!(self.text, "f {} {} {} {}", first + 3, first + 2, first + 1, first).unwrap();
        self.vertices += 4;
    }
}

/// Every stack of a project that there is is whole: its `stack.json` names files that can be read to
/// their ends. Returns their number.
pub fn whole_stacks(project: &Path) -> usize {
    let Ok(folders) = fs::read_dir(project.join("stacks")) else { return 0 };
    let mut count = 0;
    for folder in folders.map(|entry| entry.unwrap().path()) {
        let Ok(text) = fs::read(folder.join("stack.json")) else { continue };
        let stack: Value = serde_json::from_slice(&text).expect("stack.json is whole");
        for layer in stack["image_layers"].as_array().unwrap() {
            for field in ["file", "needed_file"] {
                let file = folder.join(layer[field].as_str().unwrap());
                image::open(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            }
        }
        count += 1;
    }
    count
}
