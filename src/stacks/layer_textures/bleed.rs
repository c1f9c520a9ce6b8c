//! Texels outside of a layer's content that have the photo's own colours.

use quadratura_projection::sources::BLEED;

/// Marks texels that contain the photo's colour beside the layer's visible part: transparent pixels that are not black and touch
/// one that is visible. Those beside what the photo hides have the colours of what hides it, which must not be seen.
pub fn mark_bleed(rgba: &[u8], needed: &mut [u8], width: usize) {
    let texels = rgba.as_chunks::<4>().0;
    let rows: Vec<&[[u8; 4]]> = texels.chunks(width.max(1)).collect();
    for (y, needed) in needed.chunks_mut(width.max(1)).enumerate() {
        let around = &rows[y.saturating_sub(1)..(y + 2).min(rows.len())];
        for (x, needed) in needed.iter_mut().enumerate() {
            let [r, g, b, a] = rows[y][x];
            let left = x.saturating_sub(1);
            let touches_visible =
                || around.iter().any(|row| row.iter().take(x + 2).skip(left).any(|texel| texel[3] > 0));
            if a == 0 && r | g | b != 0 && touches_visible() {
                *needed |= BLEED;
            }
        }
    }
}
