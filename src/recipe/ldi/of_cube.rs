//! Cubes of layered depth images: all that several photos show around the place of one of them, in one file.

use std::path::Path;

use super::maker::{BuildCamera, Maker, first_of};
use super::of_photos::{combined_into, taken};
use super::options::{BuildFrom, PhotosOptions, SiteLdiOptions};
use super::place::check_out;
use super::reference_camera::OfPhoto;
use super::set::{BuiltSet, Writing};
use crate::open::Opened;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::up;
use quadratura_base::task::Task;
use quadratura_layers::device::StartDevice;
use quadratura_ldi::cube::{FACE, FACE_NAMES, cube_cameras, upright};
use quadratura_ldi::file::Packing;
use quadratura_ldi::layout::LONGEST_SIDE;
use quadratura_ldi::{Arrangement, Frame};

/// Sides of faces are multiples of this many pixels, so that levels halve them evenly.
const SIDE_STEP: f64 = 64.0;

/// A request for a cube.
#[derive(Debug, Clone)]
pub struct CubeRequest<'a> {
    /// The photo whose camera is the centre.
    pub photo: PhotoId,
    /// What the faces are made from: several photos, or the whole site. There is no guard band: the faces have no end.
    pub from: BuildFrom,
    /// The file to write.
    pub out: &'a Path,
    /// How it is packed.
    pub packing: Packing,
}

/// Builds a cube around the place of a photo; a device is started for faces of the whole site. Photos that were named and cannot be used do not stop the others; the second list
/// has the reasons.
///
/// # Errors
/// [`Error::Usage`] for faces of image layers, [`Error::Request`] for too large ones, those of the first photo's image and of writing, or [`Error::Cancelled`].
pub fn build_cube(
    folder: &Path,
    opened: &Opened,
    request: &CubeRequest,
    start: StartDevice,
    task: &Task,
) -> Result<(BuiltSet, Vec<Error>)> {
    check_out(request.out)?;
    let mut maker = Maker::open(folder, opened, &request.from, start, task)?;
    let (photo, scale) = (opened.site.photo(request.photo), scale_of(&request.from)?);
    let cameras = cube_cameras(
        photo.pose.center_in_world(),
        &upright(&photo.pose, up(&opened.site.photos)),
        side_px(&photo.camera, scale)?,
    );
    let images = match &request.from {
        BuildFrom::Photos { options, best, with } => {
            let photos = match &with[..] {
                [] => maker.site.with_best_of(request.photo, &cameras, *best),
                with => maker.usable(first_of(request.photo, with)),
            };
            taken(&maker.site.images_of(&photos, &options.stack, task)?, options)
        }
        BuildFrom::Site { .. } | BuildFrom::Stack(_) => Vec::new(),
    };
    let mut writing = Writing::new(Arrangement::Cube, request.packing);
    for ((done, name), (camera, pose)) in (0..).zip(FACE_NAMES).zip(cameras) {
        task.step("faces", done, FACE_NAMES.len() as u64)?;
        let camera = BuildCamera { name: name.to_owned(), photo: None, camera, pose };
        let ldi = match &request.from {
            BuildFrom::Photos { options, .. } => face_of(&camera, &images, request.photo, options, task)?,
            BuildFrom::Site { options, .. } => face_of_site(&camera, &mut maker, options, task)?,
            BuildFrom::Stack(_) => unreachable!("refused above"),
        };
        writing.add(request.out, name, None, &ldi)?;
    }
    task.step("faces", FACE_NAMES.len() as u64, FACE_NAMES.len() as u64)?;
    Ok((writing.write(request.out, task)?, maker.unusable(&request.from)))
}

/// Returns the factor of the faces' resolution.
fn scale_of(from: &BuildFrom) -> Result<f64> {
    match from {
        BuildFrom::Photos { options, .. } => Ok(options.scale),
        BuildFrom::Site { options, .. } => Ok(options.scale),
        BuildFrom::Stack(_) => {
            let found = "a photo's image layers fill no cube; give --from photos or --from site with --cube";
            Err(Error::Usage(found.into()))
        }
    }
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

/// Combines the photos in the camera of a face.
fn face_of(
    camera: &BuildCamera,
    images: &[OfPhoto],
    own: PhotoId,
    options: &PhotosOptions,
    task: &Task,
) -> Result<quadratura_ldi::Ldi> {
    let gain = images[0].0.gain;
    let frame = Frame { camera: camera.camera, pose: camera.pose, photo_rect: None, gain };
    let mut words = PhotosOptions { guard: 0.0, ..options.clone() }.described();
    words.insert(FACE.to_owned(), camera.name.clone());
    combined_into(&frame, Some(own), images, (options, words), task)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ldi::StackLdiOptions;
    use crate::ldi::maker::no_device;
    use crate::peel::photo_picture;
    use crate::tiny_site::tiny_stacks;
    use quadratura_base::scene::synthetic::centred;
    use quadratura_ldi::file::read_ldi_set;
    use quadratura_ldi::{WarpOptions, warp_set};
    use quadratura_view::Shot;

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
    fn a_cube_around_a_photo_shows_the_photo_across_its_seams() {
        let folder = tempfile::tempdir().unwrap();
        let (project, opened) = tiny_stacks(folder.path()).unwrap();
        let (out, photo) = (folder.path().join("cube.ldi"), PhotoId::new(0));
        let stack = StackLdiOptions { relief: false, ..StackLdiOptions::default() };
        // Faces of twice the photo's resolution, so that the photo is not blurred by them.
        let options = PhotosOptions { stack, hidden: true, scale: 2.0, ..PhotosOptions::default() };
        let (best, with, packing) = (1, Vec::new(), Packing::Deflate);
        let from = BuildFrom::Photos { options, best, with };
        let request = CubeRequest { photo, from, out: &out, packing };
        let (built, _) = build_cube(&project, &opened, &request, &no_device, &Task::silent()).unwrap();
        assert_eq!((built.images.len(), built.images[4].name.as_str()), (6, "front"));
        let cube = read_ldi_set(&out, &Task::silent()).unwrap();
        let photo = opened.site.photo(photo);
        let shot = Shot::new(photo.camera, photo.pose);
        let shown = warp_set(&cube, &shot, &WarpOptions::default(), &Task::silent()).unwrap().picture;
        let own = photo_picture(photo).unwrap();
        assert!(shown.pixels().iter().all(|pixel| pixel[3] > 250), "the photo's pixels go round the seams");
        let off =
            |(a, b): (&[u8; 4], &[u8; 4])| f64::from(a[0].abs_diff(b[0])) + f64::from(a[1].abs_diff(b[1]));
        let mean =
            shown.pixels().iter().zip(own.pixels()).map(off).sum::<f64>() / (2.0 * own.pixels().len() as f64);
        // The photo is resampled twice, by pixels of half its size.
        assert!(mean < 6.0, "{mean}");
    }
}
