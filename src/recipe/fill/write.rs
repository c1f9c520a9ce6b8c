//! The filling of a stack as files.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use crate::document::Stack;
use crate::document::stack::{LayerFill, StackFill, origins};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layer_png::{write_grey, write_rgba};
use crate::layers::content::PixelSpan;
use crate::layers::fill::{Donor, Filled, Origin, Texel};
use crate::scene::Samples;

/// Places of the origins that are no photos.
const FIXED: [&str; 4] = [origins::NONE, origins::PAINTED, origins::EXEMPLAR, origins::DIFFUSED];

/// Writes the filling of each image layer into `folder`, and says in `stack` what was written; the hash of
/// what it was made of and the number of hidden texels are left to the caller. `names` are the photos'.
///
/// # Errors
/// [`crate::Error::Io`].
pub(super) fn write_fill(
    folder: &Path,
    stack: &mut Stack,
    filled: &Filled,
    own: &Donor,
    names: &[&str],
) -> Result<()> {
    let givers = givers(filled);
    let mut parts: Vec<Vec<(PixelSpan, &[Texel])>> = vec![Vec::new(); stack.image_layers.len()];
    for region in &filled.regions {
        for span in &region.region.spans {
            let first = span.first as usize;
            let texels = &region.texels[first..first + (span.span.x1 - span.span.x0) as usize];
            parts[span.layer as usize].push((span.span, texels));
        }
    }
    let layers: Vec<_> = stack.image_layers.iter().zip(parts).collect();
    let written: Vec<Option<(LayerFill, u64)>> = layers
        .into_par_iter()
        .map(|(layer, parts)| {
            let maps = Maps::of(layer.rect, &parts, own.bits, &givers);
            maps.write(folder, &layer.id, layer.rect, own.icc.as_deref())
        })
        .collect::<Result<_>>()?;
    let count = |origin: &dyn Fn(Origin) -> bool| {
        let texels = filled.regions.iter().flat_map(|region| &region.texels);
        texels.filter(|texel| origin(texel.origin)).count() as u64
    };
    stack.fill = Some(StackFill {
        inputs: String::new(),
        origins: FIXED
            .iter()
            .copied()
            .chain(givers.iter().map(|g| names[*g as usize]))
            .map(Into::into)
            .collect(),
        texels_hidden: 0,
        texels_from_photos: count(&|origin| matches!(origin, Origin::Photo(_))),
        texels_by_example: count(&|origin| origin == Origin::Exemplar),
        texels_diffused: count(&|origin| origin == Origin::Diffused),
        bytes: written.iter().flatten().map(|(_, bytes)| bytes).sum(),
    });
    for (layer, written) in stack.image_layers.iter_mut().zip(written) {
        layer.fill = written.map(|(fill, _)| fill);
    }
    Ok(())
}

/// The photos that gave something, rising.
fn givers(filled: &Filled) -> Vec<u32> {
    let texels = filled.regions.iter().flat_map(|region| &region.texels);
    let photos = texels.filter_map(|texel| match texel.origin {
        Origin::Photo(photo) => Some(photo.0),
        _ => None,
    });
    photos.collect::<BTreeSet<u32>>().into_iter().collect()
}

/// The pictures of one image layer's filling.
struct Maps {
    colours: Samples,
    confidence: Vec<u8>,
    provenance: Vec<u16>,
    texels: u64,
    largest: u16,
}

impl Maps {
    fn of(rect: PixelRect, parts: &[(PixelSpan, &[Texel])], bits: u8, givers: &[u32]) -> Self {
        let count = rect.area() as usize;
        let mut maps = Self {
            colours: if bits == 16 {
                Samples::U16(vec![0; 4 * count])
            } else {
                Samples::U8(vec![0; 4 * count])
            },
            confidence: vec![0; count],
            provenance: vec![0; count],
            texels: 0,
            largest: (FIXED.len() + givers.len()) as u16,
        };
        for (span, texels) in parts {
            let row = (span.y as i32 - rect.y) as usize * rect.w as usize;
            let first = row + (span.x0 as i32 - rect.x) as usize;
            for (at, texel) in (first..).zip(*texels) {
                maps.put(at, *texel, givers);
            }
        }
        maps
    }

    fn put(&mut self, at: usize, texel: Texel, givers: &[u32]) {
        let [r, g, b] = texel.rgb;
        match &mut self.colours {
            Samples::U8(samples) => {
                let byte = |value: u16| (value / 257) as u8;
                samples[4 * at..4 * at + 4].copy_from_slice(&[byte(r), byte(g), byte(b), u8::MAX]);
            }
            Samples::U16(samples) => samples[4 * at..4 * at + 4].copy_from_slice(&[r, g, b, u16::MAX]),
        }
        self.confidence[at] = texel.confidence;
        self.provenance[at] = match texel.origin {
            Origin::Exemplar => 2,
            Origin::Diffused => 3,
            Origin::Photo(photo) => (FIXED.len() + givers.partition_point(|g| *g < photo.0)) as u16,
        };
        self.texels += 1;
    }

    /// Nothing where nothing was filled.
    fn write(
        self,
        folder: &Path,
        id: &str,
        rect: PixelRect,
        icc: Option<&[u8]>,
    ) -> Result<Option<(LayerFill, u64)>> {
        if self.texels == 0 {
            return Ok(None);
        }
        let fill = LayerFill {
            filled_file: format!("{id}.filled.png"),
            confidence_file: format!("{id}.confidence.png"),
            provenance_file: format!("{id}.provenance.png"),
            texels_filled: self.texels,
        };
        let provenance = match self.largest {
            0..256 => Samples::U8(self.provenance.iter().map(|place| *place as u8).collect()),
            _ => Samples::U16(self.provenance),
        };
        let bytes = write_rgba(&folder.join(&fill.filled_file), rect, &self.colours, icc)?
            + write_grey(&folder.join(&fill.confidence_file), rect, &Samples::U8(self.confidence))?
            + write_grey(&folder.join(&fill.provenance_file), rect, &provenance)?;
        Ok(Some((fill, bytes)))
    }
}
