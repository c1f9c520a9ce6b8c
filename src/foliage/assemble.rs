//! Drafts of sub-objects, in any order, become a plant: ordered, without repetition, counted and bounded.

use std::collections::hash_map::Entry;
use std::fmt;
use std::hash::{Hash, Hasher};

use glam::{DAffine3, DVec3};
use rustc_hash::{FxHashMap, FxHasher};

use super::bounds::Bounds;
use super::detail::DetailLevels;
use super::leaves::Leaves;
use super::order::children_first;
use super::plant::{Counts, MOST_CORNERS, MOST_LEVELS, MOST_USES, Plant, SubObject, Use};
use super::primitive::{Corner, Primitive, Shape};

/// A use of a sub-object that may not be known yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DraftUse {
    /// The index of the child among the drafts.
    pub child: usize,
    /// The map from the child's frame to that of the sub-object that uses it.
    pub parent_from_child: DAffine3,
}

/// A sub-object before the plant is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Draft {
    /// The name, for people.
    pub name: String,
    /// The primitives of its own.
    pub primitives: Vec<Primitive>,
    /// The uses of other drafts.
    pub uses: Vec<DraftUse>,
}

/// Why drafts are no plant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlantFlaw {
    /// A sub-object uses itself: the names on the way, the first one again at the end.
    Cycle(Vec<String>),
    /// There are more levels than [`MOST_LEVELS`].
    Levels(usize),
    /// There are more uses than [`MOST_USES`].
    Uses(usize),
    /// There are more corners than [`MOST_CORNERS`].
    Corners(u64),
    /// This sub-object is larger than numbers go.
    Endless(String),
}

impl fmt::Display for PlantFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cycle(names) => {
                let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
                write!(f, "a sub-object uses itself: {}", names.join(" uses "))
            }
            Self::Levels(count) => write!(f, "{count} levels, but a plant has at most {MOST_LEVELS}"),
            Self::Uses(count) => write!(f, "{count} uses, but a plant has at most {MOST_USES}"),
            Self::Corners(count) => write!(f, "{count} corners, but a plant has at most {MOST_CORNERS}"),
            Self::Endless(name) => {
                write!(f, "{name:?} has no size that is a finite number, with all that it uses")
            }
        }
    }
}

/// Makes a plant of what `root` uses, directly or not. Sub-objects with the same primitives and uses become one, which
/// keeps the name of the first. `up` has any length but 0; `unit` is in metres.
///
/// # Errors
/// A cycle, a limit that is exceeded, or a size that is not finite.
pub fn assemble(drafts: Vec<Draft>, root: usize, up: DVec3, unit: f64) -> Result<Plant, PlantFlaw> {
    let uses: usize = drafts.iter().map(|draft| draft.uses.len()).sum();
    if uses > MOST_USES {
        return Err(PlantFlaw::Uses(uses));
    }
    let children: Vec<Vec<usize>> =
        drafts.iter().map(|draft| draft.uses.iter().map(|of| of.child).collect()).collect();
    let names = |cycle: Vec<usize>| cycle.iter().map(|&index| drafts[index].name.clone()).collect();
    let order = children_first(&children, root).map_err(|cycle| PlantFlaw::Cycle(names(cycle)))?;
    let mut drafts: Vec<Option<Draft>> = drafts.into_iter().map(Some).collect();
    let mut assembled = AssembledObjects::default();
    let mut place = vec![usize::MAX; drafts.len()];
    for index in order {
        let draft = drafts[index].take().expect("the order names each draft once");
        place[index] = assembled.add(draft, &place)?;
    }
    let up = up.try_normalize().unwrap_or(DVec3::Z);
    Ok(Plant { objects: assembled.objects, root: place[root], up, unit })
}

/// The sub-objects so far.
#[derive(Default)]
struct AssembledObjects {
    objects: Vec<SubObject>,
    /// The sub-objects by the hash of their content.
    known: FxHashMap<u64, Vec<usize>>,
    corners: u64,
}

impl AssembledObjects {
    /// Adds a draft whose children have their `place`; returns its own.
    fn add(&mut self, draft: Draft, place: &[usize]) -> Result<usize, PlantFlaw> {
        let Draft { name, primitives, uses } = draft;
        let uses: Vec<Use> = uses
            .iter()
            .map(|of| Use { child: place[of.child], parent_from_child: of.parent_from_child })
            .collect();
        let same = self.known.entry(content_hash(&primitives, &uses));
        let is_same = |index: &&usize| {
            self.objects[**index].primitives == primitives && self.objects[**index].uses == uses
        };
        if let Entry::Occupied(same) = &same
            && let Some(index) = same.get().iter().find(is_same)
        {
            return Ok(*index);
        }
        same.or_default().push(self.objects.len());
        self.corners = primitives.iter().fold(self.corners, |sum, p| sum.saturating_add(p.shape.corners()));
        if self.corners > MOST_CORNERS {
            return Err(PlantFlaw::Corners(self.corners));
        }
        let counts = counts(&primitives, &uses, &self.objects);
        if counts.levels > MOST_LEVELS {
            return Err(PlantFlaw::Levels(counts.levels));
        }
        let parts = uses.iter().map(|of| (&of.parent_from_child, &self.objects[of.child]));
        let bounds = Bounds::of(&primitives, parts.clone().map(|(map, part)| (map, &part.bounds)));
        if !bounds.ball.radius.is_finite() || !bounds.ball.middle.is_finite() {
            return Err(PlantFlaw::Endless(name));
        }
        let leaves = Leaves::of(&primitives, parts.map(|(map, part)| (map, &part.leaves)));
        let (detail, paint) = (DetailLevels::of(&primitives), Vec::new());
        self.objects.push(SubObject { name, primitives, uses, bounds, counts, leaves, detail, paint });
        Ok(self.objects.len() - 1)
    }
}

fn counts(primitives: &[Primitive], uses: &[Use], objects: &[SubObject]) -> Counts {
    let own = primitives.iter().map(|primitive| &primitive.shape);
    let mut counts =
        Counts { sub_objects: u64::from(!primitives.is_empty()), levels: 1, ..Counts::default() };
    for shape in own {
        counts.polygons = counts.polygons.saturating_add(shape.polygons());
        counts.triangles = counts.triangles.saturating_add(shape.triangles());
    }
    for child in uses.iter().map(|of| &objects[of.child].counts) {
        counts.sub_objects = counts.sub_objects.saturating_add(child.sub_objects);
        counts.polygons = counts.polygons.saturating_add(child.polygons);
        counts.triangles = counts.triangles.saturating_add(child.triangles);
        counts.levels = counts.levels.max(1 + child.levels);
    }
    counts
}

/// Hashes the numbers of a sub-object. Equal contents have equal hashes; the converse is tested by comparison.
fn content_hash(primitives: &[Primitive], uses: &[Use]) -> u64 {
    let mut hasher = FxHasher::default();
    for Primitive { shape, .. } in primitives {
        shape.polygons().hash(&mut hasher);
        shape.each_ball(|middle, radius| hash_numbers(&mut hasher, &[middle.x, middle.y, middle.z, radius]));
        if let Shape::Polygon(corners) = shape {
            let normal = |corner: &Corner| corner.normal.to_array();
            corners.iter().for_each(|corner| hash_numbers(&mut hasher, &normal(corner)));
        }
    }
    for Use { child, parent_from_child } in uses {
        child.hash(&mut hasher);
        hash_numbers(&mut hasher, &parent_from_child.to_cols_array());
    }
    hasher.finish()
}

fn hash_numbers(hasher: &mut FxHasher, numbers: &[f64]) {
    // 0 and -0 are equal.
    numbers.iter().for_each(|number| (number + 0.0).to_bits().hash(hasher));
}
