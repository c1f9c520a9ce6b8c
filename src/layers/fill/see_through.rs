//! See-through surfaces in a filling.
//!
//! The sort orders a see-through surface like a solid one. In the filling its matte takes effect: where the photo shows it, the
//! matte is the photo's own; where it is hidden, matte and colour come from other photos. Where the matte is 0 the photo
//! shows what is behind, so the texel behind gets the photo's own pixel. In between, the pixel is a mixture of both; the
//! colours of both are corrected, so that the layers over each other give the photo back. A matte counts as 1 where what
//! is behind is not filled.

mod from_others;

use std::collections::BTreeMap;

use super::region::Region;
use super::surfaces::FillSurfaceId;
use super::{FillOrigin, FilledRegion, FilledTexel, PhotoFilling};
use crate::LayerIndex;
use crate::matte::{Known, Matte};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::steps::steps_inside;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_base::scene::{PhotoId, PhotoPixels};

pub use from_others::fill_see_through;

/// An image layer of see-through surfaces, within its needed rectangle.
#[derive(Debug, Clone)]
pub struct SeeThroughLayer {
    /// The layer.
    pub layer: LayerIndex,
    /// The rectangle in photo pixels; the lists have one value per pixel of it, row by row.
    pub rect: PixelRect,
    /// The surface that covers each pixel.
    pub surfaces: Vec<Option<FillSurfaceId>>,
    /// Whether the photo shows the surface there.
    pub visible: Vec<bool>,
}

/// The matte of an image layer, within its needed rectangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LayerMatte {
    /// The layer.
    pub layer: LayerIndex,
    /// The rectangle in photo pixels; the lists have one value per pixel of it, row by row.
    pub rect: PixelRect,
    /// The matte in 255ths.
    pub matte: Vec<u8>,
    /// The colour of the surface, in the photo's encoding and the full range of 16 bits, where the photo shows it mixed
    /// with what is behind.
    pub foreground: Vec<Option<[u16; 3]>>,
    /// Whether the photo shows the surface and nobody knows how much of it: the matte is 1, but little trusted.
    pub unknown: Vec<bool>,
}

/// Counts of the pixels at which a photo shows see-through surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MattePixels {
    /// The number of pixels whose foremost surface has a matte.
    pub shown: u64,
    /// Those of which nobody knows how much is the surface: it is solid there.
    pub unknown: u64,
    /// The number of pixels with a matte between 0 and 1.
    pub mixed: u64,
    /// Those at which no colours in range give the photo back.
    pub clipped: u64,
}

/// The largest difference, in 255ths of the encoded range, at which a mixture gives the photo back.
const GIVEN_BACK: f64 = 3.0;

/// The distance in pixels from what is shown of a see-through surface at which what is seen through it is fully trusted.
const CLEAR_PX: f64 = 6.0;

/// The largest confidence of what is behind a mixture.
const MIXED: u8 = 25;

/// The mattes of a surface, by photo.
pub type MattesOfSurface<'a> = BTreeMap<PhotoId, &'a Matte>;

/// A region of a see-through surface that the photo does not show, with the matte of each texel. Texels of which nothing
/// is known have a confidence of 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MattedRegion {
    /// The region and its texels.
    pub filled: FilledRegion,
    /// The matte of each texel, in 255ths.
    pub mattes: Vec<u8>,
}

/// A photo whose see-through layers are laid over what is behind them.
pub struct SeeThroughPhoto<'a> {
    /// The photo.
    pub photo: PhotoId,
    /// Its pixels.
    pub pixels: &'a PhotoPixels,
    /// Its own mattes.
    pub mattes: BTreeMap<FillSurfaceId, &'a Matte>,
    /// Its image layers of see-through surfaces, nearest first.
    pub layers: Vec<SeeThroughLayer>,
}

impl SeeThroughPhoto<'_> {
    /// Returns the surfaces behind mixtures: their texels depend on the matte as well as on other photos.
    pub fn mixed_surfaces<'r>(&self, regions: impl Iterator<Item = &'r Region>) -> Vec<FillSurfaceId> {
        let mixed = |x: u32, y: u32| {
            self.layers.iter().any(|layer| {
                let (x, y) = (x as i32, y as i32);
                let own = layer.rect.index(x, y);
                let matte = own.and_then(|at| self.mattes.get(&layer.surfaces[at]?)?.texels.get(x, y));
                matte.is_some_and(|texel| !matches!(texel[3], 0 | u8::MAX))
            })
        };
        let is_mixed = |region: &&Region| region.pixels().any(|(x, y)| mixed(x, y));
        regions.filter(is_mixed).map(|region| region.surface).collect()
    }

    /// Lets the mattes take effect on a filling: adds the hidden texels of see-through surfaces, and corrects the texels
    /// behind what the photo shows of them. Returns the counts of pixels.
    pub fn lay_over(&self, filling: &mut PhotoFilling, hidden: Vec<MattedRegion>) -> MattePixels {
        let first = filling.regions.len();
        let mut mattes: Vec<LayerMatte> = self.layers.iter().map(LayerMatte::solid).collect();
        for MattedRegion { filled, mattes: of_texels } in hidden {
            for span in &filled.region.spans {
                let Some(layer) = mattes.iter_mut().find(|matte| matte.layer == span.layer) else { continue };
                for (x, at) in (span.span.x0..span.span.x1).zip(span.first as usize..) {
                    layer.set(x, span.span.y, of_texels[at]);
                }
            }
            filling.regions.push(filled);
        }
        let mut counts = MattePixels::default();
        let texels = TexelIndex::new(filling);
        let clearance = Clearance::new(self);
        let mut laying = Laying { of: self, filling, texels, mattes, clearance };
        for (index, layer) in self.layers.iter().enumerate() {
            for (at, (x, y)) in layer.rect.pixels().enumerate().filter(|(at, _)| layer.visible[*at]) {
                let Some(surface) = layer.surfaces[at] else { continue };
                let Some(matte) = self.mattes.get(&surface) else { continue };
                let Some((&texel, known)) = matte.texels.get(x, y).zip(matte.known.get(x, y)) else {
                    continue;
                };
                let is_unknown = *known == Known::Unknown;
                laying.mattes[index].unknown[at] = is_unknown;
                counts.shown += 1;
                counts.unknown += u64::from(is_unknown);
                if texel[3] < u8::MAX {
                    laying.lay(index, texel, [x as u32, y as u32], &mut counts);
                }
            }
        }
        let Laying { mattes, .. } = laying;
        for region in &mut filling.regions[first..] {
            let is_known = |at: usize| region.texels[at].confidence > 0;
            let part = region.region.part(is_known);
            let known = region.texels.iter().copied().filter(|texel| texel.confidence > 0);
            let texels: Vec<FilledTexel> = known.collect();
            region.region = part.unwrap_or(Region { surface: region.region.surface, spans: Vec::new() });
            region.texels = texels;
        }
        filling.regions.retain(|region| !region.texels.is_empty());
        filling.regions.sort_by_key(|filled| filled.region.surface);
        filling.mattes = mattes;
        counts
    }

    /// Returns the photo's pixel, in the full range of 16 bits.
    fn pixel(&self, [x, y]: [u32; 2]) -> [u16; 3] {
        let [r, g, b, _] = self.pixels.rgba16(x, y);
        [r, g, b]
    }

    /// Encodes linear light as a sample of the photo, scaled to the full range of 16 bits.
    fn encoded(&self, light: f64) -> u16 {
        let value = srgb_from_linear(light.clamp(0.0, 1.0));
        match self.pixels.bits() {
            16 => (value * 65535.0).round() as u16,
            _ => (value * 255.0).round() as u16 * 257,
        }
    }
}

impl LayerMatte {
    fn solid(layer: &SeeThroughLayer) -> Self {
        let count = layer.surfaces.len();
        Self {
            layer: layer.layer,
            rect: layer.rect,
            matte: vec![u8::MAX; count],
            foreground: vec![None; count],
            unknown: vec![false; count],
        }
    }

    fn set(&mut self, x: u32, y: u32, matte: u8) {
        if let Some(at) = self.rect.index(x as i32, y as i32) {
            self.matte[at] = matte;
        }
    }
}

/// Where a texel of a filling is.
#[derive(Clone, Copy)]
struct TexelPlace {
    /// The region, counted with the surroundings last.
    region: usize,
    /// The texel's index there.
    texel: usize,
}

/// The texels of a filling by image layer and pixel.
struct TexelIndex {
    /// Per layer the spans by row and column.
    spans: Vec<Vec<IndexedSpan>>,
}

/// A span of texels: row, first column, one past the last one, region, and the index of the first texel there.
type IndexedSpan = (u32, u32, u32, u32, u32);

impl TexelIndex {
    fn new(filling: &PhotoFilling) -> Self {
        let mut spans: Vec<Vec<_>> = Vec::new();
        for (index, filled) in (0..).zip(filling.regions.iter().chain(&filling.surroundings)) {
            for hidden in &filled.region.spans {
                let layer = hidden.layer.index();
                spans.resize_with(spans.len().max(layer + 1), Vec::new);
                spans[layer].push((hidden.span.y, hidden.span.x0, hidden.span.x1, index, hidden.first));
            }
        }
        spans.iter_mut().for_each(|spans| spans.sort_unstable());
        Self { spans }
    }

    /// Returns the texel of a layer at a pixel.
    fn get(&self, layer: usize, [x, y]: [u32; 2]) -> Option<TexelPlace> {
        let spans = &self.spans[layer];
        let next = spans.partition_point(|span| (span.0, span.1) <= (y, x));
        let &(row, x0, x1, region, first) = spans.get(next.checked_sub(1)?)?;
        let texel = (first + x - x0) as usize;
        (row == y && x < x1).then_some(TexelPlace { region: region as usize, texel })
    }

    /// Returns the nearest texel behind a layer at a pixel, with its layer.
    fn behind(&self, layer: LayerIndex, at: [u32; 2]) -> Option<(LayerIndex, TexelPlace)> {
        let mut layers = layer.index() + 1..self.spans.len();
        layers.find_map(|layer| Some((LayerIndex::new(layer), self.get(layer, at)?)))
    }
}

/// How far the photo's pixels are from those that show something of a see-through surface.
struct Clearance {
    rect: PixelRect,
    /// Steps to the nearest such pixel, row by row.
    steps: Vec<u16>,
}

impl Clearance {
    fn new(photo: &SeeThroughPhoto) -> Self {
        let rect = photo
            .layers
            .iter()
            .map(|layer| layer.rect)
            .reduce(|a, b| a.union(&b))
            .unwrap_or(PixelRect::of_size(0, 0));
        let mut clear = vec![true; rect.area() as usize];
        for layer in &photo.layers {
            for (at, (x, y)) in layer.rect.pixels().enumerate().filter(|(at, _)| layer.visible[*at]) {
                let matte =
                    layer.surfaces[at].and_then(|surface| photo.mattes.get(&surface)?.texels.get(x, y));
                if let Some(at) = rect.index(x, y) {
                    clear[at] = matte.is_some_and(|texel| texel[3] == 0);
                }
            }
        }
        Self { steps: steps_inside(&clear, [rect.w as usize, rect.h as usize]), rect }
    }

    /// Returns the confidence of a pixel that is seen through a surface: close to what is shown of it, traces of it may
    /// remain.
    fn confidence(&self, [x, y]: [u32; 2]) -> u8 {
        let steps = self.rect.index(x as i32, y as i32).map_or(u16::MAX, |at| self.steps[at]);
        let share = (f64::from(steps) / CLEAR_PX).min(1.0);
        (share * f64::from(u8::MAX)).round().max(f64::from(MIXED)) as u8
    }
}

/// See-through layers being laid over a filling.
struct Laying<'a, 'b> {
    of: &'a SeeThroughPhoto<'a>,
    filling: &'b mut PhotoFilling,
    texels: TexelIndex,
    mattes: Vec<LayerMatte>,
    clearance: Clearance,
}

impl Laying<'_, '_> {
    fn texel(&mut self, TexelPlace { region, texel }: TexelPlace) -> &mut FilledTexel {
        let PhotoFilling { regions, surroundings, .. } = &mut *self.filling;
        let count = regions.len();
        let filled = match region < count {
            true => &mut regions[region],
            false => surroundings.as_mut().expect("it is the region after the last one"),
        };
        &mut filled.texels[texel]
    }

    /// Returns the photo's own matte of a layer's texel that is seen through another one, if the layer is of see-through
    /// surfaces. Mattes tell what belongs to the foremost of them and what is behind all: where it is not the foremost one,
    /// nothing of it is there.
    fn own(&self, layer: LayerIndex, [x, y]: [u32; 2]) -> Option<(usize, [u8; 4])> {
        let index = self.of.layers.iter().position(|other| other.layer == layer)?;
        let see_through = &self.of.layers[index];
        let (x, y) = (x as i32, y as i32);
        let surface = see_through.surfaces[see_through.rect.index(x, y)?]?;
        let matte = self.of.mattes.get(&surface)?;
        let [r, g, b, alpha] = *matte.texels.get(x, y)?;
        let is_shown = matte.known.get(x, y).is_some_and(|known| *known != Known::NotShown);
        Some((index, [r, g, b, if is_shown { alpha } else { 0 }]))
    }

    /// Lets the matte of a visible texel take effect: `index` is that of its layer.
    fn lay(&mut self, mut index: usize, mut texel: [u8; 4], at: [u32; 2], counts: &mut MattePixels) {
        // The texel that the photo shows is none of the filling; those behind it, seen through it, are.
        let mut place = None;
        loop {
            let layer = self.of.layers[index].layer;
            let behind = self.texels.behind(layer, at);
            match (texel[3], behind) {
                // Without anything behind it counts as solid.
                (u8::MAX, _) | (_, None) => return self.show(index, place, at),
                (0, Some((next, behind))) => {
                    self.mattes[index].set(at[0], at[1], 0);
                    place.into_iter().for_each(|place| self.is_own(place, at));
                    match self.own(next, at) {
                        Some((next, own)) => (index, texel, place) = (next, own, Some(behind)),
                        None => return self.is_own(behind, at),
                    }
                }
                (_, Some(_)) => {
                    let Some(opaque) = self.opaque_behind(layer, at) else {
                        return self.show(index, place, at);
                    };
                    self.clear_between(layer, at);
                    counts.mixed += 1;
                    let is_given_back = self.mix(index, place, texel, at, opaque);
                    counts.clipped += u64::from(!is_given_back);
                    return;
                }
            }
        }
    }

    /// Makes a texel of the filling the photo's own pixel. Paint of other photos stays.
    fn is_own(&mut self, place: TexelPlace, at: [u32; 2]) {
        let (rgb, origin) = (self.of.pixel(at), FillOrigin::Photo(self.of.photo));
        let confidence = self.clearance.confidence(at);
        let texel = self.texel(place);
        if !is_painted(texel) {
            *texel = FilledTexel { rgb, confidence, origin };
        }
    }

    /// Empties the see-through texels between a layer and the next opaque texel: the photo's matte tells how much is the
    /// layer, and how much is what is behind all see-through surfaces. Paint of other photos stays.
    fn clear_between(&mut self, mut layer: LayerIndex, at: [u32; 2]) {
        while let Some((next, place)) = self.texels.behind(layer, at) {
            let Some(index) = self.of.layers.iter().position(|other| other.layer == next) else { return };
            if !is_painted(self.texel(place)) {
                self.mattes[index].set(at[0], at[1], 0);
                self.is_own(place, at);
            }
            layer = next;
        }
    }

    /// Makes a see-through texel solid, with the photo's pixel.
    fn show(&mut self, index: usize, place: Option<TexelPlace>, at: [u32; 2]) {
        self.mattes[index].set(at[0], at[1], u8::MAX);
        place.into_iter().for_each(|place| self.is_own(place, at));
    }

    /// Returns the nearest texel behind a layer that is not see-through.
    fn opaque_behind(&self, mut layer: LayerIndex, at: [u32; 2]) -> Option<TexelPlace> {
        loop {
            let (next, place) = self.texels.behind(layer, at)?;
            if !self.of.layers.iter().any(|other| other.layer == next) {
                return Some(place);
            }
            layer = next;
        }
    }

    /// Corrects the colours of both sides of a mixture, so that they give the photo's pixel back. Returns whether they do.
    fn mix(
        &mut self,
        index: usize,
        place: Option<TexelPlace>,
        [r, g, b, matte]: [u8; 4],
        at: [u32; 2],
        behind: TexelPlace,
    ) -> bool {
        let (seen, colour, alpha) = (self.of.pixel(at), [r, g, b], f64::from(matte) / 255.0);
        let rest = 1.0 - alpha;
        let FilledTexel { rgb: mut opaque, .. } = *self.texel(behind);
        // Paint stays.
        let moves = !is_painted(self.texel(behind));
        let mut front = [0; 3];
        let mut is_given_back = true;
        for c in 0..3 {
            let seen = light(seen[c]);
            let left = seen - alpha * light(u16::from(colour[c]) * 257) - rest * light(opaque[c]);
            if moves {
                let moved = light(opaque[c]) + rest * left / (alpha * alpha + rest * rest);
                opaque[c] = self.of.encoded(moved);
            }
            front[c] = self.of.encoded((seen - rest * light(opaque[c])) / alpha);
            if moves {
                // What one side cannot take because of its range, the other one takes.
                let off = |opaque: u16| (alpha * light(front[c]) + rest * light(opaque) - seen).abs();
                let other = self.of.encoded((seen - alpha * light(front[c])) / rest);
                if off(other) < off(opaque[c]) {
                    opaque[c] = other;
                }
            }
            let together = alpha * light(front[c]) + rest * light(opaque[c]);
            let off = (srgb_from_linear(together.clamp(0.0, 1.0)) - srgb_from_linear(seen)).abs();
            is_given_back &= off * 255.0 <= GIVEN_BACK;
        }
        let texel = self.texel(behind);
        texel.rgb = opaque;
        if moves {
            texel.confidence = texel.confidence.min(MIXED);
        }
        self.mattes[index].set(at[0], at[1], matte);
        match place {
            Some(place) => {
                self.is_own(place, at);
                self.texel(place).rgb = front;
            }
            None => {
                let matte = &mut self.mattes[index];
                if let Some(at) = matte.rect.index(at[0] as i32, at[1] as i32) {
                    matte.foreground[at] = Some(front);
                }
            }
        }
        is_given_back
    }
}

/// Returns whether the colour of a texel was painted on another photo.
fn is_painted(texel: &FilledTexel) -> bool {
    matches!(texel.origin, FillOrigin::Painted(_))
}

/// Decodes a sample in the full range of 16 bits to linear light.
fn light(value: u16) -> f64 {
    linear_of_srgb(f64::from(value) / 65535.0)
}

#[cfg(test)]
mod tests;
