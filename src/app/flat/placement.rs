//! How a picture lies in a view: where its middle is, and how large its pixels are.

use eframe::egui::{Pos2, Rect, Vec2, pos2, vec2};
use glam::DVec2;

use crate::geometry::PixelRect;
use crate::geometry::grid::Grid;

/// Pixels are shown at most so large, in points: single ones are seen long before.
const LARGEST: f64 = 64.0;
/// A picture is shown at least at this share of the size that fills the view.
const SMALLEST_SHARE: f64 = 0.25;
/// Around a picture that fills the view, in points.
const MARGIN: f32 = 12.0;

/// How a picture lies in a view. Its pixels may be counted from anywhere, as those of an image layer are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The place of the picture in the middle of the view, in its pixels.
    middle: DVec2,
    /// Points per pixel.
    scale: f64,
    /// That of a picture that fills the view.
    fitting: f64,
    /// It fills the view, whatever size that has.
    fitted: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Self { middle: DVec2::ZERO, scale: 1.0, fitting: 1.0, fitted: true }
    }
}

impl Placement {
    /// Whether it fills the view.
    pub fn is_fitted(&self) -> bool {
        self.fitted
    }

    /// Fills the view from now on.
    pub fn fit(&mut self) {
        self.fitted = true;
    }

    /// Adapts to the size that the view has now; `bounds` are the picture's.
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

    /// Moves the picture by so many points.
    pub fn pan(&mut self, by: Vec2) {
        if by != Vec2::ZERO {
            self.fitted = false;
            self.middle -= DVec2::new(f64::from(by.x), f64::from(by.y)) / self.scale;
        }
    }

    /// Makes pixels larger by `factor`; what is under `at` stays there.
    pub fn zoom(&mut self, rect: Rect, at: Pos2, factor: f64) {
        let scale = (self.scale * factor).clamp(self.least(), LARGEST);
        let from_middle = at - rect.center();
        let from_middle = DVec2::new(f64::from(from_middle.x), f64::from(from_middle.y));
        self.middle += from_middle / self.scale - from_middle / scale;
        (self.scale, self.fitted) = (scale, false);
    }

    /// Shows each pixel as one of the screen's, `density` of which make a point; what is under `at` stays there.
    pub fn show_pixels(&mut self, rect: Rect, at: Pos2, density: f32) {
        self.zoom(rect, at, 1.0 / f64::from(density) / self.scale);
    }

    /// Shows a rectangle of the picture, in its pixels, as large as the view has room for.
    pub fn show(&mut self, rect: Rect, low: DVec2, high: DVec2) {
        let room = rect.shrink(MARGIN).size().max(Vec2::splat(1.0));
        let size = (high - low).max(DVec2::ONE);
        let scale = (f64::from(room.x) / size.x).min(f64::from(room.y) / size.y);
        (self.middle, self.scale, self.fitted) = ((low + high) / 2.0, scale.min(LARGEST), false);
    }

    /// Puts a place of the picture into the middle.
    pub fn center_on(&mut self, place: DVec2) {
        (self.middle, self.fitted) = (place, false);
    }

    /// Pixels of a screen with `density` pixels a point, per pixel of the picture.
    pub fn magnification(&self, density: f32) -> f64 {
        self.scale * f64::from(density)
    }

    /// As it lies in `rect`, on a screen that has `density` pixels a point.
    pub fn seen(&self, rect: Rect, density: f32) -> Seen {
        let origin =
            rect.center() - vec2((self.middle.x * self.scale) as f32, (self.middle.y * self.scale) as f32);
        // On whole pixels of the screen, so that pixels of their own size are sharp.
        let whole = |points: f32| (points * density).round() / density;
        Seen { rect, origin: pos2(whole(origin.x), whole(origin.y)), scale: self.scale, density }
    }
}

/// A picture in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The view.
    pub rect: Rect,
    origin: Pos2,
    /// Points per pixel of the picture.
    pub scale: f64,
    /// Pixels of the screen per point.
    pub density: f32,
}

impl Seen {
    /// A place of the picture on the screen.
    pub fn at(&self, place: DVec2) -> Pos2 {
        self.origin + vec2((place.x * self.scale) as f32, (place.y * self.scale) as f32)
    }

    /// A rectangle of the picture on the screen.
    pub fn rect_of(&self, rect: PixelRect) -> Rect {
        let corner = |x: i32, y: i32| self.at(DVec2::new(f64::from(x), f64::from(y)));
        Rect::from_min_max(corner(rect.x, rect.y), corner(rect.right(), rect.bottom()))
    }

    /// The place of the picture under one of the screen.
    pub fn place(&self, at: Pos2) -> DVec2 {
        let from = at - self.origin;
        DVec2::new(f64::from(from.x), f64::from(from.y)) / self.scale
    }

    /// The screen's pixels in the view, as a grid over the picture.
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

    /// Where cells of [`Self::grid`] are on the screen.
    pub fn on_screen(&self, cells: PixelRect) -> Rect {
        let corner = |x: i32, y: i32| (self.first_cell() + vec2(x as f32, y as f32)) / self.density;
        let (min, max) = (corner(cells.x, cells.y), corner(cells.right(), cells.bottom()));
        Rect::from_min_max(min.to_pos2(), max.to_pos2())
    }

    /// The pixel of the screen in the view's top left corner.
    fn first_cell(&self) -> Vec2 {
        (self.rect.min.to_vec2() * self.density).floor()
    }

    /// The pixel under a place of the screen.
    pub fn pixel(&self, at: Pos2) -> (i32, i32) {
        let from = at - self.origin;
        let whole = |points: f32| (f64::from(points) / self.scale).floor() as i32;
        (whole(from.x), whole(from.y))
    }

    /// The part of the picture that is in the view.
    pub fn window(&self, bounds: PixelRect) -> PixelRect {
        let ((x0, y0), (x1, y1)) = (self.pixel(self.rect.min), self.pixel(self.rect.max));
        PixelRect::from_edges(x0, y0, x1 + 1, y1 + 1).intersection(&bounds)
    }

    /// Pixels of the screen per pixel of the picture.
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
            // To a pixel of the screen, or of the picture where those are larger.
            let near = (1.0 / density).max(1.01 * zoom as f32 / density);
            let distance = (shown.min - exact.min).length().max((shown.max - exact.max).length());
            assert!(distance <= 1.5 * near, "{shown:?} {exact:?}");
            let place = seen.place(seen.at(DVec2::new(1512.5, 1007.25)));
            assert!(place.distance(DVec2::new(1512.5, 1007.25)) < 1e-3, "{place}");
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
