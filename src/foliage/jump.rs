//! Jumps between two frames: what a plant's picture changes by that its truth does not.

use serde::Serialize;

use super::similarity::over_sky;
use quadratura_view::Picture;

/// How much more a plant's pictures change from one frame to the next than the truth does, in steps of 8 bits: of the means of blocks of 8 x 8
/// pixels over a plain sky, in gamma. A jump of many pixels to and fro, as of leaves that move, has a small mean in each block; one of the
/// eye's kind, where a part becomes brighter, darker or larger, has not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Jump {
    /// The mean of the blocks in which the truth shows something.
    pub mean: f64,
    /// The largest one.
    pub most: f64,
}

/// The side of a block in pixels.
const BLOCK: usize = 8;

/// Compares the change between two frames with that of the truth; all pictures have the same size. `None` where the truth shows nothing.
pub fn jump(truth: [&Picture; 2], pictures: [&Picture; 2]) -> Option<Jump> {
    let shown: Vec<bool> =
        truth[0].pixels().iter().zip(truth[1].pixels()).map(|(a, b)| a[3] > 0 || b[3] > 0).collect();
    let width = truth[0].width as usize;
    let means = |picture: &Picture| means(&over_sky(picture), width);
    let ([truth, pictures], shown) = ([truth, pictures].map(|of| of.map(means)), any(&shown, width));
    let changes = (0..shown.len()).filter(|block| shown[*block]).map(|block| {
        let change = |of: &[Vec<[f64; 3]>; 2], channel: usize| of[1][block][channel] - of[0][block][channel];
        [0, 1, 2].map(|c| (change(&pictures, c) - change(&truth, c)).abs()).iter().sum::<f64>() / 3.0
    });
    let changes: Vec<f64> = changes.collect();
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    (!changes.is_empty()).then(|| Jump { mean, most: changes.iter().copied().fold(0.0, f64::max) })
}

/// Returns the blocks of a picture that are whole.
fn blocks(width: usize, pixels: usize) -> impl Iterator<Item = impl Iterator<Item = usize>> {
    let (across, down) = (width / BLOCK, pixels / width.max(1) / BLOCK);
    (0..across * down).map(move |block| {
        let first = BLOCK * (block / across * width + block % across);
        (0..BLOCK * BLOCK).map(move |at| first + at / BLOCK * width + at % BLOCK)
    })
}

fn any(shown: &[bool], width: usize) -> Vec<bool> {
    blocks(width, shown.len()).map(|mut block| block.any(|at| shown[at])).collect()
}

fn means(rgb: &[u8], width: usize) -> Vec<[f64; 3]> {
    let (pixels, _) = rgb.as_chunks::<3>();
    let mean = |block: &mut dyn Iterator<Item = usize>| {
        let sum = block.fold([0.0; 3], |sum, at| [0, 1, 2].map(|c| sum[c] + f64::from(pixels[at][c])));
        sum.map(|sum| sum / (BLOCK * BLOCK) as f64)
    };
    blocks(width, pixels.len()).map(|mut block| mean(&mut block)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixel: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
        let rgba = (0..20 * 17).flat_map(|at| pixel(at % 20, at / 20)).collect();
        Picture { width: 20, height: 17, rgba }
    }

    #[test]
    fn what_the_truth_does_too_is_no_jump_and_what_it_does_not_is_one_in_its_block() {
        let grey = |byte: u8| picture(move |x, _| if x < 10 { [byte, byte, byte, 255] } else { [0; 4] });
        let (dark, bright) = (grey(100), grey(120));
        assert_eq!(jump([&dark, &bright], [&dark, &bright]), Some(Jump { mean: 0.0, most: 0.0 }));
        // Blocks are 2 x 2; two of them are covered, and two in a fourth of their columns.
        let found = jump([&dark, &dark], [&dark, &bright]).unwrap();
        assert!((found.most - 20.0).abs() < 1e-9 && (found.mean - 12.5).abs() < 1e-9, "{found:?}");
        let spot = picture(|x, y| {
            if x < 10 && (x, y) != (2, 3) {
                [100, 100, 100, 255]
            } else if x < 10 {
                [164, 164, 164, 255]
            } else {
                [0; 4]
            }
        });
        let found = jump([&dark, &dark], [&dark, &spot]).unwrap();
        assert!((found.most - 1.0).abs() < 1e-9 && (found.mean - 0.25).abs() < 1e-9, "{found:?}");
        let empty = picture(|_, _| [0; 4]);
        assert_eq!(jump([&empty, &empty], [&dark, &bright]), None);
    }
}
