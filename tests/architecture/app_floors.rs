//! The floors of the window's room, the files of it that import each other in a circle, and the drawing functions that
//! can change the whole editor.

use std::collections::{BTreeMap, BTreeSet};

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

/// The largest circle of files of `src/app` that import each other: more cannot be read one after the other.
pub const LARGEST_CIRCLE: usize = 8;

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

/// The files of `src/app` that import each other, directly or by others: the largest such circle, sorted.
pub fn largest_circle(sources: &[Source]) -> Vec<String> {
    let app: Vec<&Source> = sources.iter().filter(|source| source.path.starts_with("app/")).collect();
    let places: BTreeMap<Vec<String>, usize> =
        app.iter().enumerate().map(|(place, source)| (source.module_path(), place)).collect();
    let home =
        |path: &[String]| (1..=path.len()).rev().find_map(|length| places.get(&path[..length]).copied());
    let uses = |source: &&Source| -> Vec<usize> {
        source.used_paths().iter().filter_map(|used| home(&used.segments)).collect()
    };
    let uses: Vec<Vec<usize>> = app.iter().map(uses).collect();
    let circle = circles(&uses).into_iter().max_by_key(Vec::len).unwrap_or_default();
    let mut names: Vec<String> = circle.into_iter().map(|place| app[place].path.clone()).collect();
    names.sort();
    names
}

/// The strongly connected components of a graph, which holds for each place those that it points to: Tarjan's
/// algorithm (Depth-first search and linear graph algorithms, SIAM J. Comput. 1972), without recursion.
fn circles(points_to: &[Vec<usize>]) -> Vec<Vec<usize>> {
    const NEW: usize = usize::MAX;
    let count = points_to.len();
    let (mut number, mut low, mut is_open) = (vec![NEW; count], vec![NEW; count], vec![false; count]);
    let (mut next, mut open, mut found) = (0, Vec::new(), Vec::new());
    for root in 0..count {
        let mut path = if number[root] == NEW { vec![(root, 0)] } else { Vec::new() };
        while let Some((place, done)) = path.last_mut() {
            let place = *place;
            if *done == 0 && number[place] == NEW {
                (number[place], low[place], is_open[place]) = (next, next, true);
                next += 1;
                open.push(place);
            }
            if let Some(to) = points_to[place].get(*done).copied() {
                *done += 1;
                if number[to] == NEW {
                    path.push((to, 0));
                } else if is_open[to] {
                    low[place] = low[place].min(number[to]);
                }
                continue;
            }
            path.pop();
            if let Some((above, _)) = path.last() {
                low[*above] = low[*above].min(low[place]);
            }
            if low[place] == number[place] {
                let begin =
                    open.iter().rposition(|other| *other == place).expect("it was opened and not closed");
                let circle: Vec<usize> = open.drain(begin..).collect();
                circle.iter().for_each(|place| is_open[*place] = false);
                found.push(circle);
            }
        }
    }
    found
}

#[test]
fn circles_are_found_and_what_only_points_into_one_is_in_none() {
    let mut found = circles(&[vec![1], vec![2, 3], vec![0], vec![4], vec![], vec![0, 5]]);
    found.iter_mut().for_each(|circle| circle.sort_unstable());
    found.sort();
    assert_eq!(found, [vec![0, 1, 2], vec![3], vec![4], vec![5]]);
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

#[test]
fn files_that_import_each_other_are_a_circle() {
    let sources = [
        Source::new("app/a.rs", "use super::b::B;"),
        Source::new("app/b/mod.rs", "use self::c::C;"),
        Source::new("app/b/c.rs", "use crate::a::A; use quadratura::testing::files::lock;"),
        Source::new("app/d.rs", "use super::a::A;"),
    ];
    assert_eq!(largest_circle(&sources), ["app/a.rs", "app/b/c.rs", "app/b/mod.rs"]);
}
