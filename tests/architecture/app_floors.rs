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

/// Files on a floor that still use something above it, and how many names of it they use. It may only shrink: the
/// number goes down with what was moved, and a file without any is taken off.
const STILL_ABOVE: &[(&str, usize)] = &[
    ("app/action/build.rs", 15),
    ("app/action/decide.rs", 4),
    ("app/action/flat.rs", 1),
    ("app/action/life.rs", 3),
    ("app/action/masks.rs", 10),
    ("app/action/mod.rs", 25),
    ("app/command/file.rs", 2),
    ("app/command/mask.rs", 3),
    ("app/panel/colour.rs", 2),
    ("app/panel/dialogs.rs", 3),
    ("app/panel/fill/mod.rs", 3),
    ("app/panel/fill/propagated.rs", 2),
    ("app/panel/fill/worst.rs", 2),
    ("app/panel/help.rs", 1),
    ("app/panel/inspector.rs", 4),
    ("app/panel/layer_options.rs", 2),
    ("app/panel/masks.rs", 4),
    ("app/panel/menu.rs", 1),
    ("app/panel/mod.rs", 2),
    ("app/panel/notes.rs", 1),
    ("app/panel/paint.rs", 5),
    ("app/panel/palette.rs", 1),
    ("app/panel/photos.rs", 1),
    ("app/panel/settings.rs", 1),
    ("app/panel/side.rs", 1),
    ("app/panel/status.rs", 1),
    ("app/panel/welcome.rs", 5),
    ("app/shell/crash.rs", 3),
    ("app/shell/editor.rs", 5),
    ("app/shell/layout.rs", 4),
    ("app/state/ask.rs", 7),
    ("app/state/mod.rs", 11),
    ("app/state/session.rs", 1),
    ("app/state/settings.rs", 4),
    ("app/work/jobs.rs", 1),
    ("app/work/mod.rs", 6),
];

/// Rooms of `src/app` that are on no floor yet, and how many files they have at most. It may only shrink.
const NOT_MOVED: &[(&str, usize)] = &[
    ("check", 2),
    ("flat", 5),
    ("flight", 3),
    ("layer", 2),
    ("masking", 8),
    ("opening", 9),
    ("photo", 6),
    ("pictures", 1),
    ("quality", 4),
    ("space", 9),
];

/// Files of `state` that still name the toolkit, and files of `work` that do. They may only get fewer.
const STILL_EGUI: &[&str] = &["app/work/painter/mod.rs"];

/// The largest circle of files of `src/app` that import each other. It may only shrink; 8 is wanted.
pub const LARGEST_CIRCLE: usize = 90;

/// Functions that take `&mut Editor`. They may only get fewer; none is wanted outside of the shell.
pub const TAKE_THE_EDITOR: usize = 80;

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

/// Arrows between the floors of `src/app` that point up, beyond what the table still allows.
pub fn arrows_in_app(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut left: BTreeMap<&str, usize> = STILL_ABOVE.iter().copied().collect();
    for source in sources.iter().filter(|source| source.path.starts_with("app/")) {
        let above = above(source);
        let allowed = left.remove(source.path.as_str()).unwrap_or(0);
        if above.len() > allowed {
            let names = above.into_iter().collect::<Vec<_>>().join(", ");
            complaints.push(format!("src/{}: uses what is above its floor: {names}", source.path));
        } else if above.len() < allowed {
            let count = above.len();
            complaints.push(format!(
                "src/{}: {count} names above its floor, so the table says {count}",
                source.path
            ));
        }
    }
    complaints.extend(left.keys().map(|path| format!("src/{path} is gone: it is taken off the table")));
    complaints
}

/// Rooms of `src/app` that are on no floor, beyond what the table still allows.
pub fn rooms_beside_the_floors(sources: &[Source]) -> Vec<String> {
    let mut files: BTreeMap<String, usize> = BTreeMap::new();
    for source in
        sources.iter().filter(|source| source.path.starts_with("app/") && source.path != "app/mod.rs")
    {
        let path = parts(source);
        if !is_floor(floor_of(&path)) {
            *files.entry(floor_of(&path).to_owned()).or_default() += 1;
        }
    }
    let most = |room: &str| NOT_MOVED.iter().find(|(known, _)| *known == room).map_or(0, |(_, most)| *most);
    let large = files.iter().filter(|(room, count)| **count > most(room));
    let mut complaints: Vec<String> =
        large.map(|(room, count)| format!("src/app/{room}: {count} files on no floor")).collect();
    let gone = NOT_MOVED.iter().filter(|(room, _)| !files.contains_key(*room));
    complaints.extend(gone.map(|(room, _)| format!("src/app/{room} is moved: it is taken off the table")));
    complaints
}

/// Files of `state` and `work` that name the toolkit, beyond what the table still allows.
pub fn toolkit_below(sources: &[Source]) -> Vec<String> {
    let names = |source: &&Source| {
        let below =
            ["app/state/", "app/work/", "app/action/"].iter().any(|floor| source.path.starts_with(floor));
        below && tokens(&source.code).iter().any(|token| token.text == "egui" || token.text == "eframe")
    };
    let found: BTreeSet<&str> = sources.iter().filter(names).map(|source| source.path.as_str()).collect();
    let known: BTreeSet<&str> = STILL_EGUI.iter().copied().collect();
    let new = found.difference(&known).map(|path| format!("src/{path}: names the toolkit"));
    let gone = known.difference(&found).map(|path| format!("src/{path}: it is taken off the table"));
    new.chain(gone).collect()
}

/// Functions of `src/app` outside of `shell` that take `&mut Editor`, as `file: count`.
pub fn takes_the_editor(sources: &[Source]) -> Vec<(String, usize)> {
    let count = |source: &Source| {
        let tokens = tokens(&source.code);
        let takes = |at: &usize| {
            let word = |by: usize| tokens.get(at + by).map_or("", |token| token.text);
            word(0) == "&" && word(1) == "mut" && word(2) == "Editor"
        };
        (0..tokens.len()).filter(takes).count()
    };
    let below = sources.iter().filter(|s| s.path.starts_with("app/") && !s.path.starts_with("app/shell/"));
    below.map(|source| (source.path.clone(), count(source))).filter(|(_, count)| *count > 0).collect()
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
    assert_eq!(file("app/state/notes.rs", "use crate::app::command::words;"), 1);
    assert_eq!(file("app/panel/menu.rs", "use crate::app::{action::apply, work::Work};"), 2);
    assert_eq!(file("app/command/file.rs", "use super::super::panel::counted;"), 1);
    assert_eq!(file("app/work/jobs.rs", "use crate::app::panel::x; use super::waker::Waker;"), 1);
    assert_eq!(
        file("app/panel/menu.rs", "use super::row; use crate::app::{state::State, widget::dialog};"),
        0
    );
    assert_eq!(file("app/action/mod.rs", "use super::work::Work; use crate::io::lock;"), 0);
    assert_eq!(file("app/shell/editor.rs", "use crate::app::{action::apply, work::Work, panel};"), 0);
}

#[test]
fn files_that_import_each_other_are_a_circle() {
    let sources = [
        Source::new("app/a.rs", "use super::b::B;"),
        Source::new("app/b/mod.rs", "use self::c::C;"),
        Source::new("app/b/c.rs", "use crate::app::a::A; use crate::io::lock;"),
        Source::new("app/d.rs", "use super::a::A;"),
    ];
    assert_eq!(largest_circle(&sources), ["app/a.rs", "app/b/c.rs", "app/b/mod.rs"]);
}
