//! A painted plant is another plant: where paint reaches one instance of a sub-object, that instance becomes a sub-object of its own,
//! because the others share its images and polygons and keep their colours. Small ones become triangles.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DAffine3;
use rustc_hash::FxHashMap;

use super::{PaintAt, PaintField};
use crate::detail::DetailLevels;
use crate::mesh::Mesh;
use crate::plant::{Plant, SubObject, Use};
use crate::primitive::{Corner, Material, Primitive, Shape, TriangleList};
use crate::view::normal_map;

/// A painted instance of at most this many polygons becomes triangles: it has no images, and its parts would be as many things to
/// draw as it has leaves.
const MOST_AS_TRIANGLES: u64 = 4_000;
/// The most polygons of instances that paint may make sub-objects of their own: some 100 bytes each.
const MOST_POLYGONS: u64 = 2_000_000;

/// A plant with paint.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedPlant {
    /// The plant. Bounds and counts are those without paint.
    pub plant: Plant,
    /// The polygons of instances, all counted, that paint reaches and that keep their colours, because the plant would become too
    /// large.
    pub unpainted: u64,
}

/// Paints the sub-object `top` of a plant, which becomes the whole plant, with all that it uses. `fields` has the paint of sub-objects
/// by index; that of sub-objects which use `top` does not count.
pub fn painted(plant: &Plant, top: usize, fields: &BTreeMap<usize, Arc<PaintField>>) -> PaintedPlant {
    painted_within(plant, top, fields, MOST_POLYGONS)
}

pub(super) fn painted_within(
    plant: &Plant,
    top: usize,
    fields: &BTreeMap<usize, Arc<PaintField>>,
    most_polygons: u64,
) -> PaintedPlant {
    let mut has_own_below = vec![false; plant.objects.len()];
    for (index, object) in plant.objects.iter().enumerate() {
        let below = object.uses.iter().any(|of| has_own_below[of.child] || fields.contains_key(&of.child));
        has_own_below[index] = below;
    }
    let mut painter = PlantPainter {
        plant,
        fields,
        has_own_below,
        objects: Vec::new(),
        shared: vec![None; plant.objects.len()],
        meshes: FxHashMap::default(),
        left: most_polygons,
        unpainted: 0,
    };
    let root = painter.add(top, &[]);
    let PlantPainter { objects, unpainted, .. } = painter;
    PaintedPlant { plant: Plant { objects, root, up: plant.up, unit: plant.unit }, unpainted }
}

struct PlantPainter<'a> {
    plant: &'a Plant,
    fields: &'a BTreeMap<usize, Arc<PaintField>>,
    /// Whether something that a sub-object uses, directly or not, has paint of its own.
    has_own_below: Vec<bool>,
    objects: Vec<SubObject>,
    /// The new index of each sub-object as all instances share it that no paint from above reaches.
    shared: Vec<Option<usize>>,
    meshes: FxHashMap<usize, Arc<Vec<Mesh>>>,
    /// The polygons that may still become sub-objects of their own.
    left: u64,
    unpainted: u64,
}

impl PlantPainter<'_> {
    /// Adds an instance of a sub-object that paint from above may reach; returns its index.
    fn add(&mut self, object: usize, from_above: &[PaintAt]) -> usize {
        let of = &self.plant.objects[object];
        let ball = &of.bounds.ball;
        let reaches = |paint: &&PaintAt| paint.field.touches(&ball.mapped(&paint.field_from_object));
        let mut paint: Vec<PaintAt> = from_above.iter().filter(reaches).cloned().collect();
        let polygons = of.counts.polygons;
        let is_small = polygons <= MOST_AS_TRIANGLES && !self.has_own_below[object];
        if !paint.is_empty() && (self.left == 0 || (is_small && polygons > self.left)) {
            (self.left, self.unpainted) = (0, self.unpainted.saturating_add(polygons));
            paint.clear();
        }
        let is_shared = paint.is_empty();
        if let Some(known) = self.shared[object].filter(|_| is_shared) {
            return known;
        }
        if let Some(field) = self.fields.get(&object).filter(|field| !field.is_empty()) {
            let own = PaintAt { field: field.clone(), field_from_object: DAffine3::IDENTITY };
            paint.push(own);
        }
        let (primitives, uses) = match is_small && !is_shared {
            true => {
                self.left -= polygons;
                (self.triangles(object), Vec::new())
            }
            false => {
                let uses = of.uses.iter().map(|of| self.used(of, &paint)).collect();
                (of.primitives.clone(), uses)
            }
        };
        let SubObject { name, bounds, counts, leaves, .. } = of;
        let (name, bounds, counts, leaves) = (name.clone(), *bounds, *counts, *leaves);
        // What paint reaches keeps all its polygons, because colours are known at their corners.
        let detail = if paint.is_empty() { of.detail.clone() } else { DetailLevels::default() };
        self.objects.push(SubObject { name, primitives, uses, bounds, counts, leaves, detail, paint });
        let index = self.objects.len() - 1;
        if is_shared {
            self.shared[object] = Some(index);
        }
        index
    }

    fn used(&mut self, Use { child, parent_from_child }: &Use, paint: &[PaintAt]) -> Use {
        let carried = |at: &PaintAt| PaintAt {
            field: at.field.clone(),
            field_from_object: at.field_from_object * *parent_from_child,
        };
        let carried: Vec<PaintAt> = paint.iter().map(carried).collect();
        Use { child: self.add(*child, &carried), parent_from_child: *parent_from_child }
    }

    /// Returns the triangles of a sub-object with all that it uses, a list for each material.
    fn triangles(&mut self, object: usize) -> Vec<Primitive> {
        let mut lists: Vec<(Arc<Material>, TriangleList)> = Vec::new();
        let mut left = vec![(object, DAffine3::IDENTITY)];
        while let Some((part, object_from_part)) = left.pop() {
            let of = &self.plant.objects[part];
            let meshes = self.meshes.entry(part).or_insert_with(|| Arc::new(Mesh::of(of))).clone();
            meshes.iter().for_each(|mesh| add_mesh(&mut lists, mesh, &object_from_part));
            let uses = of.uses.iter().rev();
            left.extend(uses.map(|of| (of.child, object_from_part * of.parent_from_child)));
        }
        let primitive = |(material, list)| Primitive { shape: Shape::Triangles(list), material };
        lists.into_iter().map(primitive).collect()
    }
}

fn add_mesh(lists: &mut Vec<(Arc<Material>, TriangleList)>, mesh: &Mesh, object_from_part: &DAffine3) {
    let index = lists.iter().position(|(material, _)| Arc::ptr_eq(material, &mesh.material));
    let index = index.unwrap_or_else(|| {
        let empty = TriangleList { corners: Vec::new(), triangles: Vec::new() };
        lists.push((mesh.material.clone(), empty));
        lists.len() - 1
    });
    let list = &mut lists[index].1;
    let (first, normals) = (list.corners.len() as u32, normal_map(&object_from_part.matrix3));
    list.corners.extend(mesh.corners.iter().map(|corner| Corner {
        position: object_from_part.transform_point3(corner.position),
        normal: (normals * corner.normal).normalize_or_zero(),
        texture: corner.texture,
    }));
    list.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
}
