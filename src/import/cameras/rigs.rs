//! Rigs and frames of COLMAP 3.12 and later: cameras that are fixed to each other, and where they were together.
//!
//! Where these files are, the pose of a photo is that of its sensor in the rig times that of the rig in the frame; COLMAP takes
//! none from `images` then, which may be older (`sensor_from_world = sensor_from_rig * rig_from_world`).

use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::str::SplitAsciiWhitespace;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::assembly::Assembly;
use super::binary::Records;
use super::lines::LineReader;
use super::photo_name::short;
use super::pose::pose_of_quaternion;
use super::text::parse;
use quadratura_base::error::Result;
use quadratura_base::geometry::Pose;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The photos that a note names.
const NAMED: usize = 5;

/// Rotations that differ by no more are the same, in degrees: text with six decimals is within it.
const SAME_DEGREES: f64 = 1e-3;

/// Positions that differ by no more are the same, as a share of how far the cameras are spread.
const SAME_SHARE: f64 = 1e-5;

/// The number of a camera among the kinds of sensors in binary files.
const CAMERA: u32 = 0;

/// The poses of the sensors that are cameras, in the rig; `None` where the file states none.
type Sensors = FxHashMap<u32, Option<Pose>>;

/// The poses of photos, by their number.
#[derive(Debug)]
pub(super) struct Rigs {
    rigs_file: PathBuf,
    frames_file: PathBuf,
    rigs: FxHashMap<u32, Sensors>,
    /// The camera and, where it is known, the pose, world to camera, of each photo.
    photos: FxHashMap<u32, (u32, Option<Pose>)>,
    compared: Vec<PoseDifference>,
    /// The photos without a pose here.
    without: Vec<String>,
}

/// How far the pose of a photo in `images` is from the one here.
#[derive(Debug)]
struct PoseDifference {
    name: String,
    degrees: f64,
    distance: f64,
    centre: DVec3,
}

/// A frame as its file has it.
struct RigFrame {
    rig: u32,
    pose: Result<Pose, Objection>,
    /// The numbers of cameras, and of their photos.
    photos: Vec<(u32, u64)>,
}

impl Rigs {
    /// Reads both files, text or binary. What is wrong with one rig or frame goes to the assembly.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] where the rest of a binary file cannot be understood; [`quadratura_base::Error::Io`];
    /// [`quadratura_base::Error::Cancelled`].
    pub fn read(rigs: &Path, frames: &Path, assembly: &mut Assembly, task: &Task) -> Result<Self> {
        let mut read = Self {
            rigs_file: rigs.to_path_buf(),
            frames_file: frames.to_path_buf(),
            rigs: FxHashMap::default(),
            photos: FxHashMap::default(),
            compared: Vec::new(),
            without: Vec::new(),
        };
        match rigs.extension().is_some_and(|extension| extension == "bin") {
            true => read.binary(assembly, task)?,
            false => read.text(assembly, task)?,
        }
        Ok(read)
    }

    fn text(&mut self, assembly: &mut Assembly, task: &Task) -> Result<()> {
        let (rigs, frames) = (self.rigs_file.clone(), self.frames_file.clone());
        let mut lines = LineReader::open(&rigs)?;
        while lines.next_record("read rigs", task)? {
            match rig_of_line(&lines.text()) {
                Ok((id, sensors)) => drop(self.rigs.insert(id, sensors)),
                Err(objection) => assembly.problem(&rigs, lines.place(), objection),
            }
        }
        let mut lines = LineReader::open(&frames)?;
        while lines.next_record("read frames", task)? {
            let taken = frame_of_line(&lines.text()).and_then(|frame| self.take(frame));
            if let Err(objection) = taken {
                assembly.problem(&frames, lines.place(), objection);
            }
        }
        Ok(())
    }

    fn binary(&mut self, assembly: &mut Assembly, task: &Task) -> Result<()> {
        let (rigs, frames) = (self.rigs_file.clone(), self.frames_file.clone());
        let mut file = Records::open(&rigs)?;
        for done in 0..file.count(8)? {
            task.step("read rigs", done, file.total())?;
            let place = file.place();
            let (id, sensors) = rig_of_record(&mut file)?;
            match sensors {
                Ok(sensors) => drop(self.rigs.insert(id, sensors)),
                Err(objection) => assembly.problem(&rigs, place, objection),
            }
        }
        let mut file = Records::open(&frames)?;
        for done in 0..file.count(68)? {
            task.step("read frames", done, file.total())?;
            let place = file.place();
            let frame = frame_of_record(&mut file)?;
            if let Err(objection) = self.take(frame) {
                assembly.problem(&frames, place, objection);
            }
        }
        Ok(())
    }

    /// Takes the photos of a frame.
    fn take(&mut self, frame: RigFrame) -> Result<(), Objection> {
        let RigFrame { rig, pose, photos } = frame;
        let sensors = self.rigs.get(&rig).ok_or_else(|| {
            (
                format!("a frame of rig {rig}, which is not in the rigs file"),
                "use files of the same reconstruction",
            )
        })?;
        let rig_from_world = pose?;
        let mut twice = None;
        for (camera, photo) in photos {
            let Ok(photo) = u32::try_from(photo) else { continue };
            let sensor_from_rig = sensors.get(&camera).copied().flatten();
            let pose = sensor_from_rig.map(|sensor_from_rig| Pose {
                rotation: sensor_from_rig.rotation * rig_from_world.rotation,
                translation: sensor_from_rig.rotation * rig_from_world.translation
                    + sensor_from_rig.translation,
            });
            match self.photos.entry(photo) {
                Entry::Occupied(_) => twice = Some(photo),
                Entry::Vacant(free) => _ = free.insert((camera, pose)),
            }
        }
        let again = |photo| (format!("photo {photo} is in two frames"), "keep one; the first is used");
        twice.map_or(Ok(()), |photo| Err(again(photo)))
    }

    /// Returns the pose of a photo, for which `images` has another or the same one.
    pub fn pose_of(
        &mut self,
        id: u32,
        name: &str,
        camera: u32,
        stated: Result<Pose, Objection>,
    ) -> Result<Pose, Objection> {
        let Some(&(_, Some(pose))) = self.photos.get(&id).filter(|(of, _)| *of == camera) else {
            self.without.push(short(name));
            return stated;
        };
        let centre = centre_of(&pose);
        let (degrees, distance) = match stated {
            Ok(stated) => (degrees_between(&pose, &stated), centre.distance(centre_of(&stated))),
            Err(_) => (0.0, 0.0),
        };
        self.compared.push(PoseDifference { name: short(name), degrees, distance, centre });
        Ok(pose)
    }

    /// Returns what the user should know about both files.
    pub fn notes(mut self, images: &Path) -> Vec<String> {
        let images = images.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let names = |names: Vec<String>| {
            let more = names.len().saturating_sub(NAMED);
            let named = names.into_iter().take(NAMED).collect::<Vec<_>>().join(", ");
            if more > 0 { format!("{named} and {more} more") } else { named }
        };
        let spread = |axis: usize| {
            let of = self.compared.iter().map(|it| it.centre[axis]);
            of.clone().fold(f64::NEG_INFINITY, f64::max) - of.fold(f64::INFINITY, f64::min)
        };
        let spread = [0, 1, 2].map(spread).into_iter().fold(0.0, f64::max);
        let total = self.compared.len();
        self.compared.retain(|it| it.degrees > SAME_DEGREES || it.distance > SAME_SHARE * spread);
        self.compared.sort_by(|a, b| b.degrees.total_cmp(&a.degrees).then(b.distance.total_cmp(&a.distance)));
        let mut notes = Vec::new();
        let file = self.frames_file.display();
        if !self.compared.is_empty() {
            let by = |it: &PoseDifference| {
                format!("{} by {:.3} degrees and {:.4} units", it.name, it.degrees, it.distance)
            };
            let by = names(self.compared.iter().map(by).collect());
            notes.push(format!(
                "{file}: {} of {total} photos {} another pose in {images} ({by}); the poses of rigs and frames are \
                 used, as COLMAP does",
                self.compared.len(),
                if self.compared.len() == 1 { "has" } else { "have" }
            ));
        }
        if !self.without.is_empty() {
            let (count, listed) = (self.without.len(), names(std::mem::take(&mut self.without)));
            notes.push(format!(
                "{file}: no pose from rigs and frames for {count} of the photos ({listed}); those in {images} are used"
            ));
        }
        notes
    }
}

fn centre_of(pose: &Pose) -> DVec3 {
    -(pose.rotation.transpose() * pose.translation)
}

/// Returns the angle between two rotations, by their distance, which is exact for small ones.
fn degrees_between(a: &Pose, b: &Pose) -> f64 {
    let difference = (a.rotation - b.rotation).to_cols_array();
    let distance = difference.iter().map(|value| value * value).sum::<f64>().sqrt();
    2.0 * (distance / 8.0f64.sqrt()).min(1.0).asin().to_degrees()
}

const WRONG_COUNT: &str = "write as many sensors or data as the line announces";

/// `RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID`, then `SENSOR_TYPE SENSOR_ID HAS_POSE` and, where it is 1, `QW QX QY QZ TX
/// TY TZ`, for each other sensor.
fn rig_of_line(line: &str) -> Result<(u32, Sensors), Objection> {
    let mut fields = line.split_ascii_whitespace();
    let id = parse(fields.next(), "RIG_ID")?;
    let count: u64 = parse(fields.next(), "NUM_SENSORS")?;
    let mut sensors = Sensors::default();
    for number in 0..count {
        let is_camera = is_camera(fields.next(), count)?;
        let sensor: u32 = parse(fields.next(), "SENSOR_ID")?;
        let pose = match number {
            // The first is the reference, whose frame is the rig's.
            0 => Some(UNMOVED),
            _ if parse::<u8>(fields.next(), "HAS_POSE")? == 0 => None,
            _ => Some(pose_of_fields(&mut fields)?),
        };
        if is_camera {
            sensors.insert(sensor, pose);
        }
    }
    no_more(fields, count)?;
    Ok((id, sensors))
}

/// `FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA_IDS`, then `SENSOR_TYPE SENSOR_ID DATA_ID` for each.
fn frame_of_line(line: &str) -> Result<RigFrame, Objection> {
    let mut fields = line.split_ascii_whitespace();
    let _: u64 = parse(fields.next(), "FRAME_ID")?;
    let rig = parse(fields.next(), "RIG_ID")?;
    let pose = pose_of_fields(&mut fields)?;
    let count: u64 = parse(fields.next(), "NUM_DATA_IDS")?;
    let mut photos = Vec::new();
    for _ in 0..count {
        let is_camera = is_camera(fields.next(), count)?;
        let data = (parse(fields.next(), "SENSOR_ID")?, parse(fields.next(), "DATA_ID")?);
        photos.extend(is_camera.then_some(data));
    }
    no_more(fields, count)?;
    Ok(RigFrame { rig, pose: Ok(pose), photos })
}

fn no_more(mut fields: SplitAsciiWhitespace, count: u64) -> Result<(), Objection> {
    let more =
        fields.next().map(|field| (format!("{} after the {count} announced", short(field)), WRONG_COUNT));
    more.map_or(Ok(()), Err)
}

fn is_camera(field: Option<&str>, count: u64) -> Result<bool, Objection> {
    match field {
        Some("CAMERA") => Ok(true),
        Some(kind) if kind.parse::<f64>().is_err() => Ok(false),
        Some(number) => {
            Err((format!("{} where SENSOR_TYPE should be", short(number)), "write CAMERA or IMU there"))
        }
        None => Err((format!("fewer than the {count} announced"), WRONG_COUNT)),
    }
}

const UNMOVED: Pose = Pose { rotation: glam::DMat3::IDENTITY, translation: DVec3::ZERO };

fn pose_of_fields(fields: &mut SplitAsciiWhitespace) -> Result<Pose, Objection> {
    let mut values = [0.0; 7];
    for (value, name) in values.iter_mut().zip(["QW", "QX", "QY", "QZ", "TX", "TY", "TZ"]) {
        *value = parse(fields.next(), name)?;
    }
    pose_of_values(values)
}

fn pose_of_values([w, x, y, z, tx, ty, tz]: [f64; 7]) -> Result<Pose, Objection> {
    pose_of_quaternion([w, x, y, z], [tx, ty, tz])
}

type SensorsRead = Result<Sensors, Objection>;

/// A rig of the binary file: numbers as in the text, in 32 bits, but `HAS_POSE` in 8 and the pose in 64 each.
fn rig_of_record(file: &mut Records) -> Result<(u32, SensorsRead)> {
    let (id, count) = (file.u32()?, file.u32()?);
    let mut sensors = Ok(Sensors::default());
    for number in 0..count {
        let (kind, sensor) = (file.u32()?, file.u32()?);
        let pose = match number {
            0 => Ok(Some(UNMOVED)),
            _ if file.u8()? == 0 => Ok(None),
            _ => pose_of_values(values(file)?).map(Some),
        };
        match (pose, &mut sensors) {
            (Ok(pose), Ok(sensors)) if kind == CAMERA => drop(sensors.insert(sensor, pose)),
            (Err(objection), Ok(_)) => sensors = Err(objection),
            _ => {}
        }
    }
    Ok((id, sensors))
}

/// A frame of the binary file: numbers as in the text, in 32 bits, but `DATA_ID` and the pose in 64 each.
fn frame_of_record(file: &mut Records) -> Result<RigFrame> {
    let (_, rig) = (file.u32()?, file.u32()?);
    let pose = pose_of_values(values(file)?);
    let mut photos = Vec::new();
    for _ in 0..file.u32()? {
        let (kind, sensor, data) = (file.u32()?, file.u32()?, file.u64()?);
        photos.extend((kind == CAMERA).then_some((sensor, data)));
    }
    Ok(RigFrame { rig, pose, photos })
}

fn values(file: &mut Records) -> Result<[f64; 7]> {
    let mut values = [0.0; 7];
    for value in &mut values {
        *value = file.f64()?;
    }
    Ok(values)
}

#[cfg(test)]
mod tests;
