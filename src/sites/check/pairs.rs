//! Aligns the model by corners that a person points out in photos, where no search finds the alignment.

use std::path::Path;

use glam::{DVec2, DVec3};
use serde::Serialize;

use quadratura_align::centres::{self, from_centres};
use quadratura_align::pairs::{CornerPair, SURE, Unpaired, from_pairs};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::scene::{Site, SparsePoint};
use quadratura_base::task::Task;
use quadratura_import::cameras::read_cameras;

use crate::named::index_of_photo;

/// A corner of the model, and the pixel at which a photo shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct CornerInPhoto {
    /// The corner in the coordinates of the model's file.
    pub corner: DVec3,
    /// The photo's name, or enough of it.
    pub photo: String,
    /// The place in the photo without lens distortion, in pixels from its upper left corner.
    pub px: DVec2,
}

/// The transform that pairs give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairReport {
    /// The value for `--model-transform`.
    pub transform: String,
    /// Whether there are so few pairs that they fit almost any pixels, and their residuals say little.
    pub rough: bool,
    /// The pairs, in the order in which they were given.
    pub pairs: Vec<PairResidual>,
}

/// A pair, and how far it is from the others' transform.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairResidual {
    /// The corner in the coordinates of the model's file.
    pub corner: [f64; 3],
    /// The photo's unique name.
    pub photo: String,
    /// The place in the photo.
    pub px: [f64; 2],
    /// How far from there the transform shows the corner, in pixels; `None` behind the camera.
    pub residual_px: Option<f64>,
    /// Whether all other pairs fit far better without it.
    pub doubtful: bool,
}

/// Finds the transform with which the photos show the corners where they were pointed out. Only photos and points of
/// `site` count, and its model does not matter.
///
/// # Errors
/// [`Error::Request`] for a photo that there is not, for a pixel outside its photo, and for pairs that do not determine a transform.
pub fn align_by_pairs(site: &Site, points: &[SparsePoint], pairs: &[CornerInPhoto]) -> Result<PairReport> {
    let pair = |pair: &CornerInPhoto| {
        let photo = index_of_photo(site, &pair.photo)?.index();
        let camera = &site.photos[photo].camera;
        let size = DVec2::new(camera.width.into(), camera.height.into());
        if !(pair.px.cmpge(DVec2::ZERO).all() && pair.px.cmple(size).all()) {
            return Err(Error::Request(format!(
                "the pixel {},{} is outside of {}, which has {} x {} pixels: give a pixel of the photo",
                pair.px.x, pair.px.y, site.photos[photo].name, camera.width, camera.height
            )));
        }
        Ok(CornerPair { corner: pair.corner, photo, px: pair.px })
    };
    let known = pairs.iter().map(pair).collect::<Result<Vec<_>>>()?;
    let cameras: Vec<_> = site.photos.iter().map(|photo| (photo.camera, photo.pose)).collect();
    let fit = from_pairs(&known, &cameras, points)
        .map_err(|reason| Error::Request(refusal(reason, known.len())))?;
    let residual = |(i, pair): (usize, &CornerPair)| PairResidual {
        corner: pair.corner.to_array(),
        photo: site.photos[pair.photo].name.clone(),
        px: pair.px.to_array(),
        residual_px: Some(fit.residuals_px[i]).filter(|px| px.is_finite()),
        doubtful: fit.doubtful == Some(i),
    };
    Ok(PairReport {
        transform: fit.world_from_model.to_string(),
        rough: known.len() < SURE,
        pairs: known.iter().enumerate().map(residual).collect(),
    })
}

fn refusal(reason: Unpaired, count: usize) -> String {
    match reason {
        Unpaired::TooFew => format!(
            "{count} pairs of a model's corner and a photo's pixel do not determine the alignment: give three at least, better \
             five, in two photos or more"
        ),
        Unpaired::OnePlace => {
            "all pairs are in photos taken from one place, which leaves the size of the model open: point \
                               out some of the corners in a photo from another place, too"
                .into()
        }
        Unpaired::NoFit => {
            "no transform shows these corners at these pixels: give corners that are not on one line, and \
                            compare each with its photo"
                .into()
        }
    }
}

/// The transform that cameras in common give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CamerasReport {
    /// The value for `--model-transform`.
    pub transform: String,
    /// The number of photos that both files name.
    pub shared: usize,
    /// The number of these whose centres agree.
    pub agreeing: usize,
    /// The median distance between the centres of these, in units of the project's cameras.
    pub residual: f64,
}

/// Finds the transform from the coordinates of other cameras, in which the model was made, to those of the site, by photos
/// that both name.
///
/// # Errors
/// As for reading cameras, and [`Error::Input`] where too few centres agree.
pub fn align_by_cameras(site: &Site, file: &Path, task: &Task) -> Result<CamerasReport> {
    let others = read_cameras(file, task)?;
    let name = |name: &str| name.rsplit('/').next().unwrap_or(name).to_lowercase();
    let pairs: Vec<(DVec3, DVec3)> = others
        .photos
        .iter()
        .filter_map(|other| {
            let mut same = site.photos.iter().filter(|photo| name(&photo.name) == name(&other.name));
            // A name that several photos share tells none of them.
            let (photo, none) = (same.next()?, same.next());
            none.is_none().then(|| (other.pose.center_in_world(), photo.pose.center_in_world()))
        })
        .collect();
    let found = from_centres(&pairs).ok_or_else(|| {
        let found = format!(
            "{} of its {} photos have the name of a photo of the project, and no {} of their centres agree",
            pairs.len(),
            others.photos.len(),
            centres::FEWEST
        );
        Error::input(
            file,
            "",
            found,
            "use cameras of the same photos, in the coordinates of the model, that do not lie on one line",
        )
    })?;
    let mut agreeing = found.residuals.clone();
    agreeing.sort_by(f64::total_cmp);
    Ok(CamerasReport {
        transform: found.similarity.to_string(),
        shared: pairs.len(),
        agreeing: found.agreeing,
        residual: agreeing[found.agreeing / 2],
    })
}

impl PairReport {
    /// Returns the transform from the model's file to the cameras' world.
    pub fn similarity(&self) -> Similarity {
        Similarity::parse(&self.transform).expect("a transform is written as it is read")
    }
}

impl CamerasReport {
    /// Returns the transform from the model's file to the cameras' world.
    pub fn similarity(&self) -> Similarity {
        Similarity::parse(&self.transform).expect("a transform is written as it is read")
    }
}
