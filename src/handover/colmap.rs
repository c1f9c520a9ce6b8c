//! COLMAP's text files: `cameras.txt`, `images.txt` and `points3D.txt`, with PINHOLE cameras.
//!
//! Source: COLMAP's documentation, *Output format*. A quaternion and a translation take the world to the camera; pixel (0, 0) has
//! its centre at (0.5, 0.5), as everywhere here. Numbers have all digits that they need to be read back as they are.

use std::fmt::Write as _;

use glam::{DQuat, DVec2, DVec3};

use super::camera::HandoverCamera;
use quadratura_base::geometry::Pinhole;

/// A point with its observations.
#[derive(Debug, Clone, PartialEq)]
pub struct HandoverPoint {
    /// The position in the world less the origin.
    pub position: DVec3,
    /// The colour, sRGB.
    pub colour: [u8; 3],
    /// The mean distance in pixels between the observations and where the cameras show the point.
    pub error: f64,
    /// The observations: the camera's place in the list, and the position in its undistorted picture in pixels.
    pub observations: Vec<(usize, DVec2)>,
}

/// The three files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColmapText {
    /// `cameras.txt`
    pub cameras: String,
    /// `images.txt`
    pub images: String,
    /// `points3D.txt`
    pub points: String,
}

/// Writes cameras and points as COLMAP's text files. `names` are the paths of the photos' pictures in the folder that is given to
/// other programs, in the order of `cameras`.
pub fn colmap_text(cameras: &[HandoverCamera], names: &[String], points: &[HandoverPoint]) -> ColmapText {
    let mut lenses: Vec<Pinhole> = Vec::new();
    let mut images = String::from(
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n",
    );
    let mut tracks: Vec<Vec<(usize, usize)>> = vec![Vec::new(); points.len()];
    let mut seen: Vec<Vec<(usize, DVec2)>> = vec![Vec::new(); cameras.len()];
    for (number, point) in points.iter().enumerate() {
        for &(camera, at) in &point.observations {
            tracks[number].push((camera, seen[camera].len()));
            seen[camera].push((number, at));
        }
    }
    for (number, ((camera, name), seen)) in cameras.iter().zip(names).zip(&seen).enumerate() {
        let lens = lenses.iter().position(|lens| *lens == camera.camera).unwrap_or_else(|| {
            lenses.push(camera.camera);
            lenses.len() - 1
        });
        let turn = DQuat::from_mat3(&camera.pose.rotation);
        let [w, x, y, z] = [turn.w, turn.x, turn.y, turn.z];
        let DVec3 { x: tx, y: ty, z: tz } = camera.pose.translation;
        let _ = writeln!(images, "{} {w} {x} {y} {z} {tx} {ty} {tz} {} {name}", number + 1, lens + 1);
        let seen: Vec<String> =
            seen.iter().map(|(point, at)| format!("{} {} {}", at.x, at.y, point + 1)).collect();
        images.push_str(&seen.join(" "));
        images.push('\n');
    }
    ColmapText { cameras: cameras_text(&lenses), images, points: points_text(points, &tracks) }
}

fn cameras_text(lenses: &[Pinhole]) -> String {
    let mut text = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[] (fx, fy, cx, cy)\n");
    for (number, Pinhole { width, height, fx, fy, cx, cy }) in lenses.iter().enumerate() {
        let _ = writeln!(text, "{} PINHOLE {width} {height} {fx} {fy} {cx} {cy}", number + 1);
    }
    text
}

fn points_text(points: &[HandoverPoint], tracks: &[Vec<(usize, usize)>]) -> String {
    let mut text =
        String::from("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
    for (number, (point, track)) in points.iter().zip(tracks).enumerate() {
        let DVec3 { x, y, z } = point.position;
        let [r, g, b] = point.colour;
        let _ = write!(text, "{} {x} {y} {z} {r} {g} {b} {}", number + 1, point.error);
        for (camera, index) in track {
            let _ = write!(text, " {} {index}", camera + 1);
        }
        text.push('\n');
    }
    text
}
