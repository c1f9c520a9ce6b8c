//! The nearest and the farthest depths of plants in a parallel view, at each sub-pixel.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::bands::drawn;
use super::bounds::Ball;
use super::drawer::FragmentCanvas;
use super::facet::Facet;
use super::plant::Plant;
use super::raster::Fragment;
use super::view::{Projection, View};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;

/// How near a pixel's sub-pixels are ([`Projection::image_from_view`]): the nearest and the farthest surface of each. Where
/// nothing is, the nearest is below and the farthest above everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Depths {
    pub nearest: [f32; 16],
    pub farthest: [f32; 16],
}

impl Depths {
    pub const NOTHING: Self = Self { nearest: [f32::NEG_INFINITY; 16], farthest: [f32::INFINITY; 16] };
}

/// A parallel view of a ball: a square picture that shows all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Square {
    /// The number of pixels across and down.
    pub side: u32,
    /// Pixels for a unit.
    pub scale: f64,
    /// The map from the frame of the ball to the view's (x right, y down, z away from the viewer), whose origin is the ball's
    /// middle.
    pub view_from_frame: DAffine3,
}

impl Square {
    /// Makes the view of a ball from a direction of length 1, `side` pixels wide.
    pub fn around(ball: &Ball, towards_viewer: DVec3, side: u32) -> Self {
        let right = towards_viewer.any_orthonormal_vector();
        let down = right.cross(towards_viewer);
        let linear = DMat3::from_cols(right, down, -towards_viewer).transpose();
        // A pixel is left free on each side.
        let scale = f64::from(side - 2) / (2.0 * ball.radius).max(f64::MIN_POSITIVE);
        let view_from_frame = DAffine3 { matrix3: linear, translation: -(linear * ball.middle) };
        Self { side, scale, view_from_frame }
    }

    pub fn projection(&self) -> Projection {
        let centre_px = DVec2::splat(0.5 * f64::from(self.side));
        Projection::Parallel { width: self.side, height: self.side, scale: self.scale, centre_px }
    }

    /// Draws the depths of a plant, row by row.
    ///
    /// # Errors
    /// Those of [`super::draw`].
    pub fn depths(&self, plant: &Plant, frame_from_plant: &DAffine3, task: &Task) -> Result<Vec<Depths>> {
        let view = View {
            projection: self.projection(),
            view_from_plant: self.view_from_frame * *frame_from_plant,
            light_from_view: DMat3::IDENTITY,
        };
        let begun =
            |rect: PixelRect| DepthCanvas { rect, depths: vec![Depths::NOTHING; rect.area() as usize] };
        let bands = drawn(plant, &view, &begun, &|band: &DepthCanvas| band.depths.clone(), task)?;
        Ok(bands.into_iter().flat_map(|(depths, _)| depths).collect())
    }
}

struct DepthCanvas {
    rect: PixelRect,
    depths: Vec<Depths>,
}

impl FragmentCanvas for DepthCanvas {
    fn visible(&self, _fragment: &Fragment) -> u16 {
        0
    }

    #[inline]
    fn cover(&mut self, fragment: &Fragment) -> bool {
        let depths = &mut self.depths[self.rect.offset(fragment.x, fragment.y)];
        let mut left = fragment.mask;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let found = fragment.nearness[bit];
            depths.nearest[bit] = depths.nearest[bit].max(found);
            depths.farthest[bit] = depths.farthest[bit].min(found);
        }
        true
    }

    fn put(&mut self, _fragment: &Fragment, _visible: u16, _facet: &Facet) {}
}
