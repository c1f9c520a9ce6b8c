//! One surface point in one view: the layer textures that contribute, and the resulting colour.

use glam::{DVec2, DVec3};

use super::ReferenceRenderer;
use super::sample::Footprint;
use crate::exposure::{ViewExposure, kept_white};
use crate::model_surface::RayHit;
use crate::turned::{MIRRORED, PhotoOnFace, blend_on};
use crate::{LayerTextureId, Projector, Server};
use quadratura_base::geometry::polygon::fit_plane;
use quadratura_base::geometry::{Pinhole, Plane, Pose};
use quadratura_base::scene::FaceId;
use quadratura_base::scene::impostor::Facing;
use quadratura_view::optics::{squared_radius, squared_tangent};
use quadratura_view::weights::{
    Claim, LEAST_ANGLE, OTHER_SIDE, angle_at, border, octaves_missing, pixels_per_unit, shares,
};
use quadratura_view::{Mode, Quality, Shot};

/// The confidence below which a texel does not contribute: half a step of 8 bits.
pub(super) const LEAST_CONFIDENCE: f64 = 0.002;

/// The contribution of one server to a point.
struct Contribution {
    penalty: f64,
    /// The trust of a pinned photo; `None` for other photos.
    pinned: Option<f64>,
    /// The colour as stored, in linear light.
    stored: [f64; 3],
    /// The same without the photo's optics.
    undone: [f64; 3],
    /// The matte: 1 on faces that are not see-through.
    matte: f64,
    /// How much of the texel shows the face, not the sky within the outlines of the model.
    outline: f64,
}

/// What the photos show at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShownTexel {
    /// The blended colour, in linear light and in the view's exposure; black where nothing is there.
    pub colour: [f64; 3],
    /// How much of the point the surface covers: 1 on faces that are not see-through, but for the sky within outlines.
    pub alpha: f64,
    /// The layer texture with the largest weight.
    pub strongest: LayerTextureId,
}

/// The point that a pixel's ray hits.
pub struct HitPoint<'a> {
    twin: &'a ReferenceRenderer,
    shot: &'a Shot,
    face: FaceId,
    plane: Plane,
    on_plane: DVec3,
}

impl<'a> HitPoint<'a> {
    /// Intersects the ray through `px` with the plane of the face it hits; `None` edge-on.
    pub fn new(twin: &'a ReferenceRenderer, shot: &'a Shot, px: DVec2, hit: RayHit) -> Option<Self> {
        let plane = plane_of(twin, shot, &hit)?;
        let eye = shot.viewpoint();
        let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
        let depth = -plane.signed_distance(eye) / plane.normal.dot(direction);
        let on_plane = eye + direction * depth;
        (depth > 0.0).then_some(Self { twin, shot, face: hit.face, plane, on_plane })
    }

    /// Takes a given point of a planar face.
    pub fn at(twin: &'a ReferenceRenderer, shot: &'a Shot, face: FaceId, on_plane: DVec3) -> Self {
        let plane = twin.model.plane_facing(face, &Facing::of_pose(&shot.pose));
        Self { twin, shot, face, plane, on_plane }
    }

    /// Computes what the photos show; `None` where no photo contributes.
    pub fn shown(&self, exposure: &ViewExposure) -> Option<ShownTexel> {
        let shown = match self.on_relief() {
            // Where no photo shows the point on the relief, one may show the point on the plane.
            Some(on_relief) => {
                self.shown_at(on_relief, exposure).or_else(|| self.shown_at(self.on_plane, exposure))
            }
            None => self.shown_at(self.on_plane, exposure),
        };
        let left = self.light_left();
        shown.map(|shown| ShownTexel { colour: [0, 1, 2].map(|c| left[c] * shown.colour[c]), ..shown })
    }

    /// Returns what shadows leave of the light of the point, per channel.
    fn light_left(&self) -> [f64; 3] {
        let Some(shadows) = &self.twin.shadows else { return [1.0; 3] };
        let Plane { normal, .. } = self.plane;
        let is_behind = self.plane.signed_distance(self.shot.viewpoint()) < 0.0;
        let normal = if is_behind { -normal } else { normal };
        shadows(self.on_plane, (!self.is_billboard()).then_some(normal))
    }

    /// Returns the point on the surface as the view shows it, with its relief.
    pub fn on_surface(&self) -> DVec3 {
        self.on_relief().unwrap_or(self.on_plane)
    }

    /// Returns the plane of the face, or of its triangle.
    pub fn plane(&self) -> Plane {
        self.plane
    }

    fn on_relief(&self) -> Option<DVec3> {
        let relief = self.twin.relief.of(self.face).filter(|_| self.shot.relief)?;
        Some(relief.meet(self.shot.viewpoint(), self.on_plane, self.plane.normal))
    }

    fn shown_at(&self, point: DVec3, exposure: &ViewExposure) -> Option<ShownTexel> {
        let servers = self.twin.sources.servers_of(self.face).iter();
        let taking_part = servers.filter(|server| !self.shot.without.contains(&server.photo));
        let mut of_servers = (Vec::new(), Vec::new(), Vec::new());
        let (mut mattes, mut textures) = (Vec::new(), Vec::new());
        let lens = self.lens(exposure);
        for (server, contribution) in
            taking_part.filter_map(|server| Some((server, self.contribution(server, point)?)))
        {
            let on_face = exposure.surfaces.of(self.face, server.photo);
            let factor = exposure.factors[server.photo.index()];
            let factor = [0, 1, 2].map(|c| lens * factor[c] * on_face[c]);
            of_servers.0.push(exposure.leaning_of(server.photo) * contribution.penalty);
            of_servers.1.push(contribution.pinned);
            let Contribution { stored, undone, matte, outline, .. } = contribution;
            let shows = 1.0 + exposure.surroundings.left(server.photo) * (outline - 1.0);
            let exposed = kept_white(stored, [0, 1, 2].map(|c| undone[c] * factor[c]));
            of_servers.2.push(exposed.map(|light| light * matte * shows));
            mattes.push(matte * shows);
            textures.push(server.layer_texture);
        }
        let (penalties, pinned, colours) = of_servers;
        let blend = blend_on(&self.twin.model, self.face, &self.shot.blend);
        let shares = shares(&penalties, &pinned, &blend);
        let sum =
            |c: usize| shares.iter().zip(&colours).map(|(share, colour)| share * colour[c]).sum::<f64>();
        let alpha: f64 = shares.iter().zip(&mattes).map(|(share, matte)| share * matte).sum();
        // Of equal shares the first counts, as in the shaders.
        let largest =
            (0..shares.len()).reduce(|best, next| if shares[next] > shares[best] { next } else { best })?;
        let colour = [0, 1, 2].map(|c| if alpha > 0.0 { sum(c) / alpha } else { 0.0 });
        Some(ShownTexel { colour, alpha, strongest: textures[largest] })
    }

    /// Returns the factor of the view's lens at the point.
    fn lens(&self, exposure: &ViewExposure) -> f64 {
        let Shot { camera, pose, .. } = self.shot;
        let px = camera.image_from_camera(pose.camera_from_world(self.on_plane));
        px.map_or(1.0, |px| exposure.lens.factor(squared_tangent(camera, px)))
    }

    /// Returns the layer texture that would show the point if its texels there were not empty: that of the photo whose
    /// direction is nearest to the view's. `None` where the image of the point is in no photo that textures the face.
    pub fn nearest_server(&self) -> Option<LayerTextureId> {
        let (point, eye) = (self.on_surface(), self.shot.viewpoint());
        let servers = self.twin.sources.servers_of(self.face).iter();
        let could_show = servers.filter_map(|server| {
            let photo = self.twin.sources.photo(server.photo);
            let on_face = self.on_face(photo, server);
            let px = photo.camera.image_from_camera(on_face.pose.camera_from_world(point));
            let px = px.filter(|px| server.domain.holds(*px))?;
            let other_side = server.back == (self.plane.signed_distance(eye) > 0.0);
            let serves = !self.shot.without.contains(&server.photo) && border(&photo.camera, px) > 0.0;
            let angle = angle_at(point, eye, on_face.seen_from(point)) + self.apart(other_side);
            (serves && (!other_side || self.is_billboard())).then_some((angle, server.layer_texture))
        });
        could_show.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, texture)| texture)
    }

    /// Computes the contribution of one server; `None` where it has none.
    fn contribution(&self, server: &Server, point: DVec3) -> Option<Contribution> {
        let photo = self.twin.sources.photo(server.photo);
        let on_face = self.on_face(photo, server);
        let in_photo = on_face.pose.camera_from_world(point);
        let px = photo.camera.image_from_camera(in_photo).filter(|px| server.domain.holds(*px))?;
        let other_side = server.back == (self.plane.signed_distance(self.shot.viewpoint()) > 0.0);
        if other_side && !self.is_billboard() {
            return None;
        }
        let (eye, center) = (self.shot.viewpoint(), on_face.pose.center_in_world());
        let depth = self.shot.pose.camera_from_world(self.on_plane).z;
        let in_view = pixels_per_unit(&self.shot.camera, &self.plane, eye, depth);
        let of_photo = pixels_per_unit(&photo.camera, &self.plane, center, in_photo.z);
        let footprint = match self.shot.quality {
            Quality::Preview => Footprint::Square(of_photo / in_view),
            Quality::Final | Quality::Finer => {
                let [a, b] =
                    self.steps(depth).map(|step| image_step(&photo.camera, &on_face.pose, in_photo, step));
                Footprint::Sides(a, b)
            }
        };
        let texel = self.twin.layer_textures[&server.layer_texture].texel(px, footprint)?;
        let optics = self.twin.gains.optics(self.shot, server.photo);
        // The offset is of light that is not multiplied by the matte.
        let stored = texel.colour.map(|light| if texel.matte > 0.0 { light / texel.matte } else { 0.0 });
        let undone = optics.undone(stored, squared_radius(&photo.camera, px));
        let sees_through = self.twin.see_through.contains(&self.face) || self.twin.skirts.holds(self.face);
        let (matte, outline) = match sees_through {
            true => (texel.matte, 1.0),
            false => (1.0, self.twin.outline(self.shot, server.layer_texture, px)),
        };
        let (confidence, border) = (texel.confidence, border(&photo.camera, px));
        if confidence <= LEAST_CONFIDENCE || border <= 0.0 {
            return None;
        }
        let octaves = octaves_missing(in_view, of_photo);
        let angle = angle_at(point, eye, on_face.seen_from(point)) + self.apart(other_side);
        let agreement = self.twin.agreement(self.shot, server.layer_texture, px);
        let claim = Claim { angle, octaves, border, confidence, agreement };
        let penalty = claim.penalty(&self.shot.blend);
        debug_assert!(self.shot.blend.mode == Mode::Debevec || penalty >= LEAST_ANGLE);
        let pinned = (server.pinned && !other_side).then(|| claim.trust());
        Some(Contribution { penalty, pinned, stored, undone, matte, outline })
    }

    /// Returns how the point on the plane, `depth` in front of the view, moves in world coordinates for a
    /// step of one pixel to the right, and of one down.
    fn steps(&self, depth: f64) -> [DVec3; 2] {
        let Shot { camera, pose, .. } = self.shot;
        let axes = pose.rotation.transpose();
        let ray = (self.on_plane - self.shot.viewpoint()) / depth;
        let (normal, facing) = (self.plane.normal, self.plane.normal.dot(ray));
        let step = |of_ray: DVec3| depth * (of_ray - ray * (normal.dot(of_ray) / facing));
        [step(axes.x_axis / camera.fx), step(axes.y_axis / camera.fy)]
    }

    fn on_face(&self, photo: &Projector, server: &Server) -> PhotoOnFace {
        PhotoOnFace::new(&self.twin.model, self.face, self.shot, photo, server)
    }

    /// Returns the angle, in radians, that is added for photos of the other side.
    fn apart(&self, other_side: bool) -> f64 {
        match (other_side, self.twin.model.impostor(self.face)) {
            (false, _) => 0.0,
            (true, None) => OTHER_SIDE,
            (true, Some(_)) => MIRRORED,
        }
    }

    fn is_billboard(&self) -> bool {
        let model = &self.twin.model;
        model.object(model.face(self.face).object).billboard
    }
}

/// Computes the movement in pixels of the image of a point (given in the photo's camera frame) for a step of
/// the point, in the world of the photo's pose.
pub(super) fn image_step(camera: &Pinhole, pose: &Pose, in_photo: DVec3, step_in_world: DVec3) -> DVec2 {
    let step = pose.rotation * step_in_world;
    let across = step.truncate() - in_photo.truncate() * (step.z / in_photo.z);
    across * DVec2::new(camera.fx, camera.fy) / in_photo.z
}

/// Returns the plane of a face; of its triangle when the face is not planar.
fn plane_of(twin: &ReferenceRenderer, shot: &Shot, hit: &RayHit) -> Option<Plane> {
    if twin.model.face(hit.face).planar || twin.model.impostor(hit.face).is_some() {
        return Some(twin.model.plane_facing(hit.face, &Facing::of_pose(&shot.pose)));
    }
    let corners = twin.model.face_triangles(hit.face)[hit.triangle as usize];
    fit_plane(&corners.map(|vertex| twin.model.vertices[vertex as usize]))
}
