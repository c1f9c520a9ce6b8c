//! The description of one novel view: camera, blending of photos, and display mode.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use glam::{DMat3, DVec3};

use super::hidden::{Culling, HiddenFaces};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::raster::over::on_opaque;
use quadratura_base::scene::PhotoId;

/// The formula by which photos are selected and weighted at a surface point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Mode {
    /// The photo of least penalty alone.
    Best,
    /// Weights by angles alone: inverse angle, the nearest photos (Debevec, Yu & Borshukov 1998, section 3).
    Debevec,
    /// Unstructured lumigraph weights (Buehler et al. 2001): `w = max(0, 1 - q/T) / q`.
    Lumigraph,
    /// Franke-Little weights: `w = (max(0, T - q) / (T q))^2`, once continuously differentiable.
    #[default]
    Smooth,
}

impl Mode {
    /// All modes, in the order of the command line's help.
    pub const ALL: [Self; 4] = [Self::Best, Self::Debevec, Self::Lumigraph, Self::Smooth];

    /// Returns the mode's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Best => "best",
            Self::Debevec => "debevec",
            Self::Lumigraph => "lumigraph",
            Self::Smooth => "smooth",
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        Self::ALL.into_iter().find(|mode| mode.name() == text).ok_or_else(|| {
            format!("{text} is not a blending mode; the modes are {}", Self::ALL.map(Self::name).join(", "))
        })
    }
}

/// Options of the blending of photos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blend {
    /// The formula of the weights.
    pub mode: Mode,
    /// The largest number of photos blended per surface point; 1 to [`Blend::MOST`].
    pub photos: u32,
    /// The weight of the resolution penalty, in radians per octave of missing resolution.
    pub lambda: f64,
    /// True when photos count less where others contradict them (`agreement`).
    pub agreement: bool,
    /// True when contradicted texels count less in their photo's own camera, too, so that it shows what the others show
    /// there. It has no effect without [`Self::agreement`].
    pub without_transients: bool,
}

impl Blend {
    /// The upper limit of [`Blend::photos`].
    pub const MOST: u32 = 8;

    /// Returns the factor of `1 - agreement` in penalties, in radians.
    pub fn transient_angle(&self) -> f64 {
        f64::from(u8::from(self.without_transients))
    }
}

impl Default for Blend {
    fn default() -> Self {
        Self { mode: Mode::default(), photos: 4, lambda: 0.1, agreement: true, without_transients: false }
    }
}

/// The quality of texture filtering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quality {
    /// One sample per pixel, trilinear filtering; for interaction.
    Preview,
    /// Four samples per pixel at edges, anisotropic filtering; for results.
    #[default]
    Final,
    /// One sample per pixel, anisotropic filtering; for finer images, of which several pixels become one.
    Finer,
}

impl Quality {
    /// Returns whether lookups follow the footprint of a pixel.
    pub fn is_anisotropic(self) -> bool {
        match self {
            Self::Preview => false,
            Self::Final | Self::Finer => true,
        }
    }

    /// Returns whether edges have several samples per pixel.
    pub fn is_multisampled(self) -> bool {
        match self {
            Self::Preview | Self::Finer => false,
            Self::Final => true,
        }
    }
}

/// The largest number of samples along each side of a pixel of an image that is drawn as finely as photos show it
/// ([`Shot::supersampled`]).
pub const MOST_SAMPLES: f64 = 8.0;

/// The largest number of lookups along the longer axis of a pixel's footprint, in *final* quality.
pub const MOST_TAPS: f64 = 8.0;

/// The display mode: the quantity that an image shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum DisplayMode {
    /// The blended photos.
    #[default]
    Colour,
    /// An identifying colour per photo, in stripes as wide as the photos' weights: no mixture looks like another photo.
    Weights,
    /// The identifying colour of the photo of the largest weight.
    BestPhoto,
    /// The identifying colour of the group of light of the photo of the largest weight.
    Group,
    /// The resolution: texels of the best photo per pixel of the image, in octaves around one.
    Density,
    /// The largest confidence among the contributing photos.
    Confidence,
    /// How far other photos confirm the photo that would be best if agreement did not count (`agreement`).
    Agreement,
    /// An identifying colour per image layer, that of the best photo.
    Layer,
    /// An identifying colour per face.
    Item,
    /// The number of photos that can contribute to the point.
    Coverage,
    /// How much see-through surfaces cover of what is behind them; other surfaces are dark.
    Matte,
    /// The source of the texels: a colour for each origin ([`super::legend::Origin`]), mixed by the photos'
    /// weights.
    Provenance,
}

/// How the trees of a site are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum TreeMethod {
    /// They are left out; what they replace does not come back.
    None,
    /// From the images of their sub-objects as far as these are fine enough, the rest as polygons; trees without images as polygons.
    #[default]
    Flakes,
    /// Every polygon of every tree.
    Polygons,
}

/// What is drawn where no photo shows what is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Unseen {
    /// Surfaces are left empty, the surroundings continue: for work on the photos.
    #[default]
    Marked,
    /// Surfaces continue, too (`continuation`): for final pictures.
    Continued,
    /// Nothing: surfaces and surroundings are left empty.
    Empty,
}

/// The exposure of an image.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// As the site's rule says, which is decided by leaving photos out (`exposure::ExposureRule`).
    #[default]
    Decided,
    /// The blend of the photos' gains by their part in the view; a photo's own camera has the photo's
    /// exposure.
    Near,
    /// As a camera's exposure meter would choose it, where the photos' exposures follow their meters; the common exposure
    /// otherwise.
    Metered,
    /// The common exposure to which all photos are brought.
    Common,
    /// The exposure of one photo, for any camera.
    Of(PhotoId),
    /// The exposure that the view's camera wrote down, as a natural logarithm, where those of the photos suit views
    /// (`exposure::CameraExposures`); otherwise as the site's rule says.
    AsTaken(f64),
    /// The photos unchanged, with their different exposures.
    Raw,
}

/// Parallel rays: an orthographic view. Its camera is a pinhole so far away that nobody can tell it from parallel rays in f64
/// ([`FAR`]), for computations on the processor; devices, which compute in f32, draw exactly parallel rays around a reference point near
/// the surfaces. So the weights of photos are those of one direction, that of the projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelRays {
    /// The distance of the reference point from the viewpoint along the axis, in world units.
    pub distance: f64,
    /// The extent of all that may be seen, in world units.
    pub extent: f64,
    /// Nothing in front of this depth is shown; in world units behind the reference point. `None`: all is shown.
    pub from_depth: Option<f64>,
}

/// The distance of the viewpoint of parallel rays in extents of what is seen: rays converge by half a thousandth of a pixel in a picture of
/// a thousand, and f64 still places points to a billionth of the extent.
pub const FAR: f64 = 1e6;

/// Within this share of the depth, or of the extent seen by parallel rays, surfaces count as one.
const TOLERANCE: f64 = 1e-4;
/// The same of parallel rays, whose depths have no perspective to be exact for.
const TOLERANCE_OF_PARALLEL: f64 = 1e-5;

/// The plane of an orthographic picture in world coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PicturePlane {
    /// The point in the middle of the picture: the reference point.
    pub middle: DVec3,
    /// The unit direction to the right in the picture.
    pub right: DVec3,
    /// The unit direction down in the picture, at right angles to `right`. The view looks along `right x down`.
    pub down: DVec3,
}

impl PicturePlane {
    /// Returns the unit direction of the rays.
    pub fn forward(&self) -> DVec3 {
        self.right.cross(self.down)
    }
}

/// The description of one novel view.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Image size and intrinsics in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// What makes the view an orthographic one; `None` for perspective.
    pub parallel: Option<ParallelRays>,
    /// The blending of photos.
    pub blend: Blend,
    /// The quality of filtering.
    pub quality: Quality,
    /// The display mode.
    pub display: DisplayMode,
    /// The exposure.
    pub exposure: Exposure,
    /// True when surfaces are displayed with their relief, false when flat as modelled.
    pub relief: bool,
    /// True when the back sides of faces (`sides`) are visible like all others, false when they are
    /// culled.
    pub backs: bool,
    /// Photos that must not take part, such as those that are to be predicted.
    pub without: Vec<PhotoId>,
    /// The faces that are left out, so that what is behind them is visible.
    pub hidden: HiddenFaces,
    /// How trees are drawn.
    pub trees: TreeMethod,
    /// The time that trees may take in *previews* that follow each other: where they take longer, coarser images serve from picture to
    /// picture. `None`: as fine as the quality says, so that the same view is always the same picture.
    pub trees_within: Option<Duration>,
    /// True when the photos' surroundings are drawn where no face is, false when nothing is.
    pub surroundings: bool,
    /// True when the image is drawn in linear light, with more than 8 bits a channel, for `Renders::linear_picture`.
    pub linear: bool,
    /// True when the image is drawn as finely as the photos show what is in it, and reduced: a pixel is the mean of what the
    /// photos show in it. Renderers with one sample per pixel ignore it.
    pub supersampled: bool,
    /// What is drawn where no photo shows what is there, in views of colours and of their sources.
    pub unseen: Unseen,
}

impl Shot {
    /// Builds the view of a camera, with all options at their defaults.
    pub fn new(camera: Pinhole, pose: Pose) -> Self {
        Self {
            camera,
            pose,
            parallel: None,
            blend: Blend::default(),
            quality: Quality::default(),
            display: DisplayMode::default(),
            exposure: Exposure::default(),
            relief: true,
            backs: true,
            without: Vec::new(),
            hidden: HiddenFaces::default(),
            trees: TreeMethod::default(),
            trees_within: None,
            surroundings: true,
            linear: false,
            supersampled: false,
            unseen: Unseen::default(),
        }
    }

    /// Builds an orthographic view of `[width, height]` pixels with this many pixels per world unit. `extent` is the largest distance
    /// between points that may be seen, in world units. Trees and surroundings, which have perspective alone, are left out.
    pub fn orthographic(
        plane: &PicturePlane,
        [width, height]: [u32; 2],
        px_per_unit: f64,
        extent: f64,
        from_depth: Option<f64>,
    ) -> Self {
        let forward = plane.forward();
        let rotation = DMat3::from_cols(plane.right, plane.down, forward).transpose();
        let distance = FAR * extent;
        let eye = plane.middle - forward * distance;
        let pose = Pose { rotation, translation: -(rotation * eye) };
        let focal = px_per_unit * distance;
        let [cx, cy] = [width, height].map(|side| 0.5 * f64::from(side));
        let camera = Pinhole { width, height, fx: focal, fy: focal, cx, cy };
        let parallel = Some(ParallelRays { distance, extent, from_depth });
        Self { parallel, trees: TreeMethod::None, surroundings: false, ..Self::new(camera, pose) }
    }

    /// Returns the point that a device computes relative to: the viewpoint, or the reference point of parallel rays; in world coordinates.
    pub fn reference(&self) -> DVec3 {
        match &self.parallel {
            None => self.viewpoint(),
            Some(parallel) => {
                let forward = self.pose.rotation.row(2);
                self.viewpoint() + forward * parallel.distance
            }
        }
    }

    /// Returns the depth of a world point behind the point of [`Self::reference`], along the axis, in world units.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        self.pose.camera_from_world(point).z - self.parallel.map_or(0.0, |parallel| parallel.distance)
    }

    /// Returns the share of the depth from the viewpoint within which surfaces count as one, as in the visibility sort.
    pub fn tolerance(&self) -> f64 {
        match self.parallel {
            None => TOLERANCE,
            Some(ParallelRays { distance, extent, .. }) => TOLERANCE_OF_PARALLEL * extent / distance,
        }
    }

    /// As [`Self::tolerance`], of the depths that a device stores.
    pub fn stored_tolerance(&self) -> f64 {
        if self.parallel.is_some() { TOLERANCE_OF_PARALLEL } else { TOLERANCE }
    }

    /// Returns the faces that the view skips.
    pub fn culling(&self) -> Culling<'_> {
        Culling { backs: self.backs, hidden: &self.hidden }
    }

    /// Returns the same view with `samples` times as many pixels along each side, to be reduced.
    pub fn finer(&self, samples: f64) -> Self {
        let Pinhole { width, height, fx, fy, cx, cy } = self.camera;
        let [w, h] = [width, height].map(|side| ((f64::from(side) * samples).round() as u32).max(side));
        let (x, y) = (f64::from(w) / f64::from(width), f64::from(h) / f64::from(height));
        let camera = Pinhole { width: w, height: h, fx: fx * x, fy: fy * y, cx: cx * x, cy: cy * y };
        // From two samples along each side on, edges need no more of them.
        let quality = if samples >= 2.0 { Quality::Finer } else { self.quality };
        Self { camera, quality, supersampled: false, ..self.clone() }
    }

    /// Returns the camera's position, in world coordinates.
    pub fn viewpoint(&self) -> DVec3 {
        self.pose.center_in_world()
    }
}

/// An image with alpha; rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB and alpha, 8 bits each, `width * height * 4` values; not premultiplied. Alpha is the share of the
    /// pixel that is textured.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// Returns the rectangle of all pixels.
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.width, self.height)
    }

    /// Returns R, G, B, A of every pixel, row by row.
    pub fn pixels(&self) -> &[[u8; 4]] {
        self.rgba.as_chunks().0
    }

    /// Returns the image composited over a plain colour, in gamma; it is opaque.
    pub fn on(&self, background: [u8; 3]) -> Self {
        let over = self.over(background);
        let rgba = over.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
        Self { rgba, ..*self }
    }

    /// Composites the image over a plain colour, in gamma: RGB, 8 bits, `width * height * 3` values.
    pub fn over(&self, background: [u8; 3]) -> Vec<u8> {
        let laid = |pixel: &[u8; 4]| -> [u8; 3] {
            std::array::from_fn(|c| on_opaque(pixel[c], pixel[3], background[c]))
        };
        self.pixels().iter().flat_map(laid).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orthographic_view_shows_points_where_they_are_over_its_plane_whatever_their_depth() {
        let middle = DVec3::new(412_000.0, 5_654_000.0, 120.0);
        let right = DVec3::new(0.6, 0.8, 0.0);
        let plane = PicturePlane { middle, right, down: DVec3::NEG_Z };
        let shot = Shot::orthographic(&plane, [3000, 2000], 100.0, 50.0, None);
        assert!((shot.reference() - middle).length() < 1e-5);
        for (x, y, depth) in [(14.0, -9.0, 0.0), (-14.9, 9.0, 20.0), (3.0, 4.0, -25.0)] {
            let point = middle + right * x + plane.down * y + plane.forward() * depth;
            let px = shot.camera.image_from_camera(shot.pose.camera_from_world(point)).unwrap();
            let expected = glam::DVec2::new(1500.0 + 100.0 * x, 1000.0 + 100.0 * y);
            // Georeferenced coordinates of 5.6 million have steps of 1e-9, which the far viewpoint makes 1e-5 at most.
            assert!((px - expected).length() < 0.01, "{px} and {expected}");
            assert!((shot.depth_of(point) - depth).abs() < 1e-5);
        }
    }

    #[test]
    fn a_picture_over_a_colour_is_itself_where_opaque_and_the_colour_where_empty() {
        let rgba = vec![10, 20, 30, 255, 10, 20, 30, 0, 0, 100, 200, 51];
        let picture = Picture { width: 3, height: 1, rgba };
        assert_eq!(picture.over([250, 0, 100]), [10, 20, 30, 250, 0, 100, 200, 20, 120]);
    }
}
