//! What is around the site in every direction, as a picture of the six sides of a cube.

use quadratura_page::chunk::Chunk;
use quadratura_page::pictures::jpeg;
use quadratura_projection::dome::{Dome, SIDES};

/// The quality of the picture; it is mostly smooth.
const QUALITY: u8 = 85;

/// Returns the chunk with the sides below each other.
pub fn dome(dome: &Dome) -> Chunk {
    let rgb: Vec<u8> = dome.texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let mut chunk = Chunk::default();
    chunk.add("sides", &jpeg(&rgb, [dome.side, SIDES as u32 * dome.side], QUALITY));
    chunk
}
