//! A reader judges itself: where the cameras show the points, compared with where these were observed.
//!
//! A file that is read in another convention than it was written in has cameras that look plausible one by one. Its own
//! observations tell: with the right convention they are off by about a pixel, with a wrong one by tens. The conventions in
//! which formats and programs differ are tried, and proposed where one explains the observations better; none is taken by itself.

use glam::{DMat3, DVec2, DVec3};

use super::kept::CameraPhoto;
use super::pose::CV_FROM_GL;
use super::triangulate::triangulated;
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::SparsePoint;

/// How far the observations of points lie from where the cameras show these.
#[derive(Debug, Clone, PartialEq)]
pub struct Reprojection {
    /// The median distance, in pixels of the photos as taken; infinite where most points are behind the cameras.
    pub median_px: f64,
    /// The number of observations.
    pub observations: usize,
    /// What the median would be in other conventions, the best first; empty where nothing is wrong.
    pub variants: Vec<(&'static str, f64)>,
}

/// With fewer observations nothing is judged.
const FEWEST: usize = 20;
/// About the most observations that are compared; of more, those of every n-th point are.
const COMPARED: usize = 20_000;
/// The median, in pixels, above which a convention is probably wrong. Bundle adjustment leaves about one.
const SUSPICIOUS_PX: f64 = 3.0;
/// A variant is proposed whose median is at most this share of that of the file as it was read.
const BETTER: f64 = 0.5;

/// A convention: its name, and the changes of a photo and of a place that it means.
type Variant = (&'static str, fn(&mut CameraPhoto, &mut DVec2));

/// The conventions in which programs differ.
const VARIANTS: [Variant; 13] = [
    ("y of observations upwards", |photo, at| at.y = f64::from(photo.camera.height) - at.y),
    ("observations from the middle of the photo", |photo, at| *at += middle(photo)),
    ("observations from the corner of the photo", |photo, at| *at -= middle(photo)),
    ("pixel centres at whole numbers", |_, at| *at += 0.5),
    ("pixel centres at whole numbers, the other way", |_, at| *at -= 0.5),
    ("the rotation transposed", |photo, _| {
        let centre = photo.pose.center_in_world();
        photo.pose = posed(photo.pose.rotation.transpose(), centre);
    }),
    ("the pose from camera to world", |photo, _| {
        photo.pose = posed(photo.pose.rotation.transpose(), photo.pose.translation);
    }),
    ("cameras that look along -z with y upwards", |photo, _| {
        photo.pose = posed(CV_FROM_GL * photo.pose.rotation, photo.pose.center_in_world());
    }),
    ("the distortion with the other sign", |photo, _| photo.lens = changed(photo.lens, -1.0, false)),
    ("the tangential coefficients in the other order", |photo, _| {
        photo.lens = changed(photo.lens, 1.0, true)
    }),
    ("no distortion", |photo, _| photo.lens = Lens::None),
    ("the principal point on the other side", |photo, _| {
        let to = 2.0 * middle(photo);
        (photo.camera.cx, photo.camera.cy) = (to.x - photo.camera.cx, to.y - photo.camera.cy);
    }),
    ("the principal point from the middle of the photo", |photo, _| {
        let by = middle(photo);
        (photo.camera.cx, photo.camera.cy) = (photo.camera.cx + by.x, photo.camera.cy + by.y);
    }),
];

fn middle(photo: &CameraPhoto) -> DVec2 {
    0.5 * DVec2::new(photo.camera.width.into(), photo.camera.height.into())
}

fn posed(rotation: DMat3, centre: DVec3) -> Pose {
    Pose { rotation, translation: -(rotation * centre) }
}

/// Returns the lens with its coefficients times `sign`, and the two tangential ones exchanged if `swapped`.
fn changed(lens: Lens, sign: f64, swapped: bool) -> Lens {
    let turned = |p: [f64; 2]| if swapped { [sign * p[1], sign * p[0]] } else { p.map(|p| sign * p) };
    match lens {
        Lens::Brown { k, p } => Lens::Brown { k: k.map(|k| sign * k), p: turned(p) },
        Lens::Skewed { k, p, skew } => Lens::Skewed { k: k.map(|k| sign * k), p: turned(p), skew },
        Lens::Fisheye { k, p, s } => Lens::Fisheye { k: k.map(|k| sign * k), p: turned(p), s },
        Lens::PrismFisheye { k, p, s } => Lens::PrismFisheye { k: k.map(|k| sign * k), p: turned(p), s },
        Lens::Division { k } => Lens::Division { k: sign * k },
        Lens::Reverse { k } => Lens::Reverse { k: sign * k },
        Lens::None | Lens::Fov { .. } | Lens::Eucm { .. } => lens,
    }
}

impl Reprojection {
    /// Compares points with their observations, which count through `photos`; `None` where there are too few. The positions of
    /// points that were `triangulated` from their observations follow these in other conventions.
    pub(super) fn new(photos: &[CameraPhoto], points: &[SparsePoint], triangulated: bool) -> Option<Self> {
        let observations = points.iter().map(|point| point.observations.len()).sum::<usize>();
        if observations < FEWEST {
            return None;
        }
        let every = observations.div_ceil(COMPARED);
        let compared: Vec<&SparsePoint> = points.iter().step_by(every).collect();
        let median_px = median(photos, &compared, false, |_, _| ());
        let mut variants = Vec::new();
        if median_px > SUSPICIOUS_PX {
            let of = |(name, change): &Variant| (*name, median(photos, &compared, triangulated, change));
            variants.extend(VARIANTS.iter().map(of));
            variants.sort_by(|a, b| a.1.total_cmp(&b.1));
        }
        Some(Self { median_px, observations, variants })
    }

    /// Returns the convention that explains the observations clearly better than the one in which they were read, with its median in
    /// pixels.
    pub fn better(&self) -> Option<(&'static str, f64)> {
        self.variants.first().copied().filter(|(_, median)| *median <= BETTER * self.median_px)
    }

    /// Returns a warning where the cameras hardly fit their own observations.
    pub fn warning(&self) -> Option<String> {
        if self.variants.is_empty() {
            return None;
        }
        let head = format!(
            "the median reprojection error of its {} observations is {}, where up to {SUSPICIOUS_PX} px are expected",
            self.observations,
            px(self.median_px)
        );
        if let Some((name, median)) = self.better() {
            return Some(format!(
                "{head}: the file may use another convention than the one in which it was read. With {name} it would be {}. Nothing is changed: \
                 correct the file, or export the cameras in another format, such as COLMAP's",
                px(median)
            ));
        }
        let tried: Vec<String> =
            self.variants.iter().map(|(name, median)| format!("{name} ({})", px(*median))).collect();
        Some(format!(
            "{head}. Conventions that were tried and are not clearly better: {}. Check that cameras and points are of one \
             reconstruction, or export them in another format, such as COLMAP's",
            tried.join(", ")
        ))
    }
}

impl std::fmt::Display for Reprojection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (median of {} observations)", px(self.median_px), self.observations)
    }
}

/// Formats a distance in pixels.
fn px(distance: f64) -> String {
    match distance {
        _ if !distance.is_finite() => "infinite, as most points are behind the cameras".into(),
        _ if distance >= 100.0 => format!("{distance:.0} px"),
        _ => format!("{distance:.2} px"),
    }
}

/// Returns the median distance of the observations of points after a change of convention. Points that a camera does not show are
/// infinitely far.
fn median(
    photos: &[CameraPhoto],
    points: &[&SparsePoint],
    triangulate: bool,
    change: impl Fn(&mut CameraPhoto, &mut DVec2),
) -> f64 {
    let mut distances = Vec::new();
    for point in points {
        let known =
            point.observations.iter().filter_map(|&(photo, at)| Some((photos.get(photo as usize)?, at)));
        let changed = known.map(|(photo, mut at)| {
            // Only what a change may touch is copied.
            let mut photo = CameraPhoto { name: String::new(), place: String::new(), ..*photo };
            change(&mut photo, &mut at);
            (photo, at)
        });
        let changed: Vec<(CameraPhoto, DVec2)> = changed.collect();
        let position = match triangulate {
            false => Some(point.position),
            true => triangulated(&changed.iter().map(|(photo, at)| (photo, *at)).collect::<Vec<_>>()),
        };
        distances.extend(changed.iter().map(|(photo, at)| {
            let shown = position.and_then(|position| photo.image_from_world(position));
            shown.map_or(f64::INFINITY, |shown| shown.distance(*at))
        }));
    }
    upper_median(&mut distances).unwrap_or(0.0)
}
