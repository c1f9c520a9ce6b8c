//! What a view shows at single positions of its picture: the surface, the photo with the largest weight, the colour.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::ReferenceRenderer;
use super::point::{HitPoint, ShownTexel};
use crate::exposure::ViewExposure;
use crate::model_surface::RayHit;
use crate::sources::LEAST_MATTE;
use crate::turned::PhotoOnFace;
use crate::{LayerTextureId, Sources};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Plane, Pose};
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_view::Shot;
use quadratura_view::hidden::HiddenFaces;
use quadratura_view::optics::{squared_radius, squared_tangent};

/// A point of the surface that a view shows at a position of its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbedPoint {
    /// The position in the picture, in pixels.
    pub px: DVec2,
    /// The face and triangle that own the position.
    pub hit: RayHit,
    /// The plane of the face, or of its triangle where the face is not planar.
    pub plane: Plane,
    /// The point in world coordinates, with relief where the view shows it.
    pub point: DVec3,
}

/// The texture of a probed point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbedTexel {
    /// What the photos show; `None` where all texels are empty.
    pub shown: Option<ShownTexel>,
    /// The layer texture with the largest weight, or the one that would have it if its texels were not empty.
    pub texture: Option<LayerTextureId>,
}

/// A position in a photo, with the face that the photo shows there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoPosition {
    /// The photo.
    pub photo: PhotoId,
    /// The face.
    pub face: FaceId,
    /// The position in pixels.
    pub px: DVec2,
}

impl ReferenceRenderer {
    /// Casts rays through positions of a view's picture; `None` where they hit nothing. No texture is read.
    pub fn probed_points(&self, shot: &Shot, positions: &[DVec2]) -> Vec<Option<ProbedPoint>> {
        let probe = |px: &DVec2| {
            let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(*px);
            let hit = self.surface.owner(shot.viewpoint(), direction, shot.tolerance(), shot.culling())?;
            let on_face = HitPoint::new(self, shot, *px, hit)?;
            Some(ProbedPoint { px: *px, hit, plane: on_face.plane(), point: on_face.on_surface() })
        };
        positions.par_iter().map(probe).collect()
    }

    /// As [`Self::probed_points`], but through see-through surfaces where nothing of them is there: the nearest surface that
    /// the view shows at each position.
    ///
    /// # Errors
    /// As [`crate::Renders::picture`].
    pub fn seen_points(
        &mut self,
        shot: &Shot,
        positions: &[DVec2],
        task: &Task,
    ) -> Result<Vec<Option<ProbedPoint>>> {
        let mut points = self.probed_points(shot, positions);
        let is_see_through = |point: &ProbedPoint| self.see_through.contains(&point.hit.face);
        if !points.iter().flatten().any(is_see_through) {
            return Ok(points);
        }
        let seen_through: BTreeSet<FaceId> = {
            let hits = |px: &DVec2| self.hits_through(shot, *px);
            positions.iter().flat_map(hits).map(|hit| hit.face).collect()
        };
        self.load(&seen_through, task)?;
        task.check_cancelled()?;
        let exposure = self.view_exposure(shot);
        let opaque: HiddenFaces = shot.hidden.iter().chain(self.see_through.iter().copied()).collect();
        let behind = self.probed_points(&Shot { hidden: opaque, ..shot.clone() }, positions);
        let twin = &*self;
        points.par_iter_mut().zip(behind).for_each(|(point, behind)| {
            let Some(first) = point.filter(|point| twin.see_through.contains(&point.hit.face)) else {
                return;
            };
            let reach = behind.map_or(f64::INFINITY, |behind| behind.hit.t);
            let is_there = |hit: &RayHit| {
                let on_face = HitPoint::new(twin, shot, first.px, *hit)?;
                let shown = on_face.shown(&exposure).filter(|shown| shown.alpha >= f64::from(LEAST_MATTE))?;
                debug_assert!(shown.alpha <= 1.0 + 1e-6);
                let (plane, point) = (on_face.plane(), on_face.on_surface());
                Some(ProbedPoint { px: first.px, hit: *hit, plane, point })
            };
            // From back to front.
            let hits = twin.hits_through(shot, first.px);
            *point = hits.iter().rev().filter(|hit| hit.t <= reach).find_map(is_there).or(behind);
        });
        Ok(points)
    }

    /// Returns where the ray through a position meets see-through faces, from back to front.
    fn hits_through(&self, shot: &Shot, px: DVec2) -> Vec<RayHit> {
        let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
        self.surface.through(shot.viewpoint(), direction, &self.see_through, shot.culling())
    }

    /// Computes what the photos show at probed points of the same view. `exposure` is that of
    /// [`Self::view_exposure`].
    ///
    /// # Errors
    /// As [`crate::Renders::picture`].
    pub fn probed_texels(
        &mut self,
        shot: &Shot,
        points: &[ProbedPoint],
        exposure: &ViewExposure,
        task: &Task,
    ) -> Result<Vec<ProbedTexel>> {
        self.load(&points.iter().map(|point| point.hit.face).collect::<BTreeSet<FaceId>>(), task)?;
        task.check_cancelled()?;
        let twin = &*self;
        let texel = |point: &ProbedPoint| {
            let on_face = HitPoint::new(twin, shot, point.px, point.hit);
            let shown = on_face.as_ref().and_then(|on_face| on_face.shown(exposure));
            let nearest = || on_face.as_ref().and_then(HitPoint::nearest_server);
            ProbedTexel { shown, texture: shown.map(|shown| shown.strongest).or_else(nearest) }
        };
        Ok(points.par_iter().map(texel).collect())
    }

    /// Computes the exposure of a view.
    pub fn view_exposure(&self, shot: &Shot) -> ViewExposure {
        self.exposure(shot)
    }

    /// Returns the linear colour that a photo must have at a position so that a view with this
    /// exposure shows `colour` at `in_view`, in the view's pixels.
    pub fn colour_in_photo(
        &self,
        shot: &Shot,
        exposure: &ViewExposure,
        position: PhotoPosition,
        colour: [f64; 3],
        in_view: DVec2,
    ) -> [f64; 3] {
        let PhotoPosition { photo, face, px } = position;
        let (factor, on_face) = (exposure.factors[photo.index()], exposure.surfaces.of(face, photo));
        let lens = exposure.lens.factor(squared_tangent(&shot.camera, in_view));
        let light = [0, 1, 2].map(|c| colour[c] / (lens * factor[c] * on_face[c]).max(f64::MIN_POSITIVE));
        let camera = &self.sources.photo(photo).camera;
        self.gains.optics(shot, photo).applied(light, squared_radius(camera, px))
    }

    /// Returns the point of a face with this plane that a photo shows at a position, with relief as in the view `shot`;
    /// `None` where the ray does not meet the plane in front of the photo.
    pub fn point_in_photo(
        &self,
        shot: &Shot,
        photo: PhotoId,
        px: DVec2,
        face: FaceId,
        plane: &Plane,
    ) -> Option<DVec3> {
        let pose = self.pose_on_face(shot, photo, face);
        let eye = pose.center_in_world();
        let ray = pose.rotation.transpose() * self.sources.photo(photo).camera.ray_in_camera(px);
        let along = -plane.signed_distance(eye) / plane.normal.dot(ray);
        let on_plane = (along > 0.0 && along.is_finite()).then(|| eye + ray * along)?;
        let relief = self.relief.of(face).filter(|_| shot.relief);
        Some(relief.map_or(on_plane, |relief| relief.meet(eye, on_plane, plane.normal)))
    }

    /// Returns the pose from which points of a face, as a view has them, are seen where a photo shows them: the photo's own,
    /// but for impostors.
    pub fn pose_on_face(&self, shot: &Shot, photo: PhotoId, face: FaceId) -> Pose {
        PhotoOnFace::looking(&self.model, face, shot, self.sources.photo(photo)).pose
    }

    /// Returns the photos and their layer textures.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Returns the model, in world coordinates.
    pub fn model(&self) -> &Model {
        &self.model
    }
}
