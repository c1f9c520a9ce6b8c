//! OpenSfM and OpenDroneMap: `reconstruction.json`, and `tracks.csv` beside it for the observations.
//!
//! The file is a list of reconstructions, each with `cameras`, `shots` (axis times angle and translation, world to camera) and `points`.
//! Lengths in the photo are in longer sides m from the middle. Source: OpenSfM, *Dataset structure* and *Geometric models*; the convention was
//! compared with a file that OpenSfM wrote.

use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec2, DVec3};
use rustc_hash::FxHashMap;
use serde_json::{Map, Value};

use super::assembly::Assembly;
use super::foreign_text::{json_number, json_numbers, kind, read_value};
use super::format::CameraFormat;
use super::lines::LineReader;
use super::photo_paths::{Without, photo_paths};
use super::pose::pose_at;
use super::raw::RawCamera;
use super::recognise::{beginning, has_name, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct OpenSfm;

const USUAL_NAME: &str = "reconstruction.json";
const TRACKS: &str = "tracks.csv";
const REMEDY: &str = "run OpenSfM's reconstruct again; the file may be cut short or damaged";
const EXPECTED: &str = "expected a list of reconstructions with \"cameras\" and \"shots\"";

impl CameraFormat for OpenSfm {
    fn accepted(&self) -> &'static str {
        "reconstruction.json of OpenSfM or OpenDroneMap"
    }

    fn program(&self) -> &'static str {
        "OpenSfM or OpenDroneMap"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "opensfm"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "perspective, brown, radial and fisheye lenses; points, with observations from tracks.csv; not tried with the program itself, but with files that it wrote",
            "all reconstructions but the largest; panoramas",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        (has_name(file, &[USUAL_NAME]) || is_one(&beginning(file))).then(|| Ok(with_tracks(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".json", &[USUAL_NAME], is_one);
        Some(Ok(with_tracks(found.first()?)))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let whole = read_value(file, EXPECTED, REMEDY)?;
        let all = whole.as_array().map(Vec::as_slice).unwrap_or(std::slice::from_ref(&whole));
        let shots_of = |it: &Value| it.get("shots").and_then(Value::as_object).map_or(0, Map::len);
        let most = all.iter().map(shots_of).max().unwrap_or(0);
        let chosen =
            all.iter().find(|it| shots_of(it) == most && it.get("shots").is_some_and(Value::is_object));
        let Some(chosen) = chosen else {
            return Err(Error::input(file, "", format!("{}, {EXPECTED}", kind(Some(&whole))), REMEDY));
        };
        if all.len() > 1 {
            let (file, count) = (file.display(), all.len());
            assembly.note(format!(
                "{file}: the largest of {count} separate reconstructions is read, with {most} photos"
            ));
        }
        let shots = chosen.get("shots").and_then(Value::as_object).into_iter().flatten();
        let shots: Vec<(&String, &Value)> = shots.collect();
        let names: Vec<&str> = shots.iter().map(|(name, _)| name.as_str()).collect();
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let photos = photo_paths(&names, &[folder.join("images"), folder], Without::Any);
        let mut kept: FxHashMap<&str, Used> = FxHashMap::default();
        for (done, ((name, shot), photo)) in shots.iter().zip(&photos).enumerate() {
            task.step("read poses", done as u64, shots.len() as u64)?;
            let camera = shot.get("camera").and_then(Value::as_str).unwrap_or_default();
            let described = chosen.get("cameras").and_then(|cameras| cameras.get(camera));
            let camera = match described {
                Some(described) => of_camera(described),
                None => Err((format!("its camera {camera:?} is not in the file"), REMEDY)),
            };
            let size = camera.as_ref().map(|camera| camera.size).unwrap_or_default();
            if let Some(photo) = assembly.photo(format!("shots[{name:?}]"), &photo.name, camera, pose(shot)) {
                kept.insert(name, Used { photo, size });
            }
        }
        let mut observations = match &files.points {
            Some(tracks) => observations(tracks, &kept, assembly, task)?,
            None => FxHashMap::default(),
        };
        let points = chosen.get("points").and_then(Value::as_object).into_iter().flatten();
        for (index, (id, point)) in points.enumerate() {
            let (place, seen) =
                (format!("points[{id:?}]"), observations.remove(id.as_str()).unwrap_or_default());
            match json_numbers::<3>(point.get("coordinates"), "coordinates") {
                Ok(position) => assembly.seen_point(place, index as u64, position, seen),
                Err(objection) => assembly.point_problem(place, objection),
            }
        }
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().first() == Some(&b'[')
        && holds(beginning, "\"cameras\"")
        && holds(beginning, "\"projection_type\"")
}

fn with_tracks(file: &Path) -> ReconstructionFiles {
    let tracks: PathBuf = file.with_file_name(TRACKS);
    let mut files = ReconstructionFiles::one(file);
    match tracks.is_file() {
        true => files.points = Some(tracks),
        false => files.notes.push(format!(
            "{}: there is no {TRACKS} beside it, so the observations of the points are not known",
            file.display()
        )),
    }
    files
}

/// A photo that is used, with its size.
struct Used {
    photo: u32,
    size: [u64; 2],
}

fn of_camera(camera: &Value) -> Result<RawCamera, Objection> {
    let number = |key: &str| json_number(camera.get(key), key);
    let or_0 = |key: &str| camera.get(key).map_or(Ok(0.0), |value| json_number(Some(value), key));
    let side = |key: &str| match number(key)? {
        side if (1.0..1e9).contains(&side) && side.fract() == 0.0 => Ok(side as u64),
        side => Err((format!("{key} is {side}, expected a number of pixels"), REMEDY)),
    };
    let size = [side("width")?, side("height")?];
    let m = size[0].max(size[1]) as f64;
    let middle = size.map(|side| 0.5 * side as f64);
    let kind = camera.get("projection_type").and_then(Value::as_str).unwrap_or("missing");
    let brown = |k: [f64; 3], p: [f64; 2]| Lens::Brown { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p };
    let fisheye = |k: [f64; 4]| Lens::Fisheye { k, p: [0.0; 2], s: [0.0; 2] };
    let [k1, k2, k3, k4] = [or_0("k1")?, or_0("k2")?, or_0("k3")?, or_0("k4")?];
    let (lens, has_own_centre) = match kind {
        "perspective" => (brown([k1, k2, 0.0], [0.0; 2]), false),
        "fisheye" => (fisheye([k1, k2, 0.0, 0.0]), false),
        "brown" => (brown([k1, k2, k3], [or_0("p1")?, or_0("p2")?]), true),
        "radial" => (brown([k1, k2, 0.0], [0.0; 2]), true),
        "simple_radial" => (brown([k1, 0.0, 0.0], [0.0; 2]), true),
        "fisheye_opencv" => (fisheye([k1, k2, k3, k4]), true),
        "spherical" | "equirectangular" => {
            return Err((
                "a spherical panorama is not a pinhole image".into(),
                "cut it into pinhole views first",
            ));
        }
        other => {
            let found = format!(
                "the projection_type {other:?}; known are perspective, brown, radial, simple_radial, fisheye and fisheye_opencv"
            );
            return Err((found, "calibrate with one of these"));
        }
    };
    let (focal, centre) = match has_own_centre {
        false => ([number("focal")? * m; 2], middle),
        true => (
            [number("focal_x")? * m, number("focal_y")? * m],
            [middle[0] + or_0("c_x")? * m, middle[1] + or_0("c_y")? * m],
        ),
    };
    Ok(RawCamera { size, focal, centre, lens })
}

fn pose(shot: &Value) -> Result<Pose, Objection> {
    let axis: [f64; 3] = json_numbers(shot.get("rotation"), "rotation")?;
    let translation: [f64; 3] = json_numbers(shot.get("translation"), "translation")?;
    if axis.iter().any(|part| part.abs() > 1e3) {
        return Err((format!("the rotation {axis:?} is no axis times an angle in radians"), REMEDY));
    }
    let rotation = DMat3::from_quat(DQuat::from_scaled_axis(axis.into()));
    let pose = pose_at(rotation, -(rotation.transpose() * DVec3::from(translation)))?;
    Ok(Pose { translation: translation.into(), ..pose })
}

/// Reads the observations of `tracks.csv`, by track: image, track, feature, x, y and more, separated by tabs.
fn observations(
    file: &Path,
    photos: &FxHashMap<&str, Used>,
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<FxHashMap<String, Vec<(u32, DVec2)>>> {
    let mut lines = LineReader::open(file)?;
    let mut tracks: FxHashMap<String, Vec<(u32, DVec2)>> = FxHashMap::default();
    let mut damaged = 0u64;
    while lines.next_line("read observations", task)? {
        let line = lines.text();
        if line.starts_with("OPENSFM_TRACKS_VERSION") {
            continue;
        }
        let fields: Vec<&str> = line.split('\t').collect();
        let [image, track, _, x, y, ..] = fields.as_slice() else {
            damaged += 1;
            continue;
        };
        let Some(used) = photos.get(image) else { continue };
        match (x.parse::<f64>(), y.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                let [w, h] = used.size.map(|side| side as f64);
                let at = DVec2::new(x, y) * w.max(h) + 0.5 * DVec2::new(w, h);
                tracks.entry((*track).to_owned()).or_default().push((used.photo, at));
            }
            _ => damaged += 1,
        }
    }
    if damaged > 0 {
        assembly.note(format!("{}: {damaged} lines are no observations, and are left out", file.display()));
    }
    Ok(tracks)
}
