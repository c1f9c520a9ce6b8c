//! What a sub-object is made of: polygons, limbs and triangle lists, and the materials they have.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::pixels::{Pixels, Wrap};
use super::stretch::largest_stretch;

/// How a surface answers light. Colours are linear light, 0..=1.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name, for people.
    pub name: String,
    /// The share of light that is reflected, in R, G, B. With a picture it is a factor of the picture's light.
    pub reflected: [f32; 3],
    /// The share of light that a leaf lets through, in R, G, B.
    pub through: [f32; 3],
    /// True for leaves, which are lit from both sides.
    pub leaf: bool,
    /// The alpha of the picture, 0..=1, below which there is nothing; `None` where the picture is not cut out.
    pub cutout: Option<f32>,
    /// The picture that colours the surface, if any.
    pub picture: Option<Arc<Pixels>>,
    /// How the picture goes on beyond its sides, across and down.
    pub wrap: [Wrap; 2],
}

/// Grey that reflects half of the light.
impl Default for Material {
    fn default() -> Self {
        let (reflected, through, wrap) = ([0.5; 3], [0.0; 3], [Wrap::Held; 2]);
        Self { name: "grey".into(), reflected, through, leaf: false, cutout: None, picture: None, wrap }
    }
}

/// A corner of a polygon or of a triangle, in the sub-object's frame and unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The position.
    pub position: DVec3,
    /// The normal, of any length; zero for that of the plane.
    pub normal: DVec3,
    /// The place in the picture: (0, 0) is its top left corner, (1, 1) the bottom right one.
    pub texture: DVec2,
}

/// A point of a limb's centre line, with the radius there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// The position.
    pub position: DVec3,
    /// The radius, at least 0.
    pub radius: f64,
}

/// A tube whose centre line and radius are Bezier curves (Max 1996).
#[derive(Debug, Clone, PartialEq)]
pub struct Limb {
    /// `3 k + 1` control points of `k` cubic pieces, in the limb's own frame.
    pub points: Vec<CurvePoint>,
    /// The number of polygons around, at least 3.
    pub sides: u32,
    /// The number of polygons along all pieces, at least 1.
    pub segments: u32,
    /// The affine map from the limb's own frame to the sub-object's.
    pub object_from_limb: DAffine3,
}

/// Triangles with shared corners.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleList {
    /// The corners.
    pub corners: Vec<Corner>,
    /// Three indices into `corners` a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// The geometry of a primitive.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A flat polygon of at least three corners, convex or not.
    Polygon(Vec<Corner>),
    /// A limb, which is kept as a curve and made polygons when it is drawn.
    Limb(Limb),
    /// Triangles.
    Triangles(TriangleList),
}

/// A part of a sub-object.
#[derive(Debug, Clone, PartialEq)]
pub struct Primitive {
    /// The geometry.
    pub shape: Shape,
    /// The material of all of it.
    pub material: Arc<Material>,
}

impl Shape {
    /// Returns the number of polygons: a limb has one for each side of each segment.
    pub fn polygons(&self) -> u64 {
        match self {
            Self::Polygon(_) => 1,
            Self::Limb(limb) => u64::from(limb.sides) * u64::from(limb.segments),
            Self::Triangles(list) => list.triangles.len() as u64,
        }
    }

    /// Returns the number of triangles: a polygon of `n` corners has `n - 2`.
    pub fn triangles(&self) -> u64 {
        match self {
            Self::Polygon(corners) => (corners.len() as u64).saturating_sub(2),
            Self::Limb(_) => 2 * self.polygons(),
            Self::Triangles(_) => self.polygons(),
        }
    }

    /// Returns the number of corners of all polygons.
    pub fn corners(&self) -> u64 {
        match self {
            Self::Polygon(corners) => corners.len() as u64,
            Self::Limb(_) => 4 * self.polygons(),
            Self::Triangles(list) => list.corners.len() as u64 + 3 * self.polygons(),
        }
    }

    /// Calls `visit` with balls that together hold the shape: corners have radius 0.
    pub(super) fn each_ball(&self, mut visit: impl FnMut(DVec3, f64)) {
        match self {
            Self::Polygon(corners) => corners.iter().for_each(|corner| visit(corner.position, 0.0)),
            Self::Triangles(list) => list.corners.iter().for_each(|corner| visit(corner.position, 0.0)),
            Self::Limb(limb) => {
                let stretch = largest_stretch(&limb.object_from_limb.matrix3);
                let at = |point: &CurvePoint| limb.object_from_limb.transform_point3(point.position);
                limb.points.iter().for_each(|point| visit(at(point), stretch * point.radius));
            }
        }
    }
}
