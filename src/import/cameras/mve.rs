//! MVE's scene: a folder `views/NAME.mve` per photo with `meta.ini`.
//!
//! `rotation` by rows and `translation`, world to camera, x right, y down, z forward; `focal_length` in longer sides of the photo (with
//! `pixel_aspect`, the width of a pixel by its height), `principal_point` in parts of width and height, and two radial coefficients as Bundler's. A
//! focal length of 0 is a photo without pose. Sizes are those of the photos' files. Source: the program's `camera.h`. Not tried with the program
//! itself.

use std::path::{Path, PathBuf};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::assembly::Assembly;
use super::foreign_text::{number, numbers, read_text};
use super::format::CameraFormat;
use super::photo_paths::{Without, photo_paths};
use super::pose::{of_rows, pose_at};
use super::raw::RawCamera;
use super::recognise::{beginning, has_name, holds};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Mve;

const META: &str = "meta.ini";
const VIEW: &str = ".mve";
const REMEDY: &str = "reconstruct the scene again, or remove the view";

impl CameraFormat for Mve {
    fn accepted(&self) -> &'static str {
        "the folder of MVE's scene, with views/NAME.mve/meta.ini"
    }

    fn program(&self) -> &'static str {
        "MVE"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "views"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "focal length, principal point, two radial coefficients; not tried with the program itself",
            "points; undistorted copies",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["ini"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let of_view = file.parent().is_some_and(|view| view.extension().is_some_and(|it| it == "mve"));
        if !(has_name(file, &[META]) && (of_view || is_one(&beginning(file)))) {
            return None;
        }
        let views = file.parent().and_then(Path::parent).unwrap_or(Path::new(""));
        let folder = if views.as_os_str().is_empty() { Path::new(".") } else { views };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        Some(Ok(all(folder, &names).unwrap_or_else(|| ReconstructionFiles::one(file))))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        all(folder, names).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let (mut views, mut without) = (Vec::new(), 0);
        for (done, file) in files.others.iter().enumerate() {
            task.step("read poses", done as u64, files.others.len() as u64)?;
            match read_text(file, "expected the description of a view", REMEDY) {
                Ok(text) => match ViewFile::new(file, &text) {
                    Some(view) => views.push(view),
                    None => without += 1,
                },
                Err(error) => assembly.refused_file(error),
            }
        }
        let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
        let photos = photo_paths(&names, &[], Without::Any);
        let sizes = assembly.sizes(&photos, task)?;
        for ((view, photo), size) in views.into_iter().zip(&photos).zip(sizes) {
            let camera = size.and_then(|size| view.intrinsics?.camera(size));
            assembly.photo(view.place, &photo.name, camera, view.pose);
        }
        if without > 0 {
            assembly.note(format!("{}: {without} views have no pose", files.images.display()));
        }
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    holds(beginning, "[camera]") && holds(beginning, "focal_length")
}

/// Returns the descriptions of all views in a folder.
fn all(folder: &Path, names: &[String]) -> Option<ReconstructionFiles> {
    let mut views: Vec<&String> = names.iter().filter(|name| name.ends_with(VIEW)).collect();
    views.sort_unstable();
    let files = views.into_iter().map(|name| folder.join(name).join(META));
    let others: Vec<PathBuf> = files.filter(|file| file.is_file()).collect();
    Some(ReconstructionFiles { others: others.clone(), ..ReconstructionFiles::one(others.first()?) })
}

/// What a file says of its photo.
struct ViewFile {
    place: String,
    name: String,
    intrinsics: Result<Intrinsics, Objection>,
    pose: Result<Pose, Objection>,
}

impl ViewFile {
    /// Reads a view; `None` for one without pose.
    fn new(file: &Path, text: &str) -> Option<Self> {
        let values = values(text);
        let camera = |key: &str| values.get(&("camera", key)).copied();
        let intrinsics = Intrinsics::new(camera);
        if intrinsics.as_ref().is_ok_and(|intrinsics| intrinsics.focal == 0.0) {
            return None;
        }
        let text_of = |key: &str| camera(key).ok_or_else(|| (format!("it has no {key}"), REMEDY));
        let pose = || {
            let rotation = of_rows(&numbers(text_of("rotation")?, "rotation")?);
            let translation = DVec3::from(numbers::<3>(text_of("translation")?, "translation")?);
            pose_at(rotation, -(rotation.transpose() * translation))
        };
        let folder =
            file.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        let own = values.get(&("view", "name")).filter(|name| !name.is_empty());
        let name = own.map_or_else(|| folder.trim_end_matches(VIEW).to_owned(), |name| (*name).to_owned());
        Some(Self { place: format!("{folder}/{META}"), name, intrinsics, pose: pose() })
    }
}

/// Returns the values of a file by section and key.
fn values(text: &str) -> FxHashMap<(&str, &str), &str> {
    let (mut section, mut values) = ("", FxHashMap::default());
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with(['#', ';'])) {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            section = name;
        } else if let Some((key, value)) = line.split_once('=') {
            values.insert((section, key.trim()), value.trim());
        }
    }
    values
}

/// Intrinsics in the units of the program.
struct Intrinsics {
    focal: f64,
    aspect: f64,
    principal: [f64; 2],
    radial: [f64; 2],
}

impl Intrinsics {
    fn new<'a>(value: impl Fn(&str) -> Option<&'a str>) -> Result<Self, Objection> {
        let pair = |key: &str, usual| value(key).map_or(Ok(usual), |text| numbers(text, key));
        Ok(Self {
            focal: value("focal_length").map_or(Ok(0.0), |text| number(text, "focal_length"))?,
            aspect: value("pixel_aspect").map_or(Ok(1.0), |text| number(text, "pixel_aspect"))?,
            principal: pair("principal_point", [0.5; 2])?,
            radial: pair("radial_distortion", [0.0; 2])?,
        })
    }

    fn camera(self, size: [u64; 2]) -> Result<RawCamera, Objection> {
        let [width, height] = size.map(|side| side as f64);
        // The longer side of the picture as it is shown, in which pixels may be no squares.
        let focal = match width * self.aspect < height {
            true => [self.focal * height / self.aspect, self.focal * height],
            false => [self.focal * width, self.focal * width * self.aspect],
        };
        let [k1, k2] = self.radial;
        let lens = Lens::Brown { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        Ok(RawCamera { size, focal, centre: [self.principal[0] * width, self.principal[1] * height], lens })
    }
}
