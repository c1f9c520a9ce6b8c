//! Grows plants from the numbers of a species, with one seed.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::assemble::{Draft, DraftUse, PlantFlaw, assemble};
use super::leaf_picture::{OUTER, leaf_picture};
use super::plant::Plant;
use super::primitive::{Corner, CurvePoint, Limb, Material, Primitive, Shape};
use super::species::{Blade, LimbLevel, Profile, Species};
use quadratura_base::scene::synthetic::Rng;

/// The turn from one child to the next in degrees: the golden angle.
const TURN: f64 = 137.508;
/// Radii go with lengths to this power (Weber & Penn 1995).
const RADIUS_POWER: f64 = 1.2;
/// The alpha below which there is no leaf.
const CUTOUT: f32 = 0.5;
/// The radii of a limb's control points, as shares of that of its foot.
const TAPER: [f64; 4] = [1.0, 0.82, 0.6, 0.2];
/// The largest radius of a limb at its foot as a share of its parent's there: a thicker one would show the open end of its
/// tube. Limbs of 8 sides are 0.92 of their radius where they are thinnest.
const THICKEST: f64 = 0.9;

/// Grows a plant. Its root is in metres, z is up, and the foot of a single tree is the origin. A wood has its trees' feet
/// on the plane z = 0 around the origin.
///
/// Each level is grown once a variant, leaves first. Child i of f is on its limb at the share `a + (1 - a)(i + 1/2)/f`, a
/// the bare share, turned by i times 137.508 degrees, and leans by the level's angle, each with the level's spread; its
/// length is its parent's times the level's ratio times the profile, or less, so that it is not thicker than its parent.
///
/// # Errors
/// A plant that exceeds a limit. The numbers have to be checked ([`Species::check`]).
pub fn grow(species: &Species) -> Result<Plant, PlantFlaw> {
    let mut grower = Grower { rng: Rng::new(species.seed), drafts: Vec::new() };
    let mut children = Children::of_leaf(&species.leaf, grower.leaves(&species.leaf));
    let bark = Material { reflected: species.bark.reflected, name: "bark".into(), ..Material::default() };
    let bark = Arc::new(bark);
    for (index, level) in species.levels.iter().enumerate().rev() {
        let length = if index == 0 { species.height } else { 1.0 };
        let radius = length * girth(species, index);
        let variants = (0..level.variants.max(1)).map(|variant| {
            let name = if level.variants > 1 {
                format!("{} {}", level.name, variant + 1)
            } else {
                level.name.clone()
            };
            grower.limb(name, level, [length, radius], &children, &bark)
        });
        let variants = variants.collect();
        children = Children::of_level(level, variants, girth(species, index));
    }
    let root = match species.trees {
        0 | 1 => children.variants[0],
        trees => grower.placed(species, trees, children.variants[0]),
    };
    assemble(grower.drafts, root, DVec3::Z, 1.0)
}

/// Returns the radius of a level's limbs at their foot for a length of 1.
fn girth(species: &Species, index: usize) -> f64 {
    let ratios = species.levels[1..=index].iter().map(|level| level.ratio);
    species.girth * ratios.map(|ratio| ratio.powf(RADIUS_POWER - 1.0)).product::<f64>()
}

/// How children of one level are on their parent.
struct Children {
    /// The drafts of the variants.
    variants: Vec<usize>,
    count: u32,
    ratio: f64,
    profile: Profile,
    angle: [f64; 2],
    spread: f64,
    /// The radius at the foot for a length of 1; 0 for leaves.
    girth: f64,
}

impl Children {
    fn of_leaf(leaf: &Blade, variants: Vec<usize>) -> Self {
        let Blade { count, ratio, angle, spread, .. } = *leaf;
        Self { variants, count, ratio, profile: Profile::Cylinder, angle, spread, girth: 0.0 }
    }

    fn of_level(level: &LimbLevel, variants: Vec<usize>, girth: f64) -> Self {
        let LimbLevel { count, ratio, profile, angle, spread, .. } = *level;
        Self { variants, count, ratio, profile, angle, spread, girth }
    }
}

/// The drafts so far.
struct Grower {
    rng: Rng,
    drafts: Vec<Draft>,
}

impl Grower {
    /// Returns a number between minus and plus `most`.
    fn around(&mut self, most: f64) -> f64 {
        self.rng.between(-most, most)
    }

    fn add(&mut self, draft: Draft) -> usize {
        self.drafts.push(draft);
        self.drafts.len() - 1
    }

    /// Makes the leaves: two triangles each, of length 1, along z; x is the normal of the upper side.
    fn leaves(&mut self, leaf: &Blade) -> Vec<usize> {
        let variants = leaf.variants.max(1);
        let make = |variant: u32| {
            // The second leaf is a younger one.
            let factor = if variant == 0 { 1.0 } else { 1.3 };
            let lighter = |share: f32| (share * factor).min(1.0);
            let material = Arc::new(Material {
                name: if variants > 1 { format!("leaf {}", variant + 1) } else { "leaf".into() },
                reflected: [1.0; 3],
                through: leaf.through.map(lighter),
                leaf: true,
                cutout: Some(CUTOUT),
                picture: Some(Arc::new(leaf_picture(leaf.shape, leaf.reflected.map(lighter)))),
                ..Material::default()
            });
            let primitive = |side: f64| Primitive {
                shape: Shape::Polygon(half_leaf(leaf, side)),
                material: material.clone(),
            };
            Draft {
                name: material.name.clone(),
                primitives: [-1.0, 1.0].map(primitive).into(),
                uses: Vec::new(),
            }
        };
        (0..variants).map(|variant| self.add(make(variant))).collect()
    }

    /// Grows a limb along z with its children.
    fn limb(
        &mut self,
        name: String,
        level: &LimbLevel,
        [length, radius]: [f64; 2],
        children: &Children,
        bark: &Arc<Material>,
    ) -> usize {
        let limb = Limb {
            points: self.curve(level, length, radius),
            sides: level.sides,
            segments: level.segments,
            object_from_limb: DAffine3::IDENTITY,
        };
        let uses = (0..children.count).map(|i| self.child(i, level.bare, length, &limb, children)).collect();
        let primitives = vec![Primitive { shape: Shape::Limb(limb), material: bark.clone() }];
        self.add(Draft { name, primitives, uses })
    }

    /// Returns the control points of a limb: it leaves along z and bends to x by its tropism.
    fn curve(&mut self, level: &LimbLevel, length: f64, radius: f64) -> Vec<CurvePoint> {
        let bend = level.tropism;
        let far = (1.0 - bend * bend).sqrt();
        let points = [
            DVec3::ZERO,
            DVec3::new(0.0, 0.0, 0.34),
            DVec3::new(0.4 * bend, 0.0, 0.36 + 0.31 * far),
            DVec3::new(bend, 0.0, far),
        ];
        let mut control = |i: usize| {
            let wander = if i < 2 { 0.0 } else { level.wander };
            let aside = DVec3::new(self.around(wander), self.around(wander), 0.0);
            CurvePoint { position: length * (points[i] + aside), radius: radius * TAPER[i] }
        };
        (0..4).map(&mut control).collect()
    }

    /// Places child `i` on a limb.
    fn child(&mut self, i: u32, bare: f64, length: f64, limb: &Limb, children: &Children) -> DraftUse {
        let place = (f64::from(i) + 0.5) / f64::from(children.count);
        let (at, along) = limb.along(bare + (1.0 - bare) * place);
        let [lowest, highest] = children.angle;
        let lean = (lowest + (highest - lowest) * place + self.around(children.spread)).to_radians();
        let turn = (f64::from(i) * TURN + self.around(children.spread)).to_radians();
        let across = (DVec3::X - DVec3::X.dot(along) * along).try_normalize().unwrap_or(DVec3::Y);
        let outwards = turn.cos() * across + turn.sin() * along.cross(across);
        let z = lean.cos() * along + lean.sin() * outwards;
        // Tropism bends to x: to the direction of the parent.
        let x = (along - along.dot(z) * z).try_normalize().unwrap_or(-outwards);
        let wanted = length * children.ratio * children.profile.at(1.0 - place);
        let size =
            if children.girth > 0.0 { wanted.min(THICKEST * at.radius / children.girth) } else { wanted };
        let parent_from_child =
            DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z) * size, at.position);
        let variant = self.rng.whole(0, children.variants.len() as u32 - 1);
        DraftUse { child: children.variants[variant as usize], parent_from_child }
    }

    /// Plants a wood: feet at random in a disc, no two of them nearer than the crowns allow.
    fn placed(&mut self, species: &Species, trees: u32, tree: usize) -> usize {
        let apart = 0.45 * species.height;
        let mut feet: Vec<DVec2> = Vec::new();
        // The disc is large enough for all; where chance finds no place for a while, it grows.
        let mut radius = 0.75 * apart * f64::from(trees).sqrt();
        while feet.len() < trees as usize {
            let (angle, far) = (self.rng.between(0.0, TAU), self.rng.unit().sqrt());
            let foot = radius * far * DVec2::from_angle(angle);
            match feet.iter().all(|other| other.distance(foot) >= apart) {
                true => feet.push(foot),
                false => radius *= 1.001,
            }
        }
        let place = |foot: &DVec2| {
            let turn = DMat3::from_rotation_z(self.rng.between(0.0, TAU));
            let parent_from_child = DAffine3::from_mat3_translation(turn, foot.extend(0.0));
            DraftUse { child: tree, parent_from_child }
        };
        let uses = feet.iter().map(place).collect();
        self.add(Draft { name: "wood".into(), primitives: Vec::new(), uses })
    }
}

/// Returns one half of a leaf, to the left (-1) or right (1) of its rib.
fn half_leaf(leaf: &Blade, side: f64) -> Vec<Corner> {
    let (sin, cos) = leaf.fold.to_radians().sin_cos();
    let across = 0.5 * leaf.width * DVec3::new(sin, side * cos, 0.0);
    let corner =
        |position: DVec3, u: f64, v: f64| Corner { position, normal: DVec3::ZERO, texture: DVec2::new(u, v) };
    let foot = corner(DVec3::ZERO, 0.5, 1.0);
    let tip = corner(DVec3::Z, 0.5, 0.0);
    let outer = corner(across + (1.0 - OUTER) * DVec3::Z, 0.5 + 0.5 * side, OUTER);
    if side > 0.0 { vec![foot, outer, tip] } else { vec![foot, tip, outer] }
}
