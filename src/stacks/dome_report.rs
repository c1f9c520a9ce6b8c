//! What is known of a project's surroundings, and their dome as an equirectangular picture.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::far_backdrops::FarBackdrops;
use crate::gains::photo_gains;
use crate::surroundings::SiteSurroundings;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, Site, up};
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack, SurroundingsPicture};
use quadratura_files::writable::check_beside;
use quadratura_io::dome_picture::{is_writable, write_dome_picture};
use quadratura_io::stack_store::StackStore;
use quadratura_projection::dome::{Dome, DomeFrame};
use quadratura_sites::budget::default_memory;
use quadratura_sites::check::CheckedSurface;
use quadratura_sites::dome_picture::frame;

/// What is known of a project's surroundings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DomeReport {
    /// The number of photos with a layer of the surroundings.
    pub photos: usize,
    /// The share of all directions that a photo shows, or the user's picture, 0..=1; `None` where there is no dome.
    pub known: Option<f64>,
    /// The same share of what views from near the photos see where no face is: from each photo's place, up to half a
    /// picture beyond its borders. `None` where there is no dome, or faces are everywhere.
    pub known_near: Option<f64>,
    /// The user's picture.
    pub picture: Option<SurroundingsPicture>,
    /// Whether that picture is shown: it can be read.
    pub picture_used: bool,
    /// The file that was written.
    pub exported: Option<PathBuf>,
    /// The direction of the middle of that file, in the cameras' world.
    pub middle: Option<[f64; 3]>,
}

/// A request to write the dome as a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DomeExport {
    /// The file: `.png` or `.hdr`, which must not exist.
    pub file: PathBuf,
    /// The width in pixels; `None` for that of the dome.
    pub width: Option<u32>,
    /// The direction of the middle; `None` for that in which the photos look.
    pub middle: Option<[f64; 3]>,
}

/// Reports a project's surroundings and writes them as a picture where that is asked for.
///
/// # Errors
/// Returns [`Error::Request`] when there is no dome to export, for a file that exists or has another extension, and
/// for a direction that is not level enough; otherwise the errors of [`SiteSurroundings::open`], and [`Error::Io`].
pub fn dome_report(
    folder: &Path,
    project: &Project,
    site: &Site,
    export: Option<&DomeExport>,
    task: &Task,
) -> Result<DomeReport> {
    if let Some(DomeExport { file, .. }) = export {
        check_target(file)?;
    }
    let store = StackStore::new(folder);
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten();
    let stacks: Vec<Option<Stack>> = site.photos.iter().map(stack).collect();
    let is_built = stacks.iter().any(Option::is_some);
    if !is_built && project.surroundings.is_none() && export.is_some() {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    let memory = default_memory();
    let gains = photo_gains(site, &stacks, &project.colour, folder, memory, task)?;
    let around = SiteSurroundings::open(folder, project, site, &stacks, &gains, memory, task)?;
    let dome = around.whole().dome.as_deref();
    let mut report = DomeReport {
        photos: around.photos().count(),
        known: dome.map(Dome::known_share),
        known_near: dome.and_then(|dome| known_near(site, dome)),
        picture: project.surroundings.clone(),
        picture_used: around.uses_picture(),
        exported: None,
        middle: None,
    };
    if let Some(DomeExport { file, width, middle }) = export {
        let dome = dome.ok_or_else(|| Error::Request(NOTHING.into()))?;
        let frame = match middle {
            None => frame_of_photos(&site.photos),
            given => frame(site, *given)?,
        };
        let (width, middle) = (width.unwrap_or(4 * dome.side) / 2 * 2, frame.middle());
        let write = || write_dome_picture(file, width, &dome.equirectangular(&frame, width), middle);
        task.timed("export", write)?;
        (report.exported, report.middle) = (Some(file.clone()), Some(middle.to_array()));
    }
    Ok(report)
}

/// The columns and rows of a grid of directions that is seen from a photo's place.
const GRID: [u32; 2] = [48, 32];

/// Returns how much of what views from near the photos see where no face is is known, 0..=1: from each photo's place, in
/// its picture and half a picture beyond its borders. `None` where faces are everywhere.
fn known_near(site: &Site, dome: &Dome) -> Option<f64> {
    let far = FarBackdrops::new(site);
    let surface = CheckedSurface::from_model(&site.model.without(|object| far.contains(&object.name)));
    let (mut known, mut all) = (0.0, 0u32);
    for photo in &site.photos {
        let (eye, [columns, rows]) = (photo.pose.center_in_world(), GRID);
        let at =
            |i: u32, of: u32, px: u32| (2.0 * (f64::from(i) + 0.5) / f64::from(of) - 0.5) * f64::from(px);
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let px = DVec2::new(at(column, columns, photo.camera.width), at(row, rows, photo.camera.height));
            let towards = photo.pose.world_from_camera(photo.camera.ray_in_camera(px)) - eye;
            if surface.tree.first_hit(eye, towards, f64::INFINITY).is_none() {
                known += f64::from(dome.known(towards));
                all += 1;
            }
        }
    }
    (all > 0).then(|| known / f64::from(all))
}

/// The least length of the mean of the photos' directions, made level, at which it is one.
const ONE_WAY: f64 = 0.1;

/// Returns the frame of pictures of a site that has the direction in which the photos look in its middle; the usual one
/// where they look all around.
fn frame_of_photos(photos: &[Photo]) -> DomeFrame {
    let up = up(photos);
    let forward = |photo: &Photo| photo.pose.rotation.transpose() * DVec3::Z;
    let mean = photos.iter().map(forward).sum::<DVec3>() / photos.len().max(1) as f64;
    let level = mean - up * mean.dot(up);
    let frame = DomeFrame::new(up, mean).filter(|_| level.length() >= ONE_WAY);
    frame.unwrap_or_else(|| DomeFrame::with_default_middle(up))
}

/// What is told where there is nothing to export.
const NOTHING: &str = "there is nothing around the model to export: no photo shows anything where no surface is, and no \
                       picture is set; --set FILE sets one";

/// Refuses files that exist, formats that are not written, and places where no file can be made.
///
/// # Errors
/// Returns [`Error::Request`], or the errors of [`check_beside`].
pub fn check_target(file: &Path) -> Result<()> {
    let name = file.display();
    if !is_writable(file) {
        let found = format!("{name}: the picture can be written as .png or .hdr; give such a name");
        return Err(Error::Request(found));
    }
    if file.exists() {
        return Err(Error::Request(format!("{name} exists and is not overwritten; give another name")));
    }
    check_beside(file)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::dvec3;

    use super::*;
    use quadratura_base::scene::Model;
    use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
    use quadratura_projection::dome::CubeMap;
    use quadratura_sites::dome_picture::chosen_picture;

    fn photo(eye: DVec3, target: DVec3) -> Photo {
        let (camera, pose) = (centred(60, 40, 50.0), look_at(eye, target));
        Photo {
            name: "a.jpg".into(),
            camera,
            pose,
            file: "missing.jpg".into(),
            exposure: None,
            masks: Vec::new(),
        }
    }

    #[test]
    fn what_views_near_the_photos_see_counts_and_what_faces_hide_or_is_behind_them_does_not() {
        // Known in front of the camera and above the horizon: the upper half of what it sees.
        let known = |d: DVec3| ([0.5; 3], if d.y > 0.0 && d.z > 0.0 { 1.0 } else { 0.0 });
        let dome = Dome::from_light(&CubeMap::from_directions(56, known));
        let photos = vec![photo(DVec3::ZERO, DVec3::Y)];
        let empty = Site { photos: photos.clone(), model: Modeller::new().finish() };
        assert!((known_near(&empty, &dome).unwrap() - 0.5).abs() < 0.02);
        let mut m = Modeller::new();
        m.object("ground").quad(dvec3(-900.0, -900.0, -1.0), DVec3::X * 1800.0, DVec3::Y * 1800.0);
        let ground = Site { photos: photos.clone(), model: m.finish() };
        assert!(known_near(&ground, &dome).unwrap() > 0.95, "the ground is no part of the surroundings");
        m.object("wall").quad(dvec3(-900.0, 1.0, -900.0), DVec3::X * 1800.0, DVec3::Z * 1800.0);
        assert_eq!(known_near(&Site { photos, model: m.finish() }, &dome), None);
    }
    #[test]
    fn the_middle_of_an_exported_picture_is_where_the_photos_look_and_is_found_again() {
        let photos =
            vec![photo(DVec3::ZERO, dvec3(1.0, 0.2, 0.0)), photo(DVec3::ZERO, dvec3(1.0, -0.2, 0.0))];
        let frame = frame_of_photos(&photos);
        assert!(frame.middle().abs_diff_eq(DVec3::X, 1e-9), "{}", frame.middle());
        let around = vec![photo(DVec3::ZERO, DVec3::X), photo(DVec3::ZERO, DVec3::NEG_X)];
        assert_eq!(frame_of_photos(&around).middle(), DVec3::Y, "they look all around");

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sky.hdr");
        write_dome_picture(&file, 8, &[[0.5; 3]; 32], frame.middle()).unwrap();
        let site = Site { photos, model: Arc::new(Model::default()) };
        let chosen =
            |given| chosen_picture(folder.path(), &site, &file, given, &Task::silent()).unwrap().middle;
        assert_eq!(chosen(None), frame.middle().to_array());
        assert_eq!(chosen(Some([0.0, 1.0, 0.0])), [0.0, 1.0, 0.0], "what is given counts first");
    }
}
