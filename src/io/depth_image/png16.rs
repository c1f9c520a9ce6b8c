//! PNG of one channel with 16 bits: whole numbers, as depth cameras and many data sets store them.

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::depth_file::{COPY, DepthFile, check_size};
use quadratura_base::error::{Error, Result};

/// Bytes that a decoder may take beside the picture: for chunks of text and profiles.
const SLACK: usize = 64 << 20;

/// Reads the numbers of a file, 0 to 65535, rows from the top.
pub(super) fn read(source: &mut DepthFile, size: [u32; 2]) -> Result<Vec<f32>> {
    let bytes = 2 * size[0] as usize * size[1] as usize;
    let path = source.path.clone();
    let unreadable = |error: png::DecodingError| {
        Error::input(&path, "", format!("the PNG cannot be decoded ({error})"), COPY)
    };
    let mut decoder = Decoder::new_with_limits(&mut source.reader, Limits { bytes: bytes + SLACK });
    decoder.set_transformations(Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(unreadable)?;
    let info = reader.info();
    let (color, depth, found) = (info.color_type, info.bit_depth, [info.width, info.height].map(u64::from));
    if (color, depth) != (ColorType::Grayscale, BitDepth::Sixteen) {
        let found = format!("{color:?} with {} bits; expected grey with 16 bits and no alpha", depth as u8);
        let remedy = "save the depth as a 16-bit grey PNG, or as OpenEXR; a picture of colours for people has no depths";
        return Err(Error::input(&path, "header", found, remedy));
    }
    check_size(&path, found, size)?;
    let mut samples = vec![0u8; bytes];
    reader.next_frame(&mut samples).map_err(unreadable)?;
    Ok(samples.as_chunks().0.iter().map(|sample| f32::from(u16::from_be_bytes(*sample))).collect())
}
