//! The filling of a layer texture, read from its files.

use super::FilledFiles;
use crate::projected_paint::{ProjectedPaint, ProjectedTexel};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_io::layer_reader::{read_grey, read_layer};

/// The filling of a part of a layer texture, row by row.
pub(super) struct TextureFilling {
    pub confidence: Vec<u16>,
    /// RGBA, opaque where a hidden texel was filled.
    pub colours: Vec<u8>,
    /// RGBA, opaque where paint of another photo covers what the photo shows.
    pub propagated: Option<Vec<u8>>,
    /// The matte in 255ths; `None` where the surfaces are solid.
    pub matte: Option<Vec<u8>>,
    /// RGBA, opaque where the photo shows a see-through surface mixed with what is behind it: the surface's own colour.
    pub foreground: Option<Vec<u8>>,
}

impl TextureFilling {
    /// Reads the part `part` of a layer texture with the rectangle `rect`, both in photo pixels.
    pub fn read(files: &FilledFiles, rect: PixelRect, part: PixelRect) -> Result<Self> {
        let propagated = files.propagated.as_ref().map(|file| read_layer(file, rect, part));
        let matte = files.matte.as_ref().map(|file| read_grey(file, rect, part));
        let foreground = files.foreground.as_ref().map(|file| read_layer(file, rect, part));
        Ok(Self {
            confidence: read_grey(&files.confidence, rect, part)?,
            colours: read_layer(&files.colours, rect, part)?,
            propagated: propagated.transpose()?,
            matte: matte
                .transpose()?
                .map(|matte| matte.into_iter().map(|value| value.min(255) as u8).collect()),
            foreground: foreground.transpose()?,
        })
    }

    /// Makes the filling of a part of which nothing is filled.
    pub fn of_nothing(part: PixelRect) -> Self {
        let texels = part.area() as usize;
        Self {
            confidence: vec![0; texels],
            colours: vec![0; 4 * texels],
            propagated: None,
            matte: None,
            foreground: None,
        }
    }

    /// Returns the same with nothing but the paint of other photos.
    pub fn propagated_alone(mut self) -> Self {
        let nothing = vec![0; self.colours.len()];
        let propagated = self.propagated.as_ref().unwrap_or(&nothing).as_chunks::<4>().0.iter();
        let others = self.confidence.iter_mut().zip(propagated).filter(|(_, colour)| colour[3] == 0);
        others.for_each(|(confidence, _)| *confidence = 0);
        self.colours.fill(0);
        self
    }

    /// Gives texels that the photo shows mixed with what is behind the colour of the surface.
    pub fn lay_foreground(&self, rgba: &mut [u8]) {
        let Some(foreground) = &self.foreground else { return };
        for (texel, colour) in rgba.as_chunks_mut::<4>().0.iter_mut().zip(foreground.as_chunks::<4>().0) {
            if colour[3] > 0 {
                *texel = *colour;
            }
        }
    }

    /// Gives texels that the photo shows, and of which nobody knows how much is the surface, their low confidence.
    pub fn lower_unknown(&self, rgba: &mut [u8]) {
        if self.matte.is_some() {
            let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(&self.confidence);
            let unknown = texels.filter(|(texel, confidence)| texel[3] == u8::MAX && **confidence > 0);
            unknown.for_each(|(texel, confidence)| texel[3] = (*confidence).min(255) as u8);
        }
    }

    /// Returns the same with a matte of 1 where paint of other photos was propagated to.
    pub fn solid_where_propagated(mut self) -> Self {
        if let (Some(matte), Some(propagated)) = (&mut self.matte, &self.propagated) {
            let laid =
                matte.iter_mut().zip(propagated.as_chunks::<4>().0).filter(|(_, colour)| colour[3] > 0);
            laid.for_each(|(matte, _)| *matte = u8::MAX);
        }
        self
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_texels_of_which_nobody_knows_the_matte_are_trusted_less() {
        let mut filling = TextureFilling {
            confidence: vec![0, 25, 25],
            ..TextureFilling::of_nothing(PixelRect::of_size(3, 1))
        };
        let shown = [[9, 9, 9, 255], [9, 9, 9, 255], [0; 4]].concat();
        let mut rgba = shown.clone();
        filling.lower_unknown(&mut rgba);
        assert_eq!(rgba, shown, "of a solid surface the confidence is that of propagated paint");
        filling.matte = Some(vec![255; 3]);
        filling.lower_unknown(&mut rgba);
        assert_eq!(rgba, [[9, 9, 9, 255], [9, 9, 9, 25], [0; 4]].concat());
    }
}
