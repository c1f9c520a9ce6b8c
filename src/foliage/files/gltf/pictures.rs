//! Pictures, in the file itself or beside it.

use std::borrow::Cow;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::pictures::{LONGEST_SIDE, pixels_of};
use crate::Pixels;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_import::models::gltf::{Source, resource};
use quadratura_import::photo::decode_picture;

/// Reads pictures, each once.
pub struct Pictures<'a> {
    source: &'a Source<'a>,
    known: FxHashMap<usize, Arc<Pixels>>,
}

impl<'a> Pictures<'a> {
    /// Prepares the pictures of a file.
    pub fn new(source: &'a Source<'a>) -> Self {
        Self { source, known: FxHashMap::default() }
    }

    /// Returns the picture of a texture that the value at a JSON path names.
    ///
    /// # Errors
    /// [`Error::Input`] with the JSON path; [`Error::Io`].
    pub fn of_texture(&mut self, texture: usize, place: impl Fn() -> String) -> Result<Arc<Pixels>> {
        let Some(described) = self.source.root.textures.get(texture) else {
            return Err(self.source.error(&place(), format!("textures[{texture}] does not exist")));
        };
        let image = described.source.value();
        // What the package gives to textures without a source.
        if image == u32::MAX as usize {
            let found = "no source; pictures of extensions alone, such as KTX2 and WebP, are not read";
            return Err(self.source.error(&format!("textures[{texture}]"), found));
        }
        if let Some(known) = self.known.get(&image) {
            return Ok(known.clone());
        }
        let place = format!("images[{image}]");
        let bytes = self.bytes(image, &place)?;
        let photo =
            decode_picture(self.source.path, &bytes, LONGEST_SIDE).map_err(|error| at(error, &place))?;
        let pixels = Arc::new(pixels_of(&photo));
        self.known.insert(image, pixels.clone());
        Ok(pixels)
    }

    fn bytes(&self, image: usize, place: &str) -> Result<Cow<'a, [u8]>> {
        let source = self.source;
        let described = source.root.images.get(image);
        let described = described.ok_or_else(|| source.error(place, "this picture does not exist"))?;
        match (&described.uri, described.buffer_view) {
            (Some(uri), _) => resource(source.path, place, uri).map(Cow::Owned),
            (None, Some(view)) => {
                let view = view.value();
                let found = || format!("bufferViews[{view}], which is missing or not within its buffer");
                source.view_bytes(view).map(Cow::Borrowed).ok_or_else(|| source.error(place, found()))
            }
            (None, None) => Err(source.error(place, "neither a uri nor a bufferView")),
        }
    }
}

/// Gives an error about a picture its place.
fn at(error: Error, place: &str) -> Error {
    match error {
        Error::Input { file, found, remedy, .. } => {
            Error::Input { file, place: place.to_owned(), found, remedy }
        }
        other => other,
    }
}

/// Returns the mean linear light of a picture, weighted by alpha, and its mean alpha, 0..=1.
pub fn mean(pixels: &Pixels) -> [f32; 4] {
    let mut sums = [0.0f64; 4];
    for [r, g, b, a] in pixels.rgba() {
        let alpha = f64::from(*a) / 255.0;
        for (sum, byte) in sums.iter_mut().zip([r, g, b]) {
            *sum += alpha * f64::from(LINEAR_FROM_BYTE[usize::from(*byte)]);
        }
        sums[3] += alpha;
    }
    let [r, g, b, alpha] = sums;
    let share = |sum: f64| if alpha > 0.0 { (sum / alpha) as f32 } else { 0.0 };
    [share(r), share(g), share(b), (alpha / pixels.rgba().len() as f64) as f32]
}
