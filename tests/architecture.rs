//! The house rules that a compiler does not hold: which package may use which, which package of others is named
//! where, and what library code never does. `src/lib.rs` says them in words, the tables in
//! `architecture/rules.rs` in full.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "architecture/app_floors.rs"]
mod app_floors;
#[path = "architecture/circles.rs"]
mod circles;
#[path = "architecture/floors.rs"]
mod floors;
#[path = "architecture/retired.rs"]
mod retired;
#[path = "architecture/rules.rs"]
mod rules;
#[path = "architecture/source.rs"]
mod source;

use app_floors::{arrows_in_app, files_beside_the_floors, takes_the_editor, toolkit_below};
use circles::{largest_circle, too_large};
use floors::{Floors, ROOMS_WITH_FLOORS};
use retired::{retired_in, words_of};
use rules::{
    FACADE, FLOORS, LONGEST_FILE, dependencies_out_of_place, forbidden_rooms, machine_paths, missing_header,
    more_than_names, noise, packages_out_of_place, too_long, unused_in_workspace, unused_packages, unwraps,
    wgpu_in_layers,
};
use source::{Source, without_literals};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files below `folder` (relative to the project) whose names end in one of `endings`, sorted.
fn files(folder: &str, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if endings.iter().any(|ending| path.to_string_lossy().ends_with(ending)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The file's path relative to `folder` of the project, with `/`.
fn relative(path: &Path, folder: &str) -> String {
    let base = root().join(folder);
    path.strip_prefix(base).expect("files() looks below it").to_string_lossy().replace('\\', "/")
}

fn sources() -> Vec<Source> {
    let read = |path: PathBuf| Source::new(&relative(&path, "src"), &fs::read_to_string(&path).unwrap());
    let sources: Vec<_> = files("src", &[".rs"]).into_iter().map(read).collect();
    assert!(!sources.is_empty(), "no sources found below {}", root().display());
    sources
}

/// The rooms, each with its manifest, sorted.
fn manifests() -> Vec<(String, String)> {
    let room = |path: &PathBuf| relative(path, "src").trim_end_matches("/Cargo.toml").to_owned();
    let manifests: Vec<_> = files("src", &["/Cargo.toml"])
        .iter()
        .map(|path| (room(path), fs::read_to_string(path).unwrap()))
        .collect();
    assert_eq!(manifests.len(), FLOORS.concat().len(), "every room is a package, and every package a room");
    manifests
}

fn texts(folders: &[&str], endings: &[&str]) -> Vec<(String, String)> {
    let paths = folders.iter().flat_map(|folder| files(folder, endings));
    paths.map(|path| (relative(&path, ""), fs::read_to_string(&path).unwrap())).collect()
}

#[track_caller]
fn assert_none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn packages_use_only_those_below_them() {
    assert_none(manifests().iter().flat_map(|(room, manifest)| forbidden_rooms(room, manifest)).collect());
}

#[test]
fn modules_of_a_room_use_only_those_of_their_floor_and_of_lower_ones() {
    let sources = sources();
    for room in ROOMS_WITH_FLOORS {
        let root = sources.iter().find(|source| source.path == format!("{room}/mod.rs"));
        let floors = Floors::new(root.unwrap_or_else(|| panic!("src/{room}/mod.rs is missing")));
        assert_none(floors.strays(&sources));
        assert_none(sources.iter().flat_map(|source| floors.forbidden_arrows(source)).collect());
    }
}

#[test]
fn a_package_that_one_job_needs_is_named_in_one_place() {
    let manifests = manifests();
    let in_manifests =
        manifests.iter().flat_map(|(room, manifest)| dependencies_out_of_place(room, manifest));
    assert_none(in_manifests.chain(sources().iter().flat_map(packages_out_of_place)).collect());
}

#[test]
fn every_package_has_a_user() {
    let (sources, manifests) = (sources(), manifests());
    let of = |room: &str| -> Vec<&Source> {
        sources
            .iter()
            .filter(|source| source.path.split_once('/').map_or("", |(room, _)| room) == room)
            .collect()
    };
    let unused = |(room, manifest): &(String, String)| {
        unused_packages(&format!("src/{room}/Cargo.toml"), manifest, &of(room))
    };
    let root = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let (_, package) = root.split_once("\n[package]\n").expect("it is a package, too");
    let texts: Vec<String> = manifests.iter().map(|(_, manifest)| manifest.clone()).collect();
    let complaints = manifests.iter().flat_map(unused);
    let of_root = unused_packages("Cargo.toml", package, &of(""));
    assert_none(complaints.chain(of_root).chain(unused_in_workspace(&root, &texts)).collect());
}

#[test]
fn the_method_is_written_without_the_graphics_library() {
    assert_none(sources().iter().flat_map(wgpu_in_layers).collect());
}

#[test]
fn nothing_is_unwrapped_outside_tests() {
    assert_none(sources().iter().flat_map(unwraps).collect());
}

#[test]
fn libraries_return_errors_and_never_print() {
    assert_none(sources().iter().flat_map(noise).collect());
}

#[test]
fn every_file_says_what_it_is_and_can_be_read_in_one_sitting() {
    let all = texts(&["src", "tests", "examples", "benches"], &[".rs"]);
    let headers = all.iter().filter_map(|(path, text)| missing_header(path, text));
    let lengths = all.iter().filter_map(|(path, text)| too_long(path, text));
    assert_none(headers.chain(lengths).collect());
}

#[test]
fn no_file_knows_the_machine_it_was_written_on() {
    let endings = [".rs", ".wgsl", ".sh", ".py", ".scm", ".md", ".json", ".toml", ".svg"];
    let all = texts(&["src", "shaders", "tests", "examples", "benches", "docs", "projects", ".ci"], &endings);
    assert_none(all.iter().flat_map(|(path, text)| machine_paths(path, text)).collect());
}

#[test]
fn the_front_page_lists_the_packages_from_the_ground_up() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let rooms = text.split("# For contributors").nth(1).unwrap();
    let table: String = rooms.lines().filter(|line| line.starts_with("//! | `")).collect();
    let mut last = 0;
    for room in FLOORS.iter().copied().flatten() {
        let at = table.find(&format!("`{room}`")).unwrap_or_else(|| panic!("src/lib.rs: no `{room}`"));
        assert!(at > last || last == 0, "src/lib.rs: `{room}` is listed too early");
        last = last.max(at);
    }
}

#[test]
fn the_public_modules_name_items_of_the_rooms_and_define_none() {
    assert_none(sources().iter().flat_map(more_than_names).collect());
}

#[test]
fn the_library_shows_its_public_modules_alone() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let public = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let expected = |module: &&str| FACADE.contains(module) || *module == "testing";
    assert_eq!(public.filter(|module| !expected(module)).collect::<Vec<_>>(), [""; 0]);
    let hidden = text.find("#[doc(hidden)]\npub mod testing;");
    assert!(hidden.is_some(), "nobody outside depends on `testing`");
}

#[test]
fn the_window_has_floors_and_its_arrows_point_down() {
    let sources = sources();
    let rules = [arrows_in_app, files_beside_the_floors, toolkit_below];
    assert_none(rules.iter().flat_map(|rule| rule(&sources)).collect());
}

#[test]
fn files_of_a_room_import_each_other_in_small_circles_only() {
    let sources = sources();
    let of_room = |room: &&str| too_large(room, &largest_circle(room, &sources));
    assert_none(FLOORS.concat().iter().filter_map(of_room).collect());
}

#[test]
fn what_draws_cannot_change_the_whole_editor() {
    let found = takes_the_editor(&sources());
    assert!(found.is_empty(), "{found:?}");
}

// ---- the rules can fail ----

/// What a rule says about a file of one line or more.
fn complaints_of(rule: fn(&Source) -> Vec<String>, path: &str, text: &str) -> usize {
    rule(&Source::new(path, text)).len()
}

#[test]
fn a_package_that_uses_one_above_or_beside_it_is_found() {
    let count = |room: &str, manifest: &str| forbidden_rooms(room, manifest).len();
    let above = "[dependencies]\nquadratura-gpu.workspace = true\nglam.workspace = true\n";
    assert_eq!(count("layers", above), 1);
    assert_eq!(count("exports", above), 1, "neighbours");
    assert_eq!(count("app", above), 0);
    assert_eq!(count("layers", "[dev-dependencies]\nquadratura-stacks = { workspace = true }\n"), 1, "tests");
    assert_eq!(count("layers", "[dependencies]\nquadratura-attic.workspace = true\n"), 1);
    assert_eq!(count("layers", "[dependencies]\n# quadratura-gpu = 1\n\n[lib]\nquadratura-cli = 1\n"), 0);
    assert_eq!(count("attic", ""), 1, "a room that is on no floor");
}

#[test]
fn a_package_out_of_place_is_found() {
    let rule = packages_out_of_place;
    assert_eq!(complaints_of(rule, "layers/projected_model.rs", "use wgpu::Device;"), 1);
    assert_eq!(complaints_of(rule, "cli/mod.rs", "fn f() { image::open(p); }"), 1);
    assert_eq!(complaints_of(rule, "stacks/x.rs", "use zip;"), 1);
    assert_eq!(complaints_of(rule, "gpu/device.rs", "use wgpu::Device;"), 0);
    assert_eq!(
        complaints_of(rule, "stacks/x.rs", "use quadratura_io::image::Image; let zip = 1; a.zip(b);"),
        0
    );
    let manifest = "[dependencies]\nwgpu.workspace = true\n\n[dev-dependencies]\nimage.workspace = true\n";
    assert_eq!(dependencies_out_of_place("stacks", manifest).len(), 1);
    assert_eq!(dependencies_out_of_place("gpu", manifest).len(), 0);
}

#[test]
fn a_package_without_a_user_is_found() {
    let manifest = "[package]\n\n[dependencies]\nclap-mangen.workspace = true\nzip = { workspace = true }\n\n[x]\ny = 1\n";
    let sources = [Source::new("io/a.rs", "use zip::write; // clap_mangen::f()")];
    let complaints = unused_packages("src/io/Cargo.toml", manifest, &[&sources[0]]);
    assert_eq!(complaints, ["src/io/Cargo.toml: no source names the package `clap_mangen`"]);
    let hidden =
        "[dependencies]\nzip = 1\n# Never named: a reason.\neither = 1\n\n[build-dependencies]\ncc = 1\n";
    assert_eq!(unused_packages("Cargo.toml", hidden, &[&sources[0]]).len(), 1);
    let root = "[workspace.dependencies]\nzip = \"9\"\nglam = \"1\"\npng = \"1\"\n\n[dependencies]\nglam.workspace = true\n";
    let unused = unused_in_workspace(root, &[manifest.to_owned()]);
    assert_eq!(unused, ["Cargo.toml: no package of the workspace uses `png`"]);
}

#[test]
fn code_in_a_public_module_is_found_and_names_without_documentation_are() {
    let rule = more_than_names;
    assert_eq!(
        complaints_of(rule, "edit.rs", "#[doc(inline)]\npub use quadratura_base::{Error, Result};\n"),
        0
    );
    assert_eq!(complaints_of(rule, "edit.rs", "pub use quadratura_base::Error;"), 1);
    assert_eq!(
        complaints_of(rule, "edit.rs", "#[doc(inline)]\npub use quadratura_base::Error;\nfn f() {}"),
        1
    );
}

#[test]
fn an_unwrap_and_a_print_are_found_in_code_only() {
    assert_eq!(complaints_of(unwraps, "io/a.rs", "fn f() {\n    g().unwrap();\n}"), 1);
    assert_eq!(complaints_of(unwraps, "io/a.rs", "#[cfg(test)]\nmod t { fn f() { g().unwrap(); } }"), 0);
    assert_eq!(complaints_of(unwraps, "io/a.rs", "/// `x.unwrap()`\nfn f() {}"), 0);
    assert_eq!(complaints_of(noise, "io/a.rs", "fn f() { println!(\"x\"); }"), 1);
    assert_eq!(complaints_of(noise, "io/a.rs", "fn f() { std::process::exit(1) }"), 1);
    assert_eq!(complaints_of(noise, "cli/mod.rs", "fn f() { println!(\"x\"); }"), 0);
}

#[test]
fn a_missing_header_a_long_file_and_a_private_folder_are_found() {
    assert!(missing_header("a.rs", "use std::fs;").is_some());
    assert!(missing_header("a.rs", "//! A file.").is_none());
    assert!(too_long("a.rs", &"\n".repeat(LONGEST_FILE + 1)).is_some());
    assert_eq!(machine_paths("a.rs", concat!("open(\"/ho", "me/me/x\")")).len(), 1);
    assert_eq!(machine_paths("a.md", concat!("https://example.org/ho", "me/me")).len(), 0);
}

#[test]
fn literals_and_comments_are_blanked_without_moving_a_line() {
    for (text, left) in [
        ("a // b\nc", "a     \nc"),
        ("a /* b /* c */ d */ e", "a                   e"),
        ("f(\"\\\"crate::x\", 'y', '\\'', 'a)", "f(            ,    ,     , 'a)"),
        ("r#\"a\"b\"# c", "         c"),
        ("br\"\\\" c; radius", "      c; radius"),
    ] {
        assert_eq!(without_literals(text), left, "{text}");
    }
}

#[test]
fn retired_words_stay_out_of_identifiers() {
    let list = fs::read_to_string(root().join("tests/retired_words.txt")).unwrap();
    let retired = words_of(&list);
    assert!(retired.len() > 10, "the list is read");
    let found: Vec<_> = sources().iter().flat_map(|source| retired_in(source, &retired)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
