//! Primitives as polygons and limbs.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use super::super::tokens::LARGEST_NUMBER;
use super::words::Words;
use crate::{Corner, CurvePoint, Limb, Shape, TriangleList};
use quadratura_base::error::Result;

/// The sides of cylinders and cones, and the corners of discs, which close them.
const SIDES: u32 = 8;
/// The polygons around a sphere and from pole to pole.
const SPHERE: [u32; 2] = [12, 6];
/// The most corners of a polygon.
const MOST_POINTS: usize = 1_000;

fn corner(position: DVec3, normal: DVec3, texture: DVec2) -> Corner {
    Corner { position, normal, texture }
}

fn polygon(points: impl IntoIterator<Item = DVec3>) -> Shape {
    Shape::Polygon(points.into_iter().map(|point| corner(point, DVec3::ZERO, DVec2::ZERO)).collect())
}

impl Words<'_> {
    /// Reads the numbers of a primitive other than a sphere; nothing for one without area.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub fn shapes(&mut self, keyword: &str) -> Result<Vec<Shape>> {
        match keyword {
            "triangle" => self.triangle(),
            "triangleuv" => self.triangle_uv(),
            "cone" | "cylinder" => self.cone(keyword),
            "disc" => self.disc(),
            "box" => self.cuboid(),
            _ => self.polygon(keyword),
        }
    }

    fn polygon(&mut self, keyword: &str) -> Result<Vec<Shape>> {
        let numbers = self.all_numbers(&format!("`{keyword}`"), 3 * MOST_POINTS)?;
        if numbers.len() < 9 || !numbers.len().is_multiple_of(3) {
            let found =
                format!("{} numbers of `{keyword}`, expected 3 for each of 3 or more corners", numbers.len());
            return Err(self.wrong(found));
        }
        Ok(vec![polygon(numbers.chunks_exact(3).map(DVec3::from_slice))])
    }

    /// Three points, or points and normals by turns.
    fn triangle(&mut self) -> Result<Vec<Shape>> {
        let numbers = self.all_numbers("`triangle`", 18)?;
        // Where nothing else is said, u and v of a picture grow from the first corner to the others.
        let textures = [DVec2::new(0.0, 1.0), DVec2::ONE, DVec2::ZERO];
        let vector = |index: usize| DVec3::from_slice(&numbers[3 * index..]);
        let corner = |i: usize| match numbers.len() {
            9 => corner(vector(i), DVec3::ZERO, textures[i]),
            _ => corner(vector(2 * i), vector(2 * i + 1).normalize_or_zero(), textures[i]),
        };
        if !matches!(numbers.len(), 9 | 18) {
            let found = format!("{} numbers of `triangle`, expected 9, or 18 with normals", numbers.len());
            return Err(self.wrong(found));
        }
        Ok(vec![Shape::Polygon((0..3).map(corner).collect())])
    }

    /// Three times a point, a normal, and u and v, which grows upwards; the normals may be left out.
    fn triangle_uv(&mut self) -> Result<Vec<Shape>> {
        let numbers = self.all_numbers("`triangleuv`", 24)?;
        if !matches!(numbers.len(), 15 | 24) {
            let found =
                format!("{} numbers of `triangleuv`, expected 24, or 15 without normals", numbers.len());
            return Err(self.wrong(found));
        }
        let corner = |of: &[f64]| {
            let normal =
                if of.len() == 8 { DVec3::from_slice(&of[3..]).normalize_or_zero() } else { DVec3::ZERO };
            let [u, v] = [of[of.len() - 2], of[of.len() - 1]];
            corner(DVec3::from_slice(of), normal, DVec2::new(u, 1.0 - v))
        };
        Ok(vec![Shape::Polygon(numbers.chunks_exact(numbers.len() / 3).map(corner).collect())])
    }

    fn radius(&mut self, what: &str) -> Result<f64> {
        let radius = self.number(what)?;
        if radius < 0.0 {
            return Err(self.wrong(format!("the radius {radius}, expected at least 0")));
        }
        Ok(radius)
    }

    /// Reads a cone or a cylinder, which is a limb of one piece.
    fn cone(&mut self, keyword: &str) -> Result<Vec<Shape>> {
        let low = self.radius(&format!("the radius of `{keyword}`"))?;
        let foot = self.point(&format!("the base of `{keyword}`"))?;
        let high = if keyword == "cone" { self.radius("the second radius of `cone`")? } else { low };
        let tip = self.point(&format!("the top of `{keyword}`"))?;
        if foot == tip || low + high == 0.0 {
            return Ok(Vec::new());
        }
        let point = |i: u32| {
            let share = f64::from(i) / 3.0;
            CurvePoint { position: foot.lerp(tip, share), radius: low + share * (high - low) }
        };
        let points = (0..4).map(point).collect();
        let limb = Limb { points, sides: SIDES, segments: 1, object_from_limb: DAffine3::IDENTITY };
        Ok(vec![Shape::Limb(limb)])
    }

    fn disc(&mut self) -> Result<Vec<Shape>> {
        let radius = self.radius("the radius of `disc`")?;
        let middle = self.point("the middle of `disc`")?;
        let Some(normal) = self.point("the normal of `disc`")?.try_normalize().filter(|_| radius > 0.0)
        else {
            return Ok(Vec::new());
        };
        // The corners are those of a cylinder's end.
        let (x, y) = normal.any_orthonormal_pair();
        let angles = (0..SIDES).map(|side| TAU * f64::from(side) / f64::from(SIDES));
        Ok(vec![polygon(angles.map(|angle| middle + radius * (angle.cos() * x + angle.sin() * y)))])
    }

    /// Reads a box, whose faces look outwards.
    fn cuboid(&mut self) -> Result<Vec<Shape>> {
        let [a, b] = [self.point("a corner of `box`")?, self.point("the other corner of `box`")?];
        let (low, high) = (a.min(b), a.max(b));
        let at = |bits: usize| {
            let side = |axis: usize| if bits & (1 << axis) == 0 { low[axis] } else { high[axis] };
            DVec3::new(side(0), side(1), side(2))
        };
        const FACES: [[usize; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Ok(FACES.map(|face| polygon(face.map(at))).into())
    }

    /// Reads a sphere. Returns the map from the sphere of [`unit_sphere`]; none where it has no radius.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub fn sphere(&mut self) -> Result<Option<DAffine3>> {
        let radius = self.radius("the radius of `sphere`")?;
        let middle = self.point("the middle of `sphere`")?;
        let map =
            DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, middle);
        Ok((radius > 0.0).then_some(map))
    }
}

/// Makes the sphere of radius 1 around the origin, with its normals.
pub fn unit_sphere() -> Shape {
    let [around, along] = SPHERE;
    let mut corners = Vec::new();
    let mut triangles = Vec::new();
    for ring in 0..=along {
        let v = f64::from(ring) / f64::from(along);
        let (sin, cos) = (0.5 * TAU * v).sin_cos();
        let across = if ring == along { 0.0 } else { sin };
        for side in 0..=around {
            let u = f64::from(side) / f64::from(around);
            let (y, x) = (TAU * f64::from(side % around) / f64::from(around)).sin_cos();
            let point = DVec3::new(across * x, across * y, cos);
            corners.push(corner(point, point, DVec2::new(u, v)));
            let a = ring * (around + 1) + side;
            let [b, c, d] = [a + 1, a + around + 1, a + around + 2];
            if ring < along && side < around {
                // There is one triangle at a pole.
                triangles.extend((ring > 0).then_some([a, c, b]));
                triangles.extend((ring + 1 < along).then_some([b, c, d]));
            }
        }
    }
    Shape::Triangles(TriangleList { corners, triangles })
}

/// Moves a shape; `None` where a point comes to lie beyond [`LARGEST_NUMBER`].
pub fn moved(shape: Shape, map: &DAffine3) -> Option<Shape> {
    let is_near = |point: DVec3| map.transform_point3(point).abs().max_element() <= LARGEST_NUMBER;
    let normals = map.matrix3.inverse().transpose();
    let move_corner = |corner: &mut Corner| {
        let is_inside = is_near(corner.position);
        corner.position = map.transform_point3(corner.position);
        corner.normal = (normals * corner.normal).normalize_or_zero();
        is_inside
    };
    let mut shape = shape;
    let is_inside = match &mut shape {
        Shape::Polygon(corners) => corners.iter_mut().all(move_corner),
        Shape::Triangles(list) => list.corners.iter_mut().all(move_corner),
        Shape::Limb(limb) => {
            limb.object_from_limb = *map * limb.object_from_limb;
            let place = |point: &CurvePoint| limb.object_from_limb.transform_point3(point.position);
            limb.points.iter().all(|point| place(point).abs().max_element() <= LARGEST_NUMBER)
        }
    };
    is_inside.then_some(shape)
}
