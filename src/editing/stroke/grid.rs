//! The part of a view's picture in which a stroke lies: the surface and the layer texture of most weight at each pixel.

use glam::DVec2;

use super::dabs::Dabs;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::task::Task;
use quadratura_projection::LayerTextureId;
use quadratura_projection::exposure::ViewExposure;
use quadratura_projection::twin::{ProbedPoint, ProbedTexel, ReferenceRenderer};
use quadratura_view::Shot;

/// The pixels of a view around a stroke.
pub struct ViewGrid {
    /// The surface at each pixel centre; `None` where there is none.
    points: Image<Option<ProbedPoint>>,
    /// What the photos show; `None` at pixels that were not looked at.
    texels: Image<Option<ProbedTexel>>,
}

/// Returns the centre of a pixel.
pub fn centre((x, y): (i32, i32)) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

impl ViewGrid {
    /// Finds the surface at the pixels that the dabs may cover, through see-through surfaces where nothing of them is there.
    ///
    /// # Errors
    /// Returns the errors of reading layer textures.
    pub fn new(shot: &Shot, dabs: &Dabs, renderer: &mut ReferenceRenderer, task: &Task) -> Result<Self> {
        let rect = dabs.rect(shot);
        let centres: Vec<DVec2> = rect.pixels().map(centre).collect();
        let points = Image::new(rect, renderer.seen_points(shot, &centres, task)?);
        Ok(Self { points, texels: Image::filled(rect, None) })
    }

    /// Computes what the photos show at the pixels that are `wanted`.
    ///
    /// # Errors
    /// Returns the errors of reading layer textures.
    pub fn look(
        &mut self,
        shot: &Shot,
        exposure: &ViewExposure,
        renderer: &mut ReferenceRenderer,
        wanted: impl Fn(&ProbedPoint) -> bool,
        task: &Task,
    ) -> Result<()> {
        let chosen = |point: &&ProbedPoint| wanted(point);
        let points: Vec<ProbedPoint> =
            self.points.pixels().iter().flatten().filter(chosen).copied().collect();
        let texels = renderer.probed_texels(shot, &points, exposure, task)?;
        for (point, texel) in points.iter().zip(texels) {
            let px = point.px.floor().as_ivec2();
            if let Some(place) = self.texels.get_mut(px.x, px.y) {
                *place = Some(texel);
            }
        }
        Ok(())
    }

    /// Returns the rectangle, in pixels of the view.
    pub fn rect(&self) -> PixelRect {
        self.points.rect()
    }

    /// Iterates over the surface points that were looked at, with what the photos show there.
    pub fn seen(&self) -> impl Iterator<Item = (&ProbedPoint, &ProbedTexel)> {
        let both = self.points.pixels().iter().zip(self.texels.pixels());
        both.filter_map(|(point, texel)| Some((point.as_ref()?, texel.as_ref()?)))
    }

    /// Iterates over all surface points.
    pub fn surface(&self) -> impl Iterator<Item = &ProbedPoint> {
        self.points.pixels().iter().flatten()
    }

    /// Returns the surface point at a pixel, with what the photos show where it was looked at.
    pub fn at(&self, x: i32, y: i32) -> Option<(&ProbedPoint, Option<&ProbedTexel>)> {
        let point = self.points.get(x, y)?.as_ref()?;
        Some((point, self.texels.get(x, y).and_then(Option::as_ref)))
    }

    /// Returns the layer texture of most weight at a position, on a surface for which `same` is true: that of the pixel
    /// there, or of the nearest one beside it where the outline of the surface crosses the pixel.
    pub fn texture_at(&self, px: DVec2, same: impl Fn(&ProbedPoint) -> bool) -> Option<LayerTextureId> {
        let (_, texel) = self.nearest(px, same)?;
        texel?.texture
    }

    /// Returns true when the view shows such a surface at a position, or beside it by no more than a pixel.
    pub fn shows(&self, px: DVec2, same: impl Fn(&ProbedPoint) -> bool) -> bool {
        self.nearest(px, same).is_some()
    }

    fn nearest(
        &self,
        px: DVec2,
        same: impl Fn(&ProbedPoint) -> bool,
    ) -> Option<(&ProbedPoint, Option<&ProbedTexel>)> {
        let own = px.floor().as_ivec2();
        let here = self.at(own.x, own.y).filter(|(point, _)| same(point));
        let around = || {
            let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let pixels = steps.filter_map(|(dx, dy)| self.at(own.x + dx, own.y + dy));
            let distance = |point: &ProbedPoint| point.px.distance_squared(px);
            pixels.filter(|(point, _)| same(point)).min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))
        };
        here.or_else(around)
    }
}
