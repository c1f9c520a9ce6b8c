//! The whole site as a page: a folder that a browser opens, in which one walks through the site and sees what views show.
//!
//! | module | contents |
//! |---|---|
//! | [`options`] | what is wanted, and what was published |
//! | `plane` | bytes of pictures as they are packed |
//! | `shelf` | rectangles beside each other |
//! | `labels` | which image layers show each pixel of a photo |
//! | `tiles` | texels of layers beside the visible pixels of their photo |
//! | `photo` | a photo composed of its layers |
//! | `geometry` | surfaces, servers, layers, relief |
//! | `dome` | what is around |
//! | `safe` | where a visitor is kept |
//! | `description` | what the viewer is told first |
//! | `photos`, `tile_chunk` | photos and pages of tiles as chunks |
//! | `place_texts` | texts at places |
//! | `texts` | the page without its viewer |
//! | `choose` | which of many photos are published |
//! | `write` | all files |
//! | `publication` | a page before it is written |

mod choose;
mod description;
mod dome;
mod geometry;
mod labels;
mod meter;
pub mod options;
mod photo;
mod photos;
mod place_texts;
mod plane;
mod publication;
mod safe;
mod shelf;
mod texts;
mod tile_chunk;
mod tiles;
mod write;

use std::path::Path;

pub use self::options::{LeavingPhoto, MOST_SIDE, PageOptions, PagePart, Published};
pub use self::publication::Publication;
use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_layers::device::SiteDevice;
use quadratura_sites::open::Opened;

/// Returns the photos that a page would publish: their names there, and their sizes.
pub fn leaving(photos: &[&Photo], options: &PageOptions) -> Vec<LeavingPhoto> {
    let leaving = |(number, photo): (usize, &&Photo)| LeavingPhoto {
        photo: photo.name.clone(),
        published: if options.keep_names { photo.name.clone() } else { format!("p{:03}", number + 1) },
        size: published_size([photo.camera.width, photo.camera.height], options.longest),
    };
    photos.iter().enumerate().map(leaving).collect()
}

/// Returns the size at which a picture of this size is published, in pixels: its longer side at most `longest`.
pub fn published_size([width, height]: [u32; 2], longest: u32) -> [u32; 2] {
    let by = (f64::from(longest.min(MOST_SIDE)) / f64::from(width.max(height).max(1))).min(1.0);
    [width, height].map(|side| ((f64::from(side) * by).round() as u32).max(1))
}

/// Publishes the site with these photos, in the site's order, from the project in the folder `project` as a page in the folder `out`.
///
/// # Errors
/// Returns the errors of [`Publication::prepare`] and [`Publication::write`].
pub fn publish(
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    out: &Path,
    options: &PageOptions,
    device: &dyn SiteDevice,
    task: &Task,
) -> Result<Published> {
    Publication::prepare(project, opened, photos, options, device, task)?.write(out, task)
}
