//! Trees that stand in the site: `trees` of `project.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Formatter;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The largest coordinate, height or light that is accepted; larger ones are mistakes.
const LARGEST: f64 = 1e15;
/// The largest change of a tree's brightness in stops.
const MOST_STOPS: f64 = 20.0;

/// The trees of a project: species, trees that are placed, and the light on them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trees {
    /// The species by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub species: BTreeMap<String, TreeSpecies>,
    /// The trees, in the order in which they were placed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub placed: Vec<PlacedTree>,
    /// The light on all trees.
    #[serde(default, skip_serializing_if = "TreeLight::is_default")]
    pub light: TreeLight,
}

/// A plant of which trees are placed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeSpecies {
    /// Where the plant is from.
    pub from: PlantSource,
    /// What is up in the plant's frame, in place of what its file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<PlantAxis>,
    /// The length of the plant's unit in units of the world, in place of what its file says in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<f64>,
}

/// Where a species' plant is from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PlantSource {
    /// A file of one of the formats of plants, relative to the project's folder, with `/`.
    File(String),
    /// The built-in maple.
    Maple(Grown),
    /// The built-in oak.
    Oak(Grown),
}

/// How a plant is grown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grown {
    /// The seed; `None` for the species' own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

/// An axis of a plant's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlantAxis {
    /// x.
    #[serde(rename = "x")]
    X,
    /// y, as glTF has it.
    #[serde(rename = "y")]
    Y,
    /// z.
    #[serde(rename = "z")]
    Z,
    /// Against x.
    #[serde(rename = "-x")]
    MinusX,
    /// Against y.
    #[serde(rename = "-y")]
    MinusY,
    /// Against z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl PlantAxis {
    /// All axes, in the order of the command line's help.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::MinusX, Self::MinusY, Self::MinusZ];

    /// Returns the axis's name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }

    /// Returns the unit vector.
    pub fn direction(self) -> [f64; 3] {
        match self {
            Self::X => [1.0, 0.0, 0.0],
            Self::Y => [0.0, 1.0, 0.0],
            Self::Z => [0.0, 0.0, 1.0],
            Self::MinusX => [-1.0, 0.0, 0.0],
            Self::MinusY => [0.0, -1.0, 0.0],
            Self::MinusZ => [0.0, 0.0, -1.0],
        }
    }
}

/// A tree that stands in the site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedTree {
    /// Its name, which no other tree has.
    pub name: String,
    /// Its species.
    pub species: String,
    /// Its foot, in world coordinates.
    pub at: [f64; 3],
    /// Its height above the foot in world units; `None` for the plant's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// The width of its crown in world units; `None` for that of a plant of this height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Its turn about what is up in degrees, against the clock as seen from above.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub turn: f64,
    /// How much brighter it is than its species, in stops: R, G, B.
    #[serde(default, skip_serializing_if = "is_no_tint")]
    pub tint: [f64; 3],
    /// The objects of the model that are removed while the tree stands.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub replaces: BTreeSet<String>,
    /// Whether its sun shadow darkens faces. The shadow of a tree that the photos show is in the photos already.
    #[serde(default, skip_serializing_if = "is_false")]
    pub casts: bool,
}

/// The index of a tree among those that are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TreeIndex(pub u32);

impl TreeIndex {
    /// Makes an index of a position in the list of trees.
    pub fn new(index: usize) -> Self {
        Self(index as u32)
    }

    /// Returns the position in the list of trees.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The light on trees. A sun that is left out is that of a clear day.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeLight {
    /// The direction to the sun in the world, of any length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun: Option<[f64; 3]>,
    /// What sun, sky and ground give.
    #[serde(default, skip_serializing_if = "Strength::is_estimated")]
    pub strength: Strength,
    /// True where trees stay as they are drawn near the photos that show them, instead of having what these show of light and colour.
    #[serde(default, skip_serializing_if = "is_false")]
    pub without_photos: bool,
}

/// Where what sun, sky and ground give is from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Strength {
    /// It is estimated from the photos; in files the word `estimated`.
    #[default]
    Estimated,
    /// It is given.
    Given(LightStrength),
}

/// The word of files for [`Strength::Estimated`].
const ESTIMATED: &str = "estimated";

impl Strength {
    fn is_estimated(&self) -> bool {
        *self == Self::Estimated
    }

    /// Returns what is given; `None` where it is estimated.
    pub fn given(&self) -> Option<&LightStrength> {
        match self {
            Self::Estimated => None,
            Self::Given(strength) => Some(strength),
        }
    }
}

impl Serialize for Strength {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Estimated => serializer.serialize_str(ESTIMATED),
            Self::Given(strength) => strength.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Strength {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordOrLight;
        impl<'de> Visitor<'de> for WordOrLight {
            type Value = Strength;

            fn expecting(&self, text: &mut Formatter<'_>) -> std::fmt::Result {
                text.write_str("\"estimated\", or an object with sun, sky and ground")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Strength, E> {
                match word {
                    ESTIMATED => Ok(Strength::Estimated),
                    _ => Err(E::invalid_value(Unexpected::Str(word), &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Strength, A::Error> {
                LightStrength::deserialize(MapAccessDeserializer::new(map)).map(Strength::Given)
            }
        }
        deserializer.deserialize_any(WordOrLight)
    }
}

/// What a white surface reflects that faces each source: linear light R, G, B in the photos' common exposure, where 1 is the
/// brightest light of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightStrength {
    /// The light of the sun.
    pub sun: [f64; 3],
    /// The light of the sky on what looks up.
    pub sky: [f64; 3],
    /// The light of the ground on what looks down.
    pub ground: [f64; 3],
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn is_false(value: &bool) -> bool {
    !*value
}

fn is_no_tint(tint: &[f64; 3]) -> bool {
    *tint == [0.0; 3]
}

impl TreeLight {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    fn problem(&self) -> Option<String> {
        if let Some(sun) = self.sun {
            let length = sun.iter().map(|value| value * value).sum::<f64>().sqrt();
            if !length.is_finite() || length == 0.0 {
                return Some(format!(
                    "light.sun is {sun:?}, expected a direction to the sun: three numbers, not all 0"
                ));
            }
        }
        let LightStrength { sun, sky, ground } = *self.strength.given()?;
        let of = |name: &str, light: [f64; 3]| {
            let is_light = light.iter().all(|value| (0.0..=LARGEST).contains(value));
            (!is_light).then(|| {
                format!(
                    "light.strength.{name} is {light:?}, expected three numbers of linear light, 0 or more"
                )
            })
        };
        of("sun", sun).or_else(|| of("sky", sky)).or_else(|| of("ground", ground))
    }
}

impl Trees {
    /// Returns true when there is nothing of trees.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the tree of a name.
    pub fn find(&self, name: &str) -> Option<&PlacedTree> {
        self.placed.iter().find(|tree| tree.name == name)
    }

    /// Returns the tree at an index; `None` beyond the last one.
    pub fn at(&self, index: TreeIndex) -> Option<&PlacedTree> {
        self.placed.get(index.index())
    }

    /// Returns the index of the tree of a name.
    pub fn index_of(&self, name: &str) -> Option<TreeIndex> {
        self.placed.iter().position(|tree| tree.name == name).map(TreeIndex::new)
    }

    /// Returns the objects of the model that trees replace.
    pub fn replaced(&self) -> impl Iterator<Item = &String> {
        self.placed.iter().flat_map(|tree| &tree.replaces)
    }

    /// Returns a name with a number that no tree has yet.
    pub fn free_name(&self, species: &str) -> String {
        let name = |number: usize| format!("{species}_{number}");
        // Of one more name than there are trees, one is free.
        let free = (1..=self.placed.len() + 1).map(name).find(|name| self.find(name).is_none());
        free.expect("fewer trees than names")
    }

    /// Returns what is wrong, in words; `None` where nothing is.
    pub fn problem(&self) -> Option<String> {
        let of_species = self.species.iter().find_map(|(name, species)| {
            if name.trim().is_empty() {
                return Some("a species has no name, expected one of letters or digits".to_owned());
            }
            let unit = species.unit.filter(|unit| !(*unit > 0.0 && *unit <= LARGEST))?;
            Some(format!("species {name:?} has the unit {unit}, expected a length above 0"))
        });
        let mut names = BTreeSet::new();
        let of_placed = || {
            self.placed.iter().find_map(|tree| {
                self.problem_of(tree).map(|problem| format!("tree {:?} {problem}", tree.name)).or_else(|| {
                    (!names.insert(&tree.name))
                        .then(|| format!("two trees are called {:?}, expected names that differ", tree.name))
                })
            })
        };
        of_species.or_else(of_placed).or_else(|| self.light.problem())
    }

    fn problem_of(&self, tree: &PlacedTree) -> Option<String> {
        let PlacedTree { name, species, at, height, width, turn, tint, replaces: _, casts: _ } = tree;
        if name.trim().is_empty() {
            return Some("has no name, expected one of letters or digits".to_owned());
        }
        if !self.species.contains_key(species) {
            let known = self.species.keys().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
            let known =
                if known.is_empty() { "there are none".to_owned() } else { format!("there are {known}") };
            return Some(format!(
                "is of the species {species:?}, which trees.species does not have; {known}"
            ));
        }
        if !at.iter().all(|value| value.abs() <= LARGEST) {
            return Some(format!(
                "stands at {at:?}, expected three world coordinates of {LARGEST:e} at most"
            ));
        }
        for (what, length) in [("height", height), ("width", width)] {
            if let Some(length) = length.filter(|length| !(*length > 0.0 && *length <= LARGEST)) {
                return Some(format!("has the {what} {length}, expected a length above 0 in world units"));
            }
        }
        if !turn.is_finite() || turn.abs() > LARGEST {
            return Some(format!("has the turn {turn}, expected degrees"));
        }
        if !tint.iter().all(|stops| stops.abs() <= MOST_STOPS) {
            return Some(format!(
                "has the tint {tint:?}, expected three numbers of stops from -{MOST_STOPS} to {MOST_STOPS}"
            ));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the documentation.
    const EXAMPLE: &str = r#"{
        "species": {
            "plane": {"from": {"file": "../plants/plane.glb"}, "up": "y", "unit": 1.0},
            "maple": {"from": {"maple": {"seed": 7}}}
        },
        "placed": [
            {"name": "tree_1", "species": "plane", "at": [-11.4, -3.2, 0.0], "height": 6.6, "width": 4.6, "turn": 35.0,
             "tint": [0, 0, 0], "replaces": ["tree_1.billboard"]},
            {"name": "new", "species": "maple", "at": [2.0, 1.0, 0.0], "casts": true}
        ],
        "light": {"sun": [0.55, -0.35, 0.76]}
    }"#;

    fn example() -> Trees {
        serde_json::from_str(EXAMPLE).unwrap()
    }

    #[test]
    fn trees_come_back_from_a_file_as_they_were_written() {
        let trees = example();
        assert_eq!(trees.problem(), None);
        assert_eq!(trees.species["maple"].from, PlantSource::Maple(Grown { seed: Some(7) }));
        assert_eq!(trees.species["plane"].up, Some(PlantAxis::Y));
        let text = serde_json::to_string(&trees).unwrap();
        assert_eq!(serde_json::from_str::<Trees>(&text).unwrap(), trees);
        assert_eq!(serde_json::to_string(&Trees::default()).unwrap(), "{}");
        // What is not said is false, and not written.
        assert_eq!(trees.placed.iter().map(|tree| tree.casts).collect::<Vec<_>>(), [false, true]);
        assert_eq!(text.matches("casts").count(), 1);
        for bad in ["1", "\"yes\"", "null"] {
            let text = text.replace("\"casts\":true", &format!("\"casts\":{bad}"));
            let told = serde_json::from_str::<Trees>(&text).unwrap_err().to_string();
            assert!(told.contains("expected a boolean"), "{told}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_the_name_of_the_tree() {
        let told = |change: &dyn Fn(&mut Trees), words: &[&str]| {
            let mut trees = example();
            change(&mut trees);
            let problem = trees.problem().expect("something is wrong");
            assert!(words.iter().all(|word| problem.contains(word)), "{problem}");
        };
        told(&|t| t.placed[0].species = "palm".into(), &["tree_1", "palm", "\"maple\", \"plane\""]);
        told(&|t| t.placed[0].height = Some(0.0), &["tree_1", "height 0", "above 0"]);
        told(&|t| t.placed[0].width = Some(f64::NAN), &["tree_1", "width"]);
        told(&|t| t.placed[0].at[1] = f64::INFINITY, &["tree_1", "inf"]);
        told(&|t| t.placed[0].turn = f64::NAN, &["tree_1", "turn"]);
        told(&|t| t.placed[0].tint[2] = 21.0, &["tree_1", "tint", "stops"]);
        told(&|t| t.placed.push(t.placed[0].clone()), &["two trees", "tree_1"]);
        told(&|t| t.placed[0].name = " ".into(), &["no name"]);
        told(&|t| t.light.sun = Some([0.0; 3]), &["light.sun"]);
        let black = LightStrength { sun: [-1.0, 0.0, 0.0], sky: [0.0; 3], ground: [0.0; 3] };
        told(&|t| t.light.strength = Strength::Given(black), &["light.strength.sun"]);
        told(&|t| t.species.get_mut("plane").unwrap().unit = Some(-1.0), &["plane", "unit -1"]);
    }

    #[test]
    fn light_is_estimated_unless_it_is_given_and_other_words_are_refused() {
        let light = |text: &str| serde_json::from_str::<TreeLight>(text);
        assert_eq!(light("{}").unwrap(), light(r#"{"strength": "estimated"}"#).unwrap());
        assert_eq!(example().light.strength, Strength::Estimated);
        let text = r#"{"strength":{"sun":[1.0,2.0,3.0],"sky":[0.5,0.5,0.5],"ground":[0.0,0.0,0.0]}}"#;
        let given = light(text).unwrap();
        assert_eq!(given.strength.given().unwrap().sun, [1.0, 2.0, 3.0]);
        assert_eq!(serde_json::to_string(&given).unwrap(), text);
        for (text, word) in [
            (r#"{"strength": "bright"}"#, "estimated"),
            (r#"{"strength": 2}"#, "estimated"),
            (r#"{"strength": {"sun": [1, 1, 1]}}"#, "sky"),
        ] {
            let told = light(text).unwrap_err().to_string();
            assert!(told.contains(word), "{told}");
        }
    }

    #[test]
    fn new_names_are_free() {
        let mut trees = example();
        assert_eq!(trees.free_name("maple"), "maple_1");
        trees.placed[0].name = "maple_1".into();
        assert_eq!(trees.free_name("maple"), "maple_2");
        assert_eq!(trees.replaced().collect::<Vec<_>>(), ["tree_1.billboard"]);
    }
}
