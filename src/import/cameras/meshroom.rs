//! Meshroom's `cameras.sfm` and `sfm.json` (AliceVision).
//!
//! `views` name photos and refer to `intrinsics` and `poses` by number. A pose has nine numbers, world to camera by *columns*, and the
//! centre. Numbers are texts. The table of what changed with the version, of those that are read:
//!
//! | version | |
//! |---|---|
//! | before 1.2.0 | `pxFocalLength` in pixels in place of `focalLength` |
//! | from 1.2.0 | `focalLength` in millimetres, of a sensor `sensorWidth` wide |
//! | before 1.2.1 | `principalPoint` from the upper left corner |
//! | from 1.2.1 | `principalPoint` from the middle |
//!
//! Types: `pinhole`; `radial1` (k1), `radial3` (k1, k2, k3), `brown` (k1, k2, k3, t1, t2 as OpenCV's p1, p2) and `fisheye4` (k1 to k4, of the
//! angle). Later versions have `pinhole` with a `distortionType` (`none`, `radialk1`, `radialk3`, `brown`, `fisheye`), which was not tried with
//! the program itself. Those of 3DEqualizer are inverses, and are refused. Source: AliceVision, `sfmDataIO`; the conventions were compared with files that Meshroom wrote.

use std::path::Path;

use glam::{DMat3, DVec2, DVec3};
use rustc_hash::FxHashMap;
use serde_json::Value;

use super::assembly::Assembly;
use super::foreign_text::{json_number, json_numbers, kind, read_value};
use super::format::CameraFormat;
use super::photo_paths::{Without, photo_paths};
use super::pose::pose_at;
use super::raw::RawCamera;
use super::recognise::{beginning, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Meshroom;

const REMEDY: &str = "write it anew with Meshroom: ConvertSfMFormat, or the node StructureFromMotion";
const EXPECTED: &str = "expected a JSON object with lists \"views\", \"intrinsics\" and \"poses\"";

impl CameraFormat for Meshroom {
    fn accepted(&self) -> &'static str {
        "Meshroom's cameras.sfm or sfm.json"
    }

    fn program(&self) -> &'static str {
        "Meshroom"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "pinhole, radial1, radial3, brown and fisheye4 lenses; points with observations; not tried with the program itself, but with files that it wrote",
            "rigs; pixels that are not square; lenses of 3DEqualizer",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["sfm", "json"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        is_one(&beginning(file)).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let mut found = recognised(folder, names, ".sfm", &["sfm.sfm", "cameras.sfm"], is_one);
        found.extend(recognised(folder, names, ".json", &["sfm.json"], is_one));
        ReconstructionFiles::first_of(&found).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let whole = read_value(file, EXPECTED, REMEDY)?;
        let Some(views) = whole.get("views").and_then(Value::as_array) else {
            let found = format!("views: {}, {EXPECTED}", kind(whole.get("views")));
            return Err(Error::input(file, "", found, REMEDY));
        };
        let version = version(&whole);
        let by_id = |list: &str, id: &str| -> FxHashMap<String, &Value> {
            let items = whole.get(list).and_then(Value::as_array).into_iter().flatten();
            items.filter_map(|item| Some((name_of(item.get(id)?)?, item))).collect()
        };
        let (intrinsics, poses) = (by_id("intrinsics", "intrinsicId"), by_id("poses", "poseId"));
        let field = |view: &Value, key: &str| view.get(key).and_then(name_of).unwrap_or_default();
        let (mut used, mut without, mut of_rigs) = (Vec::new(), 0, 0);
        for (index, view) in views.iter().enumerate() {
            if view.get("subPoseId").and_then(name_of).is_some_and(|id| id != "-1" && id != "4294967295") {
                of_rigs += 1;
                continue;
            }
            match poses.get(&field(view, "poseId")) {
                None => without += 1,
                Some(pose) => used.push((index, view, *pose)),
            }
        }
        let paths: Vec<&str> = used
            .iter()
            .map(|(_, view, _)| view.get("path").and_then(Value::as_str).unwrap_or_default())
            .collect();
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let photos = photo_paths(&paths, &[folder], Without::Any);
        let mut kept: FxHashMap<String, u32> = FxHashMap::default();
        for (done, ((index, view, pose), photo)) in used.iter().zip(&photos).enumerate() {
            task.step("read poses", done as u64, used.len() as u64)?;
            let id = field(view, "intrinsicId");
            let camera = match intrinsics.get(&id) {
                Some(intrinsic) => camera(intrinsic, version)
                    .map_err(|(found, remedy)| (format!("intrinsic {id}: {found}"), remedy)),
                None => Err((format!("its intrinsic {id:?} is not in the file"), REMEDY)),
            };
            if let Some(photo) = assembly.photo(format!("views[{index}]"), &photo.name, camera, pose_of(pose))
            {
                kept.insert(field(view, "viewId"), photo);
            }
        }
        let (name, all) = (file.display(), views.len());
        for (count, why) in [
            (without, "have no pose: they are not registered"),
            (of_rigs, "belong to a rig, which is not read"),
        ] {
            if count > 0 {
                assembly.note(format!("{name}: {count} of {all} views {why}, and are left out"));
            }
        }
        take_structure(&whole, &kept, assembly);
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    let is_one = ["\"viewId\"", "\"intrinsicId\"", "\"poseId\""].into_iter().any(|key| holds(beginning, key));
    beginning.trim_ascii_start().first() == Some(&b'{') && is_one
}

/// Returns a number or text as text: ids are either.
fn name_of(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// Returns the version of the file, the latest where it states none.
fn version(whole: &Value) -> [u32; 3] {
    let mut version = [u32::MAX; 3];
    let parts = whole.get("version").and_then(Value::as_array).into_iter().flatten();
    for (to, part) in version.iter_mut().zip(parts) {
        *to = name_of(part).and_then(|part| part.parse().ok()).unwrap_or(u32::MAX);
    }
    version
}

fn camera(intrinsic: &Value, version: [u32; 3]) -> Result<RawCamera, Objection> {
    let number = |key: &str| json_number(intrinsic.get(key), key);
    let side = |key: &str| match number(key)? {
        side if (1.0..1e9).contains(&side) && side.fract() == 0.0 => Ok(side as u64),
        side => Err((format!("{key} is {side}, expected a number of pixels"), REMEDY)),
    };
    let size = [side("width")?, side("height")?];
    let f = match version < [1, 2, 0] {
        true => number("pxFocalLength")?,
        false => number("focalLength")? * size[0] as f64 / number("sensorWidth")?,
    };
    if intrinsic.get("pixelRatio").is_some() && number("pixelRatio")? != 1.0 {
        let found = format!("pixelRatio is {}, and only square pixels are read", number("pixelRatio")?);
        return Err((found, "calibrate with square pixels"));
    }
    let principal: [f64; 2] = json_numbers(intrinsic.get("principalPoint"), "principalPoint")?;
    let from_corner = version < [1, 2, 1];
    let centre = [0, 1].map(|axis| principal[axis] + if from_corner { 0.0 } else { 0.5 * size[axis] as f64 });
    Ok(RawCamera { size, focal: [f; 2], centre, lens: lens(intrinsic)? })
}

fn lens(intrinsic: &Value) -> Result<Lens, Objection> {
    let named = |key: &str| intrinsic.get(key).and_then(Value::as_str);
    // Later versions have the lens in a field of its own.
    let model = match (named("type").unwrap_or("missing"), named("distortionType")) {
        ("pinhole", Some("radialk1")) => "radial1",
        ("pinhole", Some("radialk3")) => "radial3",
        ("pinhole", Some("fisheye")) => "fisheye4",
        ("pinhole", Some(lens)) if lens != "none" => lens,
        (model, _) => model,
    };
    // Without distortion, the list may be missing, or an empty text.
    let given =
        intrinsic.get("distortionParams").and_then(Value::as_array).is_some_and(|list| !list.is_empty());
    let parameters = || json_parameters(intrinsic.get("distortionParams"));
    let brown = |k: [f64; 3], p: [f64; 2]| Lens::Brown { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p };
    let wrong = |count: usize| {
        (format!("{count} distortionParams, which is not the number of the type {model}"), REMEDY)
    };
    match model {
        "pinhole" => Ok(Lens::None),
        "radial1" | "radial3" | "brown" if !given => Ok(Lens::None),
        "radial1" | "radial3" | "brown" => match (model, parameters()?.as_slice()) {
            ("radial1", &[k1]) => Ok(brown([k1, 0.0, 0.0], [0.0; 2])),
            ("radial3", &[k1, k2, k3]) => Ok(brown([k1, k2, k3], [0.0; 2])),
            ("brown", &[k1, k2, k3, t1, t2]) => Ok(brown([k1, k2, k3], [t1, t2])),
            (_, other) => Err(wrong(other.len())),
        },
        "fisheye4" => match parameters()?.as_slice() {
            &[k1, k2, k3, k4] => Ok(Lens::Fisheye { k: [k1, k2, k3, k4], p: [0.0; 2], s: [0.0; 2] }),
            other => Err(wrong(other.len())),
        },
        _ => {
            let found = format!("the type {model:?}, expected pinhole, radial1, radial3, brown or fisheye4");
            Err((found, "calibrate with one of these, or export COLMAP's format"))
        }
    }
}

fn json_parameters(list: Option<&Value>) -> Result<Vec<f64>, Objection> {
    let items = list.and_then(Value::as_array).into_iter().flatten();
    items.map(|item| json_number(Some(item), "distortionParams")).collect()
}

fn pose_of(pose: &Value) -> Result<Pose, Objection> {
    let transform = pose.get("pose").and_then(|pose| pose.get("transform"));
    let of = |key: &str| transform.and_then(|transform| transform.get(key));
    let columns: [f64; 9] = json_numbers(of("rotation"), "rotation")?;
    let centre: [f64; 3] = json_numbers(of("center"), "center")?;
    pose_at(DMat3::from_cols_array(&columns), DVec3::from(centre))
}

fn take_structure(whole: &Value, photos: &FxHashMap<String, u32>, assembly: &mut Assembly<'_>) {
    let landmarks = whole.get("structure").and_then(Value::as_array).into_iter().flatten();
    for (index, landmark) in landmarks.enumerate() {
        let place = format!("structure[{index}]");
        let seen = landmark.get("observations").and_then(Value::as_array).into_iter().flatten();
        let seen = seen.filter_map(|observation| {
            let photo = photos.get(&name_of(observation.get("observationId")?)?)?;
            let at: [f64; 2] = json_numbers(observation.get("x"), "x").ok()?;
            Some((*photo, DVec2::from(at)))
        });
        match json_numbers::<3>(landmark.get("X"), "X") {
            Ok(position) => assembly.seen_point(place, index as u64, position, seen.collect()),
            Err(objection) => assembly.point_problem(place, objection),
        }
    }
}
