//! The command `ldi export`: a layered depth image for other programs, one function a format.

use std::path::{Path, PathBuf};

use glam::DVec3;

use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::writable::check_beside;
use quadratura_io::picture_png::make_folder;
use quadratura_ldi::lean::{SafeRegion, Window, seen};
use quadratura_ldi::mesh::{GlbContent, place_of_glb, write_glb};
use quadratura_ldi::page::{Page, PageFile, place_of_page, write_page};
use quadratura_ldi::segments::{SegmentOptions, Segments, segments};
use quadratura_ldi::{Ldi, WarpOptions, warp};

/// How much a page magnifies an image without a guard band, so that the sides that open in views from aside are outside.
const ZOOM: f64 = 1.06;
/// The width of the view that the poster is made from, in pixels.
const POSTER_WIDTH: u32 = 1280;
/// The largest error of textures in programs that do not divide them per pixel, in pixels of the frame.
const UNDIVIDED: f64 = 0.25;

/// The options of meshes and pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// The number of triangles above which meshes become coarser.
    pub triangles: usize,
    /// The quality of JPEGs, from 1 to 100.
    pub quality: u8,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self { triangles: SegmentOptions::default().triangles, quality: 90 }
    }
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportedMesh {
    /// The folder or file.
    pub path: PathBuf,
    /// The files of a folder, or the file.
    pub files: Vec<PageFile>,
    /// The number of segments.
    pub segments: u32,
    /// The number of triangles.
    pub triangles: usize,
    /// The largest error of inverse depth that was allowed, in pixels of parallax for a step of half the reach.
    pub parallax: f64,
    /// The reach in world units.
    pub reach: f64,
    /// The window of a page, and the viewpoints that it goes to.
    pub seen: Option<(Window, SafeRegion)>,
    /// Files and folders of the name that are kept, because they are others' or were changed.
    pub spared: Vec<PathBuf>,
}

impl ExportedMesh {
    /// Returns the size of all files in bytes.
    pub fn bytes(&self) -> u64 {
        self.files.iter().map(|file| file.bytes).sum()
    }

    fn new(made: &Segments, path: PathBuf, files: Vec<PageFile>, spared: Vec<PathBuf>) -> Self {
        Self {
            path,
            files,
            segments: made.count,
            triangles: made.triangles(),
            parallax: made.parallax,
            reach: made.reach,
            seen: None,
            spared,
        }
    }
}

/// Makes the folder in which a file or folder is to be.
fn make_folder_above(path: &Path) -> Result<()> {
    match path.parent().filter(|folder| *folder != Path::new("")) {
        Some(folder) => make_folder(folder),
        None => Ok(()),
    }
}

/// Writes a page to a folder.
///
/// # Errors
/// [`quadratura_base::Error::Io`], [`quadratura_base::Error::Cancelled`].
pub fn export_page(
    ldi: &Ldi,
    out: &Path,
    caption: &str,
    options: &MeshOptions,
    task: &Task,
) -> Result<ExportedMesh> {
    let place = place_of_page(out);
    // What cannot be written is refused before the work.
    check_beside(&place.folder)?;
    let made =
        segments(ldi, &SegmentOptions { triangles: options.triangles, ..SegmentOptions::default() }, task)?;
    let zoom = if seen(ldi) == ldi.camera.rect() { ZOOM } else { 1.0 };
    let (window, safe) = task.timed("safe region", || Window::with_widest_region(ldi, zoom, task))?;
    let height = f64::from(POSTER_WIDTH) * f64::from(window.seen.h) / f64::from(window.seen.w);
    let own = window.shot(ldi, DVec3::ZERO, [POSTER_WIDTH, (height.round() as u32).max(1)]);
    let poster = warp(ldi, &own, &WarpOptions::default(), task)?.picture;
    let page = Page {
        camera: &ldi.camera,
        segments: &made,
        window: &window,
        safe: &safe,
        poster: &poster,
        caption,
        quality: options.quality,
    };
    make_folder_above(&place.folder)?;
    let files = task.timed("write", || write_page(&place, &page))?;
    Ok(ExportedMesh {
        seen: Some((window, safe)),
        ..ExportedMesh::new(&made, place.folder, files, place.spared)
    })
}

/// Writes a GLB file.
///
/// # Errors
/// [`quadratura_base::Error::Io`], [`quadratura_base::Error::Cancelled`].
pub fn export_glb(
    ldi: &Ldi,
    out: &Path,
    name: &str,
    options: &MeshOptions,
    task: &Task,
) -> Result<ExportedMesh> {
    let cells = SegmentOptions {
        triangles: options.triangles,
        undivided: Some(UNDIVIDED),
        ..SegmentOptions::default()
    };
    let (file, spared) = place_of_glb(out);
    check_beside(&file)?;
    let made = segments(ldi, &cells, task)?;
    let mesh =
        GlbContent { name, camera: &ldi.camera, pose: &ldi.pose, segments: &made, quality: options.quality };
    make_folder_above(&file)?;
    let bytes = task.timed("write", || write_glb(&file, &mesh))?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(ExportedMesh::new(&made, file, vec![PageFile { name, bytes }], spared))
}
