//! Pages as files of pictures.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// The quality of JPEG files, 1 to 100: nobody tells them from the photos.
const QUALITY: u8 = 92;

/// The format of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PageKind {
    /// RGB as JPEG.
    Jpeg,
    /// RGB as PNG.
    Png,
    /// RGB and alpha as PNG.
    PngWithAlpha,
    /// Grey as PNG.
    Grey,
}

impl PageKind {
    /// Returns the ending of files, with its dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Jpeg => ".jpg",
            Self::Png | Self::PngWithAlpha | Self::Grey => ".png",
        }
    }

    /// Returns the media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Jpeg => "image/jpeg",
            Self::Png | Self::PngWithAlpha | Self::Grey => "image/png",
        }
    }

    /// Returns the number of values of a texel.
    pub fn channels(self) -> usize {
        match self {
            Self::Jpeg | Self::Png => 3,
            Self::PngWithAlpha => 4,
            Self::Grey => 1,
        }
    }
}

/// Encodes texels, 8 bits a value, rows from the top.
///
/// # Panics
/// When their number does not fit the size.
pub fn encoded(kind: PageKind, texels: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let colour = match kind {
        PageKind::Jpeg | PageKind::Png => ExtendedColorType::Rgb8,
        PageKind::PngWithAlpha => ExtendedColorType::Rgba8,
        PageKind::Grey => ExtendedColorType::L8,
    };
    let written = match kind {
        PageKind::Jpeg => {
            JpegEncoder::new_with_quality(&mut bytes, QUALITY).write_image(texels, width, height, colour)
        }
        PageKind::Png | PageKind::PngWithAlpha | PageKind::Grey => {
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
                .write_image(texels, width, height, colour)
        }
    };
    written.expect("pages have sizes that both formats allow, and memory does not fail");
    bytes
}
