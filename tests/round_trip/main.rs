//! Out to an image editor and home again: exactly what was painted becomes paint, whatever editors do to a file
//! besides, and nothing of it is ever lost.

mod at_once;
#[path = "../common/mod.rs"]
mod common;
mod crash;
mod damage;
mod former;
mod leftovers;
mod live;
mod looks;
mod masks;
mod matrix;
mod paper;
mod piazza;
#[path = "../layered/psd_file.rs"]
#[allow(dead_code)]
mod psd_file;
mod rehome;
#[path = "../command_line/site.rs"]
#[allow(dead_code)]
mod site;
mod strokes;
mod surroundings;
mod watching;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use common::adapter;
use paper::{Colour, Paper};
use quadratura::testing::document::paint::ERASED;
use quadratura::testing::io::paint_store::PaintStore;
use serde_json::Value;
use site::{Site, json_of, stderr_of, stdout_of};

const RED: Colour = [65535, 0, 2 * 257, 65535];
const SOFT: Colour = [257, 200 * 257, 9 * 257, 100 * 257];

/// A project with one photo, built and exported.
struct Studio {
    site: Site,
    /// As `--format` has it.
    format: &'static str,
}

impl Studio {
    /// A copy of a project that was built once; none without an adapter.
    fn new(format: &'static str) -> Option<Self> {
        static BUILT: OnceLock<Option<Site>> = OnceLock::new();
        let build = || {
            adapter()?;
            let site = Site::with_photos(&["left.png"], 160, 120, 1);
            site.make_project();
            site.run("build project -q").success();
            Some(site)
        };
        let Some(built) = BUILT.get_or_init(build) else {
            // Each test that is left out has to say so, not only the first.
            adapter();
            return None;
        };
        let site = Site { folder: tempfile::tempdir().unwrap() };
        copy(built.folder.path(), site.folder.path());
        let studio = Self { site, format };
        studio.export();
        Some(studio)
    }

    fn export(&self) -> PathBuf {
        let exported =
            self.site.json(&format!("export project --out layers --format {} --json", self.format));
        self.site.path(exported["photos"][0]["path"].as_str().unwrap())
    }

    /// The file as it was exported first.
    fn file(&self) -> PathBuf {
        let extension = if self.format == "folder" { "layers" } else { self.format };
        self.site.path("layers").join(format!("left.png.{extension}"))
    }

    fn import(&self) -> Value {
        self.import_with("")
    }

    fn import_with(&self, options: &str) -> Value {
        let file = self.file();
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        self.site.json(&format!("import project layers/{name} --json {options}"))
    }

    fn paint(&self) -> BTreeMap<(i32, i32), Colour> {
        paint_of(&self.site.project())
    }
}

/// All paint of a project of one photo; later imports show.
fn paint_of(project: &Path) -> BTreeMap<(i32, i32), Colour> {
    let store = PaintStore::new(project);
    let book = store.read().unwrap();
    let mut entries: Vec<_> = book.entries.iter().collect();
    entries.sort_by_key(|entry| entry.import);
    let patches = entries.into_iter().map(|entry| store.patch(entry).unwrap());
    patches
        .flat_map(|patch| patch.iter().map(|(x, y, colour)| ((x, y), colour)).collect::<Vec<_>>())
        .collect()
}

/// Paints on the wall: where the photo shows it, where the box hides it, past its outline; and erases a little.
/// Returns what the project should have then, in photo pixels. `[dx, dy]`: where the photo lies on the canvas.
fn paint_the_wall(paper: &mut Paper, [dx, dy]: [i32; 2]) -> BTreeMap<(i32, i32), Colour> {
    let wall = paper.sheet("wall");
    let (shown, empty) = (wall.pixels_where(true), wall.pixels_where(false));
    let mut painted = BTreeMap::new();
    let strokes = shown.iter().step_by(97).map(|place| (*place, RED));
    let soft = empty.iter().step_by(31).map(|place| (*place, SOFT));
    let erased = shown.iter().skip(50).step_by(211).map(|place| (*place, [0; 4]));
    for ((x, y), colour) in strokes.chain(soft).chain(erased).collect::<Vec<_>>() {
        wall.paint(x, y, colour);
        painted.insert((x - dx, y - dy), if colour[3] == 0 { ERASED } else { colour });
    }
    assert!(painted.len() > 60, "the test paints enough: {}", painted.len());
    painted
}

/// The layer of a report with this in its name.
fn layer<'a>(report: &'a Value, name: &str) -> &'a Value {
    let layers = report["files"][0]["layers"].as_array().unwrap();
    let found = layers.iter().find(|layer| layer["name"].as_str().unwrap().contains(name));
    found.unwrap_or_else(|| panic!("{name} is not in {report:#}"))
}

fn states(report: &Value) -> Vec<&str> {
    let layers = report["files"][0]["layers"].as_array().unwrap();
    layers.iter().map(|layer| layer["state"].as_str().unwrap()).collect()
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    copy(from, to);
}

fn copy(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let (old, new) = (entry.path(), to.join(entry.file_name()));
        if old.is_dir() {
            fs::create_dir(&new).unwrap();
            copy(&old, &new);
        } else {
            fs::copy(&old, &new).unwrap();
        }
    }
}

/// Every file below a folder with its content, but for what only says which documents were looked at.
fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                files.insert(entry.clone(), vec![]);
                folders.push(entry);
            } else if !["project.lock", "taken.json"]
                .contains(&&*entry.file_name().unwrap().to_string_lossy())
            {
                files.insert(entry.clone(), fs::read(&entry).unwrap());
            }
        }
    }
    // The folder that holds nothing else.
    let paint = folder.join("paint");
    if !files.keys().any(|path| path.starts_with(&paint) && *path != paint) {
        files.remove(&paint);
    }
    files
}
