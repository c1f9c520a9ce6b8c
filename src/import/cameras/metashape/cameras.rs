//! The cameras of a chunk: their names, sensors and poses.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DMat3, DMat4, DVec3};
use roxmltree::{Document, Node};

use super::super::assembly::Assembly;
use super::super::foreign_text::{child, children, number, numbers, parse_xml};
use super::super::photo_paths::{Without, photo_paths};
use super::super::pose::{pose_at, rotation_and_scale};
use super::archive::document_of;
use super::sensor::{Sensor, sensor};
use super::shutter::{Motion, Shutters, UnreadableMotion};
use super::{Chunk, REMEDY, markers};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pose;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// Returns the cameras of a chunk, those in groups, too.
pub(super) fn cameras_in<'a, 'i>(chunk: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let cameras = child(chunk, "cameras").into_iter().flat_map(|all| all.descendants());
    cameras.filter(|node| node.has_tag_name("camera"))
}

pub(super) fn is_aligned(camera: Node<'_, '_>) -> bool {
    child(camera, "transform").is_some()
}

fn is_disabled(camera: Node<'_, '_>) -> bool {
    matches!(camera.attribute("enabled"), Some("0" | "false" | "no"))
}

/// A camera that is aligned, with what its chunk knows about it.
struct Aligned<'a> {
    id: &'a str,
    place: String,
    /// The path of its photo, or its label.
    path: &'a str,
    sensor: &'a str,
    pose: Result<(Pose, f64), Objection>,
    motion: Result<Option<Motion>, UnreadableMotion>,
}

/// The numbers of cameras that are left out, by reason.
#[derive(Default)]
struct LeftOut {
    not_aligned: usize,
    disabled: usize,
    of_rigs: usize,
}

/// Reads the cameras and markers of a chunk.
///
/// # Errors
/// What cannot be read of the frame's archive; [`quadratura_base::Error::Cancelled`].
pub(super) fn read(
    file: &Path,
    chunk: &Chunk<'_, '_>,
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<()> {
    let frame_text = chunk.source.frame.as_deref().map(document_of).transpose()?;
    let frame: Option<Document<'_>> = match (&frame_text, &chunk.source.frame) {
        (Some(text), Some(file)) => Some(parse_xml(file, text, REMEDY)?),
        _ => None,
    };
    let paths = frame.as_ref().map(photos_of_frame).unwrap_or_default();
    let sensors: BTreeMap<&str, Sensor> = child(chunk.node, "sensors")
        .into_iter()
        .flat_map(|all| children(all, "sensor"))
        .map(|node| (node.attribute("id").unwrap_or_default(), sensor(node)))
        .collect();
    let mut left_out = LeftOut::default();
    let aligned = aligned_cameras(chunk.node, &paths, &sensors, &mut left_out);
    left_out.tell(file, chunk.cameras[0], assembly);
    let written: Vec<&str> = aligned.iter().map(|camera| camera.path).collect();
    // The paths of photos are relative to the archive of the frame, as if it were a folder.
    let photos = photo_paths(&written, &[chunk.source.frame.clone().unwrap_or_default()], Without::Any);
    let mut kept: BTreeMap<&str, u32> = BTreeMap::new();
    let mut shutters = Shutters::default();
    for (done, (camera, photo)) in aligned.iter().zip(&photos).enumerate() {
        task.step("read poses", done as u64, aligned.len() as u64)?;
        let of_sensor = match sensors.get(camera.sensor) {
            Some(Sensor::Camera(of_sensor)) => of_sensor.clone(),
            _ => Err((format!("its sensor {:?} is not in the chunk", camera.sensor), REMEDY)),
        };
        let (pose, scale) = match &camera.pose {
            Ok((pose, scale)) => (Ok(*pose), *scale),
            Err(objection) => (Err(objection.clone()), 1.0),
        };
        if let Some(index) = assembly.photo(camera.place.clone(), &photo.name, of_sensor, pose) {
            kept.insert(camera.id, index);
            shutters.add(index, camera.motion, scale);
        }
    }
    let frame = frame.as_ref().map(Document::root_element);
    if !shutters.is_empty() {
        let depths = markers::depths(chunk.node, frame, &kept, assembly);
        shutters.apply(file, &depths, assembly);
    }
    // Once more, with the motions taken out of the photos.
    markers::read(chunk.node, frame, &kept, assembly);
    tell_of_place(file, chunk.node, assembly);
    Ok(())
}

/// Returns the paths of the photos that a frame holds, by the number of their camera.
fn photos_of_frame<'a>(frame: &'a Document<'_>) -> BTreeMap<&'a str, &'a str> {
    let cameras = child(frame.root_element(), "cameras").into_iter().flat_map(|all| children(all, "camera"));
    let named = cameras.filter_map(|camera| {
        Some((camera.attribute("camera_id")?, child(camera, "photo")?.attribute("path")?))
    });
    named.collect()
}

fn aligned_cameras<'a>(
    chunk: Node<'a, '_>,
    paths: &BTreeMap<&'a str, &'a str>,
    sensors: &BTreeMap<&str, Sensor>,
    left_out: &mut LeftOut,
) -> Vec<Aligned<'a>> {
    let world = child(chunk, "transform").map_or(Ok(DMat4::IDENTITY), transform);
    let components: BTreeMap<&str, Result<DMat4, Objection>> = child(chunk, "components")
        .into_iter()
        .flat_map(|all| children(all, "component"))
        .filter_map(|node| Some((node.attribute("id")?, child(node, "transform").map(transform)?)))
        .collect();
    let mut aligned = Vec::new();
    for node in cameras_in(chunk) {
        let (id, sensor) = (attribute(node, "id"), attribute(node, "sensor_id"));
        let Some(of_camera) = child(node, "transform") else {
            left_out.not_aligned += 1;
            continue;
        };
        if is_disabled(node) {
            left_out.disabled += 1;
            continue;
        }
        if node.attribute("master_id").is_some_and(|master| master != id)
            || matches!(sensors.get(sensor), Some(Sensor::OfRig))
        {
            left_out.of_rigs += 1;
            continue;
        }
        let component = match components.get(attribute(node, "component_id")) {
            Some(component) => component.clone(),
            None => Ok(DMat4::IDENTITY),
        };
        let pose = world.clone().and_then(|world| {
            let chunk_from_camera = matrix(of_camera.text().unwrap_or_default())?;
            pose(world * component?, chunk_from_camera)
        });
        let path = paths.get(id).copied().unwrap_or_else(|| attribute(node, "label"));
        let place = format!("camera {id}");
        aligned.push(Aligned { id, place, path, sensor, pose, motion: Motion::of(node) });
    }
    aligned
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> &'a str {
    node.attribute(name).unwrap_or_default()
}

/// Returns the pose, world to camera, and the scale of the world, by which lengths in the chunk are multiplied.
fn pose(world_from_chunk: DMat4, chunk_from_camera: DMat4) -> Result<(Pose, f64), Objection> {
    let world_from_camera = world_from_chunk * chunk_from_camera;
    let (rotation, scale) = rotation_and_scale(DMat3::from_mat4(world_from_camera), "its transform")?;
    Ok((pose_at(rotation.transpose(), world_from_camera.w_axis.truncate())?, scale))
}

/// Reads the transform of a chunk or component: 16 numbers, or elements `rotation`, `translation` and `scale`, each of which may be
/// missing.
fn transform(node: Node<'_, '_>) -> Result<DMat4, Objection> {
    let text = |name: &str| child(node, name).map(|node| node.text().unwrap_or_default());
    if ["rotation", "translation", "scale"].iter().all(|name| text(name).is_none()) {
        let whole = node.text().unwrap_or_default();
        return if whole.trim().is_empty() { Ok(DMat4::IDENTITY) } else { matrix(whole) };
    }
    let rotation = match text("rotation") {
        Some(text) => DMat3::from_cols_array(&numbers::<9>(text, "the rotation of the chunk")?).transpose(),
        None => DMat3::IDENTITY,
    };
    let translation = match text("translation") {
        Some(text) => DVec3::from(numbers::<3>(text, "the translation of the chunk")?),
        None => DVec3::ZERO,
    };
    let scale = text("scale").map_or(Ok(1.0), |text| number(text, "the scale of the chunk"))?;
    Ok(DMat4::from_translation(translation) * DMat4::from_mat3(rotation * scale))
}

/// Reads a matrix of 16 numbers, by rows.
fn matrix(text: &str) -> Result<DMat4, Objection> {
    let matrix = DMat4::from_cols_array(&numbers::<16>(text, "its transform")?).transpose();
    if matrix.row(3) != glam::DVec4::W {
        let found =
            format!("its transform ends with the row {:?}, expected 0, 0, 0, 1", matrix.row(3).to_array());
        return Err((found, REMEDY));
    }
    Ok(matrix)
}

impl LeftOut {
    fn tell(&self, file: &Path, all: usize, assembly: &mut Assembly<'_>) {
        let file = file.display();
        for (count, why) in [
            (self.not_aligned, "are not aligned"),
            (self.disabled, "are disabled"),
            (self.of_rigs, "belong to a rig (a sensor with a master), which is not read"),
        ] {
            if count > 0 {
                assembly.note(format!("{file}: {count} of {all} cameras {why}, and are left out"));
            }
        }
    }
}

/// Tells where the world may not be what the user expects: components that nothing joins, and geocentric coordinates.
fn tell_of_place(file: &Path, chunk: Node<'_, '_>, assembly: &mut Assembly<'_>) {
    let used = |node: &Node<'_, '_>| is_aligned(*node) && !is_disabled(*node);
    let mut components: Vec<&str> =
        cameras_in(chunk).filter(used).filter_map(|node| node.attribute("component_id")).collect();
    components.sort_unstable();
    components.dedup();
    if components.len() > 1 {
        let (file, count) = (file.display(), components.len());
        assembly.note(format!(
            "{file}: the cameras are of {count} components, which fit each other only if each of them has references"
        ));
    }
    let is_geographic = child(chunk, "reference").and_then(|node| node.text()).is_some_and(|text| {
        text.trim_start().starts_with("GEOGCS") || text.trim_start().starts_with("PROJCS")
    });
    if is_geographic && child(chunk, "transform").is_some() {
        let file: PathBuf = file.to_path_buf();
        assembly.note(format!(
            "{}: the chunk is georeferenced, and its cameras are in geocentric coordinates (metres from the centre of the \
             earth); the model must be in the same, not in the projected coordinates of an export",
            file.display()
        ));
    }
}
