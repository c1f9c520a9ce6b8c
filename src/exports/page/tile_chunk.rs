//! Pages of tiles as chunks.

use super::plane::{differences, in_8_steps, in_16_steps};
use super::tiles::{PAGE, TilePage, TiledPhoto};
use quadratura_page::chunk::Chunk;
use quadratura_page::pictures::photo_jpeg;

/// Hidden texels are seen in narrow strips: their quality is lower by this.
const HIDDEN_LOWER: u8 = 10;

/// What tiles show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileKind {
    /// Filled and painted texels.
    Hidden,
    /// Layers that one sees through, with their mattes.
    Cut,
}

impl TileKind {
    /// Returns what a layer's tiles show.
    pub fn of(tiled: &TiledPhoto) -> Self {
        if tiled.has_matte { Self::Cut } else { Self::Hidden }
    }

    /// Returns the name by which chunks begin.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hidden => "hidden",
            Self::Cut => "cut",
        }
    }

    /// Returns a page as a chunk, for photos of a JPEG quality.
    pub fn chunk(self, page: &TilePage, quality: u8) -> Chunk {
        let mut content = Chunk::default();
        let quality = match self {
            Self::Hidden => quality.saturating_sub(HIDDEN_LOWER).max(1),
            Self::Cut => quality,
        };
        let colours = page.colours(self == Self::Cut);
        content.add("colours", &photo_jpeg(&colours, [PAGE as u32, page.rows() as u32], quality));
        let trust: Vec<u8> = page.trust().into_iter().map(in_8_steps).collect();
        content.add_packed("trust", &differences(&trust, PAGE));
        if self == Self::Cut {
            let mattes: Vec<u8> = page.mattes().into_iter().map(in_16_steps).collect();
            content.add_packed("mattes", &differences(&mattes, PAGE));
        }
        content
    }
}
