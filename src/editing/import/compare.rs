//! Comparison of layers with what was exported: the pixels that differ are paint.

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_document::paint::{ERASED, PaintColour, PaintPatch};
use quadratura_io::colour::Conversion;
use quadratura_layered_files::{Depth, Raster, Rounding};

/// The largest difference, of 65535, that conversion to another profile and back may cause: three steps of 8 bits.
/// Editors round, and their tables differ from ours.
const CONVERTED: u16 = 3 * 257;

/// A raster with its position in the photo.
#[derive(Debug, Clone, Copy)]
pub struct PlacedRaster<'a> {
    /// The rectangle in photo pixels.
    pub rect: PixelRect,
    /// The pixels, as large as `rect`.
    pub pixels: &'a Raster,
}

impl PlacedRaster<'_> {
    /// Returns the colour at a pixel of the photo; transparent outside.
    pub fn at(&self, x: i32, y: i32) -> PaintColour {
        let (dx, dy) = (x - self.rect.x, y - self.rect.y);
        if self.rect.contains(x, y) { self.pixels.rgba16(dx as u32, dy as u32) } else { [0; 4] }
    }
}

/// The conversions between the photo's profile and the document's.
pub struct Profiles {
    /// The conversion from the photo's profile to the document's.
    pub there: Conversion,
    /// The conversion from the document's profile to the photo's.
    pub back: Conversion,
}

/// A layer as it was exported, and as it is in the edited document.
pub struct Comparison<'a> {
    /// The layer as it was exported.
    pub base: PlacedRaster<'a>,
    /// The layer in the edited document.
    pub found: PlacedRaster<'a>,
    /// The document's canvas, in photo pixels. Pixels outside of it that are not in the layer are unknown.
    pub canvas: PixelRect,
    /// The profiles; `None` where the document has the photo's profile.
    pub profiles: Option<&'a Profiles>,
    /// How coarsely the document stores colours.
    pub rounding: Option<Rounding>,
}

impl Comparison<'_> {
    /// Returns all pixels that differ from what was exported.
    ///
    /// Transparent pixels are equal, whatever their colour. Between 16 and 8 bits, a rounded or truncated value is
    /// equal; in another profile, values within the error of the conversions are.
    pub fn painted(&self) -> PaintPatch {
        let rect = self.base.rect.hull(&self.found.rect);
        let mut painted = Vec::new();
        for y in rect.y..rect.bottom() {
            self.paint_of_row(y, rect.x..rect.right(), &mut painted);
        }
        PaintPatch::of_pixels(&painted)
    }

    /// Appends the pixels of a row that differ.
    fn paint_of_row(
        &self,
        y: i32,
        columns: std::ops::Range<i32>,
        painted: &mut Vec<(i32, i32, PaintColour)>,
    ) {
        let row: Vec<(i32, PaintColour, PaintColour)> = columns
            .filter(|&x| self.found.rect.contains(x, y) || self.canvas.contains(x, y))
            .map(|x| (x, self.base.at(x, y), self.found.at(x, y)))
            .filter(|(_, base, found)| base != found && (base[3] != 0 || found[3] != 0))
            .collect();
        let is_rounded =
            |base: PaintColour, found| self.rounding.is_some_and(|rounding| rounding.is_same(base, found));
        let Some(profiles) = self.profiles else {
            let depths = (self.base.pixels.depth(), self.found.pixels.depth());
            let other = row
                .into_iter()
                .filter(|(_, base, found)| !alike(*base, *found, depths) && !is_rounded(*base, *found));
            painted.extend(other.map(|(x, _, found)| (x, y, kept(found))));
            return;
        };
        let there = profiles.there.converted(&row.iter().map(|(_, base, _)| *base).collect::<Vec<_>>());
        let back = profiles.back.converted(&row.iter().map(|(_, _, found)| *found).collect::<Vec<_>>());
        let all = row.iter().zip(there).zip(back);
        let other =
            all.filter(|(((_, _, found), there), _)| !near(*there, *found) && !is_rounded(*there, *found));
        painted.extend(other.map(|(((x, _, _), _), back)| (*x, y, kept(back))));
    }
}

/// Returns true when two colours differ by no more than a conversion to another profile may cause.
fn near(a: PaintColour, b: PaintColour) -> bool {
    let alpha_is_alike = in_8_bits(a[3]) == in_8_bits(b[3]);
    alpha_is_alike && (0..3).all(|i| a[i].abs_diff(b[i]) <= CONVERTED)
}

impl Profiles {
    /// Returns true when the document's profile was assigned and its pixels were not converted to it: of these colours,
    /// as exported and as found, more are the same than are as converted.
    pub fn are_assigned(&self, colours: &[(PaintColour, PaintColour)]) -> bool {
        let there = self.there.converted(&colours.iter().map(|(base, _)| *base).collect::<Vec<_>>());
        let same = colours.iter().filter(|(base, found)| base.map(in_8_bits) == found.map(in_8_bits)).count();
        let converted = colours.iter().zip(there).filter(|((_, found), there)| near(*there, *found)).count();
        same > converted
    }
}

/// Returns the colour as it is stored: erased pixels have a defined value.
fn kept(colour: PaintColour) -> PaintColour {
    if colour[3] == 0 { ERASED } else { colour }
}

/// Returns true when two colours are equal except for the bit depth.
fn alike(base: PaintColour, found: PaintColour, depths: (Depth, Depth)) -> bool {
    match depths {
        (Depth::Eight, Depth::Sixteen) => base.map(in_8_bits) == found.map(in_8_bits),
        // An 8-bit editor has rounded, or truncated the lower half.
        (Depth::Sixteen, Depth::Eight) => {
            let found = found.map(in_8_bits);
            base.map(in_8_bits) == found || base.map(|sample| (sample >> 8) as u8) == found
        }
        _ => base == found,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;
    use quadratura_io::colour::adobe_rgb;

    const CANVAS: PixelRect = PixelRect::of_size(100, 100);

    fn eight(width: u32, samples: &[[u8; 4]]) -> Raster {
        Raster::new(width, samples.len() as u32 / width, Samples::U8(samples.as_flattened().to_vec()))
    }

    fn painted(base: &Raster, base_x: i32, found: &Raster, found_x: i32) -> Vec<(i32, i32, PaintColour)> {
        let placed = |pixels, x| PlacedRaster {
            rect: PixelRect { x, y: 0, w: Raster::width(pixels), h: Raster::height(pixels) },
            pixels,
        };
        let comparison = Comparison {
            base: placed(base, base_x),
            found: placed(found, found_x),
            canvas: CANVAS,
            profiles: None,
            rounding: None,
        };
        comparison.painted().iter().collect()
    }

    #[test]
    fn a_pixel_is_paint_if_it_is_not_as_it_was() {
        let base = eight(3, &[[1, 2, 3, 255], [4, 5, 6, 255], [9, 9, 9, 0]]);
        let found = eight(3, &[[1, 2, 3, 255], [4, 5, 7, 255], [50, 60, 70, 0]]);
        assert_eq!(painted(&base, 5, &found, 5), [(6, 0, [4 * 257, 5 * 257, 7 * 257, 65535])]);
    }

    #[test]
    fn a_layer_cropped_to_what_is_not_transparent_is_untouched_and_beyond_that_it_is_erased() {
        let base = eight(4, &[[0; 4], [1, 1, 1, 255], [2, 2, 2, 255], [0; 4]]);
        let cropped = eight(2, &[[1, 1, 1, 255], [2, 2, 2, 255]]);
        assert_eq!(painted(&base, 0, &cropped, 1), []);
        let erased = eight(1, &[[1, 1, 1, 255]]);
        assert_eq!(painted(&base, 0, &erased, 1), [(2, 0, ERASED)]);
    }

    #[test]
    fn paint_beside_the_layer_is_paint() {
        let base = eight(1, &[[1, 1, 1, 255]]);
        let grown = eight(3, &[[7, 7, 7, 10], [1, 1, 1, 255], [0; 4]]);
        assert_eq!(painted(&base, 4, &grown, 3), [(3, 0, [7 * 257, 7 * 257, 7 * 257, 10 * 257])]);
    }

    #[test]
    fn what_a_smaller_canvas_no_longer_shows_is_not_erased() {
        let base = eight(2, &[[1, 1, 1, 255], [2, 2, 2, 255]]);
        let found = eight(1, &[[1, 1, 1, 255]]);
        assert_eq!(painted(&base, 98, &found, 98), [(99, 0, ERASED)]);
        assert_eq!(painted(&base, 99, &found, 99), [], "the second pixel is outside");
    }

    #[test]
    fn another_depth_is_no_paint() {
        let all: Vec<[u8; 4]> = (0..=255).map(|v| [v, 255 - v, v / 2, 255]).collect();
        let base = eight(256, &all);
        let deeper = base.clone().in_depth(Depth::Sixteen);
        assert_eq!(painted(&base, -256, &deeper, -256), []);
        let Samples::U16(samples) = deeper.samples() else { panic!("16 bits") };
        let uneven = samples.iter().enumerate().map(|(i, s)| s.saturating_add((i % 128) as u16)).collect();
        let sixteen = Raster::new(256, 1, Samples::U16(uneven));
        assert_eq!(painted(&base, 0, &sixteen, 0), [], "as editors round them");
        assert_eq!(painted(&sixteen, 0, &base, 0), []);
        let cut = Samples::U8(match sixteen.samples() {
            Samples::U16(s) => s.iter().map(|s| (s >> 8) as u8).collect(),
            Samples::U8(_) => unreachable!("made of 16 bits"),
        });
        assert_eq!(painted(&sixteen, 0, &Raster::new(256, 1, cut), 0), []);
    }

    #[test]
    fn through_another_profile_only_what_was_painted_is_paint() {
        let adobe = adobe_rgb();
        let profiles = Profiles {
            there: Conversion::between(None, Some(&adobe)).unwrap().unwrap(),
            back: Conversion::between(Some(&adobe), None).unwrap().unwrap(),
        };
        let colours: Vec<[u8; 4]> =
            (0..200u32).map(|i| [(i * 7) as u8, (i * 13) as u8, (i * 29) as u8, 255]).collect();
        let base = eight(200, &colours);
        let wide: Vec<PaintColour> = (0..200).map(|x| base.rgba16(x, 0)).collect();
        let mut found = Raster::blank(200, 1, Depth::Eight);
        let there = profiles.there.converted(&wide);
        (0..200).for_each(|x| found.set_rgba16(x as u32, 0, there[x]));
        found.set_rgba16(17, 0, [65535, 0, 0, 65535]);
        let rect = PixelRect::of_size(200, 1);
        let comparison = Comparison {
            base: PlacedRaster { rect, pixels: &base },
            found: PlacedRaster { rect, pixels: &found },
            canvas: PixelRect { w: 200, ..CANVAS },
            profiles: Some(&profiles),
            rounding: None,
        };
        let pairs = |edit: &dyn Fn(usize) -> PaintColour| -> Vec<(PaintColour, PaintColour)> {
            wide.iter().enumerate().map(|(x, base)| (*base, edit(x))).collect()
        };
        assert!(!profiles.are_assigned(&pairs(&|x| found.rgba16(x as u32, 0))));
        assert!(profiles.are_assigned(&pairs(&|x| if x < 60 { [0, 0, 0, 65535] } else { wide[x] })));
        let painted: Vec<_> = comparison.painted().iter().collect();
        assert_eq!(painted.len(), 1);
        assert!(painted[0].0 == 17 && painted[0].2[1] < 257, "{painted:?}");
    }
}
