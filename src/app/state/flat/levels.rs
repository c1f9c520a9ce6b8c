//! A picture with its halved versions, of which a view draws the one that suits its scale.

use std::sync::Arc;

use quadratura_projection::reduced::halves;
use quadratura_view::Picture;

/// The side of a tile, in pixels: every device has textures of this size, and one is made in a fraction of a
/// millisecond.
pub const TILE_SIDE: u32 = 512;

/// A picture with its halved versions: full size first, the smallest fits into a tile.
pub type Levels = Arc<Vec<Picture>>;

/// Computes the levels of a picture. This takes a while, so it is work for a job.
pub fn levels_of(picture: Picture) -> Levels {
    let halves = halves(&picture, TILE_SIDE);
    Arc::new(std::iter::once(picture).chain(halves).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_halved_until_it_fits_into_a_tile() {
        let of = |width: u32, height: u32| {
            let levels = levels_of(Picture { width, height, rgba: vec![255; 4 * (width * height) as usize] });
            levels.iter().map(|level| [level.width, level.height]).collect::<Vec<_>>()
        };
        assert_eq!(of(512, 8), [[512, 8]]);
        assert_eq!(of(1600, 20), [[1600, 20], [800, 10], [400, 5]]);
    }
}
