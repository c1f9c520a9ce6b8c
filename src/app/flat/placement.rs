//! The placement of a picture in a view: its centre and its scale.

use eframe::egui::{Pos2, Rect, Vec2, pos2, vec2};
use glam::DVec2;

use crate::geometry::PixelRect;
use crate::geometry::grid::Grid;

/// The largest scale, in points per pixel: single pixels are visible long before.
const LARGEST: f64 = 64.0;
/// The smallest scale, as a share of the one that fills the view.
const SMALLEST_SHARE: f64 = 0.25;
/// The margin around a picture that fills the view, in points.
const MARGIN: f32 = 12.0;

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

    /// Adapts the placement to the current size of the view; `bounds` are the picture's.
    pub fn settle(&mut self, bounds: PixelRect, rect: Rect) {
        let (low, size) = (
            DVec2::new(f64::from(bounds.x), f64::from(bounds.y)),
            DVec2::new(f64::from(bounds.w.max(1)), f64::from(bounds.h.max(1))),
        );
        let room = rect.shrink(MARGIN).size().max(Vec2::splat(1.0));
        self.fitting = (f64::from(room.x) / size.x).min(f64::from(room.y) / size.y);
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
            self.middle -= DVec2::new(f64::from(by.x), f64::from(by.y)) / self.scale;
        }
    }

    /// Zooms by `factor`; the position under `at` stays fixed.
    pub fn zoom(&mut self, rect: Rect, at: Pos2, factor: f64) {
        let scale = (self.scale * factor).clamp(self.least(), LARGEST);
        let from_middle = at - rect.center();
        let from_middle = DVec2::new(f64::from(from_middle.x), f64::from(from_middle.y));
        self.middle += from_middle / self.scale - from_middle / scale;
        (self.scale, self.fitted) = (scale, false);
    }

    /// Shows one pixel of the picture as one of the screen, `density` of which make a point; the position under `at`
    /// stays fixed.
    pub fn show_pixels(&mut self, rect: Rect, at: Pos2, density: f32) {
        self.zoom(rect, at, 1.0 / f64::from(density) / self.scale);
    }

    /// Frames a rectangle of the picture, in its pixels.
    pub fn show(&mut self, rect: Rect, low: DVec2, high: DVec2) {
        let room = rect.shrink(MARGIN).size().max(Vec2::splat(1.0));
        let size = (high - low).max(DVec2::ONE);
        let scale = (f64::from(room.x) / size.x).min(f64::from(room.y) / size.y);
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

    /// Returns the placement in `rect`, on a screen that has `density` pixels a point.
    pub fn seen(&self, rect: Rect, density: f32) -> PlacedPicture {
        let origin =
            rect.center() - vec2((self.middle.x * self.scale) as f32, (self.middle.y * self.scale) as f32);
        // The corner is rounded to whole screen pixels, so that pictures at 1:1 are sharp.
        let whole = |points: f32| (points * density).round() / density;
        PlacedPicture { rect, origin: pos2(whole(origin.x), whole(origin.y)), scale: self.scale, density }
    }
}

/// A picture placed in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedPicture {
    /// The rectangle of the view, in points.
    pub rect: Rect,
    origin: Pos2,
    /// The scale, in points per pixel of the picture.
    pub scale: f64,
    /// Screen pixels per point.
    pub density: f32,
}

impl PlacedPicture {
    /// Converts a position in the picture to one on the screen.
    pub fn at(&self, position: DVec2) -> Pos2 {
        self.origin + vec2((position.x * self.scale) as f32, (position.y * self.scale) as f32)
    }

    /// Converts a rectangle of the picture to one on the screen.
    pub fn rect_of(&self, rect: PixelRect) -> Rect {
        let corner = |x: i32, y: i32| self.at(DVec2::new(f64::from(x), f64::from(y)));
        Rect::from_min_max(corner(rect.x, rect.y), corner(rect.right(), rect.bottom()))
    }

    /// Converts a position on the screen to one in the picture.
    pub fn position(&self, at: Pos2) -> DVec2 {
        let from = at - self.origin;
        DVec2::new(f64::from(from.x), f64::from(from.y)) / self.scale
    }

    /// Returns the screen pixels of the view, as a grid over the picture.
    pub fn grid(&self) -> Grid {
        let first = self.first_cell();
        let origin = self.origin.to_vec2() * self.density - first;
        let size = (self.rect.max.to_vec2() * self.density).ceil() - first;
        let cells = |points: f32| points.max(0.0) as u32;
        Grid {
            origin: DVec2::new(f64::from(origin.x), f64::from(origin.y)),
            scale: self.magnification(),
            size: [cells(size.x), cells(size.y)],
        }
    }

    /// Returns the rectangle of cells of [`Self::grid`] on the screen.
    pub fn on_screen(&self, cells: PixelRect) -> Rect {
        let corner = |x: i32, y: i32| (self.first_cell() + vec2(x as f32, y as f32)) / self.density;
        let (min, max) = (corner(cells.x, cells.y), corner(cells.right(), cells.bottom()));
        Rect::from_min_max(min.to_pos2(), max.to_pos2())
    }

    /// Returns the screen pixel in the view's top left corner.
    fn first_cell(&self) -> Vec2 {
        (self.rect.min.to_vec2() * self.density).floor()
    }

    /// Returns the pixel of the picture under a position on the screen.
    pub fn pixel(&self, at: Pos2) -> (i32, i32) {
        let from = at - self.origin;
        let whole = |points: f32| (f64::from(points) / self.scale).floor() as i32;
        (whole(from.x), whole(from.y))
    }

    /// Returns the part of the picture that is visible in the view.
    pub fn window(&self, bounds: PixelRect) -> PixelRect {
        let ((x0, y0), (x1, y1)) = (self.pixel(self.rect.min), self.pixel(self.rect.max));
        PixelRect::from_edges(x0, y0, x1 + 1, y1 + 1).intersection(&bounds)
    }

    /// Returns the screen pixels per pixel of the picture.
    pub fn magnification(&self) -> f64 {
        self.scale * f64::from(self.density)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: Rect = Rect { min: pos2(100.0, 50.0), max: pos2(900.0, 650.0) };
    const BOUNDS: PixelRect = PixelRect { x: -20, y: 40, w: 3000, h: 2000 };

    #[test]
    fn a_fitted_picture_fills_the_view_and_follows_its_size() {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, VIEW);
        let shown = placement.seen(VIEW, 1.0).rect_of(BOUNDS);
        assert!(VIEW.contains_rect(shown) && (shown.width() - 776.0).abs() < 1.5, "{shown:?}");
        let half = Rect::from_min_size(VIEW.min, VIEW.size() / 2.0);
        placement.settle(BOUNDS, half);
        assert!(half.contains_rect(placement.seen(half, 1.0).rect_of(BOUNDS)));
    }

    #[test]
    fn what_is_under_the_pointer_stays_when_zooming_and_moves_with_a_drag() {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, VIEW);
        let at = pos2(333.0, 222.0);
        let before = placement.seen(VIEW, 2.0).pixel(at);
        placement.show_pixels(VIEW, at, 2.0);
        placement.settle(BOUNDS, VIEW);
        let seen = placement.seen(VIEW, 2.0);
        assert!((seen.magnification() - 1.0).abs() < 1e-12 && !placement.is_fitted());
        let after = seen.pixel(at);
        assert!((before.0 - after.0).abs() <= 4 && (before.1 - after.1).abs() <= 4, "{before:?} {after:?}");
        placement.pan(vec2(10.0, -5.0));
        assert_eq!(placement.seen(VIEW, 2.0).pixel(at + vec2(10.0, -5.0)), after);
        placement.zoom(VIEW, at, 1e9);
        assert_eq!(placement.seen(VIEW, 1.0).scale, LARGEST);
    }

    #[test]
    fn cells_of_the_screen_lie_over_the_pixels_that_they_show() {
        for (density, zoom) in [(1.0, 0.3), (1.5, 4.0)] {
            let mut placement = Placement::default();
            placement.settle(BOUNDS, VIEW);
            placement.show_pixels(VIEW, VIEW.center(), density);
            placement.zoom(VIEW, pos2(222.0, 333.0), zoom);
            let seen = placement.seen(VIEW, density);
            let grid = seen.grid();
            assert!(seen.on_screen(grid.whole()).contains_rect(VIEW));
            let (x, y) = seen.pixel(VIEW.center());
            let block = PixelRect { x: x - 10, y: y - 20, w: 40, h: 30 };
            let cells = grid.cells(&crate::geometry::Spans::of_pixels(block, |_, _| true)).bounds();
            let (shown, exact) = (seen.on_screen(cells), seen.rect_of(block).intersect(VIEW));
            // The tolerance is a screen pixel, or a pixel of the picture where those are larger.
            let near = (1.0 / density).max(1.01 * zoom as f32 / density);
            let distance = (shown.min - exact.min).length().max((shown.max - exact.max).length());
            assert!(distance <= 1.5 * near, "{shown:?} {exact:?}");
            let position = seen.position(seen.at(DVec2::new(1512.5, 1007.25)));
            assert!(position.distance(DVec2::new(1512.5, 1007.25)) < 1e-3, "{position}");
        }
    }

    #[test]
    fn the_window_is_what_is_seen_of_the_picture() {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, VIEW);
        assert_eq!(placement.seen(VIEW, 1.0).window(BOUNDS), BOUNDS);
        placement.show(VIEW, DVec2::new(100.0, 100.0), DVec2::new(140.0, 130.0));
        let window = placement.seen(VIEW, 1.0).window(BOUNDS);
        assert!(window.w < 45 && window.x >= 95 && window.h < 40, "{window:?}");
    }
}
