//! What the parsers found, before it is judged.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use quadratura_base::error::Error;
use quadratura_base::geometry::{Lens, Pinhole, Pose};
use quadratura_files::text::Objection;

/// A parsed camera before its checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawCamera {
    /// Width and height in pixels.
    pub size: [u64; 2],
    /// Focal lengths along x and y, in pixels.
    pub focal: [f64; 2],
    /// The principal point in pixels from the upper left corner.
    pub centre: [f64; 2],
    /// The lens distortion.
    pub lens: Lens,
}

/// A parsed photo before its checks that refers to its camera and to its points by number.
pub(super) struct RawImage<'a> {
    pub id: u32,
    pub pose: Result<Pose, Objection>,
    pub camera: u32,
    pub name: &'a str,
    /// Image position in pixels and point id, of those keypoints that have one.
    pub observations: Vec<([f64; 2], u64)>,
}

/// A parsed photo with its own camera.
pub(super) struct RawPhoto<'a> {
    pub name: &'a str,
    pub camera: Result<(Pinhole, Lens), Objection>,
    pub pose: Result<Pose, Objection>,
}

/// Problems of one reading, kept in number: a hostile file may hold one in every line.
#[derive(Debug, Default)]
pub(super) struct Problems {
    kept: Vec<Error>,
    dropped: BTreeMap<PathBuf, usize>,
}

impl Problems {
    pub const MOST: usize = 200;

    pub fn push(&mut self, file: &Path, problem: Error) {
        if self.kept.len() < Self::MOST {
            self.kept.push(problem);
        } else {
            *self.dropped.entry(file.to_path_buf()).or_default() += 1;
        }
    }

    pub fn finish(mut self) -> Vec<Error> {
        for (file, count) in self.dropped {
            let found = format!("{count} more problems that are not listed");
            self.kept.push(Error::input(file, "", found, "correct those above first"));
        }
        self.kept
    }
}
