//! The pixels that a triangle covers, without clipping: rasterisation in 2D homogeneous coordinates
//! (Olano & Greer, *Triangle Scan Conversion using 2D Homogeneous Coordinates*, 1997).
//!
//! A pixel centre (X, Y, 1) is a combination of the three corners (x, y, w). Where all three weights are
//! positive, the ray through the pixel hits the triangle in front of the camera, even when some corners lie
//! behind it. Each weight is a linear function over the image, the edge function.

use std::ops::Range;

use glam::DVec3;

/// The coverage of a triangle: three edge functions `e . (X, Y, 1)`, positive inside.
///
/// Adjacent triangles have the same function for their common edge, up to its sign and bit for bit, because
/// both compute the same cross product of its corners: no pixel of a common edge is lost or covered twice.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleFootprint {
    edges: [DVec3; 3],
    rows: Range<u32>,
    width: u32,
}

impl TriangleFootprint {
    /// Builds the coverage from corners in homogeneous clip coordinates (see
    /// [`crate::ProjectedModel::corners`]). Returns `None` for a triangle that is behind the camera, seen
    /// edge-on, or above or below the photo.
    pub fn new(corners: &[[f32; 3]; 3], width: u32, height: u32) -> Option<Self> {
        let corners = corners.map(|corner| homogeneous_pixels(corner, width, height));
        let [p, q, r] = corners;
        let edges = [q.cross(r), r.cross(p), p.cross(q)];
        let winding = p.dot(edges[0]);
        let rows = rows_of(&corners, height);
        if winding == 0.0 || rows.is_empty() {
            return None;
        }
        Some(Self { edges: edges.map(|e| if winding < 0.0 { -e } else { e }), rows, width })
    }

    /// Returns the rows that may hold covered pixels; there are none outside.
    pub fn rows(&self) -> Range<u32> {
        self.rows.clone()
    }

    /// Returns the columns that are covered in row `y`: a single run, because a triangle is convex.
    pub fn columns(&self, y: u32) -> Range<u32> {
        let centre = f64::from(y) + 0.5;
        let (mut left, mut right) = (0.0_f64, f64::from(self.width));
        for edge in &self.edges {
            let along = edge.y * centre + edge.z;
            if edge.x == 0.0 && !inside(along, edge) {
                return 0..0;
            }
            // The column where the function vanishes, with a reserve for rounding; the exact test follows.
            let crossing = -along / edge.x;
            if edge.x > 0.0 {
                left = left.max(crossing - 2.0);
            } else if edge.x < 0.0 {
                right = right.min(crossing + 2.0);
            }
        }
        self.shrink(left as u32..right as u32, centre)
    }

    /// Shrinks a run of columns that may begin too early and end too late to the covered part.
    fn shrink(&self, mut run: Range<u32>, centre: f64) -> Range<u32> {
        while !run.is_empty() && !self.covers(run.start, centre) {
            run.start += 1;
        }
        while !run.is_empty() && !self.covers(run.end - 1, centre) {
            run.end -= 1;
        }
        run
    }

    fn covers(&self, x: u32, centre: f64) -> bool {
        let x = f64::from(x) + 0.5;
        self.edges.iter().all(|edge| inside(edge.x * x + (edge.y * centre + edge.z), edge))
    }
}

/// Applies the top-left rule: a pixel centre on an edge belongs to the triangle right of it or below it.
fn inside(value: f64, edge: &DVec3) -> bool {
    value > 0.0 || (value == 0.0 && (edge.x > 0.0 || (edge.x == 0.0 && edge.y > 0.0)))
}

/// Converts clip coordinates to (X w, Y w, w), with (X, Y) the image position in pixels.
fn homogeneous_pixels([x, y, w]: [f32; 3], width: u32, height: u32) -> DVec3 {
    let (x, y, w) = (f64::from(x), f64::from(y), f64::from(w));
    DVec3::new((w + x) * (0.5 * f64::from(width)), (w - y) * (0.5 * f64::from(height)), w)
}

/// Returns the rows that may hold covered pixels: all rows when the triangle crosses the plane of the camera,
/// where its outline runs to infinity.
fn rows_of(corners: &[DVec3; 3], height: u32) -> Range<u32> {
    if corners.iter().all(|c| c.z <= 0.0) {
        return 0..0;
    }
    if corners.iter().any(|c| c.z <= 0.0) {
        return 0..height;
    }
    let rows = corners.map(|c| c.y / c.z);
    let top = rows.into_iter().fold(f64::INFINITY, f64::min);
    let bottom = rows.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // The conversion saturates, so rows far outside of the photo are cut off here.
    (top - 1.0).floor() as u32..((bottom + 1.0).ceil() as u32).min(height)
}
