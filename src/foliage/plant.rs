//! The plant: a directed graph of sub-objects without cycles.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::bounds::Bounds;
use super::detail::DetailLevels;
use super::leaves::Leaves;
use super::paint::PaintAt;
use super::primitive::{Material, Primitive};

/// The largest number of levels of a plant.
pub const MOST_LEVELS: usize = 64;
/// The largest number of uses that a plant stores.
pub const MOST_USES: usize = 1_000_000;
/// The largest number of corners of all sub-objects, each counted once.
pub const MOST_CORNERS: u64 = 30_000_000;

/// A child in a sub-object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// The index of the child in [`Plant::objects`].
    pub child: usize,
    /// The map from the child's frame to the frame of the sub-object that uses it; not singular.
    pub parent_from_child: DAffine3,
}

/// How much there is of a sub-object with everything that it uses, counting every instance. Counts that do not fit are
/// the largest number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Counts {
    /// The number of instances, itself included. A sub-object that has no primitives of its own, such as a wood that only
    /// places trees, is not counted.
    pub sub_objects: u64,
    /// The number of polygons.
    pub polygons: u64,
    /// The number of triangles that are drawn for them.
    pub triangles: u64,
    /// The number of sub-objects on the longest way from it down, itself included.
    pub levels: usize,
}

/// Primitives and uses of others, in its own frame and unit.
#[derive(Debug, Clone, PartialEq)]
pub struct SubObject {
    /// The name, for people.
    pub name: String,
    /// The primitives of its own.
    pub primitives: Vec<Primitive>,
    /// The sub-objects that it uses.
    pub uses: Vec<Use>,
    /// A box and a ball around it with everything that it uses, in its own frame.
    pub bounds: Bounds,
    /// The counts of it with everything that it uses.
    pub counts: Counts,
    /// The lengths of its leaves with everything that it uses.
    pub leaves: Leaves,
    /// The levels of detail of its polygons.
    pub detail: DetailLevels,
    /// The paint that reaches it, that on what uses it first; none but in a plant that was [`super::painted`].
    pub paint: Vec<PaintAt>,
}

/// A plant as geometry. Sub-objects are stored once, however often they are used.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// The sub-objects, children before those that use them.
    pub objects: Vec<SubObject>,
    /// The index of the whole plant in `objects`.
    pub root: usize,
    /// What is up, a unit vector in the root's frame.
    pub up: DVec3,
    /// The length of the root's unit in metres.
    pub unit: f64,
}

impl Plant {
    /// Returns the sub-object that is the whole plant.
    pub fn whole(&self) -> &SubObject {
        &self.objects[self.root]
    }

    /// Returns a sub-object as a plant of its own, without what it does not use.
    pub(super) fn part(&self, object: usize) -> Self {
        let mut is_used = vec![false; object + 1];
        is_used[object] = true;
        for index in (0..=object).rev() {
            if is_used[index] {
                self.objects[index].uses.iter().for_each(|of| is_used[of.child] = true);
            }
        }
        let of_all: Vec<usize> = (0..=object).filter(|index| is_used[*index]).collect();
        let mut place = vec![usize::MAX; object + 1];
        of_all.iter().enumerate().for_each(|(at, index)| place[*index] = at);
        let moved = |index: &usize| {
            let mut object = self.objects[*index].clone();
            object.uses.iter_mut().for_each(|of| of.child = place[of.child]);
            object
        };
        let objects: Vec<SubObject> = of_all.iter().map(moved).collect();
        Self { root: objects.len() - 1, objects, ..*self }
    }

    /// Returns the number of instances of each sub-object, in their order; numbers that do not fit are the largest one.
    pub fn instances(&self) -> Vec<u64> {
        let mut instances = vec![0u64; self.objects.len()];
        instances[self.root] = 1;
        // Those that use others come after them.
        for (index, object) in self.objects.iter().enumerate().rev() {
            for Use { child, .. } in &object.uses {
                instances[*child] = instances[*child].saturating_add(instances[index]);
            }
        }
        instances
    }

    /// Returns the materials that primitives have, each once, in the order of the sub-objects.
    pub fn materials(&self) -> Vec<&Arc<Material>> {
        let mut materials: Vec<&Arc<Material>> = Vec::new();
        for primitive in self.objects.iter().flat_map(|object| &object.primitives) {
            let material = &primitive.material;
            // Most primitives share their material; only others have to be compared.
            if !materials.iter().any(|known| Arc::ptr_eq(known, material) || *known == material) {
                materials.push(material);
            }
        }
        materials
    }
}
