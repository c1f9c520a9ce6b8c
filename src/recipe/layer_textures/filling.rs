//! The filling of a layer texture, read from its files.

use super::FilledFiles;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_grey, read_layer};
use crate::recipe::fill::projected::{ProjectedPaint, ProjectedTexel};

/// The filling of a part of a layer texture, row by row.
pub(super) struct Filling {
    pub confidence: Vec<u16>,
    /// RGBA, opaque where a hidden texel was filled.
    pub colours: Vec<u8>,
    /// RGBA, opaque where paint of another photo covers what the photo shows.
    pub propagated: Option<Vec<u8>>,
}

impl Filling {
    /// Reads the part `part` of a layer texture with the rectangle `rect`, both in photo pixels.
    pub fn read(files: &FilledFiles, rect: PixelRect, part: PixelRect) -> Result<Self> {
        let propagated = files.propagated.as_ref().map(|file| read_layer(file, rect, part));
        Ok(Self {
            confidence: read_grey(&files.confidence, rect, part)?,
            colours: read_layer(&files.colours, rect, part)?,
            propagated: propagated.transpose()?,
        })
    }

    /// Makes the filling of a part of which nothing is filled.
    pub fn of_nothing(part: PixelRect) -> Self {
        let texels = part.area() as usize;
        Self { confidence: vec![0; texels], colours: vec![0; 4 * texels], propagated: None }
    }

    /// Takes over paint that the files do not contain yet. `visible` are the texels that the photo shows, opaque.
    /// Hidden texels that are not filled stay empty: they may lie before what another layer shows.
    pub fn take(&mut self, projected: &ProjectedPaint, part: PixelRect, visible: &[u8]) {
        let bare = || vec![0; 4 * part.area() as usize];
        for ((x, y), texel) in projected.rect.pixels().zip(&projected.texels) {
            let Some(at) = part.index(x, y) else { continue };
            let (place, is_visible) = (4 * at..4 * at + 4, visible[4 * at + 3] != 0);
            match *texel {
                ProjectedTexel::AsFiled => (),
                ProjectedTexel::Bare => {
                    self.propagated.iter_mut().for_each(|propagated| propagated[place.clone()].fill(0));
                }
                ProjectedTexel::Paint([r, g, b], confidence) if is_visible => {
                    let propagated = self.propagated.get_or_insert_with(bare);
                    propagated[place].copy_from_slice(&[r, g, b, u8::MAX]);
                    self.confidence[at] = confidence.into();
                }
                ProjectedTexel::Paint([r, g, b], confidence) => {
                    if self.confidence[at] > 0 {
                        self.colours[place].copy_from_slice(&[r, g, b, u8::MAX]);
                        self.confidence[at] = confidence.into();
                    }
                }
            }
        }
    }
}
