//! Circles: files of one room that import each other, directly or by others.

use std::collections::BTreeMap;

use petgraph::algo::tarjan_scc;
use petgraph::graph::DiGraph;

use super::source::Source;

/// The largest circle of files of a room that import each other: more cannot be read one after the other.
pub const LARGEST_CIRCLE: usize = 4;

/// The files of a room that import each other, directly or by others: the largest such circle, sorted; empty where there is none. A file
/// imports what it names through `crate::`, `super::` or `self::`.
pub fn largest_circle(room: &str, sources: &[Source]) -> Vec<String> {
    let is_in_room = |source: &&Source| source.path.split_once('/').is_some_and(|(first, _)| first == room);
    let files: Vec<&Source> = sources.iter().filter(is_in_room).collect();
    let places: BTreeMap<Vec<String>, usize> =
        files.iter().enumerate().map(|(place, source)| (source.module_path(), place)).collect();
    let home =
        |path: &[String]| (1..=path.len()).rev().find_map(|length| places.get(&path[..length]).copied());
    let imports_of = |(place, source): (usize, &&Source)| -> Vec<(u32, u32)> {
        let used = source.used_paths();
        used.iter().filter_map(|used| Some((place as u32, home(&used.segments)? as u32))).collect()
    };
    let imports = DiGraph::<(), ()>::from_edges(files.iter().enumerate().flat_map(imports_of));
    let circles = tarjan_scc(&imports).into_iter().filter(|circle| circle.len() > 1);
    let circle = circles.max_by_key(Vec::len).unwrap_or_default();
    let mut names: Vec<String> = circle.into_iter().map(|place| files[place.index()].path.clone()).collect();
    names.sort();
    names
}

/// What is wrong with the largest circle of a room.
pub fn too_large(room: &str, circle: &[String]) -> Option<String> {
    let (found, names) = (circle.len(), circle.join(", "));
    (found > LARGEST_CIRCLE).then(|| format!("src/{room}: {found} files import each other: {names}"))
}

#[test]
fn files_that_import_each_other_are_a_circle_and_what_only_points_into_it_is_in_none() {
    let sources = [
        Source::new("app/a.rs", "use super::b::B;"),
        Source::new("app/b/mod.rs", "use self::c::C;"),
        Source::new("app/b/c.rs", "use crate::a::A; use quadratura::testing::files::lock;"),
        Source::new("app/d.rs", "use super::a::A;"),
        Source::new("io/a.rs", "use super::b::B;"),
        Source::new("io/b.rs", "fn f() -> crate::a::A { crate::b::g() }"),
        Source::new("gpu/a.rs", "use super::b::B;\n#[cfg(test)]\nmod tests {\n    use super::*;\n}"),
        Source::new("gpu/b.rs", "use quadratura_io::a::A; // use super::a::A;"),
    ];
    assert_eq!(largest_circle("app", &sources), ["app/a.rs", "app/b/c.rs", "app/b/mod.rs"]);
    assert_eq!(largest_circle("io", &sources), ["io/a.rs", "io/b.rs"]);
    assert_eq!(largest_circle("gpu", &sources), [""; 0]);
}

#[test]
fn a_circle_that_is_too_large_is_found() {
    let circle = |size: usize| -> Vec<String> { (0..size).map(|file| format!("io/{file}.rs")).collect() };
    let found = |size: usize| too_large("io", &circle(size)).is_some();
    assert!(!found(0) && !found(LARGEST_CIRCLE) && found(LARGEST_CIRCLE + 1));
}
