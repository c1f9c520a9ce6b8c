//! `cameras.json`: cameras in plain numbers, for scripts.
//!
//! `X_camera = R (X_world - origin) + t`, the camera looks along +z with x right and y down, and `K X_camera` is the position in
//! pixels from the top left corner, whose pixel has its centre at (0.5, 0.5). C is the centre of projection, less the origin.

use serde::Serialize;

use super::camera::HandoverCamera;
use quadratura_files::json::to_json;

const VERSION: u32 = 1;

#[derive(Serialize)]
struct CamerasFile<'a> {
    version: u32,
    origin: [f64; 3],
    cameras: Vec<Camera<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    views: Vec<Camera<'a>>,
}

#[derive(Serialize)]
#[allow(non_snake_case, reason = "the field's names for these")]
struct Camera<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "str::is_empty")]
    file: &'a str,
    width: u32,
    height: u32,
    K: [[f64; 3]; 3],
    R: [[f64; 3]; 3],
    t: [f64; 3],
    C: [f64; 3],
}

/// Writes cameras as `cameras.json`, and `views`, which have no file: viewpoints that the project keeps. `origin` is the point of the world that is
/// zero in their poses.
pub fn cameras_json(cameras: &[HandoverCamera], views: &[HandoverCamera], origin: [f64; 3]) -> Vec<u8> {
    let [cameras, views] = [cameras, views].map(|cameras| cameras.iter().map(camera_of).collect());
    to_json(&CamerasFile { version: VERSION, origin, cameras, views })
}

fn camera_of(camera: &HandoverCamera) -> Camera<'_> {
    Camera {
        name: &camera.name,
        file: &camera.file,
        width: camera.camera.width,
        height: camera.camera.height,
        K: camera.camera.matrix_rows(),
        R: camera.pose.rotation_rows(),
        t: camera.pose.translation.to_array(),
        C: camera.center().to_array(),
    }
}
