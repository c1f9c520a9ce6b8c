//! A cache of what layers showed at earlier imports, by the hash of their stored data: a watched folder is read
//! after each save, and most layers of a file have not changed then.

use std::iter;
use std::sync::{Arc, Mutex, PoisonError};

use rustc_hash::FxHashMap;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_files::hash::Hashing;
use quadratura_layered_files::{EditedLayer, EditedMask};

/// The cache, kept by callers that import repeatedly. Its entries never become invalid, because their keys cover
/// everything they were made from.
#[derive(Debug, Default)]
pub struct LayerCache {
    sights: Mutex<FxHashMap<String, CachedLayer>>,
}

/// The combined layers of one token, without their pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedLayer {
    /// The hash of the pixels in the bit depth of the export, at their position in the photo.
    pub shown: String,
    /// The rectangle in canvas pixels.
    pub rect: PixelRect,
    /// Notes about what was ignored or assumed.
    pub notes: Vec<String>,
}

impl LayerCache {
    /// Returns the entry of a key.
    pub fn sight(&self, code: &str) -> Option<CachedLayer> {
        self.sights.lock().unwrap_or_else(PoisonError::into_inner).get(code).cloned()
    }

    /// Stores an entry.
    pub fn keep(&self, code: String, sight: CachedLayer) {
        self.sights.lock().unwrap_or_else(PoisonError::into_inner).insert(code, sight);
    }
}

/// Returns a hash of everything that determines what the layers of a token show, without decoding their pixels;
/// `desk` contains what all layers of the document share. `None` where the format does not permit that.
///
/// # Errors
/// Returns the errors of reading the file.
pub fn key_of_layers<'a>(context: &str, layers: &[&'a EditedLayer]) -> Result<Option<String>> {
    let mut hashing = Hashing::default();
    hashing.add(context.as_bytes());
    for layer in layers {
        let Some(pixels) = layer.pixels.code()? else { return Ok(None) };
        let look =
            (&layer.name, layer.rect, layer.visible, layer.hidden_by_group, layer.opacity, &layer.blend);
        hashing.add(format!("{look:?}").as_bytes());
        hashing.add(pixels.as_bytes());
        let both =
            |mask: &'a Arc<EditedMask>| iter::successors(Some(&**mask), |mask| mask.lowest_with.as_deref());
        for mask in layer.masks.iter().flat_map(both) {
            let Some(grey) = mask.pixels.code()? else { return Ok(None) };
            hashing.add(format!("{:?} {} {}", mask.rect, mask.outside.to_bits(), mask.enabled).as_bytes());
            hashing.add(grey.as_bytes());
        }
    }
    Ok(Some(hashing.hash()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;
    use quadratura_layered_files::{BlendMode, Depth, Grey, Lazy, Raster};

    const RECT: PixelRect = PixelRect { x: 1, y: 2, w: 3, h: 4 };

    fn layer(stored: &'static str) -> EditedLayer {
        let pixels =
            Lazy::new(|| Ok(Raster::blank(3, 4, Depth::Eight))).with_stored_hash(|| Ok(stored.to_owned()));
        EditedLayer::plain("wall", RECT, pixels)
    }

    fn masked(stored: &'static str, enabled: bool) -> EditedLayer {
        let grey =
            Lazy::new(|| Ok(Grey::new(0, 0, Samples::U8(vec![])))).with_stored_hash(|| Ok(stored.to_owned()));
        let mask = EditedMask { rect: RECT, outside: 1.0, enabled, lowest_with: None, pixels: grey };
        EditedLayer { masks: vec![Arc::new(mask)], ..layer("a") }
    }

    fn code(layers: &[&EditedLayer]) -> String {
        key_of_layers("desk", layers).unwrap().expect("all layers know their code")
    }

    #[test]
    fn all_that_a_layer_shows_is_in_its_code() {
        let different = [
            layer("a"),
            layer("b"),
            EditedLayer { visible: false, ..layer("a") },
            EditedLayer { hidden_by_group: true, ..layer("a") },
            EditedLayer { opacity: 0.5, ..layer("a") },
            EditedLayer { blend: BlendMode::Other("multiply".into()), ..layer("a") },
            EditedLayer { rect: PixelRect { x: 0, ..RECT }, ..layer("a") },
            masked("m", true),
            masked("n", true),
            masked("m", false),
        ];
        let mut codes: Vec<String> = different.iter().map(|layer| code(&[layer])).collect();
        codes.push(code(&[&layer("a"), &layer("a")]));
        codes.push(key_of_layers("another desk", &[&layer("a")]).unwrap().unwrap());
        assert_eq!(codes[0], code(&[&layer("a")]));
        let all = codes.len();
        codes.sort();
        codes.dedup();
        assert_eq!(codes.len(), all);
    }

    #[test]
    fn what_cannot_say_what_it_is_decoded_from_is_looked_at_each_time() {
        let pixels = Lazy::new(|| Ok(Raster::blank(3, 4, Depth::Eight)));
        let unknown = EditedLayer { pixels, ..layer("a") };
        assert_eq!(key_of_layers("desk", &[&layer("a"), &unknown]).unwrap(), None);
    }
}
