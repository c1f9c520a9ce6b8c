//! What is around the site in directions that no photo shows: a picture of all directions.

use glam::DVec3;

use crate::handover::folder::HandoverFolder;
use crate::handover::origin::Placement;
use quadratura_base::error::Result;
use quadratura_handover::blender::scene::SceneDome;
use quadratura_io::layer_png::rgb_png;
use quadratura_projection::dome::{Dome, DomeFrame, PENALTY};
use quadratura_view::srgb::Srgb;

/// The name of the file.
const FILE: &str = "surroundings.png";
/// The most columns of the picture.
const WIDEST: u32 = 4096;

/// Writes the dome as an equirectangular picture, and describes it. `up` is the site's up direction.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`].
pub fn write_dome(
    folder: &mut HandoverFolder,
    dome: &Dome,
    up: DVec3,
    placement: &Placement,
) -> Result<SceneDome> {
    let frame = DomeFrame::with_default_middle(up);
    let width = (4 * dome.side).min(WIDEST) / 2 * 2;
    let srgb = Srgb::tables();
    let light = dome.equirectangular(&frame, width);
    let rgb: Vec<u8> = light.iter().flatten().map(|value| srgb.encoded(*value)).collect();
    folder.write(FILE, &rgb_png([width, width / 2], &rgb))?;
    let (middle, up) = (frame.middle(), up.try_normalize().unwrap_or(DVec3::Z));
    let axes = [middle, up.cross(middle), up].map(|axis| placement.direction(axis).to_array());
    Ok(SceneDome { file: FILE.to_owned(), axes, distance: PENALTY })
}
