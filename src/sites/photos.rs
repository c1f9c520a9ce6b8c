//! Import of photos: the file of each of the cameras' photos is found and, if distorted, resampled to a pinhole
//! image.

use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::budget::default_memory;
use crate::masks::beside::mask_names;
use crate::photo_plan::PhotoPlan;
use crate::side_by_side::ParallelPhotos;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_base::scene::alike::{composed, folded};
use quadratura_base::task::Task;
use quadratura_import::cameras::{CameraPhoto, Cameras};
use quadratura_import::photo::{Match, PhotoFolder};

/// The result of [`import_photos`].
#[derive(Debug, Default)]
pub struct PhotoImport {
    /// The usable photos, sorted by name; the file of each exists and matches its camera.
    pub photos: Vec<Photo>,
    /// The reasons why the others are unusable, one each, in the cameras' order.
    pub problems: Vec<Error>,
    /// The names of the others, in the same order.
    pub left_out: Vec<String>,
    /// Notes for the user, each beginning with a photo's name.
    pub notes: Vec<String>,
}

/// Finds the file of every photo below `photo_dir` and checks it against its camera. A photo without distortion is
/// used as it is. Each other one has a pinhole image in `cache_dir/photos` afterwards, which is made where it is
/// missing or out of date.
///
/// # Errors
/// Returns only errors that concern all photos: a folder cannot be read or written, or the task was cancelled.
pub fn import_photos(
    cameras: &Cameras,
    photo_dir: &Path,
    cache_dir: &Path,
    task: &Task,
) -> Result<PhotoImport> {
    let folder = PhotoFolder::scan(photo_dir, task)?;
    let names: Vec<&str> = cameras.photos.iter().map(|photo| photo.name.as_str()).collect();
    let matches = folder.find(&names);
    let images = cache_dir.join("photos");
    let plans = plans(cameras, &matches, &folder, &images, task)?;
    if plans.iter().flatten().any(|plan| plan.needs_image()) {
        std::fs::create_dir_all(&images).map_err(Error::io(&images, "create the folder"))?;
    }
    let made = made_images(&plans, task)?;
    let mut import = PhotoImport::default();
    for ((plan, made), name) in plans.into_iter().zip(made).zip(&names) {
        match plan.and_then(|plan| made.map(|()| plan)) {
            Ok(plan) => {
                import.photos.push(plan.photo);
                import.notes.extend(plan.notes);
            }
            Err(problem) => {
                import.problems.push(problem);
                import.left_out.push((*name).to_owned());
            }
        }
    }
    import.photos.sort_by(|a, b| a.name.cmp(&b.name));
    import.notes.extend(look_alikes(&folder, cameras, &matches));
    import.notes.extend(unused(&folder, cameras, &matches));
    Ok(import)
}

/// Photos that can be used, notes for the user, and the reasons why others cannot.
pub(super) type FoundPhotos = (Vec<PhotoPlan>, Vec<String>, Vec<Error>);

/// Finds the file of every photo below `photo_dir` and checks it against its camera; nothing is written.
///
/// # Errors
/// Returns only errors that concern all photos, as [`import_photos`].
pub(super) fn found_photos(cameras: &Cameras, photo_dir: &Path, task: &Task) -> Result<FoundPhotos> {
    let folder = PhotoFolder::scan(photo_dir, task)?;
    let names: Vec<&str> = cameras.photos.iter().map(|photo| photo.name.as_str()).collect();
    let matches = folder.find(&names);
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    for plan in plans(cameras, &matches, &folder, Path::new(""), task)? {
        match plan {
            Ok(plan) => found.push(plan),
            Err(problem) => problems.push(problem),
        }
    }
    let notes = found.iter().flat_map(|plan| plan.notes.iter().cloned());
    let notes =
        notes.chain(look_alikes(&folder, cameras, &matches)).chain(unused(&folder, cameras, &matches));
    let notes = notes.collect();
    Ok((found, notes, problems))
}

/// Plans the import of every photo from its file's header, in parallel.
fn plans(
    cameras: &Cameras,
    matches: &[Match],
    folder: &PhotoFolder,
    images: &Path,
    task: &Task,
) -> Result<Vec<Result<PhotoPlan>>> {
    let done = AtomicUsize::new(0);
    let total = matches.len() as u64;
    let photos = cameras.photos.par_iter().zip(matches);
    let there = cameras
        .photos
        .iter()
        .zip(matches)
        .filter(|(photo, found)| found.file().is_some() && !photo.name.is_ascii());
    let there: FxHashMap<String, &str> =
        there.map(|(photo, _)| (composed(&photo.name).into_owned(), photo.name.as_str())).collect();
    let plan = |(photo, found): (&CameraPhoto, &Match)| {
        task.step("find photos", done.fetch_add(1, Ordering::Relaxed) as u64, total)?;
        let twin = there.get(&*composed(&photo.name)).filter(|_| *found == Match::Missing);
        Ok(twin.map_or_else(
            || PhotoPlan::new(photo, found, folder, images),
            |twin| Err(listed_twice(&cameras.file, photo, twin)),
        ))
    };
    photos.map(plan).collect()
}

/// Makes the error for a photo that has its file in common with another one, of the same name in another Unicode form.
fn listed_twice(file: &Path, photo: &CameraPhoto, twin: &str) -> Error {
    let found = format!(
        "{:?} and {twin:?} look the same and differ in their Unicode form alone; there is one file of these names, which is \
         used for the latter",
        photo.name
    );
    Error::input(file, photo.place.as_str(), found, "remove one of the two cameras, or add the other photo")
}

/// Makes the missing pinhole images, several at a time: decoding and writing keep one thread each busy, resampling
/// all of them.
///
/// # Errors
/// Returns [`Error::Cancelled`]; an error with one photo is in its own result.
fn made_images(plans: &[Result<PhotoPlan>], task: &Task) -> Result<Vec<Result<()>>> {
    let at_a_time = ParallelPhotos {
        threads: rayon::current_num_threads(),
        memory: default_memory(),
        stage: "import photos",
    };
    let bytes = |plan: &Result<PhotoPlan>| plan.as_ref().map_or(0, PhotoPlan::memory);
    // The caller reports why there is no plan.
    let work = |plan: &Result<PhotoPlan>| plan.as_ref().map_or(Ok(()), |plan| plan.make_image(task));
    at_a_time.run(plans, bytes, work, task)
}

/// Returns notes about photos beside whose files there are others with names that look the same.
fn look_alikes(folder: &PhotoFolder, cameras: &Cameras, matches: &[Match]) -> Vec<String> {
    let used: FxHashSet<usize> = matches.iter().filter_map(Match::file).collect();
    let others = (0..folder.len()).filter(|file| !used.contains(file));
    let others: FxHashSet<Cow<'_, str>> = others.map(|file| composed(folder.name(file))).collect();
    let note = |(photo, found): (&CameraPhoto, &Match)| {
        let name = folder.name(found.file()?);
        others.contains(&composed(name)).then(|| {
            format!("{}: another file has this name in another Unicode form, too; it is not used", photo.name)
        })
    };
    cameras.photos.iter().zip(matches).filter_map(note).collect()
}

/// Returns a note about files that belong to no camera and are no masks, if any.
fn unused(folder: &PhotoFolder, cameras: &Cameras, matches: &[Match]) -> Option<String> {
    let of_photos = matches.iter().flat_map(|found| match found {
        Match::File(file, _) => std::slice::from_ref(file),
        Match::Ambiguous { files, .. } => files,
        Match::NotRead(_) | Match::Missing => &[],
    });
    let used: FxHashSet<usize> = of_photos.copied().collect();
    let masks = cameras.photos.iter().flat_map(|photo| mask_names(&photo.name));
    let masks: FxHashSet<String> = masks.map(|name| folded(&name).into_owned()).collect();
    let unused = (0..folder.len()).filter(|file| !used.contains(file)).map(|f| folder.name(f));
    let unused: Vec<_> = unused.filter(|name| !masks.contains(&*folded(name))).collect();
    let listed = unused[..unused.len().min(5)].join(", ");
    // Those that are there and cannot be used are reported themselves.
    let usable = if cameras.problems.is_empty() { "" } else { " usable" };
    match unused.len() {
        0 => None,
        1 => Some(format!("{listed}: no{usable} camera for this photo; it is not used")),
        n if n <= 5 => Some(format!("{listed}: no{usable} cameras for these photos; they are not used")),
        n => Some(format!(
            "{listed} and {} more: no{usable} cameras for these photos; they are not used",
            n - 5
        )),
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use quadratura_base::geometry::{Lens, Pinhole, Pose};
    use quadratura_import::cameras::read_cameras;
    use quadratura_import::photo::read_photo;

    fn camera_photo(name: &str) -> CameraPhoto {
        CameraPhoto {
            name: name.into(),
            camera: Pinhole { width: 8, height: 6, fx: 9.0, fy: 9.0, cx: 4.0, cy: 3.0 },
            lens: Lens::None,
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            shutter: None,
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
        assert!(problems[0].contains("no file of this name"), "{problems:?}");
        assert!(problems[1].contains("7 x 6 pixels where the camera has 8 x 6"), "{problems:?}");
        assert!(problems[2].contains("matches 2 files (x/twice.png, y/twice.png)"), "{problems:?}");
        assert!(import.notes.is_empty(), "{:?}", import.notes);
    }

    #[test]
    fn two_photos_whose_names_look_the_same_need_two_files() {
        let names = ["m\u{fc}r.png", "mu\u{308}r.png"];
        let one = import(&names, &names[..1]);
        assert_eq!((one.photos.len(), one.left_out.as_slice()), (1, &[names[1].to_owned()][..]));
        let problem = one.problems[0].to_string();
        assert!(problem.contains("look the same") && problem.contains("add the other photo"), "{problem}");
        assert_eq!(import(&names, &names).photos.len(), 2);
    }

    #[test]
    fn the_castle_is_imported_as_it_is() {
        let Some(castle) = crate::left_out::castle() else { return };
        let cameras = read_cameras(&castle.join("sparse"), &Task::silent()).unwrap();
        let cache = tempfile::tempdir().unwrap();
        let import = import_photos(&cameras, &castle.join("images"), cache.path(), &Task::silent()).unwrap();
        assert_eq!(
            (import.photos.len(), import.problems.len(), import.notes.len()),
            (19, 0, 0),
            "{import:?}"
        );
        assert!(import.photos.iter().all(|photo| photo.file.starts_with(castle.join("images"))));
        assert_eq!(std::fs::read_dir(cache.path()).unwrap().count(), 0, "nothing was written");
    }

    #[test]
    fn a_photo_that_lies_wholly_outside_its_lens_is_a_problem_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        image::RgbImage::new(8, 6).save(folder.path().join("a.png")).unwrap();
        let mut photo = CameraPhoto { lens: Lens::Division { k: -0.1 }, ..camera_photo("a.png") };
        photo.camera.cx = 700.0;
        let cameras = Cameras { photos: vec![photo], ..Cameras::default() };
        let import = import_photos(&cameras, folder.path(), folder.path(), &Task::silent()).unwrap();
        assert!(
            import.problems[0].to_string().contains("no pixel is in the valid range"),
            "{:?}",
            import.problems
        );
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
                "a.jpg: the file was found in another folder and image format, as sub/a.png",
                "other.png: no camera for this photo; it is not used",
            ]
        );
    }
}
