//! Mirrored and turned images: the seven ways in which an editor can do that to a whole image without resampling it,
//! and how each is undone.

use std::sync::Arc;

use super::edited::{EditedDocument, EditedLayer, EditedMask};
use super::grey::Grey;
use super::raster::Raster;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;

/// What undoes the turn of an image: mirror in x, mirror in y, then exchange of x and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ImageTurn {
    mirror_x: bool,
    mirror_y: bool,
    exchange: bool,
    /// What was done to the image, in words that follow "was".
    pub done: &'static str,
}

/// All turns, the common ones first.
pub const TURNS: [ImageTurn; 7] = [
    ImageTurn { mirror_x: true, mirror_y: false, exchange: false, done: "mirrored horizontally" },
    ImageTurn { mirror_x: false, mirror_y: true, exchange: false, done: "mirrored vertically" },
    ImageTurn { mirror_x: true, mirror_y: true, exchange: false, done: "turned by 180 degrees" },
    ImageTurn { mirror_x: true, mirror_y: false, exchange: true, done: "turned by 90 degrees clockwise" },
    ImageTurn {
        mirror_x: false,
        mirror_y: true,
        exchange: true,
        done: "turned by 90 degrees counter-clockwise",
    },
    ImageTurn {
        mirror_x: false,
        mirror_y: false,
        exchange: true,
        done: "turned by 90 degrees clockwise and mirrored horizontally",
    },
    ImageTurn {
        mirror_x: true,
        mirror_y: true,
        exchange: true,
        done: "turned by 90 degrees clockwise and mirrored vertically",
    },
];

impl ImageTurn {
    /// Returns the size of an image of this size once it is turned back.
    pub fn size(self, (width, height): (u32, u32)) -> (u32, u32) {
        if self.exchange { (height, width) } else { (width, height) }
    }

    /// Returns a rectangle of a canvas of this size on the canvas turned back.
    pub fn rect(self, rect: PixelRect, (width, height): (u32, u32)) -> PixelRect {
        let x = if self.mirror_x { width as i32 - rect.right() } else { rect.x };
        let y = if self.mirror_y { height as i32 - rect.bottom() } else { rect.y };
        match self.exchange {
            true => PixelRect { x: y, y: x, w: rect.h, h: rect.w },
            false => PixelRect { x, y, w: rect.w, h: rect.h },
        }
    }

    /// Turns pixels back.
    pub fn raster(self, raster: &Raster) -> Raster {
        const RGBA: usize = 4;
        let size = (raster.width(), raster.height());
        let (width, height) = self.size(size);
        Raster::new(width, height, self.samples(raster.samples(), size, RGBA))
    }

    fn grey(self, grey: &Grey) -> Grey {
        let size = (grey.width(), grey.height());
        let (width, height) = self.size(size);
        Grey::new(width, height, self.samples(grey.samples(), size, 1))
    }

    fn samples(self, samples: &Samples, size: (u32, u32), per_pixel: usize) -> Samples {
        match samples {
            Samples::U8(samples) => Samples::U8(self.turned(samples, size, per_pixel)),
            Samples::U16(samples) => Samples::U16(self.turned(samples, size, per_pixel)),
        }
    }

    fn turned<T: Copy>(self, samples: &[T], (width, height): (u32, u32), per_pixel: usize) -> Vec<T> {
        let (w, h) = (width as usize, height as usize);
        let mut out = Vec::with_capacity(samples.len());
        let (columns, rows) = if self.exchange { (h, w) } else { (w, h) };
        for row in 0..rows {
            for column in 0..columns {
                let (x, y) = if self.exchange { (row, column) } else { (column, row) };
                let x = if self.mirror_x { w - 1 - x } else { x };
                let y = if self.mirror_y { h - 1 - y } else { y };
                let at = per_pixel * (y * w + x);
                out.extend_from_slice(&samples[at..at + per_pixel]);
            }
        }
        out
    }

    /// Returns a document turned back. Pixels are still read on request.
    pub fn document(self, document: EditedDocument) -> EditedDocument {
        let canvas = (document.width, document.height);
        let (width, height) = self.size(canvas);
        let layers = document.layers.into_iter().map(|layer| self.layer(layer, canvas)).collect();
        EditedDocument { width, height, layers, ..document }
    }

    fn layer(self, layer: EditedLayer, canvas: (u32, u32)) -> EditedLayer {
        // Masks of groups become one for each layer in them; all are read on request.
        let masks = layer.masks.iter().map(|mask| Arc::new(self.mask(mask, canvas))).collect();
        let rect = self.rect(layer.rect, canvas);
        let pixels = layer.pixels.changed(self.done, move |raster| self.raster(&raster));
        EditedLayer { rect, masks, pixels, ..layer }
    }

    fn mask(self, mask: &Arc<EditedMask>, canvas: (u32, u32)) -> EditedMask {
        EditedMask {
            rect: self.rect(mask.rect, canvas),
            outside: mask.outside,
            enabled: mask.enabled,
            lowest_with: mask.lowest_with.as_ref().map(|other| Arc::new(self.mask(other, canvas))),
            pixels: EditedMask::shared_pixels(mask).changed(self.done, move |grey| self.grey(&grey)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Depth, Lazy};
    use quadratura_document::export_record::ExportFormat;

    /// Pixels of 3 x 2 with the values 1 to 6 in reading order.
    fn numbered() -> Raster {
        Raster::new(3, 2, Samples::U8((1..=6).flat_map(|value| [value, 0, 0, 255]).collect()))
    }

    fn values(raster: &Raster) -> (u32, Vec<u16>) {
        let places = PixelRect::of_size(raster.width(), raster.height()).pixels();
        (raster.width(), places.map(|(x, y)| raster.rgba16(x as u32, y as u32)[0] / 257).collect())
    }

    #[test]
    fn each_turn_is_undone() {
        // What an editor makes of 1 2 3 / 4 5 6, by the words for it.
        let turned: [(u32, [u8; 6]); 7] = [
            (3, [3, 2, 1, 6, 5, 4]),
            (3, [4, 5, 6, 1, 2, 3]),
            (3, [6, 5, 4, 3, 2, 1]),
            (2, [4, 1, 5, 2, 6, 3]),
            (2, [3, 6, 2, 5, 1, 4]),
            (2, [1, 4, 2, 5, 3, 6]),
            (2, [6, 3, 5, 2, 4, 1]),
        ];
        for (turn, (width, found)) in TURNS.into_iter().zip(turned) {
            let samples = found.into_iter().flat_map(|value| [value, 0, 0, 255]).collect();
            let found = Raster::new(width, 6 / width, Samples::U8(samples));
            assert_eq!(values(&turn.raster(&found)), values(&numbered()), "{}", turn.done);
        }
    }

    #[test]
    fn a_layer_lies_where_its_pixels_are() {
        // On a canvas of 10 x 8, a layer of one marked pixel in each of many places.
        for turn in TURNS {
            for (x, y) in [(0, 0), (9, 7), (3, 5), (-2, 4)] {
                let rect = PixelRect { x, y, w: 2, h: 1 };
                let marked = |raster: &Raster, at: PixelRect| {
                    let places = PixelRect::of_size(raster.width(), raster.height()).pixels();
                    let mut marks = places.filter(|(x, y)| raster.rgba16(*x as u32, *y as u32)[3] > 0);
                    marks.next().map(|(dx, dy)| (at.x + dx, at.y + dy))
                };
                let mut pixels = Raster::blank(2, 1, Depth::Eight);
                pixels.set_rgba16(1, 0, [65535; 4]);
                let (found, at) = (turn.raster(&pixels), turn.rect(rect, (10, 8)));
                assert_eq!((at.w, at.h), (found.width(), found.height()));
                // The same as turning the canvas's pixel (x + 1, y).
                let one = turn.rect(PixelRect::of_pixel(x + 1, y), (10, 8));
                assert_eq!(marked(&found, at), Some((one.x, one.y)), "{}", turn.done);
            }
        }
    }

    #[test]
    fn a_document_is_turned_back_with_its_layers_and_masks() {
        let grey = Lazy::new(|| Ok(Grey::new(3, 2, Samples::U8(vec![1, 2, 3, 4, 5, 6]))));
        let rect = PixelRect { x: 1, y: 0, w: 3, h: 2 };
        let mask = EditedMask { rect, outside: 0.5, enabled: true, lowest_with: None, pixels: grey };
        let layer = EditedLayer {
            masks: vec![Arc::new(mask)],
            ..EditedLayer::plain("a", rect, Lazy::new(|| Ok(numbered())))
        };
        let document = EditedDocument {
            format: ExportFormat::Psd,
            width: 10,
            height: 4,
            depth: Depth::Eight,
            rounding: None,
            icc: None,
            key: None,
            layers: vec![layer],
            notes: vec![],
        };
        let document = TURNS[3].document(document);
        let layer = &document.layers[0];
        assert_eq!((document.width, document.height), (4, 10));
        assert_eq!(layer.rect, PixelRect { x: 0, y: 6, w: 2, h: 3 });
        assert_eq!(layer.masks[0].rect, layer.rect);
        assert_eq!(values(&layer.pixels.read().unwrap()), (2, vec![3, 6, 2, 5, 1, 4]));
        assert_eq!(layer.masks[0].pixels.read().unwrap().samples(), &Samples::U8(vec![3, 6, 2, 5, 1, 4]));
        assert_eq!(layer.masks[0].pixels.code().unwrap(), None, "as before");
    }
}
