//! `--format cameras`: COLMAP's text files, `transforms.json` and `cameras.json`, and the flight of the project as a camera path.
//!
//! Programs that read these take one folder of pictures. Where no photo had to be undistorted, that is the user's own; else
//! `images/` has the pictures of all photos: the undistorted ones, and the others as they are.

use std::path::Path;

use super::folder::HandoverFolder;
use super::origin::Placement;
use super::photos::{camera_of, copied, is_resampled, linked};
use super::points::handover_points;
use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Bookmark;
use quadratura_files::json::to_json;
use quadratura_handover::camera::HandoverCamera;
use quadratura_handover::cameras_json::cameras_json;
use quadratura_handover::colmap::colmap_text;
use quadratura_handover::transforms::transforms_json;
use quadratura_sites::open::Opened;
use quadratura_view::navigation::Viewpoint;

/// The folder of pictures.
const IMAGES: &str = "images";
/// Where programs that read COLMAP's results look for them.
const COLMAP: &str = "sparse/0";

/// Writes the cameras of `photos`.
///
/// # Errors
/// Returns the errors of reading cameras and photos and of writing, or [`quadratura_base::Error::Cancelled`].
pub fn write(
    folder: &mut HandoverFolder,
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    placement: &Placement,
    task: &Task,
) -> Result<()> {
    let needs_copies = photos.iter().any(|photo| is_resampled(project, photo));
    let (mut cameras, mut names) = (Vec::new(), Vec::new());
    for (done, photo) in photos.iter().enumerate() {
        task.step("write photos", done as u64, photos.len() as u64)?;
        let file = if needs_copies { copied(folder, IMAGES, photo)? } else { linked(folder, photo)? };
        names.push(match file.strip_prefix(&format!("{IMAGES}/")) {
            Some(name) if needs_copies => name.to_owned(),
            _ => photo.name.clone(),
        });
        cameras.push(camera_of(photo, file, placement));
    }
    let points = handover_points(project, opened, photos, placement, task)?;
    if points.is_empty() {
        folder.leave_out("points, because the project's cameras have none that two of these photos observe");
    }
    if photos.iter().any(|photo| !photo.masks.is_empty()) {
        folder.leave_out("masks, because these formats have no common place for them");
    }
    let origin = placement.origin;
    let text = colmap_text(&cameras, &names, &points);
    for (name, content) in
        [("cameras.txt", text.cameras), ("images.txt", text.images), ("points3D.txt", text.points)]
    {
        folder.write(&format!("{COLMAP}/{name}"), content.as_bytes())?;
    }
    folder.write("transforms.json", &transforms_json(&cameras, origin.to_array()))?;
    let views = views(&opened.project.views, placement);
    folder.write("cameras.json", &cameras_json(&cameras, &views, origin.to_array()))?;
    if let Some(flight) = &opened.project.flight {
        // Camera paths know the site's frame, and no origin.
        let flight = placement.frame_from_world.map_or_else(|| flight.clone(), |frame| flight.moved(&frame));
        folder.write(FLIGHT, &to_json(&flight))?;
    }
    Ok(())
}

/// The flight of the project.
const FLIGHT: &str = "flight.json";
/// The size of the pictures of bookmarks, which have none of their own, in pixels: the usual one of `render --view`.
const VIEW_PX: [u32; 2] = [1920, 1080];

/// Returns the cameras of the bookmarks that can be views.
fn views(bookmarks: &[Bookmark], placement: &Placement) -> Vec<HandoverCamera> {
    let camera = |bookmark: &Bookmark| {
        let Viewpoint { pose, lens, .. } = bookmark.viewpoint();
        HandoverCamera {
            name: bookmark.name.clone(),
            file: String::new(),
            camera: lens.camera(VIEW_PX[0], VIEW_PX[1]),
            pose: placement.pose(&pose),
        }
    };
    bookmarks.iter().filter(|bookmark| bookmark.problem().is_none()).map(camera).collect()
}
