//! The placement of a picture in a view: its centre and its scale.

use glam::{DVec2, Vec2};

use quadratura_base::geometry::PixelRect;

/// The largest scale, in points per pixel: single pixels are visible long before.
pub const LARGEST: f64 = 64.0;
/// The smallest scale, as a share of the one that fills the view.
const SMALLEST_SHARE: f64 = 0.25;
/// The margin around a picture that fills the view, in points.
const MARGIN: f32 = 12.0;

/// A rectangle on the screen, in points from the window's top left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenRect {
    /// The top left corner.
    pub min: Vec2,
    /// The bottom right corner.
    pub max: Vec2,
}

impl ScreenRect {
    /// Returns the position in the middle.
    pub fn center(&self) -> Vec2 {
        (self.min + self.max) / 2.0
    }

    /// Returns whether a position is in the rectangle.
    pub fn contains(&self, at: Vec2) -> bool {
        at.cmpge(self.min).all() && at.cmple(self.max).all()
    }

    /// Returns the size without the margin around pictures, at least one point.
    fn room(&self) -> DVec2 {
        (self.max - self.min - 2.0 * MARGIN).max(Vec2::ONE).as_dvec2()
    }
}

/// The placement of a picture in a view. Pixel coordinates may start anywhere, as those of an image layer do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The position in the picture that is at the centre of the view, in pixels of the picture.
    middle: DVec2,
    /// The scale, in points per pixel.
    scale: f64,
    /// The scale at which the picture fills the view.
    fitting: f64,
    /// Whether the picture fills the view, and follows when the view is resized.
    fitted: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Self { middle: DVec2::ZERO, scale: 1.0, fitting: 1.0, fitted: true }
    }
}

impl Placement {
    /// Returns whether the picture fills the view.
    pub fn is_fitted(&self) -> bool {
        self.fitted
    }

    /// Makes the picture fill the view from now on.
    pub fn fit(&mut self) {
        self.fitted = true;
    }

    /// Returns the position in the picture that is at the centre of the view, in pixels of the picture.
    pub fn middle(&self) -> DVec2 {
        self.middle
    }

    /// Returns the scale, in points per pixel.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Adapts the placement to the current size of the view; `bounds` are the picture's.
    pub fn settle(&mut self, bounds: PixelRect, rect: ScreenRect) {
        let (low, size) = (
            DVec2::new(f64::from(bounds.x), f64::from(bounds.y)),
            DVec2::new(f64::from(bounds.w.max(1)), f64::from(bounds.h.max(1))),
        );
        self.fitting = (rect.room() / size).min_element();
        if self.fitted {
            (self.middle, self.scale) = (low + size / 2.0, self.fitting);
        } else {
            self.scale = self.scale.clamp(self.least(), LARGEST);
            self.middle = self.middle.clamp(low, low + size);
        }
    }

    fn least(&self) -> f64 {
        (self.fitting * SMALLEST_SHARE).min(LARGEST)
    }

    /// Pans the picture, in points.
    pub fn pan(&mut self, by: Vec2) {
        if by != Vec2::ZERO {
            self.fitted = false;
            self.middle -= by.as_dvec2() / self.scale;
        }
    }

    /// Zooms by `factor`; the position under `at` stays fixed.
    pub fn zoom(&mut self, rect: ScreenRect, at: Vec2, factor: f64) {
        let scale = (self.scale * factor).clamp(self.least(), LARGEST);
        let from_middle = (at - rect.center()).as_dvec2();
        self.middle += from_middle / self.scale - from_middle / scale;
        (self.scale, self.fitted) = (scale, false);
    }

    /// Shows one pixel of the picture as one of the screen, `density` of which make a point; the position under `at`
    /// stays fixed.
    pub fn show_pixels(&mut self, rect: ScreenRect, at: Vec2, density: f32) {
        self.zoom(rect, at, 1.0 / f64::from(density) / self.scale);
    }

    /// Frames a rectangle of the picture, in its pixels.
    pub fn show(&mut self, rect: ScreenRect, low: DVec2, high: DVec2) {
        let size = (high - low).max(DVec2::ONE);
        let scale = (rect.room() / size).min_element();
        (self.middle, self.scale, self.fitted) = ((low + high) / 2.0, scale.min(LARGEST), false);
    }

    /// Centres the view on a position in the picture.
    pub fn center_on(&mut self, position: DVec2) {
        (self.middle, self.fitted) = (position, false);
    }

    /// Returns the screen pixels per pixel of the picture, for a screen with `density` pixels a point.
    pub fn magnification(&self, density: f32) -> f64 {
        self.scale * f64::from(density)
    }
}

/// A picture in a flat view: its placement, and where the view is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlacedView {
    /// The placement of the picture in the view.
    pub placement: Placement,
    /// The rectangle of the view on the screen, as it was drawn last.
    pub rect: Option<ScreenRect>,
}

impl PlacedView {
    /// Fits the whole picture into the view.
    pub fn fit(&mut self) {
        self.placement.fit();
    }

    /// Shows one pixel of the picture as one of the screen; a point has `density` screen pixels.
    pub fn show_pixels(&mut self, density: f32) {
        if let Some(rect) = self.rect {
            self.placement.show_pixels(rect, rect.center(), density);
        }
    }

    /// Zooms by a factor.
    pub fn zoom(&mut self, factor: f64) {
        if let Some(rect) = self.rect {
            self.placement.zoom(rect, rect.center(), factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: PixelRect = PixelRect { x: -100, y: 50, w: 400, h: 200 };
    const VIEW: ScreenRect = ScreenRect { min: Vec2::new(10.0, 20.0), max: Vec2::new(834.0, 644.0) };

    fn settled() -> Placement {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, VIEW);
        placement
    }

    #[test]
    fn a_fitted_picture_has_its_middle_in_the_views_and_a_margin_around_it() {
        let placement = settled();
        assert_eq!(placement.middle(), DVec2::new(100.0, 150.0));
        assert_eq!(placement.scale(), (824.0 - 24.0) / 400.0);
    }

    #[test]
    fn a_picture_that_was_moved_does_not_follow_the_size_of_the_view() {
        let mut placement = settled();
        let scale = placement.scale();
        placement.pan(Vec2::new(4.0, 0.0));
        placement.settle(BOUNDS, ScreenRect { max: VIEW.max * 0.75, ..VIEW });
        assert_eq!((placement.scale(), placement.is_fitted()), (scale, false));
        placement.fit();
        placement.settle(BOUNDS, ScreenRect { max: VIEW.max * 0.75, ..VIEW });
        assert!(placement.scale() < scale);
    }

    #[test]
    fn a_picture_cannot_be_moved_out_of_its_view_nor_lost_by_its_scale() {
        let mut placement = settled();
        placement.pan(Vec2::splat(1e7));
        placement.settle(BOUNDS, VIEW);
        assert_eq!(placement.middle(), DVec2::new(-100.0, 50.0), "its corner stays in the middle");
        placement.zoom(VIEW, VIEW.center(), 1e-9);
        assert_eq!(placement.scale(), 0.25 * settled().scale());
        placement.zoom(VIEW, VIEW.center(), 1e9);
        assert_eq!(placement.scale(), LARGEST);
    }

    #[test]
    fn zooming_keeps_the_pixel_under_the_pointer() {
        let mut placement = settled();
        let at = Vec2::new(333.0, 222.0);
        let under =
            |placement: &Placement| placement.middle() + (at - VIEW.center()).as_dvec2() / placement.scale();
        let before = under(&placement);
        placement.zoom(VIEW, at, 3.0);
        assert!(under(&placement).distance(before) < 1e-9);
        placement.show_pixels(VIEW, at, 2.0);
        assert!(under(&placement).distance(before) < 1e-9 && placement.magnification(2.0) == 1.0);
    }

    #[test]
    fn a_view_that_was_never_drawn_is_not_zoomed() {
        let mut view = PlacedView::default();
        view.zoom(2.0);
        view.show_pixels(1.0);
        assert_eq!(view, PlacedView::default());
        view.rect = Some(VIEW);
        view.zoom(2.0);
        assert!(view.placement.scale() == 2.0 && !view.placement.is_fitted());
    }

    #[test]
    fn the_border_belongs_to_a_rectangle() {
        assert!(VIEW.contains(VIEW.min) && VIEW.contains(VIEW.max) && VIEW.contains(VIEW.center()));
        assert!(!VIEW.contains(VIEW.max + Vec2::X));
    }
}
