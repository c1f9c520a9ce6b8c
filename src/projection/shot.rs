//! One novel view: from where, how photos are blended for it, and what of it is shown.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::PhotoId;
use crate::geometry::{Pinhole, Pose};

/// How photos are chosen and weighed at a surface point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Mode {
    /// The photo of least q alone.
    Best,
    /// Angles alone: inverse angle, the nearest photos (Debevec, Yu & Borshukov 1998, section 3).
    Debevec,
    /// Unstructured lumigraph (Buehler et al. 2001): `w = max(0, 1 - q/T) / q`.
    Lumigraph,
    /// Franke-Little weights: `w = (max(0, T - q) / (T q))^2`, once continuously differentiable.
    #[default]
    Smooth,
}

impl Mode {
    /// All of them, in the order of the command line's help.
    pub const ALL: [Self; 4] = [Self::Best, Self::Debevec, Self::Lumigraph, Self::Smooth];

    /// As the command line names it.
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
            format!("{text} is no blending mode; they are {}", Self::ALL.map(Self::name).join(", "))
        })
    }
}

/// How photos are blended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blend {
    /// The formula.
    pub mode: Mode,
    /// At most so many photos share a surface point; 1 to [`Blend::MOST`].
    pub photos: u32,
    /// Weight of the resolution penalty, in radians per octave of missing resolution.
    pub lambda: f64,
}

impl Blend {
    /// The most photos that may share a point.
    pub const MOST: u32 = 8;
}

impl Default for Blend {
    fn default() -> Self {
        Self { mode: Mode::default(), photos: 4, lambda: 0.1 }
    }
}

/// How well a picture is filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quality {
    /// One sample a pixel, trilinear: for moving.
    Preview,
    /// Four samples a pixel at edges, anisotropic: for keeping.
    #[default]
    Final,
}

/// Lookups along the longer axis of a pixel's footprint, at most, in *final* quality.
pub const MOST_TAPS: f64 = 8.0;

/// What a picture shows of the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shown {
    /// The blended photos.
    #[default]
    Colour,
    /// Each photo's own colour (by number), mixed by its weight.
    Weights,
    /// The photo of the largest weight, as its colour.
    BestPhoto,
    /// Texels of the best photo per pixel of the picture, in octaves around one.
    Density,
    /// The largest confidence among the photos that serve.
    Confidence,
    /// The image layer of the best photo, as a colour.
    Layer,
    /// The face, as a colour.
    Item,
    /// How many photos serve the point.
    Coverage,
    /// Where what is seen comes from: each origin in a colour of its own ([`super::legend::Origin`]), mixed as the
    /// photos are blended.
    Provenance,
}

/// Which exposure a picture has.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// The blend of the photos' gains by nearness of the viewpoint: a photo's own camera keeps its own.
    #[default]
    Near,
    /// The exposure that all photos are brought to.
    Common,
    /// That of one photo, wherever the picture is taken from.
    Of(PhotoId),
    /// Photos as they are, differences and all.
    Raw,
}

/// One novel view.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
    /// How photos are blended.
    pub blend: Blend,
    /// How well it is filtered.
    pub quality: Quality,
    /// What is shown.
    pub shown: Shown,
    /// Its exposure.
    pub exposure: Exposure,
    /// Surfaces are shown with their relief, else flat as they were modelled.
    pub relief: bool,
    /// Backs of faces ([`super::sides`]) are surfaces like all others; else they are not there.
    pub backs: bool,
    /// Photos that must not take part (those that are to be predicted).
    pub without: Vec<PhotoId>,
}

impl Shot {
    /// The camera's view with everything else at its default.
    pub fn new(camera: Pinhole, pose: Pose) -> Self {
        Self {
            camera,
            pose,
            blend: Blend::default(),
            quality: Quality::default(),
            shown: Shown::default(),
            exposure: Exposure::default(),
            relief: true,
            backs: true,
            without: Vec::new(),
        }
    }

    /// Where it is taken from, in the world.
    pub fn viewpoint(&self) -> DVec3 {
        self.pose.center_in_world()
    }
}

/// A picture: rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// sRGB and alpha, 8 bits each, `width * height * 4`; not premultiplied. Alpha: how much of the
    /// pixel is textured.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// RGB, 8 bits, `width * height * 3`: laid over a plain colour, in gamma.
    pub fn over(&self, background: [u8; 3]) -> Vec<u8> {
        let laid = |pixel: &[u8; 4]| {
            let alpha = u32::from(pixel[3]);
            let mix = |above: u8, below: u8| {
                ((u32::from(above) * alpha + u32::from(below) * (255 - alpha) + 127) / 255) as u8
            };
            std::array::from_fn::<u8, 3, _>(|channel| mix(pixel[channel], background[channel]))
        };
        let (pixels, _) = self.rgba.as_chunks::<4>();
        pixels.iter().flat_map(laid).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_over_a_colour_is_itself_where_opaque_and_the_colour_where_empty() {
        let rgba = vec![10, 20, 30, 255, 10, 20, 30, 0, 0, 100, 200, 51];
        let picture = Picture { width: 3, height: 1, rgba };
        assert_eq!(picture.over([250, 0, 100]), [10, 20, 30, 250, 0, 100, 200, 20, 120]);
    }
}
