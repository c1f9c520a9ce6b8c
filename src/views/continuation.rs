//! What a site's surfaces continue from where no photo shows them, for final pictures.

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::scene::{Model, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_projection::Gains;
use quadratura_projection::continuation::{Continuation, SeenPoint};
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::thumbnail::cached_thumbnail;
use quadratura_view::hidden::{Culling, HiddenFaces};
use quadratura_view::srgb::Srgb;

/// The longer side of the pictures from which colours are taken, which lists of photos and the ground of the surroundings use, too.
const SMALL_PX: u32 = 160;
/// The number of rays after which photos are sampled more coarsely.
const MOST_RAYS: usize = 1_000_000;

/// What the photos of a site show of its surfaces, coarsely.
pub(super) struct SiteContinuation {
    model: Arc<Model>,
    seen: Vec<SeenPoint>,
}

impl SiteContinuation {
    /// Looks at small pictures of all photos. A photo that cannot be read is told where it is used.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn new(folder: &Path, site: &Site, task: &Task) -> Result<Self> {
        let (surface, nothing) = (ModelSurface::from_model(&site.model), HiddenFaces::default());
        let rays = site.photos.len() * (SMALL_PX * SMALL_PX) as usize * 2 / 3;
        let step = (rays as f64 / MOST_RAYS as f64).sqrt().ceil().max(1.0) as usize;
        let of_photo = |id: PhotoId| -> Result<Vec<SeenPoint>> {
            task.check_cancelled()?;
            let photo = site.photo(id);
            let Ok(picture) = cached_thumbnail(folder, photo, SMALL_PX) else { return Ok(Vec::new()) };
            let (camera, eye) = (&photo.camera, photo.pose.center_in_world());
            let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
            let scale = DVec2::new(f64::from(camera.width), f64::from(camera.height)) / size;
            let point = |((x, y), [r, g, b, alpha]): ((i32, i32), &[u8; 4])| {
                let is_sampled = (x as usize).is_multiple_of(step) && (y as usize).is_multiple_of(step);
                if !is_sampled || *alpha < u8::MAX {
                    return None;
                }
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * scale;
                let direction = photo.pose.rotation.transpose() * camera.ray_in_camera(px);
                let hit = surface.first_visible(eye, direction, Culling { backs: true, hidden: &nothing })?;
                let light = [*r, *g, *b].map(|byte| Srgb::tables().linear(byte));
                Some(SeenPoint { face: hit.face, at: eye + direction * hit.t, photo: id, light })
            };
            Ok(picture.rect().pixels().zip(picture.pixels()).filter_map(point).collect())
        };
        let ids: Vec<PhotoId> = site.photo_ids().collect();
        let seen: Vec<Vec<SeenPoint>> = ids.into_par_iter().map(of_photo).collect::<Result<_>>()?;
        Ok(Self { model: site.model.clone(), seen: seen.concat() })
    }

    /// Continues the surfaces without these photos.
    pub fn without(&self, photos: &[PhotoId], gains: &Gains) -> Continuation {
        let gain = |photo: PhotoId| (!photos.contains(&photo)).then(|| gains.of_photo[photo.index()]);
        Continuation::new(&self.model, &self.seen, gain)
    }
}
