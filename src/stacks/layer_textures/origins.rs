//! Where the texels of layer textures come from.

use super::{LayerTextureFiles, PaintedStack, dome};
use crate::layer_pixels::shown;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_document::paint::PaintColour;
use quadratura_io::layer_reader::{read_grey, read_layer};
use quadratura_projection::LayerTextureId;
use quadratura_view::legend::Origin;

impl LayerTextureFiles {
    /// Returns the sources of a layer texture's texels in the part `rect` of it (photo pixels), row by row; their
    /// colours are in [`Texels::layer texture`].
    ///
    /// # Errors
    /// Returns the errors of [`Texels::layer texture`].
    pub fn origins(&self, layer_texture: LayerTextureId, rect: PixelRect) -> Result<Vec<Origin>> {
        if let Some(side) = self.side_of_dome(layer_texture) {
            return Ok(self.dome.as_ref().map_or(Vec::new(), |dome| dome::origins(dome, side)));
        }
        let file = self.file(layer_texture)?;
        let mut origins = vec![Origin::Photo; rect.area() as usize];
        if file.needed_rect.is_empty() || rect.is_empty() {
            return Ok(origins);
        }
        if let Some(filled) = &file.filled {
            let texels = read_layer(&file.texels, file.rect, rect)?;
            let confidence = read_grey(&filled.confidence, file.rect, rect)?;
            let numbers = read_grey(&filled.provenance, file.rect, rect)?;
            let filling = texels.as_chunks::<4>().0.iter().zip(confidence).zip(numbers);
            for (origin, ((texel, confidence), number)) in origins.iter_mut().zip(filling) {
                if texel[3] == 0 && confidence > 0 {
                    *origin = filled.origins.get(usize::from(number)).copied().unwrap_or(Origin::OtherPhoto);
                }
            }
            if let Some(propagated) = &filled.propagated {
                let colours = read_layer(propagated, file.rect, rect)?;
                let laid = origins.iter_mut().zip(colours.as_chunks::<4>().0);
                laid.filter(|(_, colour)| colour[3] > 0).for_each(|(origin, _)| *origin = Origin::Propagated);
            }
        }
        if let Some(Some(PaintedStack { stack, paint })) = self.painted.get(file.photo.index()) {
            for (x, y, colour) in paint.on(stack, file.layer)?.iter() {
                if let Some(at) = rect.index(x, y).filter(|_| shown(colour)[3] > 0) {
                    origins[at] = Origin::Paint;
                }
            }
        }
        Ok(origins)
    }

    /// Returns whether all texels come from photos: nobody painted, and nothing is filled.
    pub fn are_only_photos(&self) -> bool {
        let is_painted = |painted: &PaintedStack| !painted.paint.is_empty();
        self.dome.is_none()
            && self.projected.is_empty()
            && self.files.iter().all(|file| file.filled.is_none())
            && !self.painted.iter().flatten().any(is_painted)
    }

    /// Returns where a layer texture has paint, in photo pixels; `None` where it has none.
    ///
    /// # Errors
    /// Returns the errors of reading the files of paint.
    pub fn painted_on(&self, layer_texture: LayerTextureId) -> Result<Option<Image<bool>>> {
        let file = self.file(layer_texture)?;
        let Some(Some(PaintedStack { stack, paint })) = self.painted.get(file.photo.index()) else {
            return Ok(None);
        };
        let patch = paint.on(stack, file.layer)?;
        let is_painted = |colour: &Option<PaintColour>| colour.is_some_and(|colour| shown(colour)[3] > 0);
        Ok((!patch.is_empty()).then(|| {
            let painted = patch.pixels().pixels().iter().map(is_painted).collect();
            Image::new(patch.rect(), painted)
        }))
    }
}
