//! BC7: sixteen texels in sixteen bytes, so a quarter of the memory. Compressed on the processor, a few
//! million texels a second on a core: for machines whose GPU memory is short, not for loading in a hurry.
//! On the castle's texels: 48 dB of colour, 51 dB of confidence.

use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};

/// Fast, and with alpha, which is confidence.
const BC7: CompressionVariant = CompressionVariant::BC7(BC7Settings::alpha_ultrafast());

/// Blocks of 4 x 4 texels, in rows from the top, 16 bytes each. Width and height: multiples of 4.
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
        // A block's colours lie on a line of 16 steps between two ends of 8 bits; the slope across a block
        // is 7 steps of 255, so that what is off the line is off by half of that at most.
        assert!(rgba.iter().zip(&back).all(|(a, b)| a.abs_diff(*b) <= 4));
        assert!(back.chunks(4).all(|texel| texel[3] == 255), "full confidence stays full");
    }
}
