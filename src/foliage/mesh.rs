//! The triangles of a sub-object's own primitives, made once for drawing.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::plant::{Plant, SubObject};
use super::primitive::{Corner, Material, Shape, TriangleList};
use quadratura_base::geometry::polygon::{fit_plane, newell_normal, triangulate};

/// Triangles of one material, in the sub-object's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// The corners; no normal is zero unless its triangles have no area.
    pub corners: Vec<Corner>,
    /// Three indices into `corners` a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The material.
    pub material: Arc<Material>,
}

impl Mesh {
    /// Makes the triangles of a sub-object's own primitives, in their order; neighbours of one material share a mesh.
    pub fn of(object: &SubObject) -> Vec<Self> {
        Self::of_level(object, 0)
    }

    /// Makes them as [`Self::of`], at one of the sub-object's [levels of detail](SubObject::detail).
    pub fn of_level(object: &SubObject, level: usize) -> Vec<Self> {
        let mut meshes: Vec<Self> = Vec::new();
        let mut limbs = object.detail.limbs(&object.primitives, level);
        for primitive in &object.primitives {
            let list = match &primitive.shape {
                Shape::Polygon(corners) => of_polygon(corners),
                Shape::Limb(_) => limbs.next().expect("a level has all limbs").triangles(),
                Shape::Triangles(list) => with_normals(list),
            };
            let material = &primitive.material;
            match meshes.last_mut().filter(|mesh| Arc::ptr_eq(&mesh.material, material)) {
                Some(mesh) => mesh.append(&list),
                None => {
                    let TriangleList { corners, triangles } = list;
                    meshes.push(Self { corners, triangles, material: material.clone() });
                }
            }
        }
        meshes
    }

    fn append(&mut self, list: &TriangleList) {
        let first = self.corners.len() as u32;
        self.corners.extend(&list.corners);
        self.triangles.extend(list.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    }
}

/// The triangles of a plant's sub-objects, at the levels of detail that are drawn.
#[derive(Debug)]
pub struct Meshes {
    /// By sub-object and level of detail.
    of_levels: Vec<Vec<Vec<Mesh>>>,
}

impl Meshes {
    /// Makes those of all sub-objects in full detail.
    pub fn in_full(plant: &Plant) -> Self {
        Self { of_levels: plant.objects.par_iter().map(|object| vec![Mesh::of(object)]).collect() }
    }

    /// Makes those of all sub-objects at all levels of detail.
    pub fn of_all_levels(plant: &Plant) -> Self {
        let levels =
            |(object, of): (usize, &SubObject)| (0..of.detail.count()).map(move |level| (object, level));
        Self::of(plant, plant.objects.iter().enumerate().flat_map(levels))
    }

    /// Makes those of the wanted sub-objects and levels of detail.
    pub fn of(plant: &Plant, wanted: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut is_wanted: Vec<Vec<bool>> =
            plant.objects.iter().map(|object| vec![false; object.detail.count()]).collect();
        wanted.for_each(|(object, level)| is_wanted[object][level] = true);
        let all = |(object, wanted): (&SubObject, &Vec<bool>)| {
            let level = |(level, wanted): (usize, &bool)| match wanted {
                true => Mesh::of_level(object, level),
                false => Vec::new(),
            };
            wanted.iter().enumerate().map(level).collect()
        };
        Self { of_levels: plant.objects.par_iter().zip(&is_wanted).map(all).collect() }
    }

    /// Returns those of a sub-object at a level of detail; none where they were not wanted.
    pub fn get(&self, object: usize, level: usize) -> &[Mesh] {
        &self.of_levels[object][level]
    }
}

/// Cuts a polygon into triangles. One that crosses itself becomes a fan around its first corner.
fn of_polygon(corners: &[Corner]) -> TriangleList {
    let ring: Vec<DVec3> = corners.iter().map(|corner| corner.position).collect();
    let flat = newell_normal(&ring).normalize_or_zero();
    let fan = || (2..ring.len() as u32).map(|last| [0, last - 1, last]).collect();
    let cut = fit_plane(&ring).filter(|_| ring.len() > 3).map(|plane| triangulate(&ring, &plane));
    let triangles = match cut {
        Some(cut) if cut.crossings.is_empty() && !cut.triangles.is_empty() => cut.triangles,
        _ => fan(),
    };
    let corners = corners.iter().map(|corner| Corner { normal: own_or(corner.normal, flat), ..*corner });
    TriangleList { corners: corners.collect(), triangles }
}

/// Gives triangles without normals those of their planes; corners that they share are then stored for each.
fn with_normals(list: &TriangleList) -> TriangleList {
    if list.corners.iter().all(|corner| corner.normal != DVec3::ZERO) {
        return list.clone();
    }
    let mut flat = TriangleList { corners: Vec::new(), triangles: Vec::new() };
    for triangle in &list.triangles {
        let corners = triangle.map(|index| list.corners[index as usize]);
        let normal = newell_normal(&corners.map(|corner| corner.position)).normalize_or_zero();
        let first = flat.corners.len() as u32;
        flat.corners.extend(corners.map(|corner| Corner { normal: own_or(corner.normal, normal), ..corner }));
        flat.triangles.push([first, first + 1, first + 2]);
    }
    flat
}

/// Returns a normal of length 1: its own, or where that is zero the plane's.
fn own_or(own: DVec3, flat: DVec3) -> DVec3 {
    own.try_normalize().unwrap_or(flat)
}
