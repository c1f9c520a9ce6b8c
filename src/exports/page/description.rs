//! The description of a page: what `data/site.js` gives the viewer before anything else.

use super::meter::DescribedMeter;
use glam::{DMat3, DVec3};
use serde::Serialize;

use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_document::CameraPath;

/// The version of the format.
pub const VERSION: u32 = 2;

/// The description of a page.
#[derive(Debug, Serialize)]
pub struct PageDescription {
    /// [`VERSION`].
    pub version: u32,
    /// The title.
    pub title: String,
    /// The direction that is up.
    pub up: [f64; 3],
    /// The length in which cameras stand apart: the half of the diagonal around them, in world units.
    pub extent: f64,
    /// How views are blended.
    pub blend: DescribedBlend,
    /// How views are exposed.
    pub exposure: DescribedExposure,
    /// The distance between cameras from which they see other surroundings.
    pub surroundings_scale: f64,
    /// The photos.
    pub photos: Vec<DescribedPhoto>,
    /// The chunks of coarse photos, those near the start first.
    pub far: Vec<DescribedFar>,
    /// The chunks of pages of hidden texels, and of layers that one sees through, with the numbers of rows.
    pub hidden: Vec<DescribedPage>,
    /// See [`Self::hidden`].
    pub cut: Vec<DescribedPage>,
    /// The light that white in the picture of the dome stands for; `None` without a dome.
    pub dome: Option<f64>,
    /// The view at the start.
    pub start: DescribedView,
    /// The bookmarks.
    pub viewpoints: Vec<DescribedView>,
    /// The flight of the project; `None` without one.
    pub tour: Option<DescribedTour>,
    /// What is told at places.
    pub texts: Vec<super::place_texts::DescribedText>,
    /// The range in which one walks.
    pub safe: Option<super::safe::DescribedRegion>,
}

/// How photos are blended.
#[derive(Debug, Serialize)]
pub struct DescribedBlend {
    /// The weight of an octave of resolution in radians.
    pub lambda: f64,
}

/// How views are exposed.
#[derive(Debug, Serialize)]
pub struct DescribedExposure {
    /// The rule: near, metered, common or raw.
    pub rule: &'static str,
    /// Whether views are darker towards their corners, as the photos near them.
    pub keeps_vignetting: bool,
    /// The model of metering, where exposures followed meters.
    pub meter: Option<DescribedMeter>,
}

/// A chunk of coarse photos.
#[derive(Debug, Serialize)]
pub struct DescribedFar {
    /// The name of the chunk.
    pub chunk: String,
    /// The number of its first photo, from 0, and how many it has.
    pub first: usize,
    /// See [`Self::first`].
    pub photos: usize,
}

impl DescribedFar {
    /// Sorts chunks by how near their photos are to a view, by place (as a share of `extent`) and direction.
    pub fn sort_by_nearness(
        chunks: &mut [Self],
        photos: &[DescribedPhoto],
        view: &DescribedView,
        extent: f64,
    ) {
        let ahead = |rotation: &[f64; 9]| DVec3::from_slice(&rotation[6..]);
        let apart = |photo: &DescribedPhoto| {
            let step = DVec3::from(photo.centre).distance(DVec3::from(view.centre)) / extent;
            step.hypot(ahead(&photo.rotation).angle_between(ahead(&view.rotation)))
        };
        let nearest = |chunk: &Self| {
            photos[chunk.first..][..chunk.photos].iter().map(apart).fold(f64::INFINITY, f64::min)
        };
        chunks.sort_by(|a, b| nearest(a).total_cmp(&nearest(b)));
    }
}

/// A page of tiles.
#[derive(Debug, Serialize)]
pub struct DescribedPage {
    /// The name of its chunk.
    pub chunk: String,
    /// The number of rows.
    pub rows: usize,
}

/// A photo.
#[derive(Debug, Serialize)]
pub struct DescribedPhoto {
    /// The name of its chunk, and under which it is shown.
    pub name: String,
    /// Width and height of the camera's picture, in pixels.
    pub size: [u32; 2],
    /// Focal lengths and principal point: fx, fy, cx, cy.
    pub lens: [f64; 4],
    /// The rotation from world to camera, by rows, and the camera's centre.
    pub rotation: [f64; 9],
    /// See [`Self::rotation`].
    pub centre: [f64; 3],
    /// The size of the published picture, before it is turned.
    pub stored: [u32; 2],
    /// Whether it is stored turned by 90 degrees clockwise.
    pub turned: bool,
    /// The size of the coarse picture, before it is turned.
    pub far: [u32; 2],
    /// The logarithm of its exposure over the common one, R, G, B.
    pub gain: [f64; 3],
    /// The light that is added everywhere, and the falloff of the lens, for the squared distance from the axis in pixels.
    pub optics: [f64; 3],
    /// The mean colour, as `#rrggbb`.
    pub colour: String,
    /// The logarithms of the factors that bring its surroundings to one sky as a whole; `None` without any.
    pub sky: Option<[f32; 3]>,
}

/// A view.
#[derive(Debug, Clone, Serialize)]
pub struct DescribedView {
    /// The name.
    pub name: String,
    /// The camera's centre.
    pub centre: [f64; 3],
    /// The rotation from world to camera, by rows.
    pub rotation: [f64; 9],
    /// Half the angle of view from top to bottom, as a tangent.
    pub tangent: f64,
}

/// A flight.
#[derive(Debug, Serialize)]
pub struct DescribedTour {
    /// The time of each view, in seconds.
    pub times: Vec<f64>,
    /// The views.
    pub views: Vec<DescribedView>,
}

impl DescribedView {
    /// Describes a pose with the tangent of half the angle from top to bottom.
    pub fn new(name: String, pose: &Pose, tangent: f64, origin: DVec3) -> Self {
        let centre = (pose.center_in_world() - origin).to_array();
        Self { name, centre, rotation: by_rows(&pose.rotation), tangent }
    }

    /// Describes the view of a photo.
    pub fn of_photo(name: String, camera: &Pinhole, pose: &Pose, origin: DVec3) -> Self {
        Self::new(name, pose, f64::from(camera.height) / 2.0 / camera.fy, origin)
    }
}

impl DescribedTour {
    /// The views of a flight in each second; the viewer goes from one to the next.
    const PER_SECOND: f64 = 2.0;

    /// Describes a camera path; `None` where it is no flight.
    pub fn of_path(path: &CameraPath, up: DVec3, origin: DVec3) -> Option<Self> {
        let flight = path.flight(up).ok()?;
        let [from, to] = flight.span_s();
        let count = ((to - from) * Self::PER_SECOND).ceil().clamp(1.0, 600.0) as u32;
        let times: Vec<f64> =
            (0..=count).map(|at| from + (to - from) * f64::from(at) / f64::from(count)).collect();
        let view = |time: &f64| {
            let (camera, pose) = flight.at(*time);
            DescribedView::of_photo(String::new(), &camera, &pose, origin)
        };
        Some(Self {
            views: times.iter().map(view).collect(),
            times: times.iter().map(|time| time - from).collect(),
        })
    }
}

/// Returns a matrix by rows.
pub fn by_rows(matrix: &DMat3) -> [f64; 9] {
    matrix.transpose().to_cols_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_near_the_start_come_first() {
        let photo = |x: f64| DescribedPhoto {
            name: String::new(),
            size: [3, 2],
            lens: [2.0, 2.0, 1.5, 1.0],
            rotation: by_rows(&DMat3::IDENTITY),
            centre: [x, 0.0, 0.0],
            stored: [3, 2],
            turned: false,
            far: [3, 2],
            gain: [0.0; 3],
            optics: [0.0; 3],
            colour: String::new(),
            sky: None,
        };
        let photos: Vec<_> = [9.0, 8.0, 1.0, 7.0, 2.0].map(photo).into();
        let far = |first: usize, photos: usize| DescribedFar { chunk: format!("far-{first}"), first, photos };
        let mut chunks = [far(0, 2), far(2, 2), far(4, 1)];
        let start = DescribedView {
            name: String::new(),
            centre: [0.0; 3],
            rotation: by_rows(&DMat3::IDENTITY),
            tangent: 1.0,
        };
        DescribedFar::sort_by_nearness(&mut chunks, &photos, &start, 10.0);
        assert_eq!(chunks.map(|chunk| chunk.chunk), ["far-2", "far-4", "far-0"]);
    }
}
