//! Layers that were stored with fewer colours than they were exported with.

use std::path::Path;

use rustc_hash::FxHashSet;

use super::identify::SortedLayers;
use super::layer::{LayerPaint, TO_RGB};
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::{ExportFormat, RecordedIndex};
use quadratura_layered_files::{EditedDocument, Raster, StoredColours};

/// The most colours of a palette.
const PALETTE: usize = 256;

/// Returns in words how pixels are stored that cannot have the colours that were exported as `base`; `None` where they
/// can.
pub fn lost_colours(stored: StoredColours, base: &Raster) -> Option<&'static str> {
    let visible = (0..base.height()).flat_map(|y| (0..base.width()).map(move |x| base.rgba16(x, y)));
    let mut visible = visible.filter(|colour| colour[3] != 0);
    match stored {
        StoredColours::Full => None,
        StoredColours::Grey => {
            let (mut all, mut coloured) = (0u64, 0u64);
            visible.for_each(|[r, g, b, _]| {
                all += 1;
                coloured += u64::from(r != g || g != b);
            });
            // A photo in black and white loses nothing.
            (2 * coloured > all).then_some("greyscale")
        }
        StoredColours::Palette => {
            let mut colours = FxHashSet::default();
            let too_many = |[r, g, b, _]: [u16; 4]| {
                colours.insert([r, g, b]);
                colours.len() > PALETTE
            };
            visible.any(too_many).then_some("indexed colours")
        }
    }
}

/// Rejects a file that is stored in fewer colours as a whole; where only some layers are, these are left out.
pub fn refuse_lost_colours(
    file: &Path,
    document: &EditedDocument,
    sorted: &SortedLayers,
    found: &[(RecordedIndex, LayerPaint)],
) -> Result<()> {
    let mut lost = found.iter().filter_map(|(_, paint)| paint.lost_colours);
    let layers = || sorted.image_layers.values().flatten();
    let is_indexed =
        document.format == ExportFormat::Xcf && layers().any(|layer| layer.colours == StoredColours::Palette);
    let is_whole = layers().all(|layer| layer.colours != StoredColours::Full);
    let stored = lost.next().filter(|_| is_whole).or(is_indexed.then_some("indexed colours"));
    let Some(stored) = stored else { return Ok(()) };
    let found = format!(
        "the image is stored in {stored}, which cannot hold the colours that were exported and painted"
    );
    Err(Error::input(file, "", found, TO_RGB))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_layered_files::Depth;

    fn raster(colour: impl Fn(u32) -> [u16; 4]) -> Raster {
        let mut raster = Raster::blank(40, 10, Depth::Sixteen);
        (0..400).for_each(|i| raster.set_rgba16(i % 40, i / 40, colour(i)));
        raster
    }

    #[test]
    fn grey_loses_the_colours_of_a_coloured_layer_only() {
        let coloured = raster(|i| [i as u16, 900, 3, 65535]);
        let black_and_white = raster(|i| if i < 30 { [9, 8, 7, 65535] } else { [i as u16; 4] });
        assert_eq!(lost_colours(StoredColours::Grey, &coloured), Some("greyscale"));
        assert_eq!(lost_colours(StoredColours::Grey, &black_and_white), None);
        assert_eq!(lost_colours(StoredColours::Full, &coloured), None);
    }

    #[test]
    fn a_palette_loses_what_is_more_than_256_colours() {
        assert_eq!(
            lost_colours(StoredColours::Palette, &raster(|i| [i as u16, 900, 3, 65535])),
            Some("indexed colours")
        );
        let few = raster(|i| [(i % 256) as u16, 900, 3, if i < 256 { 65535 } else { i as u16 }]);
        assert_eq!(lost_colours(StoredColours::Palette, &few), None);
        let unseen = raster(|i| [i as u16, 900, 3, u16::from(i < 256)]);
        assert_eq!(lost_colours(StoredColours::Palette, &unseen), None, "transparent pixels have no colour");
    }
}
