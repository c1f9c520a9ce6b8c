//! The numbers that a plant is grown from, as they are read from JSON.

use serde::Deserialize;

/// A species: everything that [`grow`](crate::grow()) needs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Species {
    /// The name of the plant.
    pub name: String,
    /// Where the random numbers begin.
    #[serde(default)]
    pub seed: u64,
    /// The number of trees; more than one make a wood.
    #[serde(default = "one")]
    pub trees: u32,
    /// The length of the trunk in metres.
    pub height: f64,
    /// The radius of the trunk's foot as a share of its length.
    pub girth: f64,
    /// The bark of all limbs.
    pub bark: Bark,
    /// The levels of limbs, from the trunk down.
    pub levels: Vec<LimbLevel>,
    /// The leaves on the last level.
    pub leaf: Blade,
}

fn one() -> u32 {
    1
}

/// The bark of limbs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bark {
    /// The share of light that is reflected, linear R, G, B.
    pub reflected: [f32; 3],
}

/// A level of limbs. What is said of a limb on its parent has no effect for the trunk.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimbLevel {
    /// The name of its sub-objects.
    pub name: String,
    /// The number of different limbs that are grown, 1 or 2.
    #[serde(default = "one")]
    pub variants: u32,
    /// The number of polygons around a limb.
    pub sides: u32,
    /// The number of polygons along a limb.
    pub segments: u32,
    /// The number of limbs on each parent.
    #[serde(default = "one")]
    pub count: u32,
    /// The length as a share of the parent's.
    #[serde(default = "whole")]
    pub ratio: f64,
    /// How lengths follow the place on the parent.
    #[serde(default)]
    pub profile: Profile,
    /// The angle to the parent in degrees, of the lowest limb and of the highest one.
    #[serde(default)]
    pub angle: [f64; 2],
    /// The largest change of each angle by chance, in degrees.
    #[serde(default)]
    pub spread: f64,
    /// The share of a limb from its foot that has no children.
    #[serde(default)]
    pub bare: f64,
    /// How far a limb of length 1 bends to the direction of its parent; below 0 away from it.
    #[serde(default)]
    pub tropism: f64,
    /// How far its curve wanders by chance, as a share of its length.
    #[serde(default)]
    pub wander: f64,
}

fn whole() -> f64 {
    1.0
}

/// How lengths of limbs follow their place x on the parent, 0 at the tip and 1 where the crown begins (Weber & Penn 1995,
/// *Creation and Rendering of Realistic Trees*).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// All are equal.
    #[default]
    Cylinder,
    /// 0.2 + 0.8 sin(pi x).
    Sphere,
    /// 0.2 + 0.8 sin(pi x / 2).
    Hemisphere,
    /// 0.5 + 0.5 x.
    TaperedCylinder,
    /// 0.2 + 0.8 x.
    Cone,
}

impl Profile {
    /// Returns the factor of lengths at `x`, 0..=1.
    pub fn at(self, x: f64) -> f64 {
        let sine = |angle: f64| 0.2 + 0.8 * angle.sin();
        match self {
            Self::Cylinder => 1.0,
            Self::Sphere => sine(std::f64::consts::PI * x),
            Self::Hemisphere => sine(std::f64::consts::FRAC_PI_2 * x),
            Self::TaperedCylinder => 0.5 + 0.5 * x,
            Self::Cone => 0.2 + 0.8 * x,
        }
    }
}

/// The leaves.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blade {
    /// The outline that the generator draws.
    pub shape: LeafShape,
    /// The number of different leaves, 1 or 2; the second one is lighter.
    #[serde(default = "one")]
    pub variants: u32,
    /// The number of leaves on each parent.
    pub count: u32,
    /// The length with the stalk, as a share of the parent's length.
    pub ratio: f64,
    /// The width as a share of the length.
    pub width: f64,
    /// The angle to the parent in degrees, of the lowest leaf and of the highest one.
    pub angle: [f64; 2],
    /// The largest change of each angle by chance, in degrees.
    #[serde(default)]
    pub spread: f64,
    /// The angle in degrees by which each half is folded up along the rib.
    #[serde(default)]
    pub fold: f64,
    /// The share of light that is reflected, linear R, G, B.
    pub reflected: [f32; 3],
    /// The share of light that is let through, linear R, G, B.
    pub through: [f32; 3],
}

/// The outlines of leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeafShape {
    /// Five pointed lobes, as of a maple.
    Palmate,
    /// Round lobes on both sides of the rib, as of an oak.
    Lobed,
}

/// The largest number of trees in a wood.
const MOST_TREES: u32 = 10_000;
/// The largest number of children on a limb.
const MOST_CHILDREN: u32 = 10_000;
/// The largest number of polygons around a limb, and along it.
const MOST_AROUND: u32 = 1_000;

impl Species {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// The JSON path of the first number that is not, and what was found and expected there.
    pub fn check(&self) -> Result<(), (String, String)> {
        within("trees", f64::from(self.trees), 1.0, f64::from(MOST_TREES))?;
        within("height", self.height, 1e-3, 1e3)?;
        within("girth", self.girth, 1e-4, 0.5)?;
        shares("bark.reflected", &self.bark.reflected)?;
        within("levels", self.levels.len() as f64, 1.0, 60.0)?;
        for (index, level) in self.levels.iter().enumerate() {
            let of = |field: &str| format!("levels[{index}].{field}");
            within(&of("variants"), f64::from(level.variants), 1.0, if index == 0 { 1.0 } else { 2.0 })?;
            within(&of("sides"), f64::from(level.sides), 3.0, f64::from(MOST_AROUND))?;
            within(&of("segments"), f64::from(level.segments), 1.0, f64::from(MOST_AROUND))?;
            within(&of("count"), f64::from(level.count), 1.0, f64::from(MOST_CHILDREN))?;
            within(&of("ratio"), level.ratio, 1e-3, 1.0)?;
            angles(&of("angle"), &level.angle)?;
            within(&of("spread"), level.spread, 0.0, 180.0)?;
            within(&of("bare"), level.bare, 0.0, 0.95)?;
            within(&of("tropism"), level.tropism, -0.9, 0.9)?;
            within(&of("wander"), level.wander, 0.0, 0.5)?;
        }
        let leaf = &self.leaf;
        within("leaf.variants", f64::from(leaf.variants), 1.0, 2.0)?;
        within("leaf.count", f64::from(leaf.count), 1.0, f64::from(MOST_CHILDREN))?;
        within("leaf.ratio", leaf.ratio, 1e-3, 10.0)?;
        within("leaf.width", leaf.width, 1e-2, 10.0)?;
        angles("leaf.angle", &leaf.angle)?;
        within("leaf.spread", leaf.spread, 0.0, 180.0)?;
        within("leaf.fold", leaf.fold, 0.0, 85.0)?;
        shares("leaf.reflected", &leaf.reflected)?;
        shares("leaf.through", &leaf.through)
    }
}

fn within(path: &str, value: f64, low: f64, high: f64) -> Result<(), (String, String)> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err((path.to_owned(), format!("{value}, expected a number from {low} to {high}")))
}

fn shares(path: &str, values: &[f32; 3]) -> Result<(), (String, String)> {
    let mut each = (0..).zip(values);
    each.try_for_each(|(i, value)| within(&format!("{path}[{i}]"), f64::from(*value), 0.0, 1.0))
}

fn angles(path: &str, values: &[f64; 2]) -> Result<(), (String, String)> {
    let mut each = (0..).zip(values);
    each.try_for_each(|(i, value)| within(&format!("{path}[{i}]"), *value, 0.0, 180.0))
}
