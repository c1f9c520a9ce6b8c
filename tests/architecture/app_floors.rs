//! The floors of the window's room, and the drawing functions that can change the whole editor.

use std::collections::BTreeSet;

use super::source::{Source, tokens};

/// What the folders of `src/app` may use of each other. `shell` is the top and may use all.
const MAY_USE: &[(&str, &[&str])] = &[
    ("state", &[]),
    ("widget", &[]),
    ("work", &["state"]),
    ("action", &["state", "work"]),
    ("command", &["state"]),
    ("panel", &["state", "widget", "command"]),
    ("shell", &["state", "widget", "work", "action", "command", "panel"]),
];

/// The folder or file of `src/app` that a path or a file belongs to.
fn floor_of(path: &[String]) -> &str {
    match path {
        [app, floor, ..] if app == "app" => floor.trim_end_matches(".rs"),
        _ => "",
    }
}

fn parts(source: &Source) -> Vec<String> {
    source.path.split('/').map(str::to_owned).collect()
}

fn is_floor(name: &str) -> bool {
    MAY_USE.iter().any(|(floor, _)| *floor == name)
}

/// The names that a file on a floor uses of what is above it, each once.
fn above(source: &Source) -> BTreeSet<String> {
    let own = parts(source);
    let own = floor_of(&own);
    let Some((_, may_use)) = MAY_USE.iter().find(|(floor, _)| *floor == own) else { return BTreeSet::new() };
    let is_above = |path: &Vec<String>| {
        let floor = floor_of(path);
        path.len() > 1 && path[0] == "app" && floor != own && !may_use.contains(&floor)
    };
    let used = source.used_paths().into_iter().map(|used| used.segments).filter(is_above);
    used.map(|path| path.join("::")).collect()
}

/// Arrows between the floors of `src/app` that point up.
pub fn arrows_in_app(sources: &[Source]) -> Vec<String> {
    let in_app = sources.iter().filter(|source| source.path.starts_with("app/"));
    let complaint = |source: &Source| {
        let above = above(source);
        let names = above.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        (!above.is_empty()).then(|| format!("src/{}: uses what is above its floor: {names}", source.path))
    };
    in_app.filter_map(complaint).collect()
}

/// Files of `src/app` that are on no floor.
pub fn files_beside_the_floors(sources: &[Source]) -> Vec<String> {
    let in_app =
        sources.iter().filter(|source| source.path.starts_with("app/") && source.path != "app/mod.rs");
    let beside = in_app.filter(|source| !is_floor(floor_of(&parts(source))));
    beside.map(|source| format!("src/{}: is on no floor", source.path)).collect()
}

/// Files of `state`, `work` and `action` that name the toolkit.
pub fn toolkit_below(sources: &[Source]) -> Vec<String> {
    let names = |source: &&Source| {
        let below =
            ["app/state/", "app/work/", "app/action/"].iter().any(|floor| source.path.starts_with(floor));
        below && tokens(&source.code).iter().any(|token| token.text == "egui" || token.text == "eframe")
    };
    sources.iter().filter(names).map(|source| format!("src/{}: names the toolkit", source.path)).collect()
}

/// Functions of `src/app` that take `&mut Editor`, as `file: count`.
pub fn takes_the_editor(sources: &[Source]) -> Vec<(String, usize)> {
    let count = |source: &Source| {
        let tokens = tokens(&source.code);
        let takes = |at: &usize| {
            let word = |by: usize| tokens.get(at + by).map_or("", |token| token.text);
            word(0) == "&" && word(1) == "mut" && word(2) == "Editor"
        };
        (0..tokens.len()).filter(takes).count()
    };
    let in_app = sources.iter().filter(|source| source.path.starts_with("app/"));
    in_app.map(|source| (source.path.clone(), count(source))).filter(|(_, count)| *count > 0).collect()
}

#[test]
fn an_arrow_up_in_the_window_is_found_and_one_down_is_fine() {
    let file = |path: &str, text: &str| above(&Source::new(path, text)).len();
    assert_eq!(file("app/state/notes.rs", "use crate::command::words;"), 1);
    assert_eq!(file("app/panel/menu.rs", "use crate::{action::apply, work::Work};"), 2);
    assert_eq!(file("app/command/file.rs", "use super::super::panel::counted;"), 1);
    assert_eq!(file("app/work/jobs.rs", "use crate::panel::x; use super::waker::Waker;"), 1);
    assert_eq!(file("app/panel/menu.rs", "use super::row; use crate::{state::State, widget::dialog};"), 0);
    assert_eq!(file("app/action/mod.rs", "use super::work::Work; use quadratura::testing::files::lock;"), 0);
    assert_eq!(file("app/shell/editor.rs", "use crate::{action::apply, work::Work, panel};"), 0);
}
