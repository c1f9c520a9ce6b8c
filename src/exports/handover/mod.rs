//! Export to the formats of other programs: the plain data that their writers in `quadratura-handover` need is collected from the
//! project, and written to one folder with relative paths.
//!
//! To add a format: a value of [`HandoverFormat`] with its row in the table, a file here that collects its data, and an arm in
//! [`hand_over`]. The rules for all formats are in [`folder`] (nothing that a user changed is overwritten) and [`origin`] (one
//! local origin).

pub mod baked;
pub mod blender;
mod cameras;
pub mod folder;
pub mod format;
pub mod live;
mod nuke;
mod openexr;
pub mod origin;
mod photos;
mod points;
#[cfg(test)]
mod tests;

use std::path::Path;

pub use folder::HandedOver;
pub use format::HandoverFormat;

use self::baked::{BakedFormat, BakedOptions};
use self::folder::HandoverFolder;
use self::origin::Placement;
use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_layers::device::SiteDevice;
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::Opened;

/// How many photos a face gets in Blender at most: more are hardly seen, and cost memory and time.
pub const PHOTOS_PER_FACE: usize = 8;

/// Options of [`hand_over`].
#[derive(Debug, Clone, PartialEq)]
pub struct HandoverOptions {
    /// The format.
    pub format: HandoverFormat,
    /// How many photos a face gets at most, where the format projects photos; they are chosen so that their directions spread.
    pub photos_per_face: usize,
    /// How models with textures are baked.
    pub baked: BakedOptions,
    /// Whether coordinates are those of the cameras' world although the site has a frame.
    pub world: bool,
    /// The approximate memory budget in bytes for photos processed at the same time; at least one is processed.
    pub memory: u64,
}

impl Default for HandoverOptions {
    /// Blender, with as many photos per face as are seen.
    fn default() -> Self {
        Self {
            format: HandoverFormat::Blender,
            photos_per_face: PHOTOS_PER_FACE,
            baked: BakedOptions::default(),
            world: false,
            memory: default_memory(),
        }
    }
}

/// Writes the site with these photos, in the site's order, from the project in the folder `project` to the folder `out`. `start_device` starts the
/// device that draws, for formats that need one.
///
/// # Errors
/// Returns [`quadratura_base::Error::Request`] for a folder of the project's own and for one with an export of another project, the errors of reading photos
/// and stacks, [`quadratura_base::Error::Io`], or [`quadratura_base::Error::Cancelled`].
pub fn hand_over(
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    out: &Path,
    options: &HandoverOptions,
    start_device: &dyn Fn() -> Result<Box<dyn SiteDevice>>,
    task: &Task,
) -> Result<HandedOver> {
    let state = if options.format.is_live() { Some(live::state(project, photos)?) } else { None };
    let placement = &Placement::new(&opened.site, &opened.project.frame, !options.world);
    let mut folder = HandoverFolder::open(project, out, options.format, placement)?;
    let mut baked = None;
    let mut bake = |format: BakedFormat| -> Result<()> {
        let options = BakedOptions { format, ..options.baked.clone() };
        let device = start_device()?;
        baked =
            Some(baked::write(&mut folder, project, opened, photos, placement, &options, &*device, task)?);
        Ok(())
    };
    match options.format {
        HandoverFormat::Glb => bake(BakedFormat::Glb)?,
        HandoverFormat::Obj => bake(BakedFormat::Obj)?,
        HandoverFormat::Usd => bake(BakedFormat::Usd)?,
        HandoverFormat::Blender => {
            blender::write(&mut folder, project, opened, photos, placement, options, task)?
        }
        HandoverFormat::Exr => openexr::write(&mut folder, project, opened, photos, placement, task)?,
        HandoverFormat::Nuke => nuke::write(&mut folder, project, opened, photos, placement, options, task)?,
        HandoverFormat::Cameras => cameras::write(&mut folder, project, opened, photos, placement, task)?,
    }
    let done = folder.finish(task)?;
    if let Some(state) = state {
        live::remember(project, opened, photos, out, options, state)?;
    }
    Ok(HandedOver { baked, ..done })
}
