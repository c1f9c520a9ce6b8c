//! A picture as it is placed in a view: positions of the screen and of the picture.

use eframe::egui::{Pos2, Rect, Vec2, pos2, vec2};
use glam::DVec2;

use crate::state::flat::placement::{Placement, ScreenRect};
use quadratura_base::geometry::PixelRect;
use quadratura_base::geometry::grid::Grid;

/// Converts a rectangle of the toolkit.
pub fn screen_rect(rect: Rect) -> ScreenRect {
    ScreenRect { min: on_screen(rect.min), max: on_screen(rect.max) }
}

/// Converts a position of the toolkit.
pub fn on_screen(at: Pos2) -> glam::Vec2 {
    glam::Vec2::new(at.x, at.y)
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
    /// Returns a picture placed in `rect`, on a screen that has `density` pixels a point.
    pub fn new(placement: &Placement, rect: Rect, density: f32) -> Self {
        let (middle, scale) = (placement.middle(), placement.scale());
        let origin = rect.center() - vec2((middle.x * scale) as f32, (middle.y * scale) as f32);
        // The corner is rounded to whole screen pixels, so that pictures at 1:1 are sharp.
        let whole = |points: f32| (points * density).round() / density;
        Self { rect, origin: pos2(whole(origin.x), whole(origin.y)), scale, density }
    }

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
    use crate::state::flat::placement::LARGEST;

    const VIEW: Rect = Rect { min: pos2(100.0, 50.0), max: pos2(900.0, 650.0) };
    const BOUNDS: PixelRect = PixelRect { x: -20, y: 40, w: 3000, h: 2000 };

    #[test]
    fn a_fitted_picture_fills_the_view_and_follows_its_size() {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, screen_rect(VIEW));
        let shown = PlacedPicture::new(&placement, VIEW, 1.0).rect_of(BOUNDS);
        assert!(VIEW.contains_rect(shown) && (shown.width() - 776.0).abs() < 1.5, "{shown:?}");
        let half = Rect::from_min_size(VIEW.min, VIEW.size() / 2.0);
        placement.settle(BOUNDS, screen_rect(half));
        assert!(half.contains_rect(PlacedPicture::new(&placement, half, 1.0).rect_of(BOUNDS)));
    }

    #[test]
    fn what_is_under_the_pointer_stays_when_zooming_and_moves_with_a_drag() {
        let mut placement = Placement::default();
        placement.settle(BOUNDS, screen_rect(VIEW));
        let at = pos2(333.0, 222.0);
        let before = PlacedPicture::new(&placement, VIEW, 2.0).pixel(at);
        placement.show_pixels(screen_rect(VIEW), on_screen(at), 2.0);
        placement.settle(BOUNDS, screen_rect(VIEW));
        let seen = PlacedPicture::new(&placement, VIEW, 2.0);
        assert!((seen.magnification() - 1.0).abs() < 1e-12 && !placement.is_fitted());
        let after = seen.pixel(at);
        assert!((before.0 - after.0).abs() <= 4 && (before.1 - after.1).abs() <= 4, "{before:?} {after:?}");
        placement.pan(glam::Vec2::new(10.0, -5.0));
        assert_eq!(PlacedPicture::new(&placement, VIEW, 2.0).pixel(at + vec2(10.0, -5.0)), after);
        placement.zoom(screen_rect(VIEW), on_screen(at), 1e9);
        assert_eq!(PlacedPicture::new(&placement, VIEW, 1.0).scale, LARGEST);
    }

    #[test]
    fn cells_of_the_screen_lie_over_the_pixels_that_they_show() {
        for (density, zoom) in [(1.0, 0.3), (1.5, 4.0)] {
            let mut placement = Placement::default();
            placement.settle(BOUNDS, screen_rect(VIEW));
            placement.show_pixels(screen_rect(VIEW), on_screen(VIEW.center()), density);
            placement.zoom(screen_rect(VIEW), glam::Vec2::new(222.0, 333.0), zoom);
            let seen = PlacedPicture::new(&placement, VIEW, density);
            let grid = seen.grid();
            assert!(seen.on_screen(grid.whole()).contains_rect(VIEW));
            let (x, y) = seen.pixel(VIEW.center());
            let block = PixelRect { x: x - 10, y: y - 20, w: 40, h: 30 };
            let cells = grid.cells(&quadratura_base::geometry::Spans::of_pixels(block, |_, _| true)).bounds();
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
        placement.settle(BOUNDS, screen_rect(VIEW));
        assert_eq!(PlacedPicture::new(&placement, VIEW, 1.0).window(BOUNDS), BOUNDS);
        placement.show(screen_rect(VIEW), DVec2::new(100.0, 100.0), DVec2::new(140.0, 130.0));
        let window = PlacedPicture::new(&placement, VIEW, 1.0).window(BOUNDS);
        assert!(window.w < 45 && window.x >= 95 && window.h < 40, "{window:?}");
    }
}
