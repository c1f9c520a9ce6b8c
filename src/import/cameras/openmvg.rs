//! OpenMVG's `sfm_data.json`, as its library writes it: lists of pairs of key and value, with pointers in wrappers.
//!
//! `extrinsics` have a rotation, world to camera by rows, and the centre. The principal point is from the upper left corner. Lenses are
//! known by the name of their list of coefficients: `disto_k1`, `disto_k3`, `disto_t2` (k1, k2, k3, and OpenCV's p1, p2), `fisheye`.
//! Source: OpenMVG, `cameras` and `sfm_data_io`. Not tried with the program itself.

use std::path::Path;

use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use serde_json::Value;

use super::assembly::Assembly;
use super::foreign_text::{json_number, json_numbers, kind, read_value};
use super::format::CameraFormat;
use super::photo_paths::{Without, photo_paths};
use super::pose::{of_rows, pose_at};
use super::raw::RawCamera;
use super::recognise::{beginning, has_name, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct OpenMvg;

const USUAL_NAMES: [&str; 2] = ["sfm_data.json", "sfm_data_BA.json"];
const REMEDY: &str = "write it anew with openMVG_main_ConvertSfM_DataFormat";
const EXPECTED: &str = "expected a JSON object with lists \"views\", \"intrinsics\" and \"extrinsics\"";

impl CameraFormat for OpenMvg {
    fn accepted(&self) -> &'static str {
        "OpenMVG's sfm_data.json"
    }

    fn program(&self) -> &'static str {
        "OpenMVG"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "pinhole lenses with k1 to k3, t1, t2, and fisheye; points with observations; not tried with the program itself",
            "panoramas; priors",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        (has_name(file, &USUAL_NAMES) || is_one(&beginning(file))).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".json", &USUAL_NAMES, is_one);
        ReconstructionFiles::first_of(&found).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let whole = read_value(file, EXPECTED, REMEDY)?;
        if !whole.get("views").is_some_and(Value::is_array) {
            let found = format!("views: {}, {EXPECTED}", kind(whole.get("views")));
            return Err(Error::input(file, "", found, REMEDY));
        }
        let intrinsics: FxHashMap<u64, &Value> = pairs(&whole, "intrinsics").collect();
        let extrinsics: FxHashMap<u64, &Value> = pairs(&whole, "extrinsics").collect();
        let (mut used, mut without) = (Vec::new(), 0);
        for (key, view) in pairs(&whole, "views") {
            let view = data_of(view);
            match view.get("id_pose").and_then(Value::as_u64).and_then(|id| extrinsics.get(&id)) {
                Some(pose) => used.push((key, view, *pose)),
                None => without += 1,
            }
        }
        let path = |view: &Value| {
            let part = |key: &str| view.get(key).and_then(Value::as_str).unwrap_or_default();
            match part("local_path") {
                "" => part("filename").to_owned(),
                folder => format!("{}/{}", folder.trim_end_matches(['/', '\\']), part("filename")),
            }
        };
        let paths: Vec<String> = used.iter().map(|(_, view, _)| path(view)).collect();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let photos = photo_paths(&paths, &[folder], Without::Any);
        let mut kept: FxHashMap<u64, u32> = FxHashMap::default();
        for (done, ((key, view, pose), photo)) in used.iter().zip(&photos).enumerate() {
            task.step("read poses", done as u64, used.len() as u64)?;
            let id = view.get("id_intrinsic").and_then(Value::as_u64);
            let camera = match id.and_then(|id| intrinsics.get(&id)) {
                Some(intrinsic) => camera(data_of(intrinsic)),
                None => Err(("its intrinsic is not in the file".to_owned(), REMEDY)),
            };
            if let Some(photo) = assembly.photo(format!("view {key}"), &photo.name, camera, pose_of(pose)) {
                kept.insert(*key, photo);
            }
        }
        if without > 0 {
            let (file, all) = (file.display(), without + used.len());
            assembly.note(format!(
                "{file}: {without} of {all} views have no pose: they are not registered, and are left out"
            ));
        }
        for (key, landmark) in pairs(&whole, "structure") {
            let place = format!("structure {key}");
            let seen = pairs(landmark, "observations").filter_map(|(view, seen)| {
                let at: [f64; 2] = json_numbers(seen.get("x"), "x").ok()?;
                Some((*kept.get(&view)?, DVec2::from(at)))
            });
            match json_numbers::<3>(landmark.get("X"), "X") {
                Ok(position) => assembly.seen_point(place, key, position, seen.collect()),
                Err(objection) => assembly.point_problem(place, objection),
            }
        }
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().first() == Some(&b'{') && holds(beginning, "\"sfm_data_version\"")
}

/// Lists the pairs of key and value of a list.
fn pairs<'v>(whole: &'v Value, list: &str) -> impl Iterator<Item = (u64, &'v Value)> + use<'v> {
    let items = whole.get(list).and_then(Value::as_array).into_iter().flatten();
    items.filter_map(|item| Some((item.get("key")?.as_u64()?, item.get("value")?)))
}

/// Returns what a pointer points to.
fn data_of(value: &Value) -> &Value {
    value.get("ptr_wrapper").and_then(|wrapper| wrapper.get("data")).unwrap_or(value)
}

fn camera(data: &Value) -> Result<RawCamera, Objection> {
    // Some versions put what all lenses have one level deeper.
    let field = |key: &str| data.get(key).or_else(|| data.get("value0").and_then(|deeper| deeper.get(key)));
    let number = |key: &str| json_number(field(key), key);
    let side = |key: &str| match number(key)? {
        side if (1.0..1e9).contains(&side) && side.fract() == 0.0 => Ok(side as u64),
        side => Err((format!("{key} is {side}, expected a number of pixels"), REMEDY)),
    };
    let size = [side("width")?, side("height")?];
    let focal = match field("focal_length") {
        None => {
            return Err((
                "an intrinsic without a focal length, such as a panorama's".into(),
                "calibrate it as pinhole",
            ));
        }
        Some(_) => [number("focal_length")?; 2],
    };
    let centre = json_numbers(field("principal_point"), "principal_point")?;
    let brown = |k: [f64; 3], p: [f64; 2]| Lens::Brown { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p };
    let lens = if let Some(list) = data.get("disto_k1") {
        brown([json_numbers::<1>(Some(list), "disto_k1")?[0], 0.0, 0.0], [0.0; 2])
    } else if let Some(list) = data.get("disto_k3") {
        brown(json_numbers(Some(list), "disto_k3")?, [0.0; 2])
    } else if let Some(list) = data.get("disto_t2") {
        let [k1, k2, k3, t1, t2] = json_numbers(Some(list), "disto_t2")?;
        brown([k1, k2, k3], [t1, t2])
    } else if let Some(list) = data.get("fisheye") {
        Lens::Fisheye { k: json_numbers(Some(list), "fisheye")?, p: [0.0; 2], s: [0.0; 2] }
    } else {
        Lens::None
    };
    Ok(RawCamera { size, focal, centre, lens })
}

fn pose_of(pose: &Value) -> Result<Pose, Objection> {
    let rows = pose.get("rotation").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let mut rotation = [0.0; 9];
    if rows.len() != 3 {
        return Err((
            format!("rotation is {}, expected 3 rows of 3 numbers", kind(pose.get("rotation"))),
            REMEDY,
        ));
    }
    for (to, row) in rotation.chunks_exact_mut(3).zip(rows) {
        to.copy_from_slice(&json_numbers::<3>(Some(row), "rotation")?);
    }
    let centre: [f64; 3] = json_numbers(pose.get("center"), "center")?;
    pose_at(of_rows(&rotation), DVec3::from(centre))
}
