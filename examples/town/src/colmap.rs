//! COLMAP's text files: one camera, the poses, and points on surfaces with the photos that see them.

use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use glam::{DQuat, DVec2, DVec3, dvec2};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::Rng;
use rayon::prelude::*;

use crate::houses::Town;
use crate::plan::Station;

/// The noise of observations in pixels.
const NOISE: f64 = 0.3;
/// The farthest that a point is found in a photo, in metres.
const REACH: f64 = 60.0;
/// The area for each point, in square metres.
const AREA_PER_POINT: f64 = 1.5;
/// The most points of a face.
const MOST: f64 = 20_000.0;

/// A point with the photos that see it, and where.
struct Track {
    point: DVec3,
    seen: Vec<(usize, DVec2)>,
}

/// Writes `cameras.txt`, `images.txt` and `points3D.txt`.
pub fn write(
    folder: &Path,
    town: &Town,
    stations: &[Station],
    camera: &Pinhole,
    seed: u64,
) -> io::Result<()> {
    let tracks = tracks(town, stations, camera, seed);
    let Pinhole { width, height, fx, fy, cx, cy } = camera;
    fs::write(folder.join("cameras.txt"), format!("1 PINHOLE {width} {height} {fx} {fy} {cx} {cy}\n"))?;
    let mut lines = vec![String::new(); stations.len()];
    let mut counts = vec![0_usize; stations.len()];
    let mut points = String::new();
    for (number, Track { point, seen }) in tracks.iter().enumerate() {
        write!(points, "{} {} {} {} 128 128 128 {NOISE}", number + 1, point.x, point.y, point.z)
            .expect("a string takes all");
        for &(photo, at) in seen {
            write!(lines[photo], "{:.3} {:.3} {} ", at.x, at.y, number + 1).expect("a string takes all");
            write!(points, " {} {}", photo + 1, counts[photo]).expect("a string takes all");
            counts[photo] += 1;
        }
        points.push('\n');
    }
    fs::write(folder.join("points3D.txt"), points)?;
    let mut images = String::new();
    for (number, (station, line)) in stations.iter().zip(&lines).enumerate() {
        let Pose { rotation, translation: t } = station.pose;
        let q = DQuat::from_mat3(&rotation).normalize();
        let pose = format!("{} {} {} {} {} {} {}", q.w, q.x, q.y, q.z, t.x, t.y, t.z);
        writeln!(images, "{} {pose} 1 {}\n{}", number + 1, station.name, line.trim_end())
            .expect("a string takes all");
    }
    fs::write(folder.join("images.txt"), images)
}

/// Returns the points of all faces that two photos or more see.
fn tracks(town: &Town, stations: &[Station], camera: &Pinhole, seed: u64) -> Vec<Track> {
    let of_triangle = |triangle: usize| {
        let [a, b, c] = town.rays.triangles()[triangle];
        let (ab, ac) = (b - a, c - a);
        let count = (0.5 * ab.cross(ac).length() / AREA_PER_POINT).clamp(1.0, MOST) as usize;
        let mut rng = Rng::new(seed ^ (triangle as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let track = move |_| {
            let (s, t) = (rng.unit(), rng.unit());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            let point = a + ab * s + ac * t;
            let seen = stations.iter().enumerate().filter_map(|(photo, station)| {
                let at = projected(town, station, camera, point)?;
                // The sum of three uniform numbers is nearly normal, with a variance of a quarter of their range squared.
                let mut noise = || (rng.unit() + rng.unit() + rng.unit() - 1.5) * 2.0 * NOISE;
                let at = at + dvec2(noise(), noise());
                Some((photo, at))
            });
            Track { point, seen: seen.collect() }
        };
        (0..count).map(track).filter(|track| track.seen.len() > 1).collect::<Vec<_>>()
    };
    (0..town.face_of.len()).into_par_iter().flat_map_iter(of_triangle).collect()
}

/// Returns where a photo shows a point, in pixels; none where it is hidden, too far or outside.
fn projected(town: &Town, station: &Station, camera: &Pinhole, point: DVec3) -> Option<DVec2> {
    let away = point - station.eye;
    if away.length_squared() > REACH * REACH {
        return None;
    }
    let seen = station.pose.rotation * away;
    let at = dvec2(camera.fx * seen.x / seen.z + camera.cx, camera.fy * seen.y / seen.z + camera.cy);
    let size = dvec2(f64::from(camera.width), f64::from(camera.height));
    let shown = seen.z > 0.1 && at.cmpge(DVec2::ZERO).all() && at.cmplt(size).all();
    (shown && town.rays.first_hit(station.eye, away, 1.0 - 1e-4).is_none()).then_some(at)
}
