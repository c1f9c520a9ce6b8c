//! One photo as it is published: the pixels that its image layers show, and which layers show each. Pixels that no layer shows, such as
//! masked ones, are not in it.

use glam::DVec2;

use super::labels::TexelLabels;
use super::plane::{PhotoCells, in_16_steps, mean};
use super::tiles::{TileGrid, TiledPhoto};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;
use quadratura_projection::agreement::Agreement;
use quadratura_projection::confidence::ConfidenceRamp;
use quadratura_projection::pyramid::runs_where;
use quadratura_projection::skirts::Skirts;
use quadratura_projection::sources::{FILLED, LayerTexturePixels};
use quadratura_projection::{LayerTextureId, Texels};

/// A photo composed of its image layers.
pub struct ComposedPhoto {
    /// The size of the photo, in pixels.
    pub size: [u32; 2],
    /// The pixels that layers show, sRGB, 3 bytes each; 0 where none does.
    pub rgb: Vec<u8>,
    /// The layers that show each pixel.
    pub labels: TexelLabels,
    /// Confidence, without the photo's border, in 255ths.
    pub trust: Vec<u8>,
    /// Agreement, in 255ths; 255 where no layer shows the pixel.
    pub agreement: Vec<u8>,
    /// How much of the pixel shows its face, in 255ths, likewise.
    pub outlines: Vec<u8>,
    /// The pixels of layers that one sees through, with their colours.
    see_through: Vec<(usize, [u8; 3])>,
    /// What layers have beside their visible pixels.
    pub tiled: Vec<TiledPhoto>,
}

/// Composes a photo. `texels` has the texels of its image layers, `agreement` how far others confirm them.
///
/// # Errors
/// Those of reading layers.
pub fn composed(
    id: PhotoId,
    skirts: &Skirts,
    texels: &dyn Texels,
    agreement: &Agreement,
) -> Result<ComposedPhoto> {
    let camera = &skirts.sources.photo(id).camera;
    let size = [camera.width, camera.height];
    let count = size[0] as usize * size[1] as usize;
    let mut photo = ComposedPhoto {
        size,
        rgb: vec![0; 3 * count],
        labels: TexelLabels::new(count),
        trust: vec![0; count],
        agreement: vec![u8::MAX; count],
        outlines: vec![u8::MAX; count],
        see_through: Vec::new(),
        tiled: Vec::new(),
    };
    // Those of skirts are made of the layers of surroundings.
    let textures = (0..).map(LayerTextureId).zip(skirts.own_textures(&skirts.sources));
    for (layer, texture) in textures.filter(|(_, texture)| texture.photo == id) {
        let pixels = texels.layer_texture(layer)?;
        match texture.see_through {
            true => {
                photo.note_see_through(&pixels);
                photo.tiled.extend(whole(layer, &pixels));
            }
            false => photo.add(layer, &pixels, agreement),
        }
    }
    Ok(photo)
}

impl ComposedPhoto {
    /// Adds a layer: its visible pixels to the photo, and others to tiles.
    fn add(&mut self, layer: LayerTextureId, pixels: &LayerTexturePixels, agreement: &Agreement) {
        let trust = trust_of(pixels);
        let (confirmed, outline) = (agreement.of(layer), agreement.outline_of(layer));
        let photo = PixelRect::of_size(self.size[0], self.size[1]);
        let texels = pixels.rgba.as_chunks::<4>().0;
        let mut hidden = vec![false; texels.len()];
        for (at, (x, y)) in pixels.rect.pixels().enumerate() {
            let [r, g, b, alpha] = texels[at];
            if alpha == 0 {
                continue;
            }
            let own = photo.index(x, y).filter(|_| pixels.needed[at] & FILLED == 0);
            let own =
                own.filter(|to| !self.labels.is_claimed(*to) || self.rgb[3 * to..3 * to + 3] == [r, g, b]);
            let Some(to) = own else {
                hidden[at] = true;
                continue;
            };
            if !self.labels.is_claimed(to) {
                self.rgb[3 * to..3 * to + 3].copy_from_slice(&[r, g, b]);
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let byte = |value: f64| (255.0 * value).round() as u8;
                self.agreement[to] = confirmed.map_or(u8::MAX, |grid| byte(grid.at(px)));
                self.outlines[to] = outline.map_or(u8::MAX, |grid| byte(grid.at(px)));
            }
            self.trust[to] = self.trust[to].max(trust[at]);
            self.labels.claim(to, layer);
        }
        if let Some(rect) = bounds(pixels.rect, &hidden) {
            let texel = |x: i32, y: i32| {
                let at = pixels.rect.index(x, y).filter(|at| hidden[*at])?;
                let [r, g, b, _] = texels[at];
                Some(([r, g, b, trust[at]], u8::MAX))
            };
            self.tiled.push(TiledPhoto { layer, grid: TileGrid::halved(rect, texel), has_matte: false });
        }
    }

    /// Keeps the photo's own colours of a layer that one sees through, for small pictures of the photo.
    fn note_see_through(&mut self, pixels: &LayerTexturePixels) {
        let photo = PixelRect::of_size(self.size[0], self.size[1]);
        for (at, (x, y)) in pixels.rect.pixels().enumerate() {
            let [r, g, b, alpha] = pixels.rgba.as_chunks::<4>().0[at];
            let is_there = pixels.matte.as_ref().is_some_and(|matte| matte[at] > 127);
            if let Some(to) =
                photo.index(x, y).filter(|_| alpha > 0 && is_there && pixels.needed[at] & FILLED == 0)
            {
                self.see_through.push((to, [r, g, b]));
            }
        }
    }

    /// Returns the colours of the photo with those of what one sees through.
    pub fn with_see_through(&self) -> (Vec<u8>, Vec<bool>) {
        let mut rgb = self.rgb.clone();
        let mut known: Vec<bool> = (0..rgb.len() / 3).map(|at| self.labels.is_claimed(at)).collect();
        for (at, colour) in &self.see_through {
            rgb[3 * at..3 * at + 3].copy_from_slice(colour);
            known[*at] = true;
        }
        (rgb, known)
    }

    /// Returns what a photo says of cells of its pixels: confidence, agreement and outline, one plane each.
    pub fn weights(&self, cells: PhotoCells) -> [Vec<u8>; 3] {
        let is_shown = |at: usize| self.labels.is_claimed(at);
        let planes = [&self.trust, &self.agreement, &self.outlines].map(|plane| cells.means(plane, is_shown));
        in_steps(planes)
    }

    /// Returns the same of cells that show several layers: confidence is that of the layers in the middle of a cell, and the less, the
    /// more of the cell others have, since the colour of such a cell is also theirs.
    pub fn weights_of_mixed(&self, cells: PhotoCells, labels: &[u8]) -> [Vec<u8>; 3] {
        let trust = cells.map(|middle, pixels| match labels[middle] {
            0 => 0,
            label => mean(pixels.map(|at| if labels[at] == label { self.trust[at] } else { 0 })),
        });
        let of_own = |plane: &[u8]| {
            cells.map(|middle, pixels| {
                mean(pixels.filter(|at| labels[*at] == labels[middle]).map(|at| plane[at]))
            })
        };
        let [agreement, outlines] = [&self.agreement, &self.outlines].map(|plane| of_own(plane));
        in_steps([trust, agreement, outlines])
    }
}

/// Rounds planes of confidence, agreement and outlines as they are packed.
fn in_steps(mut planes: [Vec<u8>; 3]) -> [Vec<u8>; 3] {
    planes[0].iter_mut().for_each(|value| *value = in_16_steps(*value));
    // What is contradicted is told finely, since penalties are divided by it.
    let coarse = |value: u8| if value < 32 { value } else { in_16_steps(value) };
    planes[1..].iter_mut().flatten().for_each(|value| *value = coarse(*value));
    planes
}

/// Returns the whole of a layer that one sees through, with its matte, at its full size.
fn whole(layer: LayerTextureId, pixels: &LayerTexturePixels) -> Option<TiledPhoto> {
    let matte = pixels.matte.as_ref()?;
    let trust = trust_of(pixels);
    let texels = pixels.rgba.as_chunks::<4>().0;
    let texel = |x: i32, y: i32| {
        let at = pixels.rect.index(x, y)?;
        let [r, g, b, alpha] = texels[at];
        (alpha > 0).then_some(([r, g, b, trust[at]], matte[at]))
    };
    let shown: Vec<bool> = texels.iter().map(|texel| texel[3] > 0).collect();
    let rect = bounds(pixels.rect, &shown)?;
    Some(TiledPhoto { layer, grid: TileGrid::whole(rect, texel), has_matte: true })
}

/// Returns the confidence of a layer's texels in 255ths: their alpha, with the ramp towards what the photo does not show.
fn trust_of(pixels: &LayerTexturePixels) -> Vec<u8> {
    let texels = pixels.rgba.as_chunks::<4>().0;
    let content = runs_where(pixels.rect, texels, |texel| texel[3] != 0);
    let filled = runs_where(pixels.rect, &pixels.needed, |flags| flags & FILLED != 0);
    let mut trust: Vec<u8> = texels.iter().map(|texel| texel[3]).collect();
    ConfidenceRamp::default().each(&content.minus(&filled), |x, y, ramp| {
        if let Some(at) = pixels.rect.index(x, y) {
            trust[at] = ((f32::from(trust[at]) * ramp + 0.5) as u8).max(1);
        }
    });
    trust
}

/// Returns the rectangle around those pixels of a rectangle that are meant; `None` around none.
fn bounds(of: PixelRect, meant: &[bool]) -> Option<PixelRect> {
    let runs = runs_where(of, meant, |meant| *meant).bounds();
    (!runs.is_empty()).then_some(runs)
}
