//! The CPU reference of the renderer: slow, in f64, without shortlists, tiles or shaders. It documents the
//! shaders and serves to test them.
//!
//! At each pixel centre it casts a ray, finds the face that owns the point hit, samples every layer texture that may
//! texture that face, computes the penalties, and blends the k best in linear light. It takes one sample per
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
pub use self::probe::{ProbedPoint, ProbedTexel};
use self::sample::Lookup;
use super::agreement::Agreement;
use super::cells::{Unknown, cells};
use super::exposure::{ViewExposure, visible_shares};
use super::pyramid::PyramidOptions;
use super::relief::{FaceRelief, Relief};
use super::surface::{RayHit, Surface};
use super::{DisplayMode, Gains, LayerTextureId, Picture, Renders, Shot, Sources, Texels};
use crate::error::{Error, Result};
use crate::scene::impostor::Facing;
use crate::scene::light::srgb_from_linear;
use crate::scene::{FaceId, Model};
use crate::task::Task;

/// The share of the nearest depth within which faces count as one surface, as in the visibility sort.
const TOLERANCE: f64 = 1e-4;

/// Side of a cell, in pixels, for the exposure of the view; its value does not matter.
const CELL_PX: u32 = 32;

/// The colour and alpha of a pixel without texture.
const FLAT: [u8; 4] = [128, 128, 128, 0];

/// A renderer on the CPU for views of one site.
pub struct ReferenceRenderer {
    model: Arc<Model>,
    surface: Surface,
    sources: Arc<Sources>,
    gains: Gains,
    relief: Relief,
    agreement: Agreement,
    texels: Arc<dyn Texels>,
    options: PyramidOptions,
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
        let surface = Surface::from_model(&model).with_backs(&model, &sources);
        let agreement = Agreement::default();
        Self {
            model,
            surface,
            sources,
            gains,
            relief,
            agreement,
            texels,
            options,
            layer_textures: BTreeMap::new(),
        }
    }

    /// Returns the same with this agreement of the photos; without it nothing is contradicted.
    pub fn with_agreement(self, agreement: Agreement) -> Self {
        Self { agreement, ..self }
    }

    /// Returns the agreement of a layer texture's texel at a photo position, as far as the view respects it.
    fn agreement(&self, shot: &Shot, layer_texture: LayerTextureId, px: DVec2) -> f64 {
        if shot.blend.agreement { self.agreement.at(layer_texture, px) } else { 1.0 }
    }

    /// Casts the ray of each pixel's centre; row by row from the top.
    fn owners(&self, shot: &Shot) -> Vec<Option<RayHit>> {
        let (width, height) = (shot.camera.width, shot.camera.height);
        let at = |i: u32| DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        (0..width * height)
            .into_par_iter()
            .map(|i| {
                let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(at(i));
                self.surface.owner(shot.viewpoint(), direction, TOLERANCE, shot.culling())
            })
            .collect()
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
        let decode = |layer_texture: LayerTextureId| {
            task.go_on()?;
            let pixels = self.texels.layer_texture(layer_texture)?;
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
            let height = |face| self.relief.of(face).map_or(0.0, FaceRelief::largest);
            let heights: Vec<f64> = self.model.face_ids().map(height).collect();
            let model = self.model.facing(&Facing::of_pose(&shot.pose));
            let cells = cells(&model, &self.sources, shot, CELL_PX, &heights, &[], &Unknown);
            visible_shares(shot, &model, &self.sources, &self.surface, &cells)
        })
    }

    /// Computes the colours of surface points in a view, in linear light; `None` where no photo shows the
    /// point. Visibility of the points in the view is not tested.
    ///
    /// # Errors
    /// As [`Renders::picture`].
    pub fn colours_at(
        &mut self,
        shot: &Shot,
        points: &[(FaceId, DVec3)],
        task: &Task,
    ) -> Result<Vec<Option<[f64; 3]>>> {
        self.load(&points.iter().map(|(face, _)| *face).collect(), task)?;
        let exposure = self.exposure(shot);
        let colour =
            |(face, point): &(FaceId, DVec3)| HitPoint::at(self, shot, *face, *point).colour(&exposure);
        Ok(points.par_iter().map(colour).collect())
    }
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
        let owners = self.owners(shot);
        self.load(&owners.iter().flatten().map(|hit| hit.face).collect(), task)?;
        let shows_surroundings = shot.surroundings && owners.iter().any(Option::is_none);
        if shows_surroundings {
            self.load_surroundings(task)?;
        }
        task.go_on()?;
        let exposure = self.exposure(shot);
        let twin = &*self;
        let pixel = |(i, hit): (usize, &Option<RayHit>)| {
            let width = shot.camera.width as usize;
            let px = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            match hit {
                Some(hit) => HitPoint::new(twin, shot, px, *hit)?.colour(&exposure),
                None if shot.surroundings => twin.surroundings_at(shot, px, &exposure),
                None => None,
            }
        };
        let colours: Vec<_> = owners.par_iter().enumerate().map(pixel).collect();
        let rgba = colours.into_iter().flat_map(|colour| colour.map_or(FLAT, stored)).collect();
        Ok(Picture { width: shot.camera.width, height: shot.camera.height, rgba })
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        task.go_on()?;
        Ok(self.owners(shot).into_iter().map(|hit| hit.map_or(0, |hit| hit.face.0 + 1)).collect())
    }
}

fn stored(linear: [f64; 3]) -> [u8; 4] {
    let [r, g, b] = linear.map(|light| (srgb_from_linear(light.clamp(0.0, 1.0)) * 255.0).round() as u8);
    [r, g, b, u8::MAX]
}
