//! Pictures of a comparison: the photo, its prediction and their difference side by side.

use std::path::{Path, PathBuf};

use super::one::ComparedPixels;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_io::picture_png::write_picture;

/// The factor by which differences are amplified.
const AMPLIFIED: u32 = 4;
/// The gap between panels in pixels.
const GAP: usize = 8;
/// The colour of pixels that were not predicted, in the difference.
const HOLE: [u8; 3] = [0, 40, 140];
/// The colour of ignored pixels, in the difference.
const LEFT_OUT: [u8; 3] = [48; 3];

/// The three panels as RGB, each `width * height * 3`.
pub(super) struct Panels<'a> {
    width: usize,
    photo: &'a [u8],
    prediction: &'a [u8],
    difference: Vec<u8>,
}

impl<'a> Panels<'a> {
    /// Takes the panels of one comparison.
    pub fn from_pixels(pixels: &'a ComparedPixels) -> Self {
        Self {
            width: pixels.reference.width as usize,
            photo: &pixels.reference.rgb,
            prediction: &pixels.over_black,
            difference: difference(pixels),
        }
    }

    /// Puts the panels side by side with gaps between them.
    fn side_by_side(&self) -> Vec<u8> {
        let rows = |panel: &'a [u8]| panel.chunks_exact(3 * self.width);
        let differences = self.difference.chunks_exact(3 * self.width);
        let mut out = Vec::with_capacity(3 * self.photo.len());
        for ((photo, prediction), difference) in rows(self.photo).zip(rows(self.prediction)).zip(differences)
        {
            for (panel, gap) in [(photo, GAP), (prediction, GAP), (difference, 0)] {
                out.extend_from_slice(panel);
                out.extend(std::iter::repeat_n(0, 3 * gap));
            }
        }
        out
    }
}

/// Returns the amplified difference per channel; holes and ignored pixels have colours of their own.
fn difference(pixels: &ComparedPixels) -> Vec<u8> {
    let (truth, _) = pixels.reference.rgb.as_chunks::<3>();
    let (predicted, _) = pixels.predicted.as_chunks::<3>();
    let at = |i: usize| match (pixels.asked[i], pixels.covered[i]) {
        (false, _) => LEFT_OUT,
        (true, false) => HOLE,
        (true, true) => std::array::from_fn(|channel| {
            let amount = AMPLIFIED * u32::from(truth[i][channel].abs_diff(predicted[i][channel]));
            amount.min(255) as u8
        }),
    };
    (0..truth.len()).flat_map(at).collect()
}

/// Writes the panels as `folder/STEM.png`.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`] when the file cannot be written.
pub(super) fn write(folder: &Path, stem: &str, panels: &Panels, task: &Task) -> Result<PathBuf> {
    let height = panels.photo.len() / (3 * panels.width);
    let size_px = [3 * panels.width + 2 * GAP, height].map(|side| side as u32);
    let placed = write_picture(folder, stem, size_px, &panels.side_by_side())?;
    for file in &placed.spared {
        let (old, new) = (file.display(), placed.path.display());
        task.note(format!("{old} was changed by another program and is kept; this picture is {new}"));
    }
    Ok(placed.path)
}
