//! The floors inside a room: the rows of the table of modules in its `mod.rs`, from the ground up. The modules of a row may use each other
//! and those of rows above it in the table.

use std::collections::{BTreeMap, BTreeSet};

use super::source::Source;

/// The rooms that have such a table.
pub const ROOMS_WITH_FLOORS: &[&str] =
    &["base", "projection", "foliage", "gpu", "sites", "stacks", "views", "editing"];

/// The floors of a room.
pub struct Floors {
    room: String,
    /// The modules of each floor, from the ground up.
    rows: Vec<Vec<String>>,
    /// The names that the room shows, each with the module that it is from.
    shown: BTreeMap<String, String>,
}

impl Floors {
    /// Reads the table of a room's `mod.rs`.
    pub fn new(root: &Source) -> Self {
        let module = |name: &str| name.trim().trim_matches(['[', ']', '`']).to_owned();
        let row = |line: &str| -> Option<Vec<String>> {
            let cell = line.strip_prefix("//! | ")?.split(" | ").next()?;
            cell.starts_with(['`', '[']).then(|| cell.split(',').map(module).collect())
        };
        let shown = root.shown_names().into_iter().filter_map(|path| match path.as_slice() {
            [module, .., name] => Some((name.clone(), module.clone())),
            _ => None,
        });
        Self {
            room: root.module_path().concat(),
            rows: root.text.lines().filter_map(row).collect(),
            shown: shown.collect(),
        }
    }

    fn floor_of(&self, module: &str) -> Option<usize> {
        self.rows.iter().position(|row| row.iter().any(|other| other == module))
    }

    /// What a file of the room uses of modules above its own, where it is on a floor.
    pub fn forbidden_arrows(&self, source: &Source) -> Vec<String> {
        let here = source.module_path();
        let [room, own, ..] = here.as_slice() else { return Vec::new() };
        if *room != self.room || source.is_test() {
            return Vec::new();
        }
        let Some(own_floor) = self.floor_of(own) else {
            return vec![format!("src/{}: module `{own}` is on no floor of `{room}`", source.path)];
        };
        let mut complaints = Vec::new();
        for used in source.used_paths() {
            let [other, name, ..] = used.segments.as_slice() else { continue };
            let module = self.shown.get(name).unwrap_or(name);
            if other == room && self.floor_of(module).is_some_and(|floor| floor > own_floor) {
                let path = used.segments.join("::");
                complaints.push(format!(
                    "src/{}:{}: `{own}` must not use `{path}`, which is below it in the table of src/{room}/mod.rs",
                    source.path, used.line
                ));
            }
        }
        complaints
    }

    /// Modules that stand in the table twice, or in it without being in the room.
    pub fn strays(&self, sources: &[Source]) -> Vec<String> {
        let paths = sources.iter().map(Source::module_path);
        let of_room = paths.filter(|path| path.first() == Some(&self.room));
        let modules: BTreeSet<String> = of_room.filter_map(|path| path.get(1).cloned()).collect();
        let mut known = BTreeSet::new();
        let listed = self.rows.iter().flatten();
        let strays = listed.filter(|module| !known.insert(*module) || !modules.contains(*module));
        strays.map(|module| format!("src/{}/mod.rs: the table has `{module}` in vain", self.room)).collect()
    }
}

/// The ground floor knows nothing, and both of the second know each other.
#[cfg(test)]
fn floors() -> Floors {
    Floors::new(&Source::new(
        "base/mod.rs",
        "//! A room.\n//!\n//! | module | contents |\n//! |---|---|\n//! | `error` | errors |\n\
         //! | [`task`], `geometry` | tasks |\n//! | `scene` | photos |\n\
         pub use error::{Error, Result as R};\npub use scene::{photo::Photo, site};\n",
    ))
}

#[test]
fn an_arrow_to_a_higher_floor_is_found_however_it_is_written() {
    let count = |path: &str, text: &str| floors().forbidden_arrows(&Source::new(path, text)).len();
    for text in [
        "use crate::scene::Site;",
        "use crate::{error::Error, scene::{self, Site}};",
        "use super::super::scene::Site;",
        "fn f() -> crate::scene::Site { todo() }",
        "use crate::{\n    error::Error as E,\n    scene,\n};",
        "use super::{super::scene::image, lens};",
        "use quadratura_base::scene::Site;",
        "use crate::Photo;",
    ] {
        assert_ne!(count("base/geometry/plane.rs", text), 0, "{text}");
    }
    assert_eq!(count("base/error.rs", "use crate::task::Task;"), 1);
    assert_eq!(count("base/attic/x.rs", ""), 1, "a module that is on no floor");
}

#[test]
fn an_arrow_to_a_lower_floor_and_one_within_a_floor_are_fine() {
    for text in [
        "use crate::task::Task;",
        "use crate::{Error, Result};",
        "use super::lens::Lens;",
        "use crate::geometry::options::Options;",
        "// use crate::scene::Site;",
        "const A: &str = \"crate::scene\";",
        "#[cfg(test)]\nmod tests {\n    use crate::scene::Site;\n}",
        "use spade_like::scene::X;",
    ] {
        let found = floors().forbidden_arrows(&Source::new("base/geometry/plane.rs", text));
        assert_eq!(found, [""; 0], "{text}");
    }
    let elsewhere = |path: &str| floors().forbidden_arrows(&Source::new(path, "use crate::scene::Site;"));
    assert_eq!([elsewhere("layers/projected_model.rs"), elsewhere("base/tests/task.rs")].concat(), [""; 0]);
}

#[test]
fn a_table_that_lists_what_is_not_in_the_room_is_found() {
    let files = ["base/error.rs", "base/task.rs", "base/geometry/mod.rs", "base/scene/photo.rs"];
    let mut sources = files.map(|path| Source::new(path, "")).to_vec();
    assert_eq!(floors().strays(&sources), [""; 0]);
    sources.remove(1);
    assert_eq!(floors().strays(&sources).len(), 1);
}
