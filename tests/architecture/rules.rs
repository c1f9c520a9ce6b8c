//! The rules themselves: each a function from a source to what it complains about.

use super::source::{Source, tokens};

/// The public modules of the library: they name items of the rooms for programs that embed it.
pub const FACADE: &[&str] =
    &["cameras", "site", "project", "sort", "stack", "fill", "layered", "render", "edit", "error", "task"];

/// The rooms, each a package, from the ground up. A room uses only floors below its own: neighbours on one floor do not know
/// each other.
pub const FLOORS: &[&[&str]] = &[
    &["base"],
    &["files", "view", "align"],
    &["import", "suggest", "page"],
    &["projection", "foliage", "ldi"],
    &["layers"],
    &["document"],
    &["layered_files"],
    &["io"],
    &["handover"],
    &["sites"],
    &["stacks"],
    &["trees"],
    &["views"],
    &["editing"],
    &["images", "exports", "gpu"],
    &["app"],
    &["cli"],
];

/// Packages that one job needs, and the only places below `src/` that name them. Only the manifests of these rooms have them.
const PACKAGES_OF_ONE_JOB: &[(&str, &[&str])] = &[
    ("wgpu", &["gpu/"]),
    ("pollster", &["gpu/"]),
    ("block_compression", &["gpu/blocks.rs"]),
    ("half", &["gpu/", "layered_files/xcf/"]),
    ("spade", &["base/geometry/"]),
    ("i_overlay", &["base/geometry/"]),
    ("gltf", &["import/models/", "foliage/files/gltf/"]),
    ("exr", &["io/depth_image/", "io/layers_exr.rs", "io/picture_exr.rs"]),
    ("image", &["import/photo/", "io/", "page/", "handover/textured/encoded.rs"]),
    ("jpeg_encoder", &["page/"]),
    ("exif", &["import/photo/"]),
    ("png", &["files/png_error.rs", "import/photo/", "io/", "layered_files/"]),
    ("csv", &["foliage/files/list.rs"]),
    ("unicode_normalization", &["base/scene/alike.rs"]),
    ("chardetng", &["files/text.rs"]),
    ("encoding_rs", &["files/text.rs"]),
    ("moxcms", &["io/colour.rs"]),
    ("notify_debouncer_full", &["io/watch.rs"]),
    ("zip", &["layered_files/ora/", "import/cameras/metashape/", "handover/textured/usd/"]),
    ("flate2", &["files/deflated.rs", "layered_files/", "io/ortho/", "ldi/file/", "import/photo/tiff/"]),
    ("weezl", &["import/photo/tiff/"]),
    ("roxmltree", &["layered_files/", "import/cameras/"]),
    ("tempfile", &["files/", "io/", "layered_files/", "page/"]),
    ("petgraph", &["layers/"]),
    ("sysinfo", &["sites/", "cli/"]),
    ("clap", &["cli/"]),
    ("clap_complete", &["cli/"]),
    ("clap_mangen", &["cli/"]),
    ("indicatif", &["cli/"]),
    ("ctrlc", &["cli/"]),
    ("eframe", &["app/"]),
    ("egui_tiles", &["app/shell/pane_layout.rs"]),
    ("rfd", &["app/"]),
    ("pulldown_cmark", &["app/work/pages.rs"]),
    ("rustix", &["app/shell/frame_times.rs", "app/work/priority.rs"]),
    // `cli` is the program, in src/main.rs.
    ("libc", &["main.rs"]),
    // The readers of photos have a module of this name.
    ("tiff", &["import/photo/", "io/ortho/"]),
    ("pdf_writer", &["io/ortho/"]),
    ("postcard", &["files/cached.rs"]),
    ("thiserror", &["base/error/mod.rs"]),
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

fn floor_of(room: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&room))
}

fn module_of(source: &Source) -> String {
    source.path.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_string()
}

/// Rooms that the manifest of `room` names, for its code or for its tests, and that are not below it.
pub fn forbidden_rooms(room: &str, manifest: &str) -> Vec<String> {
    let Some(own) = floor_of(room) else {
        return vec![format!("src/{room}: is on no floor of tests/architecture/rules.rs")];
    };
    let used =
        dependencies(manifest).into_iter().filter_map(|(_, package)| package.strip_prefix("quadratura-"));
    used.map(|used| used.replace('-', "_"))
        .filter(|used| floor_of(used).is_none_or(|floor| floor >= own))
        .map(|used| {
            let below = FLOORS[..own].concat().join(", ");
            format!("src/{room}/Cargo.toml: `{room}` must not use `{used}`: arrows point down to {below}")
        })
        .collect()
}

/// The packages that a manifest names, each with the section that it stands in.
fn dependencies(manifest: &str) -> Vec<(&str, &str)> {
    let (mut section, mut found) = ("", Vec::new());
    for line in manifest.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']');
        } else if section.ends_with("dependencies") && !line.starts_with('#') {
            let name = line.split_once(" = ").map_or("", |(name, _)| name);
            found.extend((!name.is_empty()).then(|| (section, name.trim_end_matches(".workspace"))));
        }
    }
    found
}

/// The packages that the code needs, tests left out, as the code calls them.
fn packages(manifest: &str) -> Vec<String> {
    let of_code = dependencies(manifest).into_iter().filter(|(section, _)| *section != "dev-dependencies");
    of_code.map(|(_, package)| package.replace('-', "_")).collect()
}

/// Packages of one job in the manifest of a room that has another.
pub fn dependencies_out_of_place(room: &str, manifest: &str) -> Vec<String> {
    let has = |places: &[&str]| places.iter().any(|place| place.split('/').next() == Some(room));
    let strays = packages(manifest)
        .into_iter()
        .filter(|package| PACKAGES_OF_ONE_JOB.iter().any(|(name, places)| name == package && !has(places)));
    strays.map(|package| format!("src/{room}/Cargo.toml: has no use for the package `{package}`")).collect()
}

/// What a public module of the library has besides `pub use` and documentation.
pub fn more_than_names(source: &Source) -> Vec<String> {
    if !FACADE.contains(&module_of(source).as_str()) {
        return Vec::new();
    }
    let statements = source.code.split(';').map(str::trim);
    statements
        .filter(|statement| {
            // Without the attribute, the documentation would only say where an item comes from.
            let item = statement.strip_prefix("#[doc(inline)]").unwrap_or_default().trim_start();
            !statement.is_empty() && !item.starts_with("pub use quadratura_")
        })
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

/// Packages that `sources`, which are those of one package, never name, out of those that its manifest at `path` depends on.
pub fn unused_packages(path: &str, manifest: &str, sources: &[&Source]) -> Vec<String> {
    // What stands below this line in the manifest says there why it is never named.
    let (named, rest) = manifest.split_once("# Never named").unwrap_or((manifest, ""));
    let rest = rest.split_once("\n[").map_or("", |(_, rest)| rest);
    packages(named)
        .into_iter()
        .chain(packages(&format!("[{rest}")))
        .filter(|package| sources.iter().all(|source| source.lines_naming_package(package).is_empty()))
        .map(|package| format!("{path}: no source names the package `{package}`"))
        .collect()
}

/// Packages of the workspace that no member's manifest names.
pub fn unused_in_workspace(root: &str, members: &[String]) -> Vec<String> {
    let all = dependencies(root).into_iter().filter(|(section, _)| *section == "workspace.dependencies");
    let is_used = |package: &str| {
        let all = members.iter().map(String::as_str).chain([root]).flat_map(dependencies);
        all.into_iter().any(|(section, other)| section != "workspace.dependencies" && other == package)
    };
    all.filter(|(_, package)| !is_used(package))
        .map(|(_, package)| format!("Cargo.toml: no package of the workspace uses `{package}`"))
        .collect()
}
