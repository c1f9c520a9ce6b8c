//! Undistortion: the rectangle of a photo's pinhole image, and the position in the photo that each of its pixels
//! comes from.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Lens, Pinhole, RangedLens, RollingShutter};

/// The mapping between a distorted photo and its pinhole image. The pinhole image keeps the focal length at the
/// photo's centre, so that one pixel there stays one pixel, and contains all of the photo within the lens's valid
/// range and within twice the photo's number of pixels. Its principal point need not be in its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undistortion {
    /// The photo as taken: its size, and the focal lengths and principal point of its distorted image, in pixels.
    pub photo: Pinhole,
    /// The pinhole image's camera, in pixels.
    pub pinhole: Pinhole,
    lens: RangedLens,
    shutter: Option<RollingShutter>,
    /// The share of the photo's pixels that the pinhole image does not show, 0..=1, accurate to about 0.1 %.
    pub lost: f64,
}

/// The most pixels of the pinhole image, as a multiple of the photo's.
const MOST_PIXELS: f64 = 2.0;

/// A rectangle in pixels of the pinhole plane, before its corner is moved to (0, 0).
#[derive(Debug, Clone, Copy)]
struct PlaneRect {
    min: DVec2,
    max: DVec2,
}

impl Undistortion {
    /// Finds the pinhole image; `None` when the lens's range contains no pixel of the photo.
    pub fn new(photo: &Pinhole, lens: Lens) -> Option<Self> {
        Self::of_moving(photo, lens, None)
    }

    /// Finds the pinhole image at the pose of the middle row of a camera that moved, if it did; `None` as in
    /// [`Undistortion::new`].
    pub fn of_moving(photo: &Pinhole, lens: Lens, shutter: Option<RollingShutter>) -> Option<Self> {
        let lens = RangedLens::new(lens);
        let magnification = lens.lens().central_magnification();
        let plane = Pinhole { fx: photo.fx * magnification, fy: photo.fy * magnification, ..*photo };
        let unbounded = Self { photo: *photo, pinhole: plane, lens, shutter, lost: 0.0 };
        let bounds = within_budget(unbounded.bounds()?, &plane);
        // Pixels whose centre is inside are kept; at most half a pixel along the border is given up.
        let (min, max) = ((bounds.min - 0.5).ceil(), (bounds.max - 0.5).floor() + 1.0);
        let size = max - min;
        if !(size.x >= 1.0 && size.y >= 1.0) {
            return None;
        }
        let (width, height) = (size.x as u32, size.y as u32);
        let pinhole = Pinhole { width, height, cx: plane.cx - min.x, cy: plane.cy - min.y, ..plane };
        let bounded = Self { pinhole, ..unbounded };
        Some(Self { lost: bounded.lost_share(), ..bounded })
    }

    /// Maps a position in the pinhole image to the photo, both in pixels; `None` outside the photo or the lens's
    /// range.
    #[inline]
    pub fn photo_from_pinhole(&self, at: DVec2) -> Option<DVec2> {
        let (pinhole, photo) = (&self.pinhole, &self.photo);
        let xy = DVec2::new((at.x - pinhole.cx) / pinhole.fx, (at.y - pinhole.cy) / pinhole.fy);
        let at = match &self.shutter {
            None => self.photo_at(xy)?,
            Some(shutter) => {
                let point = DVec3::new(xy.x, xy.y, 1.0) * shutter.depth;
                let at_rest =
                    |point: DVec3| self.photo_at(point.truncate() / point.z).filter(|_| point.z > 0.0);
                shutter.image_of(point, photo.height.into(), at_rest)?
            }
        };
        holds(photo, at).then_some(at)
    }

    /// Maps an undistorted point in the camera's plane to the photo in pixels; `None` outside the lens's range.
    fn photo_at(&self, xy: DVec2) -> Option<DVec2> {
        let (distorted, photo) = (self.lens.distort(xy)?, &self.photo);
        Some(DVec2::new(photo.fx * distorted.x + photo.cx, photo.fy * distorted.y + photo.cy))
    }

    /// Maps a position in the photo to the pinhole image, both in pixels; it may lie outside of that image. `None`
    /// outside the lens's range.
    pub fn pinhole_from_photo(&self, at: DVec2) -> Option<DVec2> {
        let (pinhole, photo) = (&self.pinhole, &self.photo);
        let distorted = DVec2::new((at.x - photo.cx) / photo.fx, (at.y - photo.cy) / photo.fy);
        let mut xy = self.lens.undistort(distorted)?;
        if let Some(shutter) = &self.shutter {
            xy = shutter.ray_at_rest(xy.extend(1.0), at.y, photo.height.into())?.truncate();
        }
        Some(DVec2::new(pinhole.fx * xy.x + pinhole.cx, pinhole.fy * xy.y + pinhole.cy))
    }

    /// Returns what the photo covers of the pinhole plane: the bounds of the photo's outline within the lens's
    /// range, and of the range's outline within the photo.
    fn bounds(&self) -> Option<PlaneRect> {
        let outline = outline_points(&self.photo).filter_map(|at| self.pinhole_from_photo(at));
        let range = self.range_points().filter(|&at| self.photo_from_pinhole(at).is_some());
        outline.chain(range).fold(None, |bounds: Option<PlaneRect>, at| {
            let PlaneRect { min, max } = bounds.unwrap_or(PlaneRect { min: at, max: at });
            Some(PlaneRect { min: min.min(at), max: max.max(at) })
        })
    }

    /// Returns points all around the lens's range, in pixels of the pinhole plane.
    fn range_points(&self) -> impl Iterator<Item = DVec2> + '_ {
        const POINTS: u32 = 4096;
        // Slightly inside, because rounding could put them outside.
        let radius = self.lens.radius() * (1.0 - 1e-12);
        let Pinhole { fx, fy, cx, cy, .. } = self.pinhole;
        (0..POINTS).map(move |i| {
            let xy = DVec2::from_angle(TAU * f64::from(i) / f64::from(POINTS)) * radius;
            DVec2::new(fx * xy.x + cx, fy * xy.y + cy)
        })
    }

    /// Estimates the share of the photo that the pinhole image does not show, on a grid of 32 x 32 samples.
    fn lost_share(&self) -> f64 {
        const GRID: u32 = 32;
        let cell = DVec2::new(self.photo.width.into(), self.photo.height.into()) / f64::from(GRID);
        let kept = (0..GRID * GRID)
            .map(|i| cell * DVec2::new(f64::from(i % GRID) + 0.5, f64::from(i / GRID) + 0.5))
            .filter(|&at| self.pinhole_from_photo(at).is_some_and(|at| holds(&self.pinhole, at)))
            .count();
        1.0 - kept as f64 / f64::from(GRID * GRID)
    }
}

/// Returns true when a position in pixels lies in the image.
fn holds(image: &Pinhole, at: DVec2) -> bool {
    at.x >= 0.0 && at.y >= 0.0 && at.x <= f64::from(image.width) && at.y <= f64::from(image.height)
}

/// Returns points all around a photo with all four corners, close enough together that a curved border is met
/// within a hundredth of a pixel.
fn outline_points(photo: &Pinhole) -> impl Iterator<Item = DVec2> + use<> {
    let (width, height) = (f64::from(photo.width), f64::from(photo.height));
    let points = (photo.width.max(photo.height) / 8).clamp(64, 1024);
    (0..=points).flat_map(move |i| {
        let (x, y) = (width * f64::from(i) / f64::from(points), height * f64::from(i) / f64::from(points));
        [DVec2::new(x, 0.0), DVec2::new(x, height), DVec2::new(0.0, y), DVec2::new(width, y)]
    })
}

/// Cuts off what is farthest from the axis until at most [`MOST_PIXELS`] times the photo's pixels are left.
fn within_budget(bounds: PlaneRect, plane: &Pinhole) -> PlaneRect {
    let budget = MOST_PIXELS * f64::from(plane.width) * f64::from(plane.height);
    let (center, focal) = (DVec2::new(plane.cx, plane.cy), DVec2::new(plane.fx, plane.fy));
    let cut = |tangent: f64| PlaneRect {
        min: bounds.min.max(center - focal * tangent),
        max: bounds.max.min(center + focal * tangent),
    };
    // Rounding to pixel centres may add one row and one column.
    let fits =
        |b: &PlaneRect| (b.max.x - b.min.x + 1.0).max(0.0) * (b.max.y - b.min.y + 1.0).max(0.0) <= budget;
    if fits(&bounds) {
        return bounds;
    }
    let (mut low, mut high) =
        (0.0, ((bounds.max - center) / focal).max((center - bounds.min) / focal).max_element());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if fits(&cut(middle)) { low = middle } else { high = middle }
    }
    cut(low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lens::EVERY_KIND;

    const PHOTO: Pinhole = Pinhole { width: 640, height: 480, fx: 500.0, fy: 505.0, cx: 330.0, cy: 235.0 };

    #[test]
    fn every_pixel_of_the_photo_is_in_the_pinhole_image_of_a_mild_lens() {
        for lens in EVERY_KIND {
            let undistortion = Undistortion::new(&PHOTO, lens).unwrap();
            assert!(undistortion.lost < 1e-9, "{lens:?}: {}", undistortion.lost);
        }
    }

    #[test]
    fn a_lens_that_does_nothing_keeps_size_and_camera() {
        let undistortion = Undistortion::new(&PHOTO, Lens::None).unwrap();
        assert_eq!(undistortion.pinhole, PHOTO);
    }

    #[test]
    fn positions_lead_there_and_back() {
        for lens in EVERY_KIND {
            let undistortion = Undistortion::new(&PHOTO, lens).unwrap();
            for at in [DVec2::new(0.5, 0.5), DVec2::new(600.0, 20.0), DVec2::new(330.0, 235.0)] {
                let pinhole = undistortion.pinhole_from_photo(at).unwrap();
                let back = undistortion.photo_from_pinhole(pinhole).unwrap();
                assert!((back - at).length() < 1e-7, "{lens:?}: {back} is not {at}");
            }
        }
    }

    #[test]
    fn positions_in_the_photo_of_a_camera_that_moved_lead_there_and_back() {
        let (rotation, motion) = (DVec3::new(0.004, -0.01, 0.003), DVec3::new(0.05, 0.01, -0.02));
        let shutter = RollingShutter { rotation, motion, depth: 6.0 };
        let lens = EVERY_KIND[1];
        let still = Undistortion::new(&PHOTO, lens).unwrap();
        let moved = Undistortion::of_moving(&PHOTO, lens, Some(shutter)).unwrap();
        for at in [DVec2::new(20.5, 30.5), DVec2::new(600.0, 20.0), DVec2::new(330.0, 470.0)] {
            let pinhole = moved.pinhole_from_photo(at).unwrap();
            assert!(moved.photo_from_pinhole(pinhole).unwrap().distance(at) < 1e-7);
            let ray = |to: &Undistortion, at: DVec2| to.pinhole.ray_in_camera(at);
            let apart = ray(&moved, pinhole) - ray(&still, still.pinhole_from_photo(at).unwrap());
            assert!(apart.length() > 1e-3, "{apart}");
        }
        let middle = DVec2::new(100.0, 240.0);
        let rays =
            [&moved, &still].map(|to| to.pinhole.ray_in_camera(to.pinhole_from_photo(middle).unwrap()));
        assert!(rays[0].distance(rays[1]) < 1e-12, "the middle row is at the pose");
    }

    #[test]
    fn the_centre_keeps_its_scale() {
        for lens in EVERY_KIND {
            let undistortion = Undistortion::new(&PHOTO, lens).unwrap();
            let center = DVec2::new(undistortion.pinhole.cx, undistortion.pinhole.cy);
            let [a, b] =
                [-0.5, 0.5].map(|dx| undistortion.photo_from_pinhole(center + DVec2::new(dx, 0.0)).unwrap());
            assert!(((b - a).length() - 1.0).abs() < 1e-4, "{lens:?}: {}", (b - a).length());
        }
    }

    #[test]
    fn the_rectangle_touches_the_photo_on_all_sides() {
        let barrel = Lens::Brown { k: [-0.15, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let undistortion = Undistortion::new(&PHOTO, barrel).unwrap();
        let Pinhole { width, height, .. } = undistortion.pinhole;
        let any = |mut centers: Box<dyn Iterator<Item = (u32, u32)>>| {
            centers.any(|(x, y)| {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                undistortion.photo_from_pinhole(at).is_some()
            })
        };
        assert!(any(Box::new((0..width).map(|x| (x, 0)))), "top");
        assert!(any(Box::new((0..width).map(move |x| (x, height - 1)))), "bottom");
        assert!(any(Box::new((0..height).map(|y| (0, y)))), "left");
        assert!(any(Box::new((0..height).map(move |y| (width - 1, y)))), "right");
    }

    #[test]
    fn a_fisheye_of_180_degrees_is_cut_to_twice_its_pixels_and_says_what_is_lost() {
        let fisheye = Lens::Fisheye { k: [0.0; 4], p: [0.0; 2], s: [0.0; 2] };
        // Half the width spans 90 degrees.
        let photo = Pinhole { width: 1000, height: 1000, fx: 318.3, fy: 318.3, cx: 500.0, cy: 500.0 };
        let undistortion = Undistortion::new(&photo, fisheye).unwrap();
        let Pinhole { width, height, fx, .. } = undistortion.pinhole;
        assert!(width * height <= 2_000_000 && fx == photo.fx);
        let degrees = 2.0 * (f64::from(width) / 2.0 / fx).atan().to_degrees();
        assert!(degrees <= 120.0 && width == height && width == 1102, "{width}, {degrees}");
        // A disc of 60 degrees around the axis out of a square of 180.
        let expected = 1.0 - TAU / 2.0 * (318.3 * TAU / 6.0_f64).powi(2) / 1e6;
        assert!((undistortion.lost - expected).abs() < 0.01, "{} {expected}", undistortion.lost);
    }

    #[test]
    fn a_wide_lens_is_cut_to_twice_its_pixels() {
        let strong = Lens::Division { k: -0.9 };
        let photo = Pinhole { width: 800, height: 600, fx: 500.0, fy: 500.0, cx: 400.0, cy: 300.0 };
        let undistortion = Undistortion::new(&photo, strong).unwrap();
        let Pinhole { width, height, .. } = undistortion.pinhole;
        assert!(width * height <= 2 * 800 * 600 && undistortion.lost > 0.0);
        assert!(width * height > 2 * 800 * 600 * 95 / 100, "{width} x {height}");
    }

    #[test]
    fn an_off_centre_crop_keeps_its_place() {
        let barrel = Lens::Brown { k: [-0.1, 0.01, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let crop = Pinhole { fx: 2000.0, fy: 2000.0, cx: -50.0, cy: 600.0, ..PHOTO };
        let undistortion = Undistortion::new(&crop, barrel).unwrap();
        assert!(undistortion.pinhole.cx < 0.0 && undistortion.lost < 1e-9, "{undistortion:?}");
    }

    #[test]
    fn a_photo_outside_the_range_has_no_pinhole_image() {
        let far = Pinhole { cx: 60_000.0, ..PHOTO };
        assert!(Undistortion::new(&far, Lens::Division { k: -0.1 }).is_none());
    }
}
