//! The photos' cameras, their image layers (here flat textures called *layer textures*), and the table of which layer
//! texture may texture which side of which face. The table is made once from the stacks; it replaces depth tests
//! against photos.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::DVec2;

use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_view::Shot;
use quadratura_view::hidden::HiddenFaces;

/// The index of an image layer in [`Sources::layer_textures`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LayerTextureId(pub u32);

/// A photo as a projector: its name, camera and pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Projector {
    /// The unique name of the photo.
    pub name: String,
    /// Image size and intrinsics in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
}

/// An image layer as a texture.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerTexture {
    /// The photo that the layer belongs to.
    pub photo: PhotoId,
    /// The token that identifies the layer in the stack.
    pub id: String,
    /// The layer's rectangle in photo pixels, moved so that its content takes few tiles
    /// ([`super::tiles::in_few_tiles`]). It may reach outside the photo; its sides are powers of two.
    pub rect: PixelRect,
    /// True when its texels have a matte: one sees through them in places.
    pub see_through: bool,
}

/// A layer texture that may texture one side of one face.
#[derive(Debug, Clone, PartialEq)]
pub struct Server {
    /// The layer texture.
    pub layer_texture: LayerTextureId,
    /// The photo of the layer texture.
    pub photo: PhotoId,
    /// True when the photo sees the face from behind, and textures that side of it.
    pub back: bool,
    /// True when the face is pinned to this photo: the photo takes precedence to the extent of its confidence
    /// at each point ([`quadratura_view::weights::shares`]).
    pub pinned: bool,
    /// The part of the face that the layer texture textures.
    pub domain: Domain,
}

/// The part of a face that a layer texture textures.
#[derive(Debug, Clone, PartialEq)]
pub enum Domain {
    /// The whole face, because it lies in one layer texture of this photo.
    Whole,
    /// A convex polygon in photo pixels: a piece of a cut face, one triangle of a face that is not planar, or
    /// the share of one of several layer textures. The inside is where every `normal . p >= offset`.
    Inside(Vec<HalfPlane>),
}

impl Domain {
    /// Returns true when the domain is the whole face.
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Whole)
    }

    /// Returns true when one side of the domain has all of a box, in photo pixels, beyond it: then no point of the box is within the
    /// domain.
    pub fn is_apart(&self, low: DVec2, high: DVec2) -> bool {
        let farthest = |normal: DVec2| DVec2::select(normal.cmpgt(DVec2::ZERO), high, low).dot(normal);
        match self {
            Self::Whole => false,
            Self::Inside(sides) => sides.iter().any(|side| farthest(side.normal) < side.offset),
        }
    }

    /// Returns true when a point, in photo pixels, is within the domain.
    pub fn holds(&self, point_px: DVec2) -> bool {
        match self {
            Self::Whole => true,
            Self::Inside(sides) => sides.iter().all(|s| s.normal.dot(point_px) >= s.offset),
        }
    }
}

/// The half plane `normal . p >= offset`, with p in photo pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// The unit normal, which points inwards.
    pub normal: DVec2,
    /// The offset along the normal, in pixels.
    pub offset: f64,
}

/// The photos, their layer textures, and the layer textures that may texture each face, with faces by the model's ids.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sources {
    /// The photos, in the site's order.
    pub photos: Vec<Projector>,
    /// The sides of the dome, whose ids follow those of the photos; none or six ([`super::dome`]).
    pub dome: Vec<Projector>,
    /// The layer textures, by photo, then nearest first; last those of the dome.
    pub layer_textures: Vec<LayerTexture>,
    /// The servers, by face, then photo; last those of the surroundings, by photo, the dome after all photos.
    pub servers: Vec<Server>,
    /// The range of each face in `servers`.
    pub of_face: Vec<Range<u32>>,
    /// The range of the surroundings in `servers`: what is seen where no face is.
    pub surroundings: Range<u32>,
    /// The distance between cameras, in world units, from which they see other surroundings: the larger of the cameras'
    /// largest distance from their mean and a tenth of the median depth of what they show.
    pub surroundings_scale: f64,
    /// The faces of backdrops that are so far away that views show surroundings in their place: their layer textures serve these.
    pub far: HiddenFaces,
    /// Whether views show the dome alone where no face is, whatever photos show there.
    pub dome_alone: bool,
}

impl Sources {
    /// Returns a view that shows the surroundings in the place of far backdrops.
    pub fn beyond_backdrops(&self, shot: &Shot) -> Shot {
        let hidden = shot.hidden.iter().chain(self.far.iter()).collect();
        Shot { hidden, ..shot.clone() }
    }

    /// Returns the servers of a face.
    pub fn servers_of(&self, face: FaceId) -> &[Server] {
        let range = &self.of_face[face.0 as usize];
        &self.servers[range.start as usize..range.end as usize]
    }

    /// Returns the faces through which one sees in places: the see-through ones that some layer texture with a matte textures.
    /// They are drawn after all others, blended over what is behind them.
    pub fn see_through_faces(&self, model: &Model) -> BTreeSet<FaceId> {
        let has_matte = |server: &Server| self.layer_texture(server.layer_texture).see_through;
        let surfaces = model.see_through_surfaces();
        surfaces.filter(|face| self.servers_of(*face).iter().any(has_matte)).collect()
    }

    /// Returns whether views show the surroundings of a photo, or of a side of the dome.
    pub fn shows_around(&self, id: PhotoId) -> bool {
        !self.dome_alone || self.is_dome(id)
    }

    /// Returns the servers of the surroundings.
    pub fn servers_of_surroundings(&self) -> &[Server] {
        &self.servers[self.surroundings.start as usize..self.surroundings.end as usize]
    }

    /// Returns the photo with this id, or the side of the dome.
    pub fn photo(&self, id: PhotoId) -> &Projector {
        self.photos.get(id.index()).unwrap_or_else(|| &self.dome[id.index() - self.photos.len()])
    }

    /// Returns the layer texture with this id.
    pub fn layer_texture(&self, id: LayerTextureId) -> &LayerTexture {
        &self.layer_textures[id.0 as usize]
    }
}

/// The least matte: of less nobody can tell whether anything of the surface is there, and as near to 1 whether anything is
/// missing. Mattes that are found are 0 and 1 there.
pub const LEAST_MATTE: f32 = 1.0 / 32.0;

/// The flag of a texel that some element of the layer covers.
pub const COVERED: u8 = 1;

/// The flag of a bleed texel: it is outside the content, but its colour is the photo's own there, which is of
/// another surface. Next to an outline such colours extend the content better than a guess, because they are
/// mixtures of both surfaces.
pub const BLEED: u8 = 2;

/// The flag of a texel that was filled; its alpha is its confidence. The confidence of the photo's own texels
/// falls off towards filled texels as towards empty ones.
pub const FILLED: u8 = 4;

/// The decoded texels of a layer texture, as stored in its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LayerTexturePixels {
    /// The part of the layer texture's rectangle that is not empty, in photo pixels.
    pub rect: PixelRect,
    /// sRGB and alpha, 8 bits, `rect.w * rect.h * 4` values, rows from the top, not premultiplied. Alpha is 0
    /// where there is no content, else the confidence of the texel.
    pub rgba: Vec<u8>,
    /// The flags [`COVERED`], [`BLEED`] and [`FILLED`] of each texel; `rect.w * rect.h` values.
    pub needed: Vec<u8>,
    /// The matte of each texel, in 255ths: how much of it the surface covers, in linear light; the rest is what is behind
    /// it. It is another number than confidence: a texel of matte 0 with full confidence says that nothing is there.
    /// `rect.w * rect.h` values; `None` where the surface covers all.
    pub matte: Option<Vec<u8>>,
}

/// A source of layer textures' texels: files, or data made by a test.
pub trait Texels: Send + Sync {
    /// Decodes the texels of a layer texture.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for the layer texture's files.
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_apart_from_a_domain_when_a_side_has_it_beyond() {
        let side = |x: f64, y: f64, offset: f64| HalfPlane { normal: DVec2::new(x, y), offset };
        // The triangle (0, 0), (10, 0), (0, 10).
        let slope = std::f64::consts::FRAC_1_SQRT_2;
        let triangle = Domain::Inside(vec![
            side(1.0, 0.0, 0.0),
            side(0.0, 1.0, 0.0),
            side(-slope, -slope, -10.0 * slope),
        ]);
        let apart = |x: f64, y: f64| triangle.is_apart(DVec2::new(x, y), DVec2::new(x + 2.0, y + 2.0));
        assert!(!apart(1.0, 1.0) && !apart(-1.0, 4.0) && !apart(4.5, 4.5));
        assert!(apart(-3.0, 4.0) && apart(4.0, -3.0) && apart(6.0, 6.0));
        assert!(!Domain::Whole.is_apart(DVec2::ZERO, DVec2::ONE));
    }
}
