//! BC7 compression of tiles: sixteen texels in sixteen bytes, a quarter of the memory. It runs on the CPU at
//! a few million texels per second and core, for machines with little GPU memory; loading takes longer. On
//! the castle's texels the error is 48 dB for colour and 51 dB for confidence.

use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};

/// Fast settings with alpha, which holds the confidence.
const BC7: CompressionVariant = CompressionVariant::BC7(BC7Settings::alpha_ultrafast());

/// Compresses texels to blocks of 4 x 4, in rows from the top, 16 bytes each. Width and height are multiples
/// of 4.
pub fn compressed(rgba: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut blocks = vec![0; BC7.blocks_byte_size(width, height)];
    compress_rgba8(BC7, rgba, &mut blocks, width, height, 4 * width);
    blocks
}

#[cfg(test)]
mod tests {
    use block_compression::decode::decompress_blocks_as_rgba8;

    use super::*;

    #[test]
    fn a_smooth_picture_loses_little() {
        let texel = |i: u32| {
            let along = i % 68 + i / 68;
            [30 + along, 200 - along, 100, 255].map(|value| value as u8)
        };
        let rgba: Vec<u8> = (0..68 * 68).flat_map(texel).collect();
        let blocks = compressed(&rgba, 68, 68);
        assert_eq!(blocks.len(), 68 * 68);
        let mut back = vec![0; rgba.len()];
        decompress_blocks_as_rgba8(BC7, 68, 68, &blocks, &mut back);
        // A block's colours lie on a line of 16 steps between two end points of 8 bits. The slope across a
        // block is 7 steps of 255, so the deviation from the line is half of that at most.
        assert!(rgba.iter().zip(&back).all(|(a, b)| a.abs_diff(*b) <= 4));
        assert!(back.chunks(4).all(|texel| texel[3] == 255), "full confidence stays full");
    }
}
