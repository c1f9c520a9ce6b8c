//! Reads the first page of a TIFF or BigTIFF of 8 or 16 bits: grey, RGB, palettes and CMYK, in strips or tiles, interleaved or
//! in planes, without compression or with LZW, Deflate, PackBits or JPEG (Adobe, *TIFF 6.0*, 1992; BigTIFF as in libtiff).
//!
//! Colours that are stored multiplied with opacity (associated alpha) are divided by it. What is not read is refused by name.

use std::io::{Read, Seek};
use std::path::Path;

use image::error::DecodingError;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageResult, LimitSupport, Limits};

use self::chunks::{ChannelSample, samples};
use self::directory::{Directory, TiffDefect};
use self::layout::{Alpha, Colours, DAMAGED, Layout};
use quadratura_base::error::{Error, Result};

mod chunks;
mod directory;
mod layout;

#[cfg(test)]
mod tests;

/// A TIFF whose tags were read.
pub(super) struct TiffPhoto<R> {
    file: Directory<R>,
    layout: Layout,
    most: u64,
}

impl<R: Read + Seek> TiffPhoto<R> {
    /// Reads the tags. Pixels are decoded with at most `most` bytes for a strip or tile.
    ///
    /// # Errors
    /// [`Error::Input`] where the file is damaged or of a kind that is not read, which is named.
    pub fn open(path: &Path, input: R, most: u64) -> Result<Self> {
        let refused = |(found, remedy): (TiffDefect, &'static str)| Error::input(path, "", found, remedy);
        let mut file = Directory::open(input).map_err(|defect| refused((defect, DAMAGED)))?;
        let layout = Layout::read(&mut file).map_err(refused)?;
        Ok(Self { file, layout, most })
    }

    /// Returns remarks for the user about what was found in the file.
    pub fn notes(&self) -> &[String] {
        &self.layout.notes
    }

    fn decoded<T: ChannelSample>(mut self) -> Result<Vec<T>, TiffDefect> {
        let layout = &self.layout;
        let mut pixels: Vec<T> = samples(&mut self.file, layout, self.most)?;
        let channels = layout.used.len();
        let narrow = |value: u32| T::try_from(value).unwrap_or_default();
        if layout.colours == (Colours::Grey { inverted: true }) {
            pixels.iter_mut().step_by(channels).for_each(|grey| *grey = narrow(T::FULL - (*grey).into()));
        }
        if layout.alpha == Alpha::Associated {
            pixels.chunks_exact_mut(channels).for_each(divided_by_alpha);
        }
        Ok(match &layout.colours {
            Colours::Grey { .. } | Colours::Rgb => pixels,
            Colours::Palette(colours) => {
                let of =
                    |index: T| colours[Into::<u32>::into(index) as usize].map(|byte| narrow(byte.into()));
                let pixels = pixels.chunks_exact(channels);
                pixels.flat_map(|pixel| of(pixel[0]).into_iter().chain(pixel[1..].iter().copied())).collect()
            }
            Colours::Cmyk => {
                let pixel = |pixel: &[T]| {
                    let rest = |ink: T| T::FULL - Into::<u32>::into(ink);
                    let light = |ink: &T| narrow((rest(*ink) * rest(pixel[3]) + T::FULL / 2) / T::FULL);
                    pixel[..3].iter().map(light).chain(pixel[4..].iter().copied()).collect::<Vec<T>>()
                };
                pixels.chunks_exact(channels).flat_map(pixel).collect()
            }
        })
    }
}

/// Divides the colours of a pixel by its opacity, the last of its samples.
fn divided_by_alpha<T: ChannelSample>(pixel: &mut [T]) {
    let Some((alpha, colours)) = pixel.split_last_mut() else { return };
    let alpha: u32 = (*alpha).into();
    for colour in colours {
        let stored: u64 = Into::<u32>::into(*colour).into();
        // Nothing is known about the colour where nothing is opaque.
        let whole = (stored * u64::from(T::FULL) + u64::from(alpha / 2)).checked_div(alpha.into());
        *colour = T::try_from(whole.unwrap_or(0).min(T::FULL.into()) as u32).unwrap_or_default();
    }
}

fn decoding(defect: TiffDefect) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormat::Tiff.into(), defect))
}

impl<R: Read + Seek> ImageDecoder for TiffPhoto<R> {
    fn dimensions(&self) -> (u32, u32) {
        (self.layout.width, self.layout.height)
    }

    fn color_type(&self) -> ColorType {
        let is_grey = matches!(self.layout.colours, Colours::Grey { .. });
        match (is_grey, self.layout.alpha != Alpha::None, self.layout.bits == 16) {
            (true, false, false) => ColorType::L8,
            (true, false, true) => ColorType::L16,
            (true, true, false) => ColorType::La8,
            (true, true, true) => ColorType::La16,
            (false, false, false) => ColorType::Rgb8,
            (false, false, true) => ColorType::Rgb16,
            (false, true, false) => ColorType::Rgba8,
            (false, true, true) => ColorType::Rgba16,
        }
    }

    fn icc_profile(&mut self) -> ImageResult<Option<Vec<u8>>> {
        self.file.bytes(34675).map_err(decoding)
    }

    fn orientation(&mut self) -> ImageResult<Orientation> {
        let tag = self.file.number(274).map_err(decoding)?;
        let orientation = tag.and_then(|tag| Orientation::from_exif(u8::try_from(tag).ok()?));
        Ok(orientation.unwrap_or(Orientation::NoTransforms))
    }

    fn set_limits(&mut self, limits: Limits) -> ImageResult<()> {
        limits.check_support(&LimitSupport::default())?;
        self.most = limits.max_alloc.unwrap_or(self.most);
        Ok(())
    }

    fn read_image(self, buf: &mut [u8]) -> ImageResult<()> {
        if self.layout.bits == 16 {
            let pixels: Vec<u16> = self.decoded().map_err(decoding)?;
            buf.copy_from_slice(bytemuck::cast_slice(&pixels));
        } else {
            let pixels: Vec<u8> = self.decoded().map_err(decoding)?;
            buf.copy_from_slice(&pixels);
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, buf: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(buf)
    }
}
