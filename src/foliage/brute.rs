//! Brute force: every polygon of every instance is drawn, with 16 sub-pixels a pixel. It is the truth that other ways of
//! drawing plants are compared with.

use glam::{DMat3, Vec3};

use super::bands::drawn;
use super::drawer::FragmentCanvas;
use super::facet::Facet;
use super::plant::Plant;
use super::raster::Fragment;
use super::shade::{LightReach, LitSurface, OutdoorLight, shade};
use super::shades::{Shades, ViewShades};
use super::view::View;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// A picture of a plant, and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// The picture; alpha is the share of a pixel's sub-pixels that are covered.
    pub picture: Picture,
    /// The triangles that were projected. One near the border of two bands of rows is projected for both.
    pub triangles: u64,
}

/// Draws a plant without shadows.
///
/// # Errors
/// [`quadratura_base::Error::Request`] for a plant of more than [`super::MOST_TRIANGLES`] or of none, and for a view that is
/// not made of finite numbers; [`quadratura_base::Error::Cancelled`].
pub fn draw(plant: &Plant, view: &View, light: &OutdoorLight, task: &Task) -> Result<Drawing> {
    draw_shaded(plant, view, light, None, task)
}

/// Draws a plant with what keeps light from it, if that is given.
///
/// # Errors
/// Those of [`draw`].
pub fn draw_shaded(
    plant: &Plant,
    view: &View,
    light: &OutdoorLight,
    shades: Option<&Shades<'_>>,
    task: &Task,
) -> Result<Drawing> {
    let lit = Lit::new([*light], view, shades);
    let drawn = drawn(plant, view, &|rect| LitCanvas::new(rect, lit), &LitCanvas::resolve, task)?;
    let triangles = drawn.iter().map(|(_, triangles)| triangles).sum();
    let rgba = drawn.into_iter().flat_map(|(rgba, _)| rgba).collect();
    let rect = view.rect();
    Ok(Drawing { picture: Picture { width: rect.w, height: rect.h, rgba }, triangles })
}

/// Finds the pixels of which a plant covers some sub-pixel, row by row, except where something else is nearer: `hiding` holds
/// the nearness of that ([`super::Projection::image_from_view`]) at the centre of each pixel.
///
/// # Errors
/// Those of [`draw`].
pub fn silhouette(plant: &Plant, view: &View, hiding: &[f32], task: &Task) -> Result<Vec<bool>> {
    let rows = |rect: PixelRect| &hiding[(rect.y as usize * rect.w as usize)..][..rect.area() as usize];
    let lit = Lit::new([], view, None);
    let behind = |rect| LitCanvas::behind(rect, lit, rows(rect));
    let covered = |band: &LitCanvas<'_, 0>| {
        let subpixels = band.nearness.as_chunks::<16>().0.iter().zip(rows(band.rect));
        subpixels.map(|(found, hiding)| found.iter().any(|found| found > hiding)).collect()
    };
    let drawn = drawn(plant, view, &behind, &covered, task)?;
    Ok(drawn.into_iter().flat_map(|(covered, _)| covered).collect())
}

/// What a pixel shows of a plant in two lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InLights {
    /// How many of the pixel's 16 sub-pixels show the plant.
    pub covered: u8,
    /// The sums of their linear light, one for each of the lights.
    pub sums: [Vec3; 2],
}

/// Draws a plant in two lights, which have the same directions, row by row, except where something else is nearer, as in
/// [`silhouette`].
///
/// # Errors
/// Those of [`draw`].
pub fn draw_in_lights(
    plant: &Plant,
    view: &View,
    lights: [OutdoorLight; 2],
    hiding: &[f32],
    shades: Option<&Shades<'_>>,
    task: &Task,
) -> Result<Vec<InLights>> {
    let rows = |rect: PixelRect| &hiding[(rect.y as usize * rect.w as usize)..][..rect.area() as usize];
    let lit = Lit::new(lights, view, shades);
    let sums = |band: &LitCanvas<'_, 2>| -> Vec<InLights> {
        let subpixels = band.nearness.as_chunks::<16>().0.iter().zip(band.light.as_chunks::<16>().0);
        let pixel = |((nearness, light), hiding): ((&[f32; 16], &[[Vec3; 2]; 16]), &f32)| InLights {
            covered: nearness.iter().filter(|nearness| *nearness > hiding).count() as u8,
            // Those that are not covered are black.
            sums: [0, 1].map(|of| light.iter().map(|light| light[of]).sum()),
        };
        subpixels.zip(rows(band.rect)).map(pixel).collect()
    };
    let drawn = drawn(plant, view, &|rect| LitCanvas::behind(rect, lit, rows(rect)), &sums, task)?;
    Ok(drawn.into_iter().flat_map(|(pixels, _)| pixels).collect())
}

/// Returns the sums of the linear light of all sub-pixels that a plant covers, in each of some lights without shadows, and their number.
///
/// # Errors
/// Those of [`draw`].
pub(super) fn sums_of_light<const N: usize>(
    plant: &Plant,
    view: &View,
    lights: [OutdoorLight; N],
    task: &Task,
) -> Result<([Vec3; N], u32)> {
    let lit = Lit::new(lights, view, None);
    let sums = |band: &LitCanvas<'_, N>| {
        let covered = band.nearness.iter().filter(|nearness| **nearness > f32::NEG_INFINITY).count();
        let none = [Vec3::ZERO; N];
        let add = |sums: [Vec3; N], light: &[Vec3; N]| std::array::from_fn(|of| sums[of] + light[of]);
        vec![(band.light.iter().fold(none, add), covered as u32)]
    };
    let bands = drawn(plant, view, &|rect| LitCanvas::new(rect, lit), &sums, task)?;
    let parts = bands.into_iter().flat_map(|(parts, _)| parts);
    Ok(parts.fold(([Vec3::ZERO; N], 0), |(all, count), (sums, covered)| {
        (std::array::from_fn(|of| all[of] + sums[of]), count + covered)
    }))
}

/// The lights in which a plant is drawn, which have the same directions.
#[derive(Debug, Clone, Copy)]
struct Lit<'a, const N: usize> {
    lights: [OutdoorLight; N],
    light_from_view: DMat3,
    shades: Option<ViewShades<'a>>,
}

impl<'a, const N: usize> Lit<'a, N> {
    fn new(lights: [OutdoorLight; N], view: &View, shades: Option<&Shades<'a>>) -> Self {
        let shades = shades.map(|shades| ViewShades::new(shades, view));
        Self { lights, light_from_view: view.light_from_view, shades }
    }

    /// Returns the light that comes from some sub-pixels of a fragment, in each light.
    #[inline]
    fn shaded(&self, fragment: &Fragment, visible: u16, facet: &Facet) -> [Vec3; N] {
        let Some(first) = self.lights.first() else { return [Vec3::ZERO; N] };
        let normal = (self.light_from_view * facet.normal).normalize_or_zero();
        let surface = LitSurface { normal, reflected: facet.reflected, through: facet.through };
        let facing = normal.dot(first.towards_sun);
        let reach = self
            .shades
            .map_or(LightReach::ALL, |shades| shades.reach(fragment, visible, facet.normal, facing));
        self.lights.map(|light| shade(&surface, &light, &reach))
    }
}

/// The sub-pixels of a band of rows.
struct LitCanvas<'a, const N: usize> {
    rect: PixelRect,
    lit: Lit<'a, N>,
    /// 16 a pixel: how near, lower than everything where nothing is.
    nearness: Vec<f32>,
    /// 16 a pixel: linear light in each of the lights.
    light: Vec<[Vec3; N]>,
}

impl<'a, const N: usize> LitCanvas<'a, N> {
    fn new(rect: PixelRect, lit: Lit<'a, N>) -> Self {
        let count = 16 * rect.area() as usize;
        Self { rect, lit, nearness: vec![f32::NEG_INFINITY; count], light: vec![[Vec3::ZERO; N]; count] }
    }

    /// Makes a band behind something that is this near at each pixel.
    fn behind(rect: PixelRect, lit: Lit<'a, N>, hiding: &[f32]) -> Self {
        let nearness = hiding.iter().flat_map(|nearness| [*nearness; 16]).collect();
        Self { nearness, ..Self::new(rect, lit) }
    }
}

impl LitCanvas<'_, 1> {
    /// Returns R, G, B, A of the pixels: the mean light of the covered sub-pixels, and their share.
    fn resolve(&self) -> Vec<u8> {
        let subpixels = self.nearness.as_chunks::<16>().0.iter().zip(self.light.as_chunks::<16>().0);
        let pixel = |(nearness, light): (&[f32; 16], &[[Vec3; 1]; 16])| {
            let covered = nearness.iter().filter(|nearness| **nearness > f32::NEG_INFINITY).count();
            // Those that are not covered are black.
            let mean = light.iter().flatten().sum::<Vec3>() / covered.max(1) as f32;
            let byte =
                |light: f32| (255.0 * srgb_from_linear(f64::from(light).clamp(0.0, 1.0))).round() as u8;
            [byte(mean.x), byte(mean.y), byte(mean.z), ((covered * 255 + 8) / 16) as u8]
        };
        subpixels.flat_map(pixel).collect()
    }
}

impl<const N: usize> FragmentCanvas for LitCanvas<'_, N> {
    /// Those that are nearer than what is there: of equals the first one stays.
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        let first = 16 * self.rect.offset(fragment.x, fragment.y);
        let behind = &self.nearness[first..first + 16];
        let (mut left, mut visible) = (fragment.mask, 0);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            visible |= u16::from(fragment.nearness[bit] > behind[bit]) << bit;
        }
        visible
    }

    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        let light = self.lit.shaded(fragment, visible, facet);
        let first = 16 * self.rect.offset(fragment.x, fragment.y);
        let mut left = visible;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            self.nearness[first + bit] = fragment.nearness[bit];
            self.light[first + bit] = light;
        }
    }
}
