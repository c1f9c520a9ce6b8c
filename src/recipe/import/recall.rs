//! What layers showed when they were looked at before, by the hash of their code: who watches a folder looks at the
//! same layers again after every save, and most of them are as they were.

use std::sync::{Mutex, PoisonError};

use rustc_hash::FxHashMap;

use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::hash::Hashing;
use crate::io::layered::EditedLayer;

/// Kept from import to import, by whoever makes several. What is in it holds for ever: it is found by all that it was
/// made of.
#[derive(Debug, Default)]
pub struct Recall {
    sights: Mutex<FxHashMap<String, Sight>>,
}

/// What the layers of one token showed together.
#[derive(Debug, Clone, PartialEq)]
pub struct Sight {
    /// Hash of it in the depth of the export, at its place in the photo.
    pub shown: String,
    /// In canvas pixels.
    pub rect: PixelRect,
    /// What was not followed of them, and what was taken for granted.
    pub notes: Vec<String>,
}

impl Recall {
    /// What was seen under this code.
    pub fn sight(&self, code: &str) -> Option<Sight> {
        self.sights.lock().unwrap_or_else(PoisonError::into_inner).get(code).cloned()
    }

    /// Keeps what was seen.
    pub fn keep(&self, code: String, sight: Sight) {
        self.sights.lock().unwrap_or_else(PoisonError::into_inner).insert(code, sight);
    }
}

/// A hash of all that the layers of a token show, without decoding it; `desk` is what all layers of the document have in
/// common. None where the format cannot say.
///
/// # Errors
/// Those of reading the file.
pub fn code_of(desk: &str, layers: &[&EditedLayer]) -> Result<Option<String>> {
    let mut hashing = Hashing::default();
    hashing.add(desk.as_bytes());
    for layer in layers {
        let Some(pixels) = layer.pixels.code()? else { return Ok(None) };
        let look =
            (&layer.name, layer.rect, layer.visible, layer.hidden_by_group, layer.opacity, &layer.blend);
        hashing.add(format!("{look:?}").as_bytes());
        hashing.add(pixels.as_bytes());
        for mask in &layer.masks {
            let Some(grey) = mask.pixels.code()? else { return Ok(None) };
            hashing.add(format!("{:?} {} {}", mask.rect, mask.outside.to_bits(), mask.enabled).as_bytes());
            hashing.add(grey.as_bytes());
        }
    }
    Ok(Some(hashing.hash()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::io::layered::{Blend, Depth, EditedMask, Grey, Lazy, Raster};
    use crate::scene::Samples;

    const RECT: PixelRect = PixelRect { x: 1, y: 2, w: 3, h: 4 };

    fn layer(stored: &'static str) -> EditedLayer {
        let pixels = Lazy::new(|| Ok(Raster::blank(3, 4, Depth::Eight))).with_code(|| Ok(stored.to_owned()));
        EditedLayer::plain("wall", RECT, pixels)
    }

    fn masked(stored: &'static str, enabled: bool) -> EditedLayer {
        let grey = Lazy::new(|| Ok(Grey::new(0, 0, Samples::U8(vec![])))).with_code(|| Ok(stored.to_owned()));
        let mask = EditedMask { rect: RECT, outside: 1.0, enabled, pixels: grey };
        EditedLayer { masks: vec![Arc::new(mask)], ..layer("a") }
    }

    fn code(layers: &[&EditedLayer]) -> String {
        code_of("desk", layers).unwrap().expect("all layers know their code")
    }

    #[test]
    fn all_that_a_layer_shows_is_in_its_code() {
        let different = [
            layer("a"),
            layer("b"),
            EditedLayer { visible: false, ..layer("a") },
            EditedLayer { hidden_by_group: true, ..layer("a") },
            EditedLayer { opacity: 0.5, ..layer("a") },
            EditedLayer { blend: Blend::Other("multiply".into()), ..layer("a") },
            EditedLayer { rect: PixelRect { x: 0, ..RECT }, ..layer("a") },
            masked("m", true),
            masked("n", true),
            masked("m", false),
        ];
        let mut codes: Vec<String> = different.iter().map(|layer| code(&[layer])).collect();
        codes.push(code(&[&layer("a"), &layer("a")]));
        codes.push(code_of("another desk", &[&layer("a")]).unwrap().unwrap());
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
        assert_eq!(code_of("desk", &[&layer("a"), &unknown]).unwrap(), None);
    }
}
