//! The surroundings in a view of the reference renderer: what the photos show in a direction without any face.

use glam::{DVec2, DVec3};

use super::ReferenceRenderer;
use super::point::{LEAST_CONFIDENCE, image_step};
use super::sample::Footprint;
use crate::Server;
use crate::exposure::{ViewExposure, kept_white};
use crate::surroundings::{Reach, claim, pixels_per_angle};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_view::optics::{squared_radius, squared_tangent};
use quadratura_view::weights::{border, weights};
use quadratura_view::{Quality, Shot};

/// What a photo shows in a direction.
struct SurroundingsSample {
    /// The position in the photo.
    px: DVec2,
    penalty: f64,
    /// The colour as it is stored, in linear light.
    stored: [f64; 3],
    /// The same without the photo's optics.
    colour: [f64; 3],
}

impl ReferenceRenderer {
    /// Decodes the layer textures of the surroundings.
    pub(super) fn load_surroundings(&mut self, task: &Task) -> Result<()> {
        let sources = self.sources.clone();
        self.decode(sources.servers_of_surroundings().iter().map(|server| server.layer_texture), task)
    }

    /// Computes the colour of the surroundings at a position of the view with this reach, in linear light; `None` where no photo shows
    /// that direction.
    pub(super) fn surroundings_at(
        &self,
        shot: &Shot,
        reach: Reach,
        px: DVec2,
        exposure: &ViewExposure,
    ) -> Option<[f64; 3]> {
        let ray = shot.camera.ray_in_camera(px);
        let lens = exposure.lens.factor(squared_tangent(&shot.camera, px));
        let servers = self.sources.servers_of_surroundings().iter();
        let taking_part = servers.filter(|server| {
            !shot.without.contains(&server.photo) && self.sources.shows_around(server.photo)
        });
        let (penalties, colours): (Vec<f64>, Vec<[f64; 3]>) = taking_part
            .filter_map(|server| {
                let SurroundingsSample { px, penalty, stored, colour } =
                    self.shown_by(server, shot, reach, ray)?;
                let factor = exposure.factor(server.photo).map(|factor| lens * factor);
                let penalty = exposure.leaning_of(server.photo) * penalty;
                let exposed = [0, 1, 2].map(|c| colour[c] * factor[c]);
                let camera = &self.sources.photo(server.photo).camera;
                let of_photo = self.gains.surroundings.at(server.photo, camera, px);
                let of_sky =
                    if self.sources.is_dome(server.photo) { [1.0; 3] } else { exposure.surroundings.of_sky };
                let to_one_sky = [0, 1, 2].map(|c| of_photo[c] * of_sky[c]);
                let own = kept_white(stored, exposed);
                let share = exposure.surroundings.share(server.photo);
                Some((penalty, [0, 1, 2].map(|c| own[c] + share * (exposed[c] * to_one_sky[c] - own[c]))))
            })
            .unzip();
        let weights = weights(&penalties, &shot.blend);
        let sum = |c: usize| weights.iter().zip(&colours).map(|(weight, colour)| weight * colour[c]).sum();
        (!penalties.is_empty()).then(|| [0, 1, 2].map(sum))
    }

    /// Returns what a photo shows in a direction of the view's camera frame.
    fn shown_by(&self, server: &Server, shot: &Shot, reach: Reach, ray: DVec3) -> Option<SurroundingsSample> {
        let photo = self.sources.photo(server.photo);
        let axes = shot.pose.rotation.transpose();
        let in_photo = photo.pose.rotation * (axes * ray);
        let px = photo.camera.image_from_camera(in_photo).filter(|px| server.domain.holds(*px))?;
        let footprint = match shot.quality {
            Quality::Preview => {
                let (of_photo, of_view) =
                    (pixels_per_angle(&photo.camera, in_photo), pixels_per_angle(&shot.camera, ray));
                Footprint::Square(of_photo / of_view)
            }
            Quality::Final | Quality::Finer => {
                let step = |of_ray: DVec3| image_step(&photo.camera, &photo.pose, in_photo, of_ray);
                Footprint::Sides(step(axes.x_axis / shot.camera.fx), step(axes.y_axis / shot.camera.fy))
            }
        };
        let texel = self.layer_textures[&server.layer_texture].texel(px, footprint)?;
        let colour =
            self.gains.optics(shot, server.photo).undone(texel.colour, squared_radius(&photo.camera, px));
        let border = border(&photo.camera, px);
        if texel.confidence <= LEAST_CONFIDENCE || border <= 0.0 {
            return None;
        }
        let agreement = self.agreement(shot, server.layer_texture, px);
        let known = [border, texel.confidence, agreement];
        let claim = claim(&self.sources, shot, server.photo, reach, [ray, in_photo], known);
        Some(SurroundingsSample { px, penalty: claim.penalty(&shot.blend), stored: texel.colour, colour })
    }
}
