//! The exposures that cameras wrote into photos: what became of them in the estimate of gains, and which views have one.

use std::collections::BTreeMap;
use std::f64::consts::LN_2;
use std::path::Path;

use serde::Serialize;

use quadratura_base::error::Result;
use quadratura_base::scene::{CameraExposure, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_import::photo::{Match, PhotoFolder, read_exposure};
use quadratura_io::project::resolved;
use quadratura_projection::exposure::Estimate;
use quadratura_sites::views::RequestedView;

/// What became of the exposures that cameras wrote down.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraReport {
    /// The number of photos with exposure time, aperture and sensitivity, taken without a flash.
    pub written: usize,
    /// The number of those that agree with the estimate and are used; all or none of those that cannot be compared.
    pub used: usize,
    /// The median difference from the estimate in stops; `None` where nothing can be compared.
    pub off: Option<f64>,
    /// By how many dB left-out photos are predicted better in the exposure that their cameras wrote down than by the rule; `None`
    /// where nothing can be compared.
    pub lead: Option<f64>,
    /// Whether views that have the name of a photo get the exposure that its camera wrote down.
    pub suits_views: bool,
}

/// The exposure that a camera wrote down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WrittenExposure {
    /// The exposure time in seconds.
    pub seconds: f64,
    /// The aperture.
    pub f_number: f64,
    /// The sensitivity.
    pub iso: f64,
    /// Whether a flash fired, so that it says nothing.
    pub flash: bool,
    /// How much brighter it makes the photo than the mean of all, in stops; `None` where it is not used.
    pub stops: Option<f64>,
}

impl CameraReport {
    pub(super) fn new(estimate: &Estimate) -> Self {
        let camera = &estimate.gains.camera;
        Self {
            written: camera.written,
            used: camera.used(),
            off: camera.off.map(|off| off / LN_2),
            lead: estimate.camera_lead,
            suits_views: camera.suits_views,
        }
    }
}

impl WrittenExposure {
    pub(super) fn of_photo(photo: PhotoId, site: &Site, estimate: &Estimate) -> Option<Self> {
        let CameraExposure { seconds, f_number, iso, flash } = site.photo(photo).exposure?;
        let log = estimate.gains.camera.of_photo.get(photo.index()).copied().flatten();
        Some(Self { seconds, f_number, iso, flash, stops: log.map(|log| log / LN_2) })
    }
}

/// Returns the exposures that cameras wrote down, as natural logarithms, by the names of those views that are no photos of the site but
/// have the name of a file in its photo folder: photos that were taken, but not calibrated with the others.
///
/// # Errors
/// Returns [`quadratura_base::Error::Cancelled`], or the errors of reading the folder.
pub fn written_exposures(
    folder: &Path,
    project: &Project,
    site: &Site,
    views: &[RequestedView],
    task: &Task,
) -> Result<BTreeMap<String, f64>> {
    let names: Vec<&str> =
        views.iter().filter(|view| view.photo.is_none()).map(|view| view.name.as_str()).collect();
    let root = resolved(folder, &project.photos);
    if names.is_empty() || !root.is_dir() {
        return Ok(BTreeMap::new());
    }
    let photos = PhotoFolder::scan(&root, task)?;
    let found = photos.find(&names);
    let written = names.into_iter().zip(found).filter_map(|(name, found)| {
        let Match::File(file, _) = found else { return None };
        let of_site = site.photo_named(photos.name(file)).is_some();
        let log = if of_site { None } else { read_exposure(&photos.path(file))?.log() };
        Some((name.to_owned(), log?))
    });
    Ok(written.collect())
}
