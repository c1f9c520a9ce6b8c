//! The pictures of an exported layered depth image beside its colours: rims and opacity.

use crate::segments::Atlas;
use quadratura_page::pictures::{ExtendedColorType, png};

/// Returns what a segment covers, and its opacity there, as a PNG: grey where everything that is covered is opaque, otherwise
/// the cover in red and the opacity in green.
pub fn rims(atlas: &Atlas) -> Vec<u8> {
    let soft = atlas.opacity.iter().any(|opacity| !matches!(opacity, 0 | 255));
    let cover = |opacity: u8| if opacity > 0 { 255 } else { 0 };
    if soft {
        let pixels: Vec<u8> =
            atlas.opacity.iter().flat_map(|&opacity| [cover(opacity), opacity, 0]).collect();
        return png(&pixels, [atlas.width, atlas.height], ExtendedColorType::Rgb8);
    }
    png(&atlas.opacity, [atlas.width, atlas.height], ExtendedColorType::L8)
}

/// Returns colours with their opacity as a PNG.
pub fn rgba_png(atlas: &Atlas) -> Vec<u8> {
    let texels = atlas.rgb.as_chunks::<3>().0.iter().zip(&atlas.opacity);
    let pixels: Vec<u8> = texels.flat_map(|(&[r, g, b], &a)| [r, g, b, a]).collect();
    png(&pixels, [atlas.width, atlas.height], ExtendedColorType::Rgba8)
}
