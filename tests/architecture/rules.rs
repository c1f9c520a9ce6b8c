//! The rules themselves: each a function from a source to what it complains about.

use super::source::{Source, tokens};

/// The public modules of the library: they name items of the rooms for programs that embed it.
pub const FACADE: &[&str] =
    &["cameras", "site", "project", "sort", "stack", "fill", "layered", "render", "edit"];

/// The modules from the ground up. A module uses only floors below its own: neighbours on one floor
/// (`io` and `gpu`) do not know each other.
pub const FLOORS: &[&[&str]] = &[
    &["error"],
    &["task"],
    &["geometry"],
    &["raster"],
    &["scene"],
    &["projection"],
    &["foliage"],
    &["ldi"],
    &["layers"],
    &["document"],
    &["io", "gpu"],
    &["recipe"],
    FACADE,
    &["app"],
    &["cli"],
    &["testing"],
    &["main"],
];

/// Packages that one job needs, and the only places below `src/` that name them.
const PACKAGES_OF_ONE_JOB: &[(&str, &[&str])] = &[
    ("wgpu", &["gpu/"]),
    ("pollster", &["gpu/"]),
    ("block_compression", &["gpu/blocks.rs"]),
    ("half", &["gpu/", "io/layered/xcf/"]),
    ("spade", &["geometry/"]),
    ("i_overlay", &["geometry/"]),
    ("gltf", &["io/models/", "io/ldi_mesh/", "io/plants/gltf/"]),
    ("exr", &["io/depth_image/", "io/picture_exr.rs"]),
    ("image", &["io/"]),
    ("exif", &["io/photo/"]),
    ("png", &["io/"]),
    ("csv", &["io/tree_list.rs"]),
    ("unicode_normalization", &["scene/alike.rs"]),
    ("chardetng", &["io/text.rs"]),
    ("encoding_rs", &["io/text.rs"]),
    ("moxcms", &["io/colour.rs"]),
    ("notify_debouncer_full", &["io/watch.rs"]),
    ("zip", &["io/layered/ora/"]),
    ("flate2", &["io/layered/", "io/ldi_file/", "io/photo/tiff/", "io/plant_images/"]),
    ("weezl", &["io/photo/tiff/"]),
    ("roxmltree", &["io/layered/"]),
    ("tempfile", &["io/"]),
    ("petgraph", &["layers/"]),
    ("sysinfo", &["recipe/", "cli/"]),
    ("clap", &["cli/"]),
    ("clap_complete", &["cli/"]),
    ("clap_mangen", &["cli/"]),
    ("indicatif", &["cli/"]),
    ("ctrlc", &["cli/"]),
    ("eframe", &["app/"]),
    ("egui_tiles", &["app/shell/layout.rs"]),
    ("rfd", &["app/"]),
    ("rustix", &["app/shell/frame_times.rs", "app/work/priority.rs"]),
    ("thiserror", &["error/mod.rs"]),
];

/// Longer files are read by nobody.
pub const LONGEST_FILE: usize = 500;

/// What a library never does: it returns errors, and has no unfinished rooms.
const FORBIDDEN_MACROS: &[&str] =
    &["print", "println", "eprint", "eprintln", "dbg", "todo", "unimplemented", "panic"];

/// The faces of the program, which may print and exit.
fn is_face(path: &str) -> bool {
    path.starts_with("cli/") || path == "main.rs"
}

fn floor_of(module: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&module))
}

fn module_of(source: &Source) -> String {
    source.path.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_string()
}

pub fn forbidden_arrows(source: &Source) -> Vec<String> {
    let own = module_of(source);
    if own == "lib" {
        return Vec::new();
    }
    let Some(own_floor) = floor_of(&own) else {
        return vec![format!("src/{}: module `{own}` is in no floor of tests/architecture.rs", source.path)];
    };
    let mut complaints = Vec::new();
    for used in source.used_paths() {
        let root = match used.segments.first().map_or("", String::as_str) {
            "Error" | "Result" => "error",
            root => root,
        };
        if root != own && floor_of(root).is_some_and(|floor| floor >= own_floor) {
            let path = used.segments.join("::");
            complaints.push(format!(
                "src/{}:{}: `{own}` must not use `{path}`: arrows point down to {}",
                source.path,
                used.line,
                FLOORS[..own_floor].concat().join(", ")
            ));
        }
    }
    complaints
}

/// What a public module of the library has besides `pub use` and documentation.
pub fn more_than_names(source: &Source) -> Vec<String> {
    if !FACADE.contains(&module_of(source).as_str()) {
        return Vec::new();
    }
    let statements = source.code.split(';').map(str::trim);
    statements
        .filter(|statement| !statement.is_empty() && !statement.starts_with("pub use crate::"))
        .map(|statement| format!("src/{}: a public module only names items: {statement}", source.path))
        .collect()
}

pub fn packages_out_of_place(source: &Source) -> Vec<String> {
    let mut complaints = Vec::new();
    for (package, places) in PACKAGES_OF_ONE_JOB {
        if places.iter().any(|place| source.path.starts_with(place)) {
            continue;
        }
        for line in source.lines_naming_package(package) {
            complaints.push(format!(
                "src/{}:{line}: package `{package}` is named in src/{} only",
                source.path,
                places.join(", src/")
            ));
        }
    }
    complaints
}

pub fn unwraps(source: &Source) -> Vec<String> {
    let lines = source.code.lines().enumerate().filter(|(_, line)| line.contains(".unwrap()"));
    lines
        .map(|(i, _)| format!("src/{}:{}: unwrap: say expect(\"why this cannot be\")", source.path, i + 1))
        .collect()
}

pub fn noise(source: &Source) -> Vec<String> {
    if is_face(&source.path) {
        return Vec::new();
    }
    let tokens = tokens(&source.code);
    let mut complaints = Vec::new();
    for pair in tokens.windows(2) {
        if pair[1].text == "!" && FORBIDDEN_MACROS.contains(&pair[0].text) {
            complaints.push(format!("src/{}:{}: {}! in a library", source.path, pair[0].line, pair[0].text));
        }
    }
    if source.code.contains("process::exit") {
        complaints.push(format!("src/{}: only the program's face exits", source.path));
    }
    complaints
}

pub fn wgpu_in_layers(source: &Source) -> Vec<String> {
    if source.path.starts_with("layers/") && source.text.contains("wgpu") {
        return vec![format!("src/{}: `layers` is written without the word wgpu", source.path)];
    }
    Vec::new()
}

pub fn missing_header(path: &str, text: &str) -> Option<String> {
    (!text.starts_with("//! ")).then(|| format!("{path}: the first line says what the file is: `//! …`"))
}

pub fn too_long(path: &str, text: &str) -> Option<String> {
    let lines = text.lines().count();
    (lines > LONGEST_FILE).then(|| format!("{path}: {lines} lines, at most {LONGEST_FILE}"))
}

/// Folders of somebody's machine do not belong into the project.
pub fn machine_paths(path: &str, text: &str) -> Vec<String> {
    // Put together here, so that this file does not name them itself.
    const PRIVATE: &[&str] =
        &[concat!("/ro", "ot/"), concat!("/wo", "rk/"), concat!("/ho", "me/"), concat!("\\Us", "ers\\")];
    let lines = text.lines().enumerate();
    lines
        .filter(|(_, line)| PRIVATE.iter().any(|private| names_folder(line, private)))
        .map(|(i, line)| format!("{path}:{}: a path of one machine: {}", i + 1, line.trim()))
        .collect()
}

/// `private` as the beginning of a path, not as a part of a longer one or of an address.
fn names_folder(line: &str, private: &str) -> bool {
    line.match_indices(private).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || matches!(c, '.' | '-' | '_' | '/' | '}' | '>' | '*'))
    })
}

/// Packages that `source` and its siblings never name, out of those that `manifest` depends on.
pub fn unused_packages(manifest: &str, sources: &[Source]) -> Vec<String> {
    let section = manifest.split("\n[dependencies]\n").nth(1).unwrap_or_default();
    let section = section.split("\n[").next().unwrap_or_default();
    // What stands below this line in the manifest says there why it is never named.
    let named = section.split("# Never named").next().unwrap_or_default();
    let packages =
        named.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = "));
    packages
        .map(|(package, _)| package.replace('-', "_"))
        .filter(|package| sources.iter().all(|source| source.lines_naming_package(package).is_empty()))
        .map(|package| format!("Cargo.toml: no source names the package `{package}`"))
        .collect()
}
