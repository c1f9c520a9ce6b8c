//! Pictures of what is around a site: the dome as an equirectangular picture, and the user's own instead of it.

use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::budget::default_memory;
use super::gains::photo_gains;
use super::open::Opened;
use super::surroundings::{SiteSurroundings, dome_side};
use super::views::up;
use crate::document::{Project, Stack, SurroundingsPicture};
use crate::error::{Error, Remedy, Result};
use crate::io::dome_picture::{is_writable, read_dome_picture, write_dome_picture};
use crate::io::project::{relative_to, resolved};
use crate::io::stack_store::StackStore;
use crate::io::writable::check_beside;
use crate::projection::dome::{CubeMap, Dome, DomeFrame};
use crate::raster::Image;
use crate::raster::bilinear::Clamped;
use crate::scene::{Photo, Site};
use crate::task::Task;

/// The number of samples along both sides of a texel of the dome: pictures may be several times as fine.
const SAMPLES: u32 = 3;

/// What is known of a project's surroundings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DomeReport {
    /// The number of photos with a layer of the surroundings.
    pub photos: usize,
    /// The share of all directions that a photo shows, or the user's picture, 0..=1; `None` where there is no dome.
    pub known: Option<f64>,
    /// The user's picture.
    pub picture: Option<SurroundingsPicture>,
    /// Whether that picture is shown: it can be read.
    pub picture_used: bool,
    /// The file that was written.
    pub exported: Option<PathBuf>,
}

/// A request to write the dome as a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DomeExport {
    /// The file: `.png` or `.hdr`, which must not exist.
    pub file: PathBuf,
    /// The width in pixels; `None` for that of the dome.
    pub width: Option<u32>,
    /// The direction of the middle; `None` for the usual one.
    pub middle: Option<[f64; 3]>,
}

/// Reports a project's surroundings and writes them as a picture where that is asked for.
///
/// # Errors
/// Returns [`Error::Request`] when there is no dome to export, for a file that exists or has another extension, and
/// for a direction that is not level enough; otherwise the errors of [`SiteSurroundings::open`], and [`Error::Io`].
pub fn dome_report(
    folder: &Path,
    opened: &Opened,
    export: Option<&DomeExport>,
    task: &Task,
) -> Result<DomeReport> {
    if let Some(DomeExport { file, .. }) = export {
        check_target(file)?;
    }
    let site = &opened.site;
    let store = StackStore::new(folder);
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten();
    let stacks: Vec<Option<Stack>> = site.photos.iter().map(stack).collect();
    let is_built = stacks.iter().any(Option::is_some);
    if !is_built && opened.project.surroundings.is_none() && export.is_some() {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    let memory = default_memory();
    let gains = photo_gains(site, &stacks, &opened.project.colour, folder, memory, task)?;
    let around = SiteSurroundings::open(folder, opened, &stacks, &gains, memory, task)?;
    let dome = around.whole().dome.as_deref();
    let mut report = DomeReport {
        photos: stacks.iter().flatten().filter(|stack| stack.surroundings().is_some()).count(),
        known: dome.map(Dome::known_share),
        picture: opened.project.surroundings.clone(),
        picture_used: around.uses_picture(),
        exported: None,
    };
    if let Some(DomeExport { file, width, middle }) = export {
        let dome = dome.ok_or_else(|| Error::Request(NOTHING.into()))?;
        let frame = frame(site, *middle)?;
        let width = width.unwrap_or(4 * dome.side) / 2 * 2;
        task.timed("export", || write_dome_picture(file, width, &dome.equirectangular(&frame, width)))?;
        report.exported = Some(file.clone());
    }
    Ok(report)
}

/// What is told where there is nothing to export.
const NOTHING: &str = "there is nothing around the model to export: no photo shows anything where no surface is, and no \
                       picture is set; --set FILE sets one";

/// Refuses files that exist, formats that are not written, and places where no file can be made.
///
/// # Errors
/// Returns [`Error::Request`], or the errors of [`check_beside`].
pub fn check_target(file: &Path) -> Result<()> {
    let name = file.display();
    if !is_writable(file) {
        let found = format!("{name}: the picture can be written as .png or .hdr; give such a name");
        return Err(Error::Request(found));
    }
    if file.exists() {
        return Err(Error::Request(format!("{name} exists and is not overwritten; give another name")));
    }
    check_beside(file)
}

/// Returns the frame of pictures of a site, with the usual middle where none is given.
fn frame(site: &Site, middle: Option<[f64; 3]>) -> Result<DomeFrame> {
    let up = up(&site.photos);
    let Some(middle) = middle else { return Ok(DomeFrame::with_default_middle(up)) };
    DomeFrame::new(up, DVec3::from(middle)).ok_or_else(|| {
        let [x, y, z] = middle;
        Error::Request(format!(
            "the direction {x},{y},{z} of the picture's middle points straight up or down; give one that is more level"
        ))
    })
}

/// Returns the decision for a picture after reading it, so that a wrong one is told at once.
///
/// # Errors
/// Returns the errors of reading the picture, and [`Error::Request`] for a direction that is not level enough.
pub fn chosen_picture(
    folder: &Path,
    site: &Site,
    file: &Path,
    middle: Option<[f64; 3]>,
) -> Result<SurroundingsPicture> {
    let frame = frame(site, middle)?;
    read_dome_picture(file)?;
    let middle = middle.unwrap_or_else(|| frame.middle().to_array());
    Ok(SurroundingsPicture { picture: relative_to(folder, file)?, middle })
}

/// Makes the dome of the project's picture; `None` where it has none.
///
/// # Errors
/// Returns the errors of reading the picture.
pub(super) fn picture_dome(folder: &Path, opened: &Opened, task: &Task) -> Result<Option<Dome>> {
    let Some(SurroundingsPicture { picture, middle }) = &opened.project.surroundings else { return Ok(None) };
    let frame = frame(&opened.site, Some(*middle))?;
    let side = dome_side(&opened.site);
    let picture = task.timed("read picture", || read_dome_picture(&resolved(folder, picture)))?;
    let value = |towards: DVec3| (light(&picture, &frame, towards, side), 1.0);
    Ok(Some(Dome::from_light(&CubeMap::from_directions(side as usize, value))))
}

/// Returns the mean light of a picture over a texel of a dome of this side.
fn light(picture: &Image<[f32; 3]>, frame: &DomeFrame, towards: DVec3, side: u32) -> [f32; 3] {
    let (size, across) = (picture.size(), towards.normalize().any_orthonormal_vector());
    let down = towards.normalize().cross(across);
    let whole = DVec2::new(size[0] as f64, size[1] as f64);
    let mut sum = [0.0; 3];
    for (i, k) in (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |k| (i, k))) {
        let offset = |at: u32| ((f64::from(at) + 0.5) / f64::from(SAMPLES) - 0.5) * 2.0 / f64::from(side);
        let at = frame.position(towards + across * offset(i) + down * offset(k)) * whole;
        let between = Clamped::new(at, size);
        let pixel = |x: usize, y: usize| picture.pixels()[y * size[0] + x];
        (0..3).for_each(|c| sum[c] += between.mix(|x, y| pixel(x, y)[c]));
    }
    sum.map(|sum| sum / (SAMPLES * SAMPLES) as f32)
}

/// Returns what says that the project's picture is still the same: its path, its direction, and the size and time
/// of its file; empty without a picture.
pub(super) fn picture_stamp(folder: &Path, project: &Project) -> String {
    let Some(chosen) = &project.surroundings else { return String::new() };
    let metadata = std::fs::metadata(resolved(folder, &chosen.picture)).ok();
    let changed = metadata.as_ref().and_then(|file| file.modified().ok());
    let changed = changed.and_then(|at| at.duration_since(UNIX_EPOCH).ok()).map_or(0, |at| at.as_nanos());
    let length = metadata.map_or(0, |file| file.len());
    format!("{} {:?} {length} {changed}", chosen.picture, chosen.middle)
}
