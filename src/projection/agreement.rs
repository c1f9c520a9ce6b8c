//! The agreement of the image layers of a site: that of the photos ([`quadratura_view::agreement`]), divided among the layers that
//! show their pixels.

use std::collections::BTreeMap;

use glam::DVec2;

use super::{LayerTextureId, Server, Sources};
use quadratura_base::scene::PhotoId;
use quadratura_view::agreement::{AgreementGrid, ContradictedPixel, NO_FACE, PhotoAgreement};

/// The agreement of the image layers of a site.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Agreement {
    /// The agreement of each image layer, in the order of [`Sources::layer_textures`]; 1 throughout for `None` and
    /// beyond the list.
    pub of_texture: Vec<Option<AgreementGrid>>,
    /// How much of each texel shows its face rather than the sky within the outlines of the model, likewise.
    pub outlines: Vec<Option<AgreementGrid>>,
}

impl Agreement {
    /// Divides the agreement of photos (in the site's order) among the image layers that show their pixels. A pixel
    /// whose face is pinned to its photo is not contradicted, because photos do not overrule a decision.
    pub fn new(photos: &[&PhotoAgreement], sources: &Sources) -> Self {
        Self { of_texture: divided(photos, sources), outlines: vec![None; sources.layer_textures.len()] }
    }

    /// Returns the same with the outlines of photos, which are divided likewise; those of pixels without a face among their
    /// surroundings.
    pub fn with_outlines(self, photos: &[&PhotoAgreement], sources: &Sources) -> Self {
        let mut outlines = divided(photos, sources);
        let around = |photo: &ContradictedPixel| photo.face == NO_FACE;
        divide_surroundings(&mut outlines, photos.iter().copied(), around, sources);
        Self { outlines, ..self }
    }

    /// Returns the same with that of the photos' surroundings, whose pixels show no face.
    pub fn with_surroundings(mut self, photos: &[PhotoAgreement], sources: &Sources) -> Self {
        divide_surroundings(&mut self.of_texture, photos.iter(), |_| true, sources);
        self
    }

    /// Returns the grid of an image layer; `None` where nothing of it is contradicted.
    pub fn of(&self, layer_texture: LayerTextureId) -> Option<&AgreementGrid> {
        self.of_texture.get(layer_texture.0 as usize)?.as_ref()
    }

    /// Returns how much of an image layer's texel at a position in the photo shows its face, 0 to 1.
    pub fn outline_at(&self, layer_texture: LayerTextureId, px: DVec2) -> f64 {
        self.outline_of(layer_texture).map_or(1.0, |grid| grid.at(px))
    }

    /// Returns the outlines of an image layer; `None` where it shows no sky within them.
    pub fn outline_of(&self, layer_texture: LayerTextureId) -> Option<&AgreementGrid> {
        self.outlines.get(layer_texture.0 as usize)?.as_ref()
    }

    /// Returns true when some texel shows the sky within the outlines of the model.
    pub fn has_outlines(&self) -> bool {
        self.outlines.iter().any(Option::is_some)
    }

    /// Returns the agreement of an image layer's texel at a position in the photo, 0 to 1.
    pub fn at(&self, layer_texture: LayerTextureId, px: DVec2) -> f64 {
        self.of(layer_texture).map_or(1.0, |grid| grid.at(px))
    }

    /// Returns a lower bound of the agreement within `low_px..high_px` (photo pixels).
    pub fn least(&self, layer_texture: LayerTextureId, low_px: DVec2, high_px: DVec2) -> f64 {
        self.of(layer_texture).map_or(1.0, |grid| grid.least(low_px, high_px))
    }

    /// Returns the same with half as many cells per pixel along both axes.
    pub fn halved(&self) -> Self {
        let halved = |grids: &[Option<AgreementGrid>]| {
            grids.iter().map(|grid| grid.as_ref().map(AgreementGrid::halved)).collect()
        };
        Self { of_texture: halved(&self.of_texture), outlines: halved(&self.outlines) }
    }

    /// Returns true when nothing is contradicted.
    pub fn is_full(&self) -> bool {
        self.of_texture.iter().all(Option::is_none)
    }
}

/// Divides values of photos' pixels (in the site's order) among the image layers that show them, but for those of faces that are pinned
/// to the photo.
fn divided(photos: &[&PhotoAgreement], sources: &Sources) -> Vec<Option<AgreementGrid>> {
    let mut cells: BTreeMap<LayerTextureId, BTreeMap<(u16, u16), u8>> = BTreeMap::new();
    for (id, agreement) in PhotoId::all(photos.len()).zip(photos) {
        let scale = cells_per_px(agreement, sources, id);
        // What a layer shows comes after what is beside it, and replaces it.
        for pixel in agreement.beside.iter().chain(&agreement.contradicted) {
            let px = (DVec2::new(pixel.at[0].into(), pixel.at[1].into()) + 0.5) / scale;
            let shows = |server: &&Server| server.photo == id && !server.pinned && server.domain.holds(px);
            let servers = if pixel.face == NO_FACE { &[] } else { sources.servers_of(pixel.face) };
            for server in servers.iter().filter(shows) {
                let [x, y] = pixel.at;
                cells.entry(server.layer_texture).or_default().insert((y, x), pixel.agreement);
            }
        }
    }
    let mut of_texture = vec![None; sources.layer_textures.len()];
    for (layer_texture, cells) in cells {
        let photo = sources.layer_texture(layer_texture).photo;
        let scale = cells_per_px(photos[photo.index()], sources, photo);
        of_texture[layer_texture.0 as usize] = AgreementGrid::new(scale, &cells);
    }
    of_texture
}

/// Writes the values of these pixels of photos (in the site's order) into the grids of their surroundings.
fn divide_surroundings<'a>(
    grids: &mut [Option<AgreementGrid>],
    photos: impl Iterator<Item = &'a PhotoAgreement>,
    is_around: impl Fn(&ContradictedPixel) -> bool,
    sources: &Sources,
) {
    let photos: Vec<&PhotoAgreement> = photos.collect();
    let servers = sources.servers_of_surroundings().iter();
    for server in servers.filter(|server| !sources.is_dome(server.photo)) {
        let Some(photo) = photos.get(server.photo.index()) else { continue };
        let cell = |pixel: &ContradictedPixel| ((pixel.at[1], pixel.at[0]), pixel.agreement);
        let cells: BTreeMap<(u16, u16), u8> =
            photo.contradicted.iter().filter(|pixel| is_around(pixel)).map(cell).collect();
        grids[server.layer_texture.0 as usize] =
            AgreementGrid::new(cells_per_px(photo, sources, server.photo), &cells);
    }
}

/// Returns the number of cells per pixel of a photo, along x and y.
fn cells_per_px(agreement: &PhotoAgreement, sources: &Sources, photo: PhotoId) -> DVec2 {
    let camera = &sources.photo(photo).camera;
    let [columns, rows] = agreement.size.map(f64::from);
    DVec2::new(columns / f64::from(camera.width), rows / f64::from(camera.height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, LayerTexture, Projector};
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::FaceId;
    use quadratura_base::scene::synthetic::{camera_is_world, centred};

    #[test]
    fn a_pinned_photo_is_not_contradicted_on_its_face() {
        let server = |photo: usize, pinned: bool| Server {
            layer_texture: LayerTextureId(photo as u32),
            photo: PhotoId::new(photo),
            back: false,
            pinned,
            domain: Domain::Whole,
        };
        let camera = centred(20, 10, 10.0);
        let projector = Projector { name: "a".into(), camera, pose: camera_is_world() };
        let rect = PixelRect::of_size(16, 8);
        let layer_texture =
            |photo| LayerTexture { photo: PhotoId::new(photo), id: "a".into(), rect, see_through: false };
        let sources = Sources {
            photos: vec![projector; 2],
            layer_textures: (0..2).map(layer_texture).collect(),
            servers: vec![server(0, false), server(1, true)],
            of_face: std::iter::once(0..2).collect(),
            ..Sources::default()
        };
        let pixel = ContradictedPixel { at: [4, 2], face: FaceId(0), agreement: 51 };
        let photo = PhotoAgreement { size: [10, 5], contradicted: vec![pixel], beside: Vec::new() };
        let agreement = Agreement::new(&[&photo, &photo], &sources);
        assert!((agreement.at(LayerTextureId(0), DVec2::new(9.0, 5.0)) - 0.2).abs() < 1e-9);
        assert!(agreement.of(LayerTextureId(1)).is_none(), "photos do not overrule a decision");
    }
}
