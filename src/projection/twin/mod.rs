//! The CPU reference of the renderer: slow, in f64, without shortlists, tiles or shaders. It documents the
//! shaders and serves to test them.
//!
//! At each pixel centre it casts a ray, finds the face that owns the point hit, samples every layer texture that may
//! texture that face, computes the penalties, and blends the k best in linear light; the see-through faces in front
//! follow, from back to front, each laid over what is behind it. It takes one sample per
//! pixel in either quality, so at the outlines of faces it differs from *final* images; and it filters texels
//! in linear light in either quality, so between texels of high contrast it differs from *preview*.

mod point;
mod probe;
pub mod sample;
mod surroundings;

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::point::HitPoint;
pub use self::point::ShownTexel;
pub use self::probe::{PhotoPosition, ProbedPoint, ProbedTexel};
use self::sample::Lookup;
use super::agreement::Agreement;
use super::exposure::{ViewExposure, shares_of_view};
use super::model_surface::{ModelSurface, RayHit};
use super::pyramid::PyramidOptions;
use super::relief::Relief;
use super::skirts::{Skirts, met};
use super::surroundings::Reach;
use super::{Gains, LayerTextureId, Renders, Sources, Texels};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_view::hidden::{Culling, HiddenFaces};
use quadratura_view::{DisplayMode, Picture, Shot};

/// The alpha from which on nothing is seen through a surface: half a step of 8 bits less than 1 (`shaders/project.wgsl`).
const WHOLE: f64 = 0.998;

/// The colour and alpha of a pixel without texture.
const FLAT: [u8; 4] = [128, 128, 128, 0];

/// What is left of the light of a point of a face, per channel, where something casts a shadow that the photos do not show. Takes the
/// point, in the world, and the normal that looks to the viewer; `None` on billboards, which stand for what is round.
pub type LightLeft = dyn Fn(DVec3, Option<DVec3>) -> [f64; 3] + Send + Sync;

/// A renderer on the CPU for views of one site.
pub struct ReferenceRenderer {
    model: Arc<Model>,
    surface: ModelSurface,
    sources: Arc<Sources>,
    /// The faces through which one sees in places.
    see_through: BTreeSet<FaceId>,
    gains: Gains,
    relief: Relief,
    agreement: Agreement,
    /// What stands on the outlines of the model; model and sources contain it.
    skirts: Skirts,
    texels: Arc<dyn Texels>,
    options: PyramidOptions,
    /// What shadows leave of the light of faces; `None` for all of it.
    shadows: Option<Arc<LightLeft>>,
    /// The layer textures decoded so far.
    layer_textures: BTreeMap<LayerTextureId, Lookup>,
}

impl ReferenceRenderer {
    /// Builds a reference of a renderer with the same arguments.
    pub fn new(
        model: Arc<Model>,
        sources: Arc<Sources>,
        gains: Gains,
        relief: Relief,
        texels: Arc<dyn Texels>,
        options: PyramidOptions,
    ) -> Self {
        let surface = ModelSurface::from_model(&model).with_backs(&model, &sources);
        let agreement = Agreement::default();
        Self {
            see_through: sources.see_through_faces(&model),
            skirts: Skirts::none(&model, &sources),
            model,
            surface,
            sources,
            gains,
            relief,
            agreement,
            texels,
            options,
            shadows: None,
            layer_textures: BTreeMap::new(),
        }
    }

    /// Returns the same with this agreement of the photos; without it nothing is contradicted.
    pub fn with_agreement(self, agreement: Agreement) -> Self {
        Self { agreement, ..self }
    }

    /// Returns the same with shadows that the photos do not show.
    pub fn with_shadows(self, shadows: Arc<LightLeft>) -> Self {
        Self { shadows: Some(shadows), ..self }
    }

    /// Returns the same with skirts on the outlines of the model.
    pub fn with_skirts(self) -> Self {
        let skirts = Skirts::new(&self.model, &self.sources, &self.surface);
        Self { model: skirts.model.clone(), sources: skirts.sources.clone(), skirts, ..self }
    }

    /// Returns the agreement of a layer texture's texel at a photo position, as far as the view respects it.
    fn agreement(&self, shot: &Shot, layer_texture: LayerTextureId, px: DVec2) -> f64 {
        if shot.blend.agreement { self.agreement.at(layer_texture, px) } else { 1.0 }
    }

    /// Returns how much of a layer texture's texel at a photo position shows its face, likewise.
    fn outline(&self, shot: &Shot, layer_texture: LayerTextureId, px: DVec2) -> f64 {
        if shot.blend.agreement { self.agreement.outline_at(layer_texture, px) } else { 1.0 }
    }

    /// Casts the ray of each pixel's centre, row by row from the top: which face owns it, of those that the view does not
    /// leave out.
    fn owners(&self, shot: &Shot, hidden: &HiddenFaces) -> Vec<Option<RayHit>> {
        let culling = Culling { hidden, ..shot.culling() };
        let owner =
            |px: DVec2| self.surface.owner(shot.viewpoint(), ray(shot, px), shot.tolerance(), culling);
        positions(shot).map(owner).collect()
    }

    /// Finds what each pixel's centre shows, row by row from the top.
    fn pixel_hits(&self, shot: &Shot) -> Vec<PixelHits> {
        let opaque: HiddenFaces = shot.hidden.iter().chain(self.see_through.iter().copied()).collect();
        let eye = shot.viewpoint();
        let culling = Culling { hidden: &opaque, ..shot.culling() };
        let skirts = self.skirts.of_view(shot);
        let through = |(px, owner): (DVec2, Option<RayHit>)| {
            let direction = ray(shot, px);
            let nearest = owner.and_then(|_| self.surface.first_visible(eye, direction, culling));
            let reach = nearest.map_or(f64::INFINITY, |hit| hit.t * (1.0 + shot.tolerance()));
            let through = self.surface.through(eye, direction, &self.see_through, shot.culling());
            let skirts = skirts.iter().filter(|_| owner.is_none());
            let skirts = skirts.filter_map(|skirt| met(&self.model, *skirt, eye, direction));
            let through = through.into_iter().filter(|hit| hit.t <= reach);
            PixelHits { px, owner, through: skirts.chain(through).collect() }
        };
        positions(shot).zip(self.owners(shot, &opaque)).map(through).collect()
    }

    /// Computes the colour of a pixel of a view with this reach of surroundings: linear light times alpha, and alpha.
    fn colour_of(&self, shot: &Shot, reach: Reach, hits: &PixelHits, exposure: &ViewExposure) -> [f64; 4] {
        let shown = |hit: &RayHit| HitPoint::new(self, shot, hits.px, *hit)?.shown(exposure);
        let of_owner = hits.owner.as_ref().map(shown);
        let is_open = of_owner.is_none_or(|shown| shown.is_some_and(|shown| shown.alpha < WHOLE));
        let around = if is_open && shot.surroundings {
            self.surroundings_at(shot, reach, hits.px, exposure)
        } else {
            None
        };
        let clipped = |light: f64| light.clamp(0.0, 1.0);
        let mut colour = around.map_or([0.0; 4], |[r, g, b]| [r, g, b, 1.0].map(clipped));
        let through = hits.through.iter().filter_map(shown);
        for shown in of_owner.flatten().into_iter().chain(through) {
            let [r, g, b] = shown.colour.map(|light| clipped(light * shown.alpha));
            let over = [r, g, b, shown.alpha];
            colour = std::array::from_fn(|c| over[c] + (1.0 - shown.alpha) * colour[c]);
        }
        colour
    }

    /// Decodes the layer textures of these faces that are not decoded yet.
    fn load(&mut self, faces: &BTreeSet<FaceId>, task: &Task) -> Result<()> {
        let sources = self.sources.clone();
        let serving = faces.iter().flat_map(|face| sources.servers_of(*face)).map(|s| s.layer_texture);
        self.decode(serving, task)
    }

    /// Decodes those of these layer textures that are not decoded yet.
    fn decode(&mut self, wanted: impl Iterator<Item = LayerTextureId>, task: &Task) -> Result<()> {
        let missing: BTreeSet<LayerTextureId> =
            wanted.filter(|layer_texture| !self.layer_textures.contains_key(layer_texture)).collect();
        let texels = self.skirts.texels(self.texels.clone(), &self.agreement);
        let decode = |layer_texture: LayerTextureId| {
            task.check_cancelled()?;
            let pixels = texels.layer_texture(layer_texture)?;
            Ok((
                layer_texture,
                Lookup::new(self.sources.layer_texture(layer_texture).rect, &pixels, &self.options),
            ))
        };
        let decoded: Vec<_> = missing.into_par_iter().map(decode).collect::<Result<_>>()?;
        self.layer_textures.extend(decoded);
        Ok(())
    }

    /// Computes the exposure of a view. This uses the renderer's own code:
    /// exposure is not part of what the reference verifies.
    fn exposure(&self, shot: &Shot) -> ViewExposure {
        self.gains.exposed(shot, &self.sources.photos, || {
            shares_of_view(shot, &self.model, &self.sources, &self.surface, &self.relief)
        })
    }

    /// Computes the colours of surface points in a view, in linear light times alpha, and alpha, which is below 1 on
    /// see-through faces, and where photos show the sky within outlines; `None` where no photo shows the point. Visibility of the points in the view is not tested,
    /// and nothing is laid over what is behind.
    ///
    /// # Errors
    /// As [`Renders::picture`].
    pub fn colours_at(
        &mut self,
        shot: &Shot,
        points: &[(FaceId, DVec3)],
        task: &Task,
    ) -> Result<Vec<Option<[f64; 4]>>> {
        self.load(&points.iter().map(|(face, _)| *face).collect(), task)?;
        let exposure = self.exposure(shot);
        let shown = |(face, point): &(FaceId, DVec3)| {
            let shown = HitPoint::at(self, shot, *face, *point).shown(&exposure)?;
            let [r, g, b] = shown.colour.map(|light| light * shown.alpha);
            Some([r, g, b, shown.alpha])
        };
        Ok(points.par_iter().map(shown).collect())
    }
}

/// What the ray of a pixel's centre meets.
struct PixelHits {
    /// The pixel's centre.
    px: DVec2,
    /// The face that owns it, of those that are not see-through; `None` where there is none.
    owner: Option<RayHit>,
    /// The skirts, where there is none, and the see-through faces in front of that, each from back to front.
    through: Vec<RayHit>,
}

/// Returns the centres of all pixels, row by row from the top.
fn positions(shot: &Shot) -> impl IndexedParallelIterator<Item = DVec2> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let at = move |i: u32| DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
    (0..width * height).into_par_iter().map(at)
}

/// Returns the ray through a position of a view, in world axes.
fn ray(shot: &Shot, px: DVec2) -> DVec3 {
    shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px)
}

impl Renders for ReferenceRenderer {
    /// Renders the image of a view, by one sample per pixel.
    ///
    /// # Errors
    /// As [`Renders::picture`], and [`Error::Request`] for anything but [`DisplayMode::Colour`].
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        if shot.display != DisplayMode::Colour {
            return Err(Error::Request("the twin shows colours only".into()));
        }
        let shot = &self.sources.beyond_backdrops(shot);
        let hits_of_pixels = self.pixel_hits(shot);
        let hits = hits_of_pixels.iter().flat_map(|hits| hits.owner.iter().chain(&hits.through));
        self.load(&hits.map(|hit| hit.face).collect(), task)?;
        if shot.surroundings
            && (self.agreement.has_outlines() || hits_of_pixels.iter().any(|hits| hits.owner.is_none()))
        {
            self.load_surroundings(task)?;
        }
        task.check_cancelled()?;
        let exposure = self.exposure(shot);
        let reach = Reach::new(&self.sources, shot);
        let twin = &*self;
        let colours: Vec<_> = hits_of_pixels
            .par_iter()
            .map(|hits| stored(twin.colour_of(shot, reach, hits, &exposure)))
            .collect();
        let rgba = colours.into_flattened();
        Ok(Picture { width: shot.camera.width, height: shot.camera.height, rgba })
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        task.check_cancelled()?;
        Ok(self
            .owners(shot, &shot.hidden)
            .into_iter()
            .map(|hit| hit.map_or(0, |hit| hit.face.0 + 1))
            .collect())
    }

    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        let positions: Vec<DVec2> = positions(shot).collect();
        let points = self.seen_points(shot, &positions, task)?;
        Ok(points.into_iter().map(|point| point.map_or(0, |point| point.hit.face.0 + 1)).collect())
    }
}

/// Encodes a colour times alpha as straight colour and alpha, in 8 bits.
fn stored([r, g, b, alpha]: [f64; 4]) -> [u8; 4] {
    let byte = (alpha * 255.0).round() as u8;
    if byte == 0 {
        return FLAT;
    }
    let [r, g, b] =
        [r, g, b].map(|light| (srgb_from_linear((light / alpha).clamp(0.0, 1.0)) * 255.0).round() as u8);
    [r, g, b, byte]
}
