//! The gains of the surroundings: how photos' skies differ from one common sky.
//!
//! The gains of photos are measured on surfaces, and do not explain skies: these are clipped, darken towards corners, and change
//! while photos are taken. Each photo therefore has factors that vary slowly over the picture, on a grid, which bring what it
//! shows of the surroundings to one sky that all photos share (`layers::one_sky`). So there is no step where one
//! photo ends. A photo's own camera shows the photo as it is; the factors take effect as the view leaves it.

use glam::{DVec2, DVec3};

use super::near::Shares;
use crate::Projector;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::PhotoId;
use quadratura_view::Shot;

/// The number of cells of a photo's grid along both sides.
pub const GRID: usize = 32;

/// The distance of a view's camera from a photo's, as a share of the scale of the surroundings, from which on the photo's factors
/// are fully in effect.
const AWAY: f64 = 0.1;

/// The distance by which a view reaches beyond a photo, as a share of the photo's longer side, from which on they are, too.
const BEYOND: f64 = 0.1;

/// The factors of one photo on light in the common exposure, as natural logarithms, R, G, B.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SurroundingsFactors {
    /// That of the photo as a whole.
    pub offset: [f32; 3],
    /// Those at the middles of the cells of a grid of [`GRID`] x [`GRID`] over the photo, row by row.
    pub cells: Vec<[f32; 3]>,
}

impl SurroundingsFactors {
    /// Returns the factors of a photo that is brought to one sky by one factor throughout.
    pub fn constant(offset: [f32; 3]) -> Self {
        Self { offset, cells: vec![offset; GRID * GRID] }
    }

    /// Returns the product of both, the sum of their logarithms.
    pub fn times(&self, other: &Self) -> Self {
        let sum = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| a[c] + b[c]);
        let cells = self.cells.iter().zip(&other.cells).map(|(a, b)| sum(*a, *b)).collect();
        Self { offset: sum(self.offset, other.offset), cells }
    }

    /// Interpolates between the cells at a position in pixels of the photo's camera; logarithms.
    pub fn at(&self, camera: &Pinhole, px: DVec2) -> [f32; 3] {
        let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
        let last = (GRID - 1) as f64;
        let at = (px / size * GRID as f64 - 0.5).clamp(DVec2::ZERO, DVec2::splat(last));
        let base = at.floor().min(DVec2::splat(last - 1.0));
        let share = (at - base).as_vec2();
        let cell = |dx: usize, dy: usize| self.cells[(base.y as usize + dy) * GRID + base.x as usize + dx];
        [0, 1, 2].map(|c| {
            let row = |dy: usize| cell(0, dy)[c] + (cell(1, dy)[c] - cell(0, dy)[c]) * share.x;
            row(0) + (row(1) - row(0)) * share.y
        })
    }
}

/// The gains of the surroundings of all photos.
#[derive(Debug, Clone, PartialEq)]
pub struct SurroundingsGains {
    /// The factors of each photo, in the site's order; `None` for photos without surroundings. Empty where none are known.
    pub of_photo: Vec<Option<SurroundingsFactors>>,
    /// The light, in the common exposure, that the largest value of the dome's texels stands for.
    pub dome_white: f32,
    /// The distance between cameras from which they see other surroundings, in world units.
    pub scale: f64,
}

impl Default for SurroundingsGains {
    fn default() -> Self {
        Self { of_photo: Vec::new(), dome_white: 1.0, scale: 0.0 }
    }
}

/// What a view does with the surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct SurroundingsExposure {
    /// How far the view has left each photo's own camera, 0 to 1.
    pub left: Vec<f64>,
    /// How far each photo's factors are in effect, 0 to 1; empty where there are none.
    pub shares: Vec<f64>,
    /// The factor that brings the common sky to that of the photos near the view, as far as it is one for whole photos.
    pub of_sky: [f64; 3],
    /// The light that the largest value of the dome's texels stands for.
    pub dome_white: f64,
}

impl Default for SurroundingsExposure {
    fn default() -> Self {
        Self { left: Vec::new(), shares: Vec::new(), of_sky: [1.0; 3], dome_white: 1.0 }
    }
}

impl SurroundingsExposure {
    /// Returns how far the view has left a photo's own camera; not at all for the dome, whose ids follow the photos'.
    pub fn left(&self, photo: PhotoId) -> f64 {
        self.left.get(photo.index()).copied().unwrap_or(0.0)
    }

    /// Returns how far a photo's factors are in effect; fully for the dome, whose ids follow the photos', since it is the common sky.
    pub fn share(&self, photo: PhotoId) -> f64 {
        self.shares.get(photo.index()).copied().unwrap_or(if self.shares.is_empty() { 0.0 } else { 1.0 })
    }
}

impl SurroundingsGains {
    /// Returns the factors on a photo's light at a position (photo pixels), interpolated between the cells; 1 without any.
    pub fn at(&self, photo: PhotoId, camera: &Pinhole, px: DVec2) -> [f64; 3] {
        match self.of_photo.get(photo.index()) {
            Some(Some(factors)) => factors.at(camera, px).map(|log| f64::from(log).exp()),
            _ => [1.0; 3],
        }
    }

    /// Computes what a view does with the surroundings of these photos, whose skies it has with these shares.
    pub fn exposed(&self, shot: &Shot, photos: &[Projector], skies: &Shares) -> SurroundingsExposure {
        let left = self.left(shot, photos);
        let share =
            |(left, factors): (&f64, &Option<SurroundingsFactors>)| factors.as_ref().map_or(0.0, |_| *left);
        let shares = left.iter().zip(&self.of_photo).map(share).collect();
        // A sky that changed while photos were taken is that of the photos nearby, as exposures are.
        let own = |c: usize| {
            let offsets = self.of_photo.iter().zip(&skies.of_photo);
            offsets.map(move |(factors, share)| {
                share * factors.as_ref().map_or(0.0, |of| -f64::from(of.offset[c]))
            })
        };
        let of_sky = [0, 1, 2].map(|c| own(c).sum::<f64>().exp());
        SurroundingsExposure { left, shares, of_sky, dome_white: f64::from(self.dome_white) }
    }

    /// Returns how far a view has left the own camera of each photo, 0 to 1.
    pub fn left(&self, shot: &Shot, photos: &[Projector]) -> Vec<f64> {
        photos.iter().map(|photo| left(shot, photo, self.scale)).collect()
    }
}

/// Returns how far a view has left a photo's own camera, 0 to 1: by its place, or by showing what is beyond the photo. It changes
/// gradually with the view.
fn left(shot: &Shot, photo: &Projector, scale: f64) -> f64 {
    let away = photo.pose.center_in_world().distance(shot.viewpoint()) / scale.max(f64::MIN_POSITIVE);
    let view = &shot.camera;
    let corners = [[0, 0], [view.width, 0], [0, view.height], [view.width, view.height]];
    let beyond = corners.map(|[x, y]| {
        let ray = view.ray_in_camera(DVec2::new(f64::from(x), f64::from(y)));
        beyond(photo, shot.pose.rotation.transpose() * ray)
    });
    let t = (away / AWAY + beyond.into_iter().fold(0.0, f64::max) / BEYOND).min(1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns how far a direction (world) is beyond a photo's frame, as a share of its longer side; 1 behind the camera.
fn beyond(photo: &Projector, direction: DVec3) -> f64 {
    let camera = &photo.camera;
    let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
    let Some(px) = camera.image_from_camera(photo.pose.rotation * direction) else { return 1.0 };
    let off = (px - size).max(-px).max_element().max(0.0) / size.max_element();
    off.min(1.0)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use quadratura_base::geometry::Pose;

    const CAMERA: Pinhole = Pinhole { width: 300, height: 200, fx: 200.0, fy: 200.0, cx: 150.0, cy: 100.0 };

    fn photo() -> Projector {
        let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        Projector { name: "a".into(), camera: CAMERA, pose }
    }

    #[test]
    fn factors_are_interpolated_between_cells_and_constant_outside_of_their_middles() {
        let cells = (0..GRID * GRID).map(|at| [(at % GRID) as f32, (at / GRID) as f32, 1.0]).collect();
        let factors = SurroundingsFactors { offset: [0.0; 3], cells };
        let at = |x: f64, y: f64| factors.at(&CAMERA, DVec2::new(x, y));
        assert_eq!(at(0.0, 0.0), [0.0, 0.0, 1.0]);
        assert_eq!(at(300.0, 200.0), [31.0, 31.0, 1.0]);
        let middle = at(150.0, 100.0);
        assert!((0..2).all(|c| (middle[c] - 15.5).abs() < 1e-4), "{middle:?}");
        let gains = SurroundingsGains { of_photo: vec![Some(factors), None], ..Default::default() };
        assert_eq!(gains.at(PhotoId(1), &CAMERA, DVec2::ZERO), [1.0; 3]);
        assert_eq!(gains.at(PhotoId(7), &CAMERA, DVec2::ZERO), [1.0; 3]);
        assert!((gains.at(PhotoId(0), &CAMERA, DVec2::ZERO)[2] - 1f64.exp()).abs() < 1e-6);
    }

    #[test]
    fn a_photos_own_camera_shows_the_photo_and_views_leave_it_gradually() {
        let photo = photo();
        let gains = SurroundingsGains {
            of_photo: vec![Some(SurroundingsFactors::constant([0.1; 3]))],
            scale: 2.0,
            ..Default::default()
        };
        let share = |pose: Pose, camera: Pinhole| {
            let shot = Shot::new(camera, pose);
            let skies = Shares { of_photo: vec![1.0], of_common: 0.0, takes_part: vec![true] };
            gains.exposed(&shot, std::slice::from_ref(&photo), &skies).share(PhotoId(0))
        };
        let turned = |angle: f64| Pose { rotation: DMat3::from_rotation_y(angle), ..photo.pose };
        let moved = |x: f64| Pose { translation: DVec3::X * x, ..photo.pose };
        assert_eq!(share(photo.pose, CAMERA), 0.0);
        let zoomed = Pinhole { fx: 400.0, fy: 400.0, ..CAMERA };
        assert_eq!(share(turned(0.05), zoomed), 0.0, "a view within the photo");
        assert_eq!(
            (share(turned(0.5), CAMERA), share(turned(3.0), CAMERA), share(moved(0.5), CAMERA)),
            (1.0, 1.0, 1.0)
        );
        let shares: Vec<f64> = (0..200).map(|i| share(turned(f64::from(i) * 1e-3), CAMERA)).collect();
        assert!(shares.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.03), "gradually");
        let shares: Vec<f64> = (0..200).map(|i| share(moved(f64::from(i) * 1e-3), CAMERA)).collect();
        assert!(shares.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.02), "gradually");
    }
}
