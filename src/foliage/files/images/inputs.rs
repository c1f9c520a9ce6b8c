//! The hash of what images of a plant are made of.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use crate::{Corner, Material, PaintAt, PaintField, PaintPoint, Plant, Shape, Wrap};
use quadratura_files::hash::Hashing;

/// Is changed when the same plant gives other images.
const RECIPE: u64 = 5;

/// Is changed when plants are hashed in another way: their exports are then taken for those of other plants.
const PLANT_VERSION: u64 = 3;

/// Returns the hash of what images of a plant are made of: the plant, and how images are made.
pub fn images_hash(plant: &Plant) -> String {
    let mut hashing = Hashing::default();
    hashing.add(&RECIPE.to_le_bytes());
    hashing.add(plant_hash(plant).as_bytes());
    hashing.hash()
}

/// Returns the hash of a plant's geometry, materials and paint; names do not count.
pub fn plant_hash(plant: &Plant) -> String {
    let mut hasher = PlantHasher { hashing: Hashing::default(), bytes: Vec::new() };
    hasher.number(PLANT_VERSION);
    hasher.number(plant.root as u64);
    let mut known: Vec<Arc<Material>> = Vec::new();
    let mut fields: Vec<Arc<PaintField>> = Vec::new();
    for object in &plant.objects {
        hasher.number(object.primitives.len() as u64);
        for primitive in &object.primitives {
            let index = known.iter().position(|material| Arc::ptr_eq(material, &primitive.material));
            if index.is_none() {
                hasher.material(&primitive.material);
                known.push(primitive.material.clone());
            }
            hasher.number(index.unwrap_or(known.len() - 1) as u64);
            hasher.shape(&primitive.shape);
        }
        hasher.number(object.uses.len() as u64);
        for used in &object.uses {
            hasher.number(used.child as u64);
            hasher.map(&used.parent_from_child);
        }
        hasher.paint(&object.paint, &mut fields);
        hasher.flush();
    }
    hasher.hashing.hash()
}

/// Numbers as bytes, which are hashed in pieces.
struct PlantHasher {
    hashing: Hashing,
    bytes: Vec<u8>,
}

impl PlantHasher {
    fn flush(&mut self) {
        self.hashing.add(&self.bytes);
        self.bytes.clear();
    }

    fn number(&mut self, number: u64) {
        self.bytes.extend(number.to_le_bytes());
    }

    fn float(&mut self, number: f64) {
        self.number(number.to_bits());
    }

    fn vector(&mut self, vector: DVec3) {
        vector.to_array().into_iter().for_each(|number| self.float(number));
    }

    fn map(&mut self, map: &DAffine3) {
        map.to_cols_array().into_iter().for_each(|number| self.float(number));
    }

    /// Adds the paint on a sub-object; without paint nothing, so that the hash is that of plants before there was paint.
    fn paint(&mut self, paint: &[PaintAt], known: &mut Vec<Arc<PaintField>>) {
        for PaintAt { field, field_from_object } in paint {
            let index = known.iter().position(|known| Arc::ptr_eq(known, field));
            if index.is_none() {
                self.field(field);
                known.push(field.clone());
            }
            self.number(index.unwrap_or(known.len() - 1) as u64);
            self.map(field_from_object);
        }
    }

    fn field(&mut self, field: &PaintField) {
        for (document, slabs) in (1u64..).zip(field.documents()) {
            self.number(document);
            for slab in slabs {
                self.number(slab.direction as u64);
                [slab.delta, slab.far].into_iter().chain(slab.corner).for_each(|number| self.float(number));
                self.number(slab.points.len() as u64);
                for point in &slab.points {
                    let PaintPoint { at, change, leaf } = point;
                    let numbers = at.to_array().into_iter().chain(change.colour.to_array());
                    numbers.chain([change.alpha]).for_each(|number| self.bytes.extend(number.to_le_bytes()));
                    self.bytes.push(u8::from(*leaf));
                }
            }
        }
    }

    fn corner(&mut self, Corner { position, normal, texture: DVec2 { x, y } }: &Corner) {
        self.vector(*position);
        self.vector(*normal);
        self.float(*x);
        self.float(*y);
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Polygon(corners) => {
                self.number(0);
                self.number(corners.len() as u64);
                corners.iter().for_each(|corner| self.corner(corner));
            }
            Shape::Limb(limb) => {
                self.number(1);
                self.number(limb.points.len() as u64);
                for point in &limb.points {
                    self.vector(point.position);
                    self.float(point.radius);
                }
                self.number(u64::from(limb.sides));
                self.number(u64::from(limb.segments));
                self.map(&limb.object_from_limb);
            }
            Shape::Triangles(list) => {
                self.number(2);
                self.number(list.corners.len() as u64);
                list.corners.iter().for_each(|corner| self.corner(corner));
                self.number(list.triangles.len() as u64);
                list.triangles.iter().flatten().for_each(|corner| self.number(u64::from(*corner)));
            }
        }
    }

    fn material(&mut self, material: &Material) {
        let Material { name: _, reflected, through, leaf, cutout, picture, wrap } = material;
        for number in reflected.iter().chain(through) {
            self.float(f64::from(*number));
        }
        self.number(u64::from(*leaf));
        self.float(f64::from(cutout.unwrap_or(-1.0)));
        for wrap in wrap {
            self.number(match wrap {
                Wrap::Held => 0,
                Wrap::Repeated => 1,
                Wrap::Mirrored => 2,
            });
        }
        match picture {
            None => self.number(0),
            Some(pixels) => {
                self.number(1);
                pixels.size().into_iter().for_each(|side| self.number(side as u64));
                self.bytes.extend(pixels.rgba().iter().flatten());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::files::read_plant;
    use quadratura_base::task::Task;

    #[test]
    fn plants_have_the_same_hash_when_they_are_grown_alike_and_another_where_a_number_differs() {
        let grown = |seed| read_plant(Path::new("maple"), Some(seed), &Task::silent()).unwrap();
        let plant = grown(1);
        assert_eq!(plant_hash(&plant), plant_hash(&grown(1)));
        assert_ne!(plant_hash(&plant), plant_hash(&grown(2)));
        let mut moved = plant.clone();
        let last = moved.objects.last_mut().unwrap();
        last.uses[0].parent_from_child.translation.x += 1e-9;
        assert_ne!(plant_hash(&plant), plant_hash(&moved));
        let mut renamed = plant.clone();
        renamed.objects[0].name = "another".into();
        assert_eq!(plant_hash(&plant), plant_hash(&renamed));
    }
}
