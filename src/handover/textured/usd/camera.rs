//! The camera of a photo.
//!
//! With a = fx / fy and an aperture of s for the width W of the photo: focal length fx s / W, vertical aperture s a H / W, offsets
//! (W/2 - cx) s / W and (cy - H/2) a s / W. The camera looks along -z with y up.

use glam::DVec3;

use super::text::{quoted, tuple};
use super::transform;
use crate::camera::{FILM_WIDTH_MM, HandoverCamera};
use quadratura_base::geometry::Pinhole;

/// Writes a camera, which is called `name`, with the shortest and the longest distance that it shows.
pub(super) fn write(text: &mut String, name: &str, camera: &HandoverCamera, clipping: [f64; 2]) {
    let Pinhole { width, height, fx, fy, cx, cy } = camera.camera;
    let [w, h] = [width, height].map(f64::from);
    let (aspect, per_px) = (fx / fy, FILM_WIDTH_MM / w);
    let axes = camera.pose.rotation.transpose();
    let rows: [DVec3; 4] = [axes.x_axis, -axes.y_axis, -axes.z_axis, camera.pose.center_in_world()];
    let [focal, vertical, right, up] =
        [fx * per_px, aspect * h * per_px, (w / 2.0 - cx) * per_px, (cy - h / 2.0) * aspect * per_px]
            .map(|value| value as f32);
    let (clipping, transform) = (tuple(clipping), transform(&rows, "            "));
    let (photo, file) = (quoted(&camera.name), quoted(&camera.file));
    text.push_str(&format!(
        r#"        def Camera "{name}"
        {{
            float2 clippingRange = {clipping}
            float focalLength = {focal}
            float horizontalAperture = {FILM_WIDTH_MM}
            float horizontalApertureOffset = {right}
            token projection = "perspective"
            custom string quadratura:file = {file}
            custom string quadratura:name = {photo}
            custom int2 quadratura:size = ({width}, {height})
            float verticalAperture = {vertical}
            float verticalApertureOffset = {up}
{transform}        }}

"#
    ));
}
