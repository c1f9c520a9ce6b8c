//! Cameras of the same view at another image size.

use quadratura_base::geometry::Pinhole;

/// Returns `camera` for images of `width` x `height` pixels. Where the proportion of the sides is kept, to
/// within a pixel, the intrinsics are scaled exactly, so the image shows the same. Otherwise the vertical
/// field of view is kept, and the image is cropped or widened evenly left and right.
pub fn resized(camera: &Pinhole, width: u32, height: u32) -> Pinhole {
    let (old_width, old_height) = (f64::from(camera.width), f64::from(camera.height));
    let (x, y) = (f64::from(width) / old_width, f64::from(height) / old_height);
    // A size that was rounded to whole pixels counts as keeping the proportion.
    let keeps_proportion =
        (f64::from(width) - y * old_width).abs() < 1.0 || (f64::from(height) - x * old_height).abs() < 1.0;
    let across = if keeps_proportion { x } else { y };
    let margin = if keeps_proportion { 0.0 } else { (f64::from(width) - y * old_width) / 2.0 };
    Pinhole {
        width,
        height,
        fx: camera.fx * across,
        fy: camera.fy * y,
        cx: camera.cx * across + margin,
        cy: camera.cy * y,
    }
}

/// Returns `camera` with `scale` times its pixels along each side, at least one.
pub fn scaled(camera: &Pinhole, scale: f64) -> Pinhole {
    let side = |px: u32| (f64::from(px) * scale).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    resized(camera, side(camera.width), side(camera.height))
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    const CAMERA: Pinhole =
        Pinhole { width: 3072, height: 2048, fx: 2760.0, fy: 2764.0, cx: 1521.19, cy: 1007.31 };

    #[test]
    fn a_point_keeps_its_place_in_the_picture_when_the_proportion_is_kept() {
        let point = DVec3::new(0.3, -0.2, 1.0);
        let old = CAMERA.image_from_camera(point).unwrap() / DVec2::new(3072.0, 2048.0);
        for (width, height) in [(1536, 1024), (1000, 667), (6144, 4096), (1, 1)] {
            let camera = resized(&CAMERA, width, height);
            let new = camera.image_from_camera(point).unwrap();
            let error = new / DVec2::new(width.into(), height.into()) - old;
            assert!(error.length() < 1e-12, "{width} x {height}: {error}");
        }
    }

    #[test]
    fn another_proportion_keeps_the_vertical_field_and_the_middle() {
        let camera = resized(&CAMERA, 1920, 1024);
        assert_eq!((camera.fx, camera.fy, camera.cy), (1380.0, 1382.0, 503.655));
        let middle = |camera: &Pinhole| camera.ray_in_camera(DVec2::new(f64::from(camera.width) / 2.0, 0.0));
        assert!((middle(&camera) - middle(&CAMERA)).length() < 1e-12);
    }

    #[test]
    fn a_scale_gives_whole_pixels_and_one_at_least() {
        let half = scaled(&CAMERA, 0.5);
        assert_eq!((half.width, half.height, half.fx, half.cx), (1536, 1024, 1380.0, 760.595));
        assert_eq!((scaled(&CAMERA, 1e-9).width, scaled(&CAMERA, 1.0)), (1, CAMERA));
    }
}
