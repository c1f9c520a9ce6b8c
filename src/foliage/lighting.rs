//! What was drawn into a buffer of indices, and the light that comes from what is seen of it.

use glam::{DVec2, Mat3, Vec3};

use super::drawer::FragmentCanvas;
use super::facet::Facet;
use super::flake::FlakeBuffer;
use super::images::MBuffer;
use super::listed::rgba_of_light;
use super::raster::Fragment;
use super::shade::{LightReach, LitSurface, OutdoorLight, Spread, shade_leaves};
use super::view::View;
use quadratura_base::error::{Error, Result};

/// What was drawn in a band: each index belongs to a sample of an image or to a fragment of a polygon.
#[derive(Default)]
pub(super) struct DrawnParts<'a> {
    /// The first index of each, in order.
    firsts: Vec<u32>,
    parts: Vec<Listed<'a>>,
    /// The fragments of all polygons.
    facets: Vec<Facet>,
    /// The first index that is free.
    next: u32,
}

/// What some indices in a row belong to.
#[derive(Clone, Copy)]
enum Listed<'a> {
    /// The samples of an image.
    Image(&'a MBuffer, OfSamples),
    /// Fragments: the first one's index among all.
    Facets(usize),
}

/// What the light of all samples of an image depends on.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfSamples {
    /// The map of their normals into the view.
    pub view_from_normal: Mat3,
    /// What leaves let through over what they reflect.
    pub through: Vec3,
    /// The factor on the light.
    pub gain: Vec3,
    /// The length of the mean normals of leaves.
    pub length: f32,
}

/// What is seen at an index.
pub(super) struct SeenSurface {
    /// The surface.
    surface: LitSurface,
    /// How the normals of its leaves are spread.
    spread: Spread,
    gain: Vec3,
}

impl SeenSurface {
    /// Returns the light that comes from it.
    #[inline]
    pub fn lit(&self, light: &OutdoorLight) -> Vec3 {
        self.gain * shade_leaves(&self.surface, &self.spread, light, &LightReach::ALL)
    }
}

impl<'a> DrawnParts<'a> {
    /// Adds the samples of an image; returns the index of the first.
    ///
    /// # Errors
    /// [`Error::Request`] where indices run out.
    pub fn begin_image(&mut self, image: &'a MBuffer, of_samples: OfSamples) -> Result<u32> {
        let first = self.next;
        let count = u32::try_from(image.samples.len()).ok();
        let Some(next) = count.and_then(|count| first.checked_add(count)) else {
            return Err(Error::Request(format!(
                "more than {} samples of images are in a part of the picture; give a larger tau, or a smaller picture",
                u32::MAX
            )));
        };
        self.firsts.push(first);
        self.parts.push(Listed::Image(image, of_samples));
        self.next = next;
        Ok(first)
    }

    /// Adds a fragment; returns its index.
    pub fn add_facet(&mut self, facet: &Facet) -> u32 {
        let index = self.next;
        if !matches!(self.parts.last(), Some(Listed::Facets(_))) {
            self.firsts.push(index);
            self.parts.push(Listed::Facets(self.facets.len()));
        }
        self.facets.push(*facet);
        self.next = self.next.saturating_add(1);
        index
    }
}

/// Draws polygons beside flakes.
pub(super) struct FlakeCanvas<'a> {
    /// What is the nearest.
    pub buffer: FlakeBuffer,
    /// What was drawn.
    pub drawn: DrawnParts<'a>,
}

impl FragmentCanvas for FlakeCanvas<'_> {
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        self.buffer.visible(fragment)
    }

    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        let index = self.drawn.add_facet(facet);
        self.buffer.put_fragment(fragment, visible, index);
    }
}

/// Lights what is seen.
pub(super) struct Lighting<'a> {
    /// What was drawn.
    pub drawn: &'a DrawnParts<'a>,
    /// The view.
    pub view: &'a View,
    /// Where the last index was found.
    pub last: usize,
}

impl Lighting<'_> {
    /// Returns R, G, B, A of a pixel.
    pub fn pixel(&mut self, at: (i32, i32), indices: &[Option<u32>; 16], light: &OutdoorLight) -> [u8; 4] {
        let mut sum = Vec3::ZERO;
        let covered = self.each_seen(at, indices, &mut |times, seen| sum += times as f32 * seen.lit(light));
        rgba_of_light(sum, covered)
    }

    /// Calls `each` for what is seen in a pixel, with the number of its sub-pixels; returns how many sub-pixels are covered.
    pub fn each_seen(
        &mut self,
        at: (i32, i32),
        indices: &[Option<u32>; 16],
        each: &mut dyn FnMut(u32, &SeenSurface),
    ) -> u32 {
        let (mut distinct, mut count) = ([(0u32, 0u32); 16], 0);
        for index in indices.iter().flatten() {
            match distinct[..count].iter_mut().find(|(other, _)| other == index) {
                Some((_, times)) => *times += 1,
                None => {
                    distinct[count] = (*index, 1);
                    count += 1;
                }
            }
        }
        for (index, times) in &distinct[..count] {
            each(*times, &self.seen(*index, at));
        }
        distinct[..count].iter().map(|(_, times)| times).sum()
    }

    /// Returns what has an index, as seen at a pixel.
    fn seen(&mut self, index: u32, (x, y): (i32, i32)) -> SeenSurface {
        let DrawnParts { firsts, parts, facets, .. } = self.drawn;
        let is_last =
            firsts[self.last] <= index && firsts.get(self.last + 1).is_none_or(|next| index < *next);
        if !is_last {
            self.last = firsts.partition_point(|first| *first <= index) - 1;
        }
        let offset = (index - firsts[self.last]) as usize;
        match parts[self.last] {
            Listed::Facets(first) => {
                let Facet { normal, reflected, through, .. } = facets[first + offset];
                let surface = LitSurface { normal: self.view.light_from_view * normal, reflected, through };
                SeenSurface { surface, spread: Spread::NONE, gain: Vec3::ONE }
            }
            Listed::Image(image, OfSamples { view_from_normal, through, gain, length }) => {
                let sample = &image.samples[offset];
                let reflected = sample.reflected();
                let normal = (view_from_normal * sample.normal.normal()).as_dvec3();
                let point = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let towards = self.view.projection.view_from_image(point, 1.0);
                let towards = self.view.projection.towards_viewer(towards);
                let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
                let surface = LitSurface {
                    normal: (self.view.light_from_view * normal).normalize_or_zero(),
                    reflected,
                    through: sample.normal.is_leaf().then_some(reflected * through),
                };
                let towards = (self.view.light_from_view * towards).normalize_or_zero();
                let from_image = self.view.light_from_view * view_from_normal.as_dmat3();
                SeenSurface { surface, spread: Spread { length, towards_viewer: towards, from_image }, gain }
            }
        }
    }
}
