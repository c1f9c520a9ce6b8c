//! The formats of pictures, and pictures of either precision that are written in them.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_io::picture_exr::{self, write_exr};
use quadratura_io::picture_png::{self, WrittenPicture, write_picture, write_picture_16};
use quadratura_view::{LinearPicture, Picture};

/// The format of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PictureFormat {
    /// PNG with 8 bits a channel, sRGB.
    #[default]
    Png,
    /// PNG with 16 bits a channel, sRGB.
    Png16,
    /// OpenEXR: 16-bit floats in linear light, and depths.
    Exr,
}

impl PictureFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Png, Self::Png16, Self::Exr];

    /// Returns the extension of the files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png | Self::Png16 => picture_png::EXTENSION,
            Self::Exr => picture_exr::EXTENSION,
        }
    }

    /// Returns whether pictures are drawn in linear light, because 8 bits a channel are too few.
    pub fn is_linear(self) -> bool {
        match self {
            Self::Png => false,
            Self::Png16 | Self::Exr => true,
        }
    }
}

/// A picture that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum DrawnPicture {
    /// With 8 bits a channel.
    Bytes(Picture),
    /// In linear light.
    Linear(LinearPicture),
}

impl From<Picture> for DrawnPicture {
    fn from(picture: Picture) -> Self {
        Self::Bytes(picture)
    }
}

impl From<LinearPicture> for DrawnPicture {
    fn from(picture: LinearPicture) -> Self {
        Self::Linear(picture)
    }
}

impl DrawnPicture {
    /// Returns the picture with 8 bits a channel.
    pub(super) fn into_bytes(self) -> Picture {
        match self {
            Self::Bytes(picture) => picture,
            Self::Linear(picture) => picture.picture(),
        }
    }

    /// Returns the picture in linear light.
    fn into_linear(self) -> LinearPicture {
        match self {
            Self::Bytes(picture) => LinearPicture::of(&picture),
            Self::Linear(picture) => picture,
        }
    }

    /// Makes all pixels that are fully transparent black.
    pub(super) fn blacken(&mut self) {
        match self {
            Self::Bytes(picture) => {
                let transparent =
                    picture.rgba.as_chunks_mut::<4>().0.iter_mut().filter(|pixel| pixel[3] == 0);
                transparent.for_each(|pixel| *pixel = [0; 4]);
            }
            Self::Linear(picture) => {
                let transparent = picture.rgba.iter_mut().filter(|pixel| pixel[3] == 0.0);
                transparent.for_each(|pixel| *pixel = [0.0; 4]);
            }
        }
    }

    /// Returns the share of the picture that is textured.
    pub(super) fn textured(&self) -> f64 {
        let pixels = match self {
            DrawnPicture::Bytes(picture) => picture.pixels(),
            DrawnPicture::Linear(picture) => return picture.textured(),
        };
        pixels.iter().map(|pixel| f64::from(pixel[3]) / 255.0).sum::<f64>() / pixels.len() as f64
    }
}

/// Writes a picture of this name into a folder; returns its size, too.
///
/// # Errors
/// [`quadratura_base::error::Error::Io`]; an existing file stays.
pub(super) fn write(
    folder: &Path,
    name: &str,
    format: PictureFormat,
    picture: DrawnPicture,
) -> Result<([u32; 2], WrittenPicture)> {
    Ok(match format {
        PictureFormat::Png => {
            let Picture { width, height, rgba } = picture.into_bytes();
            ([width, height], write_picture(folder, name, [width, height], &rgba)?)
        }
        PictureFormat::Png16 => {
            let picture = picture.into_linear();
            let size = [picture.width, picture.height];
            (size, write_picture_16(folder, name, size, &picture.srgb_16_bits())?)
        }
        PictureFormat::Exr => {
            let picture = picture.into_linear();
            ([picture.width, picture.height], write_exr(folder, name, &picture)?)
        }
    })
}
