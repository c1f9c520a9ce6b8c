//! What is still unknown of the mattes in a filling: painted pixels are known, since somebody painted them.

use std::path::Path;

use crate::paint::PhotoPaint;
use quadratura_base::error::Result;
use quadratura_document::Stack;
use quadratura_io::layer_reader::{read_grey, read_layer};
use quadratura_layers::fill::INVENTED_CONFIDENCE;

/// The confidence in 255ths of a visible texel of which nobody knows how much of it is the surface.
pub(super) const UNKNOWN: u8 = (INVENTED_CONFIDENCE * 255.0) as u8;

/// Returns the number of pixels of a photo that show see-through surfaces of which nobody knows how much is the surface:
/// the filling's count without the pixels that were painted. `folder` has the stack's files.
///
/// # Errors
/// Returns the errors of reading the stack's files and paint.
pub fn unknown_matte_pixels(stack: &Stack, folder: &Path, paint: &PhotoPaint) -> Result<u64> {
    let unknown = stack.fill.as_ref().map_or(0, |fill| fill.matte_unknown);
    let mut known = 0;
    for (index, layer) in stack.numbered_layers().filter(|_| unknown > 0) {
        let Some(fill) = layer.fill.as_ref().filter(|fill| fill.matte_file.is_some()) else { continue };
        let patch = paint.on(stack, index)?;
        if patch.is_empty() {
            continue;
        }
        let grey = |file: &str| read_grey(&folder.join(file), layer.rect, layer.rect);
        let (confidence, provenance) = (grey(&fill.confidence_file)?, grey(&fill.provenance_file)?);
        let texels = read_layer(&folder.join(&layer.file), layer.rect, layer.rect)?;
        known += patch
            .iter()
            .filter_map(|(x, y, _)| layer.rect.index(x, y))
            // Filled texels have a source, and others are not visible.
            .filter(|at| {
                texels[4 * at + 3] > 0 && provenance[*at] == 0 && confidence[*at] == u16::from(UNKNOWN)
            })
            .count() as u64;
    }
    Ok(unknown.saturating_sub(known))
}
