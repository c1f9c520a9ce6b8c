//! The light of the ground, with which the dome continues below the horizon.

use std::path::Path;

use glam::DVec2;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::scene::up;
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_projection::Gains;
use quadratura_sites::thumbnail::cached_thumbnail;
use quadratura_view::srgb::Srgb;

/// The longer side of the pictures from which the ground's colour is taken.
const SMALL_PX: u32 = 160;

/// The sine of the angle below the horizon from which on photos are taken to show the ground: about 10 degrees.
const GROUND_BELOW: f64 = 0.17;

/// The step to which the ground's light is rounded (linear, full range 1).
const GROUND_STEP: f64 = 1.0 / 4096.0;

/// The sum of the light (linear, in the photo's own exposure) of a photo's pixels below the horizon, and their number.
pub type GroundOfPhoto = ([f64; 3], u32);

/// Returns what each photo shows of the ground, in the site's order; `known` is what is known of it. A photo that cannot be read shows
/// none: that is told where it is used.
pub fn ground_of_photos(
    folder: &Path,
    site: &Site,
    known: Vec<Option<GroundOfPhoto>>,
    task: &Task,
) -> Result<Vec<GroundOfPhoto>> {
    let up = up(&site.photos);
    let of_photo = |(photo, known): (&Photo, Option<GroundOfPhoto>)| {
        task.check_cancelled()?;
        if let Some(known) = known {
            return Ok(known);
        }
        let Ok(picture) = cached_thumbnail(folder, photo, SMALL_PX) else {
            return Ok(([0.0; 3], 0));
        };
        let scale = DVec2::new(
            f64::from(photo.camera.width) / f64::from(picture.width),
            f64::from(photo.camera.height) / f64::from(picture.height),
        );
        let srgb = Srgb::tables();
        let (mut sum, mut count) = ([0.0f64; 3], 0u32);
        for ((x, y), pixel) in picture.rect().pixels().zip(picture.pixels()) {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * scale;
            let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(px);
            if pixel[3] == u8::MAX && ray.normalize().dot(up) < -GROUND_BELOW {
                (0..3).for_each(|c| sum[c] += f64::from(srgb.linear(pixel[c])));
                count += 1;
            }
        }
        Ok((sum, count))
    };
    site.photos.par_iter().zip(known).map(of_photo).collect()
}

/// Returns the mean light of what photos show below the horizon, in the common exposure; `None` where none looks down. It is rounded,
/// because a few pixels of one photo more or less change nothing that is seen.
pub fn mean_ground(ground: &[GroundOfPhoto], left_out: &[PhotoId], gains: &Gains) -> Option<[f32; 3]> {
    let taking_part = || PhotoId::all(ground.len()).zip(ground).filter(|(id, _)| !left_out.contains(id));
    let count: u32 = taking_part().map(|(_, (_, count))| count).sum();
    let exposed =
        |c: usize| taking_part().map(move |(id, (sum, _))| sum[c] * (-gains.of_photo[id.index()][c]).exp());
    let mean = |c: usize| {
        let mean = exposed(c).sum::<f64>() / f64::from(count);
        ((mean / GROUND_STEP).round() * GROUND_STEP) as f32
    };
    (count > 0).then(|| [0, 1, 2].map(mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_is_the_mean_over_all_pixels_in_the_common_exposure_and_a_few_of_them_do_not_matter() {
        let gains = Gains { of_photo: vec![[2f64.ln(); 3], [0.0; 3]], ..Gains::none(2) };
        let ground = [([80.0; 3], 100), ([60.0; 3], 100)];
        let known = |value: f32| Some([value; 3]);
        assert_eq!(mean_ground(&ground, &[], &gains), known(0.5));
        assert_eq!(mean_ground(&ground, &[PhotoId(1)], &gains), known(0.4).map(|v| v.map(rounded)));
        assert_eq!(mean_ground(&[([80.01; 3], 100), ground[1]], &[], &gains), known(0.5));
        assert_eq!(mean_ground(&[([0.0; 3], 0)], &[], &gains), None);
    }

    fn rounded(light: f32) -> f32 {
        ((f64::from(light) / GROUND_STEP).round() * GROUND_STEP) as f32
    }
}
