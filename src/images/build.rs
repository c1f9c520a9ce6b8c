//! The command `ldi build`: layered depth images of stacks, into the cache or into a file to keep.

use std::path::{Path, PathBuf};

use super::maker::{BuildCamera, Maker};
use super::of_depth::{DepthImageOptions, depth_images};
use super::of_photos::combined_depth_images;
use super::options::{BuildFrom, PhotosOptions, StackLdiOptions};
use super::place::{cached_file, check_out, free_file};
use super::site::LdiSite;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_files::writable::check_folder;
use quadratura_io::picture_png::make_folder;
use quadratura_layers::device::StartDevice;
use quadratura_ldi::file::{LdiHeader, Packing, has_whole_length, read_ldi, read_ldi_header, write_ldi};
use quadratura_ldi::{Ldi, LdiReport};

/// A request for layered depth images.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildRequest {
    /// The photos.
    pub photos: Vec<PhotoId>,
    /// What they are made from.
    pub from: BuildFrom,
    /// The file to write, of one photo; `None` for the cache.
    pub out: Option<PathBuf>,
    /// How files are packed.
    pub packing: Packing,
}

/// A layered depth image that was built.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltLdi {
    /// The name of the photo, or of the view.
    pub photo: String,
    /// The file.
    pub file: PathBuf,
    /// Whether it was up to date already.
    pub kept: bool,
    /// The number of depth pixels of full resolution.
    pub depth_pixels: u64,
    /// The figures of its making.
    pub report: LdiReport,
    /// The size of the file in bytes.
    pub bytes: u64,
    /// Files that have the name, were changed or made by others, and were therefore not overwritten.
    pub spared: Vec<PathBuf>,
}

/// The state of the cached layered depth image of a photo.
#[derive(Debug)]
pub enum LdiState {
    /// It was made of the project as it is, with the same options.
    Current(LdiHeader),
    /// Something has changed since, or other options are asked for.
    Stale(LdiHeader),
    /// There is none, or it is cut short.
    Missing,
}

/// Returns the state of a photo's layered depth image in the cache. One that cannot be read counts as missing: it is made
/// again.
pub fn ldi_state(
    folder: &Path,
    site: &LdiSite,
    photo: PhotoId,
    name: &str,
    options: &StackLdiOptions,
) -> LdiState {
    let file = cached_file(folder, name);
    let Some(header) = read_ldi_header(&file).ok().filter(|_| has_whole_length(&file)) else {
        return LdiState::Missing;
    };
    match site.inputs(photo, options) {
        Some(inputs) if inputs == header.inputs => LdiState::Current(header),
        _ => LdiState::Stale(header),
    }
}

/// Builds layered depth images; a device is started for those of the whole site. A photo that fails does not stop the others; the second list has the reasons.
///
/// # Errors
/// [`Error::Request`] for one file of several photos, or for none where anything but a stack is in it, [`Error::Io`] when a folder cannot be created, or
/// [`Error::Cancelled`].
pub fn build_ldis(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &BuildRequest,
    start: StartDevice,
    task: &Task,
) -> Result<(Vec<BuiltLdi>, Vec<Error>)> {
    let cameras = cameras(site, request);
    if let (Some(out), [_, _, ..]) = (&request.out, &cameras[..]) {
        return Err(Error::Request(format!(
            "{} can hold the layered depth image of one photo, not of {}; give --photo, or no --out",
            out.display(),
            cameras.len()
        )));
    }
    match &request.out {
        Some(out) => check_out(out)?,
        None => check_folder(folder)?,
    }
    if request.out.is_none() && !matches!(request.from, BuildFrom::Stack(_)) {
        let found = "only layered depth images of stacks are kept in the project's cache; give --out FILE";
        return Err(Error::Request(found.into()));
    }
    let mut maker = Maker::open(folder, project, site, &request.from, start, task)?;
    let (mut built, mut failed) = (Vec::new(), maker.unusable(&request.from));
    let count = cameras.len() as u64;
    for (done, camera) in (0..).zip(&cameras) {
        task.step("layered depth images", done, count)?;
        match build_one(folder, &mut maker, camera, request, task) {
            Ok(one) => built.push(one),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => failed.push(error),
        }
    }
    task.step("layered depth images", count, count)?;
    Ok((built, failed))
}

/// Returns the cameras in which images are built.
fn cameras(site: &Site, request: &BuildRequest) -> Vec<BuildCamera> {
    if let BuildFrom::Site { at: Some(view), .. } = &request.from {
        return vec![BuildCamera::of_view(view)];
    }
    request.photos.iter().map(|photo| BuildCamera::of_photo(site, *photo)).collect()
}

fn build_one(
    folder: &Path,
    maker: &mut Maker,
    camera: &BuildCamera,
    request: &BuildRequest,
    task: &Task,
) -> Result<BuiltLdi> {
    let name = &camera.name;
    let cached = cached_file(folder, name);
    if let BuildFrom::Stack(options) = &request.from
        && request.out.is_none()
        && let Some(inputs) = maker.source.inputs(camera.photo()?, options)
        && let Some(kept) = kept(&cached, &inputs, task)
    {
        return Ok(built(name, cached, &kept, true));
    }
    let ldi = maker.image_of(camera, &request.from, task)?;
    let (file, spared) = match &request.out {
        Some(out) => free_file(out, &ldi, task)?,
        None => (cached, Vec::new()),
    };
    if let Some(parent) = file.parent().filter(|parent| *parent != Path::new("")) {
        make_folder(parent)?;
    }
    task.with_subject(name).timed("write", || write_ldi(&file, &ldi, request.packing))?;
    Ok(BuiltLdi { spared, ..built(name, file, &ldi, false) })
}

/// A request for a layered depth image of depth images from elsewhere.
#[derive(Debug, Clone)]
pub struct DepthRequest<'a> {
    /// The list of the depth images.
    pub list: &'a Path,
    /// The picture in whose camera the image is made.
    pub reference: &'a str,
    /// How they are combined.
    pub options: PhotosOptions,
    /// Whether depths are used whose scale contradicts the sparse points.
    pub force: bool,
    /// The file to write.
    pub out: &'a Path,
    /// How it is packed.
    pub packing: Packing,
}

/// Makes one layered depth image of all depth images of a list, in the camera of one of them. Those that cannot be used do not
/// stop the others; the list that is returned has the reasons.
///
/// # Errors
/// Those of [`depth_images`] and of combining, [`Error::Request`] where the reference is not in the list or cannot be used.
pub fn build_of_depth_images(request: &DepthRequest, task: &Task) -> Result<(BuiltLdi, Vec<Error>)> {
    let DepthRequest { list, reference, options, force, out, packing } = request;
    check_out(out)?;
    let (mut images, mut failed) = depth_images(list, &DepthImageOptions { force: *force }, task)?;
    let is_reference = |image: &Ldi| image.sources.first().is_some_and(|name| name == reference);
    let Some(at) = images.iter().position(is_reference) else {
        if let Some(error) = Error::of_all(std::mem::take(&mut failed)) {
            return Err(error);
        }
        if images.is_empty() {
            return Err(Error::input(*list, "", "there is no picture in the list", "name at least one"));
        }
        let names: Vec<&str> =
            images.iter().flat_map(|image| image.sources.iter().map(String::as_str)).collect();
        return Err(Error::Request(format!(
            "{}: no picture is called {reference}; --reference is one of {}",
            list.display(),
            names.join(", ")
        )));
    };
    let own = images.remove(at);
    images.insert(0, own);
    let ldi = combined_depth_images(&images, options, task)?;
    let (file, spared) = free_file(out, &ldi, task)?;
    if let Some(parent) = file.parent().filter(|parent| *parent != Path::new("")) {
        make_folder(parent)?;
    }
    task.timed("write", || write_ldi(&file, &ldi, *packing))?;
    Ok((BuiltLdi { spared, ..built(reference, file, &ldi, false) }, failed))
}

/// Returns the layered depth image in a file if it is whole and was made of these inputs.
fn kept(file: &Path, inputs: &str, task: &Task) -> Option<Ldi> {
    read_ldi_header(file).ok().filter(|header| header.inputs == inputs)?;
    read_ldi(file, task).ok()
}

fn built(photo: &str, file: PathBuf, ldi: &Ldi, kept: bool) -> BuiltLdi {
    let bytes = std::fs::metadata(&file).map_or(0, |metadata| metadata.len());
    let depth_pixels = ldi.levels[0].len() as u64;
    let report = ldi.report.clone();
    BuiltLdi { photo: photo.to_owned(), file, kept, depth_pixels, report, bytes, spared: Vec::new() }
}
