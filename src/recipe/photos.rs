//! Importing photos: each of the cameras' photos finds its file, and becomes a pinhole image.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::document::names::file_name_of_photo;
use crate::error::{Error, Result};
use crate::geometry::Undistortion;
use crate::io::cameras::{CameraPhoto, Cameras};
use crate::io::photo::{Match, PhotoFolder, check_photo, make_pinhole_image};
use crate::scene::Photo;
use crate::task::Task;

/// What [`import_photos`] made of the cameras' photos.
#[derive(Debug, Default)]
pub struct PhotoImport {
    /// Those that can be used, sorted by name; the file of each exists and fits its camera.
    pub photos: Vec<Photo>,
    /// Why the others cannot; one each, in the cameras' order.
    pub problems: Vec<Error>,
    /// What the user should know, each beginning with the photo's name.
    pub notes: Vec<String>,
}

/// Finds the file of every photo below `photo_dir` and checks it against its camera. A photo without
/// distortion is used as it is; of every other there is a pinhole image in `cache_dir/photos`
/// afterwards, made now where it is not there or no longer right.
///
/// # Errors
/// Only what concerns all photos: the folders cannot be read or written, or somebody asked to stop.
pub fn import_photos(
    cameras: &Cameras,
    photo_dir: &Path,
    cache_dir: &Path,
    task: &Task,
) -> Result<PhotoImport> {
    let folder = PhotoFolder::scan(photo_dir, task)?;
    let names: Vec<&str> = cameras.photos.iter().map(|photo| photo.name.as_str()).collect();
    let matches = folder.find(&names);
    let mut import = PhotoImport::default();
    let found = located(cameras, &matches, &folder, photo_dir, task)?;
    let images = cache_dir.join("photos");
    let total = found.len() as u64;
    // One after the other: a photo is decoded by one thread but resampled by all, and only one of
    // them at a time has to fit into memory.
    for (done, (photo, located)) in cameras.photos.iter().zip(found).enumerate() {
        task.step("import photos", done as u64, total)?;
        let result = located.and_then(|located| pinhole_photo(photo, located, &images, task));
        match result {
            Ok((photo, notes)) => {
                import.photos.push(photo);
                import.notes.extend(notes);
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(problem) => import.problems.push(problem),
        }
    }
    task.step("import photos", total, total)?;
    import.photos.sort_by(|a, b| a.name.cmp(&b.name));
    import.notes.extend(unused(&folder, &matches));
    Ok(import)
}

/// A photo's file, which fits its camera.
struct Located {
    file: PathBuf,
    notes: Vec<String>,
}

/// The files of all photos, their headers read in parallel.
fn located(
    cameras: &Cameras,
    matches: &[Match],
    folder: &PhotoFolder,
    photo_dir: &Path,
    task: &Task,
) -> Result<Vec<Result<Located>>> {
    let (done, total) = (AtomicU64::new(0), matches.len() as u64);
    (cameras.photos.par_iter(), matches)
        .into_par_iter()
        .map(|(photo, found)| {
            task.step("find photos", done.fetch_add(1, Ordering::Relaxed), total)?;
            Ok(locate(photo, found, folder, photo_dir))
        })
        .collect()
}

fn locate(photo: &CameraPhoto, found: &Match, folder: &PhotoFolder, photo_dir: &Path) -> Result<Located> {
    let (file, difference) = match found {
        Match::File(file, difference) => (*file, *difference),
        Match::Missing => return Err(missing(photo, photo_dir)),
        Match::Ambiguous { files, photos } => return Err(ambiguous(photo, folder, files, *photos)),
    };
    let name = &photo.name;
    let header = check_photo(&folder.path(file), photo.camera.width, photo.camera.height)?;
    let elsewhere =
        (!difference.is_empty()).then(|| format!("{name}: found {difference}, as {}", folder.name(file)));
    let of_header = header.notes.iter().map(|note| format!("{name}: {note}"));
    Ok(Located { file: folder.path(file), notes: elsewhere.into_iter().chain(of_header).collect() })
}

/// The photo as it is used from now on: its own file, or its pinhole image below `images`.
fn pinhole_photo(
    photo: &CameraPhoto,
    located: Located,
    images: &Path,
    task: &Task,
) -> Result<(Photo, Vec<String>)> {
    let CameraPhoto { name, camera, lens, pose, .. } = photo;
    let Located { file, mut notes } = located;
    if lens.is_none() {
        return Ok((Photo { name: name.clone(), camera: *camera, pose: *pose, file }, notes));
    }
    let undistortion = Undistortion::new(camera, *lens).ok_or_else(|| beyond_its_lens(photo, &file))?;
    std::fs::create_dir_all(images).map_err(Error::io(images, "create the folder"))?;
    let image = images.join(format!("{}.png", file_name_of_photo(name)));
    make_pinhole_image(&file, &undistortion, &image, &task.of(name))?;
    if undistortion.lost > 0.0 {
        let percent = 100.0 * undistortion.lost;
        notes.push(format!(
            "{name}: about {percent:.1} % of its pixels are left out: they lie more than 60 degrees off \
             the axis, or where the lens model ends, or beyond twice the photo's size"
        ));
    }
    Ok((Photo { name: name.clone(), camera: undistortion.pinhole, pose: *pose, file: image }, notes))
}

fn beyond_its_lens(photo: &CameraPhoto, file: &Path) -> Error {
    let found = format!("no pixel of it lies where its lens model makes sense ({:?})", photo.lens);
    Error::input(file, "", found, "calibrate the camera again, with a simpler model")
}

fn missing(photo: &CameraPhoto, photo_dir: &Path) -> Error {
    let found = "there is no such photo, nor one of that name in a sub-folder or in another format";
    let remedy = "put it there, or give the folder that the cameras' names begin from";
    Error::input(photo_dir.join(&photo.name), "", found, remedy)
}

fn ambiguous(photo: &CameraPhoto, folder: &PhotoFolder, files: &[usize], photos: usize) -> Error {
    let shown: Vec<_> = files.iter().take(4).map(|&file| folder.name(file)).collect();
    let more = if files.len() > shown.len() { ", .." } else { "" };
    let shown = format!("{}{more}", shown.join(", "));
    let found = match photos {
        1 => format!("{} could be any of {} files ({shown})", photo.name, files.len()),
        _ => format!("{} and {} others could be {shown}", photo.name, photos - 1),
    };
    let remedy = "give the files the paths that the cameras' file names";
    Error::input(folder.path(files[0]), "", found, remedy)
}

/// Files that no camera names, in one note.
fn unused(folder: &PhotoFolder, matches: &[Match]) -> Option<String> {
    let mut used = vec![false; folder.len()];
    for found in matches {
        match found {
            Match::File(file, _) => used[*file] = true,
            Match::Ambiguous { files, .. } => files.iter().for_each(|&file| used[file] = true),
            Match::Missing => (),
        }
    }
    let unused: Vec<_> = (0..folder.len()).filter(|&file| !used[file]).map(|f| folder.name(f)).collect();
    let shown = unused[..unused.len().min(5)].join(", ");
    match unused.len() {
        0 => None,
        1 => Some(format!("{shown}: no camera for this photo; it is not used")),
        n if n <= 5 => Some(format!("{shown}: no cameras for these photos; they are not used")),
        n => Some(format!("{shown} and {} more: no cameras for these photos; they are not used", n - 5)),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::geometry::{Lens, Pinhole, Pose};
    use crate::io::photo::read_photo;

    fn camera_photo(name: &str) -> CameraPhoto {
        CameraPhoto {
            name: name.into(),
            camera: Pinhole { width: 8, height: 6, fx: 9.0, fy: 9.0, cx: 4.0, cy: 3.0 },
            lens: Lens::None,
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            place: "line 1".into(),
        }
    }

    fn import(names: &[&str], files: &[&str]) -> PhotoImport {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let width = if file.contains("narrow") { 7 } else { 8 };
            image::RgbImage::new(width, 6).save(path).unwrap();
        }
        let photos = names.iter().map(|name| camera_photo(name)).collect();
        let cameras = Cameras { photos, ..Cameras::default() };
        import_photos(&cameras, folder.path(), folder.path(), &Task::silent()).unwrap()
    }

    #[test]
    fn photos_come_sorted_by_name_and_untouched() {
        let import = import(&["b.png", "a.png"], &["a.png", "b.png"]);
        let names: Vec<_> = import.photos.iter().map(|photo| photo.name.as_str()).collect();
        assert_eq!(names, ["a.png", "b.png"]);
        assert!(import.photos[0].file.ends_with("a.png"));
        assert!(import.problems.is_empty() && import.notes.is_empty(), "{import:?}");
    }

    #[test]
    fn what_is_wrong_is_reported_one_by_one_and_the_others_go_on() {
        let import = import(
            &["a.png", "gone.png", "narrow.png", "twice.png"],
            &["a.png", "narrow.png", "x/twice.png", "y/twice.png"],
        );
        assert_eq!(import.photos.len(), 1);
        let problems: Vec<_> = import.problems.iter().map(Error::to_string).collect();
        assert!(problems[0].contains("no such photo"), "{problems:?}");
        assert!(problems[1].contains("7 x 6 pixels, but its camera has 8 x 6"), "{problems:?}");
        assert!(problems[2].contains("any of 2 files (x/twice.png, y/twice.png)"), "{problems:?}");
        assert!(import.notes.is_empty(), "{:?}", import.notes);
    }

    #[test]
    fn a_distorted_photo_gets_a_pinhole_image_that_fits_its_camera() {
        let folder = tempfile::tempdir().unwrap();
        let cache = folder.path().join("cache");
        image::RgbImage::from_pixel(8, 6, image::Rgb([9, 8, 7])).save(folder.path().join("a b.png")).unwrap();
        let lens = Lens::Brown { k: [-0.3, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let photos = vec![CameraPhoto { lens, ..camera_photo("a b.png") }];
        let cameras = Cameras { photos, ..Cameras::default() };
        let import = || import_photos(&cameras, folder.path(), &cache, &Task::silent()).unwrap();
        let photo = import().photos.remove(0);
        assert_eq!(photo.file, cache.join("photos/a%20b.png.png"));
        assert!(photo.camera.width > 8 && photo.camera.fx == 9.0, "{:?}", photo.camera);
        let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height).unwrap();
        assert_eq!(pixels.rgba16(5, 3), [9 * 257, 8 * 257, 7 * 257, 65535]);
        std::fs::remove_dir_all(&cache).unwrap();
        assert!(import().photos == [photo.clone()] && photo.file.exists());
    }

    #[test]
    fn photos_found_elsewhere_and_photos_without_camera_are_noted() {
        let import = import(&["a.jpg"], &["sub/a.png", "other.png"]);
        assert_eq!(import.photos[0].name, "a.jpg");
        assert_eq!(
            import.notes,
            [
                "a.jpg: found in another folder and image format, as sub/a.png",
                "other.png: no camera for this photo; it is not used",
            ]
        );
    }
}
