//! The pictures of a layer as PNG.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, Transformations};

use super::json::LayersFile;
use quadratura_base::error::{Error, Result};

/// What the blue of a surface's picture has where there is a depth pixel.
pub(super) const HELD: u16 = u16::MAX;

/// The remedy for a picture that cannot be used.
pub(super) const REMEDY: &str = "save the picture in its size and kind again, or export the layers anew";

/// Bytes that a decoder may take beside the picture: for chunks of text and profiles.
const SLACK: usize = 64 << 20;

/// A picture of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureKind {
    Colours,
    Depths,
    Surfaces,
}

impl PictureKind {
    pub const ALL: [Self; 3] = [Self::Colours, Self::Depths, Self::Surfaces];

    /// Returns its name in the folder, for a layer counted from 0.
    pub fn file_name(self, layer: usize) -> String {
        let name = match self {
            Self::Colours => "layer",
            Self::Depths => "depth",
            Self::Surfaces => "surface",
        };
        format!("{name}-{layer:02}.png")
    }

    /// Returns the kind of samples and the bytes of a pixel.
    fn samples(self) -> (ColorType, BitDepth, usize) {
        match self {
            Self::Colours => (ColorType::Rgba, BitDepth::Eight, 4),
            Self::Depths => (ColorType::Grayscale, BitDepth::Sixteen, 2),
            Self::Surfaces => (ColorType::Rgb, BitDepth::Sixteen, 6),
        }
    }

    /// Returns a PNG of samples, 16 bits with the higher byte first.
    pub(super) fn encoded(
        self,
        [width, height]: [u32; 2],
        samples: &[u8],
    ) -> Result<Vec<u8>, png::EncodingError> {
        let (color, depth, _) = self.samples();
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(samples)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Reads the samples of a file, which must have the frame's size. Colours may also be grey, without opacity, or of 16 bits,
    /// as image editors save them.
    pub(super) fn decoded(self, file: &Path, json: &LayersFile) -> Result<Vec<u8>> {
        let size = [json.camera.width, json.camera.height];
        let (color, depth, pixel) = self.samples();
        let bytes = size[0] as usize * size[1] as usize * pixel;
        let unreadable = |error: png::DecodingError| {
            Error::input(file, "", format!("the PNG cannot be decoded ({error})"), REMEDY)
        };
        let input = BufReader::new(File::open(file).map_err(Error::io(file, "open it"))?);
        // Colours with 16 bits are twice as large while they are decoded.
        let mut decoder = Decoder::new_with_limits(input, Limits { bytes: 2 * bytes + SLACK });
        decoder.set_transformations(match self {
            Self::Colours => Transformations::normalize_to_color8() | Transformations::ALPHA,
            Self::Depths | Self::Surfaces => Transformations::IDENTITY,
        });
        let mut reader = decoder.read_info().map_err(unreadable)?;
        let found = [reader.info().width, reader.info().height];
        if found != size {
            let found = format!("{} x {} pixels; expected {} x {}", found[0], found[1], size[0], size[1]);
            return Err(Error::input(file, "", found, REMEDY));
        }
        let kind = reader.output_color_type();
        let grey = self == Self::Colours && kind == (ColorType::GrayscaleAlpha, BitDepth::Eight);
        if kind != (color, depth) && !grey {
            let found =
                format!("{:?} with {} bits; expected {color:?} with {}", kind.0, kind.1 as u8, depth as u8);
            return Err(Error::input(file, "", found, REMEDY));
        }
        let mut samples = vec![0u8; if grey { bytes / 2 } else { bytes }];
        reader.next_frame(&mut samples).map_err(unreadable)?;
        if grey {
            samples = samples
                .as_chunks()
                .0
                .iter()
                .flat_map(|[grey, opacity]| [*grey, *grey, *grey, *opacity])
                .collect();
        }
        Ok(samples)
    }
}
