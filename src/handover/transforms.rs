//! `transforms.json`, which nerfstudio, instant-ngp and programs for Gaussian splats read.
//!
//! Source: nerfstudio, *Data conventions*. `transform_matrix` takes a camera that looks along -z with y up to the world.

use serde::Serialize;

use super::camera::HandoverCamera;
use quadratura_files::json::to_json;

#[derive(Serialize)]
struct Transforms<'a> {
    camera_model: &'static str,
    /// The point of the project's world that is zero here; programs ignore what they do not know.
    origin: [f64; 3],
    frames: Vec<Frame<'a>>,
}

#[derive(Serialize)]
struct Frame<'a> {
    file_path: &'a str,
    w: u32,
    h: u32,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    transform_matrix: [[f64; 4]; 4],
}

/// Writes cameras as `transforms.json`; `origin` is the point of the world that is zero in their poses.
pub fn transforms_json(cameras: &[HandoverCamera], origin: [f64; 3]) -> Vec<u8> {
    let frames = cameras.iter().map(frame_of).collect();
    // OPENCV without coefficients is a pinhole; not every program knows the name PINHOLE.
    to_json(&Transforms { camera_model: "OPENCV", origin, frames })
}

fn frame_of(camera: &HandoverCamera) -> Frame<'_> {
    let lens = &camera.camera;
    Frame {
        file_path: &camera.file,
        w: lens.width,
        h: lens.height,
        fl_x: lens.fx,
        fl_y: lens.fy,
        cx: lens.cx,
        cy: lens.cy,
        transform_matrix: camera.world_from_gl_camera(),
    }
}
