//! Writing the filling of a stack to files.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::unknown::UNKNOWN;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{PhotoId, Samples};
use quadratura_document::Stack;
use quadratura_document::stack::{LayerFill, StackFill, origins};
use quadratura_io::layer_png::{write_grey, write_rgba};
use quadratura_layers::content::PixelSpan;
use quadratura_layers::fill::see_through::LayerMatte;
use quadratura_layers::fill::{Donor, FillOrigin, FilledRegion, FilledTexel, PhotoFilling, PropagatedPaint};

/// The sources that are not photos; their indices are the first ones of the list of sources.
const FIXED: [&str; 4] = [origins::NONE, origins::PAINTED, origins::EXEMPLAR, origins::DIFFUSED];

/// Writes the filling of each image layer into `folder` and describes it in `stack`. The caller adds the hash of
/// the inputs, the number of hidden texels and the list of propagated paint. `names` are the photos' names.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`] when a file cannot be written.
pub(super) fn write_fill(
    folder: &Path,
    stack: &mut Stack,
    filled: &PhotoFilling,
    propagated: &PropagatedPaint,
    own: &Donor,
    names: &[&str],
) -> Result<()> {
    let all: Vec<&FilledRegion> = filled.regions.iter().chain(&filled.surroundings).collect();
    let sources = sources(all.iter().copied().chain(&propagated.regions));
    let count = stack.image_layers.len();
    let (parts, laid) = (by_layer(all.iter().copied(), count), by_layer(propagated.regions.iter(), count));
    let layers: Vec<_> = stack.image_layers.iter().zip(parts).zip(laid).enumerate().collect();
    let written: Vec<Option<(LayerFill, u64)>> = layers
        .into_par_iter()
        .map(|(index, ((layer, parts), laid))| {
            let matte = filled.mattes.iter().find(|matte| matte.layer.index() == index);
            let images = FillImages::new(layer.rect, &parts, &laid, matte, own.bits, &sources);
            images.write(folder, &layer.id, layer.rect, own.icc.as_deref())
        })
        .collect::<Result<_>>()?;
    let count = |origin: &dyn Fn(FillOrigin) -> bool| {
        let texels = filled.regions.iter().flat_map(|region| &region.texels);
        texels.filter(|texel| origin(texel.origin)).count() as u64
    };
    stack.fill = Some(StackFill {
        inputs: String::new(),
        origins: FIXED
            .iter()
            .copied()
            .map(Into::into)
            .chain(sources.iter().map(|source| match source {
                TexelSource::Photo(photo) => names[photo.index()].to_owned(),
                TexelSource::Painter(photo) => origins::painted_in(names[photo.index()]),
            }))
            .collect(),
        texels_hidden: 0,
        texels_from_photos: count(&|origin| matches!(origin, FillOrigin::Photo(_))),
        texels_from_paint: count(&|origin| matches!(origin, FillOrigin::Painted(_))),
        texels_by_example: count(&|origin| origin == FillOrigin::Exemplar),
        texels_diffused: count(&|origin| origin == FillOrigin::Diffused),
        matte_pixels: 0,
        matte_unknown: 0,
        propagated: Vec::new(),
        bytes: written.iter().flatten().map(|(_, bytes)| bytes).sum(),
        basis: None,
    });
    for (layer, written) in stack.image_layers.iter_mut().zip(written) {
        layer.fill = written.map(|(fill, _)| fill);
    }
    Ok(())
}

/// A source of texels: a photo, or the paint in one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum TexelSource {
    Photo(PhotoId),
    Painter(PhotoId),
}

impl TexelSource {
    /// Returns the source of an origin; `None` for inpainting.
    fn from_origin(origin: FillOrigin) -> Option<Self> {
        match origin {
            FillOrigin::Photo(photo) => Some(Self::Photo(photo)),
            FillOrigin::Painted(photo) => Some(Self::Painter(photo)),
            FillOrigin::Exemplar | FillOrigin::Diffused => None,
        }
    }
}

/// Returns the sources that occur, sorted.
fn sources<'a>(regions: impl Iterator<Item = &'a FilledRegion>) -> Vec<TexelSource> {
    let texels = regions.flat_map(|region| &region.texels);
    texels
        .filter_map(|texel| TexelSource::from_origin(texel.origin))
        .collect::<BTreeSet<_>>()
        .into_iter()
        .collect()
}

/// A run of texels in a row.
type TexelRun<'a> = (PixelSpan, &'a [FilledTexel]);

/// Sorts the runs of all regions by image layer.
fn by_layer<'a>(regions: impl Iterator<Item = &'a FilledRegion>, layers: usize) -> Vec<Vec<TexelRun<'a>>> {
    let mut parts = vec![Vec::new(); layers];
    for region in regions {
        for span in &region.region.spans {
            let first = span.first as usize;
            let texels = &region.texels[first..first + (span.span.x1 - span.span.x0) as usize];
            parts[span.layer.index()].push((span.span, texels));
        }
    }
    parts
}

/// The images of one layer's filling.
struct FillImages {
    colours: Samples,
    /// Propagated paint over visible texels; `None` where there is none.
    propagated: Option<Samples>,
    /// The matte of see-through surfaces.
    matte: Option<Vec<u8>>,
    /// Their own colours where the photo shows mixtures; `None` where it shows none.
    foreground: Option<Samples>,
    confidence: Vec<u8>,
    provenance: Vec<u16>,
    texels: u64,
    largest: u16,
}

impl FillImages {
    /// Draws the filling of a layer, the paint that is propagated to it, and its matte.
    fn new(
        rect: PixelRect,
        parts: &[TexelRun],
        laid: &[TexelRun],
        matte: Option<&LayerMatte>,
        bits: u8,
        sources: &[TexelSource],
    ) -> Self {
        let count = rect.area() as usize;
        let blank = || match bits {
            16 => Samples::U16(vec![0; 4 * count]),
            _ => Samples::U8(vec![0; 4 * count]),
        };
        let mut images = Self {
            colours: blank(),
            propagated: (!laid.is_empty()).then(blank),
            matte: matte.map(|_| vec![u8::MAX; count]),
            foreground: None,
            confidence: vec![0; count],
            provenance: vec![0; count],
            texels: parts.iter().map(|(_, texels)| texels.len() as u64).sum(),
            largest: (FIXED.len() + sources.len()) as u16,
        };
        for (at, texel) in texels_of(rect, parts) {
            put(&mut images.colours, at, texel.rgb);
            images.describe(at, texel, sources);
        }
        if let Some((from, matte)) = matte.zip(images.matte.as_mut()) {
            let texels = from.matte.iter().zip(&from.foreground).zip(&from.unknown);
            for ((x, y), ((alpha, colour), unknown)) in from.rect.pixels().zip(texels) {
                let Some(at) = rect.index(x, y) else { continue };
                matte[at] = *alpha;
                if *unknown {
                    images.confidence[at] = UNKNOWN;
                }
                if let Some(colour) = colour {
                    put(images.foreground.get_or_insert_with(blank), at, *colour);
                }
            }
        }
        for (at, texel) in texels_of(rect, laid) {
            if let Some(propagated) = &mut images.propagated {
                put(propagated, at, texel.rgb);
            }
            // Paint is solid.
            images.matte.iter_mut().for_each(|matte| matte[at] = u8::MAX);
            images.describe(at, texel, sources);
        }
        images
    }

    /// Sets confidence and source of a texel.
    fn describe(&mut self, at: usize, texel: FilledTexel, sources: &[TexelSource]) {
        self.confidence[at] = texel.confidence;
        self.provenance[at] = match (texel.origin, TexelSource::from_origin(texel.origin)) {
            (FillOrigin::Exemplar, _) => 2,
            (_, Some(source)) => (FIXED.len() + sources.partition_point(|g| *g < source)) as u16,
            (_, None) => 3,
        };
    }

    /// Writes the files, unless nothing was filled or propagated. Returns their names and their size in bytes.
    fn write(
        self,
        folder: &Path,
        id: &str,
        rect: PixelRect,
        icc: Option<&[u8]>,
    ) -> Result<Option<(LayerFill, u64)>> {
        if self.texels == 0 && self.propagated.is_none() && self.matte.is_none() {
            return Ok(None);
        }
        let fill = LayerFill {
            filled_file: format!("{id}.filled.png"),
            confidence_file: format!("{id}.confidence.png"),
            provenance_file: format!("{id}.provenance.png"),
            propagation_file: self.propagated.as_ref().map(|_| format!("{id}.spread.png")),
            matte_file: self.matte.as_ref().map(|_| format!("{id}.matte.png")),
            foreground_file: self.foreground.as_ref().map(|_| format!("{id}.foreground.png")),
            texels_filled: self.texels,
        };
        let provenance = match self.largest {
            0..256 => Samples::U8(self.provenance.iter().map(|index| *index as u8).collect()),
            _ => Samples::U16(self.provenance),
        };
        let propagated = fill.propagation_file.as_ref().zip(self.propagated.as_ref());
        let propagated = propagated.map(|(file, samples)| write_rgba(&folder.join(file), rect, samples, icc));
        let foreground = fill.foreground_file.as_ref().zip(self.foreground.as_ref());
        let foreground = foreground.map(|(file, samples)| write_rgba(&folder.join(file), rect, samples, icc));
        let matte = fill.matte_file.as_ref().zip(self.matte);
        let matte = matte.map(|(file, matte)| write_grey(&folder.join(file), rect, &Samples::U8(matte)));
        let bytes = propagated.unwrap_or(Ok(0))?
            + foreground.unwrap_or(Ok(0))?
            + matte.unwrap_or(Ok(0))?
            + write_rgba(&folder.join(&fill.filled_file), rect, &self.colours, icc)?
            + write_grey(&folder.join(&fill.confidence_file), rect, &Samples::U8(self.confidence))?
            + write_grey(&folder.join(&fill.provenance_file), rect, &provenance)?;
        Ok(Some((fill, bytes)))
    }
}

/// Iterates over the texels of runs with their indices in an image of `rect`.
fn texels_of<'a>(
    rect: PixelRect,
    runs: &'a [TexelRun<'a>],
) -> impl Iterator<Item = (usize, FilledTexel)> + 'a {
    let first = move |span: &PixelSpan| rect.offset(span.x0 as i32, span.y as i32);
    runs.iter().flat_map(move |(span, texels)| (first(span)..).zip(texels.iter().copied()))
}

/// Sets an opaque texel.
fn put(samples: &mut Samples, at: usize, [r, g, b]: [u16; 3]) {
    match samples {
        Samples::U8(samples) => {
            let byte = |value: u16| (value / 257) as u8;
            samples[4 * at..4 * at + 4].copy_from_slice(&[byte(r), byte(g), byte(b), u8::MAX]);
        }
        Samples::U16(samples) => samples[4 * at..4 * at + 4].copy_from_slice(&[r, g, b, u16::MAX]),
    }
}
