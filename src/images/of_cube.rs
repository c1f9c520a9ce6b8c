//! Cubes of layered depth images: all that the photos of a site show around the place of one of them, in one file.

use std::path::Path;

use super::maker::{BuildCamera, Maker};
use super::options::{BuildFrom, SiteLdiOptions};
use super::place::check_out;
use super::set::{BuiltSet, Writing};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::up;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_layers::device::StartDevice;
use quadratura_ldi::Arrangement;
use quadratura_ldi::cube::{FACE, FACE_NAMES, cube_cameras, upright};
use quadratura_ldi::file::Packing;
use quadratura_ldi::layout::LONGEST_SIDE;

/// Sides of faces are multiples of this many pixels, so that levels halve them evenly.
const SIDE_STEP: f64 = 64.0;

/// A request for a cube.
#[derive(Debug, Clone)]
pub struct CubeRequest<'a> {
    /// The photo whose camera is the centre.
    pub photo: PhotoId,
    /// What the faces are made from: the whole site. There is no guard band: the faces have no end.
    pub from: BuildFrom,
    /// The file to write.
    pub out: &'a Path,
    /// How it is packed.
    pub packing: Packing,
}

/// Builds a cube around the place of a photo.
///
/// # Errors
/// [`Error::Usage`] for faces of something else, [`Error::Request`] for too large ones, those of the first photo's image and of writing, or [`Error::Cancelled`].
pub fn build_cube(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &CubeRequest,
    start: StartDevice,
    task: &Task,
) -> Result<BuiltSet> {
    check_out(request.out)?;
    let BuildFrom::Site { options, .. } = &request.from else {
        let found = "a photo's image layers fill no cube; give --from site with --cube";
        return Err(Error::Usage(found.into()));
    };
    let mut maker = Maker::open(folder, project, site, &request.from, start, task)?;
    let photo = site.photo(request.photo);
    let cameras = cube_cameras(
        photo.pose.center_in_world(),
        &upright(&photo.pose, up(&site.photos)),
        side_px(&photo.camera, options.scale)?,
    );
    let mut writing = Writing::new(Arrangement::Cube, request.packing);
    for ((done, name), (camera, pose)) in (0..).zip(FACE_NAMES).zip(cameras) {
        task.step("faces", done, FACE_NAMES.len() as u64)?;
        let camera = BuildCamera { name: name.to_owned(), photo: None, camera, pose };
        let ldi = face_of_site(&camera, &mut maker, options, task)?;
        writing.add(request.out, name, None, &ldi)?;
    }
    task.step("faces", FACE_NAMES.len() as u64, FACE_NAMES.len() as u64)?;
    writing.write(request.out, task)
}

/// Returns the side of a face in pixels: twice the photo's focal length, with which a face resolves as much as the photo in
/// its middle.
fn side_px(camera: &Pinhole, scale: f64) -> Result<u32> {
    let side = (2.0 * (camera.fx * camera.fy).sqrt() * scale / SIDE_STEP).ceil() * SIDE_STEP;
    if side > f64::from(LONGEST_SIDE) {
        return Err(Error::Request(format!(
            "the faces of the cube would have {side} pixels a side; they have at most {LONGEST_SIDE}: give a smaller --ldi-scale"
        )));
    }
    Ok(side as u32)
}

/// Makes the image of the site behind the camera of a face.
fn face_of_site(
    camera: &BuildCamera,
    maker: &mut Maker,
    options: &SiteLdiOptions,
    task: &Task,
) -> Result<quadratura_ldi::Ldi> {
    let options = SiteLdiOptions { guard: 0.0, scale: 1.0, ..*options };
    let mut ldi = maker.image_of_site(camera, &options, task)?;
    ldi.report.options.insert(FACE.to_owned(), camera.name.clone());
    Ok(ldi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StackLdiOptions;
    use crate::maker::no_device;
    use quadratura_base::scene::synthetic::centred;
    use quadratura_stacks::tiny_site::tiny_stacks;

    #[test]
    fn sides_are_twice_the_focal_length_in_whole_steps() {
        let camera = |focal: f64| centred(100, 80, focal);
        assert_eq!(side_px(&camera(160.0), 1.0).unwrap(), 320);
        assert_eq!(side_px(&camera(160.5), 1.0).unwrap(), 384);
        assert_eq!(side_px(&camera(160.0), 0.5).unwrap(), 192);
        let refused = side_px(&camera(9000.0), 1.0).unwrap_err().to_string();
        assert!(refused.contains("--ldi-scale"), "{refused}");
    }

    #[test]
    fn image_layers_fill_no_cube() {
        let folder = tempfile::tempdir().unwrap();
        let (project, opened) = tiny_stacks(folder.path()).unwrap();
        let out = folder.path().join("cube.ldi");
        let (photo, packing) = (PhotoId::new(0), Packing::Deflate);
        let request =
            CubeRequest { photo, from: BuildFrom::Stack(StackLdiOptions::default()), out: &out, packing };
        let refused =
            build_cube(&project, &opened.project, &opened.site, &request, &no_device, &Task::silent())
                .unwrap_err();
        assert!(refused.to_string().contains("--from site") && !out.exists(), "{refused}");
    }
}
