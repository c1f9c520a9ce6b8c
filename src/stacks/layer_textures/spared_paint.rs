//! Paint keeps full agreement, and is of its face throughout, because photos do not overrule a hand.

use super::{FilledFiles, LayerTextureFile, LayerTextureFiles, PaintedStack};
use crate::projected_paint::ProjectedTexel;
use quadratura_io::layer_reader::read_layer;
use quadratura_projection::LayerTextureId;
use quadratura_projection::agreement::Agreement;
use quadratura_view::agreement::AgreementGrid;

impl LayerTextureFiles {
    /// Gives paint full agreement: own paint, erased texels, and paint of other photos.
    pub fn spare_paint(&self, agreement: &mut Agreement) {
        let ids = (0..self.files.len() as u32).map(LayerTextureId);
        ids.for_each(|id| self.spare_paint_on(id, agreement));
    }

    /// Gives the paint on one layer texture full agreement. Files that cannot be read are told when the layer texture is.
    pub fn spare_paint_on(&self, id: LayerTextureId, agreement: &mut Agreement) {
        let Ok(file) = self.file(id) else { return };
        let at = id.0 as usize;
        let grids = [agreement.of_texture.get_mut(at), agreement.outlines.get_mut(at)];
        for grid in grids.into_iter().flatten().flatten() {
            self.spare_paint_in(id, file, grid);
        }
    }

    fn spare_paint_in(&self, id: LayerTextureId, file: &LayerTextureFile, grid: &mut AgreementGrid) {
        let rect = grid.rect().intersection(&file.rect);
        if let Some(Some(PaintedStack { stack, paint })) = self.painted.get(file.photo.index())
            && let Ok(patch) = paint.on(stack, file.layer)
        {
            grid.spare(patch.iter().map(|(x, y, _)| (x, y)));
        }
        if let Some(FilledFiles { propagated: Some(propagated), .. }) = &file.filled
            && let Ok(rgba) = read_layer(propagated, file.rect, rect)
        {
            let painted = rect.pixels().zip(rgba.as_chunks::<4>().0).filter(|(_, texel)| texel[3] > 0);
            grid.spare(painted.map(|(px, _)| px));
        }
        if let Some(projected) = self.projected.get(&id) {
            let texels = projected.rect.pixels().zip(&projected.texels);
            let painted = texels.filter(|(_, texel)| matches!(texel, ProjectedTexel::Paint(..)));
            grid.spare(painted.map(|(px, _)| px));
        }
    }
}
