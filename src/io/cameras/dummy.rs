//! A format as small as one can be, in the table of tests only: whatever reads cameras must read it, too.

#![cfg(test)]

use std::path::Path;

use glam::{DMat3, DVec3};

use super::RawCamera;
use super::assembly::Assembly;
use super::format::{CameraFormat, ReconstructionFiles};
use super::lines::LineReader;
use super::locate::{beginning, recognised};
use super::photo_paths::photo_paths;
use crate::error::Result;
use crate::geometry::{Lens, Pose};
use crate::task::Task;

/// A line `dummy cameras`, then a photo a line: its path. The photo number i is taken from (i, 0, 0) with a focal
/// length of 9 pixels; its size is the photo's own.
pub(super) struct Dummy;

fn is_dummy(beginning: &[u8]) -> bool {
    beginning.starts_with(b"dummy cameras\n")
}

impl CameraFormat for Dummy {
    fn accepted(&self) -> &'static str {
        "a dummy"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["dummy"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        is_dummy(&beginning(file)).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        recognised(folder, names, ".dummy", &[], is_dummy)
            .first()
            .map(|file| Ok(ReconstructionFiles::one(file)))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let (mut lines, mut paths) = (LineReader::open(&files.images)?, Vec::new());
        while lines.next_record("read cameras", task)? {
            paths.push(lines.text().into_owned());
        }
        let paths: Vec<&str> = paths[1..].iter().map(String::as_str).collect();
        let photos = photo_paths(&paths, &[files.images.parent().unwrap().into()]);
        let sizes = assembly.sizes(&photos, task)?;
        for (index, (photo, size)) in photos.iter().zip(sizes).enumerate() {
            let camera =
                size.map(|size| RawCamera { size, focal: [9.0; 2], centre: [4.0, 3.0], lens: Lens::None });
            let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(-(index as f64), 0.0, 0.0) };
            assembly.photo(format!("line {}", index + 2), &photo.name, camera, Ok(pose));
        }
        Ok(())
    }
}
