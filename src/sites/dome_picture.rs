//! The user's picture of what is around a site, in the place of what the photos show there.

use std::path::Path;
use std::time::UNIX_EPOCH;

use glam::{DVec2, DVec3};

use quadratura_base::error::{Error, Result};
use quadratura_base::raster::Image;
use quadratura_base::raster::bilinear::Clamped;
use quadratura_base::scene::Site;
use quadratura_base::scene::up;
use quadratura_base::task::Task;
use quadratura_document::{Project, SurroundingsPicture};
use quadratura_io::dome_picture::{read_dome_picture, recorded_middle};
use quadratura_io::project::{relative_to, resolved};
use quadratura_projection::dome::{CubeMap, Dome, DomeFrame, side_for};

/// The number of samples along both sides of a texel of the dome: pictures may be several times as fine.
const SAMPLES: u32 = 3;

/// Returns the frame of pictures of a site, with the usual middle where none is given.
pub fn frame(site: &Site, middle: Option<[f64; 3]>) -> Result<DomeFrame> {
    let up = up(&site.photos);
    let Some(middle) = middle else { return Ok(DomeFrame::with_default_middle(up)) };
    DomeFrame::new(up, DVec3::from(middle)).ok_or_else(|| {
        let [x, y, z] = middle;
        Error::Request(format!(
            "the direction {x},{y},{z} of the picture's middle points straight up or down; give one that is more level"
        ))
    })
}

/// Returns the decision for a picture after reading it, so that a wrong one is told at once. Without a given direction of
/// its middle, that which an exported picture records is taken, else the usual one, which is noted.
///
/// # Errors
/// Returns the errors of reading the picture, and [`Error::Request`] for a direction that is not level enough.
pub fn chosen_picture(
    folder: &Path,
    site: &Site,
    file: &Path,
    middle: Option<[f64; 3]>,
    task: &Task,
) -> Result<SurroundingsPicture> {
    let known = middle.or_else(|| recorded_middle(file));
    let frame = frame(site, known)?;
    read_dome_picture(file)?;
    let middle = known.unwrap_or_else(|| frame.middle().to_array());
    if known.is_none() {
        let ([x, y, z], file) = (middle, file.display());
        task.note(format!(
            "{file} does not say in which direction its middle is: it is taken to be {x},{y},{z}; --middle X,Y,Z gives \
             another one"
        ));
    }
    Ok(SurroundingsPicture { picture: relative_to(folder, file)?, middle })
}

/// Makes the dome of the project's picture; `None` where it has none.
///
/// # Errors
/// Returns the errors of reading the picture.
pub fn picture_dome(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<Option<Dome>> {
    let Some(SurroundingsPicture { picture, middle }) = &project.surroundings else { return Ok(None) };
    let frame = frame(site, Some(*middle))?;
    let side = dome_side(site);
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

/// Returns the side of a site's dome.
pub fn dome_side(site: &Site) -> u32 {
    side_for(site.photos.iter().map(|photo| &photo.camera))
}

/// Returns what says that the project's picture is still the same: its path, its direction, and the size and time
/// of its file; empty without a picture.
pub fn picture_stamp(folder: &Path, project: &Project) -> String {
    let Some(chosen) = &project.surroundings else { return String::new() };
    let metadata = std::fs::metadata(resolved(folder, &chosen.picture)).ok();
    let changed = metadata.as_ref().and_then(|file| file.modified().ok());
    let changed = changed.and_then(|at| at.duration_since(UNIX_EPOCH).ok()).map_or(0, |at| at.as_nanos());
    let length = metadata.map_or(0, |file| file.len());
    format!("{} {:?} {length} {changed}", chosen.picture, chosen.middle)
}
