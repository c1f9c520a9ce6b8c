//! Orthophotos: a facade from straight in front, a plan, or a section, at a scale, with exactly the blending of other pictures.
//!
//! | module | contents |
//! |---|---|
//! | [`subject`] | what a picture is of, and its plane |
//! | [`resolution`] | the size of a pixel, and the scale of a print |
//! | `draw` | the pixels, and where they come from |
//! | `cut` | where the plane of a section cuts faces |
//! | `fineness` | how finely photos show what is in the picture |
//! | `page` | the words of the page |
//! | `files` | names of files that overwrite nothing |
//! | [`report`] | numbers about the result |

mod cut;
mod draw;
mod files;
mod fineness;
mod page;
pub mod report;
pub mod resolution;
pub mod subject;

use std::path::{Path, PathBuf};

use glam::DVec3;

pub use self::report::{OrthoReport, PlaceInFrame, SourceShares};
pub use self::resolution::Resolution;
pub use self::subject::Subject;

use self::cut::CutLines;
use self::files::Stem;
use self::subject::{PlacedSubject, placed};
use crate::preview::{MORE_MEMORY, Preview};
use crate::render::Appearance;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::FaceId;
use quadratura_base::task::Task;
use quadratura_io::ortho::page::{LONGEST_PX, write_page};
use quadratura_io::ortho::picture::{MapTags, PictureTags, write_indexed_png, write_png, write_tiff};
use quadratura_io::ortho::rows::RowsFile;
use quadratura_sites::open::Opened;
use quadratura_view::{DisplayMode, Exposure, Picture, Shot, TreeMethod};

/// What is wanted of an orthophoto.
#[derive(Debug, Clone, PartialEq)]
pub struct OrthoOptions {
    /// What it is of.
    pub subject: Subject,
    /// How finely.
    pub resolution: Resolution,
    /// How far in front of the subject the picture begins, in metres: what is nearer to the viewer is left out. `None` for the usual:
    /// [`USUAL_DEPTH_M`] in front of faces, everything of plans.
    pub depth_m: Option<f64>,
    /// How photos are blended.
    pub look: Appearance,
    /// The folder of the files.
    pub out: PathBuf,
    /// The name of the files without ending; `None` for one after the subject.
    pub name: Option<String>,
    /// The formats.
    pub formats: Vec<OrthoFormat>,
    /// The title on the page; `None` for the subject.
    pub title: Option<String>,
    /// The approximate memory for pixels, in bytes.
    pub memory: u64,
}

/// A format of orthophotos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrthoFormat {
    /// TIFF with resolution, and GeoTIFF tags of plans.
    Tiff,
    /// PNG with resolution.
    Png,
    /// A page as PDF.
    Pdf,
}

impl OrthoFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Tiff, Self::Png, Self::Pdf];

    /// Returns the ending of the files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Tiff => "tif",
            Self::Png => "png",
            Self::Pdf => "pdf",
        }
    }
}

/// How far in front of faces a picture begins unless a depth is given, in metres: cornices, balconies and reveals are in it, people and
/// trees on the square are not.
pub const USUAL_DEPTH_M: f64 = 1.0;

/// The most pixels along a side.
const LONGEST: f64 = 1_000_000.0;

/// What is worked out before anything is drawn.
#[derive(Debug, Clone)]
pub struct OrthoPlan {
    subject: PlacedSubject,
    /// The view in colour.
    pub shot: Shot,
    /// Metres per unit of the cameras' world.
    metres_per_unit: f64,
}

impl OrthoPlan {
    /// Returns width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.shot.camera.width, self.shot.camera.height]
    }
}

/// Works out the view of an orthophoto.
///
/// # Errors
/// Returns [`Error::Missing`] where the site has no scale, [`Error::Request`] for what the subject names and does not exist, and for sizes
/// that are too large.
pub fn planned(opened: &Opened, options: &OrthoOptions) -> Result<OrthoPlan> {
    let metres_per_unit = opened.project.frame.metres_per_unit().ok_or_else(no_scale)?;
    let subject = placed(opened, &options.subject)?;
    let px_per_unit = metres_per_unit / options.resolution.pixel_m;
    // A millionth of a pixel is rounding.
    let sides = (subject.size * px_per_unit - 1e-6).ceil();
    if sides.min_element() < 1.0 || sides.is_nan() {
        let found = "the picture would have no pixel: the subject has no width or no height; name other faces, or a finer scale";
        return Err(Error::Request(found.into()));
    }
    check_size(sides.to_array(), options.memory)?;
    let size_px = sides.to_array().map(|side| side as u32);
    let PlacedSubject { mut plane, foremost, .. } = subject;
    // The picture begins at the upper left corner of the subject, whatever part of a pixel remains at its end.
    let more = 0.5 * (sides / px_per_unit - subject.size);
    plane.middle += plane.right * more.x + plane.down * more.y;
    let from_depth = match (&options.subject, options.depth_m) {
        (Subject::Section(_), depth) => Some(-depth.unwrap_or(0.0) / metres_per_unit),
        (Subject::On(_), depth) => Some(foremost - depth.unwrap_or(USUAL_DEPTH_M) / metres_per_unit),
        (Subject::Plan(_), depth) => depth.map(|depth| foremost - depth / metres_per_unit),
    };
    let extent = extent(opened, &subject);
    let parallel = Shot::orthographic(&plane, size_px, px_per_unit, extent, from_depth);
    let shot = as_looked_at(&parallel, options, in_front(opened, &parallel, from_depth));
    Ok(OrthoPlan { subject: PlacedSubject { plane, ..subject }, shot, metres_per_unit })
}

/// Returns the error of a site without a scale, which says how to set one.
fn no_scale() -> Error {
    Error::Request(
        "the site has no unit, so it cannot be drawn to scale. Tell a length that you know, such as `quadratura frame SITE --scale \
         'wall[0]:0' 'wall[0]:1' 12.34`, or, where the model was drawn in metres, `quadratura frame SITE --unit m`; `quadratura frame --help` \
         says how points are named"
            .into(),
    )
}

fn check_size(sides: [f64; 2], memory: u64) -> Result<()> {
    let [width, height] = sides;
    let coarser = "give a coarser --gsd or --scale, or fewer faces";
    if width.max(height) > LONGEST {
        return Err(Error::Request(format!(
            "the picture would have {width} x {height} pixels, and sides are {LONGEST} pixels at most; {coarser}"
        )));
    }
    let needed = band_bytes(width);
    if needed > memory {
        let mega = |bytes: u64| bytes.div_ceil(1 << 20);
        return Err(Error::Request(format!(
            "a picture {width} pixels wide takes about {} MiB while it is drawn, and {} MiB are allowed; give --memory {}M, or {coarser}",
            mega(needed),
            mega(memory),
            mega(needed)
        )));
    }
    Ok(())
}

/// Returns about how many bytes of pixels are in memory while a picture is drawn: a band of tiles, drawn up to twice as finely along each
/// side, and its rows.
fn band_bytes(width: f64) -> u64 {
    /// The rows of a band.
    const ROWS: f64 = 512.0;
    /// What a tile is drawn into.
    const TILE: u64 = 256 << 20;
    TILE + (width * 2.0 * ROWS * 4.0) as u64 + (width * ROWS * 8.0) as u64
}

/// Returns the largest distance between points that may be in sight.
fn extent(opened: &Opened, subject: &PlacedSubject) -> f64 {
    let vertices = opened.site.model.vertices.iter();
    let (low, high) =
        vertices.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (high - low).length() + subject.size.length()
}

/// Returns the faces that are wholly in front of where the picture begins.
fn in_front(opened: &Opened, shot: &Shot, from_depth: Option<f64>) -> Vec<FaceId> {
    let Some(from_depth) = from_depth else { return Vec::new() };
    let model = &opened.site.model;
    let is_in_front =
        |face: &FaceId| model.ring_points(*face).all(|corner| shot.depth_of(corner) < from_depth);
    model.face_ids().filter(is_in_front).collect()
}

/// Returns the view with the look that is wanted. Unless something else is said, it is in the common exposure of all photos: that of a
/// viewpoint, which there is none, means nothing.
fn as_looked_at(parallel: &Shot, options: &OrthoOptions, in_front: Vec<FaceId>) -> Shot {
    let look = &options.look;
    let exposure = match look.exposure {
        Exposure::Decided | Exposure::Near | Exposure::Metered => Exposure::Common,
        exposure => exposure,
    };
    Shot {
        parallel: parallel.parallel,
        exposure,
        trees: TreeMethod::None,
        surroundings: false,
        display: DisplayMode::Colour,
        hidden: look.hidden.iter().chain(in_front).collect(),
        ..look.shot(parallel.camera, parallel.pose)
    }
}

/// Makes an orthophoto that was planned: draws it and writes its files.
///
/// # Errors
/// Returns [`Error::Request`] where no photo shows any of the faces, the errors of drawing and of writing, or [`Error::Cancelled`].
pub fn make(
    opened: &Opened,
    plan: &OrthoPlan,
    options: &OrthoOptions,
    preview: &mut Preview,
    task: &Task,
) -> Result<OrthoReport> {
    let mut left_out = check_shown(opened, plan, preview)?;
    std::fs::create_dir_all(&options.out).map_err(Error::io(&options.out, "create the folder"))?;
    quadratura_files::atomic::remove_dead_leftovers(&options.out);
    let [width, _] = plan.size_px();
    let mut rows = RowsFile::create(&options.out, width)?;
    let cut = cut_lines(opened, plan, options);
    let is_coarser =
        task.timed("draw the orthophoto", || draw::draw(preview, &plan.shot, &cut, &mut rows, task))?;
    if is_coarser {
        left_out.push(format!("the finest pixels of photos: {MORE_MEMORY}"));
    }
    let (sources, shares) =
        task.timed("draw the sources", || draw::draw_sources(preview, &plan.shot, task))?;
    if !opened.project.trees.is_empty() {
        left_out.push("trees, which are shown in perspective alone".into());
    }
    let mut report = described(opened, plan, options, shares, left_out);
    report.photo_pixel_m =
        fineness::photo_pixel(opened, plan, preview).map(|unit| unit * plan.metres_per_unit);
    write(opened, plan, options, (&rows, &sources), &mut report, task)?;
    preview.problems().into_iter().for_each(|problem| task.note(problem));
    Ok(report)
}

/// The longer side of a preview, in pixels.
const PREVIEW_PX: f64 = 600.0;

/// Draws a small picture of an orthophoto.
///
/// # Errors
/// As [`make`], except those of writing.
pub fn preview_picture(
    opened: &Opened,
    options: &OrthoOptions,
    preview: &mut Preview,
    task: &Task,
) -> Result<Picture> {
    let [width, height] = planned(opened, options)?.size_px().map(f64::from);
    let pixel_m = options.resolution.pixel_m * (width.max(height) / PREVIEW_PX).max(1.0);
    let resolution = Resolution { pixel_m, ..options.resolution };
    let plan = planned(opened, &OrthoOptions { resolution, ..options.clone() })?;
    check_shown(opened, &plan, preview)?;
    let cut = cut_lines(opened, &plan, options);
    let mut picture = preview.picture_of_faces(&Shot { supersampled: false, ..plan.shot }, task)?;
    cut.lay_over(&mut picture.rgba, picture.width, 0);
    Ok(picture)
}

/// Returns the lines that are drawn where a section cuts the model; none of other subjects.
fn cut_lines(opened: &Opened, plan: &OrthoPlan, options: &OrthoOptions) -> CutLines {
    let from_depth = plan.shot.parallel.and_then(|parallel| parallel.from_depth);
    match (&options.subject, from_depth) {
        (Subject::Section(_), Some(from_depth)) => {
            let dpi = resolution::INCH_M * options.resolution.scale / options.resolution.pixel_m;
            let hidden = |face| options.look.hidden.contains(face);
            CutLines::new(&opened.site.model, &plan.shot, from_depth, dpi, hidden)
        }
        _ => CutLines::default(),
    }
}

/// Checks that photos show something of the subject; returns which faces none shows.
fn check_shown(opened: &Opened, plan: &OrthoPlan, preview: &Preview) -> Result<Vec<String>> {
    let model = &opened.site.model;
    let forward = plan.subject.plane.forward();
    let is_shown = |face: &FaceId| {
        let back = model.face(*face).plane.normal.dot(forward) > 0.0;
        let both = model.object(model.face(*face).object).billboard;
        preview.sources().servers_of(*face).iter().any(|server| both || server.back == back)
    };
    let faces = &plan.subject.faces;
    let unseen: Vec<FaceId> = faces.iter().copied().filter(|face| !is_shown(face)).collect();
    let Some(first) = unseen.first() else { return Ok(Vec::new()) };
    let first = model.face_name(*first);
    if unseen.len() == faces.len() {
        let what = if unseen.len() == 1 { first } else { format!("any of the {} faces", unseen.len()) };
        return Err(Error::Request(format!(
            "no photo shows {what} from this side, so there is nothing to draw; `quadratura info SITE --face` says why"
        )));
    }
    let count = unseen.len();
    let (faces, are) = if count == 1 { ("face", "is") } else { ("faces", "are") };
    Ok(vec![format!(
        "what photos show of {count} {faces}, such as {first}: no photo shows this side, so they {are} continued or filled"
    )])
}

fn described(
    opened: &Opened,
    plan: &OrthoPlan,
    options: &OrthoOptions,
    shares: SourceShares,
    left_out: Vec<String>,
) -> OrthoReport {
    let Resolution { pixel_m, scale, dpi } = options.resolution;
    let frame = &opened.project.frame;
    let frame_from_world = frame.frame_from_world();
    let (plane, [width, height]) = (&plan.subject.plane, plan.size_px().map(f64::from));
    let px = pixel_m / plan.metres_per_unit;
    let corner = plane.middle - plane.right * (0.5 * width * px) - plane.down * (0.5 * height * px);
    let corner = frame_from_world.apply(corner);
    let step = |direction: DVec3| (frame_from_world.rotation * direction * pixel_m).to_array();
    let place = PlaceInFrame { corner: corner.to_array(), right: step(plane.right), down: step(plane.down) };
    let is_plan = matches!(options.subject, Subject::Plan(_));
    let crs = frame.crs.as_ref().filter(|_| is_plan);
    let map_corner = crs.map(|crs| [0, 1].map(|axis| corner[axis] + crs.offset[axis]));
    OrthoReport {
        subject: page::named(&options.subject),
        folder: options.out.clone(),
        files: Vec::new(),
        size_px: plan.size_px(),
        pixel_m,
        scale,
        dpi,
        place,
        epsg: crs.map(|crs| crs.epsg),
        map_corner,
        shares,
        photo_pixel_m: None,
        page_mm: None,
        left_out,
    }
}

/// Writes the files of an orthophoto, and lists them in the report.
fn write(
    opened: &Opened,
    plan: &OrthoPlan,
    options: &OrthoOptions,
    (rows, sources): (&RowsFile, &quadratura_io::ortho::picture::IndexedPicture),
    report: &mut OrthoReport,
    task: &Task,
) -> Result<()> {
    let name = options.name.clone().unwrap_or_else(|| page::file_name(&options.subject));
    let formats = &options.formats;
    let mut endings: Vec<&str> = formats.iter().map(|format| format.ending()).collect();
    endings.extend(["provenance.png", "json"]);
    let stem = Stem::free(&options.out, &name, &endings);
    if let Some(spared) = &stem.spared {
        task.note(format!(
            "there are files {}.* that are not of this orthophoto or were changed; they are kept, and the new ones are {}.*",
            spared.display(),
            stem.path.display()
        ));
    }
    let map =
        (matches!(options.subject, Subject::Plan(_)) && opened.project.frame.north.is_some()).then(|| {
            let corner = report.map_corner.unwrap_or([report.place.corner[0], report.place.corner[1]]);
            MapTags { pixel_m: report.pixel_m, corner, epsg: report.epsg }
        });
    let description = page::description(report);
    let tags = PictureTags { dpi: report.dpi, description, map };
    for format in formats {
        let target = stem.with(format.ending());
        task.timed("write files", || match format {
            OrthoFormat::Tiff => write_tiff(&target, rows, &tags).map(|()| true),
            OrthoFormat::Png => write_png(&target, rows, &tags).map(|()| true),
            OrthoFormat::Pdf if rows.size_px().iter().any(|side| *side > LONGEST_PX) => Ok(false),
            OrthoFormat::Pdf => {
                let text = page::text(opened, plan, options, report);
                report.page_mm = Some(write_page(&target, rows, &text)?);
                Ok(true)
            }
        })
        .map(|is_written| match is_written {
            true => report.files.push(file_name_of(&target)),
            false => report
                .left_out
                .push(format!("the page, which holds pictures of up to {LONGEST_PX} pixels along a side")),
        })?;
    }
    let target = stem.with("provenance.png");
    write_indexed_png(&target, sources, &draw::legend())?;
    report.files.extend([file_name_of(&target), file_name_of(&stem.with("json"))]);
    stem.describe(report)
}

fn file_name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
