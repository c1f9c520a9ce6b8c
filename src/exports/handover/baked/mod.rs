//! `--format glb`, `obj` and `usd`: the model with one set of textures that does not depend on the view.
//!
//! Each chart is drawn by the renderer of views itself, from straight in front and so far away that the picture is an orthographic one: so
//! angles are those to the face's normal, and octaves are against the chart's density. See-through faces and cards get pages with alpha.
//!
//! | module | contents |
//! |---|---|
//! | [`options`] | what is wanted |
//! | `parts` | the faces of the model with the side that is shown, and cards of turning billboards |
//! | `detail` | pixels per unit of the photos on charts |
//! | `camera` | the view of a chart |
//! | `layout` | charts with densities, on pages |
//! | `painter` | the texels of a chart |
//! | `pages` | pages of charts, and the map of what is known |
//! | `page_texels` | texels of pages, with padding |
//! | `assemble` | faces with texture coordinates |
//! | [`report`] | numbers about the result |

mod assemble;
mod camera;
mod detail;
mod layout;
pub mod options;
mod page_texels;
mod pages;
mod painter;
mod parts;
pub mod report;

use std::path::Path;

pub use self::options::{BakedFormat, BakedOptions, Density};
use glam::DVec3;
pub use quadratura_handover::textured::obj::UpAxis;

use self::layout::Layout;
use self::options::NAME;
use self::pages::BakedPage;
use self::painter::Painter;
use self::parts::Parts;
use self::report::{BakedReport, Coverage};
use super::folder::HandoverFolder;
use super::origin::Placement;
use super::photos::{camera_of, linked};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId, up};
use quadratura_base::task::Task;
use quadratura_handover::camera::HandoverCamera;
use quadratura_handover::textured::obj::obj;
use quadratura_handover::textured::usd::usd;
use quadratura_handover::textured::{TexturedModel, WrittenFile, glb::glb};
use quadratura_layers::device::SiteDevice;
use quadratura_projection::TextureOptions;
use quadratura_sites::open::Opened;
use quadratura_views::preview::{self, PreviewOptions};

/// The program's name in files.
const GENERATOR: &str = concat!("Quadratura ", env!("CARGO_PKG_VERSION"));

/// The least cosine between the cameras' mean up direction and an axis of the world that is taken for what is up in its place: nobody holds
/// cameras level to the degree.
const NEARLY_AXIS: f64 = 0.94;

/// A baked model: files of its format, and what there is to say about it.
#[derive(Debug)]
pub struct Baked {
    /// The files.
    pub files: Vec<WrittenFile>,
    /// What was not baked and why, in sentences.
    pub left_out: Vec<String>,
    /// Numbers about it.
    pub report: BakedReport,
}

/// Bakes the site with these photos (indices in the site) as the project in the folder `project` shows it. `cameras` are those that a USD stage gets. Positions are those of the files.
///
/// # Errors
/// Returns the errors of [`preview::open`], [`Error::Request`] when no face has an area, or [`Error::Cancelled`].
#[allow(clippy::too_many_arguments, reason = "what a format gets, and the device")]
pub fn bake(
    project: &Path,
    opened: &Opened,
    photos: &[PhotoId],
    cameras: &[HandoverCamera],
    placement: &Placement,
    options: &BakedOptions,
    device: &dyn SiteDevice,
    task: &Task,
) -> Result<Baked> {
    let site = &opened.site;
    let textures = TextureOptions::within(options.memory);
    let look = PreviewOptions { filled: !options.holes, textures, ..PreviewOptions::default() };
    let mut preview = preview::open(project, &opened.project, site, device, &look, task)?;
    let up = snapped(up(&site.photos));
    let parts = Parts::new(&site.model, preview.sources(), photos, up);
    if parts.faces.is_empty() {
        return Err(Error::Request("the model has no face with an area, so there is nothing to bake".into()));
    }
    let layout = task.timed("lay out charts", || Layout::new(&parts, preview.sources(), photos, options));
    let without = site.photo_ids().filter(|photo| !photos.contains(photo)).collect();
    let mut painter =
        Painter { preview: &mut preview, parts: &parts, without, holes: options.holes, coarser: 0 };
    let (mut pages, mut coverage) = (Vec::new(), Coverage::default());
    for page in 0..layout.pages.len() {
        let baked = BakedPage::new(&layout, page, &mut painter, options, task)?;
        coverage.add(&baked.coverage);
        pages.push(baked);
    }
    let mut left_out = parts.left_out.clone();
    left_out.extend(layout.left_out.iter().cloned());
    if painter.coarser > 0 {
        let charts =
            if painter.coarser == 1 { "1 chart".into() } else { format!("{} charts", painter.coarser) };
        left_out.push(format!("the finest pixels of photos on {charts}: {}", preview::MORE_MEMORY));
    }
    if !opened.project.trees.is_empty() {
        left_out.push("trees, which are no textured faces; `ldi` exports views with them".into());
    }
    let report = BakedReport {
        faces: parts.faces.len(),
        charts: layout.charts.len(),
        pages: layout.pages.iter().map(|page| page.size).collect(),
        density: layout.usual_density(),
        density_cap: layout.cap.is_finite().then_some(layout.cap),
        upsampled: layout.upsampled,
        coverage: coverage.as_shares(),
    };
    let (textures, mut known): (Vec<_>, Vec<_>) =
        pages.into_iter().map(|page| (page.texture, page.known)).unzip();
    // A frame that is level has exactly Z up.
    let up = if opened.project.frame.up.is_some() && placement.frame_from_world.is_some() {
        DVec3::Z
    } else {
        placement.direction(up)
    };
    let objects = assemble::objects(&site.model, &parts, &layout, placement);
    let model = TexturedModel { name: NAME.into(), origin: placement.origin, up, objects, pages: textures };
    let mut files = match options.format {
        BakedFormat::Glb => vec![glb(&model, GENERATOR)],
        BakedFormat::Obj => obj(model, options.up, GENERATOR),
        BakedFormat::Usd => usd(model, cameras, GENERATOR),
    };
    files.append(&mut known);
    preview.problems().into_iter().for_each(|problem| task.note(problem));
    Ok(Baked { files, left_out, report })
}

/// Bakes the site with these photos and writes the files to a folder.
///
/// # Errors
/// Returns the errors of [`bake`] and of writing.
#[allow(clippy::too_many_arguments, reason = "what a format gets, and the device")]
pub(super) fn write(
    folder: &mut HandoverFolder,
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    placement: &Placement,
    options: &BakedOptions,
    device: &dyn SiteDevice,
    task: &Task,
) -> Result<BakedReport> {
    let camera = |photo: &&Photo| Ok(camera_of(photo, linked(folder, photo)?, placement));
    let cameras = match options.format {
        BakedFormat::Usd => photos.iter().map(camera).collect::<Result<_>>()?,
        BakedFormat::Glb | BakedFormat::Obj => Vec::new(),
    };
    let mut ids: Vec<PhotoId> =
        photos.iter().filter_map(|photo| opened.site.photo_named(&photo.name)).collect();
    ids.sort_unstable();
    let baked = bake(project, opened, &ids, &cameras, placement, options, device, task)?;
    for file in &baked.files {
        folder.write(&file.name, &file.bytes)?;
    }
    baked.left_out.into_iter().for_each(|what| folder.leave_out(what));
    Ok(baked.report)
}

/// Returns an axis of the world that is nearly this direction, else the direction.
fn snapped(up: DVec3) -> DVec3 {
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    axes.into_iter().find(|axis| axis.dot(up) >= NEARLY_AXIS).unwrap_or(up)
}
