//! A photo at the working size: its colours, its greys and its camera, in normalised coordinates.

use glam::{DMat3, DVec2, DVec3};

use quadratura_base::geometry::{Pinhole, PixelRect, Plane, Pose};
use quadratura_base::raster::Image;

/// A photo as a model is suggested from it.
#[derive(Debug, Clone)]
pub struct SourcePhoto {
    /// The camera for the size of `pixels`.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The colours in sRGB; alpha is below 255 where nothing is known. The longer side has [`FINE_PX`] pixels, fewer where the
    /// photo has fewer.
    pub pixels: Image<[u8; 4]>,
}

impl SourcePhoto {
    /// Returns the photo at half its size.
    pub fn halved(&self) -> Self {
        let small = Halved::new(self);
        let pixel = |([r, g, b], known): (&[f32; 3], &bool)| {
            [*r as u8, *g as u8, *b as u8, if *known { 255 } else { 0 }]
        };
        let pixels = small.colours.iter().zip(&small.known).map(pixel).collect();
        let rect = PixelRect::of_size(small.camera.width, small.camera.height);
        Self { camera: small.camera, pose: self.pose, pixels: Image::new(rect, pixels) }
    }
}

/// The longer side of the photos that are compared, in pixels. Labels are at half of it: an eighth of 3072 x 2048, at which
/// every figure of the method was measured.
pub const FINE_PX: u32 = 768;

/// Greys on a grid, with the camera for it.
#[derive(Debug, Clone)]
pub struct Greys {
    /// The camera for this size.
    pub camera: Pinhole,
    /// The greys, 0 to 255, row by row.
    pub values: Vec<f32>,
}

impl Greys {
    /// Returns the numbers of columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.camera.width as usize, self.camera.height as usize]
    }

    /// Interpolates between pixels; `None` outside of the photo.
    #[inline]
    pub fn at(&self, px: DVec2) -> Option<f32> {
        let [w, h] = self.size();
        let (x, y) = (px.x - 0.5, px.y - 0.5);
        if !(x > -0.5 && y > -0.5 && x < w as f64 - 0.5 && y < h as f64 - 0.5) {
            return None;
        }
        let (x, y) = (x.clamp(0.0, (w - 1) as f64), y.clamp(0.0, (h - 1) as f64));
        let (i, j) = ((x as usize).min(w.saturating_sub(2)), (y as usize).min(h.saturating_sub(2)));
        let (u, v) = ((x - i as f64) as f32, (y - j as f64) as f32);
        let (right, below) = ((i + 1).min(w - 1), (j + 1).min(h - 1));
        let value = |x: usize, y: usize| self.values[y * w + x];
        let above = value(i, j) * (1.0 - u) + value(right, j) * u;
        let under = value(i, below) * (1.0 - u) + value(right, below) * u;
        Some(above * (1.0 - v) + under * v)
    }
}

/// A photo at the working size.
#[derive(Debug, Clone)]
pub struct WorkingPhoto {
    /// The pose, normalised world to camera.
    pub pose: Pose,
    /// The camera's centre.
    pub eye: DVec3,
    /// The greys at the working size.
    pub greys: Greys,
    /// The greys at twice that size.
    pub fine: Greys,
    /// The colours at the working size, 0 to 255, row by row.
    pub colours: Vec<[f32; 3]>,
    /// Whether the photo shows anything at a pixel of the working size.
    pub known: Vec<bool>,
}

impl WorkingPhoto {
    /// Prepares a photo. `world = origin + unit * normalised`.
    pub fn new(photo: &SourcePhoto, origin: DVec3, unit: f64) -> Self {
        let Pose { rotation, translation } = photo.pose;
        let pose = Pose { rotation, translation: (rotation * origin + translation) / unit };
        let fine = Greys { camera: photo.camera, values: photo.pixels.pixels().iter().map(grey).collect() };
        let small = Halved::new(photo);
        let values = small.colours.iter().map(|[r, g, b]| 0.299 * r + 0.587 * g + 0.114 * b).collect();
        let greys = Greys { camera: small.camera, values };
        Self { pose, eye: pose.center_in_world(), greys, fine, colours: small.colours, known: small.known }
    }

    /// Returns the camera at the working size.
    pub fn camera(&self) -> &Pinhole {
        &self.greys.camera
    }

    /// Returns the numbers of columns and rows at the working size.
    pub fn size(&self) -> [usize; 2] {
        self.greys.size()
    }

    /// Projects a point to pixels of the working size, with its depth; `None` behind the camera and outside of the photo.
    pub fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let at = self.pose.camera_from_world(point);
        let px = self.camera().image_from_camera(at)?;
        self.camera().rect().contains_position(px).then_some((px, at.z))
    }

    /// Returns the index of the pixel at a position within the photo.
    pub fn index(&self, px: DVec2) -> usize {
        let [w, h] = self.size();
        (px.y as usize).min(h - 1) * w + (px.x as usize).min(w - 1)
    }

    /// Returns the direction of a pixel's ray in the world, of depth 1.
    pub fn ray(&self, px: DVec2) -> DVec3 {
        self.pose.rotation.transpose() * self.camera().ray_in_camera(px)
    }

    /// Returns the inverse depth of a plane over the photo.
    pub fn inverse_depth(&self, plane: &Plane) -> PlaneDepth {
        let normal = self.pose.rotation * plane.normal;
        let distance = -plane.signed_distance(self.eye);
        let camera = self.camera();
        let (x, y) = (normal.x / camera.fx / distance, normal.y / camera.fy / distance);
        let first = (normal.dot(camera.ray_in_camera(DVec2::splat(0.5)))) / distance;
        PlaneDepth { x, y, first }
    }
}

/// The inverse depth of a plane: affine over the pixels of a photo.
#[derive(Debug, Clone, Copy)]
pub struct PlaneDepth {
    x: f64,
    y: f64,
    first: f64,
}

impl PlaneDepth {
    /// What is infinitely far away.
    pub const FAR: Self = Self { x: 0.0, y: 0.0, first: 0.0 };

    /// Returns the inverse depth at the centre of a pixel: positive in front of the camera.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> f64 {
        self.between(x as f64, y as f64)
    }

    /// Returns the inverse depth between the centres of pixels.
    #[inline]
    pub fn between(&self, x: f64, y: f64) -> f64 {
        self.first + self.x * x + self.y * y
    }
}

/// The homography and the epipole that take a pixel of one photo with its inverse depth to another photo.
pub struct Warp {
    infinite: DMat3,
    epipole: DVec3,
}

impl Warp {
    /// Prepares the warp between two cameras.
    pub fn new(from: (&Pinhole, &Pose), to: (&Pinhole, &Pose)) -> Self {
        let rotation = to.1.rotation * from.1.rotation.transpose();
        let shift = to.1.translation - rotation * from.1.translation;
        let matrix = |camera: &Pinhole| {
            DMat3::from_cols(
                DVec3::new(camera.fx, 0.0, 0.0),
                DVec3::new(0.0, camera.fy, 0.0),
                DVec3::new(camera.cx, camera.cy, 1.0),
            )
        };
        Self { infinite: matrix(to.0) * rotation * matrix(from.0).inverse(), epipole: matrix(to.0) * shift }
    }

    /// Returns where the other photo shows what is at a pixel; `None` behind its camera.
    #[inline]
    pub fn at(&self, px: DVec2, inverse_depth: f64) -> Option<DVec2> {
        self.with_scale(px, inverse_depth).map(|(at, _)| at)
    }

    /// Returns also the depth in the other photo, times the inverse depth in the first.
    #[inline]
    pub fn with_scale(&self, px: DVec2, inverse_depth: f64) -> Option<(DVec2, f64)> {
        let at = self.infinite * px.extend(1.0) + self.epipole * inverse_depth;
        (at.z > 1e-9).then(|| (at.truncate() / at.z, at.z))
    }
}

fn grey(pixel: &[u8; 4]) -> f32 {
    0.299 * f32::from(pixel[0]) + 0.587 * f32::from(pixel[1]) + 0.114 * f32::from(pixel[2])
}

/// A photo at half its size; the last column and row of odd sides are dropped.
struct Halved {
    camera: Pinhole,
    colours: Vec<[f32; 3]>,
    known: Vec<bool>,
}

impl Halved {
    fn new(photo: &SourcePhoto) -> Self {
        use quadratura_base::raster::halving::OddSide;
        let pixels = photo.pixels.pixels();
        let mean = |four: &[usize]| {
            let colour = [0, 1, 2]
                .map(|c| four.iter().map(|at| f32::from(pixels[*at][c])).sum::<f32>() / four.len() as f32);
            (colour, four.iter().all(|at| pixels[*at][3] == u8::MAX))
        };
        let half = photo.pixels.halved(OddSide::Dropped, mean);
        let [w, h] = half.size();
        let Pinhole { fx, fy, cx, cy, .. } = photo.camera;
        let camera = Pinhole {
            width: w as u32,
            height: h as u32,
            fx: fx / 2.0,
            fy: fy / 2.0,
            cx: cx / 2.0,
            cy: cy / 2.0,
        };
        let (colours, known) = half.into_pixels().into_iter().unzip();
        Self { camera, colours, known }
    }
}
