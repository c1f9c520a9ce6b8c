//! The sample's cameras as other programs would have written them, with lenses and observations.
//!
//! Each file is written from the definition of its format, without the readers' code: a writer computes by the format's own formula
//! where a photo shows a point, and the reader must show it there within a millionth of a pixel.

#![cfg(test)]

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DMat3, DVec2, DVec3};

use super::*;
use crate::mutations::{mutated, mutations};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::synthetic::Rng;

mod agree;
pub(super) mod metashape;
mod others;
mod surveys;

/// A photo of the sample, without a lens.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    pub name: String,
    pub size: [u32; 2],
    /// The focal length, and the principal point from the upper left corner, in pixels.
    pub f: f64,
    pub centre_px: [f64; 2],
    /// World to camera: x right, y down, z forward.
    pub rotation: DMat3,
    /// The camera in the world.
    pub centre: DVec3,
}

impl Shot {
    /// Returns a point in the camera's frame.
    pub fn see(&self, point: DVec3) -> DVec3 {
        self.rotation * (point - self.centre)
    }

    /// Returns the rows of the rotation.
    pub fn rows(&self) -> [f64; 9] {
        self.rotation.transpose().to_cols_array()
    }

    pub fn longer_side(&self) -> f64 {
        f64::from(self.size[0].max(self.size[1]))
    }

    /// Returns the principal point from the middle of the photo.
    pub fn off_middle(&self) -> DVec2 {
        DVec2::from(self.centre_px) - self.middle()
    }

    pub fn middle(&self) -> DVec2 {
        0.5 * DVec2::new(self.size[0].into(), self.size[1].into())
    }
}

/// The photos of the sample, and points with the photos that show them.
#[derive(Debug, Clone)]
pub(super) struct Site {
    pub shots: Vec<Shot>,
    pub points: Vec<(DVec3, Vec<usize>)>,
}

pub(super) fn sample() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/piazza")
}

impl Site {
    /// Reads the sample's cameras.
    pub fn piazza() -> Self {
        let truth = read_cameras(&sample().join("sparse"), &Task::silent()).unwrap();
        let shots = truth.photos.iter().map(|photo| {
            let Pinhole { width, height, fx, fy, cx, cy } = photo.camera;
            assert!(fx == fy && photo.lens.is_none());
            let (rotation, centre) = (photo.pose.rotation, photo.pose.center_in_world());
            Shot {
                name: photo.name.clone(),
                size: [width, height],
                f: fx,
                centre_px: [cx, cy],
                rotation,
                centre,
            }
        });
        let points = truth.points.iter().map(|point| {
            (point.position, point.observations.iter().map(|(photo, _)| *photo as usize).collect())
        });
        Self { shots: shots.collect(), points: points.collect() }
    }

    /// Returns the same with some photos and some points, for files that are read ten thousand times.
    pub fn small() -> Self {
        let mut site = Self::piazza();
        site.shots.truncate(3);
        site.points.iter_mut().for_each(|(_, photos)| photos.retain(|photo| *photo < 3));
        site.points.retain(|(_, photos)| photos.len() >= 2);
        site.points.truncate(6);
        site
    }

    /// Lists points and photos that show them, with where a format's formula has them.
    pub fn observed(&self, shown: impl Fn(&Shot, DVec3) -> DVec2) -> Vec<Observed> {
        let all = self.points.iter().enumerate();
        let seen =
            all.flat_map(|(index, (point, photos))| photos.iter().map(move |photo| (index, *point, *photo)));
        seen.map(|(point, position, photo)| {
            let at = shown(&self.shots[photo], position);
            Observed { point, position, photo, at }
        })
        .collect()
    }
}

/// Where a photo shows a point by the formula of a format.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observed {
    pub point: usize,
    pub position: DVec3,
    pub photo: usize,
    pub at: DVec2,
}

/// Files of a format, the first of which is given to the reader.
pub(super) struct Written {
    pub files: Vec<(String, Vec<u8>)>,
    pub observed: Vec<Observed>,
}

impl Written {
    pub fn one(name: &str, text: String, observed: Vec<Observed>) -> Self {
        Self { files: vec![(name.to_owned(), text.into_bytes())], observed }
    }

    /// Writes the files to a new folder.
    pub fn folder(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in &self.files {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, bytes).unwrap();
        }
        folder
    }

    /// Reads the files with the sample's photos.
    pub fn read(&self, options: &CameraOptions) -> Result<Cameras> {
        let folder = self.folder();
        read_cameras_as(
            &sample().join("photos"),
            &folder.path().join(&self.files[0].0),
            options,
            &Task::silent(),
        )
    }

    /// Returns what is wrong with the files.
    pub fn refused(&self) -> String {
        self.read(&CameraOptions::default()).unwrap_err().to_string()
    }

    /// Returns the files with a text replaced in the first one.
    pub fn with(&self, from: &str, to: &str) -> Self {
        let mut files = self.files.clone();
        let text = String::from_utf8(files[0].1.clone()).unwrap();
        assert!(text.contains(from), "{from} is not in {text}");
        files[0].1 = text.replacen(from, to, 1).into_bytes();
        Self { files, observed: self.observed.clone() }
    }
}

/// Asserts that every photo is read, and shows every point where the format's formula has it. Returns the cameras.
#[track_caller]
pub(super) fn assert_agrees(site: &Site, written: &Written, options: &CameraOptions) -> Cameras {
    let read = written.read(options).unwrap();
    assert!(read.problems.is_empty(), "{:?}", read.problems);
    assert_eq!(read.photos.len(), site.shots.len());
    let mut worst = 0.0f64;
    for observed in &written.observed {
        let shot = &site.shots[observed.photo];
        let stem = |name: &str| name.split('.').next().unwrap().to_owned();
        let photo = read.photos.iter().find(|photo| stem(&photo.name) == stem(&shot.name)).unwrap();
        assert_eq!([photo.camera.width, photo.camera.height], shot.size);
        assert!(photo.pose.center_in_world().distance(shot.centre) < 1e-9, "{photo:?} {shot:?}");
        let at = photo.image_from_world(observed.position).unwrap();
        worst = worst.max(at.distance(observed.at));
    }
    assert!(worst < 1e-6, "{worst} px");
    read
}

/// Asserts that the file's own observations are where its cameras show its points, and that its points are the site's.
#[track_caller]
pub(super) fn assert_observations(read: &Cameras, written: &Written) {
    let judged = read.reprojection.as_ref().unwrap();
    assert!(judged.median_px < 1e-6 && judged.variants.is_empty(), "{judged:?}");
    assert_eq!(judged.observations, written.observed.len());
    for point in &read.points {
        let nearest =
            written.observed.iter().map(|it| it.position.distance(point.position)).fold(9.0, f64::min);
        assert!(nearest < 1e-6, "{point:?}");
        for (photo, at) in &point.observations {
            let shown = read.photos[*photo as usize].image_from_world(point.position).unwrap();
            assert!(shown.distance(*at) < 1e-6, "{shown} {at}");
        }
    }
}

/// Reads ten thousand damaged copies of a file, the first or another one of those given: each gives a result or an error, and never a
/// fault that only the net behind the readers caught.
#[track_caller]
pub(super) fn assert_survives(written: &Written, which: usize, words: &[&str]) {
    let folder = written.folder();
    let (first, damaged) =
        (folder.path().join(&written.files[0].0), folder.path().join(&written.files[which].0));
    let text = String::from_utf8(written.files[which].1.clone()).unwrap();
    let mut rng = Rng::new(17);
    for round in 0..mutations(10_000) {
        let bytes = mutated(&text, words, &mut rng);
        fs::write(&damaged, &bytes).unwrap();
        if let Err(error) = read_cameras(&first, &Task::silent()) {
            let error = error.to_string();
            assert!(
                !error.contains("its decoder failed"),
                "{round}: {error}\n{}",
                String::from_utf8_lossy(&bytes)
            );
        }
    }
}
