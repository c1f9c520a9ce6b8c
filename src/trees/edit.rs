//! Placing, moving and removing trees.

use std::collections::BTreeSet;

use glam::DVec3;

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Model;
use quadratura_document::trees::{Grown, PlacedTree, PlantSource, TreeSpecies, Trees};
use quadratura_foliage::level_axes;
use quadratura_layers::fill::options::matches_pattern;
use quadratura_sites::named::objects_named;
use quadratura_sites::unknown_name::no_such;

/// A change of trees; what is `None` stays as it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TreeChange {
    /// The foot in world coordinates.
    pub at: Option<[f64; 3]>,
    /// How far the foot moves, in world coordinates.
    pub by: Option<[f64; 3]>,
    /// The height in world units.
    pub height: Option<f64>,
    /// The width of the crown in world units.
    pub width: Option<f64>,
    /// The turn in degrees.
    pub turn: Option<f64>,
    /// How much brighter than its species, in stops: R, G, B.
    pub tint: Option<[f64; 3]>,
    /// Whether its shadow darkens faces.
    pub casts: Option<bool>,
    /// The species.
    pub species: Option<String>,
}

/// Returns the trees with one more, and its name. Without a name it gets one of its species with a number. It replaces nothing,
/// so it is one that no photo shows, and casts a shadow unless the change says that it does not.
///
/// # Errors
/// [`Error::Request`] for a name that another tree has, and for values that no tree can have; [`Error::Missing`] for an unknown
/// species.
pub fn placed(
    trees: &Trees,
    species: &str,
    name: Option<&str>,
    change: &TreeChange,
) -> Result<(Trees, String)> {
    let mut trees = with_species(trees, species)?;
    let name = name.map_or_else(|| trees.free_name(species), str::to_owned);
    if trees.find(&name).is_some() {
        return Err(Error::Request(format!("there is a tree {name:?} already; give another name")));
    }
    let mut tree = new_tree(&name, species, [0.0; 3]);
    change_tree(&mut tree, change);
    trees.placed.push(tree);
    checked(trees).map(|trees| (trees, name))
}

/// Returns the trees with one for each object of some names or patterns of the complete model, in whose place it stands, and
/// the names of the new trees. Place, height and width are those of the object; `up` is what is up in the world. Objects that
/// a tree replaces already are passed over. The photos show the shadow of what is replaced, so these trees cast none unless the
/// change says so.
///
/// # Errors
/// [`Error::Missing`] for names that the model does not have and for an unknown species; [`Error::Request`] for objects without
/// height.
pub fn placed_on(
    trees: &Trees,
    species: &str,
    patterns: &[String],
    whole: &Model,
    up: DVec3,
    change: &TreeChange,
) -> Result<(Trees, Vec<String>)> {
    let mut trees = with_species(trees, species)?;
    let mut names = Vec::new();
    for pattern in patterns {
        for id in objects_named(whole, pattern)? {
            let object = &whole.object(id).name;
            if trees.replaced().any(|replaced| replaced == object) {
                continue;
            }
            let mut tree = tree_for_object(&trees, species, whole, object, up)?;
            change_tree(&mut tree, change);
            names.push(tree.name.clone());
            trees.placed.push(tree);
        }
    }
    checked(trees).map(|trees| (trees, names))
}

/// Returns the trees after a change of those with some names or patterns, and the names of these.
///
/// # Errors
/// [`Error::Missing`] for names that no tree has and for an unknown species; [`Error::Request`] for values that no tree can have.
pub fn moved(trees: &Trees, patterns: &[String], change: &TreeChange) -> Result<(Trees, Vec<String>)> {
    let names = named(trees, patterns)?;
    let mut trees = match &change.species {
        Some(species) => with_species(trees, species)?,
        None => trees.clone(),
    };
    for tree in trees.placed.iter_mut().filter(|tree| names.contains(&tree.name)) {
        change_tree(tree, change);
    }
    checked(trees).map(|trees| (trees, names))
}

/// Returns the trees with another one in place of that of a name. Its species need not be added before where it is a built-in one.
///
/// # Errors
/// [`Error::Missing`] for a name that no tree has and for an unknown species; [`Error::Request`] for a name that another tree has,
/// and for values that no tree can have.
pub fn replaced(trees: &Trees, name: &str, tree: &PlacedTree) -> Result<Trees> {
    let Some(index) = trees.index_of(name) else {
        return Err(no_such("tree", name, trees.placed.iter().map(|tree| tree.name.as_str()), None));
    };
    let mut trees = with_species(trees, &tree.species)?;
    trees.placed[index.index()] = tree.clone();
    checked(trees)
}

/// Returns the trees with a copy of the tree of a name, beside it by a vector of the world, and the copy's name. What the tree
/// replaces stays with it.
///
/// # Errors
/// [`Error::Missing`] for a name that no tree has; [`Error::Request`] for a place that no tree can have.
pub fn duplicated(trees: &Trees, name: &str, beside: DVec3) -> Result<(Trees, String)> {
    let Some(tree) = trees.find(name) else {
        return Err(no_such("tree", name, trees.placed.iter().map(|tree| tree.name.as_str()), None));
    };
    let copy = PlacedTree {
        name: trees.free_name(&tree.species),
        at: (DVec3::from_array(tree.at) + beside).to_array(),
        replaces: BTreeSet::new(),
        // No photo shows it, whatever the tree replaces.
        casts: tree.casts || !tree.replaces.is_empty(),
        ..tree.clone()
    };
    let (mut trees, name) = (trees.clone(), copy.name.clone());
    trees.placed.push(copy);
    checked(trees).map(|trees| (trees, name))
}

/// Returns the trees without those of some names or patterns, and the names of these.
///
/// # Errors
/// [`Error::Missing`] for names that no tree has.
pub fn removed(trees: &Trees, patterns: &[String]) -> Result<(Trees, Vec<String>)> {
    let names = named(trees, patterns)?;
    let mut trees = trees.clone();
    trees.placed.retain(|tree| !names.contains(&tree.name));
    Ok((trees, names))
}

/// Returns the names of the trees that are meant, in the order of the project.
///
/// # Errors
/// [`Error::Missing`] for names that no tree has.
pub fn named(trees: &Trees, patterns: &[String]) -> Result<Vec<String>> {
    let mut errors = Vec::new();
    for pattern in patterns {
        if !trees.placed.iter().any(|tree| matches_pattern(&tree.name, pattern)) {
            let known = trees.placed.iter().map(|tree| tree.name.as_str());
            errors.push(no_such("tree", pattern, known, None));
        }
    }
    if let Some(error) = Error::of_all(errors) {
        return Err(error);
    }
    let is_meant = |tree: &&PlacedTree| patterns.iter().any(|pattern| matches_pattern(&tree.name, pattern));
    Ok(trees.placed.iter().filter(is_meant).map(|tree| tree.name.clone()).collect())
}

/// Returns the trees with a species, which takes the place of one of the same name.
///
/// # Errors
/// [`Error::Request`] for values that no species can have.
pub fn species_set(trees: &Trees, name: &str, species: TreeSpecies) -> Result<Trees> {
    let mut trees = trees.clone();
    trees.species.insert(name.to_owned(), species);
    checked(trees)
}

/// Returns the trees without a species.
///
/// # Errors
/// [`Error::Missing`] for an unknown one; [`Error::Request`] where trees of it stand.
pub fn species_removed(trees: &Trees, name: &str) -> Result<Trees> {
    let mut trees = trees.clone();
    if trees.species.remove(name).is_none() {
        return Err(no_such("species", name, trees.species.keys().map(String::as_str), None));
    }
    let of_it: Vec<&str> =
        trees.placed.iter().filter(|tree| tree.species == name).map(|tree| tree.name.as_str()).collect();
    if !of_it.is_empty() {
        let trees = of_it.join(", ");
        return Err(Error::Request(format!(
            "these trees are of the species {name:?}: {trees}; remove them first"
        )));
    }
    Ok(trees)
}

/// Returns the trees with a species of this name: the built-in ones need not be added before.
fn with_species(trees: &Trees, name: &str) -> Result<Trees> {
    let mut trees = trees.clone();
    if trees.species.contains_key(name) {
        return Ok(trees);
    }
    let from = match name {
        "maple" => PlantSource::Maple(Grown::default()),
        "oak" => PlantSource::Oak(Grown::default()),
        _ => {
            let built_in = ["maple", "oak"].into_iter().filter(|name| !trees.species.contains_key(*name));
            let known = trees.species.keys().map(String::as_str).chain(built_in);
            return Err(no_such("species", name, known, None));
        }
    };
    trees.species.insert(name.to_owned(), TreeSpecies { from, up: None, unit: None });
    Ok(trees)
}

fn new_tree(name: &str, species: &str, at: [f64; 3]) -> PlacedTree {
    PlacedTree {
        name: name.to_owned(),
        species: species.to_owned(),
        at,
        height: None,
        width: None,
        turn: 0.0,
        tint: [0.0; 3],
        replaces: BTreeSet::new(),
        casts: true,
    }
}

fn change_tree(tree: &mut PlacedTree, change: &TreeChange) {
    let TreeChange { at, by, height, width, turn, tint, casts, species } = change;
    tree.at = at.unwrap_or(tree.at);
    if let Some(by) = by {
        tree.at = [0, 1, 2].map(|axis| tree.at[axis] + by[axis]);
    }
    tree.height = height.or(tree.height);
    tree.width = width.or(tree.width);
    tree.turn = turn.unwrap_or(tree.turn);
    tree.tint = tint.unwrap_or(tree.tint);
    tree.casts = casts.unwrap_or(tree.casts);
    if let Some(species) = species {
        tree.species.clone_from(species);
    }
}

/// Returns a tree that stands where an object of the model does: its foot below the middle of the object, as high and as wide.
fn tree_for_object(trees: &Trees, species: &str, whole: &Model, name: &str, up: DVec3) -> Result<PlacedTree> {
    let (x, y) = level_axes(up);
    let object = whole.objects.iter().find(|object| object.name == name).expect("it was found by its name");
    let corners = object.faces.iter().flat_map(|face| whole.ring(*face)).map(|vertex| {
        let point = whole.vertices[*vertex as usize];
        DVec3::new(point.dot(x), point.dot(y), point.dot(up))
    });
    let corners: Vec<DVec3> = corners.collect();
    let low = corners.iter().copied().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let high = corners.iter().copied().reduce(DVec3::max).unwrap_or(DVec3::ZERO);
    let size = high - low;
    if size.z <= 0.0 {
        return Err(Error::Request(format!(
            "the object {name:?} has no height, so no tree can be as high; place one with --at and --height"
        )));
    }
    // Upright rectangles may stand at any angle: from any corner the farthest one is at one side, from that at the other.
    let farthest = |from: DVec3| {
        let level = |corner: &DVec3| (*corner - from).truncate().length();
        corners.iter().copied().max_by(|a, b| level(a).total_cmp(&level(b))).unwrap_or(from)
    };
    let side = farthest(corners[0]);
    let width = (farthest(side) - side).truncate().length();
    let foot = 0.5 * (low + high).truncate();
    let at = foot.x * x + foot.y * y + low.z * up;
    let stem = name.split('.').next().unwrap_or(name);
    let free = if trees.find(stem).is_none() { stem.to_owned() } else { trees.free_name(stem) };
    let mut tree = new_tree(&free, species, at.to_array());
    (tree.height, tree.width) = (Some(size.z), (width > 0.0).then_some(width));
    tree.replaces.insert(name.to_owned());
    tree.casts = false;
    Ok(tree)
}

fn checked(trees: Trees) -> Result<Trees> {
    match trees.problem() {
        Some(problem) => Err(Error::Request(problem)),
        None => Ok(trees),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    fn at(x: f64) -> TreeChange {
        TreeChange { at: Some([x, 0.0, 0.0]), ..TreeChange::default() }
    }

    #[test]
    fn trees_are_placed_moved_and_removed_by_name() {
        let (trees, first) = placed(&Trees::default(), "maple", None, &at(1.0)).unwrap();
        let (trees, second) = placed(&trees, "maple", None, &at(2.0)).unwrap();
        let (trees, third) = placed(&trees, "oak", Some("old oak"), &at(3.0)).unwrap();
        assert_eq!([&first[..], &second, &third], ["maple_1", "maple_2", "old oak"]);
        assert_eq!(trees.species.len(), 2, "known species need not be added");
        let by = TreeChange { by: Some([0.5, 0.0, 1.0]), turn: Some(90.0), ..TreeChange::default() };
        let (trees, names) = moved(&trees, &["maple_*".into()], &by).unwrap();
        assert_eq!(names, ["maple_1", "maple_2"]);
        assert_eq!((trees.placed[1].at, trees.placed[1].turn), ([2.5, 0.0, 1.0], 90.0));
        assert!(species_removed(&trees, "oak").unwrap_err().to_string().contains("old oak"));
        let (trees, names) = removed(&trees, &["old oak".into()]).unwrap();
        assert_eq!((names, trees.placed.len()), (vec!["old oak".to_owned()], 2));
        assert!(!species_removed(&trees, "oak").unwrap().species.contains_key("oak"));
    }

    #[test]
    fn a_copy_stands_beside_its_tree_and_replaces_nothing_and_a_tree_may_become_another() {
        let (mut trees, _) = placed(&Trees::default(), "maple", None, &at(1.0)).unwrap();
        trees.placed[0].replaces.insert("billboard".into());
        let (trees, copy) = duplicated(&trees, "maple_1", 2.0 * DVec3::X).unwrap();
        assert_eq!((copy.as_str(), trees.placed[1].at), ("maple_2", [3.0, 0.0, 0.0]));
        assert_eq!(trees.replaced().count(), 1);
        let oak = PlacedTree { name: "old oak".into(), species: "oak".into(), ..trees.placed[1].clone() };
        let other = replaced(&trees, "maple_2", &oak).unwrap();
        assert_eq!((other.placed[1].name.as_str(), other.species.len()), ("old oak", 2));
        let twice = PlacedTree { name: "maple_1".into(), ..oak.clone() };
        assert!(replaced(&trees, "maple_2", &twice).unwrap_err().to_string().contains("two trees"));
        assert!(replaced(&trees, "elm", &oak).is_err() && duplicated(&trees, "elm", DVec3::X).is_err());
    }

    #[test]
    fn what_is_unknown_or_impossible_is_refused_and_changes_nothing() {
        let (trees, _) = placed(&Trees::default(), "maple", None, &at(1.0)).unwrap();
        let refused = |found: Result<(Trees, String)>, word: &str| {
            let error = found.unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        };
        refused(placed(&trees, "palm", None, &at(0.0)), "palm");
        refused(placed(&trees, "maple", Some("maple_1"), &at(0.0)), "already");
        let low = TreeChange { height: Some(-1.0), ..at(0.0) };
        refused(placed(&trees, "maple", None, &low), "height -1");
        assert!(moved(&trees, &["elm*".into()], &at(0.0)).unwrap_err().to_string().contains("elm*"));
        assert!(removed(&trees, &["elm".into(), "ash".into()]).unwrap_err().to_string().contains("ash"));
    }

    #[test]
    fn a_tree_takes_the_place_and_the_size_of_an_object() {
        let mut model = Modeller::new();
        // An upright rectangle, askew: 5 wide, 6 high.
        let corner = DVec3::new(10.0, -2.0, 0.5);
        model.object("tree_1.billboard").quad(corner, DVec3::new(3.0, 4.0, 0.0), 6.0 * DVec3::Z);
        model.object("ground").quad(DVec3::ZERO, DVec3::X, DVec3::Y);
        let model = model.finish();
        let place = |trees: &Trees, pattern: &str| {
            placed_on(trees, "maple", &[pattern.into()], &model, DVec3::Z, &TreeChange::default())
        };
        let (trees, names) = place(&Trees::default(), "tree_*").unwrap();
        assert_eq!(names, ["tree_1"]);
        let tree = &trees.placed[0];
        assert!(DVec3::from_array(tree.at).abs_diff_eq(DVec3::new(11.5, 0.0, 0.5), 1e-12), "{tree:?}");
        assert_eq!((tree.height, tree.width), (Some(6.0), Some(5.0)));
        assert!(tree.replaces.contains("tree_1.billboard") && !tree.casts, "the photos show its shadow");
        let (copied, _) = duplicated(&trees, "tree_1", DVec3::X).unwrap();
        assert!(copied.placed[1].casts, "no photo shows that of the copy");
        assert!(place(&trees, "tree_*").unwrap().1.is_empty(), "it stands there already");
        assert!(place(&trees, "ground").unwrap_err().to_string().contains("no height"));
        assert!(place(&trees, "shrub").is_err());
    }
}
