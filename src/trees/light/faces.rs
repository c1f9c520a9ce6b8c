//! How bright the light is where no photo shows a tree: from what photos show of the model beside the trees.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::blocks::in_common_exposure;
use super::fit::{ground_of_sky, luminance, sky_of_sun, strength};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_base::scene::{Photo, PhotoId, PhotoPixels, Site};
use quadratura_base::task::Task;
use quadratura_document::trees::LightStrength;
use quadratura_foliage::{PlacedTrees, Stature};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::Gains;
use quadratura_projection::model_surface::ModelSurface;

/// The share of light that a surface reflects which faces the sun: plaster and stone, neither white nor dark.
const REFLECTED: f64 = 0.4;
/// The share of pixels that are no brighter than such a surface: most others are in shadow, or turned from the sun.
const PERCENTILE: f64 = 0.8;
/// How far away faces may be, in heights of the tree.
const HEIGHTS: f64 = 3.0;
/// Pixels from one that is looked at to the next, across and down.
const STEP_PX: u32 = 24;

/// Returns the light on trees that surfaces beside them tell, and the number of pixels; `None` where photos show none. Sun and sky
/// have the usual ratio and colours: those of the pixels are the surfaces' own.
///
/// # Errors
/// [`Error::Cancelled`]. A photo that cannot be read is noted.
pub fn light_of_faces(
    site: &Site,
    placed: &PlacedTrees,
    gains: &Gains,
    task: &Task,
) -> Result<Option<(LightStrength, usize)>> {
    let near: Vec<(DVec3, f64)> = placed
        .trees
        .iter()
        .map(|tree| {
            let plant = &placed.species[tree.species].plant;
            let stature = Stature::of(plant);
            let map = &tree.world_from_plant;
            let up = map.transform_vector3(stature.height * plant.up);
            (map.transform_point3(stature.foot), HEIGHTS * up.length())
        })
        .collect();
    let surface = ModelSurface::from_model(&site.model.without_see_through());
    let photos: Vec<(PhotoId, &Photo)> = site.numbered_photos().collect();
    let found = photos.par_iter().map(|(id, photo)| {
        task.check_cancelled()?;
        let pixels = match read_unmasked(photo) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(_) => {
                let task = task.with_subject(&photo.name);
                task.note("the photo is not used for the light on trees, because it cannot be read");
                return Ok(Vec::new());
            }
            Ok(pixels) => pixels,
        };
        let places = places(photo).filter(|px| is_near(&surface, photo, *px, &near));
        Ok(places
            .filter_map(|px| {
                light_at(&pixels, px, |at, light| {
                    luminance(in_common_exposure(gains, *id, &photo.camera, at, light))
                })
            })
            .collect())
    });
    let mut found: Vec<f64> = found.collect::<Result<Vec<_>>>()?.concat();
    if found.is_empty() {
        return Ok(None);
    }
    found.sort_by(f64::total_cmp);
    let bright = found[((found.len() - 1) as f64 * PERCENTILE).round() as usize];
    Ok(Some((of_surface(bright, placed.light.towards_sun.dot(placed.light.up)), found.len())))
}

/// Returns the light in which a surface has this luminance that faces the sun; `height` is the sine of the sun's height.
fn of_surface(bright: f64, height: f64) -> LightStrength {
    let around = DVec3::splat(0.5 * (1.0 + height)) + 0.5 * (1.0 - height) * ground_of_sky();
    let usual = DVec3::ONE + sky_of_sun() * around;
    let sun = DVec3::splat(bright / (REFLECTED * luminance(usual)));
    strength(sun, sky_of_sun() * sun)
}

fn places(photo: &Photo) -> impl Iterator<Item = [u32; 2]> + use<> {
    let (width, height) = (photo.camera.width as usize, photo.camera.height as usize);
    let steps = |side: usize| (STEP_PX as usize / 2..side).step_by(STEP_PX as usize);
    steps(height).flat_map(move |y| steps(width).map(move |x| [x as u32, y as u32]))
}

/// Returns true where a pixel shows a face that is near to some tree.
fn is_near(surface: &ModelSurface, photo: &Photo, px: [u32; 2], near: &[(DVec3, f64)]) -> bool {
    let centre = DVec2::from_array(px.map(|at| f64::from(at) + 0.5));
    let camera = &photo.camera;
    let in_camera = DVec3::new((centre.x - camera.cx) / camera.fx, (centre.y - camera.cy) / camera.fy, 1.0);
    let (eye, direction) = (photo.pose.center_in_world(), photo.pose.rotation.transpose() * in_camera);
    surface.nearest(eye, direction).is_some_and(|hit| {
        let point = eye + hit.t * direction;
        near.iter().any(|(foot, distance)| foot.distance(point) <= *distance)
    })
}

/// Returns the luminance of a pixel; `None` where it is not valid.
fn light_at(
    pixels: &PhotoPixels,
    [x, y]: [u32; 2],
    luminance: impl Fn(DVec2, [f64; 3]) -> f64,
) -> Option<f64> {
    let [r, g, b, _] = pixels.rgba16(x, y);
    let light = [r, g, b].map(|sample| f64::from(LINEAR_FROM_BYTE[usize::from(sample >> 8)]));
    let centre = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
    pixels.is_valid(x, y).then(|| luminance(centre, light))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_that_faces_the_sun_has_the_luminance_from_which_the_light_is() {
        for height in [0.2, 0.76, 1.0] {
            let LightStrength { sun, sky, ground } = of_surface(0.3, height);
            let [sun, sky, ground] = [sun, sky, ground].map(DVec3::from_array);
            let around = 0.5 * (1.0 + height) * sky + 0.5 * (1.0 - height) * ground;
            assert!((REFLECTED * luminance(sun + around) - 0.3).abs() < 1e-12);
            assert!(sun.x == sun.z && sky.z > sky.x, "the sun is white, and the sky is blue");
        }
    }
}
