//! Decoding of layer textures into pyramids, in parallel, with a cache of limited size.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_projection::mattes::MatteTextures;
use quadratura_projection::pyramid::{Pyramid, PyramidOptions, matte_pyramid, pyramid};
use quadratura_projection::{LayerTextureId, LayerTexturePixels, Texels, TextureOptions};

/// A layer texture and its pyramid.
pub type MadePyramid = (LayerTextureId, Arc<Pyramid>);

/// The result of decoding layer textures: the pyramids of those that could be read, and the errors of the others.
#[derive(Debug, Default)]
pub struct DecodedPyramids {
    /// The pyramids, in the order in which the layer textures were requested.
    pub made: Vec<MadePyramid>,
    /// The errors, in the same order.
    pub failed: Vec<(LayerTextureId, Error)>,
}

/// The stride in which layer textures are decoded, so that the first ones are representative: a photo's own layer
/// textures are consecutive.
const STRIDE: u32 = 13;

/// A decoder of layer textures into pyramids.
#[derive(Clone)]
pub struct PyramidDecoder {
    texels: Arc<dyn Texels>,
    rects: Arc<[PixelRect]>,
    mattes: Arc<MatteTextures>,
    options: PyramidOptions,
}

impl PyramidDecoder {
    /// Builds the pyramid of decoded pixels: of their mattes where the texture is the matte of a layer texture.
    pub fn of_pixels(&self, texture: LayerTextureId, pixels: &LayerTexturePixels) -> Arc<Pyramid> {
        let rect = self.rects[texture.0 as usize];
        Arc::new(match self.mattes.source(texture) {
            Some(_) => matte_pyramid(rect, pixels, &self.options),
            None => pyramid(rect, pixels, &self.options),
        })
    }

    /// Builds the pyramid of an empty layer texture.
    pub fn of_nothing(&self, layer_texture: LayerTextureId) -> Arc<Pyramid> {
        let rect = PixelRect { w: 0, h: 0, ..self.rects[layer_texture.0 as usize] };
        self.of_pixels(
            layer_texture,
            &LayerTexturePixels { rect, rgba: Vec::new(), needed: Vec::new(), matte: None },
        )
    }

    /// Decodes layer textures from their files, in parallel.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; errors of single layer textures are in the decoded.
    pub fn decode_all(&self, layer_textures: &[LayerTextureId], task: &Task) -> Result<DecodedPyramids> {
        let make = |layer_texture: &LayerTextureId| {
            task.check_cancelled()?;
            match self.texels.layer_texture(self.mattes.source(*layer_texture).unwrap_or(*layer_texture)) {
                Err(Error::Cancelled) => Err(Error::Cancelled),
                read => Ok((*layer_texture, read.map(|pixels| self.of_pixels(*layer_texture, &pixels)))),
            }
        };
        let mut decoded = DecodedPyramids::default();
        for (layer_texture, made) in layer_textures.par_iter().map(make).collect::<Result<Vec<_>>>()? {
            match made {
                Ok(pyramid) => decoded.made.push((layer_texture, pyramid)),
                Err(error) => decoded.failed.push((layer_texture, error)),
            }
        }
        Ok(decoded)
    }
}

/// A cache of the pyramids of layer textures; the least recently used are dropped first.
pub struct Pyramids {
    maker: PyramidDecoder,
    kept: FxHashMap<LayerTextureId, (Arc<Pyramid>, u64)>,
    bytes: u64,
    most_bytes: u64,
    /// The largest number of texels that are decoded at once, which limits memory.
    batch_texels: u64,
    now: u64,
}

impl Pyramids {
    /// Creates an empty cache for layer textures with these rectangles, those of their mattes last.
    pub fn new(
        texels: Arc<dyn Texels>,
        rects: Vec<PixelRect>,
        mattes: MatteTextures,
        options: &TextureOptions,
    ) -> Self {
        let maker =
            PyramidDecoder { texels, rects: rects.into(), mattes: mattes.into(), options: options.pyramid };
        let (most_bytes, batch_texels) = (options.cache_bytes, options.decoded_texels());
        Self { maker, kept: FxHashMap::default(), bytes: 0, most_bytes, batch_texels, now: 0 }
    }

    /// Reads layer textures from `texels` from now on; pyramids in the cache are kept.
    pub fn read_from(&mut self, texels: Arc<dyn Texels>) {
        self.maker.texels = texels;
    }

    /// Returns the decoder, for use in parallel with the cache.
    pub fn maker(&self) -> PyramidDecoder {
        self.maker.clone()
    }

    /// Returns the layer textures' rectangles, in photo pixels.
    pub fn rects(&self) -> &[PixelRect] {
        &self.maker.rects
    }

    /// Returns the number of texels of a layer texture's rectangle.
    pub fn area(&self, layer_texture: LayerTextureId) -> u64 {
        self.rects()[layer_texture.0 as usize].area()
    }

    /// Divides layer textures into batches that are decoded at once, within the limit of memory.
    pub fn batches(&self, layer_textures: BTreeSet<LayerTextureId>) -> Vec<Vec<LayerTextureId>> {
        let mut layer_textures: Vec<LayerTextureId> = layer_textures.into_iter().collect();
        layer_textures.sort_by_key(|layer_texture| (layer_texture.0 % STRIDE, *layer_texture));
        let mut batches: Vec<Vec<LayerTextureId>> = Vec::new();
        let mut room = 0;
        for layer_texture in layer_textures {
            let texels = self.area(layer_texture);
            if texels > room || batches.is_empty() {
                batches.push(Vec::new());
                room = self.batch_texels;
            }
            room = room.saturating_sub(texels);
            batches.last_mut().into_iter().for_each(|batch| batch.push(layer_texture));
        }
        batches
    }

    /// Returns the pyramids of layer textures, cached ones first, and the number of those that had to be decoded.
    ///
    /// # Errors
    /// As [`PyramidDecoder::decode_all`].
    pub fn get(
        &mut self,
        layer_textures: &[LayerTextureId],
        task: &Task,
    ) -> Result<(DecodedPyramids, usize)> {
        let cached: Vec<_> = layer_textures
            .iter()
            .map(|layer_texture| (*layer_texture, self.cached(*layer_texture)))
            .collect();
        let missing: Vec<LayerTextureId> = cached
            .iter()
            .filter(|(_, cached)| cached.is_none())
            .map(|(layer_texture, _)| *layer_texture)
            .collect();
        let DecodedPyramids { made, failed } = self.maker.decode_all(&missing, task)?;
        self.keep(&made);
        let decoded = made.len();
        let cached = cached.into_iter().filter_map(|(layer_texture, cached)| Some((layer_texture, cached?)));
        Ok((DecodedPyramids { made: cached.chain(made).collect(), failed }, decoded))
    }

    /// Returns the pyramid of a layer texture if it is cached.
    pub fn cached(&mut self, layer_texture: LayerTextureId) -> Option<Arc<Pyramid>> {
        self.now += 1;
        let (pyramid, used) = self.kept.get_mut(&layer_texture)?;
        *used = self.now;
        Some(pyramid.clone())
    }

    /// Adds pyramids to the cache, replacing the layer textures' old ones. The newest is kept however large it is.
    pub fn keep(&mut self, made: &[MadePyramid]) {
        for (layer_texture, pyramid) in made {
            self.now += 1;
            self.bytes += pyramid.bytes();
            if let Some((old, _)) = self.kept.insert(*layer_texture, (pyramid.clone(), self.now)) {
                self.bytes -= old.bytes();
            }
            self.forget_oldest();
        }
    }

    fn forget_oldest(&mut self) {
        while self.bytes > self.most_bytes && self.kept.len() > 1 {
            let oldest =
                self.kept.iter().min_by_key(|(_, (_, used))| *used).map(|(layer_texture, _)| *layer_texture);
            let Some((gone, _)) = oldest.and_then(|layer_texture| self.kept.remove(&layer_texture)) else {
                return;
            };
            self.bytes -= gone.bytes();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source of layer textures without files.
    struct None;

    impl Texels for None {
        fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
            Err(Error::Request(format!("layer texture {} was read", layer_texture.0)))
        }
    }

    fn square(side: u32) -> Arc<Pyramid> {
        let rect = PixelRect::of_size(side, side);
        let texels = rect.area() as usize;
        let pixels = LayerTexturePixels {
            rect,
            rgba: vec![255; 4 * texels],
            needed: vec![1; texels],
            matte: Option::None,
        };
        Arc::new(pyramid(rect, &pixels, &PyramidOptions::default()))
    }

    fn pyramids(most_bytes: u64) -> Pyramids {
        let rect = PixelRect::of_size(4096, 4096);
        Pyramids::new(
            Arc::new(None),
            vec![rect; 20],
            MatteTextures::default(),
            &TextureOptions { cache_bytes: most_bytes, ..TextureOptions::default() },
        )
    }

    #[test]
    fn what_was_not_used_for_longest_is_forgotten() {
        let one = square(64);
        let mut pyramids = pyramids(2 * one.bytes());
        (0..2).for_each(|i| pyramids.keep(&[(LayerTextureId(i), one.clone())]));
        assert!(pyramids.cached(LayerTextureId(0)).is_some());
        pyramids.keep(&[(LayerTextureId(2), one.clone())]);
        let there: Vec<bool> = (0..3).map(|i| pyramids.cached(LayerTextureId(i)).is_some()).collect();
        assert_eq!(there, [true, false, true]);
        pyramids.keep(&[(LayerTextureId(2), one.clone())]);
        assert!(pyramids.cached(LayerTextureId(0)).is_some() && pyramids.bytes == 2 * one.bytes());
        let task = Task::silent();
        assert_eq!(pyramids.get(&[LayerTextureId(2)], &task).unwrap().1, 0);
        let (batch, made) = pyramids.get(&[LayerTextureId(2), LayerTextureId(1)], &task).unwrap();
        assert_eq!((batch.made.len(), made), (1, 0));
        assert_eq!(batch.failed[0].0, LayerTextureId(1), "it has to be read");
    }

    #[test]
    fn what_is_larger_than_the_bound_is_kept_alone() {
        let mut pyramids = pyramids(1);
        pyramids.keep(&[(LayerTextureId(0), square(8)), (LayerTextureId(1), square(16))]);
        assert!(pyramids.cached(LayerTextureId(0)).is_none() && pyramids.cached(LayerTextureId(1)).is_some());
    }

    #[test]
    fn batches_hold_every_sheet_once() {
        for (cache_bytes, sheets) in [(1 << 30, 2), (256 << 20, 2), (128 << 20, 1), (1, 1)] {
            let batches = pyramids(cache_bytes).batches((0..20).map(LayerTextureId).collect());
            assert!(batches.iter().all(|batch| batch.len() == sheets), "each sheet is half a usual batch");
            let mut all = batches.concat();
            all.sort_unstable();
            assert_eq!(all, (0..20).map(LayerTextureId).collect::<Vec<_>>());
        }
    }
}
