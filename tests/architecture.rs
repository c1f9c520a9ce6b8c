//! The house rules that a compiler does not hold: which module may use which, which package is named
//! where, and what library code never does. `src/lib.rs` says them in words, the tables in
//! `architecture/rules.rs` in full.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "architecture/app_floors.rs"]
mod app_floors;
#[path = "architecture/retired.rs"]
mod retired;
#[path = "architecture/rules.rs"]
mod rules;
#[path = "architecture/source.rs"]
mod source;

use app_floors::{
    LARGEST_CIRCLE, arrows_in_app, files_beside_the_floors, largest_circle, takes_the_editor, toolkit_below,
};
use retired::{retired_in, words_of};
use rules::{
    FACADE, FLOORS, LONGEST_FILE, forbidden_arrows, machine_paths, missing_header, more_than_names, noise,
    packages_out_of_place, too_long, unused_packages, unwraps, wgpu_in_layers,
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

fn texts(folders: &[&str], endings: &[&str]) -> Vec<(String, String)> {
    let paths = folders.iter().flat_map(|folder| files(folder, endings));
    paths.map(|path| (relative(&path, ""), fs::read_to_string(&path).unwrap())).collect()
}

#[track_caller]
fn assert_none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn arrows_point_down() {
    assert_none(sources().iter().flat_map(forbidden_arrows).collect());
}

#[test]
fn a_package_that_one_job_needs_is_named_in_one_place() {
    assert_none(sources().iter().flat_map(packages_out_of_place).collect());
}

#[test]
fn every_package_has_a_user() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    assert_none(unused_packages(&manifest, &sources()));
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
fn the_front_page_lists_the_modules_from_the_ground_up() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let rooms = text.split("# For contributors").nth(1).unwrap();
    let table: String = rooms.lines().filter(|line| line.starts_with("//! | `")).collect();
    let mut last = 0;
    let unlisted = |module: &str| FACADE.contains(&module) || ["testing", "main"].contains(&module);
    for module in FLOORS.iter().copied().flatten().filter(|m| !unlisted(m)) {
        let at = table.find(&format!("`{module}`")).unwrap_or_else(|| panic!("src/lib.rs: no `{module}`"));
        let floor_is_shared = ["io", "gpu"].contains(module);
        assert!(at > last || floor_is_shared || last == 0, "src/lib.rs: `{module}` is listed too early");
        last = last.max(at);
    }
}

#[test]
fn the_public_modules_name_items_of_the_rooms_and_define_none() {
    assert_none(sources().iter().flat_map(more_than_names).collect());
}

#[test]
fn every_room_is_private() {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let public = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let expected = |module: &&str| FACADE.contains(module) || ["error", "task", "testing"].contains(module);
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
fn files_of_the_window_import_each_other_in_small_circles_only() {
    let circle = largest_circle(&sources());
    println!("largest circle of files in src/app: {}", circle.len());
    let names = circle.join(", ");
    assert!(circle.len() <= LARGEST_CIRCLE, "{} files import each other: {names}", circle.len());
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
fn an_arrow_that_points_up_is_found_however_it_is_written() {
    for text in [
        "use crate::gpu::Gpu;",
        "use crate::{error::Error, gpu::{self, Gpu}};",
        "use super::super::gpu::Gpu;",
        "fn f() -> crate::gpu::Gpu { todo() }",
        "use crate::{\n    error::Error as E,\n    cli,\n};",
        "use super::{super::recipe::build, view};",
    ] {
        assert_ne!(complaints_of(forbidden_arrows, "layers/view.rs", text), 0, "{text}");
    }
    assert_eq!(complaints_of(forbidden_arrows, "io/png.rs", "use crate::gpu::Gpu;"), 1, "neighbours");
    assert_eq!(complaints_of(forbidden_arrows, "attic/x.rs", ""), 1, "a room that is on no floor");
}

#[test]
fn an_arrow_that_points_down_and_one_within_the_module_are_fine() {
    for text in [
        "use crate::geometry::Plane;",
        "use crate::{Error, Result};",
        "use super::view::View;",
        "use crate::layers::options::Options;",
        "// use crate::gpu::Gpu;",
        "const A: &str = \"crate::gpu\";",
        "#[cfg(test)]\nmod tests {\n    use crate::gpu::Gpu;\n}",
        "use wgpu_like::gpu::X;",
    ] {
        assert_eq!(complaints_of(forbidden_arrows, "layers/view.rs", text), 0, "{text}");
    }
    assert_eq!(complaints_of(forbidden_arrows, "main.rs", "fn main() { quadratura::run() }"), 0);
}

#[test]
fn a_package_out_of_place_is_found() {
    let rule = packages_out_of_place;
    assert_eq!(complaints_of(rule, "layers/view.rs", "use wgpu::Device;"), 1);
    assert_eq!(complaints_of(rule, "cli/mod.rs", "fn f() { image::open(p); }"), 1);
    assert_eq!(complaints_of(rule, "recipe/x.rs", "use zip;"), 1);
    assert_eq!(complaints_of(rule, "gpu/device.rs", "use wgpu::Device;"), 0);
    assert_eq!(complaints_of(rule, "recipe/x.rs", "use crate::io::image::Image; let zip = 1; a.zip(b);"), 0);
}

#[test]
fn a_package_without_a_user_is_found() {
    let manifest =
        "[package]\n\n[dependencies]\nclap-mangen = \"1\"\nzip = { version = \"9\" }\n\n[x]\ny = 1\n";
    let sources = [Source::new("io/a.rs", "use zip::write; // clap_mangen::f()")];
    let complaints = unused_packages(manifest, &sources);
    assert_eq!(complaints, ["Cargo.toml: no source names the package `clap_mangen`"]);
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
