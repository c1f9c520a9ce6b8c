//! A format of cameras as small as one can be: whatever reads cameras must read it, too.

#![cfg(test)]

use std::fs;
use std::path::Path;

use glam::{DMat3, DVec3};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_import::cameras::{Assembly, CameraFormat, RawCamera, ReconstructionFiles};

/// A line `dummy cameras`, then a photo a line: its path. The photo number i is taken from (i, 0, 0) with a focal
/// length of 9 pixels, 8 x 6 pixels large.
pub struct Dummy;

impl CameraFormat for Dummy {
    fn accepted(&self) -> &'static str {
        "a dummy"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["dummy"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let text = fs::read(file).ok()?;
        text.starts_with(b"dummy cameras\n").then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        names.iter().filter(|name| name.ends_with(".dummy")).find_map(|name| self.of_file(&folder.join(name)))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, _: &Task) -> Result<()> {
        let text = fs::read_to_string(&files.images).map_err(Error::io(&files.images, "read it"))?;
        for (index, path) in text.lines().skip(1).enumerate() {
            let camera = RawCamera { size: [8, 6], focal: [9.0; 2], centre: [4.0, 3.0], lens: Lens::None };
            let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(-(index as f64), 0.0, 0.0) };
            let name = path.rsplit('/').next().unwrap_or(path);
            assembly.photo(format!("line {}", index + 2), name, Ok(camera), Ok(pose));
        }
        Ok(())
    }
}
