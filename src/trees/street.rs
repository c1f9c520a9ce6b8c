//! Placing the trees of a list at once, with their feet on the model.

use std::path::Path;

use glam::DVec3;

use super::edit::{TreeChange, placed};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Model;
use quadratura_document::trees::Trees;
use quadratura_foliage::files::list::{Column, ListedPlace, TreeList};
use quadratura_projection::model_surface::ModelSurface;

/// The outcome of placing a list.
#[derive(Debug)]
pub struct PlacedList {
    /// The trees after it.
    pub trees: Trees,
    /// The names of the trees that were placed, in the order of the list.
    pub names: Vec<String>,
}

/// What trees stand on: the solid surfaces of a model, and the axis of the world that is nearest to what is up. Feet that are
/// dropped along it keep the two level coordinates that a list gives.
pub struct Ground {
    surface: ModelSurface,
    /// The axis: 0, 1 or 2 for x, y or z.
    axis: usize,
    /// The direction from which feet are dropped, along the axis.
    up: DVec3,
    /// The coordinate along the axis from which feet are dropped, beyond the model.
    start: f64,
}

impl Ground {
    /// Makes the ground of a model. `up` is what is up in the world.
    pub fn new(model: &Model, up: DVec3) -> Self {
        // Nobody plants a tree on a billboard.
        let solid = model.without(|object| object.see_through || object.impostor.is_some());
        let axis = [0, 1, 2].into_iter().max_by(|a, b| up[*a].abs().total_cmp(&up[*b].abs()));
        let axis = axis.expect("there are three axes");
        let along = up[axis].signum() * DVec3::AXES[axis];
        let heights = solid.vertices.iter().map(|vertex| vertex.dot(along));
        let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
            [low.min(height), high.max(height)]
        });
        let start = (high + (high - low).max(1.0)) * along[axis];
        Self { surface: ModelSurface::from_model(&solid), axis, up: along, start }
    }

    /// Returns the names of the two level coordinates.
    pub fn level_names(&self) -> [&'static str; 2] {
        [["y", "z"], ["x", "z"], ["x", "y"]][self.axis]
    }

    /// Returns the highest point of the model at two level coordinates; `None` where the model is not there.
    pub fn highest_at(&self, level: [f64; 2]) -> Option<DVec3> {
        let [first, second] = [[1, 2], [0, 2], [0, 1]][self.axis];
        let mut from = DVec3::ZERO;
        (from[first], from[second], from[self.axis]) = (level[0], level[1], self.start);
        let hit = self.surface.nearest(from, -self.up)?;
        Some(from - hit.t * self.up)
    }
}

/// How many names a message lists; as many trees are told line by line.
const FEW_NAMES: usize = 4;

/// Places the trees of a list, which is in `file`. `species` is that of trees for which the list says none; `change` is what all
/// have unless the list says otherwise. Either all are placed or none, so that a list that was corrected can be placed again and
/// nothing of it stands twice.
///
/// # Errors
/// One [`Error::Input`] for each line that cannot be used, in the order of the list; one in all where most names are those of trees that
/// there are, because the list was placed before.
pub fn placed_list(
    trees: &Trees,
    file: &Path,
    list: TreeList,
    species: Option<&str>,
    ground: &Ground,
    change: &TreeChange,
) -> Result<PlacedList> {
    let mut done = trees.clone();
    let mut problems: Vec<(usize, Error)> = list.problems;
    // Trees without a name get theirs last, so that they take none that the list gives to another tree.
    let (named, nameless): (Vec<_>, Vec<_>) = list.places.iter().partition(|place| place.name.is_some());
    let mut names = Vec::new();
    if problems.is_empty()
        && let Some(error) = placed_before(trees, file, &named)
    {
        return Err(error);
    }
    for place in named.into_iter().chain(nameless) {
        match placed_one(&done, file, place, species, ground, change) {
            Ok((trees, name)) => {
                done = trees;
                names.push((place.line, name));
            }
            Err(error) => problems.push((place.line, error)),
        }
    }
    problems.sort_by_key(|(line, _)| *line);
    if let Some(error) = Error::of_all(problems.into_iter().map(|(_, error)| error).collect()) {
        return Err(error);
    }
    names.sort();
    Ok(PlacedList { trees: done, names: names.into_iter().map(|(_, name)| name).collect() })
}

/// Returns the error for a list of which most trees are there already; `None` for other lists.
fn placed_before(trees: &Trees, file: &Path, named: &[&ListedPlace]) -> Option<Error> {
    let there: Vec<&str> = named.iter().filter_map(|place| place.name.as_deref()).collect();
    let there: Vec<&str> = there.into_iter().filter(|name| trees.find(name).is_some()).collect();
    if there.len() <= FEW_NAMES || 2 * there.len() <= named.len() {
        return None;
    }
    let (count, first) = (there.len(), there[..FEW_NAMES].join(", "));
    let found =
        format!("{count} of its {} names are those of trees of the project: {first} and others", named.len());
    let remedy = "if the list was placed before, remove these trees with `quadratura tree remove`, or place only its new lines";
    Some(Error::input(file, "", found, remedy))
}

fn placed_one(
    trees: &Trees,
    file: &Path,
    place: &ListedPlace,
    species: Option<&str>,
    ground: &Ground,
    change: &TreeChange,
) -> Result<(Trees, String)> {
    let Some(species) = place.species.as_deref().or(species) else {
        let found = "no species, and the command names none";
        return Err(place.error(file, Column::Species, found));
    };
    let Some(foot) = ground.highest_at(place.at) else {
        let ([x, y], [first, second]) = (place.at, ground.level_names());
        let found = format!("{first} = {x}, {second} = {y}, where the model has no surface to stand on");
        return Err(place.error(file, Column::X, found));
    };
    let name = place.name.as_deref();
    if let Some(name) = name.filter(|name| trees.find(name).is_some()) {
        return Err(place.error(file, Column::Name, format!("{name:?}, the name of another tree")));
    }
    let change = TreeChange {
        at: Some(foot.to_array()),
        height: place.height.or(change.height),
        width: place.crown.or(change.width),
        casts: place.casts.or(change.casts),
        ..change.clone()
    };
    placed(trees, species, name, &change).map_err(|error| {
        let column = if matches!(error, Error::Missing(_)) { Column::Species } else { Column::Name };
        place.error(file, column, error.to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Modeller;
    use quadratura_foliage::files::list::read_tree_list;

    /// A ground at height 2, with a roof at 5 over its right half, and a billboard in the air.
    fn model() -> Model {
        let mut model = Modeller::new();
        model.object("ground").quad(DVec3::new(-50.0, -50.0, 2.0), 100.0 * DVec3::X, 100.0 * DVec3::Y);
        model.object("roof").quad(DVec3::new(0.0, -50.0, 5.0), 50.0 * DVec3::X, 100.0 * DVec3::Y);
        model.object("sign").quad(DVec3::new(-20.0, -5.0, 9.0), 5.0 * DVec3::X, 10.0 * DVec3::Y);
        Model::clone(&model.finish()).with_see_through(|object| object.name == "sign")
    }

    fn listed(text: &str, trees: &Trees, species: Option<&str>) -> Result<PlacedList> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("trees.csv");
        std::fs::write(&file, text).unwrap();
        let list = read_tree_list(&file).unwrap();
        let change = TreeChange { height: Some(7.0), turn: Some(10.0), ..TreeChange::default() };
        placed_list(trees, &file, list, species, &Ground::new(&model(), DVec3::new(0.01, 0.0, 1.0)), &change)
    }

    #[test]
    fn feet_stand_on_the_highest_solid_surface_with_exactly_the_coordinates_of_the_list() {
        let text =
            "name,species,x,y,height,crown,casts\nlow,oak,-3.25,4,6,3,no\n,,7,8,,,\nsign,oak,-18,0,,,\n";
        let done = listed(text, &Trees::default(), Some("maple")).unwrap();
        assert_eq!(done.names, ["low", "maple_1", "sign"]);
        let tree = |name: &str| done.trees.find(name).unwrap();
        assert_eq!(
            (tree("low").at, tree("low").height, tree("low").width),
            ([-3.25, 4.0, 2.0], Some(6.0), Some(3.0))
        );
        assert!(!tree("low").casts && tree("sign").casts);
        let on_roof = tree("maple_1");
        assert_eq!(
            (on_roof.at, on_roof.height, on_roof.width, on_roof.turn),
            ([7.0, 8.0, 5.0], Some(7.0), None, 10.0)
        );
        assert_eq!(tree("sign").at[2], 2.0, "nobody plants on what one sees through");
    }

    #[test]
    fn what_cannot_be_placed_is_told_with_line_and_column_and_nothing_is_placed() {
        let text = "name,x,y,species\na,1,1,oak\na,2,2,oak\nb,80,1,oak\nc,1,2,palm\nd,3,3,\ne,4,4,oak\nf,one,4,oak\n";
        let refused = |text: &str, trees: &Trees| match listed(text, trees, None) {
            Err(Error::Several(errors)) => errors.iter().map(ToString::to_string).collect(),
            Err(error) => vec![error.to_string()],
            Ok(done) => panic!("{:?} were placed", done.names),
        };
        let problems = refused(text, &Trees::default());
        for (problem, words) in problems.iter().zip([
            ["line 3, column 1 (name)", "\"a\", the name of another tree"],
            ["line 4, column 2 (x)", "no surface to stand on"],
            ["line 5, column 4 (species)", "\"palm\""],
            ["line 6, column 4 (species)", "no species"],
            ["line 8, column 2 (x)", "\"one\", expected a number"],
        ]) {
            assert!(words.iter().all(|word| problem.contains(word)), "{problem}");
        }
        assert_eq!(problems.len(), 5);
        let one = "name,species,x,y\na,oak,5,5\n";
        let done = listed(one, &Trees::default(), None).unwrap();
        assert_eq!(refused(one, &done.trees).len(), 1, "the project has this tree");
        let many: String = (0..9).map(|n| format!("t{n},oak,{n},1\n")).collect();
        let many = format!("name,species,x,y\n{many}");
        let done = listed(&many, &Trees::default(), None).unwrap();
        let twice = refused(&many, &done.trees);
        assert!(
            twice.len() == 1 && twice[0].contains("9 of its 9 names") && twice[0].contains("t0, t1"),
            "{twice:?}"
        );
    }

    #[test]
    fn names_that_are_given_go_before_those_that_are_made() {
        let done = listed("x,y,name\n1,1,\n2,2,maple_1\n", &Trees::default(), Some("maple")).unwrap();
        assert_eq!(done.names, ["maple_2", "maple_1"]);
    }

    #[test]
    fn the_level_coordinates_are_those_across_what_is_up() {
        let mut wall = Modeller::new();
        wall.object("floor").quad(DVec3::new(-5.0, 3.0, -5.0), 10.0 * DVec3::X, 10.0 * DVec3::Z);
        let ground = Ground::new(&wall.finish(), -DVec3::Y);
        assert_eq!(ground.level_names(), ["x", "z"]);
        assert!(ground.highest_at([1.0, -2.0]).unwrap().abs_diff_eq(DVec3::new(1.0, 3.0, -2.0), 1e-12));
        assert_eq!(ground.highest_at([6.0, 0.0]), None);
    }
}
